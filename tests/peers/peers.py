"""The peers that need no Python package of their own, as tests/peers/quality and tests/peers/picture run them."""

import json
import subprocess

import numpy as np
from astropy.io import fits

# source-extractor's own default filter, 3 x 3 for a seeing of 2 pixels.
FILTER = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]], np.float32)


def skyfront(folder, program):
    words = [program, "segment", folder / "sky.fits", "--out", folder / "skyfront", "--no-pictures", "--quiet"]
    subprocess.run(words, check=True)
    return fits.getdata(folder / "skyfront" / "segmentation.fits")


def source_extractor(folder, _):
    """Its default settings: what `source-extractor -dd` prints."""
    (folder / "none.param").write_text("NUMBER\n")
    matrix = "\n".join(" ".join(str(int(value)) for value in row) for row in FILTER)
    (folder / "default.conv").write_text(f"CONV NORM\n{matrix}\n")
    defaults = subprocess.run(["source-extractor", "-dd"], capture_output=True, check=True, text=True).stdout
    (folder / "default.sex").write_text(defaults)
    words = ["source-extractor", "sky.fits", "-c", "default.sex", "-PARAMETERS_NAME", "none.param", "-FILTER_NAME"]
    words += ["default.conv", "-CHECKIMAGE_TYPE", "SEGMENTATION", "-CHECKIMAGE_NAME", "sextractor.fits"]
    subprocess.run(words + ["-VERBOSE_TYPE", "QUIET"], cwd=folder, check=True)
    return fits.getdata(folder / "sextractor.fits")


def score(folder, labels, program):
    path = folder / "labels.fits"
    fits.writeto(path, labels.astype(np.int32), overwrite=True)
    words = [program, "score", folder / "truth.fits", path, "--image", folder / "sky.fits"]
    return json.loads(subprocess.run(words, capture_output=True, check=True).stdout)
