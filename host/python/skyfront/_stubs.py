"""Writes the type stubs from the functions' own signatures: `python -m skyfront._stubs > skyfront/__init__.pyi`."""

import inspect

from . import _api
from ._settings import OWN, PARAMETERS

HEAD = '''\
# Made by `python -m skyfront._stubs`; the table of parameters is its source.
import enum
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
'''

TAIL = '''\
def score(truth: ArrayLike, labels: ArrayLike, image: Any) -> dict[str, float]: ...
def simulate(
    kind: str = "bright",
    *,
    seed: int = 1,
    shape: tuple[int, int] = (300, 300),
    optics: str = "round",
    lopsided: bool = False,
    gradient: float = 0.0,
    full_well: float | None = None,
    step: float | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.int32]]: ...
def columns() -> list[tuple[str, str, str, bool]]: ...
def parameters() -> dict[str, dict[str, Any]]: ...

class OptionError(ValueError):
    option: str

class SkyfrontWarning(UserWarning): ...

class Outline:
    label: int
    hole: bool
    points: NDArray[np.float64]

class Segmentation:
    labels: NDArray[np.int32]
    front: NDArray[np.float32]
    background: NDArray[np.float32] | None
    noise: NDArray[np.float32] | None
    stages: dict[str, NDArray[np.float32]]
    convergence: NDArray[np.float32]
    summary: dict[str, Any]
    warnings: list[str]
    @property
    def catalogue(self) -> Any: ...
    @property
    def outlines(self) -> list[Outline]: ...
    def regions(self, sky: bool = False) -> Any: ...
    def picture(self) -> bytes: ...
    def __len__(self) -> int: ...
'''

TYPES = {
    "mask": "ArrayLike | None", "weight": "ArrayLike | None", "weight_type": "str | None",
    "background": "Any", "noise": "Any", "wcs": "Any", "preset": "str", "arithmetic": "str",
    "gain": "float | None", "saturation": "float | None", "zero_point": "float | None",
    "apertures": "Sequence[float] | float", "neighbours": "str", "columns": "Sequence[str] | str",
    "bands": "Sequence[Any]", "combine": "str | None", "threads": "int | None", "image": "Any", "labels": "ArrayLike",
}  # fmt: skip


def of_setting(parameter):
    """The type of a setting's values."""
    types = {"": [], "int": ["int"], "float": ["float"], "pair": ["tuple[float, float]"]}[parameter["numbers"]]
    # Words may have numbers, as "noise:3", and some stand for whole numbers.
    words = ["str"] if parameter["words"] else []
    numeric = any(word.isdigit() for word, _ in parameter["words"])
    mapped = ["NDArray[Any]"] if parameter["name"] == "start" else []
    return " | ".join(types + (["int"] if numeric else []) + words + mapped + ["None"])


def function(name, result):
    """The stub of a function."""
    lines, starred = [f"def {name}("], False
    for parameter in inspect.signature(getattr(_api, name)).parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not starred:
            lines.append("    *,")
            starred = True
        kind = TYPES.get(parameter.name) or of_setting(PARAMETERS[parameter.name])
        default = "" if parameter.default is parameter.empty else f" = {parameter.default!r}".replace("'", '"')
        lines.append(f"    {parameter.name}: {kind}{default},")
    return "\n".join(lines + [f") -> {result}: ..."])


def flags():
    """The stub of the flags."""
    from ._result import Flag

    return "\n".join(["class Flag(enum.IntFlag):"] + [f"    {flag.name} = {flag.value}" for flag in Flag])


def stubs():
    """The whole file."""
    assert not {name for name, *_ in OWN} & set(PARAMETERS), "a setting has the name of a keyword"
    functions = [("segment", "Segmentation"), ("paper", "Segmentation"), ("measure", "Any")]
    return "\n".join([HEAD, *(function(*one) for one in functions), TAIL, flags(), ""])


if __name__ == "__main__":
    print(stubs(), end="")
