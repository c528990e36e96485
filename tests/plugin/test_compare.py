# SPDX-License-Identifier: Apache-2.0
"""rackfocus.compare(): the figures of the command, of any buffer."""

import json
import os
import subprocess

import numpy as np
import OpenImageIO as oiio
import pytest
import rackfocus
from test_plugin import make_frame


def write_exr(path, picture):
    """A float EXR of a picture with 3 or 4 channels."""
    height, width, channels = picture.shape
    spec = oiio.ImageSpec(width, height, channels, oiio.FLOAT)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec) and out.write_image(picture), out.geterror()
    out.close()


def command_scores(folder, a, b):
    """What the command's compare prints as JSON."""
    for name, picture in (("a", a), ("b", b)):
        write_exr(folder / f"{name}.exr", picture)
    call = [os.environ["RACKFOCUS"], "compare", "--json"]
    call += [folder / "a.exr", folder / "b.exr"]
    done = subprocess.run(call, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("case", ["near", "same", "black", "small"])
def test_compare_gives_the_figures_of_the_command(tmp_path, case):
    """All of them, to the digits that the command prints."""
    rng = np.random.default_rng(8)
    shape = (4, 7, 3) if case == "small" else (40, 60, 3)
    b = 1.5 * rng.random(shape, np.float32)
    a = b + rng.normal(0, 0.05, shape).astype(np.float32) * (case != "same")
    b = b * np.float32(case != "black")
    expected = command_scores(tmp_path, a, b)
    for name in ("a", "b", "width", "height"):
        del expected[name]
    expected["max_error_pixel"] = tuple(expected["max_error_pixel"])
    found = rackfocus.compare(a, b)
    assert list(found) == list(expected)
    for name, value in expected.items():
        is_number = isinstance(value, float)
        assert found[name] == (pytest.approx(value, rel=1e-8) if is_number else value)
    assert found["identical"] == (case == "same")


def test_compare_takes_any_buffer():
    """Strides, alpha and grey; rows are counted from the first one."""
    a, b = make_frame()[0], make_frame()[0]
    b[3, 5, 1] += 2
    expected = rackfocus.compare(a[..., :3].copy(), b[..., :3].copy())
    assert expected["max_error_pixel"] == (5, 3)
    assert expected["max_error"] == pytest.approx(2)
    b[..., 3] = 0
    assert rackfocus.compare(a, b) == expected
    mirrored = rackfocus.compare(a[::-1], b[::-1])
    assert mirrored["max_error_pixel"] == (5, a.shape[0] - 1 - 3)
    grey = np.ascontiguousarray(a[..., 0])
    three = np.repeat(a[..., :1], 3, axis=2)
    assert rackfocus.compare(grey, b) == rackfocus.compare(three, b)


def test_compare_names_what_is_wrong():
    """Size, channels, type, NaN."""
    a, b = make_frame()[0], make_frame()[0]
    for wrong in (b[1:], b[..., :2], np.zeros((40, 60, 5), np.float32)):
        with pytest.raises(rackfocus.ParameterError, match="^b: ") as caught:
            rackfocus.compare(a, wrong)
        assert caught.value.field == "b"
    b[2, 4, 0] = np.nan
    with pytest.raises(rackfocus.PixelError, match=r"^b: .*\(4, 2\)"):
        rackfocus.compare(a, b)
    with pytest.raises(rackfocus.PixelError, match="^a: "):
        rackfocus.compare(b, a)
    with pytest.raises(TypeError, match="a: "):
        rackfocus.compare(a.astype("f8"), b)
