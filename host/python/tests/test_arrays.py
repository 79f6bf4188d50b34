"""Arrays of every kind give the bytes that the command line gives for the same numbers in a FITS file."""

import warnings

import numpy as np
import pytest
from astropy import units
from astropy.io import fits
from astropy.nddata import CCDData, InverseVariance, NDData, StdDevUncertainty, VarianceUncertainty
from astropy.utils.masked import Masked

import skyfront
from conftest import same

TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"]


@pytest.mark.parametrize("kind", TYPES)
def test_every_type_and_byte_order(kind, sky, command):
    image = (sky[0] / (2 if kind == "i1" else 1)).clip(0, 127 if kind == "i1" else 255)
    image = image.astype(kind) if kind[0] == "f" else image.round().astype(kind)
    out = command(image)
    for order in "<>":
        same(skyfront.segment(image.astype(image.dtype.newbyteorder(order))), out)


def test_strides_order_and_alignment(sky, command):
    out = command(sky[0])
    wide = np.zeros((240, 300), np.float32)
    wide[::2, ::2] = sky[0]
    packed = np.zeros(sky[0].shape, np.dtype([("odd", "u1"), ("value", "f4")]))
    packed["value"] = sky[0]
    for image in [wide[::2, ::2], np.asfortranarray(sky[0]), sky[0][::-1][::-1], packed["value"], sky[0][None]]:
        same(skyfront.segment(image), out)


def test_other_numbers(sky):
    half, long = sky[0].astype(np.float16), sky[0].astype(np.longdouble)
    assert np.array_equal(skyfront.segment(half).labels, skyfront.segment(half.astype(np.float32)).labels)
    assert np.array_equal(skyfront.segment(long).labels, skyfront.segment(sky[0]).labels)
    assert np.array_equal(skyfront.segment(sky[0].tolist()).labels, skyfront.segment(sky[0].astype("f8")).labels)
    flags = sky[1] > 0
    assert np.array_equal(
        skyfront.paper(flags, min_area=2).labels, skyfront.paper(flags.astype("u1"), min_area=2).labels
    )


@pytest.fixture
def masked(sky, tmp_path):
    mask = np.zeros(sky[0].shape, bool)
    mask[20:40, 30:60] = True
    fits.PrimaryHDU(mask.astype("u1")).writeto(tmp_path / "mask.fits")
    return mask


def test_masks(sky, masked, command, tmp_path):
    out = command(sky[0], "--mask", tmp_path / "mask.fits")
    image = sky[0]
    holes = np.where(masked, np.nan, image)
    for given in [
        skyfront.segment(image, mask=masked),
        skyfront.segment(image, mask=masked.astype(np.int64) * 4),
        skyfront.segment(np.ma.array(image, mask=masked)),
        skyfront.segment(Masked(image, mask=masked)),
        skyfront.segment(CCDData(image, unit="adu", mask=masked)),
        skyfront.segment(holes),
    ]:
        assert (given.labels[masked] == 0).all()
        assert np.array_equal(given.labels, fits.getdata(out / "segmentation.fits"))
    left, right = masked.copy(), masked.copy()
    left[:, 45:], right[:, :45] = False, False
    both = skyfront.segment(np.ma.array(image, mask=left), mask=right)
    same(both, out)


def test_units_are_those_of_fits(sky, command):
    hdu = fits.PrimaryHDU(sky[0])
    hdu.header["BUNIT"] = "electron / s"
    out = command(hdu)
    quantity = skyfront.segment(sky[0] * units.electron / units.s)
    same(quantity, out)
    assert quantity.catalogue["flux"].unit == units.electron / units.s
    assert quantity.summary["input"]["unit"] == "electron / s"
    same(skyfront.segment(hdu), out)
    same(skyfront.segment(CCDData(sky[0], unit="electron / s")), out)


def test_headers_and_coordinates(sky, command, tmp_path):
    hdu = fits.PrimaryHDU(sky[0])
    header = {"CTYPE1": "RA---TAN", "CTYPE2": "DEC--TAN", "CRVAL1": 150.0, "CRVAL2": 2.0, "CRPIX1": 60.0,
              "CRPIX2": 50.0, "CDELT1": -1e-4, "CDELT2": 1e-4, "CUNIT1": "deg", "CUNIT2": "deg", "BUNIT": "adu",
              "GAIN": 2.5, "SATURATE": 130.0, "RADESYS": "ICRS"}  # fmt: skip
    hdu.header.update(header)
    out = command(hdu)
    same(skyfront.segment(hdu), out)
    same(skyfront.segment(sky[0] * units.adu, wcs=hdu.header), out)
    ccd = CCDData.read(tmp_path / "image.fits")
    by_ccd = skyfront.segment(ccd)
    assert {"ra", "dec"} <= set(by_ccd.catalogue.colnames) and by_ccd.summary["measuring"]["SFGAIN"] == 2.5
    by_wcs = skyfront.segment(sky[0], wcs=ccd.wcs).catalogue
    assert np.allclose(by_wcs["ra"].value, by_ccd.catalogue["ra"].value, rtol=0, atol=1e-9)
    with pytest.raises(skyfront.OptionError, match="wcs") as error:
        skyfront.segment(sky[0], wcs=3)
    assert error.value.option == "wcs"


def test_uncertainties_are_noise(sky):
    sigma = float(np.median(skyfront.segment(sky[0]).noise))
    noise = np.full(sky[0].shape, 1.25 * sigma, np.float32)
    expected = skyfront.segment(sky[0], noise=noise)
    assert not np.array_equal(expected.labels, skyfront.segment(sky[0]).labels)
    for uncertainty in [StdDevUncertainty(noise), VarianceUncertainty(noise**2), InverseVariance(noise**-2.0)]:
        image = NDData(sky[0], uncertainty=uncertainty)
        assert np.array_equal(skyfront.segment(image).labels, expected.labels), uncertainty
    # What is given goes before what came with the image.
    image = NDData(sky[0], uncertainty=StdDevUncertainty(2 * noise))
    assert np.array_equal(skyfront.segment(image, noise=noise).labels, expected.labels)
    with pytest.warns(UserWarning, match="uncertainty"):
        skyfront.segment(NDData(sky[0], uncertainty=noise))


def test_maps_as_on_the_command_line(sky, command, tmp_path):
    rows = np.linspace(95, 105, sky[0].shape[0], dtype=np.float32)[:, None] * np.ones_like(sky[0])
    weight = np.linspace(1, 4, sky[0].shape[1], dtype=np.float32)[None, :] * np.ones_like(sky[0])
    weight[5, 5] = 0
    for name, plane in [("b", rows), ("w", weight)]:
        fits.PrimaryHDU(plane).writeto(tmp_path / f"{name}.fits")
    for kind in ["rms", "variance", "weight"]:
        out = command(
            sky[0], "--background", tmp_path / "b.fits", "--weight", tmp_path / "w.fits", "--weight-type", kind
        )
        found = skyfront.segment(sky[0], background=rows, weight=weight, weight_type=kind)
        same(found, out)
        assert np.array_equal(found.background, rows)
    out = command(sky[0], "--background", "99", "--weight", "0.25", "--weight-type", "rms")
    same(skyfront.segment(sky[0], background=99, noise=0.25), out)
    same(skyfront.segment(sky[0], background=99, weight=0.25, weight_type="rms"), out)
    adu = skyfront.segment(sky[0] * units.adu, background=99 * units.adu, noise=0.00025 * (1000 * units.adu))
    assert np.array_equal(adu.labels, skyfront.segment(sky[0], background=99, noise=0.25).labels)


def test_measured_sky_is_that_of_the_command_line(sky, command):
    out = command(sky[0], "--sky-maps")
    found = skyfront.segment(sky[0])
    for name in ["background", "noise"]:
        assert getattr(found, name).tobytes() == fits.getdata(out / f"{name}.fits").astype("f4").tobytes()


def test_what_is_no_image(sky):
    for bad in [sky[0][0], np.zeros((2, 3, 4)), 3.0]:
        with pytest.raises(ValueError, match="two axes"):
            skyfront.segment(bad)
    for bad in [sky[0].astype(complex), np.array([["a"]]), np.array([[None]])]:
        with pytest.raises(TypeError, match="real numbers"):
            skyfront.segment(bad)
    with pytest.raises(ValueError, match="no pixels"):
        skyfront.segment(fits.PrimaryHDU())
    with pytest.warns(skyfront.SkyfrontWarning, match="no pixel is defined"):
        assert len(skyfront.segment(np.full((20, 20), np.nan))) == 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        skyfront.segment(sky[0])
