# SPDX-License-Identifier: GPL-3.0-or-later
"""Farms and studios: inside/farm_checks.py, and its files in other processes."""

import os
import re
import subprocess

import numpy as np
import OpenImageIO as oiio
import pytest
from checked import Checked, names_of, read_rgba
from conftest import INSIDE, call, only_in

pytestmark = only_in("3.4", "newest")
SCRIPT = "farm_checks.py"
CHECKED = Checked(SCRIPT, "farm_results.json")
MODULE = "bl_ext.user_default.rack_focus"


@pytest.mark.parametrize("name", names_of(SCRIPT))
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)


def test_renders_that_succeed_print_no_error(blender, dist):
    """Farms' scanners of logs fail a job for a line with Error."""
    _, log = CHECKED.run(blender, dist)
    CHECKED.expect(blender, dist, "renders_that_succeed")
    printed = log.split("QUIET BEGIN")[1].split("QUIET END")[0].splitlines()
    assert any("Saved" in line for line in printed)
    assert not [line for line in printed if re.search(r"\berror\b", line, re.I)]


def test_packed_layers_of_several_views(blender, dist):
    """A ZIP file of 16 bits has what one without compression has; colours are halves."""
    CHECKED.expect(blender, dist, "a_multilayer_file_of_several_views")
    packed, plain = (
        oiio.ImageInput.open(str(next(blender.out.glob(f"{name}_07*"))))
        for name in ("packed", "unpacked")
    )
    specs = packed.spec(), plain.spec()
    assert specs[0].channelnames == specs[1].channelnames
    assert specs[0].get_string_attribute("compression") == "zip"
    kinds = [str(specs[0].channelformat(i)) for i in range(specs[0].nchannels)]
    found, wanted = packed.read_image(oiio.FLOAT), plain.read_image(oiio.FLOAT)
    for index, name in enumerate(specs[0].channelnames):
        is_colour = name[-2:] in (".R", ".G", ".B", ".A")
        assert kinds[index] == ("half" if is_colour else "float"), name
        a, b = found[..., index], wanted[..., index]
        assert np.array_equal(a, b.astype("<f2") if is_colour else b), name


def environment(blender, **more):
    """Variables of a Blender without our add-on in its own scripts."""
    home = blender.out / "bare"
    home.mkdir(exist_ok=True)
    return {
        **os.environ,
        "HOME": str(home),
        "BLENDER_USER_RESOURCES": str(home),
        **more,
    }


@pytest.mark.parametrize("name", ("plain", "nodes", "no_own_node"))
def test_a_machine_without_the_add_on_renders_sharp(blender, dist, name):
    """Bit for bit the scene's own picture, never black."""
    CHECKED.expect(blender, dist, "files_for_machines_without_the_add_on")
    made = blender.out / f"bare_{name}.exr"
    made.unlink(missing_ok=True)
    script, file = INSIDE / "without_addon.py", blender.out / f"farm_{name}.blend"
    if blender.is_module:
        command = [blender.python, script, "--", file, made]
    else:
        options = ("-b", "--factory-startup", "-P")
        command = blender.command(*options, str(script), "--", str(file), str(made))
    call(*command, env=environment(blender), cwd=blender.out)
    sharp = np.load(blender.out / "farm_sharp.npy")
    wanted = sharp[:, ::-1] if name == "nodes" else sharp
    assert np.array_equal(read_rgba(made), wanted)


@pytest.mark.parametrize("strict", ("0", "1"))
def test_a_failed_filter_for_a_farm(blender, dist, strict):
    """One line on stderr; exit code 1 only where it is asked for."""
    CHECKED.expect(blender, dist, "a_file_whose_filter_fails")
    file = blender.out / "fails.blend"
    if blender.is_module:
        script = (
            "import bpy, os, sys; "
            f"bpy.ops.preferences.addon_enable(module='{MODULE}'); "
            f"bpy.ops.wm.open_mainfile(filepath={str(file)!r}); "
            "exec('try: bpy.ops.render.render()\\nexcept RuntimeError: pass')"
        )
        command = [blender.python, "-c", script]
    else:
        command = blender.command("-b", str(file), "-f", "1")
    done = subprocess.run(
        command,
        env={**blender.environment(), "RACKFOCUS_STRICT": strict},
        cwd=blender.out,
        capture_output=True,
        text=True,
        timeout=600,
    )
    said = [x for x in done.stderr.splitlines() if x.startswith("Rack Focus: scene")]
    assert len(said) == 1 and "another type" in said[0], done.stderr
    if strict == "1":
        assert done.returncode == 1, done.returncode
    elif blender.version != "4.5":  # which hangs or crashes at its exit as a module
        assert done.returncode != 1, done.returncode
