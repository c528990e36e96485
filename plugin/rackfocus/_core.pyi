# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypedDict, Unpack, final

from ._params import FilterParameters, Parameters

SURVEY_MARGIN: int

# What Filter.new_survey() gives: a capsule that nothing else reads.
_Survey: TypeAlias = Any
# (x, y, width, height), rackfocus.Window or a plain tuple.
_Area: TypeAlias = tuple[int, int, int, int]
# Any object with the buffer protocol that holds 32 bit floats.
_Pixels: TypeAlias = Any
_View = (
    tuple[_Pixels, _Pixels, tuple[float, float], float]
    | tuple[_Pixels, _Pixels, tuple[float, float], float, _Pixels | None]
)

class Error(Exception):
    field: str
    message: str

class ParameterError(Error, ValueError): ...
class DepthError(Error, ValueError): ...
class PixelError(Error, ValueError): ...
class CancelledError(Error, RuntimeError): ...
class UnreadParameterWarning(UserWarning): ...
class ViewsWarning(UserWarning):
    about: str

class _Scores(TypedDict):
    psnr: float
    ssim: float
    rmse: float
    energy_ratio: float | None
    max_error: float
    max_error_pixel: tuple[int, int]
    identical: bool
    tpsnr: float
    flip: float

@final
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
        cls, width: int, height: int, /, **params: Unpack[Parameters]
    ) -> Lens: ...
    def radius_px(self, z: float, /) -> float: ...
    def depth_at(self, radius_px: float, /) -> float: ...
    def depth_of_field(self) -> tuple[float, float]: ...
    def hyperfocal(self) -> float: ...

@final
class Context:
    @property
    def threads(self) -> int: ...
    @property
    def cpu(self) -> str: ...
    def __new__(
        cls,
        *,
        threads: int = 0,
        max_bytes: int = 0,
        cpu: str | None = None,
        log: Callable[[str, str], object] | None = None,
    ) -> Context: ...

@final
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
        context: Context | None = None,
        threads: int = 0,
        **params: Unpack[FilterParameters],
    ) -> Filter: ...
    def process(
        self,
        colour: _Pixels,
        depth: _Pixels,
        out: _Pixels,
        progress: Callable[[float], bool | None] | None = None,
        behind: tuple[_Pixels, _Pixels] | None = None,
        seen: Sequence[tuple[_Pixels, _Pixels]] | None = None,
        mean_depth: _Pixels | None = None,
    ) -> None: ...
    def mean_depth(
        self,
        rays: _Pixels,
        depth: _Pixels,
        out: _Pixels,
        lens_offset: tuple[float, float] = (0, 0),
        shear_distance: float = 0,
    ) -> bool: ...
    def seen_depth(
        self,
        colour: _Pixels,
        depth: _Pixels,
        lights: Sequence[tuple[_Pixels, tuple[float, float], float]],
        out: _Pixels,
    ) -> None: ...
    def seen_way(
        self,
        colour: _Pixels,
        depth: _Pixels,
        light: _Pixels,
        way: _Pixels,
        out: _Pixels,
    ) -> None: ...
    def process_views(
        self,
        views: Sequence[_View],
        out: _Pixels,
        progress: Callable[[float], bool | None] | None = None,
        seen: Sequence[Sequence[tuple[_Pixels, _Pixels]] | None] | None = None,
        check: bool = True,
    ) -> None: ...
    def denoise_views(
        self,
        views: Sequence[_View],
        outs: Sequence[_Pixels],
        guides: Sequence[tuple[_Pixels | None, _Pixels | None]] | None = None,
        progress: Callable[[float], bool | None] | None = None,
        *,
        library: str | None = None,
        quality: str = "high",
        threads: int = 0,
    ) -> float: ...
    def merge_denoised(
        self,
        views: Sequence[_View],
        clean: Sequence[_Pixels],
        out: _Pixels,
        progress: Callable[[float], bool | None] | None = None,
        check: bool = True,
    ) -> None: ...
    def process_deep(
        self,
        first: _Pixels,
        samples: _Pixels,
        out: _Pixels,
        progress: Callable[[float], bool | None] | None = None,
    ) -> None: ...
    def flatten(
        self, first: _Pixels, samples: _Pixels, colour: _Pixels, depth: _Pixels
    ) -> None: ...
    def new_survey(self) -> _Survey: ...
    def count(
        self,
        survey: _Survey,
        colour: _Pixels,
        depth: _Pixels,
        given: _Area,
        counted: _Area,
    ) -> None: ...
    def window(self, survey: _Survey, kept: _Area) -> tuple[int, int, int, int]: ...
    def process_window(
        self,
        survey: _Survey,
        colour: _Pixels,
        depth: _Pixels,
        given: _Area,
        kept: _Area,
        out: _Pixels,
        progress: Callable[[float], bool | None] | None = None,
    ) -> None: ...
    def coc(self, depth: _Pixels, out: _Pixels) -> None: ...
    def planar_depth(self, depth: _Pixels, out: _Pixels) -> None: ...

@final
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
        context: Context | None = None,
        threads: int = 0,
        **params: Unpack[Parameters],
    ) -> Accumulator: ...
    def add(self, colour: _Pixels, /) -> None: ...
    def mean(self, out: _Pixels, /) -> None: ...

def lens_points(
    n: int, /, *, frame: int = 0, **params: Unpack[Parameters]
) -> tuple[tuple[float, float, float], ...]: ...
def finish(
    own: _Pixels,
    ours: _Pixels,
    out: _Pixels,
    albedo: _Pixels | None = None,
    normal: _Pixels | None = None,
    half: _Pixels | None = None,
    error: _Pixels | None = None,
    *,
    library: str | None = None,
    quality: str = "high",
    threads: int = 0,
    white: float = 1.0,
    check: bool = True,
    samples: int = 0,
) -> None: ...
def version() -> str: ...
def cpu_level() -> str: ...
def compare(a: _Pixels, b: _Pixels) -> _Scores: ...
def fill_depth(
    depth: _Pixels,
    colour: _Pixels,
    *,
    infinity: float = 1e9,
    always: bool = False,
) -> tuple[int, float]: ...
def parameters() -> tuple[tuple[Any, ...], ...]: ...
def why_not_read(name: str, /, **params: float | str | bool) -> str: ...
def looks() -> list[tuple[str, str]]: ...
def methods() -> tuple[tuple[str, str, str, str], ...]: ...
