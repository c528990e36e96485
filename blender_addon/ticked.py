# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the last render stays as the box is ticked.

From 5.0 on Blender composites the Render Result again as soon as our nodes are there (a
tick, an undo), and has no picture of ours yet: black. It is made a moment later, not as a
job: while a job runs Blender ignores F12, and what is pressed while the window waits is
done after that.
"""

import functools
import time

import bpy

from . import compat, engine, failures, operators, passes, refocusing, running, setup
from .writing import write

PAUSE_S = 0.3  # without a change before it begins, as where the scene does so by itself
# For which the window may wait. 1080p takes 0.2 to 0.4 s (docs/notebook/blender.md).
LONGEST_S = 2.0
NOT_YET = "what is shown is not filtered yet, and may be black: press F12"

_known = set()  # session_uid of filter scenes that have been looked at
_waiting = {}  # name of a scene: when it changed last


def follow(scene):
    """After a change: has the scene's own filter scene no picture yet?"""
    if not compat.HAS_NODE_GROUPS or bpy.app.background:
        return
    # Undo brings back a scene that was removed, without its picture.
    _known.intersection_update(one.session_uid for one in bpy.data.scenes)
    if scene.name in _waiting:
        _waiting[scene.name] = time.monotonic()
        return
    ours = setup.filter_scene_of(scene)
    if ours is None or ours.session_uid in _known:
        return
    _waiting[scene.name] = time.monotonic()
    task = functools.partial(write, _look, scene.name)
    bpy.app.timers.register(task, first_interval=PAUSE_S)


def note_render(scene):
    """A render of the scene begins: it makes the picture."""
    ours = setup.filter_scene_of(scene)
    if ours is not None:
        _known.add(getattr(ours, "session_uid", 0))


def _look(name):
    """The timer; returns the seconds until it looks again."""
    scene = bpy.data.scenes.get(name)
    ours = scene and setup.filter_scene_of(scene)
    if ours is None or ours.session_uid in _known:
        _waiting.pop(name, None)
        return None
    rest_s = _waiting.get(name, 0) + PAUSE_S - time.monotonic()
    if rest_s > 0 or running.is_any() or bpy.context.screen is None:
        return max(rest_s, 0.1)
    _waiting.pop(name, None)
    _known.add(ours.session_uid)
    try:
        passes.keep(scene)
    except passes.PassesError:  # there is no render that would be black
        return None
    if not setup.can_mute_sources(scene):  # a refocus would render
        engine.last_run[name] = {"seconds": {}, "message": NOT_YET}
        failures.say(scene, NOT_YET)
        return None
    with refocusing.within(LONGEST_S), bpy.context.temp_override(
        window=bpy.context.window_manager.windows[0]
    ):
        try:
            operators.refocus(scene, "EXEC_DEFAULT")
        except (RuntimeError, *operators.REFUSED) as error:
            failures.note(scene, error)
    return None


def forget():
    """Another file is open."""
    _known.clear()
    _waiting.clear()
