# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with a window under Xvfb: see inside/gui.py for its steps."""

import os
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
import session
from conftest import get_blender


@pytest.fixture(scope="module", params=("3.4", "newest"))
def found(request, dist):
    """(what the session found, its folder) for one Blender."""
    blender = get_blender(request.param)
    out = blender.out / "gui"
    return session.run(blender, "gui.py", dist, out, (1280, 900)), out


def test_enabling_makes_one_scene(found):
    """The scene and its filter scene."""
    assert found[0]["scenes"] == 2


def test_the_session_may_not_write(found):
    """In 3.4 timers and handlers are forbidden to write in all that follows."""
    values, _ = found
    has_switch_of_process = values["version"].startswith("3.")
    assert values["is_forbidden"] == has_switch_of_process


def test_refocus_changes_the_picture_and_leaves_the_nodes(found):
    """Another focus, and no node is left muted."""
    values, _ = found
    assert values["refocus_changes"] > 0.1
    assert not values["muted_left"]


def test_a_refocus_does_not_wait_for_the_window(found):
    """It filters while the main thread draws, or does anything else."""
    assert found[0]["filters_beside"]


def test_the_picker_sets_the_depth(found):
    """The distance is that of the pixel."""
    values, _ = found
    assert values["picked"] == pytest.approx(values["picked_depth"], rel=1e-6)


def test_the_picker_needs_the_render(found):
    """Another image has nothing to do with the depth under the click."""
    said = found[0]["picked_elsewhere"]
    assert len(said) == 2, said
    assert "shows “Texture”: choose Render Result" in said[0]
    assert "shows no picture: choose Render Result" in said[1]


def test_views_as_a_job(found):
    """Four views, refocused; nothing stays behind, after Esc or unticking neither."""
    values, _ = found
    assert values["views"] == 4 and not values["views_message"]
    assert values["views_change"] > 0.1
    assert values["views_leave_nothing"] and values["views_after_escape"]
    assert values["is_unticked_meanwhile"] and values["views_after_unticking"]
    assert values["escape_message"] in ("", "stopped; the picture is not filtered")


def test_the_nodes_own_button(found):
    """It ends with the filtered picture, composited."""
    assert found[0]["button_difference"] < 0.01


def test_escape_ends_the_filter(found):
    """And says that the picture is not filtered."""
    values, _ = found
    print(f"from Esc to the end: {values['cancel_s']:.2f} s")
    assert "not filtered" in values["message"]


def test_the_cameras_own_dof_is_back(found):
    """After the render and after Esc."""
    values, _ = found
    assert values["dof_is_back"] and not values["is_dof_hidden"]


# What docs/blender.md shows: the Blender, and left, right, top, bottom in px.
SHOWN = {
    "render": ("5", 150, 900, 180, 690),
    "refocus": ("5", 150, 900, 180, 690),
    "compositor": ("3", 300, 560, 240, 622),
}


@pytest.mark.parametrize("name", SHOWN)
def test_screenshots_show_something(found, name):
    """Neither black nor of one colour. RACKFOCUS_SHOTS keeps those of the newest."""
    values, folder = found
    image = oiio.ImageBuf(str(folder / f"{name}.png"))
    pixels = image.get_pixels(oiio.FLOAT)
    assert pixels.shape[:2] == (900, 1280)
    assert np.std(pixels[..., :3]) > 0.05
    shots = os.environ.get("RACKFOCUS_SHOTS")
    version, *box = SHOWN[name]
    if shots and values["version"].startswith(version):
        cut = oiio.ImageBufAlgo.cut(image, oiio.ROI(*box, 0, 1, 0, 3))
        width = min(cut.spec().width, 480)
        height = cut.spec().height * width // cut.spec().width
        cut = oiio.ImageBufAlgo.resize(cut, "", 0, oiio.ROI(0, width, 0, height))
        cut.write(str(Path(shots) / f"blender-{name}.png"))


def test_data_is_changed_in_the_main_thread(found):
    """Else Blender crashes or hangs in some of a hundred renders."""
    threads = found[0]["threads"]
    assert set(threads) == {
        "_write_file", "prepare_frame", "follow"
    }  # fmt: skip
    assert all(all(calls) for calls in threads.values()), threads
