# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks that change towards the corners, in a render region: the filter sees the region
alone, and counts from its middle. Box and console say so."""

from . import keyed, props

LOOKS = (
    "cat_eye", "barn_left", "barn_right", "barn_top", "barn_bottom", "astigmatism", "swirl",
    "field_curvature", "split_diopter",
)  # fmt: skip


def describe(scene, settings):
    """Lines for the panel on such looks of a camera."""
    if not scene.render.use_border:
        return []
    used = [
        field
        for field in LOOKS
        if props.is_read(settings, field) and any(keyed.values(settings, field))
    ]
    if not used:
        return []
    name = settings.bl_rna.properties[used[0]].name
    return [
        f"In a render region {name} counts from its middle, not the frame's:",
        "render the whole frame, and cut it afterwards",
    ]
