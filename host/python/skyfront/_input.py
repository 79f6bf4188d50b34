"""Images of all kinds as plain arrays: masked arrays, quantities, NDData, CCDData and HDUs.

What comes with an image counts as if it had been given: its mask, unit, noise, coordinates and
header. What is given to the call goes before it.
"""

import sys
import warnings
from collections.abc import Mapping

import numpy as np

from . import _engine

# Keywords that tell how a file holds its numbers: those of an array tell it themselves.
STRUCTURE = {"SIMPLE", "XTENSION", "BITPIX", "NAXIS", "NAXIS1", "NAXIS2", "EXTEND", "PCOUNT", "GCOUNT", "GROUPS",
             "BSCALE", "BZERO", "BLANK", "BUNIT", "CHECKSUM", "DATASUM", "END"}  # fmt: skip


def option_error(name, reason):
    """The exception for an option that cannot be had."""
    error = _engine.OptionError(f"{name}: {reason}")
    error.option = name
    return error


def _class(module, name):
    """A class of a package, where that is imported: only then can an image be one of its objects."""
    return getattr(sys.modules.get(module), name, ())


class Image:
    """An image with what came with it."""

    def __init__(self, image, *, mask=None, wcs=None, origin=(0, 0)):
        self.unit = self.noise = None
        self.masks = []
        self.cards = []
        pixels = self._unwrapped(image)
        self.pixels = plain("image", pixels)
        if wcs is not None:
            self.cards = [card for card in self.cards if not _is_celestial(card)] + cards(wcs)
        self.wcs = wcs if wcs is not None else getattr(image, "wcs", None)
        self.cards = [_moved(card, origin) for card in self.cards]
        if mask is not None:
            self.masks.append(mask)

    def _unwrapped(self, image):
        """The array inside, after what is around it has been noted."""
        if isinstance(image, _class("astropy.io.fits.hdu.base", "_BaseHDU")):
            self.cards = cards(image.header)
            self.unit = unit_of(image.header.get("BUNIT"))
            image = image.data
        if isinstance(image, _class("astropy.nddata", "NDDataBase")):
            self.unit = image.unit
            if isinstance(image.meta, Mapping) and hasattr(image.meta, "cards"):
                self.cards = cards(image.meta)
            if image.wcs is not None and not any(card.startswith("CTYPE1") for card in self.cards):
                self.cards += cards(image.wcs)
            if image.mask is not None:
                self.masks.append(image.mask)
            self.noise = _deviation(image)
            image = image.data
        if isinstance(image, _class("astropy.units", "Quantity")):
            self.unit = image.unit
            image = image.value
        if hasattr(image, "unmasked"):
            self.masks.append(image.mask)
            image = image.unmasked
        if isinstance(image, np.ma.MaskedArray):
            if image.mask is not np.ma.nomask:
                self.masks.append(image.mask)
            image = image.data
        if image is None:
            raise ValueError("the image has no pixels")
        return image

    def job(self):
        """What the engine must know of the image."""
        bitpix, zero = _as_fits(self.pixels.dtype)
        head = [f"BZERO   = {zero:>20}"]
        if self.unit is not None:
            head.append(f"BUNIT   = '{_fits_text(self.unit):8}'")
        return {
            "pixels": sample(self.pixels),
            "bitpix": bitpix,
            "cards": head + self.cards,
            "mask": self.mask(),
        }

    def mask(self):
        """All masks as one of booleans; none where no pixel is masked away."""
        together = None
        for mask in self.masks:
            mask = np.asarray(mask)
            mask = mask if mask.dtype == bool else mask != 0
            mask = _two_axes("mask", np.broadcast_to(mask, self.pixels.shape) if mask.ndim == 0 else mask)
            together = mask if together is None or together.shape != mask.shape else together | mask
        return together

    def map(self, name, values):
        """A map over the image in the image's unit, or one number for all of it."""
        if values is None:
            return None
        if isinstance(values, _class("astropy.units", "Quantity")):
            if self.unit is None:
                raise option_error(name, f"it is in {values.unit}, but the image has no unit")
            try:
                values = values.to_value(self.unit)
            except Exception as error:
                raise option_error(name, str(error)) from None
        if isinstance(values, np.ma.MaskedArray):
            values = values.filled(np.nan) if values.dtype.kind == "f" else values.astype(np.float32).filled(np.nan)
        values = np.asarray(values)
        if values.ndim == 0:
            values = np.broadcast_to(values, self.pixels.shape)
        return sample(plain(name, values))


def plain(name, values):
    """An array of two axes of real numbers."""
    values = np.asarray(values)
    if values.dtype.kind not in "buif":
        raise TypeError(f"{name}: real numbers are wanted, not {values.dtype}")
    return _two_axes(name, values)


def _two_axes(name, values):
    """Without axes of length 1 beyond the last two, as the command line takes them."""
    if values.ndim > 2:
        values = values.reshape([length for length in values.shape[:-2] if length > 1] + list(values.shape[-2:]))
    if values.ndim != 2:
        raise ValueError(f"{name}: two axes are wanted, rows and columns, not {values.ndim}")
    return values


def sample(values):
    """An array as the engine takes it, and whether its bytes are in the other order. No copy is made
    but of what has no type or alignment of its own there."""
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "b":
        values = values.view(np.uint8)
    elif kind == "f" and size not in (4, 8):
        values = values.astype(np.float32)
    swapped = not values.dtype.isnative
    if swapped:
        values = values.view(values.dtype.newbyteorder())
    if not values.flags.aligned:
        values = values.copy()
    return values, swapped


def _as_fits(dtype):
    """BITPIX and BZERO of a FITS file with such numbers: they tell where integers end."""
    if dtype.kind == "f":
        return (-64 if dtype.itemsize > 4 else -32), 0
    bits = 8 * dtype.itemsize
    signed = {"i": 1, "u": 0, "b": 0}[dtype.kind]
    if bits == 8:
        return 8, -128 if signed else 0
    return bits, 0 if signed else 1 << (bits - 1)


def cards(header):
    """The cards of a header or of coordinates, without those of the file's structure."""
    if hasattr(header, "to_header"):
        header = header.to_header(relax=True)
    if not hasattr(header, "cards"):
        raise option_error("wcs", f"{type(header).__name__} is neither a WCS that can be a FITS header, nor a header")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        images = [card.image for card in header.cards if card.keyword not in STRUCTURE]
    return [image[start : start + 80] for image in images for start in range(0, len(image), 80)]


def _moved(card, origin):
    """A card with the reference pixel of a part of the image that begins at this column and row."""
    for axis, by in zip("12", origin):
        if by and card.startswith(f"CRPIX{axis}") and "=" in card:
            value = float(card.split("=", 1)[1].split("/")[0]) - by
            return f"{card[:8]}= {value!r:>20}"
    return card


def _is_celestial(card):
    """Whether a card belongs to coordinates."""
    starts = ("CTYPE", "CUNIT", "CRVAL", "CRPIX", "CDELT", "CROTA", "CD1_", "CD2_", "PC1_", "PC2_", "PV1_", "PV2_",
              "WCSAXES", "RADESYS", "EQUINOX", "LONPOLE", "LATPOLE", "A_", "B_", "AP_", "BP_")  # fmt: skip
    return card.startswith(starts)


def unit_of(text):
    """The unit that a header spells; one that astropy does not know keeps its name."""
    if text is None:
        return None
    from astropy import units

    return units.Unit(text, parse_strict="silent")


def _fits_text(unit):
    """A unit as FITS spells it."""
    if isinstance(unit, str):
        return unit.replace("'", "''")
    try:
        return unit.to_string("fits")
    except Exception:
        return str(unit).replace("'", "''")


def _deviation(image):
    """The standard deviation of every pixel of an NDData, where it has an uncertainty of a known kind."""
    uncertainty = image.uncertainty
    if uncertainty is None:
        return None
    from astropy.nddata import StdDevUncertainty

    try:
        deviation = uncertainty.represent_as(StdDevUncertainty)
    except Exception:
        warnings.warn(f"an uncertainty of the kind {uncertainty.uncertainty_type!r} is not used", stacklevel=4)
        return None
    unit = deviation.unit
    return deviation.array * unit if unit is not None and image.unit is not None else deviation.array
