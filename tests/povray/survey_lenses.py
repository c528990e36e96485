#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Gives many scenes a lens and compares with POV-Ray's own blur of the same file.

    tests/povray/survey_lenses.py [--program build/cli/rackfocus] [--jobs 2]
        [--results FILE.jsonl] [--variants] [--skip N] [FOLDER...]

Without a folder: POV-Ray's examples. Every scene that POV-Ray draws within 20 s as a
pinhole gets one of five lenses (weak, middling, strong, near focus, and an aperture
without focal_point) written into its camera; one that has a lens keeps it. Then at
160x120: POV-Ray's own 100 samples of that file, POV-Ray's pinhole, and rackfocus. The
table ends with the bars: 34 dB on 90 % of the scenes, never 0.3 dB below the pinhole on
98 %, and the list of those that miss them or are refused. --variants adds scenes made by
program: cameras, gammas and versions. Takes an hour: not part of a suite.
"""

import argparse
import concurrent.futures
import itertools
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy

EXAMPLES = "/usr/share/doc/povray/examples"
WIDTH, HEIGHT = 160, 120
SIZE = [f"+W{WIDTH}", f"+H{HEIGHT}"]
LIMIT_S = 20
BAR_DB, LOSS_DB = 34, 0.3
#: Radius of the blur far away, px, and focus in distances of what the camera looks at;
#: 0: no focal_point.
LENSES = [(0.5, 1), (1.5, 1), (4, 1), (3, 0.6), (2, 0)]

#: Things on a floor; posts, wires and lamps before a far wall; a room with a text, a torus
#: and rough stone.
WORLDS = [
    """
sphere { <0,1,0>,1 pigment { checker rgb 1 rgb <0.6,0.2,0.1> scale 0.2 } }
sphere { <0.9,0.4,-2>,0.4 pigment { rgb <0.2,0.5,0.9> } finish { phong 0.8 } }
plane { y,0 pigment { checker rgb 0.9 rgb 0.3 } }
box { <-4,0,6>,<-2,4,7> pigment { bozo color_map { [0 rgb 0.2][1 rgb 0.9] } } }
sky_sphere { pigment { gradient y color_map { [0 rgb 0.8][1 rgb <0.2,0.4,0.9>] } } }
light_source { <5,9,-7> rgb 1 }
""",
    """
#declare I = 0;
#while (I < 9)
  cylinder { <-4+I,0,0>,<-4+I,4,0>,0.02+0.01*I pigment { rgb <0.2,0.5,0.3> } }
  cylinder { <-4+I,0.3*I,-2>,<-2+I,0.3*I,1>,0.012 pigment { rgb 0.1 } }
  sphere { <-4+I,3-0.2*I,7>,0.06 pigment { rgb <30,20,10> } finish { ambient 1 } }
  #declare I = I + 1;
#end
plane { z,9 pigment { brick rgb 0.8 rgb <0.6,0.3,0.2> scale 0.1 } finish { ambient 0.3 } }
plane { y,0 pigment { rgb <0.5,0.5,0.4> } }
light_source { <5,9,-7> rgb 1 }
""",
    """
text { ttf "timrom.ttf" "Lens" 0.2, 0 translate <-1,0.8,-1> pigment { rgb <0.1,0.1,0.4> } }
torus { 0.8,0.2 rotate x*70 translate <0.5,1.2,1> pigment { granite scale 0.4 } }
difference {
  box { <-5,-0.1,-9>,<5,4,6> hollow }
  box { <-4.9,0,-10>,<4.9,3.9,5.9> hollow }
  pigment { checker rgb <0.7,0.7,0.6> rgb <0.5,0.6,0.7> scale 0.5 }
  normal { bumps 0.3 scale 0.2 }
}
height_field { function 40,40 { pattern { bumps scale 0.1 } } scale <2,0.4,2>
  translate <-3,0,1> pigment { rgb <0.5,0.4,0.3> } }
light_source { <0,3.5,-3> rgb 0.9 }
""",
]
CAMERAS = [
    "location <0,1.5,-6> look_at <0,1,0>",
    "location <0,1.5,-6> angle 35 look_at <0,1,0>",
    "location <0,1.5,-6> look_at <0,1,0> right -x*4/3",
    "location <0,1.5,-6> direction z*1.7 look_at <0,1,0> rotate y*15",
    "location <0,1.5,-6>*2 look_at <0,2,0> angle 40 scale 0.5",
    "location <2,3,-5> sky <0.2,1,0> look_at <0,1,0> angle 50",
    "location <0,1.2,-5> right x*image_width/image_height up y*1 look_at <0,1,0>",
]
GAMMAS = ["1", "1.8", "2.2", "srgb"]
VERSIONS = ["3.7", "3.1"]


def write_variants(folder):
    """Scenes of the worlds under all cameras, gammas and versions."""
    for i, (world, camera, gamma, version) in enumerate(
        itertools.product(WORLDS, CAMERAS, GAMMAS, VERSIONS)
    ):
        text = (
            f"#version {version};\nglobal_settings {{ assumed_gamma {gamma} }}\n"
            f"camera {{ {camera} }}\n{world}"
        )
        (folder / f"variant{i:03}.pov").write_text(text)


def run(command, folder, limit_s):
    return subprocess.run(
        ["nice", *command], cwd=folder, capture_output=True, text=True,
        errors="replace", timeout=limit_s,
    )  # fmt: skip


def picture(path):
    import OpenImageIO

    source = OpenImageIO.ImageInput.open(str(path))
    pixels = numpy.array(source.read_image("float"))[..., :3].astype(float)
    return numpy.clip(pixels, 0, 1) ** (1 / 2.2)


def tpsnr(a, b):
    return -10 * math.log10(((a - b) ** 2).mean() + 1e-9)


def recovered(program, scene, cwd):
    """The camera's facts, or the last line of the error."""
    done = run([program, "povray", scene, "--camera", "--", *SIZE], cwd, 6 * LIMIT_S)
    if done.returncode:
        return None, done.stderr.strip().splitlines()[-1]
    facts = {}
    for line in done.stdout.splitlines():
        name, *values = line.split()
        facts[name] = values if name == "projection" else [float(v) for v in values]
    return facts, ""


LOCATION = re.compile(r"(\blocation\s*)(<[^<>]*>)(?!\s*[-+*/.])")
CAMERA = re.compile(r"\bcamera\s*\{(?!\s*[A-Za-z_]\w*\s*[}\n])")


def with_lens(text, facts, lens):
    """The scene's text with a lens in its (only) camera; None where that is not plain."""
    radius_px, distances = LENSES[lens]
    code = re.sub(
        r"/\*.*?\*/|//[^\n]*", lambda m: " " * len(m.group()), text, flags=re.S
    )
    cameras = list(CAMERA.finditer(code))
    if len(cameras) != 1:
        return None
    where = LOCATION.search(code, cameras[0].end())
    direction = math.hypot(*facts["direction"])
    length_px = WIDTH * direction / math.hypot(*facts["right"])
    focus = facts["focus_distance"][0]
    if distances and not where:
        distances = 0
    focus = focus * distances if distances else direction
    if focus <= 1e-3:
        return None
    radius = radius_px * focus / length_px
    items = f" aperture {4 * radius:.9g} blur_samples 100 variance 0 confidence 0.9999 "
    if distances:
        items += f"focal_point {where.group(2)}+z*{focus:.9g} "
        return text[: where.end()] + items + text[where.end() :]
    return text[: cameras[0].end()] + items + text[cameras[0].end() :]


def render(scene, out, cwd, *options):
    done = run(["povray", f"+I{scene}", f"+O{out}", "+FE", "-D", *SIZE, *options], cwd,
               5 * LIMIT_S)  # fmt: skip
    return done.returncode == 0


def examine(program, path, lens):
    """One scene's row of the table."""
    row = {"scene": str(path), "lens": lens}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        try:
            return {**row, **measure(program, path, lens, folder)}
        except subprocess.TimeoutExpired:
            return {**row, "state": "slow"}


def measure(program, path, lens, folder):
    cwd = path.parent
    try:
        done = run(["povray", f"+I{path.name}", f"+O{folder}/p.exr", "+FE", "-D", *SIZE,
                    "+A0.05", "+AM2", "+R3", "-J"], cwd, LIMIT_S)  # fmt: skip
    except subprocess.TimeoutExpired:
        return {"state": "slow"}
    if done.returncode:
        return {"state": "no scene"}
    facts, why = recovered(program, path.name, cwd)
    if facts is None:
        return {"state": "refused", "why": why}
    if facts["projection"] == ["orthographic"]:
        return {"state": "orthographic"}
    if facts["aperture"][0]:
        lens, scene = "own", path.name
        text = re.sub(r"\baperture\b", "aperture 0*", path.read_text(errors="replace"))
        (folder / "pinhole.pov").write_text(text)
        if not render(
            folder / "pinhole.pov",
            folder / "p.exr",
            cwd,
            "+A0.05",
            "+AM2",
            "+R3",
            "-J",
            f"+L{cwd}",
        ):
            return {"state": "no plain camera"}
    else:
        text = with_lens(path.read_text(errors="surrogateescape"), facts, lens)
        if text is None:
            return {"state": "no plain camera"}
        scene = folder / "scene.pov"
        scene.write_text(text, errors="surrogateescape")
    beside = [f"+L{cwd}"]
    if not render(scene, folder / "r.exr", cwd, "-A", *beside):
        return {"state": "no plain camera"}
    done = run([program, "povray", scene, "-o", folder / "o.exr", "-q", "--", *SIZE,
                *beside], cwd, 6 * LIMIT_S)  # fmt: skip
    if done.returncode:
        return {"state": "refused", "why": done.stderr.strip().splitlines()[-1]}
    reference = picture(folder / "r.exr")
    return {
        "state": "done", "lens": lens,
        "one": round(tpsnr(picture(folder / "o.exr"), reference), 2),
        "pinhole": round(tpsnr(picture(folder / "p.exr"), reference), 2),
        "warning": done.stderr.strip()[-300:],
    }  # fmt: skip


def report(rows):
    states = {}
    for row in rows:
        states[row["state"]] = states.get(row["state"], 0) + 1
    done = [row for row in rows if row["state"] == "done"]
    low = [row for row in done if row["one"] < BAR_DB]
    lost = [row for row in done if row["one"] < row["pinhole"] - LOSS_DB]
    for title, listed in (
        ("refused", [row for row in rows if row["state"] == "refused"]),
        (f"below {BAR_DB} dB", low),
        ("below the pinhole", lost),
    ):
        print(f"-- {title}: {len(listed)}")
        for row in listed:
            print("  ", {k: v for k, v in row.items() if v})
    n = max(1, len(done))
    print(states)
    print(f"at least {BAR_DB} dB: {1 - len(low) / n:.1%} of {len(done)}")
    print(f"not {LOSS_DB} dB below the pinhole: {1 - len(lost) / n:.1%}")
    return len(low) <= 0.1 * n and len(lost) <= 0.02 * n


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/cli/rackfocus")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--results")
    parser.add_argument("--variants", action="store_true")
    parser.add_argument("--skip", type=int, default=0, help="scenes at the beginning")
    parser.add_argument("folders", nargs="*")
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.program).resolve())
    rows = []
    with (
        tempfile.TemporaryDirectory() as made,
        concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool,
    ):
        folders = [pathlib.Path(f).resolve() for f in arguments.folders]
        if arguments.variants:
            write_variants(pathlib.Path(made))
            folders.append(pathlib.Path(made))
        folders = folders or [pathlib.Path(EXAMPLES)]
        scenes = [scene for f in folders for scene in sorted(f.rglob("*.pov"))]
        jobs = [
            pool.submit(examine, program, scene, i % len(LENSES))
            for i, scene in enumerate(scenes)
            if i >= arguments.skip
        ]
        for job in concurrent.futures.as_completed(jobs):
            rows.append(job.result())
            print(json.dumps(rows[-1]), flush=True)
            if arguments.results:
                with open(arguments.results, "a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    return 0 if report(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
