# SPDX-License-Identifier: GPL-3.0-or-later
"""Which scenes are rendered now.

What a render needs is neither made nor taken away meanwhile: 5.2 crashed where the box was
unticked during a render of several views.
"""

import functools

import bpy

from .writing import write

PAUSE_S = 0.2  # between looks whether the render is over

scenes = set()  # names, those of copies and filter scenes too
is_tick_late = False  # was a box ticked or unticked since a render began?


def is_any():
    """Is something rendered, or composited?"""
    return bool(scenes) or bpy.app.is_job_running("RENDER")


def begin(name):
    """A render of a scene begins."""
    global is_tick_late
    if not scenes:
        is_tick_late = False
    scenes.add(name)


def end(name):
    """A render of a scene is over; one that got another name meanwhile is not known."""
    scenes.discard(name)
    scenes.intersection_update({scene.name for scene in bpy.data.scenes})


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
