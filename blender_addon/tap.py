# SPDX-License-Identifier: GPL-3.0-or-later
"""What is linked to a node in mid-tree, as arrays.

A copy of the tree becomes a group in the compositor of a throw-away scene, in which
Image nodes with the render's passes stand for Render Layers nodes. Blender composites
that scene, inside the running render and without rendering anything, into files in
memory.
"""

import functools
from typing import NamedTuple

import bpy
import numpy as np

from . import compat, exr, group, main_thread, passes, setup, slots

TAP_S = 60.0  # that the main thread may take until it comes to it
FILE = "tap"


class TapError(Exception):
    """What is linked to a node cannot be had; the message is for the user."""


class Tapped(NamedTuple):
    """The inputs of a node; rows downwards."""

    colour: np.ndarray  # (height, width, 4), scene-linear, premultiplied
    depth: np.ndarray  # (height, width), or None where none is linked
    mask: np.ndarray  # (height, width), or a number


def read(scene, node, files):
    """The Tapped of a node in the compositor of a scene.

    files: {scene: path of the EXR of its passes}, of all scenes that the tree shows.
    """
    names = [s.name for s in node.inputs if s.is_linked]
    if "Image" not in names:
        raise TapError(f"nothing is linked to Image of the node “{node.name}”")
    width, height = passes.picture_size(scene.render)

    def fill(folder):
        task = functools.partial(_composite, scene, node, names, files, folder)
        main_thread.run(task, TAP_S)
        return {name: _read(folder, name) for name in names}

    with passes.filled_folder(width * height * 16 * 4, fill) as found:
        pass
    depth, mask = found.get("Depth"), found.get("Mask")
    if mask is None:
        mask = float(node.inputs["Mask"].default_value)
    else:
        mask = np.array(mask[..., 0])
    return Tapped(found["Image"], None if depth is None else depth[..., 0], mask)


def _read(folder, name):
    path = next(folder.glob(f"*{FILE}{name}*.exr"), None)
    if path is None:
        raise TapError(f"the compositor gave no {name} to the node")
    channels = exr.read_exr(path)
    by_letter = {key.split(".")[-1]: plane for key, plane in channels.items()}
    first = next(iter(by_letter.values()))
    one = np.ones_like(first)
    planes = [by_letter.get(c, one if c == "A" else first) for c in "RGBA"]
    return np.ascontiguousarray(np.stack(planes, -1), np.float32)


# ---- the throw-away scene ---------------------------------------------------------

_carriers = {}  # scene name: name of a copy of it without objects, up to 4.5


def _new_stand(scene):
    """A scene with a copy of another one's compositor tree, and without objects."""
    name = f"{scene.name} Rack Focus Tap"
    if compat.HAS_NODE_GROUPS:
        stand = bpy.data.scenes.new(name)
        stand.compositing_node_group = scene.compositing_node_group.copy()
    else:
        # A tree that belongs to a scene is copied with it only.
        carrier = bpy.data.scenes.get(_carriers.get(scene.name, ""))
        if carrier is None:
            carrier = scene.copy()
            carrier.name = f"{name} Source"
            _mark(carrier)
            _carriers[scene.name] = carrier.name
        stand = carrier.copy()
    _mark(stand)
    return stand


def _mark(stand):
    stand.rack_focus.is_tap = True
    state = stand.rack_focus
    state.filter_scene = state.source = state.nodes_off = None
    state.record = state.muted = ""
    stand.render.engine = setup.ENGINE
    stand.timeline_markers.clear()
    for part in (stand.collection.children, stand.collection.objects):
        for item in list(part):
            part.unlink(item)


def clean_up():
    """Removes what taps need for the time of a render; for the main thread."""
    _carriers.clear()
    for stand in [s for s in bpy.data.scenes if s.rack_focus.is_tap]:
        _remove(stand)


def _remove(stand):
    tree = stand.compositing_node_group if compat.HAS_NODE_GROUPS else None
    compat.remove_scene(stand)
    if tree is not None:
        bpy.data.node_groups.remove(tree)


def _composite(scene, node, names, files, folder):
    """In the main thread: composites what is linked to the node into files."""
    stand = _new_stand(scene)
    images = []
    try:
        tree = compat.compositor_tree(stand)
        _prune(tree, tree.nodes[node.name])
        for layers in [n for n in tree.nodes if n.type == "R_LAYERS"]:
            # Blender lets nodes of a copied scene look at the copy.
            if layers.scene is not None and layers.scene.rack_focus.is_tap:
                layer, layers.scene = layers.layer, scene
                layers.layer = layer
        _show_passes(tree, files, images)
        _lead_out(tree, tree.nodes[node.name], names, folder)
        _prepare(stand, scene)
        setup.settle(scene)
        windows = bpy.context.window_manager.windows
        about = {"window": windows[0]} if len(windows) else {}
        with bpy.context.temp_override(**about), slots.last_shown():
            bpy.ops.render.render(scene=stand.name)
    finally:
        _remove(stand)
        for image in images:
            bpy.data.images.remove(image)
        setup.settle(scene)


def _prune(tree, node):
    """Leaves a node, what it comes from, and nothing that writes files or shows."""
    kept = {node.name, *(n.name for n in group.upstream(tree, node))}
    for other in list(tree.nodes):
        if other.name not in kept and other.type != "FRAME":
            tree.nodes.remove(other)


def _image_node(tree, image, layer):
    """An Image node for a view layer of an EXR with all passes."""
    shown = tree.nodes.new("CompositorNodeImage")
    shown.image = image
    if shown.has_layers:
        try:
            shown.layer = layer
        except TypeError:
            raise TapError(f"view layer “{layer}” was not rendered") from None
    return shown


def _show_passes(tree, files, images):
    """Replaces Render Layers nodes by Image nodes; adds the images to the list."""
    loaded = {}
    for node in [n for n in tree.nodes if n.type == "R_LAYERS" and not n.mute]:
        if node.scene.render.engine == setup.ENGINE:
            raise TapError(
                "what comes to it is blurred already: link the Render Layers node of "
                "the scene in its place"
            )
        if node.scene not in files:
            raise TapError(
                f"it shows the scene “{node.scene.name}”, which is not the one that is "
                "rendered"
            )
        path = files[node.scene]
        if path not in loaded:
            loaded[path] = bpy.data.images.load(str(path))
            images.append(loaded[path])
        shown = _image_node(tree, loaded[path], node.layer)
        for link in [k for k in tree.links if k.from_node == node]:
            end, name = link.to_socket, link.from_socket.name
            tree.links.remove(link)
            output = shown.outputs.get("Combined" if name == "Image" else name)
            if output is not None:
                tree.links.new(output, end)
        tree.nodes.remove(node)


def _lead_out(tree, node, names, folder):
    """Writes the inputs of a node to files."""
    sources = [node.inputs[name].links[0].from_socket for name in names]
    ends = compat.file_output(tree, folder, FILE, names)
    for source, end in zip(sources, ends, strict=True):
        tree.links.new(source, end)
    tree.links.new(sources[names.index("Image")], compat.new_output(tree))
    tree.nodes.remove(node)


def _prepare(stand, scene):
    render = stand.render
    for name in setup.RENDER_SETTINGS:
        setattr(render, name, getattr(scene.render, name))
    render.use_multiview = False
    render.use_file_extension = True
    render.use_compositing, render.use_sequencer = True, False
    for name in ("frame_start", "frame_end", "frame_current"):
        setattr(stand, name, getattr(scene, name))
    for layer in list(stand.view_layers)[1:]:
        layer.use = False
    stand.view_layers[0].use = True
