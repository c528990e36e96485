# SPDX-License-Identifier: Apache-2.0
"""Memory and processor time of a frame by its size, for docs/farm.md.

    RACKFOCUS=build/cli/rackfocus python3 tests/farm/measure_sizes.py [--bounded] [WIDTH ...]

With --bounded only with --max-memory: 15360 takes 15 GiB without.

One thread, one frame: read, filter, write (half, zip). The radius grows with the width:
1 % of it. Time is of the processor, which other load changes less than the clock's.
"""

import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli")]
import plainexr  # noqa: E402

BINARY = os.path.abspath(os.environ["RACKFOCUS"])


def picture(width):
    """R, G, B and Z of discs in focus before a grainy ground."""
    height = width * 9 // 16
    y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32) / width
    near = (x * 7 % 1 - 0.5) ** 2 + (y * 7 % 1 - 0.5) ** 2 < 0.1
    grain = numpy.random.default_rng(1).random((height, width), numpy.float32)
    return {
        "R": numpy.where(near, 0.8, 0.5 * grain),
        "G": numpy.where(near, 0.4, x),
        "B": numpy.where(near, 0.1, y + 0.1 * grain),
        "Z": numpy.where(near, 2, 6 + 3 * y),
    }


def make(path, width):
    channels = picture(width)
    plainexr.write(path, {k: v.astype(numpy.float32) for k, v in channels.items()})


def measure(folder, width, *more):
    pid = subprocess.Popen(
        [BINARY, "filter", folder / f"{width}.exr", "-o", folder / "out.exr", "-q"]
        + ["-j1", "--lens-radius", "0.04", "--focal-length-px", str(width)]
        + ["--focus-distance", "3", *more]
    ).pid
    _, status, used = os.wait4(pid, 0)
    assert status == 0
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    is_bounded = "--bounded" in sys.argv
    widths = [int(w) for w in sys.argv[1:] if w != "--bounded"]
    widths = widths or [480, 960, 1920, 3840]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for width in widths:
            # In a process of its own: a child's greatest memory counts from its parent's.
            maker = multiprocessing.Process(
                target=make, args=(folder / f"{width}.exr", width)
            )
            maker.start()
            maker.join()
            # The rows of a strip need more where the picture is wider.
            bound = ["--max-memory", "1024" if width <= 7680 else "2048"]
            for more in [bound] if is_bounded else [[], bound]:
                seconds, mib = measure(folder, width, *more)
                print(
                    f"{width} x {width * 9 // 16} {' '.join(more):18} "
                    f"{seconds:7.2f} s {mib:6.0f} MiB",
                    flush=True,
                )
            (folder / f"{width}.exr").unlink()


if __name__ == "__main__":
    main()
