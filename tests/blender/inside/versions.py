# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that one version of Blender writes, and another one opens.

    versions.py DIST OUT write FOLDER    (after -- where Blender is a program)
    versions.py DIST OUT read FOLDER

Writes FOLDER/NAME.blend and NAME.npy, its picture; or opens them, renders, refocuses and
unticks, and prints VERSIONS, the name and ok, or what is wrong.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
from checking import OUT, refocused, shot  # noqa: E402
from common import last_message, start, tpsnr  # noqa: E402

WHAT, FOLDER = sys.argv[-2], Path(sys.argv[-1])


def one_layer():
    """The picture leads to the output."""
    start()


def two_layers():
    """It leads to a node whose inputs have another order in 5.0."""
    scene = bpy.context.scene
    scene.render.film_transparent = True
    scene.view_layers.new("Second")
    start()


def several_views():
    """The Render Layers nodes look at a copy of the scene meanwhile."""
    start(method="views", views=3)


def nodes_off():
    """Nodes that are switched off stay out of the picture, and are as before then."""
    scene = bpy.context.scene
    tree, layers, output = checking.tree_with_output(scene)
    invert = tree.nodes.new("CompositorNodeInvert")
    tree.links.new(layers.outputs["Image"], invert.inputs["Color"])
    tree.links.new(invert.outputs[0], output)
    scene.render.use_compositing = False
    start()


def write(make):
    """A file, and the picture that it has here."""
    bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
    make()
    scene = bpy.context.scene
    np.save(FOLDER / f"{make.__name__}.npy", shot(scene, "version.exr"))
    assert not last_message(scene), last_message(scene)
    path = str(FOLDER / f"{make.__name__}.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)


def read(make):
    """The file of another version renders the same picture here, and can be unticked."""
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / f"{make.__name__}.blend"))
    scene = bpy.data.scenes["Scene"]
    wanted = np.load(FOLDER / f"{make.__name__}.npy")
    made = shot(scene, "version.exr")
    # Samplers differ; what is not filtered has 16 to 22 dB.
    assert tpsnr(made, wanted) > 28, (make.__name__, tpsnr(made, wanted))
    assert not last_message(scene), last_message(scene)
    common.same(refocused(scene, "version.exr"), made)
    scene.camera.data.rack_focus.enabled = False
    assert len(bpy.data.scenes) == 1
    tree = common.tree_of(scene)
    if make != nodes_off:
        assert tree is None
        return
    assert not scene.render.use_compositing
    assert tree is not None and not any(node.mute for node in tree.nodes)
    links = {(k.from_node.type, k.to_node.type) for k in tree.links}
    assert ("R_LAYERS", "INVERT") in links and len(links) == 2, links


MADE = (one_layer, two_layers, several_views, nodes_off)
common.install(checking.DIST)
common.make_base(checking.BASE)
common.run(
    {make.__name__: lambda make=make: globals()[WHAT](make) for make in MADE},
    [make.__name__ for make in MADE],
    lambda name, problem: print("VERSIONS", name, problem or "ok", flush=True),
)
common.leave()
