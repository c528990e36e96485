# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with a window under Xvfb: see inside/gui.py for its steps."""

import json
import os
import shlex
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import INSIDE, call, get_blender

# The session asks for the key and for screenshots with files: both come from outside.
SERVED = """
(while sleep 0.02; do
    [ -e {out}/press_escape ] &&
        xdotool mousemove 600 400 key Escape && rm {out}/press_escape
    for shot in {out}/*.shot; do
        [ -e $shot ] && import -window root png:{out}/part &&
            mv {out}/part ${{shot%.shot}}.png && rm $shot # else again
    done
done) &
served=$!
trap 'kill $served' EXIT
{blender}
"""


@pytest.fixture(scope="module", params=("3.4", "newest"))
def session(request, dist):
    """(what the session found, its folder) for one Blender."""
    blender = get_blender(request.param)
    arguments = ("-P", INSIDE / "gui.py", "--", dist, blender.out)
    command = blender.command("--factory-startup", *map(str, arguments))
    script = SERVED.format(out=blender.out, blender=shlex.join(command))
    screen = "-screen 0 1280x900x24"
    about = {**blender.environment(), "LIBGL_ALWAYS_SOFTWARE": "1"}
    log = call(
        "xvfb-run", "-a", "-s", screen, "sh", "-c", script, env=about, timeout=400
    )
    assert "Traceback" not in log, log[-3000:]
    found = json.loads((blender.out / "gui.json").read_text())
    assert found.get("done"), found
    return found, blender.out


def test_enabling_makes_one_scene(session):
    """The scene and its filter scene."""
    assert session[0]["scenes"] == 2


def test_refocus_changes_the_picture_and_leaves_the_nodes(session):
    """Another focus, and no node is left muted."""
    found, _ = session
    assert found["refocus_changes"] > 0.1
    assert not found["muted_left"]


def test_the_picker_sets_the_depth(session):
    """The distance is that of the pixel."""
    found, _ = session
    assert found["picked"] == pytest.approx(found["picked_depth"], rel=1e-6)


def test_views_as_a_job(session):
    """Four views, refocused; nothing stays behind, after Esc neither."""
    found, _ = session
    assert found["views"] == 4 and not found["views_message"]
    assert found["views_change"] > 0.1
    assert found["views_leave_nothing"] and found["views_after_escape"]


def test_the_nodes_own_button(session):
    """It ends with the filtered picture, composited."""
    assert session[0]["button_difference"] < 0.01


def test_escape_ends_the_filter_soon(session):
    """Half a second on an idle machine; the limit leaves room for a busy one."""
    found, _ = session
    assert found["cancel_s"] < 5
    assert "not filtered" in found["message"]


def test_the_cameras_own_dof_is_back(session):
    """After the render and after Esc."""
    found, _ = session
    assert found["dof_is_back"] and not found["is_dof_hidden"]


# What docs/blender.md shows: the Blender, and left, right, top, bottom in px.
SHOWN = {
    "panel": ("5", 30, 1050, 412, 768),
    "views": ("5", 30, 1050, 602, 812),
    "render": ("5", 150, 900, 180, 690),
    "refocus": ("5", 150, 900, 180, 690),
    "compositor": ("3", 300, 560, 240, 622),
}


@pytest.mark.parametrize("name", SHOWN)
def test_screenshots_show_something(session, name):
    """Neither black nor of one colour. RACKFOCUS_SHOTS keeps those of the newest."""
    found, folder = session
    image = oiio.ImageBuf(str(folder / f"{name}.png"))
    pixels = image.get_pixels(oiio.FLOAT)
    assert pixels.shape[:2] == (900, 1280)
    assert np.std(pixels[..., :3]) > 0.05
    shots = os.environ.get("RACKFOCUS_SHOTS")
    version, *box = SHOWN[name]
    if shots and found["version"].startswith(version):
        cut = oiio.ImageBufAlgo.cut(image, oiio.ROI(*box, 0, 1, 0, 3))
        width = min(cut.spec().width, 1020 if name in ("panel", "views") else 480)
        height = cut.spec().height * width // cut.spec().width
        cut = oiio.ImageBufAlgo.resize(cut, "", 0, oiio.ROI(0, width, 0, height))
        name = "views-panel" if name == "views" else name
        cut.write(str(Path(shots) / f"blender-{name}.png"))
