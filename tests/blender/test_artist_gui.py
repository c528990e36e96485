# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's session under Xvfb: see inside/artist_gui.py for its steps."""

import os
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
import session
from conftest import get_blender


@pytest.fixture(scope="module", params=("3.4", "newest"))
def found(request, dist, oidn):
    """(what the session found, its folder) for one Blender."""
    os.environ["RACKFOCUS_OIDN"] = str(oidn)  # Debian's Blenders have no denoiser
    blender = get_blender(request.param)
    out = blender.out / "artist_gui"
    return session.run(blender, "artist_gui.py", dist, out, (1280, 900)), out


def test_it_refocuses_by_itself(found):
    """Only with the toggle; the picture is the new one."""
    values, _ = found
    assert values["old_without_the_toggle"]
    assert values["itself_changes"] > 0.05
    for whole, _, steps in values["itself_s"]:
        print(f"{whole:.2f} s from the change to the picture; {steps}")
    print("longest pause of the window, median:", values["pause"])


def test_the_focus_is_dragged_in_the_3d_view(found):
    """The gizmo's arrow moves it; arrow, cross and frame are drawn."""
    values, folder = found
    before, after = values["dragged"]
    print(f"{before} dragged to {after}")
    assert after > before + 0.1
    shots = [session.shot(folder, name) for name in ("gizmo_off", "gizmo")]
    assert 20 < (abs(shots[0] - shots[1]).max(-1) > 0.2).sum() < 20000


def test_finish_is_a_job(found):
    """The own lens is rendered and cleaned beside the window; nothing is left."""
    values, _ = found
    assert values["finish_done"] == ["RUNNING_MODAL"] and not values["finish_message"]
    assert "finish" in values["finish_steps"] and values["finish_changes"] > 0.01
    assert values["finish_scenes"] == ["Scene", "Scene Rack Focus"]
    assert not values["finish_muted"]


def test_the_node_filters_in_a_job(found):
    """What comes in is filtered, bit for bit, and refocused; nothing is left."""
    values, _ = found
    assert not values["node_message"]
    assert values["node_difference"] < 1e-5
    assert values["node_refocus_difference"] < 1e-5
    assert values["scenes_left"] == ["Scene", "Scene Rack Focus"]


def test_the_picture_comes_as_the_box_is_ticked(found):
    """Also when that is undone; Blender 5.x makes it black. One without depth stays."""
    values, _ = found
    is_composited = values["version"] >= "5"
    difference, mean, message = values["ticked_without_depth"]
    assert difference == 0 and mean > 0.05
    assert not is_composited or "without its depth: press F12" in message
    difference, mean, message = values["ticked_with_depth"]
    assert (difference > 0.01) == is_composited and mean > 0.05 and not message
    assert values["redone"] == 0


def test_f12_is_heard_while_that_picture_is_made(found):
    """A job would make Blender ignore it."""
    assert found[0].get("refocus_then_render", [True, False]) == [True, False]


def test_undo_leaves_no_refocus(found):
    """Back to a change made while one ran: F12 would not render the scene."""
    values, _ = found
    assert values["muted_meanwhile"]
    assert abs(values["undone_focus"] - 2.2) < 1e-5
    assert values["undone_muted"] == [[], ""]


# What docs/blender.md shows: the Blenders, and left, right, top, bottom in px.
SHOWN = {
    "box": ("35", 30, 1040, 60, 800),
    "gizmo": ("5", 380, 680, 200, 640),
    "box_custom": ("5", 30, 1040, 120, 800),
    "out_of_date": ("5", 0, 1060, 25, 820),
    "node": ("3", 0, 1060, 25, 620),
}


@pytest.mark.parametrize("name", SHOWN)
def test_screenshots_show_something(found, name):
    """Neither black nor of one colour. RACKFOCUS_SHOTS keeps them."""
    values, folder = found
    assert np.std(session.shot(folder, name)) > 0.05
    shots, version = os.environ.get("RACKFOCUS_SHOTS"), values["version"][0]
    versions, *box = SHOWN[name]
    if shots and version in versions:
        image = oiio.ImageBuf(str(folder / f"{name}.png"))
        cut = oiio.ImageBufAlgo.cut(image, oiio.ROI(*box, 0, 1, 0, 3))
        cut.write(str(Path(shots) / f"blender-{name}-{version}.png"))
