# SPDX-License-Identifier: GPL-3.0-or-later
"""The `rackfocus` package: installed as the extension's wheel, or bundled (3.4)."""

import contextlib
import sys
import warnings
import zlib
from pathlib import Path

if sys.version_info < (3, 10):
    raise ImportError(
        "Rack Focus needs a Blender with Python 3.10 or newer: 3.4 and later"
    )

try:
    import rackfocus
except ImportError:
    from .bundled import rackfocus

# A camera has all values at once; the panel shows those that count.
warnings.simplefilter("ignore", rackfocus.UnreadParameterWarning)
# Of files that others rendered: Cycles gives each view of ours a seed of its own, which
# nobody can change, and textures on things near the lens look like that grain too.
warnings.filterwarnings("ignore", "the grain of the views is alike", UserWarning)

RESTART = "Rack Focus was installed anew while Blender ran: restart Blender"
LOADED = "_rack_focus_loaded"  # of the library's module, which outlives the add-on's


def _is_stale():
    """Is the library that this Blender has loaded not the one that was installed?"""
    core, content = rackfocus._core, None
    with contextlib.suppress(OSError):
        content = zlib.crc32(Path(core.__file__).read_bytes())
    if not hasattr(core, LOADED):
        setattr(core, LOADED, content)
    return content != getattr(core, LOADED)


is_stale = _is_stale()

__all__ = ["RESTART", "is_stale", "rackfocus"]
