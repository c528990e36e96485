#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Is a .blend file's picture of small blur better than the sharp one? For any file.

    tests/quality/small_blur.py BPY RACKFOCUS FOLDER FILE.blend...

BPY is the Python of an environment with `bpy` 5.0. Renders 160 px of each file in Cycles:
a pinhole with depth and, with another seed (or the sharp picture would share its noise),
the own lens at three distances of focus; prints tPSNR of the sharp picture and of the
filtered one. docs/notebook/thresholds.md has 28 files of strangers. Blender's add-on is
not asked: it has tests of its own.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

# Distance in parts of that of the picture's middle, f-stop in parts of the one that
# blurs by 6 px what is infinitely far.
FOCUSES = {"middle": (1, 1), "far": (1.25, 2), "near": (0.8, 1.4)}
WIDTH, SAMPLES, SEED, INFINITY_PX = 160, 144, 77, 6
LIMIT_S = 600

INSIDE = """
import json, sys
import bpy
from mathutils import Vector

path, out, width, samples, seed, px, focuses = sys.argv[-7:]
bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
scene = bpy.context.scene
render, camera = scene.render, scene.camera
if not camera or camera.data.type != "PERSP":
    sys.exit("no perspective camera")
render.engine, scene.cycles.device = "CYCLES", "CPU"
scale = int(width) / max(render.resolution_x, render.resolution_y)
render.resolution_x = int(render.resolution_x * scale)
render.resolution_y = int(render.resolution_y * scale)
render.resolution_percentage = 100
render.use_compositing = render.use_sequencer = render.use_border = False
render.use_multiview = render.use_motion_blur = False
scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
scene.cycles.samples, scene.cycles.max_bounces = int(samples), 3
for layer in scene.view_layers:
    layer.samples, layer.use_pass_z = 0, True
graph = bpy.context.evaluated_depsgraph_get()
matrix = camera.evaluated_get(graph).matrix_world
ahead = (matrix.to_3x3() @ Vector((0, 0, -1))).normalized()
is_hit, place, *_ = scene.ray_cast(graph, matrix.translation, ahead)
if not is_hit:
    sys.exit("nothing in the middle")
distance = -(matrix.inverted() @ place).z
data = camera.data
f_stop = data.lens**2 * int(width) * 1e-3 / (data.sensor_width * float(px) * distance)
data.dof.focus_object = None


def shoot(name, has_lens):
    data.dof.use_dof = has_lens
    about = render.image_settings
    about.media_type = "IMAGE" if has_lens else "MULTI_LAYER_IMAGE"
    about.file_format = "OPEN_EXR" if has_lens else "OPEN_EXR_MULTILAYER"
    about.color_depth = "32"
    render.filepath, render.use_file_extension = f"{out}/{name}.exr", False
    bpy.ops.render.render(write_still=True)


shoot("pinhole", False)
scene.cycles.seed += int(seed)
for name, (part, stops) in json.loads(focuses).items():
    data.dof.focus_distance = distance * part
    data.dof.aperture_fstop = f_stop * stops
    shoot(name, True)
facts = dict(distance=distance, f_stop=f_stop, lens=data.lens, fit=data.sensor_fit,
             width=data.sensor_width, height=data.sensor_height)
open(f"{out}/camera.json", "w").write(json.dumps(facts))
"""


def call(*command):
    """Whether a command did what it should, and what it printed, errors too."""
    done = subprocess.run(
        [str(part) for part in command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
    )
    return done.returncode == 0, done.stdout.strip()


def score(rackfocus, picture, reference):
    """tPSNR of a picture, dB."""
    is_done, printed = call(rackfocus, "compare", picture, reference)
    found = re.search(r"tPSNR ([\d.]+|inf)", printed)
    if not is_done or not found:
        sys.exit(printed)
    return float(found[1])


def measure(rackfocus, folder):
    """Prints a line for each focus of a file whose renders lie in a folder."""
    camera = json.loads((folder / "camera.json").read_text())
    for name, (part, stops) in FOCUSES.items():
        out, reference = folder / f"{name}_filtered.exr", folder / f"{name}.exr"
        is_done, printed = call(
            rackfocus, "filter", "-q", "--type", "float", folder / "pinhole.exr",
            "-o", out, "--focus-distance", camera["distance"] * part,
            "--f-stop", camera["f_stop"] * stops, "--focal-length", camera["lens"],
            "--sensor-width", camera["width"], "--sensor-height", camera["height"],
            "--sensor-fit", camera["fit"].lower(),
        )  # fmt: skip
        if not is_done:
            sys.exit(printed)
        sharp = score(rackfocus, folder / "pinhole.exr", reference)
        filtered = score(rackfocus, out, reference)
        print(f"{folder.name:40} {name:6} sharp {sharp:6.2f} filtered {filtered:6.2f}")


def main(python, rackfocus, folder, *paths):
    """Renders what is not there yet, and measures."""
    for path in paths:
        own = Path(folder).resolve() / "_".join(Path(path).with_suffix("").parts[-2:])
        own.mkdir(parents=True, exist_ok=True)
        facts = WIDTH, SAMPLES, SEED, INFINITY_PX, json.dumps(FOCUSES)
        if not (own / "camera.json").exists():
            is_done, printed = call(python, "-c", INSIDE, "--", path, own, *facts)
            if not is_done:
                print(f"{own.name:40} {printed.splitlines()[-1]}")
                continue
        measure(rackfocus, own)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
