# SPDX-License-Identifier: Apache-2.0
"""What the tests with the real POV-Ray share."""

import os
import pathlib
import shutil
import subprocess

import numpy
import pytest

HERE = pathlib.Path(__file__).parent
SCENES = HERE / "scenes"
EXAMPLES = pathlib.Path("/usr/share/doc/povray/examples")

#: A ball on a ground; the clock moves the camera towards it.
SCENE = """#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 1, -5 + clock> look_at <0, 1, 0> right x*image_width/image_height
         aperture 0.6 focal_point <0, 1, 0> }
sphere { <0, 1, 0>, 1 pigment { checker rgb 1 rgb 0.2 scale 0.2 } }
plane { y, 0 pigment { checker rgb 0.9 rgb 0.3 } }
light_source { <3, 9, -7> rgb 1 }
"""
SIZE = ["+W160", "+H120"]


# What POV-Ray says where a machine is too busy to start its threads in time.
OVERLOADED = "Timed out waiting for worker thread startup"


@pytest.fixture
def rackfocus(binary, tmp_path):
    """Runs the command in a folder (default: a copy of scenes/).

    Checks the exit code and that no private folder is left behind.
    """
    private = pathlib.Path("/tmp") / f"rackfocus-test-{os.getpid()}"
    private.mkdir(exist_ok=True)

    def run(*arguments, code=0, cwd=None, **variables):
        if cwd is None:
            cwd = tmp_path / "scenes"
            if not cwd.exists():
                shutil.copytree(SCENES, cwd)
        for _ in range(3):
            done = subprocess.run(
                [binary, *map(str, arguments)],
                cwd=cwd,
                capture_output=True,
                text=True,
                timeout=300,
                env={**os.environ, "TMPDIR": str(private), **variables},
            )
            if OVERLOADED not in done.stderr:
                break
        assert done.returncode == code, f"{arguments}\n{done.stdout}\n{done.stderr}"
        assert not list(private.iterdir())
        return done

    yield run
    shutil.rmtree(private)


@pytest.fixture
def camera(rackfocus):
    """The recovered camera as a dictionary of numbers and lists."""

    def run(scene, *options, povray=(), **more):
        done = rackfocus(
            "povray", scene, "--camera", *options, "--", *SIZE, *povray, **more
        )
        facts = {}
        for line in done.stdout.splitlines():
            name, *values = line.split()
            if name == "projection":
                facts[name] = values[0]
            else:
                numbers = [float(value) for value in values]
                facts[name] = numbers if len(numbers) > 1 else numbers[0]
        return facts

    return run


def read_exr(path):
    """Channels of a file by name."""
    import OpenImageIO

    picture = OpenImageIO.ImageInput.open(str(path))
    assert picture, path
    pixels = picture.read_image("float")
    names = picture.spec().channelnames
    return {name: numpy.array(pixels[..., i]) for i, name in enumerate(names)}
