# SPDX-License-Identifier: Apache-2.0
"""Blender's Denoising Depth: it tells how large the parts of a mixed pixel are."""

import mixed_pixels
import numpy
import plainexr
import pytest
from mixed_pixels import FINE, FOCAL_PX, LENS, WIDTH, channels_of, scene


@pytest.fixture(scope="module")
def passes():
    return mixed_pixels.passes()


@pytest.fixture
def made(rackfocus, tmp_path):
    def run(channels, scale=1, *options):
        path = plainexr.write(tmp_path / "in.exr", channels)
        out = tmp_path / "o.exr"
        lens = [*LENS, "--focal-length-px", str(FOCAL_PX * scale), "--type", "float"]
        said = rackfocus("filter", path, "-o", out, *lens, *options).stderr
        assert "warning" not in said
        return plainexr.read(out)[0]["R"]

    return run


def test_shares_are_those_of_the_samples(made, passes):
    channels, ray = passes
    grey, z, _ = scene(FINE)
    mean = ("--supersample", str(FINE), "--pixel-filter", "box")
    true = made(channels_of(grey, z), FINE, *mean)
    errors = [
        numpy.square(made(given) - true).mean()
        for given in (channels, channels | {"Denoising Depth.Z": ray})
    ]
    print("mean squared errors", errors)
    assert errors[1] < errors[0] / 1.3


@pytest.mark.parametrize("name", ["Denoising Depth.Z", "ViewLayer.Denoising Depth.Z"])
def test_a_layer_of_something_else_changes_nothing(made, passes, name):
    channels, ray = passes
    without = made(channels)
    assert (made(channels | {name: ray}) != without).any()
    for other in (ray**2, 1 / ray, numpy.full_like(ray, numpy.nan), 0 * ray):
        assert (made(channels | {name: other}) == without).all()


def test_what_mirrors_add_is_not_believed(made, passes):
    channels, ray = passes
    without, all_known = made(channels), made(channels | {"Denoising Depth.Z": ray})
    ray = ray.copy()
    # The way on from a mirror.
    ray[:, : WIDTH // 2] += numpy.linspace(0.5, 3, WIDTH // 2, dtype="f4")
    half = made(channels | {"Denoising Depth.Z": ray})
    far = WIDTH // 2 + 40  # beyond the reach of the blur
    assert numpy.allclose(half[:, far:], all_known[:, far:], atol=1e-5)
    assert (half[:, :10] == without[:, :10]).mean() > 0.9


def test_windows_say_that_they_do_not_read_it(rackfocus, tmp_path):
    grey, z, ray = scene(FINE)
    channels = channels_of(grey, z) | {"Denoising Depth.Z": ray.astype("f4")}
    path = plainexr.write(tmp_path / "in.exr", channels)
    lens = ["--focus-distance", "4", "--lens-radius", "0.002"]
    lens += ["--focal-length-px", str(FOCAL_PX * FINE), "--max-memory", "112"]
    said = rackfocus("filter", path, "-o", tmp_path / "o.exr", *lens).stderr
    assert "Denoising Depth is not read in windows" in said
