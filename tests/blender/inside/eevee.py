# SPDX-License-Identifier: GPL-3.0-or-later
"""EEVEE as the main engine: the node's picture is the filter on EEVEE's passes.

    eevee.py DIST OUT    (after --; needs a display)

Also in two views, whose depths are those of cameras put there by hand, and in four of a
camera that its parent shears.

OUT/eevee.json: largest differences of the node to the filter and to the pinhole, and
the smallest depth.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import filtered, pinhole, render, rgba  # noqa: E402

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
SAMPLES = 2

common.install(DIST)
common.make_base(OUT / "eevee.blend")
scene = bpy.context.scene
engines = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
scene.render.engine = next(e for e in engines if e.startswith("BLENDER_EEVEE"))
scene.eevee.taa_render_samples = SAMPLES
if hasattr(scene.eevee, "use_shadows"):  # since 4.2, where nothing throws one
    scene.eevee.use_shadows = False
sharp = pinhole(scene, OUT / "eevee_passes.exr")
scene.camera.data.rack_focus.enabled = True
made = rgba(render(scene, OUT / "eevee_node.exr"))
colour, depth = rgba(sharp, "ViewLayer"), common.depth_of(sharp)
found = {
    "engine": scene.render.engine,
    "message": common.addon("engine").last_run[scene.name]["message"],
    "to_filter": float(np.abs(made - filtered(scene, colour, depth)).max()),
    "to_pinhole": float(np.abs(made - colour).max()),
    "nearest": float(depth.min()),
}

# ---- views --------------------------------------------------------------------------

camera, data = scene.camera, scene.camera.data
data.rack_focus.views = 2
bpy.ops.render.render()
found["views_message"] = common.addon("engine").last_run[scene.name]["message"]
views = common.addon("passes").rendered(scene).views("ViewLayer")
found["n_views"] = len(views)
data.rack_focus.views = 1
# As many as a view has: EEVEE's depth is that of a sample, and these differ by count.
scene.eevee.taa_render_samples = SAMPLES // len(views)
found["views_off"] = []
for layer, place in views:
    (u, v), distance = place.offset, place.shear_distance
    camera.location = (u, 0, v)  # looks along y
    data.shift_x = -u * data.lens / (distance * data.sensor_width)
    data.shift_y = -v * data.lens / (distance * data.sensor_width)
    depth = common.depth_of(pinhole(scene, OUT / "eevee_passes.exr"))
    off = np.abs(layer.depth / depth - 1) > 2e-3
    found["views_off"].append(float(off.mean()))

# ---- a camera that its parent shears --------------------------------------------------

parent = bpy.data.objects.new("Parent", None)
scene.collection.objects.link(parent)
parent.scale, parent.rotation_euler = (1, 2, 0.5), (0.3, 0.2, 0.1)
camera.parent, camera.location = parent, (0, 0, 0)
camera.rotation_euler.y += 0.2
data.shift_x = data.shift_y = 0
data.rack_focus.enabled, data.rack_focus.views = True, 4
bpy.context.view_layer.update()
bpy.ops.render.render()
found["sheared_message"] = common.addon("engine").last_run[scene.name]["message"]
views = common.addon("passes").rendered(scene).views("ViewLayer")
found["sheared_views"] = [float((layer.depth < 100).mean()) for layer, _ in views]
print(found)
(OUT / "eevee.json").write_text(json.dumps(found))
common.leave()
