# SPDX-License-Identifier: Apache-2.0
"""Scores of several views and of one with as many samples, where metal glints.

    BLENDER -b --factory-startup -P docs/measure_view_samples.py -- DIST OUT
    PYTHON_WITH_BPY docs/measure_view_samples.py -- DIST OUT

DIST: folder with the zips of the add-on (./dev package); OUT: for pictures. Prints
tPSNR against Cycles' own lens with 4096 samples, in dB.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/blender/inside"))
import common  # noqa: E402

DIST, OUT = (Path(part) for part in sys.argv[sys.argv.index("--") + 1 :][:2])
TOTALS, VIEWS = (24, 64, 128, 256, 512), (1, 4, 8)


def material(name, colour, roughness):
    """Metal."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Metallic"].default_value = 1
    shader.inputs["Roughness"].default_value = roughness
    return made


def make_scene():
    """Rough and polished metal balls of three sizes before a ground, in the sun."""
    scene = bpy.context.scene
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    common.set_up_cycles(scene)
    scene.cycles.max_bounces = 4
    scene.render.resolution_x, scene.render.resolution_y = 240, 160
    scene.render.resolution_percentage = 100
    rng = np.random.default_rng(8)
    for _ in range(60):
        y = rng.uniform(1.5, 9)
        x, z = rng.uniform(-0.35, 0.35) * y, rng.uniform(-0.25, 0.2) * y
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=24, ring_count=12, radius=rng.uniform(0.02, 0.06) * y,
            location=(x, y, z),
        )  # fmt: skip
        colour, roughness = rng.uniform(0.3, 1, 3), rng.choice((0.08, 0.25, 0.5))
        bpy.context.object.data.materials.append(material("m", colour, roughness))
    bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 10, -1.6))
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 5, (0.6, 0.3, 0.2)
    scene.collection.objects.link(sun)
    data = bpy.data.cameras.new("Camera")
    data.lens, data.dof.focus_distance, data.dof.aperture_fstop = 50, 4, 0.25
    camera = bpy.data.objects.new("Camera", data)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def main():
    """Prints a line for each number of samples in all."""
    OUT.mkdir(parents=True, exist_ok=True)
    common.install(DIST)
    scene = make_scene()
    data, score = scene.camera.data, common.addon("library").rackfocus.compare
    data.dof.use_dof, scene.cycles.samples = True, 4096
    data.rack_focus.supersample = 1
    wanted = common.rgba(common.render(scene, OUT / "reference.exr"))
    for total in TOTALS:
        found = {}
        scene.cycles.samples = total
        data.rack_focus.enabled = False
        own = common.rgba(common.render(scene, OUT / "own.exr"))
        found["own lens"] = round(score(own, wanted)["tpsnr"], 2)
        data.rack_focus.enabled = True
        for views in VIEWS:
            data.rack_focus.views = views
            made = common.rgba(common.render(scene, OUT / "made.exr"))
            found[f"{views} views"] = round(score(made, wanted)["tpsnr"], 2)
        print("SCORES", total, json.dumps(found), flush=True)
    common.leave()


main()
