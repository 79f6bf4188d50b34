"""Scores Skyfront and its peers on simulated skies; see tests/peers/quality."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import sep
from astropy.convolution import convolve
from astropy.io import fits
from astropy.stats import SigmaClip
from photutils.background import Background2D, SExtractorBackground
from photutils.segmentation import deblend_sources, detect_sources, make_2dgaussian_kernel

import injected
from peers import score, skyfront, source_extractor

# Skies, with the options that make them.
SKIES = {
    "bright": "--kind bright",
    "noisy": "--kind noisy",
    "stars": "--kind stars",
    "stars with coma": "--kind stars --optics coma",
    "stars, trailed": "--kind stars --optics trail",
    "stars out of focus": "--kind stars --optics ring",
    "stars with full wells": "--kind stars --full-well 150",
    "lopsided galaxies": "--kind bright --lopsided",
    "a gradient, whole counts": "--kind noisy --gradient 10 --step 1",
}
MEASURES = ["combined", "f_score", "completeness", "purity", "mean_iou", "pq"]
THRESHOLD, PIXELS, CELL = 1.5, 5, 64


def extract(folder, _):
    """SEP with its own defaults and the threshold of source-extractor."""
    pixels = fits.getdata(folder / "sky.fits").astype(np.float32)
    sky = sep.Background(pixels, bw=CELL, bh=CELL)
    found = sep.extract(pixels - sky.back(), THRESHOLD, err=sky.rms(), minarea=PIXELS, segmentation_map=True)
    return found[1]


def photutils(folder, _):
    """The steps of its user guide, with the threshold of source-extractor."""
    pixels = fits.getdata(folder / "sky.fits").astype(float)
    sky = Background2D(pixels, CELL, filter_size=3, sigma_clip=SigmaClip(3.0), bkg_estimator=SExtractorBackground())
    above = pixels - sky.background
    smooth = convolve(above, make_2dgaussian_kernel(3.0, size=5))
    labels = detect_sources(smooth, THRESHOLD * sky.background_rms, PIXELS)
    if labels is None:
        return np.zeros(pixels.shape, int)
    return deblend_sources(smooth, labels, PIXELS, n_levels=32, contrast=0.001, progress_bar=False).data


TOOLS = {"Skyfront": skyfront, "source-extractor": source_extractor, "SEP": extract, "photutils": photutils}


def main(seeds, side, program):
    results = {(kind, tool): [] for kind in SKIES for tool in TOOLS}
    for kind, options in SKIES.items():
        for seed in range(1, seeds + 1):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                words = [program, "simulate", *options.split(), "--seed", str(seed), "--side", str(side)]
                subprocess.run(words + ["--out", folder], check=True)
                for tool, run in TOOLS.items():
                    results[kind, tool].append(score(folder, run(folder, program), program))
    print(f"Means over {seeds} seeds of {side} x {side} pixels, every tool at its default\n")
    print("| sky | tool | " + " | ".join(MEASURES) + " |")
    print("|---" * (len(MEASURES) + 2) + "|")
    for (kind, tool), scores in results.items():
        means = [f"{np.mean([score[measure] for score in scores]):.3f}" for measure in MEASURES]
        print(f"| {kind} | {tool} | " + " | ".join(means) + " |")
    injected.table(seeds, program)


main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3])
