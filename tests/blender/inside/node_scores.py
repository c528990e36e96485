# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of tests/quality rendered through F12 with the node: posts and mirrors.

    node_scores.py DIST OUT    (after -- where Blender is a program)

OUT/SCENE_node.exr, of posts without Clean Edges and with it OUT/posts_node_edges.exr,
and, with eight views of an eighth of the samples,
OUT/SCENE_node_views.exr; of posts OUT/posts_views/passes0001_v00.exr and so on, too. Those
of mirrors are with Mirrors and Glass.
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


def render_posts():
    """As artists do."""
    cycles_scenes.build("posts")  # begins with the factory settings: no add-ons
    bpy.ops.preferences.addon_enable(module=common.MODULE)
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = SAMPLES, SEED
    data = scene.camera.data
    data.dof.use_dof = True  # Rack Focus switches it off while the scene renders
    data.rack_focus.enabled = True
    common.render(scene, OUT / "posts_node_parts.exr")
    data.rack_focus.supersample = 1
    common.render(scene, OUT / "posts_node_edges.exr")
    data.rack_focus.clean_edges = False
    common.render(scene, OUT / "posts_node.exr")
    message = addon("engine").last_run[scene.name]["message"]
    assert not message, message
    data.rack_focus.views = VIEWS
    data.rack_focus.passes_folder = str(OUT / "posts_views")
    common.render(scene, OUT / "posts_node_views.exr")
    message = addon("engine").last_run[scene.name]["message"]
    assert not message, message


def render_mirrors():
    """What mirrors and panes show, by its own distance."""
    cycles_scenes.build("mirrors")
    bpy.ops.preferences.addon_enable(module=common.MODULE)
    scene = bpy.context.scene
    scene.cycles.seed = SEED
    settings = scene.camera.data.rack_focus
    settings.mirrors = settings.enabled = True
    # One view with 64 samples is worth no more: grain of metal in each of eight is.
    for views, samples, name in (
        (1, 16, "mirrors_node"),
        (VIEWS, SAMPLES, "mirrors_node_views"),
    ):
        settings.views, scene.cycles.samples = views, samples
        common.render(scene, OUT / f"{name}.exr")
        message = addon("engine").last_run[scene.name]["message"]
        assert not message, message


common.install(DIST)
render_mirrors()
render_posts()
common.leave()
