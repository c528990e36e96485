# SPDX-License-Identifier: Apache-2.0
"""A PNG has no windows: it shows the display window, as other programs do."""

import json
import shutil

import numpy
import plainpng
import pytest

WIDTH, HEIGHT = 48, 32  # of the data window
LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "60"]

# Data and display windows: a crop, one that only begins beyond the display, an overscan,
# a window that lies beside the other in part.
WINDOWS = {
    "crop": ((10, 5, 57, 36), (0, 0, 79, 59)),
    "corner": ((-20, -10, 27, 21), (-20, -10, 59, 49)),
    "overscan": ((-4, -3, 43, 28), (0, 0, 39, 25)),
    "beside": ((-10, 5, 37, 36), (0, 0, 79, 19)),
}


def add_alpha(channels):
    """All of the picture, so that what is beyond it can be told from it."""
    channels["A"] = numpy.ones_like(channels["R"])


def on_canvas(whole, data, display):
    """Pixels of the data window where they lie in the display window; 0 elsewhere."""
    x0, y0, x1, y1 = display
    reach = 100
    wide = numpy.zeros((2 * reach, 2 * reach, whole.shape[2]), int)
    top, left = data[1] + reach, data[0] + reach
    wide[top : top + HEIGHT, left : left + WIDTH] = whole
    return wide[y0 + reach : y1 + reach + 1, x0 + reach : x1 + reach + 1]


def make(rackfocus, words, path, out):
    """The picture of one of the commands that write a PNG."""
    if words == "accumulate":
        second = path.replace("passes", "second")
        shutil.copy(path, second)
        rackfocus("accumulate", path, second, "-o", out)
    elif words == "over":
        rackfocus("filter", path, path, "--over", "-o", out, *LENS)
    else:
        rackfocus("filter", path, "-o", out, *LENS, *words.split())


@pytest.mark.parametrize("words", ["", "--method scatter", "over", "accumulate"])
@pytest.mark.parametrize("name", WINDOWS)
def test_a_png_shows_the_display_window(rackfocus, scene, tmp_path, words, name):
    """It showed the data window: frames of a cropped shot were of different sizes, and an
    overscan was seen."""
    data, display = WINDOWS[name]
    out = tmp_path / "out.png"
    lens = {"change": add_alpha, "data": data}
    make(rackfocus, words, scene(**lens, display=data), out)
    whole = plainpng.read(out)
    assert whole.shape == (HEIGHT, WIDTH, 4) and (whole[..., 3] == 255).all()
    make(rackfocus, words, scene(**lens, display=display), out)
    shown, want = plainpng.read(out), on_canvas(whole, data, display)
    assert shown.shape == want.shape
    assert (shown[..., 3] == want[..., 3]).all()
    assert abs(shown - want).max() <= 1


@pytest.mark.parametrize("name", [*WINDOWS, "moved"])
def test_compare_looks_at_the_same_window(rackfocus, scene, tmp_path, name):
    """Beside a PNG all of the EXR's display window is meant: another size was refused, and
    windows of one size were laid corner on corner."""
    data, display = {**WINDOWS, "moved": ((-5, 3, 42, 34), (0, 0, 47, 31))}[name]
    path = scene(data=data, display=display)
    exr, png, heat = (tmp_path / f for f in ("out.exr", "out.png", "heat.png"))
    for out in (exr, png):
        rackfocus("filter", path, "-o", out, *LENS)
    for pair in ((exr, png), (png, exr)):
        said = rackfocus("compare", *pair, "--json", "--heatmap", heat).stdout
        found = json.loads(said)
        assert found["tpsnr"] > 50  # 8 bits
        assert (found["height"], found["width"]) == plainpng.read(png).shape[:2]
        assert plainpng.read(heat).shape[:2] == plainpng.read(png).shape[:2]


def test_grey_and_rgb_are_placed_alike(rackfocus, scene, tmp_path):
    data, display = WINDOWS["crop"]
    out = tmp_path / "out.png"
    make(rackfocus, "", scene(data=data, display=data), out)
    whole = plainpng.read(out)
    make(rackfocus, "", scene(data=data, display=display), out)
    assert whole.shape[2] == 3
    assert (plainpng.read(out) == on_canvas(whole, data, display)).all()


@pytest.mark.parametrize(
    "display, part",
    [
        ((100, 0, 140, 30), "in which nothing of its data window lies; write .exr"),
        ((0, 0, 99999, 31), "which has 100000 x 32 px; write .exr"),
    ],
)
def test_windows_without_a_picture(rackfocus, scene, tmp_path, display, part):
    path, second = scene(display=display), scene("second.exr", display=display)
    out = tmp_path / "out.png"
    said = rackfocus("accumulate", path, second, "-o", out, code=1).stderr
    assert f"{out}: a PNG shows the display window of {path}, " + part in said
    assert not out.exists()
    rackfocus("accumulate", path, second, "-o", tmp_path / "out.exr")


def test_frames_that_are_cropped_are_of_one_size(rackfocus, scene, tmp_path):
    """A compositor writes of each frame what is there."""
    display = (0, 0, 79, 59)
    for i in range(3):
        data = (5 * i, i, 5 * i + WIDTH - 1 - 4 * i, i + HEIGHT - 1)
        scene(f"s.{i}.exr", (WIDTH - 4 * i, HEIGHT), data=data, display=display)
    shot = [tmp_path / "s.#.exr", "-o", tmp_path / "o.#.png"]
    assert "sizes" not in rackfocus("filter", *shot, *LENS).stderr
    sizes = {plainpng.read(tmp_path / f"o.{i}.png").shape for i in range(3)}
    assert sizes == {(60, 80, 3)}
