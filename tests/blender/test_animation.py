# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten frames in views with a moving camera, unattended: each is that of a run alone.

Programs run as `blender -b FILE -a` and `-f N`, modules through inside/animation.py.
"""

import shutil

import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import call, only_in

pytestmark = only_in("3.4", "newest")
FRAMES = range(1, 11)
ALONE = (1, 7)


def pixels_of(path):
    """All channels of an EXR."""
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)


def run_program(blender, *args):
    """Blender with the preferences of the test, in the background."""
    command = blender.command("-b", str(blender.out / "animation.blend"), *args)
    log = call(*command, env=blender.environment(), cwd=blender.out)
    assert_no_error(log)


def assert_no_error(log):
    """Nothing that a farm would take for one."""
    said = [x for x in log.splitlines() if x.lower().startswith(("error", "traceback"))]
    assert not said, said


@pytest.fixture(scope="module")
def rendered(blender, dist):
    """Folder with the frames of the animation and of the runs alone."""
    folder = blender.out / "anim"
    shutil.rmtree(folder, ignore_errors=True)
    script = "animation.py"
    blender.run(script, dist, blender.out, "make")
    if blender.is_module:
        assert_no_error(blender.run(script, dist, blender.out, "all"))
        for frame in ALONE:
            log = blender.run(script, dist, blender.out, "one", str(frame))
            assert_no_error(log)
        return folder
    run_program(blender, "-a")
    for frame in ALONE:
        output = str(folder / "one_####.exr")
        run_program(blender, "-o", output, "-f", str(frame))
    return folder


def test_every_frame_is_there_and_differs(rendered):
    """The camera moves."""
    pictures = [pixels_of(rendered / f"all_{frame:04}.exr") for frame in FRAMES]
    for a, b in zip(pictures[:-1], pictures[1:], strict=True):
        assert np.abs(a - b).max() > 0.1


@pytest.mark.parametrize("frame", ALONE)
def test_a_frame_is_that_of_a_run_alone(rendered, frame):
    """Bit for bit."""
    a = pixels_of(rendered / f"all_{frame:04}.exr")
    b = pixels_of(rendered / f"one_{frame:04}.exr")
    assert np.array_equal(a, b), np.abs(a - b).max()
