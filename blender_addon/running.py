# SPDX-License-Identifier: GPL-3.0-or-later
"""Which scenes are rendered now.

What a render needs is neither made nor taken away meanwhile: 5.2 crashed where the box was
unticked during a render of several views.
"""

import functools
import sys
import threading

import bpy

from .writing import write

PAUSE_S = 0.2  # between looks whether the render is over

scenes = set()  # names, those of copies and filter scenes too
_callers = {}  # name: what called its render, as of _place_in(), JOB or None
JOB = "a job beside the window's loop"
is_tick_late = False  # was a box ticked or unticked since a render began?


def is_any():
    """Is something rendered, or composited?"""
    _drop_ended()
    return bool(scenes) or bpy.app.is_job_running("RENDER")


def _is_main():
    return threading.current_thread() is threading.main_thread()


def _drop_ended():
    """Forgets renders whose end no handler was told of.

    Measured in 3.4, 5.0 and 5.2: those of a film whose file cannot be opened.
    """
    if not _callers or not _is_main():
        return
    going_on, frame = {None}, sys._getframe()
    while frame is not None:
        going_on.add(_place_in(frame))
        frame = frame.f_back
    if bpy.app.is_job_running("RENDER"):
        going_on.add(JOB)
    for name in [n for n, caller in _callers.items() if caller not in going_on]:
        _drop(name)


def _place_in(frame):
    """What stands for a call that a frame of Python makes, while it is not over."""
    return frame and (id(frame), frame.f_lasti)


def _drop(name):
    scenes.discard(name)
    _callers.pop(name, None)


def begin(name, caller):
    """A render of a scene begins; caller: the frame of Python that called it, or None."""
    global is_tick_late
    _drop_ended()
    if not scenes:
        is_tick_late = False
    scenes.add(name)
    _callers[name] = _place_in(caller) if _is_main() else JOB


def end(name):
    """A render of a scene is over; one that got another name meanwhile is not known."""
    known = {scene.name for scene in bpy.data.scenes} - {name}
    for one in scenes - known:
        _drop(one)


def forget():
    """Another file is open."""
    scenes.clear()
    _callers.clear()


def put_off_tick(task):
    """Calls task() in the main thread once nothing is rendered, where there is a window.

    In the background the next render, or the next change, sees to it.
    """
    global is_tick_late
    if not is_tick_late and not bpy.app.background:
        wait = functools.partial(_wait, task)
        bpy.app.timers.register(wait, first_interval=PAUSE_S)
    is_tick_late = True


def _wait(task):
    global is_tick_late
    if is_any():
        return PAUSE_S
    is_tick_late = False
    write(task)
    return None
