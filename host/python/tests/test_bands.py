"""Several images of one field: found together, with the bytes of the command line."""

import numpy as np
import pytest
from astropy.io import fits
from astropy.wcs import WCS
from conftest import same

import skyfront

SHAPE = (128, 112)


def blob(x, y):
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return 12 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * 2.5**2))


@pytest.fixture(scope="module")
def bands():
    """Two images: a source in each that the other does not show."""
    draw = np.random.default_rng(11)
    noise = draw.normal(size=(2, *SHAPE))
    blue, red = 500 + 3 * (noise[0] + blob(30, 40)), 20 + 3 * (noise[1] + blob(80, 36))
    return [blue.astype(">f4"), red.astype(np.float32)]


@pytest.mark.parametrize("settings", [{}, {"combine": "chi2"}, {"combine": "vector", "preset": "chan-vese"}])
def test_bands_have_the_bytes_of_the_command_line(bands, settings, command, tmp_path):
    blue, red = bands
    fits.PrimaryHDU(red).writeto(tmp_path / "red.fits")
    seg = skyfront.segment(blue, bands=[red], **settings)
    options = [word for name, value in settings.items() for word in (f"--{name}", value)]
    same(seg, command(blue, "--with", tmp_path / "red.fits", *options))
    assert seg.labels[40, 30] > 0 and seg.labels[36, 80] > 0
    assert seg.summary["input"]["combine"] == settings.get("combine", "weighted")
    for alone, shown, hidden in [(blue, (40, 30), (36, 80)), (red, (36, 80), (40, 30))]:
        found = skyfront.segment(alone, **{name: value for name, value in settings.items() if name != "combine"}).labels
        assert found[shown] > 0 and found[hidden] == 0


def test_what_a_band_lacks_is_in_no_source(bands):
    blue, red = bands
    hole = np.zeros(SHAPE, bool)
    hole[34:39, 78:83] = True
    for settings in [{}, {"combine": "vector", "preset": "chan-vese"}]:
        for lacking in (np.ma.array(red, mask=hole), np.where(hole, np.nan, red)):
            seg = skyfront.segment(blue, bands=[lacking], **settings)
            assert not seg.labels[hole].any() and seg.labels[40, 30] > 0


def test_bands_that_do_not_fit_are_refused(bands):
    blue, red = bands
    assert "m2_flux" in skyfront.segment(blue, bands=[red]).catalogue.colnames
    wcs = WCS(naxis=2)
    wcs.wcs.ctype, wcs.wcs.crval = ["RA---TAN", "DEC--TAN"], [150, 2]
    wcs.wcs.cdelt, wcs.wcs.crpix = [-1e-4, 1e-4], [60, 60]
    moved = wcs.to_header()
    moved["CRPIX1"] += 3
    there = fits.PrimaryHDU(red, moved)
    for settings, option, reason in [
        ({"bands": [red[:100]]}, "bands", "bands[0]: its shape is (100, 112), that of the image (128, 112)"),
        ({"bands": [red, np.ma.array(red)[:, :90]]}, "bands", "bands[1]: its shape is (128, 90)"),
        ({"bands": [there], "wcs": wcs}, "bands", "3.0 away"),
        ({"combine": "chi2"}, "combine", "it needs bands"),
        ({"bands": [red], "combine": "sum"}, "combine", "none of weighted, chi2, vector"),
        ({"bands": [red], "combine": "vector"}, "combine", "needs scheme chan-vese"),
        ({"bands": [red], "noise": 3.0}, "bands", "noise and weight do not go with them"),
        ({"bands": 8 * [red], "combine": "vector", "preset": "chan-vese"}, "bands", "9 must be at most 8"),
    ]:
        with pytest.raises(skyfront.OptionError) as refused:
            skyfront.segment(blue, **settings)
        assert refused.value.option == option and reason in str(refused.value), refused.value
