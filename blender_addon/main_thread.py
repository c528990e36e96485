# SPDX-License-Identifier: GPL-3.0-or-later
"""Running code in Blender's main thread, where data can be made, changed and removed.

Handlers of a render that runs as a job are called in the job's thread, while the main
thread draws, evaluates and iterates the file's datablocks. The main thread's timers go
on during a job; in the background everything is the main thread.
"""

import threading

import bpy

from .writing import write


class BusyError(Exception):
    """The main thread did not come to the task."""


def run(task, timeout_s):
    """Runs task() in the main thread, where it may write, and waits for it.

    Exceptions of the task come through. BusyError after timeout_s seconds; the task is
    then not run any more.
    """
    if threading.current_thread() is threading.main_thread():
        write(task)
        return
    problems = []
    begun, done, is_given_up = threading.Lock(), threading.Event(), []

    def do():
        with begun:
            if is_given_up:
                return
            try:
                write(task)
            except Exception as problem:
                problems.append(problem)
            done.set()

    bpy.app.timers.register(do, first_interval=0.0)
    if not done.wait(timeout_s):
        with begun:
            if not done.is_set():
                is_given_up.append(True)
                raise BusyError("Blender's window did not react")
    if problems:
        raise problems[0]


def run_or_here(task, timeout_s):
    """The same; a main thread that is not free (it waits for this one) is left alone."""
    try:
        run(task, timeout_s)
    except BusyError:
        write(task)
