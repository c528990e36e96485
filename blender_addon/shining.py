# SPDX-License-Identifier: GPL-3.0-or-later
"""Flames and holograms: surfaces of Emission that are mixed with Transparent.

Cycles' depth leaves out a surface where its alpha lies below the view layer's Passes >
Data > Alpha Threshold. What is lit there is then taken to be as far as what is behind it,
often the sky: a halo, 19.9 dB where the own lens has 33.2. Box and console say so. The threshold itself is left alone: what is as
good as invisible, a veil or the rim of a leaf's picture, would come into the depth too.
"""

from . import compat, sets, setup, walked

LIGHT, HOLE = "EMISSION", "BSDF_TRANSPARENT"
LOW = 0.01  # a threshold that leaves nothing out that is seen


def describe(scene, settings):
    """Lines for the panel of a camera on the thresholds of a scene's view layers."""
    if settings.method == "accumulate":  # it needs no depth
        return []
    layers = [layer for layer in scene.view_layers if layer.use]
    is_high = any(layer.pass_alpha_threshold > LOW for layer in layers)
    if scene.render.engine != "CYCLES" or not is_high:
        return []
    name = walked.once(_name_in, scene)
    if not name:
        return []
    return [
        f"“{name}” mixes Emission with Transparent: set",
        f"View Layer > Passes > Data > Alpha Threshold to {LOW}",
    ]


def _name_in(scene):
    """Name of such a material of an object that is rendered, or ""."""
    seen = set()
    for layer in sets.layers_of(scene):
        for item in layer.objects:
            for material in materials_of(item) - seen:
                if _is_shining(material):
                    return material.name
                seen.add(material)
    return ""


def materials_of(item):
    """Materials of an object that is rendered, and of what it is an instance of."""
    if item is None or item.hide_render:  # None: just removed
        return set()
    inside = item.instance_collection if item.instance_type == "COLLECTION" else None
    items = [item, *(inside.all_objects if inside is not None else ())]
    slots = [
        slot for one in items if not one.hide_render for slot in one.material_slots
    ]
    return {slot.material for slot in slots} - {None}


def _is_shining(material):
    """Do the nodes of a material, or groups in them, have both?"""
    is_used = compat.HAS_NODE_GROUPS or material.use_nodes  # always, from 5.0 on
    if not is_used or material.node_tree is None:
        return False
    trees = setup.with_groups(material.node_tree)
    nodes = [node for tree in trees for node in tree.nodes if not node.mute]
    return {LIGHT, HOLE} <= {node.type for node in nodes} and not _is_by_ray(nodes)


def _is_by_ray(nodes):
    """Do all mixtures go by the kind of ray alone, so that the camera sees no hole?"""
    mixed = [node for node in nodes if node.type == "MIX_SHADER"]
    feeds = [link.from_node.type for node in mixed for link in node.inputs[0].links]
    return bool(mixed) and feeds == ["LIGHT_PATH"] * len(mixed)
