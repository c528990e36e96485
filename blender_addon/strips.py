# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips in a scene's sequencer, which Blender shows in the place of its camera."""

from . import compat


def why_shown(scene):
    """Why F12 shows another picture than that of a scene that is set up, or ""."""
    edit, render = scene.sequence_editor, scene.render
    if edit is None or not render.use_sequencer:
        return ""
    strips = edit.strips if hasattr(edit, "strips") else edit.sequences
    seen = [strip for strip in strips if strip.type != "SOUND"]
    if not compat.MUTED_STRIPS_COUNT:
        seen = [s for s in seen if not s.mute and not edit.channels[s.channel].mute]
    if not seen:
        return ""
    return "Post Processing > Sequencer is on and has strips: F12 shows these, not the camera"
