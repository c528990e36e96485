# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that look at throw-away copies of the scene while these are rendered.

What is changed is written into the nodes themselves: a file saved in the middle of a
render is put right when it opens.
"""

import contextlib

from . import compat, links, setup

HOST = "rack_focus_host"  # of nodes that look at a copy: what they looked at before
LAYER = "rack_focus_layer"  # of the same nodes: their view layer
TAIL = "rack_focus_tail"  # of nodes of ours: the node whose links they have


def _layer_field(node):
    """The property that says which layer a node reads."""
    return "layer" if node.type == "R_LAYERS" else "layer_name"


def _set_layer(node, layer):
    with contextlib.suppress(TypeError):  # its scene has no such layer
        if layer and getattr(node, _layer_field(node)) != layer:
            setattr(node, _layer_field(node), layer)


def begin(scene, copies, more=()):
    """Lets nodes look at the copies, those of the filter scene after all of them.

    Blender renders the scenes of the nodes in the order of the tree's list, to which
    nodes can only be appended. more: copies that are rendered beside the picture.
    """
    tree, ours = compat.compositor_tree(scene), setup.filter_scene_of(scene)
    order = list(tree.nodes)
    filters = setup.layer_nodes(tree, ours)
    sources = setup.source_nodes(tree, scene)
    layers = [node for node in sources if node.type == "R_LAYERS"]
    first = min(order.index(node) for node in filters) if filters else len(order)
    is_in_order = any(order.index(node) < first for node in layers)
    rendered = [*copies, *more]
    added = rendered[1:] if copies else rendered
    if added or not is_in_order:
        for copy in added:
            node = compat.new_layer_node(tree, copy)
            node[HOST] = ""
        for node in filters:
            tail = setup.add_node(tree, scene, node.layer)
            tail.location = node.location
            tail[TAIL] = node.name
            links.move_links(tree, node, tail)
            _host(node, "filter", rendered[0])
    sources += setup.mattes_in_groups(tree, scene)
    for node in sources if copies else ():
        _host(node, "source", copies[0])


def _host(node, was, copy):
    layer = getattr(node, _layer_field(node))
    node[HOST], node[LAYER] = was, layer
    node.scene = copy
    _set_layer(node, layer)


def end(scene):
    """Undoes begin() from what the nodes say."""
    for tree in setup.all_trees_of(scene):
        _take_back(tree, scene, setup.filter_scene_of(scene))


def _take_back(tree, scene, ours):
    for node in [n for n in tree.nodes if HOST in n]:
        was, layer = node[HOST], node.get(LAYER, "")
        if not was:
            tree.nodes.remove(node)
            continue
        node.scene = ours if was == "filter" else scene
        _set_layer(node, layer)
        del node[HOST], node[LAYER]
    for tail in [n for n in tree.nodes if TAIL in n]:
        node = tree.nodes.get(tail[TAIL])
        if node is not None:
            links.move_links(tree, tail, node)
        tree.nodes.remove(tail)
