# SPDX-License-Identifier: GPL-3.0-or-later
"""Rack Focus over 3D views under Xvfb: see inside/viewport_gui.py for the steps."""

import json
import os
import shlex
from pathlib import Path

import OpenImageIO as oiio
import pytest
from conftest import INSIDE, call, get_blender
from test_gui import SERVED

SHOTS = "off camera_near camera_far depth coc focus free ortho material rendered"


@pytest.fixture(scope="module", params=("3.4", "newest"))
def session(request, dist):
    """(what the session found, its folder) for one Blender."""
    blender = get_blender(request.param)
    out = blender.out / "viewport"
    out.mkdir(exist_ok=True)
    arguments = ("-P", INSIDE / "viewport_gui.py", "--", dist, out)
    command = blender.command("--factory-startup", *map(str, arguments))
    script = SERVED.format(out=out, blender=shlex.join(command))
    # Small: OpenGL is drawn by the processor here.
    screen = "-screen 0 720x500x24"
    about = {**blender.environment(), "LIBGL_ALWAYS_SOFTWARE": "1"}
    log = call(
        "xvfb-run", "-a", "-s", screen, "sh", "-c", script, env=about, timeout=560
    )
    assert "Traceback" not in log, log[-3000:]
    found = json.loads((out / "viewport.json").read_text())
    assert found.get("done"), found
    print(found["version"], found["camera_seconds"])
    return found, out


def pixels_of(folder, name):
    """(height, width, 3) of a screenshot."""
    image = oiio.ImageBuf(str(folder / f"{name}.png"))
    return image.get_pixels(oiio.FLOAT)[..., :3]


def test_off_costs_nothing(session):
    """No handler before and after, nothing kept, the overlays as they were."""
    found, _ = session
    assert found["handlers_before"] and found["handlers_after"]
    assert found["views_after"] == 0 and found["overlays"]


def test_no_view_has_a_message(session):
    """Solid, seen through the camera and freely."""
    found, _ = session
    assert found["message"] == found["ortho_message"] == ""


def test_the_depth_is_that_of_the_scene(session):
    """The cubes stand at depths of 1.5 to 9, their front faces before that."""
    found, _ = session
    assert 1 < found["nearest"] < 1.5 and 8 < found["farthest"] < 10


@pytest.mark.parametrize("what", ("focus", "playback", "orbit"))
def test_the_picture_follows(session, what):
    """The lens, the animation, the view."""
    assert session[0][f"{what}_changes"] > 0.1


def test_a_click_sets_the_depth_of_the_pixel(session):
    """Through the camera its distance; freely a point of the scene."""
    found, _ = session
    assert found["clicked"] == pytest.approx(found["clicked_depth"], rel=1e-3)
    assert found["point_error"] < 1e-3


def test_colours_are_those_of_the_view(session):
    """The background inside the camera's frame is the same with and without."""
    _, folder = session
    off, on = (pixels_of(folder, name)[300, 170] for name in ("off_again", "focus"))
    assert abs(off - on).max() < 4 / 255, (off, on)


def test_maps(session):
    """Depth map, CoC and focus show something."""
    found, _ = session
    for name in ("DEPTH", "COC", "FOCUS"):
        assert found[f"std_{name}"] > 0.02


def test_material_preview_and_rendered(session):
    """With EEVEE; of Cycles Blender shows nothing to add-ons, and that is said."""
    found, _ = session
    assert "Material Preview" in found["cycles_message"]
    assert not found["cycles_has_picture"]
    for kind in ("MATERIAL", "RENDERED"):
        if "not ready" in found[f"{kind}_message"]:
            pytest.skip("EEVEE's shaders were not made in time by software OpenGL")
        assert found[f"{kind}_message"] == "" and found[f"{kind}_std"] > 0.02


@pytest.mark.parametrize("name", SHOTS.split())
def test_screenshots_show_something(session, name):
    """Neither black nor of one colour. RACKFOCUS_SHOTS keeps some of the newest."""
    found, folder = session
    assert pixels_of(folder, name).std() > 0.05
    shots = os.environ.get("RACKFOCUS_SHOTS")
    if shots and found["version"].startswith("5") and name in ("camera_near", "coc"):
        image = oiio.ImageBuf(str(folder / f"{name}.png"))
        cut = oiio.ImageBufAlgo.cut(image, oiio.ROI(0, 590, 40, 440, 0, 1, 0, 3))
        cut.write(str(Path(shots) / f"blender-view-{name}.png"))
