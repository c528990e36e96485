# SPDX-License-Identifier: GPL-3.0-or-later
"""Failures for a farm: a line on stderr, and an exit code where one is asked for.

A Blender in the background goes on after a failure and leaves with 0. With the
preference “Fail Renders” or RACKFOCUS_STRICT=1 it still does all that its command line
says, and then leaves with 1.
"""

import atexit
import os
import sys

import bpy

from . import preferences

STRICT_VARIABLE = "RACKFOCUS_STRICT"
EXIT_CODE = 1

told = {}  # scene name: what went wrong before the filter began
_is_exit_set = False


def is_strict():
    """Does a failure count for the exit code?"""
    if os.environ.get(STRICT_VARIABLE, "0") not in ("", "0"):
        return True
    return preferences.get("is_strict", False)


def say(scene, message, is_failure=True):
    """One line on stderr; in the background a failure is one for the exit code too."""
    global _is_exit_set
    text = " ".join(str(message).split())
    print(
        f"Rack Focus: scene “{scene.name}”, frame {scene.frame_current}: {text}",
        file=sys.stderr,
        flush=True,
    )
    is_counted = is_failure and bpy.app.background and not _is_exit_set
    if is_counted and is_strict():
        _is_exit_set = True
        atexit.register(_leave)


def _leave():
    """The end of a Blender in which something failed."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(EXIT_CODE)


def note(scene, message, is_failure=True):
    """The same before the filter begins; the panel shows it too."""
    told[scene.name] = str(message)
    say(scene, message, is_failure)
