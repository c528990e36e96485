# SPDX-License-Identifier: GPL-3.0-or-later
"""The render slot of the last render.

Blender reads the Render Result in the slot that the Image Editor shows. Artists show
another one to look at an earlier picture, also while a render runs; what is to be
filtered is in the slot that was shown when the render began.
"""

import contextlib

import bpy

_last = None  # (identity, number) of the slot of the last render or refocus


def render_result():
    """Blender's image of renders, or None."""
    return next((i for i in bpy.data.images if i.type == "RENDER_RESULT"), None)


def note():
    """A render or a refocus begins: its picture goes to the slot that is shown."""
    global _last
    image = render_result()
    slot = image.render_slots.active if image is not None else None
    _last = slot and (slot.as_pointer(), image.render_slots.active_index)


def forget():
    """Another file is open."""
    global _last
    _last = None


def _number(slots):
    """That of the slot of the last render; None where it is not known.

    Slots that are removed change the numbers of others, and undo their identity.
    """
    if _last is None:
        return None
    pointers = [slot.as_pointer() for slot in slots]
    number = pointers.index(_last[0]) if _last[0] in pointers else _last[1]
    return number if number < len(pointers) else None


@contextlib.contextmanager
def last_shown():
    """The slot of the last render is shown meanwhile; for the main thread."""
    image = render_result()
    slots = image.render_slots if image is not None else ()
    number = _number(slots)
    if number is None or number == slots.active_index:
        yield
        return
    kept, slots.active_index = slots.active_index, number
    try:
        yield
    finally:
        slots.active_index = kept
