# SPDX-License-Identifier: GPL-3.0-or-later
"""Setting a scene up for Rack Focus, and taking exactly that away again.

Beside the user's scene stands a second one, the filter scene, whose engine is ours. A
Render Layers node of the filter scene in the user's compositor makes Blender run our
engine between rendering and compositing. The two scenes know each other by
scene.rack_focus.filter_scene and .source; what was changed is kept in .record.
"""

import json

import bpy

from . import (
    asleep,
    camera_objects,
    compat,
    driven,
    freestyle,
    group,
    inserted,
    keyed,
    layout,
    library,
    links,
    mirrors,
    passes,
    shares,
    sharp,
)
from .writing import set_if_other

ENGINE = "RACK_FOCUS"
NODE_LABEL = "Rack Focus"
BEFORE = "rack_focus_before"  # of our nodes: the Render Layers node they took over from
OUTPUTS = ("COMPOSITE", "GROUP_OUTPUT")  # types of nodes
CALLER_LABEL = "Rack Focus: runs the nodes"
NO_RENDERER = (
    "the engine “Rack Focus” renders nothing by itself: choose Cycles or EEVEE under "
    "Render > Render Engine, and tick Rack Focus in the camera's Depth of Field"
)
TICK_AGAIN = "untick Rack Focus and tick it again"
NO_COMPOSITOR = f"the compositor is switched off (switch it on, or {TICK_AGAIN})"
RECORD_VERSION = 2  # 1: nodes of a new tree might look at another scene; see heal()

# ---- who belongs to whom ----------------------------------------------------------


def filter_scene_of(scene):
    """The filter scene of a scene, or None. A copied scene has none of its own yet."""
    ours = scene.rack_focus.filter_scene
    return ours if ours is not None and ours.rack_focus.source == scene else None


def is_filter_scene(scene):
    """Did Rack Focus make a scene to filter another one, which may be gone?

    The engine does not tell: artists may choose it for scenes of their own.
    """
    if scene.rack_focus.source is not None:
        return True
    if scene.render.engine != ENGINE or NODE_LABEL not in scene.name:
        return False
    has_content = scene.collection.children or scene.world or scene.sequence_editor
    return not has_content and all(o.type == "CAMERA" for o in scene.objects)


def user_scenes():
    """All scenes of the file itself but those that Rack Focus made."""
    scenes = [s for s in bpy.data.scenes if not is_filter_scene(s)]
    scenes = [s for s in scenes if not s.rack_focus.is_views_copy]
    scenes = [s for s in scenes if not s.rack_focus.is_tap]
    return [s for s in scenes if s.library is None]


def is_wanted(scene):
    """Is Rack Focus enabled for a camera of the scene, or has it nodes of ours?"""
    if keyed.ticked(camera_objects.cameras_of(scene)):
        return True
    return any(inserted.INSERTED not in node for node in group.nodes_of(scene))


# ---- nodes ------------------------------------------------------------------------


def layer_nodes(tree, scene):
    """Render Layers nodes of a scene, which may be a filter scene; none that sleeps."""
    nodes = [n for n in tree.nodes if n.type == "R_LAYERS" and not asleep.is_asleep(n)]
    return [n for n in nodes if n.scene == scene]


MATTE_NODE = "CompositorNodeCryptomatteV2"  # whose type 4.4 alone calls CRYPTOMATTE


def matte_nodes(tree, scene):
    """Cryptomatte nodes that read the render of a scene; none that sleeps."""
    found = [n for n in tree.nodes if n.bl_idname == MATTE_NODE]
    found = [n for n in found if n.source == "RENDER" and n.scene == scene]
    return [node for node in found if not asleep.is_asleep(node)]


def with_groups(tree):
    """A tree and all node groups inside it, each once."""
    found = [tree]
    for one in found:
        groups = (n for n in one.nodes if n.type == "GROUP" and not asleep.is_asleep(n))
        inside = (node.node_tree for node in groups)
        found += [group for group in inside if group and group not in found]
    return found


def linked_outputs(scene, layer_name):
    """Names of the sockets of our nodes for a view layer that lead somewhere."""
    tree, ours = compat.compositor_tree(scene), filter_scene_of(scene)
    return {
        output.name
        for one in (with_groups(tree) if tree is not None else ())
        for node in layer_nodes(one, ours)
        if node.layer == layer_name
        for output in node.outputs
        if output.is_linked
    }


def is_shown(scene, layer_name):
    """Does a node of any scene's tree show what is filtered of a view layer?

    In 5.x scenes share trees: that of another scene may have a node of ours that leads
    nowhere, while its own scene is not rendered.
    """
    ours, found = filter_scene_of(scene), []
    for one in user_scenes():
        for tree in all_trees_of(one):
            nodes = [n for n in layer_nodes(tree, ours) if n.layer == layer_name]
            found += [output for node in nodes for output in node.outputs]
    return any(output.is_linked for output in found)


def is_used(scene):
    """Do nodes show anything that is filtered of a scene?"""
    if group.nodes_of(scene):
        return True
    layers = filter_scene_of(scene).view_layers  # whose names nodes know
    return any(is_shown(scene, layer.name) for layer in layers)


def trees_of(scene):
    """The compositor trees of a scene, those that are out of use too."""
    trees = [compat.compositor_tree(scene)]
    if not compat.HAS_NODE_GROUPS:
        trees.append(scene.node_tree)
    return list(dict.fromkeys(tree for tree in trees if tree is not None))


def all_trees_of(scene):
    """The same with the groups inside them."""
    trees = [one for tree in trees_of(scene) for one in with_groups(tree)]
    return list(dict.fromkeys(trees))


def add_node(tree, scene, layer_name):
    """A node of the filter scene for one view layer, without links."""
    node = compat.new_layer_node(tree, filter_scene_of(scene))
    node.layer = layer_name
    node.label = NODE_LABEL
    return node


def take_over(tree, source, node):
    """Puts `node` between a Render Layers node and what follows it."""
    layout.put_below(tree, node, source)
    node[BEFORE] = source.name
    for link in list(tree.links):
        name = link.from_socket.name
        if link.from_node == source and name in ("Image", "Alpha"):
            end = link.to_socket
            tree.links.remove(link)
            tree.links.new(node.outputs[name], end)


def put_behind(scene, tree, before, node):
    """Puts a node with sockets between another one's picture and what follows it."""
    if before.type == "R_LAYERS" and before.scene == filter_scene_of(scene):
        own = [n for n in layer_nodes(tree, scene) if n.layer == before.layer]
        if own:
            links.move_links(tree, before, own[0])
            before = own[0]
    pictures = [s for s in before.outputs if s.enabled and s.type == "RGBA"]
    if not pictures:
        return
    for link in [k for k in tree.links if k.from_socket == pictures[0]]:
        tree.links.new(node.outputs["Image"], link.to_socket)
    tree.links.new(pictures[0], node.inputs["Image"])
    layout.put_below(tree, node, before)


def unblur_before(scene, tree, node):
    """Our layer nodes that a node comes from hand over to the scene's own."""
    before = group.upstream(tree, node)
    for ours in layer_nodes(tree, filter_scene_of(scene)) if before else ():
        own = [n for n in layer_nodes(tree, scene) if n.layer == ours.layer]
        if ours in before and own:
            links.move_links(tree, ours, own[0])


def _add_caller(scene, tree, used):
    node = add_node(tree, scene, used[0])
    node.label = CALLER_LABEL
    node.hide = True
    layout.put_below(tree, node, next(iter(group.nodes_of(scene)), tree.nodes[0]))
    return node


def _lead_past(scene, tree, used):
    """Leads the picture past nodes that sleep to an output; returns names of new nodes.

    used: names of the view layers that are rendered.
    """
    if not any(map(asleep.is_asleep, tree.nodes)):
        return []
    source, output = compat.new_layer_node(tree, scene), compat.output_socket(tree)
    source.scene, source.layer = scene, used[0]
    layout.put_below(tree, source, output.node)
    tree.links.new(source.outputs["Image"], output)
    return [source.name]


def _add_nodes(scene, tree, is_new):
    """Our node for every view layer in the tree; returns names of other new nodes."""
    if compat.is_linked(tree):
        return []
    used = [layer.name for layer in scene.view_layers if layer.use]
    used = used or [scene.view_layers[0].name]  # _follow_use() then takes another
    ours, others = [], []
    helpers = [node.name for node in compat.complete_nodes(tree, scene)]
    helpers += _lead_past(scene, tree, used)
    is_alone = bool(helpers)  # does no node of the artist's lead to the output?
    for source in layer_nodes(tree, scene):
        is_made = is_new or source.name in helpers
        if is_made and source.layer not in used:  # it shows the first layer of all
            source.layer = used[0]
    for source in layer_nodes(tree, scene):
        inserted.follow_denoisers(tree, source)
    if group.nodes_of(scene):  # they filter; a node without links lets Blender call us
        _add_caller(scene, tree, used)
        return helpers
    # Blender renders the scenes that nodes of the tree itself look at; those in groups
    # then show them too.
    for one in with_groups(tree):
        for source in layer_nodes(one, scene):
            node = add_node(one, scene, source.layer)
            take_over(one, source, node)
            if one == tree:
                ours.append(node)
    if not ours:
        ours.append(add_node(tree, scene, used[0]))
        is_alone = True
    output = compat.output_socket(tree)
    if is_alone and not output.is_linked:
        tree.links.new(ours[0].outputs["Image"], output)
    if is_new and len(used) > 1 and scene.render.film_transparent:
        for name in used[1:]:
            node = add_node(tree, scene, name)
            layout.put_below(tree, node, ours[-1])
            ours.append(node)
        others = links.put_over(tree, ours, output)
    for end in [e for e in asleep.outputs(tree) if not e.is_linked]:
        tree.links.new(output.links[0].from_socket, end)
    return helpers + [node.name for node in others]


def _remove_nodes(scene, record):
    """Takes our nodes out of every tree of the scene and closes the gaps."""
    for tree in trees_of(scene):
        inserted.remove(tree)
        for one in with_groups(tree):
            sources = layer_nodes(one, scene)
            for node in layer_nodes(one, filter_scene_of(scene)):
                alike = [s for s in sources if s.layer == node.layer]
                before = [s for s in sources if s.name == node.get(BEFORE)]
                both = [s for s in before if s in alike]
                source = next(iter(both or alike or before), None)
                if source is not None:
                    links.move_links(one, node, source)
                one.nodes.remove(node)
        helpers = [tree.nodes.get(name) for name in record["helpers"]]
        for node in filter(None, helpers):
            tree.nodes.remove(node)
        sources = {node.layer: node for node in layer_nodes(tree, scene)}
        output = compat.output_socket(tree)
        if record["helpers"] and output is not None and not output.is_linked:
            for source in list(sources.values())[:1]:
                tree.links.new(source.outputs["Image"], output)


def _node_names(tree):
    """Of all but the outputs, which another version of Blender replaces by its own."""
    return sorted(node.name for node in tree.nodes if node.type not in OUTPUTS)


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


def _take_lost(scene):
    """Gives our nodes a new filter scene after the old one was deleted; were there any?"""
    lost = [
        (tree, node)
        for tree in all_trees_of(scene)
        for node in layer_nodes(tree, None)
        if BEFORE in node or node.label in (NODE_LABEL, CALLER_LABEL)
    ]
    if not lost:
        return False
    sync(scene)
    for tree, node in lost:
        source = tree.nodes.get(node.get(BEFORE, ""))
        node.scene = filter_scene_of(scene)
        node.layer = source.layer if source is not None else scene.view_layers[0].name
    return True


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
    if scene.rack_focus.record and _take_lost(scene):
        return
    record = {"z": [], "was_compositing": scene.render.use_compositing}
    record["version"] = RECORD_VERSION
    for layer in scene.view_layers:
        if not layer.use_pass_z:
            layer.use_pass_z = True
            record["z"].append(layer.name)
    sync(scene)
    record["was_in_use"] = compat.compositor_tree(scene) is not None
    record["was_off"] = asleep.is_off(scene) and not group.nodes_of(scene)
    if record["was_off"]:
        asleep.begin(scene)
    tree, record["is_new"] = compat.start_compositor(scene)
    record["nodes"] = _node_names(tree)
    is_ours = record["is_new"] or record["was_off"]
    record["helpers"] = _add_nodes(scene, tree, is_ours)
    record["was_linked"] = compat.is_linked(tree)
    scene.render.use_compositing = True
    scene.rack_focus.record = json.dumps(record)


def disable(scene):
    """Takes away what enable() made; what the user made since stays."""
    ours = filter_scene_of(scene)
    if ours is None:
        return
    _sync_layers(scene, ours)
    record = json.loads(scene.rack_focus.record)
    _remove_nodes(scene, record)
    for layer in scene.view_layers:
        if layer.name in record["z"]:
            layer.use_pass_z = False
    sharp.SWITCH.drop(scene, record)
    mirrors.drop_passes(scene, record)
    shares.SWITCH.drop(scene, record)
    freestyle.SWITCH.drop(scene, record)
    tree = compat.compositor_tree(scene)
    is_untouched = tree is not None and _node_names(tree) == record["nodes"]
    was_off = record.get("was_off", False)
    if was_off:
        asleep.end(scene, is_untouched)
        if not compat.HAS_NODE_GROUPS:
            scene.use_nodes = record["was_in_use"]
    elif is_untouched and not record["was_in_use"]:
        compat.stop_compositor(scene, record["is_new"])
    if (was_off or is_untouched) and not record["was_compositing"]:
        scene.render.use_compositing = False
    scene.rack_focus.filter_scene = None
    scene.rack_focus.record = ""
    unmute_sources(scene)
    for camera in list(ours.collection.objects):
        ours.collection.objects.unlink(camera)
    compat.remove_scene(ours)
    group.remove_unused()


def has_sleepers(scene):
    """Has a scene nodes that were switched off and stay out of the picture?"""
    return json.loads(scene.rack_focus.record or "{}").get("was_off", False)


def heal(scene):
    """Mends the nodes that a version before 2 left looking at another scene."""
    ours, record = filter_scene_of(scene), json.loads(scene.rack_focus.record or "{}")
    if ours is None or record.get("version", 1) >= RECORD_VERSION:
        return
    tree = compat.compositor_tree(scene)
    strangers = {s for s in user_scenes() if s != scene}
    for name in record.get("nodes", ()) if record.get("is_new") else ():
        source = tree.nodes.get(name) if tree is not None else None
        filters = [n for n in layer_nodes(tree, ours)] if source is not None else []
        if source is None or source.type != "R_LAYERS" or not filters:
            continue
        if source.scene in strangers:
            source.scene = scene
            take_over(tree, source, filters[0])
    record["version"] = RECORD_VERSION
    scene.rack_focus.record = json.dumps(record)


def refresh(scene):
    """Brings the set-up of one scene in line with its cameras; was it out of line?"""
    is_there, is_asked = filter_scene_of(scene) is not None, is_wanted(scene)
    is_late = is_there and is_asked and _is_local_now(scene)
    if is_there == is_asked and not is_late:
        return False
    if is_there:
        disable(scene)
    if is_asked:
        enable(scene)
    return True


def _is_local_now(scene):
    """Was the compositor's group linked when our nodes should have come into it?"""
    tree = compat.compositor_tree(scene)
    is_linked = tree is not None and compat.is_linked(tree)
    record = json.loads(scene.rack_focus.record or "{}")
    return record.get("was_linked", False) and not is_linked


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
        if any(camera.data == data for camera in camera_objects.cameras_of(scene)):
            refresh(scene)


def remove_orphans():
    """Removes filter scenes whose own scene is gone; Blender keeps the last scene."""
    for scene in list(bpy.data.scenes):
        is_ours = is_filter_scene(scene) and not scene.rack_focus.is_tap
        is_last = sum(other.library is None for other in bpy.data.scenes) < 2
        if is_ours and scene.rack_focus.source is None and not is_last:
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
    "fps",  # Geometry Nodes know seconds; cameras and what they focus on may hang on them
    "fps_base",
)
MOST_OF_NAME = 48  # characters; Blender cuts names at 63 bytes and may add .001
VIEW_SETTINGS = ("name", "use", "camera_suffix", "file_suffix")


def _sync_cameras(scene, ours):
    shown = camera_objects.camera_of_strip(scene)
    set_if_other(ours, "camera", shown or scene.camera)
    markers = scene.timeline_markers if shown is None else ()
    bound = [(m.frame, m.camera) for m in markers if m.camera]
    if [(m.frame, m.camera) for m in ours.timeline_markers] == bound:
        return
    ours.timeline_markers.clear()
    for frame, camera in bound:
        ours.timeline_markers.new("camera", frame=frame).camera = camera


def follow_subframe(scene, ours):
    """Lets the filter scene stand between frames where its source does.

    Blender gives it the whole number alone, in animations neither.
    """
    if ours.frame_subframe != scene.frame_subframe:
        ours.frame_float = scene.frame_float


def _sync_views(source, target):
    """Makes the list of stereo views the same."""
    while len(target.views) > max(len(source.views), 2):
        target.views.remove(target.views[-1])
    for index, view in enumerate(source.views):
        if index >= len(target.views):
            target.views.new(view.name)
        for name in VIEW_SETTINGS:
            set_if_other(target.views[index], name, getattr(view, name))


def _follow_use(scene, ours):
    """Lets nodes that are all ours show view layers that are rendered, where none does.

    Blender without nodes shows the first one that is.
    """
    tree, record = compat.compositor_tree(scene), json.loads(
        scene.rack_focus.record or "{}"
    )
    if tree is None or not record:
        return
    filters, used = layer_nodes(tree, ours), [
        one.name for one in scene.view_layers if one.use
    ]
    made = {*(node.name for node in filters), *record["helpers"]}
    others = [name for name in _node_names(tree) if name not in made]
    are_ours = record["is_new"] or record.get("was_off") or not record["nodes"]
    shown = [node.layer for node in filters]
    if not are_ours or others != record["nodes"] or {*shown} & {*used}:
        return
    new_layers = dict(zip(dict.fromkeys(shown), used, strict=False))
    for node in [*filters, *layer_nodes(tree, scene)]:
        node.layer = new_layers.get(node.layer, node.layer)


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


def _drop_layers(names, ours):
    """Removes layers of the filter scene whose own layer was removed.

    names: of the scene's layers. One that has another name at the same place was renamed.
    Nodes keep the number of their layer, which Blender counts down with each removal: to
    remove another one would give our nodes the layers of others.
    """
    at = 0
    while at < len(ours.view_layers):
        layer = ours.view_layers[at]
        behind = [other.name for other in ours.view_layers[at + 1 :]]
        is_next = at < len(names) and names[at] in behind
        if layer.name not in names and (is_next or at >= len(names)):
            ours.view_layers.remove(layer)
        else:
            at += 1
    while len(ours.view_layers) > len(names):
        ours.view_layers.remove(ours.view_layers[-1])


def _rename_in_record(scene, new_names):
    """Lets what was noted of layers follow them; new_names: {old: new}."""
    record = json.loads(scene.rack_focus.record or "{}")
    for key in ("z", sharp.SWITCH.key, shares.SWITCH.key, freestyle.SWITCH.key):
        if key in record:
            record[key] = [new_names.get(name, name) for name in record[key]]
    if mirrors.RECORD in record:
        about = record[mirrors.RECORD].items()
        record[mirrors.RECORD] = {new_names.get(k, k): value for k, value in about}
    if record:
        scene.rack_focus.record = json.dumps(record)


def _sync_layers(scene, ours):
    _drop_layers([layer.name for layer in scene.view_layers], ours)
    n_known = len(ours.view_layers)
    while len(ours.view_layers) < len(scene.view_layers):
        ours.view_layers.new("layer")
    pairs = list(zip(scene.view_layers, ours.view_layers, strict=True))
    new_names = {b.name: a.name for a, b in pairs[:n_known] if a.name != b.name}
    for _, target in pairs if new_names else ():
        target.name = f"{NODE_LABEL} layer"  # else Blender numbers a name that is taken
    if new_names:
        passes.rename_layers(scene, new_names)
        _rename_in_record(scene, new_names)
    for source, target in pairs:
        set_if_other(target, "name", source.name)
        set_if_other(target, "use", source.use)
        set_if_other(target, "use_pass_z", False)


def _sync_lenses(scene, ours):
    """The cameras that nodes take their lens from, so that they are evaluated."""
    wanted = {group.camera_of(scene, node) for node in group.nodes_of(scene)}
    wanted -= {None, scene.camera}
    for camera in [o for o in ours.collection.objects if o not in wanted]:
        ours.collection.objects.unlink(camera)
    for camera in wanted - set(ours.collection.objects):
        ours.collection.objects.link(camera)


def sync(scene):
    """Copies to the filter scene what it must have in common with its source."""
    ours = filter_scene_of(scene)
    if ours is None:
        return
    for name in RENDER_SETTINGS:
        set_if_other(ours.render, name, getattr(scene.render, name))
    set_if_other(ours.render, "engine", ENGINE)
    set_if_other(ours, "active_clip", scene.active_clip)  # solved cameras follow it
    follow_subframe(scene, ours)
    _sync_views(scene.render, ours.render)
    _sync_cameras(scene, ours)
    _sync_layers(scene, ours)
    _follow_use(scene, ours)
    _sync_lenses(scene, ours)
    driven.follow(camera_objects.cameras_of(scene), scene, ours)
    _need_depth(scene)
    set_if_other(ours.render, "use_compositing", False)
    set_if_other(ours.render, "use_sequencer", False)
    name = f"{scene.name} {NODE_LABEL}"
    if not ours.name.startswith(name[:MOST_OF_NAME]):
        ours.name = name


# ---- compositing without rendering ------------------------------------------------


def source_nodes(tree, scene):
    """Nodes that read the scene's own render and are not muted by the user."""
    nodes = [*layer_nodes(tree, scene), *matte_nodes(tree, scene)]
    return [node for node in nodes if not node.mute]


def mattes_in_groups(tree, scene):
    """Cryptomatte nodes in groups of a tree that read the render of a scene."""
    groups = with_groups(tree)[1:]
    found = [node for one in groups for node in matte_nodes(one, scene)]
    return [node for node in found if not node.mute]


def has_mattes(scene):
    """Do Cryptomatte nodes of the scene's compositor read its own render?"""
    tree = compat.compositor_tree(scene)
    if tree is None:
        return False
    return bool(matte_nodes(tree, scene) or mattes_in_groups(tree, scene))


def can_mute_sources(scene):
    """Is the scene's own render seen only through ours?"""
    tree = compat.compositor_tree(scene)
    if tree is None:
        return True
    if mattes_in_groups(tree, scene):
        return False
    return group.ends_at_groups(tree, source_nodes(tree, scene))


def mute_sources(scene):
    """Mutes the scene's own nodes: Blender then composites without rendering it."""
    tree = compat.compositor_tree(scene)
    nodes = source_nodes(tree, scene) if tree is not None else []
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


# ---- is there an effect ------------------------------------------------------------


def need_source(scene):
    """Adds the scene's own Render Layers node where the artist deleted or muted it.

    Blender would not render the scene without; nor ours, if groups alone show that (5.x).
    """
    tree, ours = compat.compositor_tree(scene), filter_scene_of(scene)
    filters = layer_nodes(tree, ours) if tree is not None else []
    others = with_groups(tree)[1:] if tree is not None and not filters else []
    inside = [node.layer for one in others for node in layer_nodes(one, ours)]
    if inside:
        filters = [_add_caller(scene, tree, inside)]
    has_plates = all(node.inputs["Depth"].is_linked for node in group.nodes_of(scene))
    is_shown = inside or any(o.is_linked for node in filters for o in node.outputs)
    if not is_shown and has_plates:
        return
    if filters and all(node.mute for node in layer_nodes(tree, scene)):
        node = compat.new_layer_node(tree, ours)
        node.scene, node.layer = scene, filters[0].layer
        layout.put_below(tree, node, filters[0])


def is_filtered(scene):
    """Is the scene set up, with a compositor that leads through our nodes?"""
    return filter_scene_of(scene) is not None and not why_not(scene)


def why_not(scene):
    """Why the set-up of a scene has no effect, in the artist's words; "" if it has."""
    if library.is_stale:
        return library.RESTART
    if scene.library is not None:
        return (
            f"the scene is linked from “{bpy.path.basename(scene.library.filepath)}” "
            "(append it, or render that file)"
        )
    if scene.render.engine == ENGINE:
        return NO_RENDERER
    if not scene.render.use_compositing:
        return "Output > Post Processing > Compositing is off (switch it on)"
    if scene.render.use_single_layer:  # Blender then renders no scene of a node
        return (
            "View Layer > Render Single Layer is on: switch it off, and Use for "
            "Rendering for other layers"
        )
    tree, ours = compat.compositor_tree(scene), filter_scene_of(scene)
    if tree is None:
        return NO_COMPOSITOR
    if compat.is_linked(tree):
        return (
            f"the compositor's group “{tree.name}” is linked from another file: click the "
            "chain beside its name in the compositor, which makes it local"
        )
    if not compat.is_shown(tree):
        return (
            "the compositor's first output is no colour, and Blender shows the plain "
            "render: move the picture's output to the top, in the sidebar under Group"
        )
    trees = with_groups(tree)
    nodes = [n for one in trees for n in layer_nodes(one, ours)]
    if all(node.mute for node in nodes):
        return (
            f"the compositor has no active Rack Focus node (unmute it, or {TICK_AGAIN})"
        )
    unknown = [name for one in trees for name in compat.unknown_nodes(one)]
    if unknown and compat.UNKNOWN_NODES_STOP:
        return (
            f"the compositor composites nothing, since this Blender does not know its "
            f"node “{unknown[0]}”: delete that"
        )
    return ""


def is_composited(scene, names):
    """Does one of the scenes that are rendered show what is filtered of `scene`?

    names: of those scenes, a set that threads share. Blender renders the others that
    their nodes show, whose own nodes then count for nothing.
    """
    ours, rendered = filter_scene_of(scene), map(bpy.data.scenes.get, tuple(names))
    trees = [tree for one in filter(None, rendered) for tree in all_trees_of(one)]
    return any(layer_nodes(tree, ours) for tree in trees)
