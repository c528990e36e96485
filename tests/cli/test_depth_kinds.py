# SPDX-License-Identifier: Apache-2.0
"""Depth as renderers write it: undone and said, or refused with the reason."""

import json

import numpy
import plainexr
import pytest

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "100"]
PLAIN = ["--compression", "none", "--type", "float"]
SIZE = (96, 64)


def smooth_disc(channels, radius=18):
    """Coverage of a disc of distance 3 before a wall of 12, anti-aliased."""
    height, width = channels["Z"].shape
    y, x = numpy.mgrid[0:height, 0:width]
    r = numpy.hypot(x + 0.5 - width / 2, y + 0.5 - height / 2)
    return numpy.clip(radius - r + 0.5, 0, 1).astype("f4")


def add_alpha(channels):
    """The disc alone, premultiplied, nothing behind it."""
    alpha = smooth_disc(channels)
    for name, v in zip("RGB", (0.8, 0.4, 0.1), strict=True):
        channels[name] = (v * alpha).astype("f4")
    channels["A"] = alpha
    channels["Z"] = numpy.where(alpha > 0, 3, 0).astype("f4")


@pytest.fixture
def filtered(rackfocus, scene, tmp_path):
    """Filters the changed scene: its channels and what was said."""

    def run(change, *arguments, code=0):
        out = tmp_path / "o.exr"
        path = scene(size=SIZE, change=change)
        done = rackfocus(
            "filter", path, "-o", out, *LENS, *PLAIN, *arguments, code=code
        )
        return (plainexr.read(out)[0] if code == 0 else None), done.stderr

    return run


@pytest.fixture
def seen(rackfocus, scene):
    def run(change):
        path = scene(size=SIZE, change=change)
        assert rackfocus("info", path).returncode == 0
        return json.loads(rackfocus("info", path, "--json").stdout)["depth"]

    return run


def difference(a, b):
    return max(abs(a[name] - b[name]).max() for name in a)


def test_premultiplied(filtered, seen):
    """Divided by alpha, the picture is that of the depth before."""

    def premultiply(channels):
        add_alpha(channels)
        channels["Z"] *= channels["A"]

    want, said = filtered(add_alpha)
    assert said == ""
    got, said = filtered(premultiply)
    assert "was multiplied by alpha" in said
    assert difference(got, want) < 1e-4
    as_it_is, said = filtered(premultiply, "--depth-repair", "off")
    assert said == "" and difference(as_it_is, want) > 0.02
    assert seen(premultiply)["premultiplied"] and not seen(add_alpha)["premultiplied"]


def test_anti_aliased(filtered, seen):
    """Values between two sides become one of them."""

    def mix(channels, is_mixed=True):
        share = smooth_disc(channels)
        for name, v in zip("RGB", (0.8, 0.4, 0.1), strict=True):
            channels[name] = share * v + (1 - share) * channels[name] * 0.5
        near = share if is_mixed else numpy.round(share)
        channels["Z"] = (near * 3 + (1 - near) * 12).astype("f4")

    want, said = filtered(lambda c: mix(c, False))
    assert said == ""
    got, said = filtered(mix)
    assert "was anti-aliased" in said
    as_it_is, said = filtered(mix, "--depth-repair", "off")
    assert said == ""
    error = {n: abs(got[n] - want[n]).mean() for n in got}
    before = {n: abs(as_it_is[n] - want[n]).mean() for n in got}
    assert all(error[n] < 0.5 * before[n] for n in got)
    assert seen(mix)["anti_aliased"]


@pytest.mark.parametrize("kind", ["normalised", "buffer", "buffer-reversed"])
def test_what_is_no_distance_is_refused(filtered, seen, kind):
    def remap(channels):
        z = channels["Z"]
        if kind == "normalised":
            channels["Z"] = (z - 3) / 9
        else:
            v = (100 / z - 100 / 0.1) / (1 - 100 / 0.1)  # near 0.1, far 100
            channels["Z"] = v if kind == "buffer" else numpy.where(z > 5, 0, 1 - v)

    _, said = filtered(remap, code=1)
    assert f"say --depth {kind}" in said and "passes.exr" in said
    assert f"--depth {kind}" in seen(remap)["refused"]
    filtered(remap, "--depth", kind, "--depth-near", "0.1", "--depth-far", "100")
    filtered(remap, "--depth", "planar")
    filtered(remap, "--depth-repair", "off")


@pytest.mark.parametrize(
    "falloff, power", [("linear", 1), ("quadratic", 2), ("inverse-quadratic", 0.5)]
)
def test_mist(filtered, seen, falloff, power):
    """Blender's Mist pass: refused without its range, and exact with it."""

    def mist(channels):
        t = numpy.clip((channels.pop("Z") - 2) / 20, 0, 1)
        channels["ViewLayer.Mist.Z"] = (t**power).astype("f4")

    _, said = filtered(mist, code=1)
    assert "Blender's Mist pass" in said and "--mist-falloff" in said
    assert seen(mist)["mist"] is True
    lens = ["--depth", "normalised", "--depth-near", "2", "--depth-far", "22"]
    got, said = filtered(mist, *lens, "--mist-falloff", falloff)
    want, _ = filtered(None)
    assert said == ""
    assert difference(got, want) < 1e-3


def test_half_with_banding(filtered, seen):
    """A plane far away under a strong lens: 16 bit are coarse, and that is said."""

    def to_half(channels, factor=1.0):
        height, width = channels["Z"].shape
        z = numpy.linspace(4, 40, width)[None].repeat(height, 0) * factor
        channels["Z"] = z.astype("f2")

    lens = ["--lens-radius", "30", "--max-radius", "900"]
    _, said = filtered(to_half, *lens)
    assert "the depth is 16 bit, radii come in steps of up to" in said
    _, said = filtered(to_half)
    assert said == ""
    assert seen(to_half)["half"] is True and seen(None)["half"] is False
    z = 4.0
    step = 3000 * (1 / z - 1 / (z * (1 + 1 / 1024)))
    assert f"{step:.1f} px" in filtered(to_half, *lens)[1]


def test_missing_in_places(filtered, seen):
    """NaN is refused with its place and count; 0 is nothing hit, and info counts it."""

    def holes(value):
        def change(channels):
            channels["Z"][10:14, 20:25] = value

        return change

    _, said = filtered(holes(numpy.nan), code=1)
    assert "20 bad depth values" in said and "(20, 10)" in said
    _, said = filtered(holes(-1), code=1)
    assert "20 bad depth values" in said
    found = seen(holes(0))
    assert found["zero_share"] == pytest.approx(20 / (SIZE[0] * SIZE[1]))
    zero, _ = filtered(holes(0))
    infinite, _ = filtered(holes(numpy.inf))
    assert difference(zero, infinite) == 0
