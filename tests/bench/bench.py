# SPDX-License-Identifier: Apache-2.0
"""Measures the speed of the methods and of what else there is; ./dev bench --help.

Times come from the program tests/bench/bench.c, quality from the references of
tests/quality. Competitors take turns with our own methods, run by run. Reported is the
smallest time of several runs: on a machine that does other work too, wall time is an
upper bound, and CPU time what to compare.
"""

import argparse
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile

import report

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
REFERENCES = ROOT / "tests" / "quality" / "references"
BUILD = pathlib.Path(os.environ["RACKFOCUS_BUILD"])
#: Threads that wait must not count as work.

METHODS = "layered scatter box lowres mipmap offset mipmap-offset recursive-offset"
QUICK_METHODS = "layered scatter box"
SIZES = {"540p": "960x540", "1080p": "1920x1080", "4k": "3840x2160"}
SCENES = ["posts", "portrait", "plane", "macro", "foliage", "ortho"]


def say(text):
    """One line of progress."""
    print(f"bench: {text}", file=sys.stderr, flush=True)


def run(*arguments):
    """Run a program of the build; its output, or exit with what it said."""
    arguments = [str(a) for a in arguments]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"bench: {' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def measure(options, sizes, radii, methods, runs, views=0, threads="1,2"):
    """Rows of the program: one dictionary per case."""
    out = run(
        *(BUILD / "tests/bench/bench", "--sizes", ",".join(sizes)),
        *("--radii", ",".join(f"{r:g}" for r in radii)),
        *("--methods", ",".join(methods), "--runs", runs),
        *("--limit", options.limit, "--views", views, "--threads", threads),
    )
    return [json.loads(line) for line in out.splitlines()]


# ---- quality ---------------------------------------------------------------------


def tpsnr(picture, scene):
    """tPSNR in dB of a picture against the scene's reference."""
    out = run(
        *(BUILD / "cli/rackfocus", "compare", picture),
        REFERENCES / f"{scene}_reference.exr",
    )
    return float(out.splitlines()[-1].split()[1])


def method_options(variant):
    """ "layered:sub-apertures=4" as options of the command."""
    name, *pairs = variant.split(":")
    words = ["--method", name]
    for pair in pairs:
        key, _, value = pair.partition("=")
        words += [f"--{key}", value or "true"]
    return words


def measure_quality(options, methods, folder):
    """tPSNR of every method on every scene: {method: {scene: dB}}."""
    table = {}
    picture = folder / "quality.exr"
    for method in methods:
        say(f"quality of {method}")
        row = table.setdefault(method, {})
        for scene in options.scenes:
            run(
                *(BUILD / "cli/rackfocus", "filter", "-q"),
                *(REFERENCES / f"{scene}_pinhole.exr", "-o", picture),
                *("--type", "float", *method_options(method)),
            )
            row[scene] = tpsnr(picture, scene)
    for scene in options.scenes:
        views = sorted(REFERENCES.glob(f"{scene}_view*.exr"))
        if views and options.views:
            run(
                *(BUILD / "cli/rackfocus", "filter", "-q", *views),
                *("-o", picture, "--type", "float"),
            )
            table.setdefault(f"{len(views)} views", {})[scene] = tpsnr(picture, scene)
        table.setdefault("pinhole", {})[scene] = tpsnr(
            REFERENCES / f"{scene}_pinhole.exr", scene
        )
    return table


# ---- competitors -----------------------------------------------------------------


def least(best, wall, cpu):
    """The smaller of both times."""
    return [min(a, b) for a, b in zip(best, (wall, cpu), strict=True)]


# Our own in a race: the first picture of a process, and the best of two further ones.
OURS = [
    ("", 1, ["layered", "layered:sub-apertures=1", "scatter"]),
    (", next picture", 3, ["layered", "layered:sub-apertures=1"]),
]


def race(options, rivals, size, radius, folder):
    """Rows of the rivals and of our own methods on one frame, in turns."""
    raw, rows = folder / "frame.raw", {}
    program = BUILD / "tests/bench/bench"
    run(program, "--dump", raw, "--sizes", size, "--radii", radius)
    for turn in range(options.rounds):
        for suffix, runs, ours in OURS:
            for row in measure(
                options, [size], [radius], ours, runs, threads=options.threads
            ):
                if "wall_s" in row:
                    name = row["name"] + (suffix if row["name"] != "copy" else "")
                    best = rows.get(name, (1e9, 1e9))
                    rows[name] = least(best, row["wall_s"], row["cpu_s"])
        for rival in rivals:
            if (turn and rows.get(rival.name, [0, 0])[1] > options.limit) or (
                rival.gave_up(size, radius, options.limit)
            ):
                continue
            say(f"{rival.name}, {size}, {radius:g} px, round {turn + 1}")
            wall, cpu = rival.time(raw, folder, options.threads)
            rival.remember(size, radius, cpu)
            rows[rival.name] = least(rows.get(rival.name, (1e9, 1e9)), wall, cpu)
    width, height = map(int, size.split("x"))
    return [
        {
            **{"name": name, "width": width, "height": height, "radius": radius},
            **{"threads": int(options.threads), "wall_s": wall, "cpu_s": cpu},
        }
        for name, (wall, cpu) in rows.items()
    ]


def measure_rivals(options, data, folder):
    """Adds the race and the rivals' quality to the data."""
    import competitors  # needs numpy

    rivals = competitors.start(options.against, BUILD, say)
    for size in options.race_sizes:
        for radius in options.race_radii:
            data["race"] += race(options, rivals, size, radius, folder)
    for rival in rivals:
        for scene in options.scenes if options.quality else []:
            say(f"quality of {rival.name}, {scene}")
            picture = rival.filter_scene(REFERENCES, scene, folder, options.threads)
            if picture:
                data["quality"].setdefault(rival.name, {})[scene] = tpsnr(
                    picture, scene
                )


# ---- the whole -------------------------------------------------------------------


def comma_list(kind=str, names=None):
    """A type for argparse: "a,b" to a list, names looked up in a table."""

    def parse(text):
        return [kind((names or {}).get(t, t)) for t in text.split(",") if t]

    return parse


def parse_options():
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="./dev bench", description=__doc__)
    add = parser.add_argument
    add("--sizes", type=comma_list(names=SIZES), metavar="LIST")
    add("--radii", type=comma_list(float), metavar="LIST")
    add(
        *("--methods",),
        **{"type": comma_list(), "metavar": "LIST"},
        help="names, also with parameters: layered:sub-apertures=4; all",
    )
    add("--against", type=comma_list(), default=[], help="defocus,opendefocus")
    add("--race-sizes", type=comma_list(names=SIZES), metavar="LIST")
    add("--race-radii", type=comma_list(float), metavar="LIST")
    add("--rounds", type=int, default=2, help="turns of the competitors")
    add("--runs", type=int, help="of every case; the smallest time counts")
    add("--limit", type=float, help="most CPU seconds for one case")
    add("--views", type=int, help="views of the method views; 0: leave it out")
    add("--threads", default="2", help="of the competitors")
    add("--no-quality", dest="quality", action="store_false", help="no tPSNR")
    add("--scenes", type=comma_list(), metavar="LIST", help="for the tPSNR")
    add("--full", action="store_true", help="everything; takes an hour")
    add("--json", type=pathlib.Path, help="write the figures there too")
    add(
        *("--from",),
        **{"dest": "source", "type": comma_list(pathlib.Path), "metavar": "LIST"},
        help="figures of earlier runs instead of a new one",
    )
    add("--docs", action="store_true", help="put tables and plot into docs/")
    options = parser.parse_args()
    set_defaults(options)
    return options


def set_defaults(options):
    """The quick set takes some two minutes, the full one everything."""
    full = options.full
    quick = {
        "sizes": [SIZES["1080p"]],
        "radii": [0, 2, 8, 32, 128],
        "methods": QUICK_METHODS.split(),
        "race_sizes": [SIZES["540p"]],
        "race_radii": [8.0],
        "runs": 2,
        "limit": 10,
        "views": 0,
        "scenes": SCENES[:2],
    }
    everything = {
        "sizes": list(SIZES.values()),
        "methods": METHODS.split(),
        "race_sizes": [SIZES["540p"], SIZES["1080p"]],
        "race_radii": [8.0, 32.0, 128.0],
        "runs": 5,
        "limit": 400,
        "views": 8,
        "scenes": SCENES,
    }
    if full and not options.against:
        options.against = ["defocus", "opendefocus"]
    for key, value in {**quick, **(everything if full else {})}.items():
        if getattr(options, key) is None:
            setattr(options, key, value)
    if options.methods == ["all"]:
        options.methods = METHODS.split()


def about():
    """What was measured, and where."""
    commit = subprocess.run(
        ["git", "-C", ROOT, "rev-parse", "--short", "HEAD"],
        capture_output=True,
        text=True,
        check=False,
    )
    model = platform.processor() or platform.machine()
    for line in open("/proc/cpuinfo", encoding="utf-8"):
        if line.startswith("model name"):
            model = line.split(":")[1].strip()
            break
    return {
        "commit": commit.stdout.strip(),
        "processor": model,
        "processors": os.cpu_count(),
        "load": os.getloadavg()[0],
    }


def measure_all(options, folder):
    """Everything that was asked for."""
    data = {"about": about(), "cases": [], "race": [], "quality": {}}
    for size in options.sizes:
        say(f"{len(options.methods)} methods at {size}")
        data["cases"] += measure(
            *(options, [size], options.radii, options.methods, options.runs),
            views=options.views if size == SIZES["1080p"] else 0,
        )
    if options.quality:
        data["quality"] = measure_quality(options, options.methods, folder)
    if options.against:
        measure_rivals(options, data, folder)
    return data


def join_runs(paths):
    """The figures of several runs; where two have the same case, that of the first."""
    runs = [json.loads(path.read_text(encoding="utf-8")) for path in paths]
    data = {"about": runs[0]["about"], "cases": [], "race": [], "quality": {}}
    for run_data in runs:
        for kind in ("cases", "race"):
            keys = ("name", "width", "height", "threads", "radius", "views")
            known = {tuple(row.get(k) for k in keys) for row in data[kind]}
            data[kind] += [
                row
                for row in run_data[kind]
                if tuple(row.get(k) for k in keys) not in known
            ]
        for name, scores in run_data["quality"].items():
            for scene, score in scores.items():
                data["quality"].setdefault(name, {}).setdefault(scene, score)
    return data


def main():
    """The command."""
    options = parse_options()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="rackfocus-bench-"))
    try:
        if options.source:
            data = join_runs(options.source)
        else:
            data = measure_all(options, folder)
    finally:
        shutil.rmtree(folder)
    print(report.text(data))
    if options.json:
        options.json.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    if options.docs:
        report.write_docs(data, ROOT / "docs")


if __name__ == "__main__":
    main()
