# SPDX-License-Identifier: Apache-2.0
"""Makes the figures of docs/live.md: screenshots of `rackfocus view` under Xvfb.

    python3 docs/make_live_figures.py COMMAND

COMMAND is the built `rackfocus`. Needs what tests/view needs.
"""

import pathlib
import sys
import tempfile
import time

import numpy
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/view"))
from conftest import Display, Window  # noqa: E402

IMAGES = ROOT / "docs/images"
POSTS = ROOT / "tests/quality/references/posts_pinhole.exr"
POSTS_SIZE, DEMO_SIZE = (480, 270), (480, 270)


def write(name, pixels):
    height, width, n = pixels.shape
    out = oiio.ImageOutput.create(str(IMAGES / name))
    out.open(str(IMAGES / name), oiio.ImageSpec(width, height, n, oiio.UINT8))
    out.write_image(numpy.ascontiguousarray(pixels))
    out.close()


def sheet(pictures, columns, gap=4):
    """Pictures of one size side by side."""
    height, width, n = pictures[0].shape
    rows = -(-len(pictures) // columns)
    full = numpy.full(
        (rows * (height + gap) - gap, columns * (width + gap) - gap, n),
        255,
        numpy.uint8,
    )
    for i, picture in enumerate(pictures):
        y, x = i // columns * (height + gap), i % columns * (width + gap)
        full[y : y + height, x : x + width] = picture
    return full


def press(window, *keys):
    window.move(5, 5)
    window.key(*keys)


def show_posts(command, display, folder):
    """The whole window, and four of its views."""
    window = Window(command, display, folder, POSTS)
    window.wait_open()
    x, y = window.on_picture(320, 200)
    window.click(x, y)  # the ball
    window.wait_best()
    write("view.png", window.look())
    window.move(*window.control("Blades"))
    window.wait_text("tip", "Blades")
    time.sleep(0.5)
    write("view-tip.png", window.look_still("tip")[290:420, 110:])
    seen = []
    for key, facts in (
        ("d", {"mode": 1}),
        ("c", {"mode": 2}),
        ("b", {"mode": 3}),
    ):
        press(window, key)
        window.wait_best(**facts)
        seen.append(window.look_at_picture(*POSTS_SIZE))
    press(window, "b", "s")
    window.wait_best(mode=0, split=True)
    time.sleep(2)  # for the pinhole's half
    seen.append(window.look_at_picture(*POSTS_SIZE))
    write("view-modes.png", sheet(seen, 2))
    window.close()


def show_demo(command, display, folder):
    """Off, on, depth, focus near, focus at infinity, turned."""
    window = Window(command, display, folder, "--demo", "--demo-width", DEMO_SIZE[0])
    window.wait_open()
    seen = []
    press(window, "f")
    window.wait_shown(filter=False, pinhole=True)
    seen.append(window.look_at_picture(*DEMO_SIZE))
    press(window, "f")
    window.wait_best(filter=True)
    seen.append(window.look_at_picture(*DEMO_SIZE))
    press(window, "d")
    window.wait_best(mode=1)
    seen.append(window.look_at_picture(*DEMO_SIZE))
    press(window, "d", "n")
    window.wait_best(mode=0, focus=2.0)
    seen.append(window.look_at_picture(*DEMO_SIZE))
    press(window, "i")
    window.wait_best(focus=1e9)
    seen.append(window.look_at_picture(*DEMO_SIZE))
    window.set_number("Focus distance", "3")
    window.wait_best(focus=3.0)
    x, y = window.on_picture(240, 120)
    window.press(x, y)
    for i in range(1, 9):
        window.move(x - 10 * i, y + 5 * i)
        window.wait_shown()
    window.release()
    window.wait_best(focus=3.0)
    seen.append(window.look_at_picture(*DEMO_SIZE))
    write("view-demo.png", sheet(seen, 2))
    window.close()


def show_literature(command, display, folder):
    """Views accumulated, methods and their differences, both eyes; the four graphs."""
    small = (320, 180)
    arguments = ("--demo", "--demo-width", small[0], "--f-stop", "0.7")
    window = Window(command, display, folder, *arguments, "--demo-views", 256)
    window.wait_best(views=256)
    window.place()
    seen = [None, window.look_at_picture(*small)]
    press(window, "f")
    window.wait_shown(filter=False, pinhole=True)
    seen[0] = window.look_at_picture(*small)
    press(window, "f", "x")
    window.open_section("Compare")
    window.set_number("Gain", "4")
    window.wait_best(mode=4, views=256)
    seen.append(still(window, small))
    window.choose("Method", 0)
    window.wait_best(mode=4, method="layered")
    seen.append(still(window, small))
    window.close()
    window = Window(command, display, folder, *arguments, "--stereo")
    window.wait_open()
    seen.append(window.look_at_picture(*small))
    window.choose("Eyes", 3)
    window.wait_best()
    time.sleep(0.5)
    seen.append(window.look_at_picture(*small))
    window.close()
    write("view-literature.png", sheet(seen, 3))
    window = Window(command, display, folder, "--demo", "--demo-width", 480)
    window.wait_open()
    window.move(*window.on_picture(357, 120))  # the far picture
    window.key("y")
    window.wait_text("graphs", "distance 6")
    time.sleep(0.5)
    at = window.layout()
    write("view-graphs.png", window.look_still("graphs")[: round(at["y"]) + 60, :480])
    window.close()


def still(window, size):
    """The picture when the last input is worked off."""
    time.sleep(0.5)
    return window.look_at_picture(*size)


def main():
    command = sys.argv[1]
    display = Display(size=(1400, 1000))
    try:
        with tempfile.TemporaryDirectory() as folder:
            show_posts(command, display, folder)
            show_demo(command, display, folder)
            show_literature(command, display, folder)
    finally:
        display.close()


if __name__ == "__main__":
    main()
