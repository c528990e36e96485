# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypedDict

# Any object with the buffer protocol that holds 32 bit floats.
Pixels: TypeAlias = Any

class Error(Exception):
    field: str
    message: str

class ParameterError(Error, ValueError): ...
class DepthError(Error, ValueError): ...
class PixelError(Error, ValueError): ...
class CancelledError(Error, RuntimeError): ...

class Scores(TypedDict):
    psnr: float
    ssim: float
    rmse: float
    energy_ratio: float | None
    max_error: float
    max_error_pixel: tuple[int, int]
    identical: bool
    tpsnr: float

class Lens:
    focus_distance: float
    lens_radius: float
    focal_length_px: float
    px_per_unit: float
    max_radius_px: float
    coc_limit_px: float
    bias_px: float
    scale: float
    def __new__(
        cls, width: int, height: int, /, **params: float | str | bool
    ) -> Lens: ...
    def radius_px(self, z: float, /) -> float: ...
    def depth_at(self, radius_px: float, /) -> float: ...
    def depth_of_field(self) -> tuple[float, float]: ...
    def hyperfocal(self) -> float: ...

class Filter:
    @property
    def lens(self) -> Lens: ...
    @property
    def threads(self) -> int: ...
    def __new__(
        cls,
        width: int,
        height: int,
        /,
        *,
        threads: int = 0,
        distribution_image: Pixels = ...,
        **params: float | str | bool,
    ) -> Filter: ...
    def process(
        self,
        colour: Pixels,
        depth: Pixels,
        out: Pixels,
        progress: Callable[[float], bool | None] | None = None,
    ) -> None: ...
    def process_views(
        self,
        views: Sequence[tuple[Pixels, Pixels, tuple[float, float], float]],
        out: Pixels,
        progress: Callable[[float], bool | None] | None = None,
    ) -> None: ...
    def coc(self, depth: Pixels, out: Pixels) -> None: ...
    def planar_depth(self, depth: Pixels, out: Pixels) -> None: ...

class Accumulator:
    @property
    def count(self) -> int: ...
    def __new__(
        cls,
        width: int,
        height: int,
        channels: int,
        /,
        *,
        threads: int = 0,
        **params: float | str | bool,
    ) -> Accumulator: ...
    def add(self, colour: Pixels, /) -> None: ...
    def mean(self, out: Pixels, /) -> None: ...

def lens_points(
    n: int, /, *, frame: int = 0, **params: float | str | bool
) -> tuple[tuple[float, float, float], ...]: ...
def version() -> str: ...
def cpu_level() -> str: ...
def compare(a: Pixels, b: Pixels) -> Scores: ...
def parameters() -> tuple[tuple[Any, ...], ...]: ...
def methods() -> tuple[tuple[str, str, str, str], ...]: ...
