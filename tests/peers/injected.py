"""What tools make of stars and discs that were added to noise: depth at equal false positives, pairs that come apart,
sources that are seen again under other noise, and centres."""

import csv
import pathlib
import subprocess
import tempfile

import numpy as np
import sep
from astropy.convolution import convolve
from astropy.io import fits
from astropy.stats import SigmaClip
from photutils.background import Background2D, SExtractorBackground
from photutils.segmentation import SourceCatalog, deblend_sources, detect_sources, make_2dgaussian_kernel
from scipy.special import erf

from peers import FILTER

SIDE, SKY, NOISE, FWHM = 512, 1000.0, 10.0, 2.5
SIGMA = FWHM / 2.3548
# The scale of the discs, and the distance of what is added from each other, pixels.
DISC, APART = 4.0, 32
THRESHOLDS = np.arange(1.0, 3.01, 0.1)
MOST_FALSE = 2
MEASURES = ["stars", "discs", "pairs 1:1", "pairs 1:3", "again", "centre"]


def star(x, y):
    """Light of 1 in the pixels of a frame."""
    edges = np.arange(SIDE + 1) - 0.5
    along = lambda place: np.diff(erf((edges - place) / (np.sqrt(2) * SIGMA))) / 2  # noqa: E731
    return np.outer(along(y), along(x))


def disc(x, y):
    """The same of an exponential disc, smoothed by nothing."""
    rows, columns = np.mgrid[:SIDE, :SIDE]
    light = np.exp(-np.hypot(columns - x, rows - y) / DISC)
    return light / light.sum()


def grid(rng):
    """Places on a grid, up to half a pixel beside it."""
    middle = np.arange(APART // 2, SIDE, APART)
    return np.array([(x, y) for y in middle for x in middle]) + rng.uniform(-0.5, 0.5, (len(middle) ** 2, 2))


def noisy(rng, light):
    return (SKY + light + rng.normal(0, NOISE, light.shape)).astype(np.float32)


def flux(profile, ratio):
    """The light at which a profile has this signal-to-noise in a matched filter."""
    return ratio * NOISE / np.sqrt((profile**2).sum())


def skyfront(pixels, program, _):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        fits.writeto(folder / "sky.fits", pixels)
        words = [program, "segment", folder / "sky.fits", "--out", folder / "out", "--no-pictures", "--quiet"]
        subprocess.run([*words, "--map-only", "--columns", "xwin,ywin"], check=True)
        rows = csv.DictReader(line for line in open(folder / "out/catalog.csv") if line[0] != "#")
        return np.array([[float(row["xwin"]), float(row["ywin"])] for row in rows]).reshape(-1, 2)


def source_extractor(pixels, _, threshold):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        fits.writeto(folder / "sky.fits", pixels)
        (folder / "columns.param").write_text("XWIN_IMAGE\nYWIN_IMAGE\n")
        matrix = "\n".join(" ".join(str(int(value)) for value in row) for row in FILTER)
        (folder / "default.conv").write_text(f"CONV NORM\n{matrix}\n")
        defaults = subprocess.run(["source-extractor", "-dd"], capture_output=True, check=True, text=True).stdout
        (folder / "default.sex").write_text(defaults)
        words = ["source-extractor", "sky.fits", "-c", "default.sex", "-PARAMETERS_NAME", "columns.param"]
        words += ["-FILTER_NAME", "default.conv", "-DETECT_THRESH", str(threshold), "-ANALYSIS_THRESH", str(threshold)]
        subprocess.run(words + ["-CATALOG_NAME", "out.txt", "-VERBOSE_TYPE", "QUIET"], cwd=folder, check=True)
        lines = [line.split() for line in open(folder / "out.txt") if line[0] != "#"]
        return np.array(lines, float).reshape(-1, 2) - 1


def extract(pixels, _, threshold):
    sky = sep.Background(pixels)
    above = pixels - sky.back()
    found = sep.extract(above, threshold, err=sky.rms(), minarea=5)
    x, y, _ = sep.winpos(above, found["x"], found["y"], np.full(len(found), SIGMA))
    return np.column_stack([x, y])


def photutils(pixels, _, threshold):
    sky = Background2D(pixels, 64, filter_size=3, sigma_clip=SigmaClip(3.0), bkg_estimator=SExtractorBackground())
    above = pixels - sky.background
    smooth = convolve(above, make_2dgaussian_kernel(3.0, size=5))
    labels = detect_sources(smooth, threshold * sky.background_rms, 5)
    if labels is None:
        return np.zeros((0, 2))
    labels = deblend_sources(smooth, labels, 5, n_levels=32, contrast=0.001, progress_bar=False)
    catalogue = SourceCatalog(above, labels, convolved_data=smooth)
    return np.column_stack([catalogue.xcentroid_win, catalogue.ycentroid_win])


# Every tool with the thresholds that may be tried; Skyfront has a number of false sources for them.
TOOLS = {
    "Skyfront": (skyfront, [None]),
    "source-extractor": (source_extractor, THRESHOLDS),
    "SEP": (extract, THRESHOLDS),
    "photutils": (photutils, THRESHOLDS),
}


def nearest(places, found):
    """Of each place the distance to the nearest source."""
    if len(found) == 0:
        return np.full(len(places), np.inf)
    return np.hypot(*(places[:, None] - found[None]).transpose(2, 0, 1)).min(1)


def half_found(ratios, is_found):
    """The signal-to-noise that parts what is found from what is not with the fewest on the wrong side."""
    wrong = [(is_found & (ratios < cut)).sum() + (~is_found & (ratios >= cut)).sum() for cut in np.sort(ratios)]
    return np.sort(ratios)[int(np.argmin(wrong))]


def threshold_of(tool, thresholds, program, frames):
    """The lowest threshold at which noise has no more false sources than are allowed."""
    for threshold in thresholds:
        if sum(len(tool(frame, program, threshold)) for frame in frames) <= MOST_FALSE * len(frames):
            return threshold
    return thresholds[-1]


def measure(seed, program):
    """A row of `MEASURES` for each tool."""
    rng = np.random.default_rng(seed)
    places = grid(rng)
    ratios = {"stars": rng.uniform(2, 10, len(places)), "discs": rng.uniform(4, 24, len(places))}
    frames = {}
    for name, profile in [("stars", star), ("discs", disc)]:
        one = profile(SIDE / 2, SIDE / 2)
        light = sum(flux(one, ratio) * profile(*place) for place, ratio in zip(places, ratios[name]))
        frames[name] = noisy(rng, light)
    bright = rng.uniform(20, 50, len(places))
    light = sum(flux(star(256, 256), ratio) * star(*place) for place, ratio in zip(places, bright))
    again = [noisy(rng, light), noisy(rng, light)]
    turn = rng.uniform(0, np.pi, len(places))
    beside = places + 1.5 * FWHM * np.column_stack([np.cos(turn), np.sin(turn)])
    pairs = {}
    for name, share in [("pairs 1:1", 1.0), ("pairs 1:3", 1 / 3)]:
        whole = flux(star(256, 256), 100)
        pairs[name] = noisy(rng, sum(whole * (star(*a) + share * star(*b)) for a, b in zip(places, beside)))
    noise = [noisy(rng, np.zeros((SIDE, SIDE))) for _ in range(2)]

    rows = {}
    for tool, (run, thresholds) in TOOLS.items():
        threshold = threshold_of(run, thresholds, program, noise)
        find = lambda pixels: run(pixels, program, threshold)  # noqa: B023, E731
        row = {name: half_found(ratios[name], nearest(places, find(frames[name])) < 2) for name in ratios}
        for name, pixels in pairs.items():
            found = find(pixels)
            row[name] = np.mean((nearest(places, found) < 0.5 * FWHM) & (nearest(beside, found) < 0.5 * FWHM))
        first, second = map(find, again)
        row["again"] = np.mean(nearest(first, second) < 2) if len(first) else 0.0
        off = nearest(places, first)
        row["centre"] = np.sqrt(np.mean(off[off < 2] ** 2))
        rows[tool] = row
    return rows


def table(seeds, program):
    """Prints the means over so many seeds."""
    rows = [measure(seed, program) for seed in range(1, seeds + 1)]
    print(f"""
Stars (FWHM {FWHM} px) and discs (scale {DISC:.0f} px) added to white noise, means over {seeds} frames of {SIDE} x {SIDE}; every
tool at the lowest threshold with at most {MOST_FALSE} false sources per frame of noise, Skyfront at its default. Stars and
discs: signal-to-noise from which more are found than not; pairs: share that come apart at 1.5 FWHM, S/N 100; again: share
of sources of S/N 20 to 50 that other noise shows too; centre: their rms distance from the truth along both axes, pixels.
""")
    print("| tool | " + " | ".join(MEASURES) + " |")
    print("|---" * (len(MEASURES) + 1) + "|")
    for tool in TOOLS:
        print(f"| {tool} | " + " | ".join(f"{np.mean([row[tool][name] for row in rows]):.3f}" for name in MEASURES) + " |")
