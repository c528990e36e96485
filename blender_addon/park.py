# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that render sharp, not black, where the add-on is missing or our nodes are muted.

Without the add-on nobody renders the filter scene: its nodes are black (or Blender
starts EEVEE for it). So a file is written with what follows our nodes linked to the
scene's own Render Layers node, and ours muted. Once written, or opened where the add-on
is, the links are ours again. What is undone stands in the nodes themselves.
"""

import json

import bpy

from . import compat, group, layout, library, preferences, setup

PARKED = "rack_focus_parked"  # of our nodes: what restore() needs, as JSON
STAND_IN = "rack_focus_stand_in"  # of the scene's nodes that only a written file has
LABEL = "Rack Focus: add-on missing, sharp picture"
INSTEAD = {"Image": "Image", "Alpha": "Alpha", "Depth": "Depth", "Focus": "Image"}
NOTICE = "Rack Focus notice.py"
NOTICE_TEXT = """# Says in the console that the add-on Rack Focus is missing.
import sys
import bpy
if not hasattr(bpy.types.Scene, "rack_focus"):
    print("Rack Focus: this file has depth of field made by the add-on Rack Focus, "
          "which is not enabled here: the picture stays sharp", file=sys.stderr)
"""

_shown = {}  # name of a group: did it show filtered images before the file was written?


def _stand_in(tree, scene, node):
    """A Render Layers node of the scene itself for the layer of one of ours."""
    for source in setup.layer_nodes(tree, scene):
        if source.layer == node.layer and not source.mute:
            return source
    source = compat.new_layer_node(tree, node.scene)
    source.scene = scene
    source.layer = node.layer
    source[STAND_IN] = True
    layout.put_below(tree, source, node)
    return source


def _park_node(tree, scene, node, is_led_past):
    links = [k for k in tree.links if k.from_node == node]
    links = [k for k in links if k.from_socket.name in INSTEAD]
    source = _stand_in(tree, scene, node) if links and is_led_past else None
    about = {"mute": node.mute, "label": node.label, "links": []}
    for link in links if source is not None else ():
        name, end = link.from_socket.name, link.to_socket
        output = source.outputs.get(INSTEAD[name])
        if output is None or not output.enabled:
            continue
        index = list(link.to_node.inputs).index(end)
        about["links"].append([name, link.to_node.name, index, end.identifier])
        tree.links.remove(link)
        tree.links.new(output, end)
    about["source"] = source.name if source is not None else ""
    node.mute = True
    node[PARKED] = json.dumps(about)


def _is_black(scene):
    """Would all nodes of ours be black, or wrong, in a render?"""
    return scene.render.use_single_layer or library.is_stale


def lead_past(scene):
    """Links what follows nodes of ours that are black to the scene's own, for a render.

    Blender gives black for a muted Render Layers node, and for those of other scenes
    with Render Single Layer. restore() undoes it.
    """
    ours, is_black = setup.filter_scene_of(scene), _is_black(scene)
    for tree in setup.all_trees_of(scene) if ours is not None else ():
        for node in setup.layer_nodes(tree, ours):
            if (is_black or node.mute) and PARKED not in node:
                _park_node(tree, scene, node, True)


def park(scene):
    """Links what follows our nodes to the scene's own, for a file to be written."""
    ours = setup.filter_scene_of(scene)
    for tree in setup.all_trees_of(scene) if ours is not None else ():
        for node in setup.layer_nodes(tree, ours):
            if PARKED not in node:
                _park_node(tree, scene, node, not node.mute)
                node.label = LABEL
    for node in group.nodes_of(scene):
        # Images that were made are not written.
        _shown[node.node_tree.name] = node.node_tree.rack_focus.is_filtered
        group.show(node.node_tree, False)


def _end_of(node, index, identifier, fed):
    """The input of a node that followed one of ours; None where there is none.

    fed: inputs that the stand-in leads to. 5.0 has the inputs of some nodes in another
    order than the Blender that wrote the file; older files name no identifier.
    """
    inputs = list(node.inputs)
    same = [s for s in inputs if identifier and s.identifier == identifier]
    there = inputs[index : index + 1]
    led = [s for s in there if s in fed] or [s for s in inputs if s in fed]
    return next(iter(same or led or ([] if identifier else there)), None)


def _ends_of(tree, target, place, fed):
    """The inputs that followed one of our nodes, as this Blender has them.

    target: name of the node; place: index of the input, and its identifier. 5.0 puts a
    Group Output in the place of a file's Composite node, and 4.5 a Composite node
    beside the Group Output: what the stand-in leads to is the picture.
    """
    node, output = tree.nodes.get(target), compat.output_socket(tree)
    found = [_end_of(node, *place, fed)] if node is not None else []
    if output in fed and (node is None or node.type in setup.OUTPUTS):
        found.append(output)
    # What was linked anew on a machine without the add-on stays.
    return [
        end for end in found if end is not None and (end in fed or not end.is_linked)
    ]


def _restore_node(tree, node):
    about = json.loads(node[PARKED])
    node.mute, node.label = about["mute"], about["label"]
    del node[PARKED]
    for name, target, index, *identifier in about["links"]:
        output = node.outputs.get(name)
        led = [k for k in tree.links if k.from_node.name == about["source"]]
        fed = [k.to_socket for k in led if k.from_socket.name == INSTEAD[name]]
        place = index, next(iter(identifier), "")
        for end in _ends_of(tree, target, place, fed) if output is not None else ():
            for link in list(end.links):
                tree.links.remove(link)
            tree.links.new(output, end)


def restore(scene):
    """Undoes park()."""
    ours = setup.filter_scene_of(scene)
    for tree in setup.all_trees_of(scene) if ours is not None else ():
        parked = [n for n in setup.layer_nodes(tree, ours) if PARKED in n]
        for node in parked:
            _restore_node(tree, node)
        for node in [n for n in tree.nodes if STAND_IN in n] if parked else ():
            tree.nodes.remove(node)
    for node in group.nodes_of(scene) if _shown else ():
        if _shown.pop(node.node_tree.name, False):
            group.show(node.node_tree, True)


def forget():
    """Another file was opened: there is nothing to restore but what it says."""
    _shown.clear()


def add_notice():
    """A script in the written file that speaks up, where the preferences want it."""
    is_wanted = preferences.get("has_notice", False)
    if not is_wanted or not any(map(setup.filter_scene_of, setup.user_scenes())):
        return
    text = bpy.data.texts.get(NOTICE) or bpy.data.texts.new(NOTICE)
    text.from_string(NOTICE_TEXT)
    text.use_module = True


def remove_notice():
    """Takes it away again."""
    text = bpy.data.texts.get(NOTICE)
    if text is not None:
        bpy.data.texts.remove(text)
