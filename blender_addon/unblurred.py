# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of the render, beside the picture, that the artist's nodes lead to the output.

Cycles' own lens blurs every pass of light, and mattes; we filter the picture alone. A
composite that is put together from passes (light times colour, a fog by Mist, Environment
behind the picture) then stays sharp, or mixes what is sharp with what is blurred, and one
that is graded within a matte has sharp rims on blurred things. Box and console say so, and
what to do: a node on an image, behind the composite. They also say where nodes show no
picture of the scene at all, but its depth, another scene or a file, and where the artist's
own Defocus node blurs the picture a second time.
"""

from . import compat, group, setup

PICTURE = ("Image", "Alpha", "Freestyle")  # filtered by our node; lines stay sharp
GUIDES = "Denoising"  # start of names; sharp on purpose
# Passes of one channel that nodes mix and mask by; from 5.0 on, and before.
FACTORS = ("Mist", "Object Index", "Material Index", "IndexOB", "IndexMA")
MATTES = "Cryptomatte"
MOST = 3  # names that are said
NOT_SHOWN = (
    "Your nodes show nothing of the Rack Focus node",
    "Link its Image to where the picture should be",
)


def names_of(scene):
    """Names of such passes, in the order of the nodes' sockets."""
    tree = compat.compositor_tree(scene)
    values = {aov.name for layer in scene.view_layers for aov in layer.aovs}
    found = {}
    for one in setup.with_groups(tree) if tree is not None else ():
        for node in setup.layer_nodes(one, scene):
            outputs = () if node.mute else node.outputs
            outputs = [o for o in outputs if _is_blurred(o) or o.name in values]
            found.update((_said(o), None) for o in outputs if _is_shown(one, o))
        for node in setup.matte_nodes(one, scene):
            outputs = () if node.mute else node.outputs
            found.update((MATTES, None) for o in outputs if _is_shown(one, o))
    return list(found)


def describe(scene):
    """Lines for the panel on such passes."""
    names = names_of(scene)
    lines = [
        f"Your node “{name}” blurs the picture once more: mute it"
        for name in _defocus_nodes(scene)
    ]
    if not names:
        is_vain = setup.is_filtered(scene) and not setup.is_used(scene)
        return [*lines, *(NOT_SHOWN if is_vain else ())]
    said = ", ".join(names[:MOST]) + (", …" if len(names) > MOST else "")
    return [
        *lines,
        f"Your nodes show passes that are not blurred: {said}",
        "Put Add > Filter > Rack Focus on an Image behind them",
    ]


def _defocus_nodes(scene):
    """Names of Defocus nodes, which make a depth of field of their own."""
    tree = compat.compositor_tree(scene)
    if tree is None or setup.filter_scene_of(scene) is None:
        return []
    nodes = [n for one in setup.with_groups(tree) for n in one.nodes]
    nodes = [n for n in nodes if n.type == "DEFOCUS" and not n.mute]
    return [n.name for n in nodes if any(o.is_linked for o in n.outputs)]


def _is_blurred(output):
    """Is the pass of a socket one that the lens would have blurred?"""
    if output.name in PICTURE or output.name.startswith(GUIDES):
        return False
    return output.type == "RGBA" or output.name in FACTORS


def _said(output):
    """What a pass is called: the levels of Cryptomatte, which old nodes read, are one."""
    return MATTES if output.name.startswith("Crypto") else output.name


def _is_shown(tree, output):
    """Does a socket lead to the tree's output, and not through a node of ours?"""
    after = {}
    for link in tree.links:
        after.setdefault(link.from_node.name, []).append(link.to_node)
    seen, new = set(), [
        link.to_node for link in tree.links if link.from_socket == output
    ]
    while new:
        node = new.pop()
        if node.name in seen or (group.is_ours(node) and not node.mute):
            continue
        if node.type in setup.OUTPUTS:
            return True
        seen.add(node.name)
        new += after.get(node.name, ())
    return False
