# SPDX-License-Identifier: GPL-3.0-or-later
"""Compositing nodes that the artist has switched off stay out of the picture.

The set-up needs a compositor, and switching it on would let old nodes into the picture,
write their files and render the scenes that they show. So they sleep meanwhile.

5.0 and later   the scene has nodes of ours in their place
up to 4.5       a scene's nodes cannot be exchanged: all are muted but for the outputs,
                whose links are taken off; what is undone stands in the nodes themselves
"""

import json

import bpy

from . import compat

MARK = "rack_focus_asleep"  # of such nodes: what end() needs, as JSON
OUTPUT = "COMPOSITE"
LED = "rack_focus_led"  # of what led to an output, for 5.0, which replaces that: its number
ALPHA = "use_alpha"  # of an output, up to 4.4
NOT_MUTED = ("FRAME", "REROUTE")  # they do nothing
# Nodes that show the render as it is, or show it elsewhere.
PLAIN = ("R_LAYERS", OUTPUT, "GROUP_OUTPUT", "VIEWER", *NOT_MUTED)


# ---- which ------------------------------------------------------------------------


def is_asleep(node):
    """Is a node muted, or an output led past, by begin()?"""
    return MARK in node


def is_off(scene):
    """Has a scene compositing nodes that are switched off and are more than the render?"""
    tree = _tree_of(scene)
    is_on = scene.render.use_compositing and compat.compositor_tree(scene) is not None
    return tree is not None and not is_on and not _is_plain(tree, scene)


def _tree_of(scene):
    """The compositor tree of a scene, in use or not."""
    if compat.HAS_NODE_GROUPS:
        return scene.compositing_node_group
    return scene.node_tree


def _is_plain(tree, scene):
    """Does a tree show the render as it is? Or is it empty?"""
    if not tree.nodes:
        return True
    layers = [node for node in tree.nodes if node.type == "R_LAYERS"]
    used = [layer.name for layer in scene.view_layers if layer.use]
    if any(node.type not in PLAIN or node.mute for node in tree.nodes):
        return False
    is_its = len(layers) == 1 and layers[0].scene == scene
    if not is_its or used[:1] != [layers[0].layer]:
        return False
    ends = [n for n in tree.nodes if n.type in (OUTPUT, "GROUP_OUTPUT") and n.inputs]
    return all(_is_render(end) for end in ends)


def _is_render(end):
    """Does an output show the picture of a Render Layers node, and nothing else?"""
    linked = [socket for socket in end.inputs if socket.is_linked]
    if linked != [end.inputs[0]] or not getattr(end, ALPHA, True):
        return False
    output = linked[0].links[0].from_socket
    while output.node.type == "REROUTE" and output.node.inputs[0].is_linked:
        output = output.node.inputs[0].links[0].from_socket
    return output.node.type == "R_LAYERS" and output.name == "Image"


# ---- to sleep, and awake ----------------------------------------------------------


def begin(scene):
    """Puts the nodes of a scene to sleep that is_off()."""
    tree = _tree_of(scene)
    if compat.HAS_NODE_GROUPS:
        scene.rack_focus.nodes_off = tree
        scene.compositing_node_group = None
        return
    for node in tree.nodes:
        if node.mute or node.type in NOT_MUTED:
            continue
        if node.type == OUTPUT:
            node[MARK] = json.dumps(_take_off(tree, node))
        else:
            node[MARK] = ""
            node.mute = True


def _take_off(tree, node):
    """Takes the links of an output off; returns what _put_back() needs."""
    about = {"use_alpha": getattr(node, ALPHA, True), "links": []}
    for index, socket in enumerate(node.inputs):
        for link in list(socket.links):
            source = link.from_node
            number = list(source.outputs).index(link.from_socket)
            about["links"].append([source.name, number, index])
            if index == 0:
                source[LED] = number
            tree.links.remove(link)
    _set_alpha(node, True)
    return about


def _set_alpha(node, is_used):
    if hasattr(node, ALPHA):
        setattr(node, ALPHA, is_used)


def _put_back(tree, node):
    about = json.loads(node[MARK])
    _set_alpha(node, about["use_alpha"])
    for name, number, index in about["links"]:
        source = tree.nodes.get(name)
        if source is not None and number < len(source.outputs):
            tree.links.new(source.outputs[number], node.inputs[index])


def outputs(tree):
    """The inputs of the outputs that begin() led past."""
    nodes = [n for n in tree.nodes if is_asleep(n) and n.type == OUTPUT]
    return [node.inputs["Image"] for node in nodes]


def end(scene, is_untouched):
    """Undoes begin(), and leaves the nodes switched off.

    is_untouched: the tree has no nodes of the artist's that came since.
    """
    state, tree = scene.rack_focus, _tree_of(scene)
    sleepers = [n for n in tree.nodes if is_asleep(n)] if tree is not None else []
    if compat.HAS_NODE_GROUPS and sleepers:  # begun in another version
        _wake(tree, sleepers)
        scene.render.use_compositing = False
        return
    if compat.HAS_NODE_GROUPS:
        scene.compositing_node_group, state.nodes_off = state.nodes_off, None
        is_other = tree not in (None, scene.compositing_node_group)
        if is_other and not is_untouched:
            tree.use_fake_user = True
        elif is_other and tree.users == 0:
            bpy.data.node_groups.remove(tree)
        return
    _wake(tree, sleepers)


def _wake(tree, sleepers):
    for node in [n for n in tree.nodes if LED in n]:
        output = compat.output_socket(tree)
        if compat.HAS_NODE_GROUPS and output is not None:
            tree.links.new(node.outputs[node[LED]], output)
        del node[LED]
    for node in sleepers:
        if node.type == OUTPUT:
            _put_back(tree, node)
        else:
            node.mute = False
        del node[MARK]
