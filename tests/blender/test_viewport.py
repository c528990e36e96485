# SPDX-License-Identifier: GPL-3.0-or-later
"""Rack Focus over 3D views under Xvfb: see inside/viewport_gui.py for the steps."""

import os
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
import session
from conftest import ROOT, call, get_blender

sys.path.append(str(ROOT / "tests/cli"))
import plainexr  # noqa: E402

SHOTS = (
    "off camera_near camera_far depth coc focus free ortho material rendered cycles"
).split()
MODES = ("solid", "material", "rendered", "cycles")


@pytest.fixture(scope="module", params=("3.4", "newest"))
def found(request, dist):
    """(what the session found, its folder) for one Blender."""
    blender = get_blender(request.param)
    out = blender.out / "viewport"
    # Small: OpenGL is drawn by the processor here.
    return session.run(blender, "viewport_gui.py", dist, out, (720, 500)), out


def test_off_costs_nothing(found):
    """No handler before and after, nothing kept, the overlays as they were."""
    values, _ = found
    assert values["handlers_before"] == values["handlers_after"] == 0
    assert values["views_after"] == 0 and values["overlays"]
    assert (values["contexts"], values["contexts_after"]) == (1, 0)


def test_no_view_has_a_message(found):
    """Solid, seen through the camera and freely."""
    values, _ = found
    assert values["message"] == values["ortho_message"] == ""


def test_the_depth_is_that_of_the_scene(found):
    """The cubes stand at depths of 1.5 to 9, their front faces before that."""
    values, _ = found
    assert 1 < values["nearest"] < 1.5 and 8 < values["farthest"] < 10


def test_the_depth_is_not_that_of_overlays(found):
    """The grid of the floor, which is in view, and the camera's frame have none.

    In motion 2.6 % of the view have one, where the grid's lines lie side by side far
    away; 7.6 % without looking for lines.

    3.4 draws its background with alpha 1: nothing there tells what was drawn.
    """
    values, _ = found
    assert values["version"].startswith("3") or 0.01 < values["share_drawn"] < 0.9
    assert values["depth_of_nothing"] == 0
    assert values["moving_depth_of_nothing"] < 0.04
    assert values["moving_depth_same"] > 0.8


@pytest.mark.parametrize("what", ("focus_changes", "frames_change", "orbit_changes"))
def test_the_picture_follows(found, what):
    """The lens, the frame, the mouse that turns the view."""
    assert found[0][what] > 0.05


def test_playback(found):
    """Frames that play are shown with the focus that they have."""
    values, _ = found
    assert values["frames_played"] > 5 and values["playback_error"] < 1e-5


def test_a_click_sets_the_depth_of_the_pixel(found):
    """Through the camera, with the mouse, its distance; freely a point of the scene."""
    values, _ = found
    nearest, farthest = values["clicked_range"]
    assert nearest * 0.999 < values["clicked"] < farthest * 1.001
    assert values["point_error"] < 1e-3


def test_colours_are_those_of_the_view(found):
    """The background inside the camera's frame is the same with and without."""
    _, folder = found
    off, on = (session.shot(folder, n)[300, 170] for n in ("off_again", "focus"))
    assert abs(off - on).max() < 4 / 255, (off, on)


def encoded(light):
    """sRGB of linear values."""
    light = np.clip(light, 0, 1)
    return np.where(
        light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055
    )


def linear(shown):
    """The inverse of encoded()."""
    return np.where(shown < 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def test_what_is_shown_is_the_picture_over_the_background(found):
    """In Solid, encoded as sRGB; where no overlay is in the way, which few px are."""
    values, folder = found
    picture = np.load(folder / "solid.npz")["picture"]
    height, width = picture.shape[:2]
    x, y = values["place"]
    seen = session.shot(folder, "camera_near")[y : y + height, x : x + width]
    behind = linear(session.shot(folder, "off")[300, 170])  # in the camera's frame
    alpha = picture[..., 3:]
    wanted = encoded(picture[..., :3] + (1 - alpha) * behind)
    inside = np.zeros((height, width), bool)
    inside[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3] = True
    is_soft = inside & (alpha[..., 0] > 0.1) & (alpha[..., 0] < 0.9)
    off = abs(wanted - seen).max(axis=-1)
    assert is_soft.sum() > 500
    print(values["version"], np.percentile(255 * off[is_soft], (50, 80, 95)))
    assert np.percentile(off[is_soft], 80) < 6 / 255
    assert np.percentile(off[inside], 80) < 6 / 255


def test_a_depth_that_comes_late_is_awaited(found):
    values, _ = found
    assert values["early_left"] == 0
    assert values["early_off"] < 1e-5


def test_maps(found):
    """Depth map, CoC and focus show something."""
    values, _ = found
    for name in ("DEPTH", "COC", "FOCUS"):
        assert values[f"std_{name}"] > 0.02


@pytest.mark.parametrize("mode", MODES[1:])
def test_modes(found, mode):
    """Each shows the scene through the lens, also where overlays are off."""
    values, _ = found
    assert values[f"{mode}_message"] == ""
    assert values[f"{mode}_std"] > 0.02
    assert values[f"{mode}_changes"] > 0.05
    assert values[f"{mode}_same"] < 1e-3


@pytest.mark.parametrize("mode", MODES)
def test_the_picture_is_the_command_s(found, mode, command):
    """What is put into the view, from the colour and the depth that were read."""
    values, folder = found
    kept = np.load(folder / f"{mode}.npz")
    channels = dict(zip("RGBA", np.moveaxis(kept["colour"], -1, 0), strict=True))
    channels["Z"] = kept["depth"]
    channels = {k: np.ascontiguousarray(v, np.float32) for k, v in channels.items()}
    passes = plainexr.write(folder / f"{mode}.exr", channels)
    options = []
    for field, value in values[f"{mode}_params"].items():
        text = value if isinstance(value, str) else repr(value)
        options += [f"--{field.replace('_', '-')}", text]
    made = folder / f"{mode}_command.exr"
    call(command, "filter", passes, "-o", made, "--type", "float", *options)
    image = oiio.ImageInput.open(str(made))
    names = list(image.spec().channelnames)
    pixels = image.read_image(oiio.FLOAT)[..., [names.index(c) for c in "RGBA"]]
    image.close()
    assert np.array_equal(pixels, kept["picture"])


@pytest.mark.parametrize("name", SHOTS)
def test_screenshots_show_something(found, name):
    """Neither black nor of one colour. RACKFOCUS_SHOTS keeps some of the newest."""
    values, folder = found
    assert session.shot(folder, name).std() > 0.05
    shots = os.environ.get("RACKFOCUS_SHOTS")
    is_of_docs = values["version"].startswith("5") and name in ("camera_near", "cycles")
    if shots and is_of_docs:
        image = oiio.ImageBuf(str(folder / f"{name}.png"))
        cut = oiio.ImageBufAlgo.cut(image, oiio.ROI(0, 590, 40, 440, 0, 1, 0, 3))
        cut.write(str(Path(shots) / f"blender-view-{name}.png"))
