# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes with sockets that the tick puts behind Denoise nodes, and takes away again."""

from . import group, layout

INSERTED = "rack_focus_inserted"  # of these nodes


def follow_denoisers(tree, source):
    """Puts a node with sockets behind Denoise nodes: their guides are sharp.

    Not where one of the artist's follows: what is blurred twice is too soft.
    """
    nodes = {k.to_node for k in tree.links if k.from_node == source}
    own = [n for n in tree.nodes if group.is_ours(n) and not n.mute]
    followed = {node for one in own for node in group.upstream(tree, one)}
    for denoise in [n for n in nodes if n.type == "DENOISE" and not n.mute]:
        if denoise in followed:
            continue
        feeds = denoise.inputs["Image"].links
        ends = [k.to_socket for k in tree.links if k.from_node == denoise]
        if not feeds or feeds[0].from_node != source or not ends:
            continue
        node = tree.nodes.new("CompositorNodeGroup")
        node.node_tree = group.new_group()
        node.node_tree.rack_focus.layer = source.layer
        node.label = group.NAME
        node[INSERTED] = True
        layout.put_below(tree, node, denoise)
        tree.links.new(denoise.outputs["Image"], node.inputs["Image"])
        for end in ends:
            tree.links.new(node.outputs["Image"], end)


def give_way(tree, node):
    """Takes away what the tick put before or behind a node that the artist adds."""
    before = group.upstream(tree, node)
    found = [n for n in tree.nodes if INSERTED in n and group.is_ours(n)]
    remove(tree, [n for n in found if n in before or node in group.upstream(tree, n)])


def remove(tree, found=None):
    """Takes the nodes of follow_denoisers() away again, all or some."""
    if found is None:
        found = [n for n in tree.nodes if INSERTED in n and group.is_ours(n)]
    for node in found:
        feeds = [k.from_socket for k in node.inputs["Image"].links]
        for link in [k for k in tree.links if k.from_node == node]:
            end, is_picture = link.to_socket, link.from_socket.name == "Image"
            tree.links.remove(link)
            if feeds and is_picture:
                tree.links.new(feeds[0], end)
        tree.nodes.remove(node)
