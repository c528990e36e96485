# SPDX-License-Identifier: Apache-2.0
"""The whole command against a mere copy: read, filter, write; oiiotool's read and write.

    RACKFOCUS=build/cli/rackfocus python3 tests/farm/measure_oiiotool.py [ROUNDS] [THREADS]

1920x1080, RGBA half and Z float, ZIP; radii up to 32 px. Processor time (user and
system) and the clock's, medians of rounds that alternate. Needs openimageio-tools.
"""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli")]
import measure_sizes  # noqa: E402
import plainexr  # noqa: E402

WIDTH, RADIUS_PX = 1920, 32


def make(folder):
    plain, path = folder / "plain.exr", folder / "in.exr"
    made = measure_sizes.picture(WIDTH)
    made["A"] = numpy.ones_like(made["G"])
    channels = {k: v.astype(numpy.float16) for k, v in made.items()}
    channels["Z"] = made["Z"].astype(numpy.float32)
    plainexr.write(plain, channels)
    subprocess.run(["oiiotool", plain, "--compression", "zip", "-o", path], check=True)
    plain.unlink()
    return path


def run(words):
    start = time.time()
    pid = subprocess.Popen(list(map(str, words))).pid
    _, status, used = os.wait4(pid, 0)
    assert status == 0, words
    return used.ru_utime + used.ru_stime, time.time() - start


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    threads = sys.argv[2] if len(sys.argv) > 2 else "1"
    # radius = focal length in px * lens radius * |1 / z - 1 / focus|, most of all at 2
    lens = RADIUS_PX / (WIDTH * (1 / 2 - 1 / 3))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        path = make(folder)
        own = [measure_sizes.BINARY, "filter", path, "-o", folder / "out.exr", "-q"]
        own += ["-j", threads, "--lens-radius", lens, "--focal-length-px", WIDTH]
        own += ["--focus-distance", 3]
        copy = ["oiiotool", "--threads", threads, path, "-o", folder / "copy.exr"]
        times = [(run(own), run(copy)) for _ in range(rounds)]
        for i, what in enumerate(("processor", "clock")):
            mine = statistics.median(t[0][i] for t in times)
            theirs = statistics.median(t[1][i] for t in times)
            print(
                f"{what}: {mine:.3f} s, oiiotool {theirs:.3f} s, "
                f"{mine / theirs:.2f} of it; load {os.getloadavg()[0]:.1f}"
            )


if __name__ == "__main__":
    main()
