# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on's preferences say, for modules that draw nothing."""

import bpy


def get(name, default):
    """A preference; the default where the add-on is not enabled in the usual way."""
    addon = bpy.context.preferences.addons.get(__package__)
    return getattr(addon.preferences, name) if addon and addon.preferences else default


def threads():
    """Number of threads; 0 is all."""
    return get("threads", 0)
