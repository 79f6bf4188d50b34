"""Finds and outlines stars and galaxies in astronomical images with level-set methods.

    import skyfront

    image, truth = skyfront.simulate("noisy", seed=1)
    seg = skyfront.segment(image)
    seg.labels       # the segmentation map, 0 = background
    seg.catalogue    # one row per source
"""

from ._api import measure, paper, score, segment, simulate
from ._engine import OptionError, __version__
from ._result import Flag, Outline, Segmentation, SkyfrontWarning
from ._settings import columns, parameters

__all__ = [
    "Flag",
    "OptionError",
    "Outline",
    "Segmentation",
    "SkyfrontWarning",
    "__version__",
    "columns",
    "measure",
    "paper",
    "parameters",
    "score",
    "segment",
    "simulate",
]
