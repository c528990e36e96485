#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Recovers and checks the camera of every scene of POV-Ray's examples.

A scene counts if POV-Ray itself renders it at 160x120 within 60 s. The bar: the camera
is recovered and verified in at least 95 % of those with a perspective or orthographic
camera; the others must end with a clear error.

    tests/povray/scan_examples.py [--program build/cli/rackfocus] [--jobs 2] [FOLDER]
"""

import argparse
import concurrent.futures
import pathlib
import re
import subprocess
import sys
import tempfile

EXAMPLES = "/usr/share/doc/povray/examples"
SIZE = ["+W160", "+H120"]
LIMIT_S = 60
BAR = 0.95


def render(scene):
    """What POV-Ray itself says: "ok", "slow" or its error."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["povray", f"+I{scene.name}", f"+O{folder}/o.png", "-D", "-A", *SIZE]
        try:
            run = subprocess.run(
                command,
                cwd=scene.parent,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=LIMIT_S,
            )
        except subprocess.TimeoutExpired:
            return "slow"
    if run.returncode == 0:
        return "ok"
    errors = [line for line in run.stderr.splitlines() if "Error" in line]
    return errors[-1].strip() if errors else "fails"


def recover(program, scene):
    """Exit code and last line of rackfocus povray --camera."""
    command = [program, "povray", scene.name, "--camera", "--", *SIZE]
    try:
        run = subprocess.run(
            command,
            cwd=scene.parent,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=5 * LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        return 1, "took too long"
    lines = (run.stderr if run.returncode else run.stdout).strip().splitlines()
    return run.returncode, lines[-1] if lines else ""


def examine(program, scene):
    code, text = recover(program, scene)
    if code == 0:
        return scene, "recovered", text
    if re.search(r"camera is of type|has a normal", text):
        return scene, "other camera", text
    state = render(scene)
    if state != "ok":
        return scene, "not counted", state
    return scene, "FAILED", text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/cli/rackfocus")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("folder", nargs="?", default=EXAMPLES)
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.program).resolve())
    scenes = sorted(pathlib.Path(arguments.folder).rglob("*.pov"))
    counts = {}
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        jobs = [pool.submit(examine, program, scene) for scene in scenes]
        for job in jobs:
            scene, state, text = job.result()
            counts[state] = counts.get(state, 0) + 1
            print(
                f"{state:13} {scene.relative_to(arguments.folder)}: {text}", flush=True
            )
    good, bad = counts.get("recovered", 0), counts.get("FAILED", 0)
    share = good / max(1, good + bad)
    print(f"{counts}\nrecovered and verified: {good} of {good + bad}, {share:.1%}")
    return 0 if share >= BAR else 1


if __name__ == "__main__":
    sys.exit(main())
