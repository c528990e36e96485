# SPDX-License-Identifier: GPL-3.0-or-later
"""The node with sockets: a group in the artist's compositor, filtered in mid-tree.

    Image, Depth, Mask -> Image, Alpha, CoC, Depth, Focus

Blender runs no code of ours inside a compositor. What is linked to the node is computed
by a compositor of its own, between render and compositing (tap.py), filtered, and put
into images, which the group shows. Until then, where the filter fails, and in files,
the group passes its Image through: nothing is black, with or without the add-on.
"""

import bpy
import numpy as np

from . import compat

NAME = "Rack Focus"
# name, type, default (None: no field, it counts only where it is linked)
INPUTS = (
    ("Image", "NodeSocketColor", (0.0, 0.0, 0.0, 1.0)),
    ("Depth", "NodeSocketFloat", None),
    ("Mask", "NodeSocketFloat", 1.0),
)
OUTPUTS = (
    ("Image", "NodeSocketColor"),
    ("Alpha", "NodeSocketFloat"),
    ("CoC", "NodeSocketFloat"),
    ("Depth", "NodeSocketFloat"),
    ("Focus", "NodeSocketColor"),
)
PICTURE, DATA, FOCUS = "Picture", "CoC and Depth", "Focus"  # names of Image nodes

# ---- making -----------------------------------------------------------------------


def _sockets(tree):
    for name, kind, default in INPUTS:
        socket = compat.new_socket(tree, name, "INPUT", kind)
        if default is None:
            socket.hide_value = True
        else:
            socket.default_value = default
    for name, kind in OUTPUTS:
        compat.new_socket(tree, name, "OUTPUT", kind)


def new_group():
    """A new group that passes its picture through."""
    tree = bpy.data.node_groups.new(NAME, "CompositorNodeTree")
    tree.rack_focus.is_node = True
    _sockets(tree)
    begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    begin.name, end.name = "Input", "Output"
    begin.location, end.location = (-600, 0), (300, 0)
    for row, name in enumerate((PICTURE, DATA, FOCUS)):
        node = tree.nodes.new("CompositorNodeImage")
        node.name = node.label = name
        node.location = (-600, -200 - 320 * row)
    for row, name in enumerate(("Split", "Split Picture", "Split Data")):
        node = tree.nodes.new("CompositorNodeSeparateColor")
        node.name = name
        node.location = (-200, -200 * row)
    pairs = (("Split", begin), ("Split Picture", PICTURE), ("Split Data", DATA))
    for name, source in pairs:
        source = tree.nodes[source] if isinstance(source, str) else source
        tree.links.new(source.outputs["Image"], tree.nodes[name].inputs[0])
    show(tree, False)
    return tree


def show(tree, is_filtered):
    """Lets a group show its images, or pass its picture through."""
    nodes = tree.nodes
    begin, end = nodes["Input"], nodes["Output"]
    split = nodes["Split Picture" if is_filtered else "Split"]
    data = nodes["Split Data"].outputs
    found = {
        "Image": nodes[PICTURE].outputs["Image"] if is_filtered else begin.outputs[0],
        "Alpha": split.outputs["Alpha"],
        "CoC": data["Red"] if is_filtered else None,
        "Depth": data["Green"] if is_filtered else begin.outputs["Depth"],
        "Focus": nodes[FOCUS].outputs["Image"] if is_filtered else begin.outputs[0],
    }
    for name, output in found.items():
        socket = end.inputs[name]
        if [link.from_socket for link in socket.links] == [output]:
            continue
        for link in list(socket.links):
            tree.links.remove(link)
        if output is not None:
            tree.links.new(output, socket)
    tree.rack_focus.is_filtered = is_filtered


# ---- finding ----------------------------------------------------------------------


def is_ours(node):
    """Is a node one of these?"""
    tree = node.node_tree if node.type == "GROUP" else None
    return tree is not None and tree.rack_focus.is_node


def nodes_of(scene):
    """The nodes of a scene that are not muted, sources before followers."""
    tree = compat.compositor_tree(scene)
    found = [n for n in tree.nodes if is_ours(n) and not n.mute] if tree else []
    reach = {node.name: {n.name for n in upstream(tree, node)} for node in found}
    return sorted(found, key=lambda node: len(reach[node.name] & reach.keys()))


def upstream(tree, node):
    """All nodes that what is linked to a node comes from."""
    before = {}
    for link in tree.links:
        before.setdefault(link.to_node.name, set()).add(link.from_node.name)
    found, new = set(), {node.name}
    while new:
        new = {name for one in new for name in before.get(one, ())} - found
        found |= new
    return [tree.nodes[name] for name in found]


def ends_at_groups(tree, sources):
    """Do all ways from some nodes to a picture lead through unmuted nodes of ours?"""
    after = {}
    for link in tree.links:
        after.setdefault(link.from_node.name, []).append(link.to_node)
    seen, new = set(), [node.name for node in sources]
    while new:
        followers = after.get(new.pop(), ())
        for node in followers:
            if node.name in seen or (is_ours(node) and not node.mute):
                continue
            if not node.outputs:
                return False
            seen.add(node.name)
            new.append(node.name)
    return True


def camera_of(scene, node):
    """The camera object whose lens a node has, or None."""
    camera = node.node_tree.rack_focus.camera or scene.camera
    return camera if camera is not None and camera.type == "CAMERA" else None


def layer_of(scene, node):
    """Name of the view layer whose depth a node has where none is linked."""
    name = node.node_tree.rack_focus.layer
    used = [layer.name for layer in scene.view_layers if layer.use]
    return name if name in used or not used else used[0]


# ---- keeping up -------------------------------------------------------------------


def separate(scenes):
    """Gives nodes that were copied groups of their own."""
    seen = set()
    for scene in scenes:
        tree = compat.compositor_tree(scene)
        for node in [n for n in tree.nodes if is_ours(n)] if tree is not None else ():
            if node.node_tree in seen:
                node.node_tree = copy = node.node_tree.copy()
                for name in (PICTURE, DATA, FOCUS):
                    copy.nodes[name].image = None
                show(copy, False)
            seen.add(node.node_tree)


def remove_unused():
    """Removes groups that no node has any more, and their images."""
    # Counted anew: up to 4.2 copied scenes leave users too many.
    trees = [t for t in bpy.data.node_groups if t.rack_focus.is_node]
    for tree in _without_users([t for t in trees if t.library is None]):
        images = {tree.nodes[name].image for name in (PICTURE, DATA, FOCUS)} - {None}
        bpy.data.node_groups.remove(tree)
        for image in _without_users(list(images)):
            bpy.data.images.remove(image)


def _without_users(items):
    users = bpy.data.user_map(subset=items) if items else {}
    return [item for item in items if not users[item]]


# ---- pictures ---------------------------------------------------------------------


def make_ready(tree, width, height):
    """Lets a group show its images, for the render that begins.

    Blender does not see links and images that change while it renders; what the
    images show it does.
    """
    for name in (PICTURE, DATA, FOCUS):
        node = tree.nodes[name]
        if node.image is None:
            node.image = image = bpy.data.images.new(
                f"{tree.name} {name}", width, height, alpha=True, float_buffer=True
            )
            image.alpha_mode = "PREMUL"
    show(tree, True)


def put(tree, name, pixels):
    """Gives an image of a group (height, width, 4) float32, rows upwards."""
    image = tree.nodes[name].image
    height, width = pixels.shape[:2]
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).reshape(-1))
    image.update()


def linked(node):
    """Names of the outputs of a node that lead somewhere."""
    return {output.name for output in node.outputs if output.is_linked}
