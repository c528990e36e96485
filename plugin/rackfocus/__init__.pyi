# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, Unpack

from ._core import Accumulator as Accumulator
from ._core import CancelledError as CancelledError
from ._core import Context as Context
from ._core import DepthError as DepthError
from ._core import Error as Error
from ._core import Filter as Filter
from ._core import Lens as Lens
from ._core import ParameterError as ParameterError
from ._core import PixelError as PixelError
from ._core import _Pixels
from ._core import UnreadParameterWarning as UnreadParameterWarning
from ._core import ViewsWarning as ViewsWarning
from ._core import compare as compare
from ._core import cpu_level as cpu_level
from ._core import fill_depth as fill_depth
from ._core import version as version
from ._params import FilterParameters, Parameters

__all__ = [
    "SURVEY_MARGIN",
    "Accumulator",
    "CancelledError",
    "Choice",
    "Context",
    "DepthError",
    "Error",
    "Filter",
    "Lens",
    "LensPoint",
    "Look",
    "Method",
    "Parameter",
    "ParameterError",
    "PixelError",
    "UnreadParameterWarning",
    "View",
    "ViewsWarning",
    "Window",
    "accumulate",
    "apply",
    "compare",
    "cpu_level",
    "fill_depth",
    "finish",
    "lens_points",
    "look",
    "looks",
    "methods",
    "parameters",
    "version",
    "why_not_read",
]

__version__: str
SURVEY_MARGIN: int

class Choice(NamedTuple):
    name: str
    help: str

class Parameter(NamedTuple):
    key: str
    field: str
    attribute: str
    unit: str
    help: str
    type: str
    group: str
    min: Any
    max: Any
    default: Any
    choices: tuple[Choice, ...]

class Method(NamedTuple):
    name: str
    help: str
    cost: str
    source: str

class Look(NamedTuple):
    name: str
    about: str
    parameters: dict[str, Any]
    is_own: bool

class LensPoint(NamedTuple):
    u: float
    v: float
    time: float

class View(NamedTuple):
    colour: _Pixels
    depth: _Pixels
    lens_offset: tuple[float, float] = ...
    shear_distance: float = ...
    mean_depth: _Pixels | None = ...

class Window(NamedTuple):
    x: int
    y: int
    width: int
    height: int

def parameters() -> tuple[Parameter, ...]: ...
def methods() -> tuple[Method, ...]: ...
def looks() -> tuple[Look, ...]: ...
def look(name: str) -> dict[str, Any]: ...
def why_not_read(name: str, /, **params: Unpack[Parameters]) -> str: ...
def apply(
    colour: _Pixels,
    depth: _Pixels,
    /,
    out: _Pixels | None = None,
    *,
    progress: Callable[[float], bool | None] | None = None,
    context: Context | None = None,
    threads: int | None = None,
    **params: Unpack[FilterParameters],
) -> Any: ...
def accumulate(
    pictures: Iterable[_Pixels],
    out: _Pixels | None = None,
    *,
    context: Context | None = None,
    threads: int | None = None,
    **params: Unpack[Parameters],
) -> Any: ...
def finish(
    own: _Pixels,
    ours: _Pixels,
    /,
    out: _Pixels | None = None,
    *,
    albedo: _Pixels | None = None,
    normal: _Pixels | None = None,
    half: _Pixels | None = None,
    error: _Pixels | None = None,
    library: str | None = None,
    quality: str = "high",
    threads: int = 0,
    white: float = 1.0,
    check: bool = True,
    samples: int = 0,
) -> Any: ...
def lens_points(
    n: int, *, frame: int = 0, **params: Unpack[Parameters]
) -> tuple[LensPoint, ...]: ...
