"""What the tests share: small skies of their own, and the command line to compare with."""

import os
import pathlib
import subprocess

import numpy as np
import pytest
from astropy.io import fits

import skyfront

ROOT = pathlib.Path(__file__).parents[3]


@pytest.fixture(scope="session")
def program():
    """The command line of the same version."""
    named = [os.environ["SKYFRONT"]] if "SKYFRONT" in os.environ else []
    built = [ROOT / "target" / profile / "skyfront" for profile in ("release", "debug")]
    for path in [*named, *built]:
        if pathlib.Path(path).is_file():
            return str(path)
    pytest.fail("no skyfront: build it (cargo build --release), or name it in SKYFRONT")


@pytest.fixture(scope="session")
def sky():
    """A noisy sky on a level of 100, and its truth."""
    image, truth = skyfront.simulate("noisy", seed=7, shape=(120, 150))
    return (100 + 20 * image).astype(np.float32), truth


@pytest.fixture
def command(program, tmp_path):
    """Segments a FITS file on the command line: its folder of results."""

    def run(image, *options):
        source, out = tmp_path / "image.fits", tmp_path / "out"
        hdu = image if isinstance(image, fits.PrimaryHDU) else fits.PrimaryHDU(image)
        hdu.writeto(source, overwrite=True)
        line = [program, "segment", source, "--out", out, "--quiet", "--overwrite", *options]
        done = subprocess.run(line, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return out

    return run


def same(segmentation, out):
    """Whether a result has the bytes of the command line's files."""
    plane = lambda name: fits.getdata(out / name).astype(np.float32)  # noqa: E731
    labels = fits.getdata(out / "segmentation.fits").astype(np.int32)
    assert segmentation.labels.tobytes() == labels.tobytes()
    assert segmentation.front.tobytes() == plane("front.fits").tobytes()
    table = fits.getdata(out / "catalog.fits")
    catalogue = segmentation.catalogue
    assert catalogue.colnames == list(table.names)
    for name in table.names:
        ours = np.asarray(getattr(catalogue[name], "value", catalogue[name]))
        assert ours.tobytes() == table[name].astype(table[name].dtype.newbyteorder("=")).tobytes(), name
