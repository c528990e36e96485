# SPDX-License-Identifier: Apache-2.0
"""Views that OpenGL draws from points of the lens, accumulated, as the reference."""

import re

import numpy
import pytest
from conftest import plainexr, read_exr

SIZE = (480, 270)
FOCUS, NEAR, FAR = 3.0, 2.0, 6.0
FOCAL, SENSOR = 0.085, 0.036
FOCAL_PX = SIZE[0] * FOCAL / SENSOR


def radius_px(z, focus=FOCUS, f_stop=1.4):
    """Yu's circle of confusion of the demo's lens."""
    screen = FOCAL * focus / (focus - FOCAL)
    scale = FOCAL / (2 * f_stop) * FOCAL_PX * screen / FOCAL
    return abs(scale * (1 / focus - 1 / z))


def place(x, y, z):
    """Where the demo's camera sees a point, px."""
    return SIZE[0] / 2 + FOCAL_PX * x / z, SIZE[1] / 2 - FOCAL_PX * y / z


@pytest.fixture
def demo(view, tmp_path):
    """The demo with a picture that is black but for a spot in its middle."""

    def start(*options, n=256, has_spot=True):
        arguments = ["--demo"]
        if has_spot:
            spot = numpy.zeros((64, 64), numpy.float32)
            spot[30:34, 30:34] = 1
            path = plainexr.write(tmp_path / "spot.exr", dict.fromkeys("RGB", spot))
            arguments.append(path)
        window = view(*arguments, "--demo-width", SIZE[0], "--demo-views", n, *options)
        window.wait_text("accumulated", f"{n} views")
        window.wait_best(views=n)
        window.place()
        return window

    return start


def save(window, tmp_path):
    """(colour and depth, the mean of the views, the filtered picture)"""
    for path in tmp_path.glob("demo*.exr"):
        path.unlink()
    window.move(20, 20)
    window.key("ctrl+e")
    window.wait_text("saved", "demo_views.exr")
    window.key("ctrl+s")
    window.wait_text("saved", "saved demo_focus.exr")
    names = ("demo.exr", "demo_views.exr", "demo_focus.exr")
    return [read_exr(tmp_path / name) for name in names]


def variance(picture, at, reach):
    """Mean square distance along x and y of the light around a place, from its middle."""
    x, y = (round(v) for v in at)
    light = picture[y - reach : y + reach + 1, x - reach : x + reach + 1, 1]
    light = light - light[0, 0]  # what is spread over all of it, from other spots
    rows, columns = numpy.mgrid[-reach : reach + 1, -reach : reach + 1]
    total = light.sum()
    middle = (rows * light).sum() / total, (columns * light).sum() / total
    return [
        (((side - centre) ** 2) * light).sum() / total
        for side, centre in zip((columns, rows), middle, strict=True)
    ]


SPOTS = {NEAR: (-0.2, -0.04), FAR: (0.62, 0.08)}
REACH = {NEAR: 26, FAR: 15}  # px, within the black of the picture


@pytest.mark.parametrize("pattern, share", [("disc", 1 / 4), ("circle", 1 / 2)])
def test_the_blur_is_the_formulas(demo, tmp_path, pattern, share):
    """A disc of radius r has the mean square r^2 / 4 along x, its rim r^2 / 2."""
    window = demo("--lens-pattern", pattern)
    pinhole, views, _ = save(window, tmp_path)
    for z, (x, y) in SPOTS.items():
        sharp = variance(pinhole, place(x, y, z), REACH[z])
        blurred = variance(views, place(x, y, z), REACH[z])
        for before, after in zip(sharp, blurred, strict=True):
            want = radius_px(z) ** 2 * share
            assert after - before == pytest.approx(want, rel=0.06), (pattern, z)


def test_shift_leaves_the_plane_in_focus(demo, tmp_path):
    """Look-at does not: only the middle of its plane stays."""
    wide = ("--f-stop", 0.1, "--focus-distance", FAR)
    window = demo(*wide)
    pinhole, shifted, _ = save(window, tmp_path)
    at = place(*SPOTS[FAR], FAR)
    sharp = sum(variance(pinhole, at, 10))
    assert sum(variance(shifted, at, 10)) == pytest.approx(sharp, abs=0.06)
    window.choose("Camera move", 1)
    window.wait_text("accumulated", "256 views")
    _, turned, _ = save(window, tmp_path)
    assert sum(variance(turned, at, 10)) > sum(variance(shifted, at, 10)) + 0.08


def test_the_number_on_the_screen(demo, rackfocus, tmp_path):
    """Is that of rackfocus compare, for every method that is chosen."""
    window = demo(has_spot=False)
    seen = {}
    methods = ("scatter", "layered", "box")
    for method, index in zip(methods, (1, 0, 2), strict=True):
        if method != "scatter":
            window.choose("Method", index)
        shown = window.wait_best(method=method, views=256) if seen else None
        save(window, tmp_path)
        out = rackfocus("compare", "demo_focus.exr", "demo_views.exr", cwd=tmp_path)
        seen[method] = float(re.search(r"tPSNR\s+([\d.]+)", out.stdout)[1])
        shown = shown or [e for e in window.events() if e.get("views") == 256][-1]
        assert shown["tpsnr"] == pytest.approx(seen[method], abs=0.01)
    assert seen["layered"] > seen["scatter"] + 3 > seen["box"]
    assert seen["layered"] > 30


def test_flip_wipe_and_difference(demo, tmp_path):
    window = demo(n=64, has_spot=False)
    _, views, filtered = save(window, tmp_path)
    window.move(20, 20)
    window.key("f")
    window.wait_shown(filter=False, pinhole=True)
    assert window.sees(encode(views), "views")
    window.key("f", "s")
    wiped = window.look_until(
        lambda seen: numpy.array_equal(seen[:, :200], encode(views)[:, :200]),
        lambda: window.look_at_picture(*SIZE, "views_split"),
    )
    assert numpy.array_equal(wiped[:, :200], encode(views)[:, :200])
    assert numpy.array_equal(wiped[:, 280:], encode(filtered)[:, 280:])
    window.move(20, 20)
    window.key("s", "x")
    shown = window.wait_best(mode=4, views=64)
    plain = window.look_at_picture(*SIZE, "views_difference")
    window.open_section("Compare")
    window.set_number("Gain", "8")
    assert window.wait_best(mode=4)["tpsnr"] == pytest.approx(shown["tpsnr"])
    magnified = window.look_until(
        lambda seen: seen.mean() > 1.5 * plain.mean(),
        lambda: window.look_at_picture(*SIZE, "views_difference_8"),
    )
    assert magnified.mean() > 1.5 * plain.mean()


def encode(picture):
    """Linear light as the screen shows it."""
    v = picture[..., :3]
    low, high = 12.92 * v, 1.055 * numpy.maximum(v, 0.0031308) ** (1 / 2.4) - 0.055
    curve = numpy.where(v <= 0.0031308, low, high).clip(0, 1)
    return numpy.rint(curve * 255).astype(numpy.uint8)


def test_turning_begins_anew(demo, tmp_path):
    window = demo(n=64)
    _, before, _ = save(window, tmp_path)
    x, y = window.on_picture(SIZE[0] / 2, SIZE[1] / 2)
    window.press(x, y)
    window.move(x + 60, y + 20)
    window.release()
    window.wait_text("accumulated", "64 views")
    pinhole, after, _ = save(window, tmp_path)
    assert numpy.abs(after - before).max() > 0.1
    # It is of the scene as it is now: what is sharp is where the pinhole has it.
    assert numpy.abs(after - pinhole[..., :3]).mean() < numpy.abs(after - before).mean()


def test_one_view_is_the_pinhole(demo, tmp_path):
    pinhole, views, _ = save(demo(n=1, has_spot=False), tmp_path)
    assert numpy.array_equal(pinhole[..., :3], views)


def test_on_and_off_by_key_and_panel(view, tmp_path):
    window = view("--demo", "--demo-width", SIZE[0])
    window.wait_open()
    assert "Views" in window.layout()["off"]
    window.move(20, 20)
    window.key("v")
    window.wait_text("accumulated", "256 views")
    window.wait_best(views=256)
    window.set_number("Views", "16")
    window.wait_text("accumulated", "16 views")
    window.choose("Points", -1)
    window.wait_text("accumulated", "16 views")
    window.click_control("Accumulate views")
    assert window.wait_best(views=0)["tpsnr"] is None
    window.move(20, 20)
    window.key("x")
    window.wait_text("said", "there is no reference")


def test_a_polygon_needs_blades(demo):
    """What cannot be drawn is said, with what to do."""
    window = demo(n=16)
    window.choose("Points", 3)
    assert "blades" in window.wait_text("said", "no views")
    window.set_number("Blades", "6")
    window.wait_text("accumulated", "16 views")
