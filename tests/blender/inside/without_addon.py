# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a file in a Blender that does not have the add-on.

without_addon.py FILE OUTPUT
"""

import os
import sys

import bpy

path, output = sys.argv[sys.argv.index("--") + 1 :][:2]
bpy.ops.wm.open_mainfile(filepath=path)
assert not hasattr(bpy.types.Scene, "rack_focus")
scene = bpy.context.scene
scene.render.filepath = output
bpy.ops.render.render(write_still=True)
sys.stdout.flush()
os._exit(0)
