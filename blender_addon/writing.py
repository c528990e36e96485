# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing to Blender's data wherever a handler, a timer or a render's thread wants to.

Blender 3.4 has one switch for the whole process that forbids Python to write to data
while a panel is drawn (5.2 has one for each thread). A render's thread that gets its
turn in the middle of a draw finds it set. Worse: Blender puts it back, after each call
of a class, to what it was before. A call of a render engine that begins in the middle
of a draw, and ends after it, leaves the switch set for good, for all that runs outside
operators: timers and handlers, those of the main thread too. The callbacks of
properties are exempt, so the writing is done in the getter of a property; in a thread
other than the main one without giving others a turn.
"""

import contextlib
import ctypes
import sys
import threading

import bpy
from bpy.props import BoolProperty

NO_TURNS_S = 60.0

_tasks = {}  # thread: (task, list for its exception)
_lock = threading.Lock()
_n_without_turns = 0
_interval_s = sys.getswitchinterval()


def _run_task(_self):
    """The getter: runs the task of this thread."""
    task, problems = _tasks.pop(threading.get_ident(), (None, None))
    if task is not None:
        try:
            task()
        except Exception as problem:
            problems.append(problem)
    return True


@contextlib.contextmanager
def _no_turns():
    """Other threads run only while this one waits for something."""
    global _n_without_turns, _interval_s
    with _lock:
        if _n_without_turns == 0:
            _interval_s = sys.getswitchinterval()
            sys.setswitchinterval(NO_TURNS_S)
        _n_without_turns += 1
    try:
        yield
    finally:
        with _lock:
            _n_without_turns -= 1
            if _n_without_turns == 0:
                sys.setswitchinterval(_interval_s)


def write(task, *args):
    """Runs task(*args), which may write to data, in any thread; returns its result."""
    problems, results = [], []
    _tasks[threading.get_ident()] = (lambda: results.append(task(*args))), problems
    is_main = threading.current_thread() is threading.main_thread()
    with contextlib.nullcontext() if is_main else _no_turns():
        _ = bpy.data.scenes[0].rack_focus.gate
    if problems:
        raise problems[0]
    return results[0]


def set_if_other(target, name, value):
    """Writes a value that a property does not have yet.

    What is written while a render evaluates the scene is evaluated once more: a pointer
    of a camera written in every evaluation of Motion Blur left views empty (4.2 to 5.0).
    Properties are of single precision, so that 0.1 never is what was written.
    """
    if isinstance(value, float):
        value = ctypes.c_float(value).value
    if getattr(target, name) != value:
        setattr(target, name, value)


def gate():
    """The property; a member of scene.rack_focus."""
    return BoolProperty(get=_run_task, options={"HIDDEN", "SKIP_SAVE"})
