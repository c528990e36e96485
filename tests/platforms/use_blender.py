# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the add-on's zip in PyPI's Blender and renders a scene with it.

    use_blender.py DIST OUT FOLDER...    FOLDERs are looked into first

OUT gets the pinhole passes, the filtered picture and the lens, and the file is opened
again with the add-on in it.
"""

import json
import sys
from pathlib import Path

DIST, OUT = (Path(name).resolve() for name in sys.argv[1:3])
INSIDE = Path(__file__).resolve().parents[1] / "blender" / "inside"
sys.path[:0] = [str(INSIDE), *sys.argv[3:]]
import bpy  # noqa: E402
import common  # noqa: E402

common.install(DIST)
common.make_base(OUT / "base.blend")
scene, data = common.start(quality="custom")
data.dof.aperture_blades = 6
common.pinhole(scene, OUT / "passes.exr")
common.render(scene, OUT / "filtered.exr")
lens = common.addon("lens").camera_parameters(scene.camera, scene.render)
(OUT / "lens.json").write_text(json.dumps(lens))
bpy.ops.wm.save_mainfile()
bpy.ops.wm.open_mainfile(filepath=str(OUT / "base.blend"))
assert bpy.context.scene.camera.data.rack_focus.enabled
common.render(bpy.context.scene, OUT / "again.exr")
print("ok", bpy.app.version_string)
