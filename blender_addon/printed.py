# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender prints by itself in the background, for farms that read it."""

import contextlib
import ctypes
import os
import sys
import tempfile

import bpy

STDOUT = 1
C_LIBRARY = None if os.name == "posix" else "ucrtbase"  # the process's own


def _flush():
    sys.stdout.flush()
    ctypes.CDLL(C_LIBRARY).fflush(None)


@contextlib.contextmanager
def without(start):
    """Leaves out lines that begin with `start` (bytes), in the background.

    For a call whose error is known to be none. The other lines are printed at its end.
    """
    if not bpy.app.background:
        yield
        return
    _flush()
    kept = os.dup(STDOUT)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), STDOUT)
        try:
            yield
        finally:
            _flush()
            os.dup2(kept, STDOUT)
            os.close(kept)
            file.seek(0)
            lines = [x for x in file if not x.startswith(start)]
            os.write(STDOUT, b"".join(lines))
