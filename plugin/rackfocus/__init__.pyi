# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from ._core import Accumulator as Accumulator
from ._core import CancelledError as CancelledError
from ._core import DepthError as DepthError
from ._core import Error as Error
from ._core import Filter as Filter
from ._core import Lens as Lens
from ._core import ParameterError as ParameterError
from ._core import PixelError as PixelError
from ._core import Pixels
from ._core import compare as compare
from ._core import cpu_level as cpu_level
from ._core import version as version

__version__: str

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

class LensPoint(NamedTuple):
    u: float
    v: float
    time: float

def parameters() -> tuple[Parameter, ...]: ...
def methods() -> tuple[Method, ...]: ...
def apply(
    colour: Pixels,
    depth: Pixels,
    out: Pixels | None = None,
    *,
    progress: Callable[[float], bool | None] | None = None,
    threads: int = 0,
    distribution_image: Pixels = ...,
    **params: float | str | bool,
) -> Any: ...
def accumulate(
    pictures: Iterable[Pixels],
    out: Pixels | None = None,
    *,
    threads: int = 0,
    **params: float | str | bool,
) -> Any: ...
def lens_points(
    n: int, *, frame: int = 0, **params: float | str | bool
) -> tuple[LensPoint, ...]: ...
