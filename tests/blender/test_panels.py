# SPDX-License-Identifier: GPL-3.0-or-later
"""Every panel in its states, as docs/blender-panels.md shows them: inside/panels_gui.py."""

import itertools
import os
from pathlib import Path

import numpy as np
import pytest
import session
from conftest import call, get_blender

NAMES = (
    "off final views compositing_off out_of_date not_active scatter look keep_sharp "
    "preferences sidebar focus coc in_3d_views looks"
).split()
# Rows of the preferences above which Blender shows the path of the add-on.
PATHS = {"3": 210, "5": 215}


@pytest.fixture(scope="module", params=("3.4", "newest"))
def found(request, dist):
    """(what the session found, {name: picture of the panel}) for one Blender."""
    blender = get_blender(request.param)
    out = blender.out / "panels_gui"
    values = session.run(blender, "panels_gui.py", dist, out, (1280, 900))
    pictures = {}
    for name, (left, right, top, bottom) in values["shown"].items():
        pictures[name] = session.shot(out, name)[top:bottom, left:right]
    return values, pictures, out


def test_every_panel_shows_something(found):
    """None is of one colour, and no two are alike."""
    _, pictures, _ = found
    assert sorted(pictures) == sorted(NAMES)
    for name, pixels in pictures.items():
        assert np.std(pixels) > 0.03, name
    for (a, one), (b, other) in itertools.combinations(pictures.items(), 2):
        is_alike = one.shape == other.shape and np.abs(one - other).max() < 0.1
        assert not is_alike, (a, b)


def test_what_is_out_of_date_is_red(found):
    """The button, in the box and in the sidebar; it is not where nothing has changed."""
    _, pictures, _ = found

    def n_red(name):
        red, green, blue = np.moveaxis(pictures[name], -1, 0)
        return int(((red > 0.5) & (green < 0.3) & (blue < 0.3)).sum())

    assert n_red("out_of_date") > 1000 < n_red("sidebar")
    assert n_red("final") < 100


def test_pictures_for_the_docs(found):
    """RACKFOCUS_SHOTS keeps them, in few colours."""
    values, pictures, out = found
    version = values["version"][0]
    for name, box in values["shown"].items():
        left, right, top, bottom = box
        top += PATHS[version] if name == "preferences" else 0
        cut = f"{right - left}x{bottom - top}+{left}+{top}"
        target = out / f"small_{name}.png"
        # Less of what is empty below; few colours.
        call(
            "convert", out / f"{name}.png", "-crop", cut, "+repage", "-bordercolor",
            "#303030", "-fuzz", "4%", "-trim", "+repage", "-colors", "32",
            f"png8:{target}",
        )  # fmt: skip
        assert 1000 < target.stat().st_size < 60000, name
        if shots := os.environ.get("RACKFOCUS_SHOTS"):
            kept = Path(shots) / f"blender-panel-{name}-{version}.png"
            kept.write_bytes(target.read_bytes())
