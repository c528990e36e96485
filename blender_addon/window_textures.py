# SPDX-License-Identifier: GPL-3.0-or-later
"""Window texture coordinates, which lie in the picture, whichever way the camera looks.

Each of several views has a picture of its own, so that such a texture stands elsewhere on
a thing in each, and the views contradict each other: a checker behind everything scored
28.2 dB with one view and 23.7 with four, a gradient 35.6 and 41.5. Box and console name
the world, or a material.
"""

from . import compat, sets, setup, shining, walked


def describe(scene):
    """Lines for the panel on such a texture in a scene, for several views."""
    name = walked.once(_name_in, scene)
    if not name:
        return []
    return [
        f"The Window texture of {name} differs from view to",
        "view: where it has edges, take one view, or Camera coordinates",
    ]


def _name_in(scene):
    """The world, or a material of an object that is rendered; "" where none has one."""
    if scene.world is not None and _has_window(scene.world):
        return "the world"
    seen = set()
    for layer in sets.layers_of(scene):
        for item in layer.objects:
            for material in shining.materials_of(item) - seen:
                if _has_window(material):
                    return f"“{material.name}”"
                seen.add(material)
    return ""


def _has_window(owner):
    """Do the nodes of a world or material, or groups in them, read the place in the picture?"""
    is_used = compat.HAS_NODE_GROUPS or owner.use_nodes  # always, from 5.0 on
    if not is_used or owner.node_tree is None:
        return False
    return any(
        node.type == "TEX_COORD" and node.outputs["Window"].is_linked and not node.mute
        for tree in setup.with_groups(owner.node_tree)
        for node in tree.nodes
    )
