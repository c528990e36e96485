# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten frames with a moving camera in views, for runs from the command line.

    animation.py DIST OUT make      the file OUT/animation.blend; the add-on is enabled
                                    in the saved preferences
    animation.py DIST OUT all       its animation, for Blenders that are modules
    animation.py DIST OUT one N     its frame N alone, in a process of its own

Pictures are OUT/anim/all_0001.exr and so on, OUT/anim/one_0003.exr and so on.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402

DIST, OUT, WHAT, *REST = sys.argv[sys.argv.index("--") + 1 :]
PATH = Path(OUT, "animation.blend")


def make():
    """The base scene; the camera moves, its focus, lens and shift change."""
    common.install(DIST)
    common.make_base(PATH)
    bpy.ops.wm.save_userpref()
    scene, data = common.start(views=4)
    scene.cycles.samples = 8
    scene.frame_start, scene.frame_end = 1, 10
    for frame, x, focus, focal in ((1, -0.2, 2, 45), (10, 0.3, 4, 60)):
        scene.camera.location = (x, 0, x / 2)
        scene.camera.rotation_euler = (np.pi / 2, 0, -x)
        data.dof.focus_distance, data.lens, data.shift_x = focus, focal, x / 4
        scene.camera.keyframe_insert("location", frame=frame)
        scene.camera.keyframe_insert("rotation_euler", frame=frame)
        data.keyframe_insert("lens", frame=frame)
        data.keyframe_insert("shift_x", frame=frame)
        data.dof.keyframe_insert("focus_distance", frame=frame)
    common.set_output(scene, Path(OUT, "anim", "all_####.exr"))
    bpy.ops.wm.save_as_mainfile(filepath=str(PATH))


def open_file():
    """The saved file, with the add-on."""
    bpy.ops.preferences.addon_enable(module=common.MODULE)
    bpy.ops.wm.open_mainfile(filepath=str(PATH))
    return bpy.context.scene


if WHAT == "make":
    make()
elif WHAT == "all":
    open_file()
    bpy.ops.render.render(animation=True)
else:
    scene = open_file()
    frame = int(REST[0])
    scene.frame_set(frame)
    common.set_output(scene, Path(OUT, "anim", f"one_{frame:04d}.exr"))
    bpy.ops.render.render(write_still=True)
common.leave()
