# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blender 3.4 and 5.x, in one place."""

import contextlib

import bpy

from . import printed

HAS_NODE_GROUPS = bpy.app.version >= (5, 0, 0)  # the compositor is a node group
HAS_MEDIA_TYPE = bpy.app.version >= (5, 0, 0)
ORTHO_LENS_IS_AT_CLIP = bpy.app.version < (4, 2, 0)  # Cycles; measured on 3.4 and 4.2
# Measured: 3.4, 4.2, 5.1 and 5.2 composite around them; 4.4, 4.5 and 5.0 composite nothing.
UNKNOWN_NODES_STOP = (4, 4, 0) <= bpy.app.version < (5, 1, 0)
EEVEE_LOSES_THINGS = bpy.app.version < (4, 2, 0)  # of sheared cameras; not in 5.2
MATTES_ADD_VIEWS = bpy.app.version < (4, 4, 0)  # of multi-view; measured: the same ones
MUTED_STRIPS_COUNT = bpy.app.version < (4, 4, 0)  # measured: 3.4 to 4.3; 4.4 to 5.0
HAS_STROKES_PASS = "use_pass_grease_pencil" in bpy.types.ViewLayer.bl_rna.properties
HAS_FLAT_RECT = bpy.app.version >= (4, 0, 0)

# "//" for the folder of the file; older Blenders take it from every path.
PATH_OPTIONS = (
    {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()
)

LEFT_USERS = b"ERROR (bke.lib_id_delete)"  # what Blender prints

FILTER_MENUS = (
    "NODE_MT_category_compositor_filter",  # 4.x, 5.x
    "NODE_MT_category_CMP_OP_FILTER",  # 3.x
)

# ---- compositor -------------------------------------------------------------------


def compositor_tree(scene):
    """The scene's compositor tree if it is in use, else None."""
    if HAS_NODE_GROUPS:
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def is_linked(tree):
    """Does a compositor tree belong to another file, where no node can be added?"""
    return HAS_NODE_GROUPS and tree.library is not None


def unknown_nodes(tree):
    """Names of nodes of a tree that this Blender has no type for."""
    return [
        node.name
        for node in tree.nodes
        if node.bl_idname == "NodeUndefined"
        or any(
            s.bl_idname == "NodeSocketUndefined" for s in (*node.inputs, *node.outputs)
        )
    ]


def _remove_viewer(tree):
    """Reduces 4.5's default nodes to those of before: layers and output."""
    for node in list(tree.nodes):
        if node.type in ("VIEWER", "REROUTE"):
            tree.nodes.remove(node)
    output, sources = output_socket(tree), [n for n in tree.nodes if n.outputs]
    if output is not None and sources and not output.is_linked:
        tree.links.new(sources[0].outputs["Image"], output)


def _outputs_of(tree):
    """The outputs of a node group's interface, from the top."""
    items = [i for i in tree.interface.items_tree if i.item_type == "SOCKET"]
    return [item for item in items if item.in_out == "OUTPUT"]


def is_shown(tree):
    """Does Blender show what a compositor tree composites?

    From 5.0 on the first output is the picture. If it is no colour, measured in 5.0 and 5.2,
    the plain render stays; where several views hide that, 5.0 saves nothing, and crashes.
    """
    outputs = _outputs_of(tree) if HAS_NODE_GROUPS else ()
    return not outputs or outputs[0].socket_type == "NodeSocketColor"


def new_layer_node(tree, scene):
    """A new Render Layers node of a scene.

    5.0 counts a user too many for the scene of the context, for good: let it be `scene`
    where that is one of ours.
    """
    in_scene = bpy.context.temp_override(scene=scene)
    with in_scene if HAS_NODE_GROUPS else contextlib.nullcontext():
        node = tree.nodes.new("CompositorNodeRLayers")
    node.scene = scene
    return node


def start_compositor(scene):
    """Puts the compositor to use with its default nodes; returns (tree, is_new)."""
    tree = compositor_tree(scene)
    if tree is not None:
        return tree, False
    if not HAS_NODE_GROUPS:
        is_new = scene.node_tree is None
        images = set(bpy.data.images)
        scene.use_nodes = True
        if is_new:
            _remove_viewer(scene.node_tree)
            for image in set(bpy.data.images) - images:
                bpy.data.images.remove(image)
            # Blender lets them look at the scene of the window, whichever tree it is.
            for node in scene.node_tree.nodes:
                if node.type == "R_LAYERS":
                    node.scene = scene
        return scene.node_tree, is_new
    tree = bpy.data.node_groups.new(f"{scene.name} Compositing", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    layers = new_layer_node(tree, scene.rack_focus.filter_scene or scene)
    layers.scene = scene
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (400, 0)
    tree.links.new(layers.outputs["Image"], output.inputs[0])
    scene.compositing_node_group = tree
    return tree, True


def complete_nodes(tree, scene):
    """Adds what a tree needs so that anything is composited; returns the new nodes.

    An empty tree gets a Render Layers node too. Files have such trees where a script
    cleared them, or where somebody deleted all nodes.
    """
    if output_socket(tree) is not None:
        return []
    is_empty = not tree.nodes
    if HAS_NODE_GROUPS:
        if not _outputs_of(tree):
            new_socket(tree, "Image", "OUTPUT", "NodeSocketColor")
        output = tree.nodes.new("NodeGroupOutput")
    else:
        output = tree.nodes.new("CompositorNodeComposite")
    output.location = (400, 0)
    if not is_empty:
        return [output]
    layers = new_layer_node(tree, scene.rack_focus.filter_scene or scene)
    layers.scene = scene
    tree.links.new(layers.outputs["Image"], output.inputs[0])
    return [output, layers]


def stop_compositor(scene, is_made):
    """Takes the compositor out of use; is_made: the tree is ours to delete."""
    if not HAS_NODE_GROUPS:
        scene.use_nodes = False
        return
    tree = scene.compositing_node_group
    scene.compositing_node_group = None
    if is_made and tree is not None and tree.users == 0:
        bpy.data.node_groups.remove(tree)


def drop_compositor(scene):
    """Takes a scene that is a copy, and has a copy of the nodes, out of compositing.

    Measured: 4.5 crashes where a node shows a scene whose device for compositing is the
    GPU; 4.2, 5.0 and 5.2 do not.
    """
    if hasattr(scene.render, "compositor_device"):
        scene.render.compositor_device = "CPU"
    if HAS_NODE_GROUPS:
        scene.compositing_node_group = None
        return
    scene.use_nodes = False
    if scene.node_tree is not None:
        scene.node_tree.nodes.clear()


def curves_of(animation):
    """The F-curves of what a datablock's animation data plays; None has none."""
    action = animation.action if animation is not None else None
    if action is None:
        return []
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    if animation.action_slot is None:  # 5.0
        return []
    strips = [strip for layer in action.layers for strip in layer.strips]
    bags = [strip.channelbag(animation.action_slot) for strip in strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def remove_scene(scene):
    """Deletes a scene that no window shows, also where there is no window.

    scenes.remove() reads the window of the context, and 3.4 crashes without one.
    """
    for state in [other.rack_focus for other in bpy.data.scenes]:
        for name in ("filter_scene", "source", "viewed"):
            if scene in (getattr(state, name), state.id_data):
                setattr(state, name, None)
    # Up to 4.2 a copied scene counts the users of its nodes twice; 3.4 then reports one
    # that is left.
    with printed.without(LEFT_USERS):
        if bpy.context.window is not None:
            bpy.data.scenes.remove(scene)
        else:
            bpy.data.batch_remove([scene])


def shutter_start(scene):
    """When the shutter opens, in frames from the frame's own time."""
    owner = scene.render if hasattr(scene.render, "motion_blur_position") else None
    owner = owner or getattr(scene, "cycles", None)
    position = getattr(owner, "motion_blur_position", "CENTER")
    part = {"START": 0, "CENTER": -0.5, "END": -1}[position]
    return part * scene.render.motion_blur_shutter


def own_tree(scene):
    """The scene's compositor tree, copied if other scenes use it too; None without."""
    tree = compositor_tree(scene)
    if HAS_NODE_GROUPS and tree is not None and tree.users > 1:
        tree = scene.compositing_node_group = tree.copy()
    return tree


def new_socket(tree, name, side, kind):
    """A new socket of a node group; side: INPUT or OUTPUT."""
    if hasattr(tree, "interface"):
        return tree.interface.new_socket(name, in_out=side, socket_type=kind)
    return (tree.inputs if side == "INPUT" else tree.outputs).new(kind, name)


def clear_sockets(tree, side):
    """Removes all sockets of one side of a node group."""
    if hasattr(tree, "interface"):
        for item in list(tree.interface.items_tree):
            if item.item_type == "SOCKET" and item.in_out == side:
                tree.interface.remove(item)
    else:
        (tree.inputs if side == "INPUT" else tree.outputs).clear()


def new_output(tree):
    """The input of a new node that ends up as the render's picture."""
    if not HAS_NODE_GROUPS:
        return tree.nodes.new("CompositorNodeComposite").inputs["Image"]
    clear_sockets(tree, "OUTPUT")
    new_socket(tree, "Image", "OUTPUT", "NodeSocketColor")
    return tree.nodes.new("NodeGroupOutput").inputs[0]


def file_output(tree, folder, start, names):
    """A File Output node for float EXR files start + name; returns its inputs."""
    node = tree.nodes.new("CompositorNodeOutputFile")
    settings = node.format
    if hasattr(node, "file_output_items"):  # 5.x
        node.directory, node.file_name = str(folder), start
        settings.media_type = "IMAGE"
        node.file_output_items.clear()
        for name in names:
            node.file_output_items.new("RGBA", name)
    else:
        node.base_path = str(folder)
        node.file_slots.clear()
        for name in names:
            node.file_slots.new(f"{start}{name}")
    settings.file_format = "OPEN_EXR"
    settings.color_mode, settings.color_depth = "RGBA", "32"
    settings.exr_codec = "NONE"
    return list(node.inputs)[: len(names)]


def output_socket(tree):
    """The input socket that ends up as the render's picture, or None."""
    for node in tree.nodes:
        if node.type == "COMPOSITE" and not node.mute:
            return node.inputs["Image"]
    ends = [n for n in tree.nodes if n.type == "GROUP_OUTPUT" and n.inputs]
    active = [node for node in ends if node.is_active_output]
    return next((node.inputs[0] for node in (*active, *ends)), None)


def alpha_over(tree):
    """A new Alpha Over node; returns (node, background socket, foreground socket)."""
    node = tree.nodes.new("CompositorNodeAlphaOver")
    pictures = [s for s in node.inputs if s.type == "RGBA"]
    return node, pictures[0], pictures[1]


# ---- pictures ---------------------------------------------------------------------

_SETTINGS = (
    "media_type",
    "file_format",
    "color_mode",
    "color_depth",
    "exr_codec",
    "use_preview",
    "use_exr_interleave",
    "views_format",
)


def writes_passes(scene):
    """Are the files of a scene's renders of all its passes?"""
    return scene.render.image_settings.file_format == "OPEN_EXR_MULTILAYER"


class MultilayerExr:
    """Sets a scene's image settings to an uncompressed float EXR with all passes.

    A context manager; puts everything back at the end.
    """

    def __init__(self, scene, has_views):
        self.scene = scene
        self.settings = scene.render.image_settings
        self.has_views = has_views
        self.kept = []
        self.space = ""
        self.aspect = (1.0, 1.0)

    def _set(self, name, value):
        if hasattr(self.settings, name):
            setattr(self.settings, name, value)

    def __enter__(self):
        names = [name for name in _SETTINGS if hasattr(self.settings, name)]
        self.kept = [(name, getattr(self.settings, name)) for name in names]
        # Reading it prints a warning where it was never set.
        if getattr(self.settings, "color_management", "") == "OVERRIDE":
            self.space = self.settings.linear_colorspace_settings.name
        if HAS_MEDIA_TYPE:
            self._set("media_type", "MULTI_LAYER_IMAGE")
        self._set("file_format", "OPEN_EXR_MULTILAYER")
        self._set("color_depth", "32")
        self._set("exr_codec", "NONE")
        self._set("use_preview", False)
        self._use_space_of_scene()
        if self.has_views:
            self._set("views_format", "INDIVIDUAL")
        # 5.0 writes an empty file where pixels are not square.
        render = self.scene.render
        self.aspect = render.pixel_aspect_x, render.pixel_aspect_y
        if self.aspect[0] != self.aspect[1] and HAS_MEDIA_TYPE:
            render.pixel_aspect_x = render.pixel_aspect_y = 1
        return self

    def __exit__(self, *_):
        render = self.scene.render
        if (render.pixel_aspect_x, render.pixel_aspect_y) != self.aspect:
            render.pixel_aspect_x, render.pixel_aspect_y = self.aspect
        for name, value in self.kept:
            try:
                setattr(self.settings, name, value)
            except TypeError:  # not a choice of the file format: it was unused
                pass
        self._set_space(self.space)  # which 4.5 and later forget with the format

    def _use_space_of_scene(self):
        """Passes come in the scene's colour space, whatever that of the files is.

        Up to 4.4 that of the files is taken for passes too. The scene's has no name but
        that which Blender chooses: the filter scene, which writes no files, asks for it.
        """
        owner = self.scene.rack_focus.viewed or self.scene
        ours = owner.rack_focus.filter_scene
        if not self.space or ours is None:
            return
        spare = ours.render.image_settings
        for choice in ("FOLLOW_SCENE", "OVERRIDE"):
            spare.color_management = choice
        self._set_space(spare.linear_colorspace_settings.name)

    def _set_space(self, name):
        with contextlib.suppress(TypeError):  # unknown to the present configuration
            if name and self.settings.linear_colorspace_settings.name != name:
                self.settings.linear_colorspace_settings.name = name


def set_rect(render_pass, pixels):
    """Copies pixels, contiguous (height, width, channels) float32, into a pass."""
    if HAS_FLAT_RECT:
        render_pass.rect.foreach_set(pixels.reshape(-1))
    else:
        render_pass.rect.foreach_set(pixels.reshape(-1, pixels.shape[-1]))
