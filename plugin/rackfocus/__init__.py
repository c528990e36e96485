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

from typing import Any, NamedTuple

from . import _core
from ._core import (
    CancelledError,
    DepthError,
    Error,
    Filter,
    Lens,
    ParameterError,
    PixelError,
    compare,
    cpu_level,
    version,
)

__all__ = [
    "CancelledError",
    "DepthError",
    "Error",
    "Filter",
    "Lens",
    "Method",
    "Parameter",
    "ParameterError",
    "PixelError",
    "apply",
    "compare",
    "cpu_level",
    "methods",
    "parameters",
    "version",
]

__version__ = version()


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
    group: str  # "lens", "aperture", "depth" or "method"
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


def apply(colour, depth, out=None, *, progress=None, threads=0, **params):
    """Filters one frame and returns it.

    colour: (height, width, channels) or (height, width) float32.
    depth: (height, width) float32, in the convention of the parameter depth.
    out: writable, of colour's shape, may be colour itself; None makes a NumPy array.
    progress: function of a fraction from 0 to 1; returning False cancels.
    threads: 0 takes all processors.
    params: any of parameters() by field name, such as focus_distance=8, blades=6.
    """
    if out is None:
        import numpy

        out = numpy.empty(numpy.shape(colour), numpy.float32)
    height, width = memoryview(colour).shape[:2]
    Filter(width, height, threads=threads, **params).process(
        colour, depth, out, progress
    )
    return out
