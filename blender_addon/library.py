# SPDX-License-Identifier: GPL-3.0-or-later
"""The `rackfocus` package: installed as the extension's wheel, or bundled (3.4)."""

import sys

if sys.version_info < (3, 11):
    raise ImportError(
        "Rack Focus needs a Blender with Python 3.11 or newer: 4.1 and later, or "
        "Debian's 3.4"
    )

try:
    import rackfocus
except ImportError:
    from .bundled import rackfocus

__all__ = ["rackfocus"]
