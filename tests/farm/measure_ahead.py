# SPDX-License-Identifier: Apache-2.0
"""What it brings that the files of one frame are read and written while another is filtered.

    RACKFOCUS=build/cli/rackfocus python3 tests/farm/measure_ahead.py [WIDTH] [FRAMES] [ROUNDS]

3840x2160, half and ZIP, from and to a folder of this machine, the page cache warm: the
clock's time of a sequence with --jobs 1 and 2 (the default), in turns, and the memory.
"""

import os
import pathlib
import statistics
import sys
import tempfile
import time

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli")]
import measure_sizes  # noqa: E402
import plainexr  # noqa: E402


def make(folder, width, count):
    made = measure_sizes.picture(width)
    channels = {k: v.astype(numpy.float16) for k, v in made.items()}
    channels["Z"] = made["Z"].astype(numpy.float32)
    plainexr.write(folder / "shot.0001.exr", channels)
    for i in range(2, count + 1):
        os.link(folder / "shot.0001.exr", folder / f"shot.{i:04d}.exr")


def run(folder, width, jobs):
    words = [measure_sizes.BINARY, "filter", folder / "shot.####.exr", "-q", "--anew"]
    words += ["-o", folder / "out.####.exr", "--lens-radius", "0.04", "--jobs", jobs]
    words += ["--focal-length-px", width, "--focus-distance", "3"]
    words += ["--compression", "zip"]
    start = time.monotonic()
    pid = os.posix_spawn(words[0], list(map(str, words)), os.environ)
    _, status, used = os.wait4(pid, 0)
    assert status == 0
    return time.monotonic() - start, used.ru_maxrss / 1024


def main():
    width, count, rounds = (
        list(map(int, sys.argv[1:])) + [3840, 8, 3][len(sys.argv) - 1 :]
    )
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make(folder, width, count)
        found = [[run(folder, width, jobs) for jobs in (1, 2)] for _ in range(rounds)]
    for i, jobs in enumerate((1, 2)):
        seconds = statistics.median(pair[i][0] for pair in found)
        memory = max(pair[i][1] for pair in found)
        print(f"--jobs {jobs}: {count} frames in {seconds:.2f} s, {seconds / count:.3f} s "
              f"each, {memory:.0f} MiB")  # fmt: skip
    ratios = [pair[1][0] / pair[0][0] for pair in found]
    print(f"2 against 1: {statistics.median(ratios):.3f} of the time "
          f"({min(ratios):.3f} to {max(ratios):.3f}); load {os.getloadavg()[0]:.1f}")  # fmt: skip


if __name__ == "__main__":
    main()
