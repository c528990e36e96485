# SPDX-License-Identifier: GPL-3.0-or-later
"""Where new nodes are put in a tree."""

NODE_GAP = 40  # px between nodes
WITH_PREVIEW, PREVIEW = ("R_LAYERS", "IMAGE", "COMPOSITE", "VIEWER"), 190  # px


def box_of(node):
    """(left, right, bottom, top) of a node in the tree; its height is estimated."""
    x, y, parent = *node.location, node.parent
    while parent is not None:
        x, y, parent = x + parent.location.x, y + parent.location.y, parent.parent
    n_rows = sum(s.enabled for s in (*node.inputs, *node.outputs))
    height = 120 + 22 * n_rows + (PREVIEW if node.type in WITH_PREVIEW else 0)
    height = max(height, node.dimensions.y)
    return x, x + max(node.width, 140), y - height, y


def put_below(tree, node, above):
    """Places `node` under another one, where it covers none."""
    left, _, bottom, _ = box_of(above)
    node.location = (left, bottom - NODE_GAP)
    others = [box_of(n) for n in tree.nodes if n != node and n.type != "FRAME"]
    while True:
        left, right, bottom, top = box_of(node)
        hit = [b for b in others if b[0] < right and left < b[1]]
        hit = [b for b in hit if b[2] - NODE_GAP < top and bottom < b[3] + NODE_GAP]
        if not hit:
            return
        node.location.y = min(b[2] for b in hit) - NODE_GAP - 1
