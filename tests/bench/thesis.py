# SPDX-License-Identifier: Apache-2.0
"""The frame rates of the thesis beside ours: the same methods, size and kind of blur.

    ./dev bench --thesis [--size WxH] [--runs N]

The thesis (docs/methods.md names it) gives frames a second of a GeForce 3 at 1024x1024,
with one strength of blur for the whole picture, mixed in by the distance to a region
around the focus: --blend region here. Ours is the filter alone on the processor, from
floats to floats; what was drawn and read back is not in it. With one thread it is the
processor's time, which other programs on the machine do not stretch, with all of them the
smallest time of all runs.
"""

import argparse
import json
import os

from bench import BUILD, run, say

SIZE = "1024x1024"
RADIUS = 16  # px, of the blurred copy

# Name in the thesis, its frames a second, our method.
ROWS = [
    ("low resolution, 128 of 1024", "> 100", "lowres:lowres-factor=8"),
    ("mipmap", "90", "mipmap"),
    ("offset, 4 copies", "-", "offset:copies=4"),
    ("offset on mipmaps", "65", "mipmap-offset"),
    ("recursive offset, 2", "63", "recursive-offset:recursions=2"),
    ("recursive offset, 3", "54", "recursive-offset:recursions=3"),
    ("convolution 1 x N", "slow", "box:box-direction=horizontal"),
    ("convolution N x N", "slow", "box"),
]


def variant(method):
    """The method as the thesis has it, for the program of ./dev bench."""
    return f"{method}:blend=region:blur-radius={RADIUS}"


def measure(size, runs):
    """Seconds of each row with one thread and with all: {variant: {threads: s}}."""
    names = [variant(method) for _, _, method in ROWS]
    all_threads = max(2, len(os.sched_getaffinity(0)))
    say(f"{len(names)} methods at {size}, {runs} runs each")
    out = run(
        *(BUILD / "tests/bench/bench", "--sizes", size, "--radii", RADIUS),
        *("--methods", ",".join(names), "--runs", runs),
        *("--limit", 600, "--views", 0, "--threads", f"1,{all_threads}"),
    )
    times = {}
    for line in out.splitlines():
        case = json.loads(line)
        seconds = case["cpu_s" if case["threads"] == 1 else "wall_s"]
        times.setdefault(case["name"], []).append((case["threads"], seconds))
    return times


def lines(times, size):
    """The table as lines of text, for people and for Markdown alike."""
    n_threads = max(n for n, _ in next(iter(times.values())))
    yield f"| at {size} | thesis, GeForce 3 | ours, 1 thread | ours, {n_threads} |"
    yield "| --- | --: | --: | --: |"
    for name, rate, method in ROWS:
        cases = sorted(times[variant(method)])
        ours = [f"{1 / seconds:.0f}" for _, seconds in (cases[0], cases[-1])]
        yield f"| {name} (`{method}`) | {rate} | {ours[0]} | {ours[1]} |"


def main():
    """The command."""
    parser = argparse.ArgumentParser(
        prog="./dev bench --thesis",
        description="Frames a second of the thesis's methods, its own and ours.",
    )
    parser.add_argument("--size", default=SIZE, help=f"WIDTHxHEIGHT; {SIZE}")
    parser.add_argument("--runs", type=int, default=15, help="of each method; 15")
    options = parser.parse_args()
    print("\n".join(lines(measure(options.size, options.runs), options.size)))


if __name__ == "__main__":
    main()
