# SPDX-License-Identifier: Apache-2.0
"""`rackfocus view` driven for real: what it shows is what the command line makes."""

import shlex
import subprocess

import numpy
import pytest
from conftest import DISC, FAR, HEIGHT, NEAR, WALL, WIDTH, read_exr

MODES = {"picture": 0, "depth": 1, "blur": 2, "in focus": 3, "difference": 4}


@pytest.fixture
def window(view, passes):
    shown = view(passes())
    shown.wait_open()
    return shown


def picture(window, name="shot"):
    return window.look_at_picture(WIDTH, HEIGHT, name)


def test_opens_with_the_best_picture(window, passes, command_picture):
    """What `rackfocus filter` makes, byte for byte.

    A preview comes first (tests/view/test_worker.c), but nobody sees it where drawing
    the window for the first time takes longer than the picture.
    """
    assert window.sees(command_picture(passes()), "view")
    window.quit()


def test_type_a_focus_distance(window, passes, command_picture):
    window.set_number("Focus distance", "5.5")
    window.wait_best(focus=5.5)
    want = command_picture(passes(), "--focus-distance", "5.5")
    assert window.sees(want)


def test_click_on_an_object(window, passes, command_picture):
    """The depth below the mouse is in focus; so is what the command makes of it."""
    window.click(*window.on_picture(*DISC))
    window.wait_best(focus=NEAR)
    seen = command_picture(passes(), "--focus-distance", str(NEAR))
    assert window.sees(seen)
    window.click(*window.on_picture(*WALL))
    window.wait_best(focus=FAR)
    assert not numpy.array_equal(picture(window), seen)


def test_the_screen_follows_the_focus(window):
    """Yu 2004: s = f d / (d - f), f = 50 mm in decimetres; typing it sets the focus."""
    window.set_number("Focus distance", "4")
    shown = window.wait_best(focus=4.0)
    assert shown["screen"] == pytest.approx(0.5 * 4 / (4 - 0.5))
    window.set_number("Screen position", "0.6")
    shown = window.wait_best(screen=0.6)
    assert shown["focus"] == pytest.approx(0.6 * 0.5 / (0.6 - 0.5), rel=1e-5)


def test_drag_the_aperture(window, passes, command_picture):
    """While the slider moves pictures follow, previews unless the method is as fast.

    At rest comes the best picture.
    """
    x, y = window.control("f-stop")
    window.drag([(x - 4 * i, y) for i in range(9)])
    words = window.copied()
    f_stop = float(words[words.index("--f-stop") + 1])
    assert 2.0 < f_stop < 3.0  # a little left of the middle of 0.5 to 64
    shown = [e for e in window.events() if e.get("quality") in ("preview", "best")]
    assert len(shown) >= 8
    want = command_picture(passes(), "--f-stop", repr(f_stop))
    assert window.sees(want)


def test_a_blur_that_is_cut_is_told(window, passes, rackfocus):
    """The slider goes on, the picture does not: what filter warns of."""
    window.set_number("Lens radius", "20")
    said = window.wait_text("cut", "The blur")
    assert said.startswith(
        "The blur is cut at a radius of 160 px, half the longer side"
    )
    to = window.folder / "cut.exr"
    told = rackfocus("filter", passes(), "-o", to, "--lens-radius", "20").stderr
    assert "the blur is cut at a radius of 160 px, half the longer side" in told
    window.set_number("Max radius", "150")
    assert window.wait(lambda e: e["event"] == "cut")["text"] == ""


def test_every_field_reaches_the_filter(window, passes, command_picture):
    """Blades, rotation, ratio, focal length, method: as the options say."""
    window.set_number("f-stop", "1.2")
    window.set_number("Blades", "5")
    window.set_number("Rotation", "20")
    window.set_number("Ratio", "1.5")
    window.set_number("Focal length", "60")
    window.wait_best(f_stop=1.2)
    window.click(*window.on_picture(*DISC))
    window.wait_best(focus=NEAR)
    options = ["--f-stop", "1.2", "--blades", "5", "--blade-rotation", "20"]
    options += ["--aperture-ratio", "1.5", "--focal-length", "60"]
    options += ["--focus-distance", str(NEAR)]
    assert window.sees(command_picture(passes(), *options))
    window.click_control("Method")  # opens the list; scatter is the second
    x, y = window.control("Method")
    window.click(x, y + 2 * 26)
    shown = window.wait_best(method="scatter")
    assert shown["times"] == 1
    want = command_picture(passes(), *options, "--method", "scatter")
    assert window.sees(want)


def test_filter_off_and_on(window, passes, command_picture):
    on = picture(window)
    pinhole = command_picture(passes(), "--f-stop", "1e6")
    window.move(20, 20)
    window.key("f")
    window.wait_shown(filter=False, pinhole=True)
    assert window.sees(pinhole)
    assert not numpy.array_equal(on, pinhole)
    window.move(20, 20)
    window.key("f")
    window.wait_best(filter=True)
    assert window.sees(on)


def test_maps(window):
    """Depth: lighter is farther. Blur: colour by sign. In focus: colour or grey."""
    near, far = (DISC[1], DISC[0]), (WALL[1], WALL[0])
    window.move(20, 20)
    window.key("d")
    window.wait_best(mode=MODES["depth"])
    depth = picture(window, "depth")
    assert tuple(depth[near]) == (0, 0, 0) and tuple(depth[far]) == (255, 255, 255)
    window.move(20, 20)
    window.key("c")
    window.wait_best(mode=MODES["blur"])
    blur = picture(window, "blur")
    assert blur[near][0] > 200 > blur[near][2]  # before the focus: orange
    assert tuple(blur[far]) == (0, 0, 0)  # in focus
    window.click(*window.on_picture(*DISC))
    window.wait_best(mode=MODES["blur"], focus=NEAR)
    blur = picture(window)
    assert tuple(blur[near]) == (0, 0, 0) and blur[far][2] > 200 > blur[far][0]
    window.move(20, 20)
    window.key("b")
    window.wait_best(mode=MODES["in focus"])
    band = picture(window, "band").astype(int)
    assert band[near][0] > 2 * band[near][2]  # the disc's own colour
    assert band[far][0] == band[far][1]  # grey
    window.move(20, 20)
    window.key("b")
    window.wait_best(mode=MODES["picture"])


def test_split(window, passes, command_picture):
    """The pinhole to the left of the line, the lens's picture to the right."""
    lens = picture(window)
    pinhole = command_picture(passes(), "--f-stop", "1e6")
    window.move(20, 20)
    window.key("s")
    window.wait_shown(pinhole=True, split=True)
    seen = picture(window, "split")
    assert numpy.array_equal(seen[:, :155], pinhole[:, :155])
    assert numpy.array_equal(seen[:, 165:], lens[:, 165:])
    x, y = window.on_picture(160, 100)
    window.press(x, y)
    window.move(x - 60, y)
    window.move(x - 80, y)
    window.release()

    def is_moved(seen):
        left = numpy.array_equal(seen[:, :75], pinhole[:, :75])
        return left and numpy.array_equal(seen[:, 85:], lens[:, 85:])

    assert is_moved(window.look_until(is_moved, lambda: picture(window)))


def test_difference_to_a_reference(view, passes, rackfocus, tmp_path):
    """Black where the picture is the reference, heat where it is not."""
    path, reference = passes(), tmp_path / "reference.exr"
    rackfocus("filter", path, "-o", reference, "--type", "float")
    window = view(path, "--reference", reference)
    window.wait_open()
    window.key("x")
    window.wait_best(mode=MODES["difference"])
    assert picture(window).max() == 0
    window.click(*window.on_picture(*DISC))
    window.wait_best(mode=MODES["difference"], focus=NEAR)
    assert picture(window, "difference").max() > 100


def test_exposure_is_only_the_view_s(window, tmp_path, passes, command_picture):
    """A stop darker on the screen; the saved picture does not change."""
    bright = picture(window)
    window.set_number("Exposure", "-1")
    window.wait_best()

    def is_dark(seen):
        return seen.mean() < 0.85 * bright.mean()

    assert is_dark(window.look_until(is_dark, lambda: picture(window)))
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved passes_focus.exr")
    saved = read_exr(tmp_path / "passes_focus.exr")
    assert saved.max() == pytest.approx(0.9, abs=0.01)


def test_save_and_the_command_line(window, passes, rackfocus, tmp_path, binary):
    """The saved picture, the saved parameters and the copied command line agree."""
    window.click(*window.on_picture(*DISC))
    window.set_number("f-stop", "1.7")
    window.wait_best(focus=NEAR, f_stop=1.7)
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved passes_focus.exr")
    window.key("ctrl+p")
    window.wait_text("saved", "saved passes_focus.params")
    window.key("ctrl+c")
    window.wait_text("said", "copied")
    window.quit()
    saved = read_exr(tmp_path / "passes_focus.exr")
    line = window.printed().strip().splitlines()[-1]
    assert line.startswith("rackfocus filter ") and "--f-stop 1.7" in line
    (tmp_path / "passes_focus.exr").unlink()
    words = shlex.split(line)
    subprocess.run([binary, *words[1:]], check=True, cwd=tmp_path)
    assert numpy.array_equal(read_exr(tmp_path / "passes_focus.exr"), saved)
    other = tmp_path / "other.exr"
    params = tmp_path / "passes_focus.params"
    rackfocus("filter", passes(), "-o", other, "--params", params)
    assert numpy.array_equal(read_exr(other), saved)
    assert "f-stop 1.7" in params.read_text()


def test_save_as_png_under_another_name(window, tmp_path, passes, command_picture):
    window.click_control("File")
    window.type("sub.png")
    window.key("Return")
    window.click_control("Save picture")
    window.wait_text("saved", "saved sub.png")
    from conftest import read_png

    assert numpy.array_equal(read_png(tmp_path / "sub.png"), command_picture(passes()))


def test_names_that_cannot_be_saved(window):
    for name, part in [("a.jpg", "EXR or PNG"), ("no/such/a.exr", "cannot write")]:
        window.click_control("File")
        window.type(name)
        window.key("Return")
        window.click_control("Save picture")
        window.wait_text("said", part)


def test_zoom_pan_and_pick(window):
    """Wheel and drag move the picture; a click finds the px that is seen there."""
    x, y = window.on_picture(*DISC)
    window.move(x, y)
    for _ in range(8):
        window.tool("click", 4)
    window.wait(lambda e: e["event"] == "layout" and e["scale"] > 3.9, "the zoom")
    at = window.layout()
    assert at["scale"] == pytest.approx(4, rel=1e-6)
    back = window.on_picture(*DISC)
    assert back == pytest.approx((x, y), abs=4)
    window.press(x, y)
    window.move(x + 30, y)
    window.move(x + 150, y)
    window.release()
    window.wait(lambda e: e["event"] == "layout" and e["x"] > at["x"] + 100, "the pan")
    px, py = (round(v) for v in window.on_picture(*DISC))

    def is_square(seen):  # a px is a square of one colour
        block = seen[py - 1 : py + 2, px - 1 : px + 2].reshape(-1, 3)
        return (block == block[0]).all()

    assert is_square(window.look_until(is_square, lambda: window.look("zoomed")))
    window.click(*window.on_picture(*DISC))
    window.wait_best(focus=NEAR)
    window.key("1")
    window.wait(lambda e: e["event"] == "layout" and e["scale"] == 1, "one to one")
    window.key("0")


def test_by_keyboard_alone(window):
    """Tab to a field, type, Tab on; commands without the mouse."""
    window.move(20, 20)
    window.key("Tab", "Tab")  # past the heading
    window.type("4.5")
    window.key("Return")
    window.wait_best(focus=4.5)
    window.key("Right")
    window.wait(
        lambda e: e["event"] == "shown" and e["focus"] > 4.5 and e["quality"] == "best",
        "a focus behind 4.5",
    )
    window.key("Escape", "space")  # the middle of the window is the disc
    window.wait_best(focus=NEAR)
    window.key("i")
    window.wait_best(focus=1e9)
    window.type("[")  # into the scene at once, to its farthest thing
    window.wait_best(focus=FAR)
    window.type("[")
    window.wait_best(focus=float(f"{FAR / 1.05:.6g}"))
    window.type("]")
    window.wait_best(focus=FAR)
    window.key("n")
    window.wait_best(focus=NEAR)
    before = window.events()[-1]
    window.type(",,,")  # a stop wider
    shown = window.wait_best(f_stop=2 / 2**0.5)
    assert shown["id"] > before.get("id", 0)
    window.type("]")
    window.wait_best(focus=NEAR * 1.05)
    plain = window.look()

    def has_help(seen):
        return (seen != plain).any(axis=-1).mean() > 0.02

    window.key("F1")
    assert has_help(window.look_until(has_help, lambda: window.look("help")))
    window.move(20, 20)
    window.key("F1")
    assert not has_help(window.look_until(lambda seen: not has_help(seen)))


def test_a_lens_that_cannot_be(window):
    """Yu's lens does not focus inside its focal length: said, and nothing changes."""
    window.click_control("Optics")
    x, y = window.control("Optics")
    window.click(x, y + 3 * 26)  # yu is the third
    window.wait_best(screen=0.5 * FAR / (FAR - 0.5))
    window.set_number("Focus distance", "0.3")
    window.move(20, 20)
    window.key("d", "d")
    assert window.wait_best(mode=0)["focus"] == FAR
    window.quit()
