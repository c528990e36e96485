# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of others against Cycles' own lens, at equal samples.

    own_lens.py DIST OUT FILE.blend ...    (after -- where Blender is a program)

Prints for each file the tPSNR in dB, against the camera's own depth of field of many
samples, of the sharp render, of the own lens, of one view and of several; the pictures
are left in OUT. OWN_LENS has settings as JSON:

    {"focus": 25.1, "f_stop": 0.186, "samples": 32, "reference": 128, "views": 8,
     "before": "a script that is run first, as a file"}
"""

import json
import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import common  # noqa: E402
from common import last_message, read, rgba, set_output, tpsnr  # noqa: E402

USUAL = {"samples": 64, "reference": 256, "views": 8, "width": 320}


def prepare(scene, how):
    """A small picture of Cycles, without a denoiser."""
    render = scene.render
    render.engine = "CYCLES"
    height = round(render.resolution_y * how["width"] / render.resolution_x)
    render.resolution_x, render.resolution_y = how["width"], max(height, 1)
    render.resolution_percentage = 100
    scene.cycles.device = "CPU"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    for layer in scene.view_layers:
        layer.samples = 0
    if "before" in how:
        text = Path(how["before"]).read_text()
        exec(compile(text, how["before"], "exec"), {"bpy": bpy, "scene": scene})
    dof = scene.camera.data.dof
    if "focus" in how:
        dof.focus_object, dof.focus_distance = None, how["focus"]
    dof.aperture_fstop = how.get("f_stop", dof.aperture_fstop)


def picture(scene, path, samples, has_lens, views=0):
    """A render; views: 0 without Rack Focus."""
    data = scene.camera.data
    scene.cycles.samples, data.dof.use_dof = samples, has_lens
    data.rack_focus.method = "views" if views > 1 else "layered"
    data.rack_focus.views = max(views, 1)
    data.rack_focus.enabled = views > 0
    set_output(scene, path)
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        print("#", error)
    if views > 0 and last_message(scene):
        print("#", last_message(scene))
    return rgba(read(path))[..., :3]


def compare(path, out):
    """A line of scores."""
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    how = USUAL | json.loads(os.environ.get("OWN_LENS", "{}"))
    prepare(scene, how)
    folder = out / Path(path).stem
    folder.mkdir(parents=True, exist_ok=True)
    reference = picture(scene, folder / "reference.exr", how["reference"], True)
    scores = {}
    for name, has_lens, views in (
        ("sharp", False, 0),
        ("own lens", True, 0),
        ("one view", False, 1),
        (f"{how['views']} views", False, how["views"]),
    ):
        made = picture(scene, folder / f"{name}.exr", how["samples"], has_lens, views)
        scores[name] = tpsnr(made, reference)
    print(Path(path).stem, " ".join(f"{k} {v:.2f}" for k, v in scores.items()))


def main():
    """Compare all files."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    common.install(words[0])
    for path in words[2:]:
        compare(path, Path(words[1]))
    common.leave()


main()
