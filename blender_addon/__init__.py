# SPDX-License-Identifier: GPL-3.0-or-later
"""Rack Focus: the camera's depth of field, made after the render."""

bl_info = {
    "name": "Rack Focus",
    "author": "Rack Focus developers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Camera properties > Depth of Field; Compositor > Add > Filter",
    "description": "The camera's depth of field after the render, refocusable",
    "category": "Render",
}

import sys  # noqa: E402

if (
    "MODULES" in globals()
):  # installed anew: of all modules Blender loads this one again
    begin, ours = f"{__name__}.", dict(sys.modules)
    for name in [n for n in ours if n.startswith(begin)]:
        short = name.removeprefix(begin)
        if not short.startswith("bundled"):  # a library is loaded once; see library.py
            del sys.modules[name]
            globals().pop(short, None)

from . import (  # noqa: E402
    assets,
    compare,
    engine,
    gizmo,
    handlers,
    operators,
    picker,
    presets,
    props,
    refocusing,
    setup,
    ui,
    view_compositor,
    viewport,
)

MODULES = (
    props,
    engine,
    operators,
    refocusing,
    presets,
    assets,
    picker,
    gizmo,
    compare,
    view_compositor,
    ui,
    viewport,
    handlers,
)


def register():
    """Adds everything to Blender."""
    for module in MODULES:
        module.register()


def unregister():
    """Takes everything out of Blender again, the set-up of the open file too."""
    setup.disable_everywhere()
    for module in reversed(MODULES):
        module.unregister()
