# SPDX-License-Identifier: GPL-3.0-or-later
"""Several views and their mean in every Blender: see inside/view_checks.py."""

import json
import re

import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import INSIDE, call

SOURCE = (INSIDE / "view_checks.py").read_text()
NAMES = re.findall(r"^@check\ndef (\w+)", SOURCE, re.M)
_results = {}


def results_of(blender, dist):
    """{check: "" or problem} of one run in one Blender, and what it printed."""
    if blender.version not in _results:
        log = ""
        try:
            log = blender.run("view_checks.py", dist, blender.out)
        except Exception as error:  # what was done before the end still counts
            log = str(error)
        path = blender.out / "view_results.json"
        found = json.loads(path.read_text()) if path.exists() else {}
        _results[blender.version] = found, log
    return _results[blender.version]


@pytest.mark.parametrize("name", NAMES)
def test_check(blender, dist, name):
    """One check in one Blender."""
    found, log = results_of(blender, dist)
    assert name in found, f"Blender ended before this check:\n{log[-3000:]}"
    assert not found[name], found[name]


def read_rgba(path):
    """(height, width, 4) of the picture in an EXR."""
    image = oiio.ImageBuf(str(path))
    pixels = image.get_pixels(oiio.FLOAT)
    names = [name.split(".")[-1] for name in image.spec().channelnames]
    return pixels[..., [names.index(c) for c in "RGBA"]]


def kept_views(blender, folder):
    """The files that the render kept."""
    return sorted((blender.out / folder).glob("passes0001_v*.exr"))


@pytest.mark.parametrize("name", ["views4", "views4_refocused"])
def test_the_node_is_the_command_on_the_kept_views(blender, dist, command, name):
    """Bit for bit; the header has the lens, options only what was refocused."""
    results_of(blender, dist)
    options = []
    if name.endswith("refocused"):
        lens = json.loads((blender.out / "view_lens.json").read_text())
        for field, value in lens.items():
            options += [f"--{field.replace('_', '-')}", value]
    made = blender.out / f"command_{name}.exr" # read_rgba() caches by name
    files = kept_views(blender, "kept")
    assert len(files) == 4
    call(command, "filter", *files, "-o", made, "--type", "float", "--quiet", *options)
    a, b = read_rgba(made), read_rgba(blender.out / f"{name}.exr")
    assert np.array_equal(a, b), np.abs(a - b).max()


def test_the_mean_is_the_command_on_the_kept_views(blender, dist, command):
    """rackfocus accumulate."""
    results_of(blender, dist)
    made = blender.out / "command_mean.exr"
    files = kept_views(blender, "kept_mean")
    assert len(files) == 5
    call(command, "accumulate", *files, "-o", made, "--quiet")
    a, b = read_rgba(made), read_rgba(blender.out / "mean5.exr")
    assert np.array_equal(a, b), np.abs(a - b).max()


def test_kept_views_say_where_they_were_taken(blender, dist, command):
    """rackfocus info shows the place on the lens and the plane of the shear."""
    results_of(blender, dist)
    text = call(command, "info", kept_views(blender, "kept")[1])
    assert re.search(r"view from +\(-?[\d.e-]+, -?[\d.e-]+\) on the lens", text), text
    assert "sheared at distance 3" in text
    assert re.search(r"focus-distance +3 .*header rackfocus:focusDistance", text), text
