# SPDX-License-Identifier: GPL-3.0-or-later
"""The `rackfocus` package: installed as the extension's wheel, or bundled (3.4)."""

import sys
import warnings

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

__all__ = ["rackfocus"]
