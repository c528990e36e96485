# SPDX-License-Identifier: Apache-2.0
"""Measures `rackfocus view` for the table of docs/notebook/live.md.

    python3 docs/measure_live.py COMMAND [SECONDS]

COMMAND is the built `rackfocus`. Needs what tests/view needs. The windows run at
real-time priority where the system allows it, so that other programs count for little.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/view"))
from conftest import Display  # noqa: E402

POSTS = ROOT / "tests/quality/references/posts_pinhole.exr"
SIZE = (960, 540)
PATTERNS = (
    r"updates \d+, ([\d.]+) a second",
    r"median ([\d.]+) ms",
    r"95 % within ([\d.]+) ms",
    r"longest ([\d.]+) ms",
    r"filter ([\d.]+) %",
    r"to 8 bit ([\d.]+) %",
    r"drawing ([\d.]+) %",
)


def magnify(path):
    """The posts, as many px as the table says."""
    small = oiio.ImageBuf(str(POSTS))
    roi = oiio.ROI(0, SIZE[0], 0, SIZE[1], 0, 1, 0, small.nchannels)
    large = oiio.ImageBufAlgo.resample(small, False, roi)
    assert large.write(str(path)), large.geterror()


def measure(command, seconds, *arguments):
    """The figures of PATTERNS for one window."""
    display = Display((1300, 800))
    first = ["chrt", "-r", "20"]
    if subprocess.run([*first, "true"], capture_output=True).returncode:
        first = []
    else:
        real_time = ["chrt", "-r", "-p", "20", str(display.server.pid)]
        subprocess.run(real_time, check=True)
    try:
        done = subprocess.run(
            [*first, command, "view", *map(str, arguments), "--benchmark", seconds],
            env=display.environment(),
            capture_output=True,
            text=True,
            check=True,
        )
    finally:
        display.close()
    print(done.stdout)
    return [float(re.search(pattern, done.stdout)[1]) for pattern in PATTERNS]


def main():
    command, *rest = sys.argv[1:]
    seconds = rest[0] if rest else "6"
    with tempfile.TemporaryDirectory() as folder:
        posts = pathlib.Path(folder) / "posts.exr"
        magnify(posts)
        rows = {
            "posts, magnified twice (`layered`)": (posts,),
            "`--demo` (`scatter`)": ("--demo",),
            "`--demo`, the scene is turned": ("--demo", "--benchmark-turn"),
        }
        for name, arguments in rows.items():
            rate, median, most, longest, *shares = measure(command, seconds, *arguments)
            texts = [f"{share} %" for share in shares]
            print(
                f"| {name} | {rate} | {median:.0f} ms, {most:.0f} ms, {longest:.0f} ms "
                f"| {' | '.join(texts)} |\n"
            )


main()
