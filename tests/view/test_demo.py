# SPDX-License-Identifier: Apache-2.0
"""The classic set-up: three pictures, turned, read back, filtered live."""

import numpy
import pytest
from conftest import read_exr, read_png

SIZE = (480, 270)


@pytest.fixture
def window(view):
    shown = view("--demo", "--demo-width", SIZE[0])
    shown.wait_open()
    return shown


def picture(window, name="shot", size=SIZE):
    return window.look_at_picture(*size, name)


def save(window, rackfocus, tmp_path):
    """(what the window saved, what the command makes of the saved colour and depth)"""
    window.move(20, 20)
    window.key("ctrl+e")
    window.wait_text("saved", "saved demo.exr")
    window.key("ctrl+s")
    window.wait_text("saved", "saved demo_focus.exr")
    return read_exr(tmp_path / "demo_focus.exr")


def command(rackfocus, tmp_path, *options):
    out = tmp_path / "command.exr"
    rackfocus(
        "filter", tmp_path / "demo.exr", "-o", out, "--type", "float",
        "--method", "scatter", "--optics", "yu", *options,
    )  # fmt: skip
    return read_exr(out)


def test_it_is_what_the_command_makes(window, rackfocus, tmp_path):
    """Bit for bit, from the saved colour and depth buffer."""
    saved = save(window, rackfocus, tmp_path)
    assert saved.shape == (SIZE[1], SIZE[0], 3)
    assert numpy.array_equal(saved, command(rackfocus, tmp_path))
    passes = read_exr(tmp_path / "demo.exr")
    assert numpy.abs(passes[..., :3] - saved).max() > 0.1


def test_depth_is_unprojected(window, rackfocus, tmp_path):
    """The three pictures stand at 2, 3 and 6; the buffer says n f / (f - z (f - n))."""
    save(window, rackfocus, tmp_path)
    z = read_exr(tmp_path / "demo.exr")[..., 3]
    near, far = 0.5, 50.0
    depth = near * far / (far - z * (far - near))
    assert z.max() == 1 and z.min() > 0
    for distance in (2, 3, 6):
        assert (numpy.abs(depth - distance) < 1e-3).mean() > 0.01, distance
    assert "2" in rackfocus("info", tmp_path / "demo.exr").stdout


@pytest.mark.parametrize("size", [SIZE, (160, 90)])
def test_turning_the_scene(view, rackfocus, tmp_path, size):
    """A drag turns it, live; the turned scene is the command's too.

    The small one is filtered so fast that no preview comes before the best picture.
    """
    window = view("--demo", "--demo-width", size[0])
    window.wait_open()
    before = picture(window, "demo", size)
    x, y = window.on_picture(size[0] / 2, size[1] / 2)
    window.drag([(x + 5 * i, y + 3 * i) for i in range(9)])
    after = picture(window, "demo_turned", size)
    assert (before != after).any(axis=-1).mean() > 0.3
    saved = save(window, rackfocus, tmp_path)
    assert numpy.array_equal(saved, command(rackfocus, tmp_path))


def test_off_on_depth_near_infinity(window, rackfocus, tmp_path):
    on = picture(window)
    window.move(20, 20)
    window.key("f")
    window.wait_shown(filter=False, pinhole=True)
    off = picture(window, "demo_off")
    assert not numpy.array_equal(on, off)
    window.move(20, 20)
    window.key("f", "d")
    window.wait_best(mode=1)
    depth = picture(window, "demo_depth")
    assert depth.min() == 0 and depth.max() == 255
    window.move(20, 20)
    window.key("d", "n")
    window.wait_best(mode=0, focus=2.0)
    near = picture(window, "demo_near")
    window.move(20, 20)
    window.key("i")
    window.wait_best(focus=1e9)
    far = picture(window, "demo_infinity")
    for other in (on, off, far):
        assert not numpy.array_equal(near, other)
    # What is in focus is the pinhole's: the near picture there, the far one here.
    left = (slice(150, 200), slice(60, 110))
    assert numpy.abs(near[left].astype(int) - off[left]).mean() < 3
    assert numpy.abs(far[left].astype(int) - off[left]).mean() > 3
    saved = save(window, rackfocus, tmp_path)
    made = command(rackfocus, tmp_path, "--focus-distance", "1e9")
    assert numpy.array_equal(saved, made)


def test_a_picture_of_one_s_own(view, window, tmp_path, rackfocus):
    """The three pictures can be any file."""
    from conftest import plainexr

    red = numpy.full((40, 60), 0.7, numpy.float32)
    path = plainexr.write(tmp_path / "red.exr", {"R": red, "G": 0 * red, "B": 0 * red})
    window.quit()
    own = view("--demo", path, "--demo-width", SIZE[0])
    own.wait_open()
    seen = picture(own).astype(int)
    assert ((seen[..., 0] > 150) & (seen[..., 1] < 40)).mean() > 0.1


def test_both_eyes(view, rackfocus, tmp_path):
    """Each eye is what the command makes of its saved colour and depth; the picture at
    the screen's distance has one place, what is nearer is crossed."""
    window = view("--demo", "--demo-width", SIZE[0])
    window.wait_open()
    window.click_control("Both eyes")
    window.wait_best()
    window.move(20, 20)
    window.key("ctrl+e")
    window.wait_text("saved", "demo_right.exr")
    words = window.copied()
    assert words[:4] == ["rackfocus", "filter", "demo.exr", "demo_right.exr"]
    out = tmp_path / "eye_%V.png"
    rackfocus(
        "filter", tmp_path / "demo.exr", tmp_path / "demo_right.exr", "--stereo",
        "-o", out, "--method", "scatter", "--optics", "yu",
    )  # fmt: skip
    eyes = [read_png(tmp_path / f"eye_{name}.png") for name in ("left", "right")]
    both = numpy.concatenate([eyes[0][..., :1], eyes[1][..., 1:]], axis=-1)
    assert window.sees(both, "demo_anaglyph")
    window.choose("Eyes", 1)
    assert window.sees(eyes[1], "demo_right")
    z = [read_exr(tmp_path / name)[..., 3] for name in ("demo.exr", "demo_right.exr")]
    middles = []
    for buffer in z:
        depth = 0.5 * 50 / (50 - buffer * 49.5)
        middles.append(
            [numpy.nonzero(abs(depth - d) < 1e-3)[1].max() for d in (2, 3, 6)]
        )
    near, screen, far = (left - right for left, right in zip(*middles, strict=True))
    focal_px = SIZE[0] * 85 / 36
    assert screen == pytest.approx(0, abs=1)
    assert near == pytest.approx(0.065 * focal_px * (1 / 2 - 1 / 3), abs=1.5)
    assert far == pytest.approx(0.065 * focal_px * (1 / 6 - 1 / 3), abs=1.5)
    window.move(20, 20)
    window.key("v")
    window.wait_text("said", "one eye")


def test_both_eyes_from_the_start(view):
    window = view("--demo", "--stereo", "--demo-width", SIZE[0])
    window.wait_open()
    assert "Eyes" in window.layout()["controls"]
    window.click_control("Both eyes")
    window.wait_until(lambda: "Eyes" not in window.layout()["controls"], "one eye")
