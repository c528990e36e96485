# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of tests/quality rendered through F12 with the node.

    node_scores.py DIST OUT    (after -- where Blender is a program)

Per scene: OUT/SCENE_node.exr, with eight views of an eighth of the samples
OUT/SCENE_views/passes0001_v00.exr and so on and OUT/SCENE_node_views.exr. Of the scene
mirrors, with Mirrors and Glass, OUT/mirrors_node.exr and OUT/mirrors_node_views.exr.
"""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[2] / "quality" / "scenes"))
import common  # noqa: E402
import cycles_scenes  # noqa: E402
from common import addon  # noqa: E402

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
SAMPLES, SEED, VIEWS = 64, 1, 8  # as the committed passes


def render_scene(name):
    """Builds and renders one scene."""
    cycles_scenes.build(name)  # begins with the factory settings: no add-ons
    bpy.ops.preferences.addon_enable(module=common.MODULE)
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = SAMPLES, SEED
    data = scene.camera.data
    data.dof.use_dof = True  # Rack Focus switches it off while the scene renders
    data.rack_focus.enabled = True
    common.render(scene, OUT / f"{name}_node.exr")
    message = addon("engine").last_run[scene.name]["message"]
    assert not message, message
    data.rack_focus.views = VIEWS
    data.rack_focus.passes_folder = str(OUT / f"{name}_views")
    common.render(scene, OUT / f"{name}_node_views.exr")
    message = addon("engine").last_run[scene.name]["message"]
    assert not message, message


def render_mirrors():
    """What mirrors and panes show, by its own distance."""
    cycles_scenes.build("mirrors")
    bpy.ops.preferences.addon_enable(module=common.MODULE)
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = SAMPLES, SEED
    settings = scene.camera.data.rack_focus
    settings.mirrors = settings.enabled = True
    for views, name in ((1, "mirrors_node"), (VIEWS, "mirrors_node_views")):
        settings.views = views
        common.render(scene, OUT / f"{name}.exr")
        message = addon("engine").last_run[scene.name]["message"]
        assert not message, message


common.install(DIST)
render_mirrors()
for name in ("posts", "portrait"):
    render_scene(name)
common.leave()
