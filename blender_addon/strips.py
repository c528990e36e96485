# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips in a scene's sequencer, which Blender shows in the place of its camera.

Those of other scenes are filtered as by F12 there, through the camera that the strip has
(camera_objects.py).
"""

from . import camera_objects, compat, setup


def why_shown(scene):
    """Why F12 shows another picture than that of a scene that is set up, or ""."""
    edit, render = scene.sequence_editor, scene.render
    if edit is None or not render.use_sequencer:
        return ""
    strips = edit.strips if hasattr(edit, "strips") else edit.sequences
    seen = [strip for strip in strips if strip.type != "SOUND"]
    if not compat.MUTED_STRIPS_COUNT:
        seen = [s for s in seen if not s.mute and not edit.channels[s.channel].mute]
    if not seen:
        return ""
    return "Post Processing > Sequencer is on and has strips: F12 shows these, not the camera"


def _seen_in(scene):
    """Scenes that a render of a scene shows as strips, a set."""
    edit, render = scene.sequence_editor, scene.render
    if edit is None or not render.use_sequencer:
        return set()
    strips = edit.strips_all if hasattr(edit, "strips_all") else edit.sequences_all
    return {s.scene for s in strips if s.type == "SCENE" and not s.mute} - {None}


def _shown_in(scene):
    """Scenes that nodes of a scene show, a set."""
    nodes = [node for tree in setup.all_trees_of(scene) for node in tree.nodes]
    return {n.scene for n in nodes if n.type == "R_LAYERS" and not n.mute} - {None}


def linked_in(scene):
    """Scenes of other files that a render of a scene shows, itself too, and are ticked.

    They are not filtered: nothing is written to what is linked.
    """
    seen = {scene, *_seen_in(scene), *_shown_in(scene)}
    linked = [s for s in seen if s.library is not None]
    return [s for s in linked if s.rack_focus.source is None and setup.is_wanted(s)]


def of_other_layers(scene, rendered):
    """Lines for the console on strips whose view layer (5.2) no node of ours shows.

    Blender heeds it in scenes without nodes only. rendered: names of scenes.
    """
    trees, ours = setup.all_trees_of(scene), setup.filter_scene_of(scene)
    shown = {n.layer for tree in trees for n in setup.layer_nodes(tree, ours)}
    lines = []
    for strip in camera_objects.strips_rendered(scene, rendered):
        layer = getattr(strip, "view_layer", None)
        if layer is not None and layer.name not in shown:
            lines.append(
                f"Strip “{strip.name}” has view layer “{layer.name}”, and the Rack Focus "
                "node another one, which is shown: choose it at the foot of the node."
            )
    return lines
