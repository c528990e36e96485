# SPDX-License-Identifier: GPL-3.0-or-later
"""The render slot of the last render.

Blender reads the Render Result in the slot that the Image Editor shows. Artists show
another one to look at an earlier picture, also while a render runs; what is to be
filtered is in the slot that was shown when the render began.
"""

import contextlib
import itertools

import bpy

from . import names

_last = None  # (identity, number) of the slot of the last render or refocus
_count = itertools.count()
_renders = names.store()  # scene name: which of all renders was its last
_shown = []  # (identity and number of a slot, which render it has)
_is_kept = False  # does what is rendered now leave the pictures of all slots?


def render_result():
    """Blender's image of renders, or None."""
    return next((i for i in bpy.data.images if i.type == "RENDER_RESULT"), None)


def _active():
    """(identity, number) of the slot that is shown, or None."""
    image = render_result()
    slot = image.render_slots.active if image is not None else None
    return slot and (slot.as_pointer(), image.render_slots.active_index)


def note(scene):
    """A render or a refocus begins: its picture goes to the slot that is shown."""
    global _last
    if _is_kept:
        return
    _last = _active()
    about = scene.rack_focus
    if about.source is not None or about.viewed is not None:
        return  # a part of another scene's picture
    if not about.muted or scene.name not in _renders:
        _renders[scene.name] = next(_count)
    if _last is not None:
        slots = render_result().render_slots
        others = [one for one in _shown if _number_of(one[0], slots) != _last[1]]
        _shown[:] = [*others, (_last, _renders[scene.name])]


def forget():
    """Another file is open."""
    global _last
    _last = None
    _renders.clear()
    _shown.clear()


def _number_of(place, slots):
    """That of a slot, of which (identity, number) are known; None where it is gone.

    Slots that are removed change the numbers of others, and undo their identity.
    """
    pointers = [slot.as_pointer() for slot in slots]
    number = pointers.index(place[0]) if place[0] in pointers else place[1]
    return number if number < len(pointers) else None


def _number(slots):
    """That of the slot of the last render; None where it is not known."""
    return None if _last is None else _number_of(_last, slots)


def why_not_last(scene):
    """Why the slot that is shown has no picture of a scene's last render, or "".

    A refocus shows the render that it filters, so that several slots may have one.
    """
    image = render_result()
    if image is None or scene.name not in _renders:
        return ""
    slots = image.render_slots
    made = {_number_of(place, slots): render for place, render in _shown}
    wanted = _renders[scene.name]
    number = next((n for n, render in made.items() if render == wanted), None)
    if number is None or made.get(slots.active_index) == wanted:
        return ""
    return (
        f"the slot that is shown has no picture of the last render: show “"
        f"{slots[number].name}”, or press F12"
    )


@contextlib.contextmanager
def last_shown():
    """The slot of the last render is shown meanwhile; for the main thread.

    What is rendered meanwhile takes the picture of no slot.
    """
    global _is_kept
    image = render_result()
    slots = image.render_slots if image is not None else ()
    number, was_kept = _number(slots), _is_kept
    kept = slots.active_index if number is not None else None
    _is_kept = True
    try:
        if number not in (None, kept):
            slots.active_index = number
        yield
    finally:
        _is_kept = was_kept
        if number not in (None, kept):
            slots.active_index = kept
