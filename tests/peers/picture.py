"""Draws the demo's sky with the outlines of Skyfront and of source-extractor; see tests/peers/picture."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from astropy.io import fits
from PIL import Image, ImageDraw, ImageFont

from peers import score, skyfront, source_extractor

# The demo's seed and kind.
SKY = ["--kind", "bright", "--seed", "160", "--side", "300"]
ZOOM, GAP, LINE = 2, 8, 28
GREYS, OUTLINE, WHITE = 62, 62, 63


def greys(pixels):
    """An asinh stretch in a few greys, the last row on top."""
    median, low, high = np.percentile(pixels, [50, 16, 99.9])
    black, scale = median - 1.5 * (median - low), 3 * (median - low)
    shade = np.arcsinh((pixels - black) / scale) / np.arcsinh((high - black) / scale)
    enlarged = np.kron(shade[::-1], np.ones((ZOOM, ZOOM)))
    return np.clip(enlarged * (GREYS - 1), 0, GREYS - 1).astype(np.uint8)


def outlined(panel, labels):
    labels = np.kron(labels[::-1], np.ones((ZOOM, ZOOM), int))
    edge = np.zeros(labels.shape, bool)
    edge[:, :-1] |= labels[:, :-1] != labels[:, 1:]
    edge[:-1] |= labels[:-1] != labels[1:]
    return np.where(edge, OUTLINE, panel).astype(np.uint8)


def main(program, path):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([program, "simulate", *SKY, "--out", folder], check=True)
        panel = greys(fits.getdata(folder / "sky.fits"))
        panels = [("a simulated sky", panel)]
        for title, run in [("Skyfront", skyfront), ("source-extractor", source_extractor)]:
            labels = run(folder, program)
            found = score(folder, labels, program)
            caption = f"{title}: {found['tp']} of {found['n_truth']} found, {found['fp']} false"
            panels.append((caption, outlined(panel, labels)))
            print(caption)
    side = panel.shape[1]
    sheet = Image.new("P", (3 * side + 2 * GAP, panel.shape[0] + LINE))
    shades = [level * 255 // (GREYS - 1) for level in range(GREYS)]
    sheet.putpalette([value for shade in shades for value in [shade] * 3] + [255, 140, 0, 255, 255, 255])
    pen = ImageDraw.Draw(sheet)
    for index, (caption, panel) in enumerate(panels):
        left = index * (side + GAP)
        sheet.paste(Image.fromarray(panel, "P"), (left, LINE))
        pen.text((left, 3), caption, WHITE, font=ImageFont.load_default(18))
    sheet.save(path, optimize=True)


main(*sys.argv[1:])
