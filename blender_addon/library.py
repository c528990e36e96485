# SPDX-License-Identifier: GPL-3.0-or-later
"""The `rackfocus` package: installed as the extension's wheel, or bundled (3.4)."""

try:
    import rackfocus
except ImportError:
    from .bundled import rackfocus

__all__ = ["rackfocus"]
