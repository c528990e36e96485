# SPDX-License-Identifier: GPL-3.0-or-later
"""Setting a scene up for Rack Focus, and taking exactly that away again.

Beside the user's scene stands a second one, the filter scene, whose engine is ours. A
Render Layers node of the filter scene in the user's compositor makes Blender run our
engine between rendering and compositing. The two scenes know each other by
scene.rack_focus.filter_scene and .source; what was changed is kept in .record.
"""

import json

import bpy

from . import compat

ENGINE = "RACK_FOCUS"
NODE_LABEL = "Rack Focus"

# ---- who belongs to whom ----------------------------------------------------------


def filter_scene_of(scene):
    """The filter scene of a scene, or None. A copied scene has none of its own yet."""
    ours = scene.rack_focus.filter_scene
    return ours if ours is not None and ours.rack_focus.source == scene else None


def user_scenes():
    """All scenes of the file itself but those that Rack Focus made."""
    scenes = [s for s in bpy.data.scenes if s.render.engine != ENGINE]
    scenes = [s for s in scenes if not s.rack_focus.is_views_copy]
    return [s for s in scenes if s.library is None]


def view_cameras(scene, camera):
    """The cameras that a multi-view render uses in the place of `camera`."""
    render = scene.render
    if not render.use_multiview or render.views_format != "MULTIVIEW":
        return [camera]
    return [view_camera(scene, camera, view) for view in render.views if view.use]


def view_camera(scene, camera, view):
    """The camera of a view: same name with the suffix of the view, else `camera`."""
    for other in scene.render.views:
        suffix = other.camera_suffix
        if suffix and camera.name.endswith(suffix):
            name = camera.name[: -len(suffix)] + view.camera_suffix
            return bpy.data.objects.get(name, camera)
    return bpy.data.objects.get(camera.name + view.camera_suffix, camera)


def cameras_of(scene):
    """All camera objects that a render of the scene may look through."""
    cameras = {scene.camera, *(marker.camera for marker in scene.timeline_markers)}
    found = set()
    for camera in cameras:
        if camera is not None and camera.type == "CAMERA":
            found.update(view_cameras(scene, camera))
    return found


def is_wanted(scene):
    """Is Rack Focus enabled for a camera of the scene?"""
    return any(camera.data.rack_focus.enabled for camera in cameras_of(scene))


# ---- nodes ------------------------------------------------------------------------


def layer_nodes(tree, scene):
    """Render Layers nodes of a scene; `scene` may be a filter scene."""
    return [n for n in tree.nodes if n.type == "R_LAYERS" and n.scene == scene]


def _with_groups(tree):
    """A tree and all node groups inside it, each once."""
    found = [tree]
    for one in found:
        inside = (node.node_tree for node in one.nodes if node.type == "GROUP")
        found += [group for group in inside if group and group not in found]
    return found


def linked_outputs(scene, layer_name):
    """Names of the sockets of our nodes for a view layer that lead somewhere."""
    tree, ours = compat.compositor_tree(scene), filter_scene_of(scene)
    return {
        output.name
        for one in (_with_groups(tree) if tree is not None else ())
        for node in layer_nodes(one, ours)
        if node.layer == layer_name
        for output in node.outputs
        if output.is_linked
    }


def trees_of(scene):
    """The compositor trees of a scene, those that are out of use too."""
    trees = [compat.compositor_tree(scene)]
    if not compat.HAS_NODE_GROUPS:
        trees.append(scene.node_tree)
    return list(dict.fromkeys(tree for tree in trees if tree is not None))


def add_node(tree, scene, layer_name):
    """A node of the filter scene for one view layer, without links."""
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene = filter_scene_of(scene)
    node.layer = layer_name
    node.label = NODE_LABEL
    return node


def move_links(tree, source, target):
    """Lets every link from `source` start at the same socket of `target` instead.

    Links from sockets that the target lacks are removed.
    """
    for link in list(tree.links):
        if link.from_node != source:
            continue
        end, name = link.to_socket, link.from_socket.name
        tree.links.remove(link)
        output = target.outputs.get(name)
        if output is not None and output.enabled:
            tree.links.new(output, end)


def take_over(tree, source, node):
    """Puts `node` between a Render Layers node and what follows it."""
    node.location = (source.location.x, source.location.y - source.height - 340)
    for link in list(tree.links):
        name = link.from_socket.name
        if link.from_node == source and name in ("Image", "Alpha"):
            end = link.to_socket
            tree.links.remove(link)
            tree.links.new(node.outputs[name], end)


def _put_over(tree, nodes, output):
    """Chains the pictures of several layers with Alpha Over; returns the new nodes."""
    made, below = [], nodes[0].outputs["Image"]
    for node in nodes[1:]:
        over, background, foreground = compat.alpha_over(tree)
        over.location = (node.location.x + 320, node.location.y)
        tree.links.new(below, background)
        tree.links.new(node.outputs["Image"], foreground)
        below = over.outputs[0]
        made.append(over)
    tree.links.new(below, output)
    return made


def _add_nodes(scene, tree, is_new):
    """Our node for every view layer in the tree; returns names of other new nodes."""
    used = [layer.name for layer in scene.view_layers if layer.use]
    helpers, ours = [], []
    # Blender renders the scenes that nodes of the tree itself look at; those in groups
    # then show them too.
    for one in _with_groups(tree):
        for source in layer_nodes(one, scene):
            node = add_node(one, scene, source.layer)
            take_over(one, source, node)
            if one == tree:
                ours.append(node)
    if not ours and used:
        ours.append(add_node(tree, scene, used[0]))
        output = compat.output_socket(tree)
        if output is not None and not output.is_linked:
            tree.links.new(ours[0].outputs["Image"], output)
    if is_new and len(used) > 1 and scene.render.film_transparent:
        for name in used[1:]:
            node = add_node(tree, scene, name)
            node.location = (0, ours[-1].location.y - 300)
            ours.append(node)
        helpers = _put_over(tree, ours, compat.output_socket(tree))
    return [node.name for node in helpers]


def _remove_nodes(scene, record):
    """Takes our nodes out of every tree of the scene and closes the gaps."""
    for tree in trees_of(scene):
        for one in _with_groups(tree):
            sources = {node.layer: node for node in layer_nodes(one, scene)}
            for node in layer_nodes(one, filter_scene_of(scene)):
                source = sources.get(node.layer)
                if source is not None:
                    move_links(one, node, source)
                one.nodes.remove(node)
        sources = {node.layer: node for node in layer_nodes(tree, scene)}
        helpers = [tree.nodes.get(name) for name in record["helpers"]]
        for node in filter(None, helpers):
            tree.nodes.remove(node)
        output = compat.output_socket(tree)
        if record["helpers"] and output is not None and not output.is_linked:
            for source in list(sources.values())[:1]:
                tree.links.new(source.outputs["Image"], output)


def _node_names(tree):
    return sorted(node.name for node in tree.nodes)


# ---- on and off -------------------------------------------------------------------


def _adopt(scene, foreign):
    """Lets the nodes of a copied scene, copied too, look at the copy's own scenes.

    foreign: the filter scene of the scene that this one was copied from.
    """
    sync(scene)
    new_scenes = {foreign: filter_scene_of(scene), foreign.rack_focus.source: scene}
    tree = compat.own_tree(scene)
    for node in tree.nodes if tree is not None else ():
        if node.type == "R_LAYERS" and node.scene in new_scenes:
            layer = node.layer
            node.scene = new_scenes[node.scene]
            node.layer = layer


def enable(scene):
    """Makes the filter scene, switches on the Z passes, puts the nodes in."""
    if filter_scene_of(scene) is not None:
        return
    foreign = scene.rack_focus.filter_scene
    ours = bpy.data.scenes.new(f"{scene.name} Rack Focus")
    ours.render.engine = ENGINE
    ours.rack_focus.source = scene
    scene.rack_focus.filter_scene = ours
    if foreign is not None and scene.rack_focus.record:
        _adopt(scene, foreign)
        return
    record = {"z": [], "was_compositing": scene.render.use_compositing}
    for layer in scene.view_layers:
        if not layer.use_pass_z:
            layer.use_pass_z = True
            record["z"].append(layer.name)
    sync(scene)
    record["was_in_use"] = compat.compositor_tree(scene) is not None
    tree, record["is_new"] = compat.start_compositor(scene)
    record["nodes"] = _node_names(tree)
    record["helpers"] = _add_nodes(scene, tree, record["is_new"])
    scene.render.use_compositing = True
    scene.rack_focus.record = json.dumps(record)


def disable(scene):
    """Takes away what enable() made; what the user made since stays."""
    ours = filter_scene_of(scene)
    if ours is None:
        return
    record = json.loads(scene.rack_focus.record)
    _remove_nodes(scene, record)
    for layer in scene.view_layers:
        if layer.name in record["z"]:
            layer.use_pass_z = False
    tree = compat.compositor_tree(scene)
    is_untouched = tree is not None and _node_names(tree) == record["nodes"]
    if is_untouched and not record["was_in_use"]:
        compat.stop_compositor(scene, record["is_new"])
        scene.render.use_compositing = record["was_compositing"]
    scene.rack_focus.filter_scene = None
    scene.rack_focus.record = ""
    show_dof(scene)
    unmute_sources(scene)
    bpy.data.scenes.remove(ours)


def refresh(scene):
    """Brings the set-up of one scene in line with its cameras; was it out of line?"""
    is_there = filter_scene_of(scene) is not None
    if is_wanted(scene) == is_there:
        return False
    if is_there:
        disable(scene)
    else:
        enable(scene)
    return True


def settle(scene):
    """Brings what Blender keeps of relations between datablocks up to date.

    5.2 crashes when a render begins while they are not, and a render may be what comes
    next. An empty scene's update is enough.
    """
    ours = filter_scene_of(scene)
    if ours is not None:
        ours.view_layers[0].update()


def camera_changed(data):
    """Called when `enabled` of a camera changes."""
    for scene in user_scenes():
        if any(camera.data == data for camera in cameras_of(scene)):
            refresh(scene)


def remove_orphans():
    """Removes filter scenes whose own scene is gone."""
    for scene in list(bpy.data.scenes):
        if scene.render.engine == ENGINE and scene.rack_focus.source is None:
            compat.remove_scene(scene)


def disable_everywhere():
    """Takes the set-up out of all scenes, for the end of the add-on."""
    for scene in user_scenes():
        disable(scene)
    remove_orphans()


# ---- keeping up -------------------------------------------------------------------

RENDER_SETTINGS = (
    "resolution_x",
    "resolution_y",
    "resolution_percentage",
    "pixel_aspect_x",
    "pixel_aspect_y",
    "use_border",
    "use_crop_to_border",
    "border_min_x",
    "border_max_x",
    "border_min_y",
    "border_max_y",
    "film_transparent",
    "use_multiview",
    "views_format",
    "frame_map_old",
    "frame_map_new",
)
VIEW_SETTINGS = ("name", "use", "camera_suffix", "file_suffix")


def _set_if_other(target, name, value):
    if getattr(target, name) != value:
        setattr(target, name, value)


def _sync_cameras(scene, ours):
    _set_if_other(ours, "camera", scene.camera)
    bound = [(m.frame, m.camera) for m in scene.timeline_markers if m.camera]
    if [(m.frame, m.camera) for m in ours.timeline_markers] == bound:
        return
    ours.timeline_markers.clear()
    for frame, camera in bound:
        ours.timeline_markers.new("camera", frame=frame).camera = camera


def _sync_views(source, target):
    """Makes the list of stereo views the same."""
    while len(target.views) > max(len(source.views), 2):
        target.views.remove(target.views[-1])
    for index, view in enumerate(source.views):
        if index >= len(target.views):
            target.views.new(view.name)
        for name in VIEW_SETTINGS:
            _set_if_other(target.views[index], name, getattr(view, name))


def _need_depth(scene):
    """Switches the Z pass on where it is off, and notes it."""
    record = json.loads(scene.rack_focus.record or "{}")
    missing = [layer for layer in scene.view_layers if not layer.use_pass_z]
    if not record or not missing:
        return
    for layer in missing:
        layer.use_pass_z = True
        record["z"] = [*record["z"], layer.name]
    scene.rack_focus.record = json.dumps(record)


def _sync_layers(scene, ours):
    while len(ours.view_layers) < len(scene.view_layers):
        ours.view_layers.new("layer")
    while len(ours.view_layers) > len(scene.view_layers):
        ours.view_layers.remove(ours.view_layers[-1])
    for source, target in zip(scene.view_layers, ours.view_layers, strict=True):
        _set_if_other(target, "name", source.name)
        _set_if_other(target, "use", source.use)
        _set_if_other(target, "use_pass_z", False)


def sync(scene):
    """Copies to the filter scene what it must have in common with its source."""
    ours = filter_scene_of(scene)
    if ours is None:
        return
    for name in RENDER_SETTINGS:
        _set_if_other(ours.render, name, getattr(scene.render, name))
    _sync_views(scene.render, ours.render)
    _sync_cameras(scene, ours)
    _sync_layers(scene, ours)
    _need_depth(scene)
    _set_if_other(ours.render, "use_compositing", False)
    _set_if_other(ours.render, "use_sequencer", False)


# ---- compositing without rendering ------------------------------------------------


def _source_nodes(scene):
    """Render Layers nodes of the scene itself that are not muted by the user."""
    tree = compat.compositor_tree(scene)
    nodes = layer_nodes(tree, scene) if tree is not None else []
    return [node for node in nodes if not node.mute]


def can_mute_sources(scene):
    """Is the scene's own render seen only through ours?"""
    outputs = [o for node in _source_nodes(scene) for o in node.outputs]
    return not any(output.is_linked for output in outputs)


def mute_sources(scene):
    """Mutes the scene's own nodes: Blender then composites without rendering it."""
    nodes = _source_nodes(scene)
    scene.rack_focus.muted = json.dumps([node.name for node in nodes])
    for node in nodes:
        node.mute = True


def unmute_sources(scene):
    """Undoes mute_sources()."""
    tree = compat.compositor_tree(scene)
    for name in json.loads(scene.rack_focus.muted or "[]"):
        if tree is not None and name in tree.nodes:
            tree.nodes[name].mute = False
    if scene.rack_focus.muted:
        scene.rack_focus.muted = ""


# ---- the camera's own depth of field ----------------------------------------------


def hide_dof(scene):
    """Switches the cameras' own depth of field off while the scene renders."""
    for camera in cameras_of(scene):
        settings, dof = camera.data.rack_focus, camera.data.dof
        if settings.enabled and dof.use_dof:
            settings.is_dof_hidden = True
            dof.use_dof = False


def show_dof(scene=None):
    """Switches it on again; without a scene for all cameras of the file."""
    if scene is None:
        cameras = bpy.data.cameras
    else:
        cameras = {camera.data for camera in cameras_of(scene)}
    for data in cameras:
        if data.rack_focus.is_dof_hidden:
            data.dof.use_dof = True
            data.rack_focus.is_dof_hidden = False
