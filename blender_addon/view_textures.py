# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture coordinates that count from the camera that renders: Window and Camera.

Each of several views has a place and a picture of its own, so that such a texture stands
elsewhere on a thing in each, and the views contradict each other. Window: a checker behind
everything scored 28.2 dB with one view and 23.7 with four, a gradient 35.6 and 41.5.
Camera: a checker on cubes 34.3 and 25.3; the Object coordinates of the camera are the same
in all views (35.3 and 39.6). Box and console name the world, or a material.
"""

from . import compat, sets, setup, shining, walked

# kind: (what it is called, what to take in its place)
KINDS = {
    "Window": ("where it has edges, take one view", ""),
    "Camera": ("take one view, or the Object coordinates", " of the camera"),
}


def describe(scene):
    """Lines for the panel on such textures in a scene, for several views."""
    found, lines = walked.once(_names_in, scene), []
    for kind, (advice, more) in KINDS.items():
        if found.get(kind):
            lines += [
                f"The {kind} texture of {found[kind]} differs from view to",
                f"view: {advice}{more}",
            ]
    return lines


def _names_in(scene):
    """{kind: the world, or a material of an object that is rendered} of a scene.

    The world lies at infinity, where Camera coordinates are the same in all views.
    """
    found, seen = {}, set()
    if scene.world is not None and "Window" in _kinds_of(scene.world):
        found["Window"] = "the world"
    for layer in sets.layers_of(scene):
        for item in layer.objects:
            for material in shining.materials_of(item) - seen:
                for kind in _kinds_of(material):
                    found.setdefault(kind, f"“{material.name}”")
                seen.add(material)
    return found


def _kinds_of(owner):
    """Those of KINDS that nodes of a world or material, or groups in them, read."""
    is_used = compat.HAS_NODE_GROUPS or owner.use_nodes  # always, from 5.0 on
    if not is_used or owner.node_tree is None:
        return set()
    return {
        kind
        for tree in setup.with_groups(owner.node_tree)
        for node in tree.nodes
        if node.type == "TEX_COORD" and not node.mute
        for kind in KINDS
        if node.outputs[kind].is_linked
    }
