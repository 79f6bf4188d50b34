# Made by `python -m skyfront._stubs`; the table of parameters is its source.
import enum
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

def segment(
    image: Any,
    *,
    mask: ArrayLike | None = None,
    weight: ArrayLike | None = None,
    weight_type: str | None = None,
    background: Any = None,
    noise: Any = None,
    wcs: Any = None,
    bands: Sequence[Any] = (),
    combine: str | None = None,
    preset: str = "noise-aware",
    arithmetic: str = "f32",
    gain: float | None = None,
    saturation: float | None = None,
    zero_point: float | None = None,
    apertures: Sequence[float] | float = (),
    neighbours: str = "correct",
    columns: Sequence[str] | str = (),
    threads: int | None = None,
    sky: str | None = None,
    threshold: float | None = None,
    spike_height: float | None = None,
    dx: float | None = None,
    normalize: str | None = None,
    range: tuple[float, float] | None = None,
    rescale: str | None = None,
    alpha: float | None = None,
    beta: int | None = None,
    tau: float | str | None = None,
    filter: str | None = None,
    filter_steps: int | None = None,
    filter_dt: float | None = None,
    pm: str | None = None,
    pm_mu: float | None = None,
    order: str | None = None,
    edge: str | None = None,
    p: float | None = None,
    c2: float | None = None,
    scheme: str | None = None,
    outline_steps: int | None = None,
    outline_curvature: float | None = None,
    nu: float | None = None,
    curvature_form: str | None = None,
    degenerate: float | None = None,
    degenerate_power: int | None = None,
    directions: int | str | None = None,
    mu: float | None = None,
    lambda1: float | None = None,
    lambda2: float | None = None,
    start: str | NDArray[Any] | None = None,
    margin: float | None = None,
    motion: str | None = None,
    dt: float | None = None,
    t_max: float | None = None,
    band: float | str | None = None,
    eps_front: float | None = None,
    eps: float | None = None,
    stop: str | None = None,
    separate: str | None = None,
    connectivity: int | str | None = None,
    deblend_contrast: float | None = None,
    deblend_light: float | None = None,
    deblend_sharpening: float | None = None,
    deblend_excess: float | None = None,
    deblend_area: int | None = None,
    deblend_knots: int | None = None,
    select: str | None = None,
    false_sources: float | None = None,
    false_share: float | None = None,
    min_peak: float | None = None,
    min_light: float | None = None,
    min_area: int | None = None,
) -> Segmentation: ...
def paper(
    image: Any,
    *,
    mask: ArrayLike | None = None,
    weight: ArrayLike | None = None,
    weight_type: str | None = None,
    background: Any = None,
    noise: Any = None,
    wcs: Any = None,
    bands: Sequence[Any] = (),
    combine: str | None = None,
    preset: str = "paper-f160",
    arithmetic: str = "f32",
    gain: float | None = None,
    saturation: float | None = None,
    zero_point: float | None = None,
    apertures: Sequence[float] | float = (),
    neighbours: str = "correct",
    columns: Sequence[str] | str = (),
    threads: int | None = None,
    sky: str | None = None,
    threshold: float | None = None,
    spike_height: float | None = None,
    dx: float | None = None,
    normalize: str | None = None,
    range: tuple[float, float] | None = None,
    rescale: str | None = None,
    alpha: float | None = None,
    beta: int | None = None,
    tau: float | str | None = None,
    filter: str | None = None,
    filter_steps: int | None = None,
    filter_dt: float | None = None,
    pm: str | None = None,
    pm_mu: float | None = None,
    order: str | None = None,
    edge: str | None = None,
    p: float | None = None,
    c2: float | None = None,
    scheme: str | None = None,
    outline_steps: int | None = None,
    outline_curvature: float | None = None,
    nu: float | None = None,
    curvature_form: str | None = None,
    degenerate: float | None = None,
    degenerate_power: int | None = None,
    directions: int | str | None = None,
    mu: float | None = None,
    lambda1: float | None = None,
    lambda2: float | None = None,
    start: str | NDArray[Any] | None = None,
    margin: float | None = None,
    motion: str | None = None,
    dt: float | None = None,
    t_max: float | None = None,
    band: float | str | None = None,
    eps_front: float | None = None,
    eps: float | None = None,
    stop: str | None = None,
    separate: str | None = None,
    connectivity: int | str | None = None,
    deblend_contrast: float | None = None,
    deblend_light: float | None = None,
    deblend_sharpening: float | None = None,
    deblend_excess: float | None = None,
    deblend_area: int | None = None,
    deblend_knots: int | None = None,
    select: str | None = None,
    false_sources: float | None = None,
    false_share: float | None = None,
    min_peak: float | None = None,
    min_light: float | None = None,
    min_area: int | None = None,
) -> Segmentation: ...
def measure(
    image: Any,
    labels: ArrayLike,
    *,
    mask: ArrayLike | None = None,
    weight: ArrayLike | None = None,
    weight_type: str | None = None,
    background: Any = None,
    noise: Any = None,
    wcs: Any = None,
    gain: float | None = None,
    saturation: float | None = None,
    zero_point: float | None = None,
    apertures: Sequence[float] | float = (),
    neighbours: str = "correct",
    columns: Sequence[str] | str = (),
    threads: int | None = None,
) -> Any: ...
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

class Flag(enum.IntFlag):
    TRUNCATED = 1
    SATURATED = 2
    MASKED = 4
    BLENDED = 8
    LIMIT = 16
    NO_ROOM = 32
    NO_FLUX = 64
    APERTURE = 128
    NEIGHBOUR = 256
    NO_COORDINATES = 512
    PLATEAU = 1024
