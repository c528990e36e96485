# SPDX-License-Identifier: Apache-2.0
"""How many views: the scores of docs/views.md for 2 to 32 views of equal samples.

    views_table.py RACKFOCUS WORKDIR [SCENE ...] [--count N ...] [--accumulate]

WORKDIR/SCENE.N holds what

    cycles_scenes.py -- SCENE WORKDIR/SCENE.N --pass views --count N --samples 64/N

has rendered. The views are given their headers there, merged with four sub-apertures
and held against tests/quality/references. `--accumulate` scores their plain mean too,
`--beside-lamps` leaves out what is white in the reference and 3 px around it. Prints a
Markdown table of tPSNR in dB; a dash is what was not rendered.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

from collect_references import camera_header, read_exr, round_depth, write_exr

sys.path.insert(0, str(Path(__file__).parents[1]))
import beside_lamps  # noqa: E402

REFERENCES = Path(__file__).parents[1] / "references"
COUNTS = (2, 4, 8, 16, 32)


def with_headers(folder, scene):
    """Paths of the views of one folder, as files that `rackfocus filter` takes."""
    facts_path = folder / f"{scene}_views.json"
    if not facts_path.exists():
        return []
    about = json.loads(facts_path.read_text())
    paths = []
    for index, offset in enumerate(about["view_offsets"]):
        source = folder / f"{scene}_view{index:02d}.exr"
        if not source.exists():
            return []
        facts = camera_header(about["camera"])
        facts["rackfocus:lensOffset"] = tuple(offset)
        plane = about.get("shear_distance", about["camera"]["focus"])
        facts["rackfocus:shearDistance"] = float(plane)
        pixels = read_exr(source)
        pixels[..., 3] = round_depth(pixels[..., 3])
        paths.append(folder / f"with_header_{index:02d}.exr")
        write_exr(paths[-1], pixels, "zip", facts)
    return paths


def score(command, inputs, folder, scene, *options, is_beside_lamps=False):
    """tPSNR of what a command makes of views."""
    out = folder / "out.exr"
    subprocess.run([*command, *inputs, "-o", out, "--quiet", *options], check=True)
    reference = REFERENCES / f"{scene}_reference.exr"
    if is_beside_lamps:
        return beside_lamps.score(out, reference)
    compared = subprocess.run(
        [command[0], "compare", "--json", out, reference],
        check=True, text=True, stdout=subprocess.PIPE,
    )  # fmt: skip
    return json.loads(compared.stdout)["tpsnr"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rackfocus", type=Path)
    parser.add_argument("workdir", type=Path)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--count", type=int, nargs="+", default=COUNTS)
    parser.add_argument("--accumulate", action="store_true")
    parser.add_argument("--beside-lamps", action="store_true")
    args = parser.parse_args()
    how = {"is_beside_lamps": args.beside_lamps}
    found = (re.fullmatch(r"(.+)\.\d+", path.name) for path in args.workdir.iterdir())
    scenes = args.scenes or sorted({match[1] for match in found if match})
    print("| scene | one view |", *(f"{count} |" for count in args.count))
    print("| --- |", "--- | " * (1 + len(args.count)))
    merge = ("--sub-apertures", "4", "--type", "float")
    for scene in scenes:
        one = [REFERENCES / f"{scene}_pinhole.exr"]
        command = [args.rackfocus, "filter"]
        rows = {scene: [score(command, one, args.workdir, scene, *merge, **how)]}
        if args.accumulate:
            rows[f"{scene}, mean"] = [float("nan")]
        for count in args.count:
            folder = args.workdir / f"{scene}.{count}"
            paths = with_headers(folder, scene)
            for name, row in rows.items():
                if not paths:
                    row.append(float("nan"))
                elif name == scene:
                    command = [args.rackfocus, "filter"]
                    row.append(score(command, paths, folder, scene, *merge, **how))
                else:
                    command = [args.rackfocus, "accumulate"]
                    row.append(score(command, paths, folder, scene, **how))
        for name, row in rows.items():
            cells = ("-" if cell != cell else f"{cell:.2f}" for cell in row)
            print(f"| {name} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
