# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept by the names of scenes, and follows scenes that are renamed."""

_stores = []
_last = {}  # identity of a scene: its name when follow() last looked


def store():
    """A new {name of a scene: something} that follows."""
    _stores.append({})
    return _stores[-1]


def follow(scenes):
    """After anything that may have renamed scenes, and before a render or a refocus."""
    now = {_identity(scene): scene.name for scene in scenes}
    new_names = {
        old: now[one] for one, old in _last.items() if now.get(one, old) != old
    }
    _last.clear()
    _last.update(now)
    for kept in _stores if new_names else ():
        moved = {new: kept.pop(old) for old, new in new_names.items() if old in kept}
        kept.update(moved)


def _identity(scene):
    """The same before and after undo, too."""
    return scene.as_pointer(), getattr(scene, "session_uid", 0)


def forget():
    """Another file is open."""
    _last.clear()
