# SPDX-License-Identifier: GPL-3.0-or-later
"""Holdouts: holes in the picture, to which Cycles gives no depth.

One view takes them for empty sky, far away, and blurs their rims by the distance of what
is seen beside them. Several views see the hole from several points of the lens, and are
right. Box and console say so.
"""

from . import sets, setup, shining, views, walked

LINES = (
    "Holdouts have no depth, and one view blurs their rims",
    "by what is beside them: take several Views",
)


def describe(scene, camera):
    """Lines for the panel on holdouts in what a camera of the scene shows."""
    if camera is None or camera.type != "CAMERA":
        return []
    settings = camera.data.rack_focus
    is_one = settings.method != "accumulate" and views.view_count(settings) < 2
    if scene.render.engine != "CYCLES" or not is_one:
        return []
    return list(LINES) if walked.once(_are_in, scene) else []


def _are_in(scene):
    """Does a view layer that is rendered show a holdout?"""
    materials = set()
    for layer in sets.layers_of(scene):
        if _has_collection(layer.layer_collection):
            return True
        for item in layer.objects:
            if item is None or item.hide_render:  # None: just removed
                continue
            if item.is_holdout:
                return True
            materials |= shining.materials_of(item)
    return any(map(_is_holdout, materials))


def _has_collection(found):
    """Is a collection of a view layer, or one inside it, a holdout with something in it?"""
    if found.exclude or found.collection.hide_render:
        return False
    if found.holdout and len(found.collection.all_objects):
        return True
    return any(map(_has_collection, found.children))


def _is_holdout(material):
    """Do the nodes of a material, or groups in them, have a Holdout?"""
    trees = setup.with_groups(material.node_tree) if material.node_tree else ()
    return any(n.type == "HOLDOUT" and not n.mute for t in trees for n in t.nodes)
