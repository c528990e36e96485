# SPDX-License-Identifier: GPL-3.0-or-later
"""How often a 3D view is drawn while it turns, with Rack Focus and without.

See stepping.py; docs/measure_viewport.py runs it. Finds for each mode the seconds a frame
without and with, and those of its steps.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
import stepping  # noqa: E402
from common import addon  # noqa: E402
from stepping import DIST, FOUND, OUT, area_of, override, region_of, until  # noqa: E402

N_FRAMES = 10
STEPS = ("read", "shrink", "depth", "filter", "texture", "draw")


def view():
    """What the add-on keeps of the region."""
    return addon("viewport").view_of(region_of(area_of("VIEW_3D")))


def set_priority(*policy):
    """Real-time priority while frames are timed, where the system allows it."""
    command = ["chrt", "-a", *policy, str(os.getpid())]
    subprocess.run(command, capture_output=True)


def turn():
    """(seconds a frame, {step: seconds}): medians of frames of a turning view."""
    area = area_of("VIEW_3D")
    data = area.spaces.active.region_3d
    about = Quaternion((0, 0, 1), 0.02)
    frames, steps = [], []
    set_priority("-r", "-p", "20")
    for _ in range(N_FRAMES):
        data.view_rotation = about @ data.view_rotation
        started = time.perf_counter()
        with override(area):
            bpy.ops.wm.redraw_timer(type="DRAW_WIN", iterations=1)
        frames.append(time.perf_counter() - started)
        if view() and view().seconds:
            steps.append([view().seconds.get(name, 0) for name in STEPS])
    set_priority("-o", "-p", "0")
    of_steps = np.median(steps, axis=0).tolist() if steps else [0] * len(STEPS)
    return float(np.median(frames)), dict(zip(STEPS, of_steps, strict=True))


def is_shown():
    """Is there a picture in the view?"""
    area_of("VIEW_3D").tag_redraw()
    return view() and view().texture


def steps():
    """Solid, Material Preview and Cycles; yields the seconds to wait."""
    common.install(DIST)
    common.make_base(OUT / "base.blend")
    scene = bpy.context.scene
    scene.cycles.preview_samples = 1
    scene.camera.data.dof.aperture_fstop = 0.15
    space = area_of("VIEW_3D").spaces.active
    settings = bpy.context.window_manager.rack_focus_view
    region = region_of(area_of("VIEW_3D"))
    FOUND["size"] = region.width, region.height
    space.region_3d.view_perspective = "PERSP"
    space.region_3d.view_location = (0, 3, 0)
    space.region_3d.view_distance = 4
    for kind in ("SOLID", "MATERIAL", "RENDERED"):
        space.shading.type = kind
        settings.enabled = True
        yield 0.5
        yield from until(is_shown, f"a picture in {kind}", 0.2)
        settings.enabled = False
        yield 1
        turn()
        without, _ = turn()
        settings.enabled = True
        yield from until(is_shown, f"a picture in {kind}", 0.2)
        turn()
        seconds, of_steps = turn()
        FOUND[kind] = {"without": without, "with": seconds, "steps": of_steps}
        FOUND[f"{kind}_size"] = view().depth.shape[::-1]


stepping.play(steps(), is_smooth=True)
