# SPDX-License-Identifier: GPL-3.0-or-later
"""Our handlers in Blender's lists, from which scripts take them.

bpy.app.handlers.frame_change_post.clear() is how many scripts make room for a handler of
their own: ours is gone with it, and a camera whose own lens is on blurs twice.
"""

import bpy

LOST = (
    "a script took the handlers of Rack Focus out of bpy.app.handlers, and this render began "
    "without them: press F12 again, and let the script remove its own alone"
)

_ours = []  # (name of a list, handler)


def add(handlers):
    """Adds handlers, (name of a list, handler) each, where this Blender has the list."""
    _ours[:] = [one for one in handlers if hasattr(bpy.app.handlers, one[0])]
    put_back()


def put_back():
    """Adds those that are gone."""
    for name, handler in _ours:
        found = getattr(bpy.app.handlers, name)
        if handler not in found:
            found.append(handler)


def be_last(handlers):
    """Calls some of ours after those of the file's scripts."""
    for name, handler in handlers:
        found = getattr(bpy.app.handlers, name)
        found.remove(handler)
        found.append(handler)


def remove():
    """Removes all."""
    for name, handler in _ours:
        found = getattr(bpy.app.handlers, name)
        if handler in found:
            found.remove(handler)
    _ours.clear()
