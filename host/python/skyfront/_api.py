"""The functions of the package."""

import dataclasses
import json

import numpy as np

from . import _engine
from ._input import Image, option_error, plain, sample
from ._result import Segmentation
from ._settings import OWN, PARAMETERS, describe, describe_own, signature, texts

_DEFAULTS = {name: default for name, default, _, _ in OWN}
_ALL = tuple(_DEFAULTS)
_MEASURING = ("mask", "weight", "weight_type", "background", "noise", "wcs", "gain", "saturation", "zero_point",
              "apertures", "neighbours", "columns", "threads")  # fmt: skip


def _run(function, image, keywords, known, stages=False, labels=None, part=None, answers=()):
    """A run of the engine: the image as it was taken, and what was found."""
    own = {name: keywords.pop(name, _DEFAULTS[name]) for name in known}
    start = None
    if labels is None and not isinstance(keywords.get("start"), (str, type(None))):
        start = keywords.pop("start")
    settings = texts(function, keywords)
    image = Image(image, mask=own["mask"], wcs=own["wcs"], origin=(0, 0) if part is None else part["origin"])
    job = image.job()
    job.update(
        background=image.map("background", own["background"]),
        weight=_weight(image, own),
        start=None if start is None else sample(plain("start", start)),
        labels=None if labels is None else sample(plain("labels", labels)),
        bands=[Image(band).job() for band in own.get("bands", ())],
        combine=own.get("combine"),
        preset=own.get("preset", _DEFAULTS["preset"]),
        arithmetic=own.get("arithmetic", _DEFAULTS["arithmetic"]),
        settings=settings,
        gain=_number("gain", own["gain"]),
        saturation=_number("saturation", own["saturation"], signed=True),
        zero_point=_number("zero_point", own["zero_point"], signed=True),
        apertures=[_number("apertures", radius, most=1e4) for radius in np.atleast_1d(own["apertures"])],
        neighbours=own["neighbours"],
        columns=[own["columns"]] if isinstance(own["columns"], str) else list(own["columns"]),
        threads=own["threads"],
        stages=stages,
        part=part,
        answers=list(answers),
    )
    return image, _engine.segment(job)


def _weight(image, own):
    """The weight map and its type, of what is given or of what came with the image."""
    given = {name: own[name] for name in ("weight", "noise") if own[name] is not None}
    if len(given) == 2:
        raise option_error("noise", "it says the same as weight: only one of them can be given")
    if "weight" in given:
        if own["weight_type"] is None:
            raise option_error("weight_type", "weight needs it: rms, variance or weight")
        return image.map("weight", given["weight"]), own["weight_type"]
    if own["weight_type"] is not None:
        raise option_error("weight_type", "there is no weight")
    noise = image.map("noise", given.get("noise", image.noise))
    return None if noise is None else (noise, "noise")


def _number(name, value, signed=False, most=np.inf):
    """A finite number, or none."""
    if value is None:
        return None
    try:
        value = float(value)
    except (TypeError, ValueError):
        raise option_error(name, f"{value!r} is not a number") from None
    if not np.isfinite(value) or not (signed or value > 0) or value > most:
        bound = "finite" if signed else "above 0 and finite" if most == np.inf else f"above 0, at most {most:g}"
        raise option_error(name, f"{value} must be {bound}")
    return value


def segment(image, **keywords):
    return Segmentation(*_run("segment", image, keywords, _ALL))


def paper(image, **keywords):
    keywords.setdefault("preset", "paper-f160")
    return Segmentation(*_run("paper", image, keywords, _ALL, stages=True))


def measure(image, labels, **keywords):
    return Segmentation(*_run("measure", image, dict(keywords), _measuring(keywords), labels=labels)).catalogue


def _measuring(keywords):
    for name in keywords:
        if name not in _MEASURING:
            raise TypeError(f"measure() got an unexpected keyword argument {name!r}")
    return _MEASURING


def score(truth, labels, image):
    """Scores a label map against the truth, after Haigh et al. 2021 (doi:10.1051/0004-6361/201936561).

    Parameters
    ----------
    truth, labels : array
        Label maps, 0 = background.
    image : array
        The image, in which an object is represented by its brightest pixel.

    Returns
    -------
    dict
        The measures, among them `combined`, `completeness`, `purity`, `mean_iou` and `pq` (panoptic quality).
    """
    image = Image(image)
    flat = [np.ascontiguousarray(plain(name, map), np.int64) for name, map in (("truth", truth), ("labels", labels))]
    for name, map in zip(("truth", "labels"), flat):
        if map.shape != image.pixels.shape:
            raise option_error(name, f"its shape is {map.shape}, that of the image {image.pixels.shape}")
    return json.loads(_engine.score(flat[0].ravel(), flat[1].ravel(), sample(image.pixels)))


@dataclasses.dataclass
class _Seen:
    """What a telescope and a camera make of a sky."""

    optics: str
    lopsided: bool
    gradient: float
    full_well: float | None
    step: float | None


def simulate(
    kind="bright",
    *,
    seed=1,
    shape=(300, 300),
    optics="round",
    lopsided=False,
    gradient=0.0,
    full_well=None,
    step=None,
):
    """A simulated sky and its truth: which object owns which pixel.

    Parameters
    ----------
    kind : str
        `bright` (few bright stars and galaxies), `noisy` (stars and galaxies in strong noise) or `stars`.
    seed : int
        The same seed and shape give the same sky, on every machine.
    shape : (int, int)
        Rows and columns, 8 to 8192.
    optics : str
        What the telescope makes of a point: `round`, `coma` (a tail that grows with the distance from the middle),
        `trail` (a line) or `ring` (out of focus).
    lopsided : bool
        Galaxies brighter on one side than opposite.
    gradient : float
        How much brighter the sky is in the last column than in the first, in noise units.
    full_well : float, optional
        No pixel is brighter, in noise units; stars bleed along their columns.
    step : float, optional
        Distance of two values, in noise units: whole counts.

    Returns
    -------
    image : float32 array
    truth : int32 array
    """
    seen = _Seen(optics, lopsided, gradient, full_well, step)
    image, truth = _engine.simulate(kind, seed, tuple(shape), seen)
    return image, truth.view(np.int32)


segment.__doc__ = f"""Finds the sources of an image and outlines them.

Parameters
----------
image : array of two axes
    Rows and columns, of any real type, byte order and strides; also a masked array, Quantity, NDData,
    CCDData or FITS HDU, whose mask, unit, uncertainty, coordinates and header count as if they were given.
    Pixels that are not finite are undefined.

Other Parameters
----------------
{describe_own(_ALL)}

Settings; one that the chosen steps do not use is refused.
{describe("segment")}

Returns
-------
Segmentation

Raises
------
OptionError
    A keyword has a value that it cannot have; `option` has its name.
ValueError
    The image cannot be segmented.

The result has the same bits as the command line's for the same numbers in a FITS file. The
interpreter's lock is released. After Ctrl-C the call ends at once.
"""
segment.__signature__ = signature(["image"], _ALL)

paper.__doc__ = """Segments an image by the steps of Tozza and Falcone's paper, and keeps every step's plane.

`segment` with another default preset; `stages` of the result holds the planes `normalised`, `rescaled`,
`filtered` and `edge`, `front` the final front and `convergence` the norm of every step's change.
All keywords are those of `segment`.
"""
paper.__signature__ = signature(["image"], _ALL, preset="paper-f160")

measure.__doc__ = f"""Measures the sources of a label map.

Parameters
----------
image : array of two axes
    As for `segment`.
labels : array of the same shape
    The source of every pixel, 0 = background; gaps in the numbers are kept.

Other Parameters
----------------
{describe_own(_MEASURING)}

Returns
-------
QTable or structured array
    One row per label, as `Segmentation.catalogue`.
"""
measure.__signature__ = signature(["image", "labels"], _MEASURING, leave_out=tuple(PARAMETERS))
