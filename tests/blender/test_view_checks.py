# SPDX-License-Identifier: GPL-3.0-or-later
"""Several views and their mean: see inside/view_checks.py,
inside/sampling_checks.py and inside/camera_checks.py."""

import json
import re

import numpy as np
import pytest
from checked import Checked, names_of, read_rgba
from conftest import call, only_in

CHECKED = Checked("view_checks.py", "view_results.json")
CAMERAS = Checked("camera_checks.py", "camera_results.json")
SAMPLING = Checked("sampling_checks.py", "sampling_results.json")
in_newest = only_in("3.4", "newest")
in_5_0 = only_in("3.4", "5.0")  # which left views empty, and has longer names


@in_newest
@pytest.mark.parametrize("name", names_of("view_checks.py"))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)


@in_5_0
@pytest.mark.parametrize("name", names_of("sampling_checks.py"))
def test_few_samples(blender, dist, name):
    """One check of inside/sampling_checks.py in one Blender."""
    SAMPLING.expect(blender, dist, name)


@in_5_0
@pytest.mark.parametrize("name", names_of("camera_checks.py"))
def test_cameras(blender, dist, name):
    """One check of inside/camera_checks.py in one Blender."""
    CAMERAS.expect(blender, dist, name)


def kept_views(blender, folder):
    """The files that the render kept."""
    return sorted((blender.out / folder).glob("passes0001_v*.exr"))


@in_newest
@pytest.mark.parametrize("name", ["views4", "views4_refocused"])
def test_the_node_is_the_command_on_the_kept_views(blender, dist, command, name):
    """Bit for bit; the header has the lens, options only what was refocused."""
    CHECKED.run(blender, dist)
    options = []
    if name.endswith("refocused"):
        lens = json.loads((blender.out / "view_lens.json").read_text())
        for field, value in lens.items():
            options += [f"--{field.replace('_', '-')}", value]
    made = blender.out / f"command_{name}.exr"  # read_rgba() caches by name
    files = kept_views(blender, "kept")
    assert len(files) == 4
    call(command, "filter", *files, "-o", made, "--type", "float", "--quiet", *options)
    a, b = read_rgba(made), read_rgba(blender.out / f"{name}.exr")
    assert np.array_equal(a, b), np.abs(a - b).max()


@in_newest
def test_the_mean_is_the_command_on_the_kept_views(blender, dist, command):
    """rackfocus accumulate."""
    CHECKED.run(blender, dist)
    made = blender.out / "command_mean.exr"
    files = kept_views(blender, "kept_mean")
    assert len(files) == 5
    call(command, "accumulate", *files, "-o", made, "--quiet")
    a, b = read_rgba(made), read_rgba(blender.out / "mean5.exr")
    assert np.array_equal(a, b), np.abs(a - b).max()


@in_newest
def test_kept_views_say_where_they_were_taken(blender, dist, command):
    """rackfocus info shows the place on the lens and the plane of the shear."""
    CHECKED.run(blender, dist)
    text = call(command, "info", kept_views(blender, "kept")[1])
    assert re.search(r"view from +\(-?[\d.e-]+, -?[\d.e-]+\) on the lens", text), text
    # 4 views of 4 samples, so not the plane in focus: 1/D = 1/3 - 1.5 px / (0.125 * 100 px)
    # (blender_addon/sampling.py).
    sheared = float(re.search(r"sheared at distance ([\d.]+)", text)[1])
    assert sheared == pytest.approx(4.6875, rel=1e-3), text
    assert re.search(r"focus-distance +3 .*header rackfocus:focusDistance", text), text
