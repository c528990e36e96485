# SPDX-License-Identifier: Apache-2.0
"""Depth of field after the render.

A pinhole render (colour and depth) goes in, the picture that the host's own lens would
have made comes out.

    import rackfocus

    out = rackfocus.apply(colour, depth, focus_distance=8, f_stop=1.4)

Pictures are any objects with the buffer protocol (NumPy arrays, memoryviews) that hold
32 bit floats: colour of shape (height, width, channels) with 1, 3 or 4 channels,
scene-linear with premultiplied alpha; depth of shape (height, width). Strides may be
anything, negative too; nothing is copied. Lengths are scene units, radii are pixels.
"""

import warnings
from typing import Any, NamedTuple

from . import _core, _looks
from ._core import (
    Accumulator,
    CancelledError,
    Context,
    DepthError,
    Error,
    Filter,
    Lens,
    ParameterError,
    PixelError,
    UnreadParameterWarning,
    ViewsWarning,
    compare,
    cpu_level,
    fill_depth,
    version,
)
from ._errors import parameter_error

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

__version__ = version()

SURVEY_MARGIN = _core.SURVEY_MARGIN
"""How many px around a window Filter.count() is to be given."""


class Choice(NamedTuple):
    """One choice of an enumerated parameter."""

    name: str
    help: str


class Parameter(NamedTuple):
    """One parameter, straight from the core's table."""

    key: str  # on the command line, "focus-distance"
    field: str  # as a keyword, "focus_distance"
    attribute: str  # in an EXR header, "rackfocus:focusDistance"
    unit: str  # "" for bool and enum
    help: str
    type: str  # "float", "int", "bool" or "enum"
    group: str  # "lens", "aperture", "depth", "method" or "highlights"
    min: Any
    max: Any
    default: Any  # enum: the name of the choice
    choices: tuple  # of Choice; empty unless enum


class Method(NamedTuple):
    """One method of making the blur."""

    name: str
    help: str
    cost: str
    source: str


class Look(NamedTuple):
    """The look of a kind of lens."""

    name: str
    about: str  # which kind of lens; "your own"
    parameters: dict  # {field: value}
    is_own: bool


class LensPoint(NamedTuple):
    """A view to render: where on the lens, and when."""

    u: float  # lens radii to the right of the middle, as the camera sees it
    v: float  # lens radii up
    time: float  # moment within the shutter's time, 0 (opens) to 1 (closes)


class View(NamedTuple):
    """A pinhole view from a point of the lens, for Filter.process_views()."""

    colour: Any  # (height, width, 1, 3 or 4) float32
    depth: Any  # (height, width) float32
    lens_offset: tuple = (0.0, 0.0)  # scene units right and up of the lens's middle
    shear_distance: float = 0.0  # of the plane that stays in place; 0: parallel cameras
    mean_depth: Any = None  # (height, width) float32, see Filter.process()


class Window(NamedTuple):
    """A part of a picture, px from its first row and column."""

    x: int
    y: int
    width: int
    height: int


def parameters():
    """All parameters, a tuple of Parameter in the order of the core's table."""
    found = []
    for row in _core.parameters():
        choices = tuple(Choice(*choice) for choice in row[-1])
        found.append(Parameter(*row[:-1], choices))
    return tuple(found)


def methods():
    """All methods, a tuple of Method."""
    return tuple(Method(*row) for row in _core.methods())


def looks():
    """All looks of lenses, a tuple of Look: those that come with the program, then the
    artist's own (`rackfocus looks --save`), which win where names are the same. One
    whose file is wrong is left out with a warning that names its line.
    """
    table = parameters()
    found = []
    for name, source in _looks.sources().items():
        is_own = not isinstance(source, str)
        try:
            text = _looks.text_of(source)
            values = _looks.parameters(name, text, table)
        except ParameterError as error:
            warnings.warn(error.message, stacklevel=2)
            continue
        about = "your own" if is_own else _looks.about(text)
        found.append(Look(name, about, values, is_own))
    return tuple(found)


def look(name):
    """The parameters of a look, as keywords: apply(..., **{**look("vintage"), ...}).

    The error of another name lists the looks that there are.
    """
    sources = _looks.sources()
    if name not in sources:
        message = f"there is no look {name!r}; there are {', '.join(sources)}"
        raise parameter_error("name", message)
    return _looks.parameters(name, _looks.text_of(sources[name]), parameters())


def why_not_read(name, /, **params):
    """Why a parameter has no effect with others, or "" where it has one.

    name: field of parameters(); params: any of them by field name. For panels that show
    only what counts.
    """
    return _core.why_not_read(name, **params)


def _context(context, threads):
    """The keywords of those that were given."""
    given = {"context": context, "threads": threads}
    return {name: value for name, value in given.items() if value is not None}


def _shape(name, picture):
    """The shape of a picture, or an error that names it."""
    try:
        shape = memoryview(picture).shape
    except TypeError:
        message = f"a readable buffer of floats is needed, not {type(picture).__name__}"
        if picture is not None:
            message += f"; give numpy.asarray({name}, numpy.float32)"
        raise TypeError(f"{name}: {message}") from None
    if len(shape) not in (2, 3):
        raise parameter_error(
            name,
            "the shape must be (height, width) or (height, width, channels), "
            f"not of {len(shape)} dimensions",
        )
    if (*shape, 1)[2] not in (1, 3, 4):
        message = f"has {shape[2]} channels; 1, 3 or 4 can be filtered"
        if shape[0] in (1, 3, 4):
            message += f". Are they the first axis? Give {name}.transpose(1, 2, 0)"
        raise parameter_error(name, message)
    return shape


def apply(
    colour, depth, /, out=None, *, progress=None, context=None, threads=None, **params
):
    """Filters one frame and returns it.

    colour: (height, width, channels) or (height, width) float32.
    depth: (height, width) float32, in the convention of the parameter depth.
    out: writable, of colour's shape, may be colour itself; None makes a NumPy array.
    progress: function of a fraction from 0 to 1; returning False cancels.
    context: a Context to share; kept for several pictures it saves making threads anew.
    threads: without a context; 0 takes all processors.
    params, depth="radial" among them: any of parameters() by field name, such as focus_distance=8, blades=6; and
    distribution_image, a picture of the aperture for method="scatter".
    """
    shape = _shape("colour", colour)
    if out is None:
        import numpy

        out = numpy.empty(shape, numpy.float32)
    height, width = shape[:2]
    own = _context(context, threads)
    Filter(width, height, **own, **params).process(colour, depth, out, progress)
    return out


def accumulate(pictures, out=None, *, context=None, threads=None, **params):
    """The mean of pictures of one shape, one in memory at a time.

    pictures: an iterable of (height, width, channels) or (height, width) float32.
    out: writable, of their shape; None makes a NumPy array.
    params: of parameters() blend_gamma matters, of which 1 (default) sums linear light,
        and those of highlights, which change each picture before it is added.
    """
    shape = getattr(pictures, "shape", ())
    if len(shape) == 3 and shape[-1] in (1, 3, 4):
        # Its rows would be taken for pictures, and a row of their means come out.
        raise parameter_error(
            "pictures", f"one picture of shape {tuple(shape)}; give a list of pictures"
        )
    total = None
    for picture in pictures:
        if total is None:
            shape = _shape("pictures", picture)
            height, width, channels = (*shape, 1)[:3]
            own = _context(context, threads)
            total = Accumulator(width, height, channels, **own, **params)
        total.add(picture)
    if total is None:
        raise parameter_error("pictures", "there is none to take the mean of")
    if out is None:
        import numpy

        out = numpy.empty(shape, numpy.float32)
    total.mean(out)
    return out


def finish(
    own,
    ours,
    /,
    out=None,
    *,
    albedo=None,
    normal=None,
    half=None,
    error=None,
    library=None,
    quality="high",
    threads=0,
    white=1.0,
    check=True,
    samples=0,
):
    """The host's own lens cleaned with our picture; returns the result.

    own: rendered with the lens, with grain: (height, width, 3 or 4) float32.
    ours: what a filter made, of its size. It is kept where the grain does not
    contradict it.
    out: writable, of own's shape; None makes a NumPy array. Alpha is own's.
    albedo, normal: (height, width, 3) of the own render, with its grain; textures in
    focus are sharper with them.
    half: like own, rendered with another seed, each with half of the samples. Their
    mean is finished, and what they differ by tells the grain; albedo and normal are
    then best means of both, too.
    error: writable, (height, width): how far each pixel may be off, after clipping to
    [0, 1] and gamma 2.2.
    library: Open Image Denoise's file or folder, where the environment's RACKFOCUS_OIDN
    names none; None lets the system look.
    quality: of its filters, "high", "balanced" or "fast", as Cycles names them.
    threads: of the denoiser; 0 takes all processors.
    white: luminance that is shown as white, to the nearest power of two.
    check: warn (ViewsWarning) where ours has another lens or exposure than own, as the
    command does; False does not look.
    samples: in a pixel of own, and of half; of fewer than 10 the grain is told by more
    pixels. 0 takes 10 or more.

    Error where there is no Open Image Denoise.
    """
    if not hasattr(_core, "finish"):
        error = Error("library: this build of rackfocus cannot load a denoiser")
        error.field, error.message = "library", str(error).partition(": ")[2]
        raise error
    if out is None:
        import numpy

        out = numpy.empty(numpy.shape(own), numpy.float32)
    more = (albedo, normal, half, error)
    given = {"library": library, "quality": quality, "threads": threads}
    given |= {"white": white, "check": check, "samples": samples}
    _core.finish(own, ours, out, *more, **given)
    return out


def lens_points(n, *, frame=0, **params):
    """n points that share out the lens evenly, a tuple of LensPoint.

    n: 2 to 1024.
    frame: number of the frame, which matters with lens_random only.
    params: lens_pattern ("disc", "circle", "polygon", "grid"; "auto" is a polygon where
    blades are given, else a disc), lens_random, lens_seed, and those of the aperture.
    """
    return tuple(LensPoint(*p) for p in _core.lens_points(n, frame=frame, **params))
