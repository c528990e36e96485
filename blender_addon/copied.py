# SPDX-License-Identifier: GPL-3.0-or-later
"""Where copies of a scene cannot render in its place, or beside it, for a setting."""

from . import bodies, freestyle, group


def why_not(scene, name):
    """Why a setting that needs copies of a scene does not work, or "".

    name: of the setting, for the box.
    """
    render = scene.render
    with_which = (
        (render.use_border, "a render region"),
        (render.use_multiview, "stereo"),
        (group.nodes_of(scene), "Rack Focus nodes on pictures"),
        (freestyle.is_drawn(scene), "Freestyle's lines"),
        (bodies.why_one_view(scene), "rigid bodies that are not baked"),
    )
    found = [what for is_there, what in with_which if is_there]
    return f"{name} does not work with {found[0]}" if found else ""
