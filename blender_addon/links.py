# SPDX-License-Identifier: GPL-3.0-or-later
"""Links between the nodes of a tree."""

from . import compat


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


def put_over(tree, nodes, output):
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
