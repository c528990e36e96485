# SPDX-License-Identifier: GPL-3.0-or-later
"""File Output nodes write nothing where a refocus shows what belongs into no file.

To Blender a refocus is a render of the present frame, in which these nodes write: the
picture of another frame or camera would replace the file of this one, and so would what
is in focus, or the CoC, in the picture's place. They are muted meanwhile, and marked, so
that a file that is saved then is put right when it opens.
"""

from . import camera_objects, names, refocusing, setup, taken

MARK = "rack_focus_unwritten"  # of nodes that begin() muted
SAID = "File Output nodes write nothing"

_refocused = names.store()  # scenes whose own nodes are muted for a refocus


def mute(scene):
    """A refocus begins: the scene's own nodes are muted."""
    _refocused[scene.name] = True
    setup.mute_sources(scene)


def unmute(scene):
    """A refocus is over: all nodes are as the artist has them."""
    _refocused.pop(scene.name, None)
    setup.unmute_sources(scene)
    end(scene)


def is_left_muted(scene):
    """Did an undo bring back a moment of a refocus, which is over? F12 would be one."""
    return bool(scene.rack_focus.muted) and scene.name not in _refocused


def begin(scene):
    """Before a refocus, once its passes are known; for the main thread."""
    nodes = [
        node
        for tree in setup.all_trees_of(scene)
        for node in tree.nodes
        if node.type == "OUTPUT_FILE" and not node.mute
    ]
    if not nodes or not _is_other(scene):
        return
    for node in nodes:
        node[MARK] = True
        node.mute = True


def _is_other(scene):
    """Is what a refocus will show no picture of the present frame?"""
    if refocusing.shown.get(scene.name, "picture") != "picture":
        return True
    ours, camera = setup.filter_scene_of(scene), camera_objects.camera_of(scene)
    if camera is None:
        return False
    ours.frame_set(scene.frame_current, subframe=scene.frame_subframe)
    first = [*camera_objects.view_cameras(scene, camera), camera][0]
    seen = first.evaluated_get(ours.view_layers[0].depsgraph)
    return bool(taken.why_not_this(scene, scene.frame_current, seen))


def end(scene):
    """Undoes begin()."""
    for tree in setup.all_trees_of(scene):
        for node in [node for node in tree.nodes if MARK in node]:
            node.mute = False
            del node[MARK]


def added(scene, message):
    """A message on a picture, and what becomes of its files."""
    marked = (MARK in node for tree in setup.all_trees_of(scene) for node in tree.nodes)
    return f"{message}. {SAID}" if message and any(marked) else message
