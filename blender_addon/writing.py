# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing to Blender's data from render threads.

Blender has one switch for the whole process that forbids Python to write to data while
a panel is drawn. A render thread that gets its turn in the middle of a draw finds it
set, and handlers may. The callbacks of properties are exempt, so the writing is done in
the getter of a property, without giving other threads a turn.
"""

import sys
import threading

import bpy
from bpy.props import BoolProperty

NO_TURNS_S = 60.0

_tasks = {}  # thread: (task, list for its exception)


def _run_task(_self):
    """The getter: runs the task of this thread."""
    task, problems = _tasks.pop(threading.get_ident(), (None, None))
    if task is not None:
        try:
            task()
        except Exception as problem:
            problems.append(problem)
    return True


def write(task, *args):
    """Runs task(*args), which may write to Blender's data, in any thread."""
    problems = []
    _tasks[threading.get_ident()] = (lambda: task(*args)), problems
    kept = sys.getswitchinterval()
    sys.setswitchinterval(NO_TURNS_S)
    try:
        _ = bpy.data.scenes[0].rack_focus.gate
    finally:
        sys.setswitchinterval(kept)
    if problems:
        raise problems[0]


def gate():
    """The property; a member of scene.rack_focus."""
    return BoolProperty(get=_run_task, options={"HIDDEN", "SKIP_SAVE"})
