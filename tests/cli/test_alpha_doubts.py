# SPDX-License-Identifier: Apache-2.0
"""Colour that is not multiplied by alpha: warned of with what to type, and never where
it is, nor before a sky that is seen where alpha is 0."""

import os
import re

import numpy
import OpenImageIO
import plainexr
import pytest

SIZE = (240, 160)
LENS = ["--focus-distance", "4", "--lens-radius", "0.1", "--focal-length-px", "200"]


def discs(soft):
    """Alpha, unmultiplied colours and depth of discs, rims of `soft` px."""
    width, height = SIZE
    y, x = numpy.mgrid[0:height, 0:width] + 0.5
    alpha, z = numpy.zeros((height, width)), numpy.zeros((height, width))
    light = 0.4 + 0.2 * numpy.sin(x / 5) * numpy.cos(y / 7)
    for at, radius, distance in (((60, 60), 40, 3), ((150, 90), 50, 6)):
        r = numpy.hypot(x - at[0], y - at[1])
        own = numpy.clip((radius - r) / soft + 0.5, 0, 1)
        alpha = own + alpha * (1 - own)
        z[own > 0.5] = distance
    colours = {"R": light, "G": 0.8 * light, "B": 0.3 + 0 * light}
    return alpha, colours, z


@pytest.fixture
def said(rackfocus, tmp_path):
    """What filter says of discs with these colours, made large with `times`."""

    def run(colours, alpha, z, *options, code=0, times=1):
        channels = colours | {"A": alpha, "Z": z}
        larger = numpy.ones((times, times))
        path = plainexr.write(
            tmp_path / "in.exr",
            {n: numpy.kron(v, larger).astype("f4") for n, v in channels.items()},
        )
        arguments = ["-o", tmp_path / "o.exr", *LENS, *options]
        return rackfocus("filter", path, *arguments, code=code).stderr

    return run


def multiplied(colours, alpha):
    return {n: v * alpha for n, v in colours.items()}


@pytest.mark.parametrize("soft", [2, 4, 15])
def test_straight_colour(said, soft):
    alpha, colours, z = discs(soft)
    black = {n: numpy.where(alpha > 0, v, 0) for n, v in colours.items()}
    told = said(black, alpha, z)
    assert "in.exr: rims of things are as bright as what is within" in told
    assert "--ch R,G,B,A --premult -o colour.exr, and filter colour.exr" in told
    assert "unassociated" in said(black, alpha, z, "--strict", code=1)
    assert said(black, alpha, z, "-q") == ""
    assert "unassociated" not in said(multiplied(colours, alpha), alpha, z)


def test_info_says_it_too(rackfocus, said, tmp_path):
    alpha, colours, z = discs(3)
    for colour, is_straight in ((multiplied(colours, alpha), False), (colours, True)):
        said({n: numpy.where(alpha > 0, v, 0) for n, v in colour.items()}, alpha, z)
        told = rackfocus("info", tmp_path / "in.exr").stdout
        assert ("colour is not multiplied by alpha" in told) == is_straight


@pytest.mark.parametrize("sky", [0.1, 0.45, 2])
def test_a_sky_without_alpha_is_none(said, sky):
    alpha, colours, z = discs(3)
    seen = {n: v * alpha + sky * (1 - alpha) for n, v in colours.items()}
    assert "unassociated" not in said(seen, alpha, z)


def test_straight_colour_in_windows(said):
    alpha, colours, z = discs(3)
    black = {n: numpy.where(alpha > 0, v, 0) for n, v in colours.items()}
    options = ("--max-memory", "300")
    assert "unassociated" in said(black, alpha, z, *options, times=8)
    assert "unassociated" not in said(
        multiplied(colours, alpha), alpha, z, *options, times=8
    )


@pytest.mark.parametrize("layer", ["", "beauty.", "ViewLayer.Combined."])
def test_the_command_that_is_named_mends_it(rackfocus, said, tmp_path, layer):
    """Of a layer's names OpenImageIO knows no alpha: the command then did nothing."""
    alpha, colours, z = discs(3)
    black = {n: numpy.where(alpha > 0, v, 0) for n, v in colours.items()}
    said(multiplied(colours, alpha), alpha, z)
    wanted = plainexr.read(tmp_path / "o.exr")[0]
    path = tmp_path / "layers.exr"
    channels = {layer + n: v for n, v in {**black, "A": alpha}.items()} | {"Z": z}
    plainexr.write(path, {n: v.astype("f4") for n, v in channels.items()})
    told = rackfocus("filter", path, "-o", tmp_path / "o.exr", *LENS).stderr
    listed = re.search(r"--ch (\S+) --premult -o colour\.exr", told)[1].split(",")
    names = [item.split("=") for item in listed]
    picture = OpenImageIO.ImageBufAlgo.channels(
        OpenImageIO.ImageBuf(str(path)),
        tuple(name[-1] for name in names),
        tuple(name[0] for name in names),
    )
    mended = OpenImageIO.ImageBufAlgo.premult(picture)
    mended.write(str(tmp_path / "colour.exr"))
    arguments = ["--depth-file", path, "-o", tmp_path / "o.exr", "--compression"]
    done = rackfocus("filter", tmp_path / "colour.exr", *arguments, "none", *LENS)
    assert "unassociated" not in done.stderr
    found = plainexr.read(tmp_path / "o.exr")[0]
    assert max(abs(found[n] - wanted[n]).max() for n in "RGBA") < 1e-3


def test_the_own_lens_of_finish(rackfocus, tmp_path):
    """Blurred rims are wide: straight, or coded for a screen, is said before the work."""
    alpha, colours, _ = discs(15)
    black = {n: numpy.where(alpha > 0, v, 0) for n, v in colours.items()}
    coded = {"colorInteropID": "srgb_rec709_scene"}
    for own, attributes, said in (
        (black, {}, "multiply it first: oiiotool FILE --ch R,G,B,A --premult"),
        (multiplied(colours, alpha), coded, "own.exr: is not linear light"),
        (multiplied(colours, alpha), {}, None),
    ):
        channels = {n: v.astype("f4") for n, v in (own | {"A": alpha}).items()}
        path = plainexr.write(tmp_path / "own.exr", channels, attributes)
        done = rackfocus(
            *("finish", path, "-o", tmp_path / "o.exr"),
            code=1,
            env=os.environ | {"RACKFOCUS_OIDN": str(tmp_path)},
        )
        assert said in done.stderr if said else done.stderr.count("warning") == 1
        strict = rackfocus("finish", path, "-o", tmp_path / "o.exr", "--strict", code=1)
        assert "warning" not in strict.stderr
        assert (said or "has no albedo and no guide") in strict.stderr


def test_the_mean_of_straight_views(rackfocus, said, tmp_path):
    """The mean of straight colours is not that of their light: accumulate says it, too."""
    alpha, colours, z = discs(4)
    out = tmp_path / "mean.exr"
    for colour, is_straight in ((multiplied(colours, alpha), False), (colours, True)):
        said({n: numpy.where(alpha > 0, v, 0) for n, v in colour.items()}, alpha, z)
        view = tmp_path / "in.exr"
        told = rackfocus("accumulate", view, view, "-o", out).stderr
        assert ("in.exr: rims of things are as bright" in told) == is_straight
        assert ("--premult" in told) == is_straight
    assert rackfocus("accumulate", "-q", view, view, "-o", out).stderr == ""
