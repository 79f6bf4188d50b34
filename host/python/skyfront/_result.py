"""What a run gives."""

import base64
import enum
import html
import json
import re
import warnings
from dataclasses import dataclass, field

import numpy as np

from . import _engine
from ._input import sample, unit_of

Flag = enum.IntFlag("Flag", {name.upper().replace("-", "_"): bit for bit, name, _ in _engine.flags()})
Flag.__doc__ = "What a user of a source should know about it:\n\n" + "\n".join(
    f"- {name.upper().replace('-', '_')} ({bit}): {meaning}" for bit, name, meaning in _engine.flags()
)


class SkyfrontWarning(UserWarning):
    """What must be known of an image to judge what was found in it."""


@dataclass(frozen=True)
class Outline:
    """A closed outline, where the front's zero level runs."""

    label: int
    """The source."""
    hole: bool
    """Whether it bounds a hole in the source."""
    points: np.ndarray = field(repr=False)
    """Its corners (x, y), the first pixel's centre at (0, 0); counter-clockwise around a source."""


class Segmentation:
    """A segmented image.

    Attributes
    ----------
    labels : int32 array
        The source of every pixel, from 1; 0 = background.
    front : float32 array
        The final front, above 0 inside the outlines.
    background, noise : float32 array or None
        Sky and its standard deviation at every pixel, as measured or given.
    stages : dict of float32 arrays
        Planes after each step, where they were asked for.
    convergence : float32 array
        The norm of every step's change, where a front ran until it stopped.
    summary : dict
        Version, parameters, what was found; as the command line's summary.json. `engine_seconds` is the time of the
        run itself, without what is done for Python.
    warnings : list of str
        What must be known of the image to judge the sources.
    """

    def __init__(self, image, found):
        self._image = image
        self._labels = found["labels"]
        self.labels = self._labels.view(np.int32)
        self.front = found["front"]
        self.background = found["background"]
        self.noise = found["noise"]
        # The catalogue is measured on them when it is asked for; changed labels it would notice.
        for plane in (self.front, self.background, self.noise):
            if plane is not None:
                plane.flags.writeable = False
        self.stages = found.get("stages", {})
        self.convergence = found["convergence"]
        self.warnings = told(map(in_python, found["warnings"]))
        self.summary = summarised(json.loads(found["summary"]), image, self.warnings)
        self._sources = found["sources"]
        self._neighbours = found["connectivity"]
        self._table = self._outlines = None

    @property
    def catalogue(self):
        """One row per source: an astropy QTable where astropy is installed, else a structured array.

        It is measured when it is first asked for. Positions count from 1, as in FITS; all columns are
        described by `skyfront.columns()`."""
        if self._table is None:
            sky = [None if plane is None else (plane, False) for plane in (self.background, self.noise)]
            columns, settings, notes = self._sources.measure(self._labels, *sky)
            told(map(in_python, notes))
            self.summary["measuring"] = json.loads(settings)
            self._table, self._sources = table(columns, self.summary), None
        return self._table

    @property
    def outlines(self):
        """The outlines of all sources, by label."""
        if self._outlines is None:
            rings = _engine.outlines(self._labels, self.front, self._neighbours)
            self._outlines = [Outline(*ring) for ring in rings]
        return self._outlines

    def regions(self, sky=False):
        """The outlines as polygons of the package `regions`; on the sky if the image has a WCS."""
        from regions import PixCoord, PolygonPixelRegion, Regions

        def polygon(outline):
            x, y = outline.points.T
            meta = {"text": str(outline.label), "include": not outline.hole}
            return PolygonPixelRegion(PixCoord(x, y), meta=meta)

        polygons = [polygon(outline) for outline in self.outlines]
        if sky:
            wcs = self._image.wcs
            if not hasattr(wcs, "pixel_to_world"):
                from astropy.wcs import WCS

                wcs = WCS(wcs)
            polygons = [polygon.to_sky(wcs) for polygon in polygons]
        return Regions(polygons)

    def picture(self):
        """The image with the outlines of its sources, numbered where few, as the bytes of a PNG."""
        return _engine.picture(sample(self._image.pixels), self._labels)

    def __len__(self):
        """The number of sources."""
        return self.summary["n_sources"]

    def __repr__(self):
        height, width = self.labels.shape
        return f"<Segmentation of {width} x {height} pixels: {len(self)} sources>"

    def _repr_html_(self):
        picture = base64.b64encode(self.picture()).decode()
        notes = "".join(f"<br>{html.escape(text)}" for text in self.warnings)
        return (
            f"<figure><figcaption>{html.escape(repr(self)[1:-1])}{notes}</figcaption>"
            f'<img style="max-width:100%" alt="outlines over the image" src="data:image/png;base64,{picture}"></figure>'
        )


def told(notes):
    """Warns of what must be known; gives it back as a list."""
    notes = list(notes)
    for text in notes:
        warnings.warn(text, SkyfrontWarning, stacklevel=4)
    return notes


def in_python(text):
    """A message with options as keywords."""
    return re.sub(r"--([a-z][a-z-]*)", lambda found: found[1].replace("-", "_"), text)


def summarised(summary, image, notes):
    """The command line's summary of an array: there is no file."""
    height, width = image.pixels.shape
    combine = summary["input"]["beside"].get("combine")
    summary["input"] = {"dtype": image.pixels.dtype.name, "unit": None if image.unit is None else str(image.unit)}
    if combine is not None:
        summary["input"]["combine"] = combine["file"]
    summary["result_warnings"] = notes
    return summary


def table(columns, summary):
    """Columns as a QTable where astropy is installed, else as a structured array."""
    try:
        from astropy import units
        from astropy.table import Column, QTable
    except ImportError:
        array = np.empty(len(columns[0][3]), [(name, values.dtype) for name, _, _, values in columns])
        for name, _, _, values in columns:
            array[name] = values
        return array
    made = QTable(meta={"skyfront": summary})
    for name, unit, description, values in columns:
        # A quantity would turn numbers of pixels into reals.
        if unit and values.dtype.kind == "f":
            made[name] = units.Quantity(values, unit_of(unit), copy=False)
        else:
            made[name] = Column(values, copy=False)
        made[name].info.description = description
    return made
