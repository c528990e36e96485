#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The pan of measure_pan.py as its users get it: how much the renderers' own depth of
field flickers, and how much their pinhole renders do behind `rackfocus`.

    RACKFOCUS=build/cli/rackfocus tests/deep/measure_hosts.py [povray] [cycles] [bits]
    tests/deep/measure_hosts.py keep    # files/pan_*.exr, for test_pan_hosts.py

needs POV-Ray, and Blender with Cycles (BLENDER, by default the one in PATH). All is
divided by the lens in closed form, as in measure_pan.py. Cycles has a pixel filter of a
box, as POV-Ray and the closed form; its seed is the same for all frames, as it is by
default, or another one for each. `bits` is the closed form itself, rounded.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import measure_pan
import numpy as np
import OpenImageIO as oiio
import test_pan
from deepscene import read, tpsnr

N_FRAMES = measure_pan.N_FRAMES
CAMERA = measure_pan.CAMERA
SCALE = 0.1  # pan_in_cycles.py
DARK, BRIGHT, RED = (0.05, 0.05, 0.1), (0.9, 0.8, 0.6), (0.9, 0.2, 0.1)

# ---- POV-Ray -----------------------------------------------------------------------

SCENE = """#version 3.7;
global_settings {{ assumed_gamma 1 }}
camera {{
  location <clock * {step}, 0, 0>
  direction z  right x * {width}  up y * {height}
  aperture {aperture}  focal_point <clock * {step}, 0, {focus}>
  {blur}
}}
#default {{ finish {{ ambient 0 diffuse 0 emission 1 }} }}
plane {{
  z, 14
  pigment {{
    gradient x color_map {{ [0.5 rgb <{dark}>] [0.5 rgb <{bright}>] }} scale 5
  }}
}}
"""
POST = "box {{ <-0.22, -9, 3>, <0.02, 9, 3.001> pigment {{ rgb <{red}> }} }}\n"


def povray_scene(has_post, blur):
    """The scene as test_pan.scene() has it; the clock is the number of the frame."""

    def list_of(rgb):
        return ", ".join(map(str, rgb))

    return (SCENE + POST * has_post).format(
        step=measure_pan.STEP,
        width=CAMERA.width / CAMERA.focal_px,
        height=CAMERA.height / CAMERA.focal_px,
        aperture=4 * CAMERA.lens_radius,
        focus=CAMERA.focus,
        blur=blur,
        dark=list_of(DARK),
        bright=list_of(BRIGHT),
        red=list_of(RED),
    )


CLOCK = ["+KFI1", f"+KFF{N_FRAMES}", "+KI0", f"+KF{N_FRAMES - 1}"]
SIZE = [f"+W{CAMERA.width}", f"+H{CAMERA.height}"]


def povray(has_post, blur):
    """POV-Ray's own focal blur, as linear light in 16 bits."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "pan.pov").write_text(povray_scene(has_post, blur))
        words = ["povray", "+Ipan.pov", *SIZE, *CLOCK, "+FN16", "File_Gamma=1", "-D"]
        subprocess.run([*words, "-A"], cwd=folder, check=True, capture_output=True)
        return [read(path)[0][..., :3] for path in sorted(Path(folder).glob("*.png"))]


def through_rackfocus(has_post, *options, povray=()):
    """`rackfocus povray` of the same scene."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "pan.pov").write_text(povray_scene(has_post, "blur_samples 100"))
        words = [os.environ["RACKFOCUS"], "povray", "pan.pov", "-o", "out.####.exr"]
        words += ["--frames", f"1-{N_FRAMES}", *options, "--"]
        words += [*SIZE, *CLOCK, *povray]
        subprocess.run(words, cwd=folder, check=True, capture_output=True)
        return [read(path)[0][..., :3] for path in sorted(Path(folder).glob("*.exr"))]


def with_povray(show, has_post):
    for n in (37, 64, 100, 300, 1000, 3000):
        blur = f"blur_samples {n}, {n} variance 0 confidence 0.9999"
        show(f"POV-Ray, {n} samples", povray(has_post, blur))
    show("POV-Ray, 300 samples or enough", povray(has_post, "blur_samples 300"))
    for views in ([], ["--views", "8"]):
        for quality in ("", "+A0.05 +AM2 +R5 -J", "+A0.01 +AM2 +R7 -J"):
            name = "ours, 8 views" if views else "ours, pinhole"
            frames = through_rackfocus(has_post, *views, povray=quality.split())
            show(f"{name} {quality}", frames)


# ---- Cycles ------------------------------------------------------------------------


def render_in_cycles(folder, has_post, jobs):
    """Makes the folder of each job and the frames in it."""
    for number, job in enumerate(jobs):
        job["folder"] = str(folder / str(number))
        Path(job["folder"]).mkdir()
    about = {
        "has_post": has_post,
        "dark": DARK,
        "bright": BRIGHT,
        "red": RED,
        "step": measure_pan.STEP,
        "n_frames": N_FRAMES,
        "jobs": jobs,
        **vars(CAMERA),
    }
    (folder / "jobs.json").write_text(json.dumps(about))
    words = [os.environ.get("BLENDER", "blender"), "-b", "--factory-startup", "-P"]
    words += [Path(__file__).with_name("pan_in_cycles.py"), "--", folder / "jobs.json"]
    subprocess.run(words, check=True, capture_output=True)


def frames_in(folder, name, n_rows=CAMERA.height):
    """The colour of their middle rows."""
    first = (CAMERA.height - n_rows) // 2
    frames = []
    for i in range(N_FRAMES):
        picture, names = read(Path(folder) / f"{name}.{i}.exr")
        colour = [next(k for k, c in enumerate(names) if c.endswith(w)) for w in "RGB"]
        frames.append(picture[first : first + n_rows, :, colour])
    return frames


def filter_frames(folder):
    """A tenth of the size: pan_in_cycles.py."""
    lens = ["--focal-length-px", str(CAMERA.focal_px)]
    lens += ["--lens-radius", str(SCALE * CAMERA.lens_radius)]
    lens += ["--focus-distance", str(SCALE * CAMERA.focus), "--type", "float"]
    words = [os.environ["RACKFOCUS"], "filter", f"{folder}/in.#.exr"]
    subprocess.run([*words, "-q", "-o", f"{folder}/out.#.exr", *lens], check=True)


def job(samples, has_lens, other_seeds=False, is_adaptive=False):
    return {
        "samples": samples,
        "has_lens": has_lens,
        "other_seeds": other_seeds,
        "is_adaptive": is_adaptive,
    }


def with_cycles(show, has_post):
    jobs = [
        job(n, has_lens, other_seeds)
        for has_lens in (True, False)
        for n in (64, 256, 1024)
        for other_seeds in (False, True)
    ]
    jobs.append(job(4096, has_lens=True, is_adaptive=True))
    with tempfile.TemporaryDirectory() as folder:
        render_in_cycles(Path(folder), has_post, jobs)
        for one in jobs:
            name = f"{one['samples']} samples" + " or enough" * one["is_adaptive"]
            name += ", seed of every frame" * one["other_seeds"]
            if one["has_lens"]:
                show(f"Cycles, {name}", frames_in(one["folder"], "in"))
            else:
                filter_frames(one["folder"])
                show(f"ours, pinhole of {name}", frames_in(one["folder"], "out"))


KEPT_ROWS = 8
FILES = Path(__file__).with_name("files")


def keep(name, has_post, one):
    """One file of half floats: the middle rows of the frames, below each other."""
    with tempfile.TemporaryDirectory() as folder:
        render_in_cycles(Path(folder), has_post, [one])
        frames = np.concatenate(frames_in(one["folder"], "in", n_rows=KEPT_ROWS))
    spec = oiio.ImageSpec(frames.shape[1], frames.shape[0], 3, oiio.HALF)
    output = oiio.ImageOutput.create(str(FILES / name))
    assert output.open(str(FILES / name), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(frames, "f4")), output.geterror()
    output.close()


def kept(name):
    pixels = read(FILES / name)[0]
    return pixels.reshape(N_FRAMES, KEPT_ROWS, CAMERA.width, 3)


def keep_all():
    keep("pan_wall_pinhole_64.exr", False, job(64, False))
    keep("pan_wall_cycles_256.exr", False, job(256, True))
    keep("pan_post_cycles_256.exr", True, job(256, True))


# ---- the closed form, rounded ------------------------------------------------------


def with_bits(show, has_post):
    shifts = [i * measure_pan.STEP for i in range(N_FRAMES)]
    lens = np.stack([measure_pan.lens(s, has_post) for s in shifts])
    show("the lens in 8 bits of sRGB", from_srgb(np.round(255 * to_srgb(lens)) / 255))
    show("the lens in half floats", lens.astype("f2").astype(float))


def to_srgb(v):
    return np.where(v < 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def from_srgb(v):
    return np.where(v < 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


# ---- all ---------------------------------------------------------------------------


def measure(title, has_post, hosts):
    inner = np.s_[:, :, measure_pan.BORDER : -measure_pan.BORDER]
    shifts = [i * measure_pan.STEP for i in range(N_FRAMES)]
    want = np.stack([measure_pan.lens(s, has_post) for s in shifts])[inner]
    measures = test_pan.flicker, measure_pan.flicker_linear

    def show(name, frames):
        got = np.stack(frames)[inner]
        ratios = " | ".join(f"{f(got) / f(want):.1f}" for f in measures)
        print(f"| {title} | {name} | {ratios} | {tpsnr(got, want):.1f} dB |")
        sys.stdout.flush()

    for host in hosts:
        HOSTS[host](show, has_post)


HOSTS = {"povray": with_povray, "cycles": with_cycles, "bits": with_bits}


def main():
    if sys.argv[1:] == ["keep"]:
        return keep_all()
    hosts = sys.argv[1:] or HOSTS
    measure("wall", False, hosts)
    measure("post, wall", True, hosts)


if __name__ == "__main__":
    main()
