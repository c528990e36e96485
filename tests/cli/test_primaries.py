# SPDX-License-Identifier: Apache-2.0
"""Numbers of other primaries are other colours: ACEScg is not Rec. 709."""

import os
import struct

import numpy
import pytest

ACESCG = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
ACESCG_D65 = (*ACESCG[:6], 0.3127, 0.329)
P3_D65 = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329)
P3_CINEMA = (*P3_D65[:6], 0.314, 0.351)
REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "60"]
COMMANDS = {
    "filter top.exr bottom.exr --over -o out.exr": "they are put over each other",
    "filter top.exr bottom.exr -o out.exr": "they are merged",
    "accumulate top.exr bottom.exr -o out.exr": "the mean is taken of them",
    "compare top.exr bottom.exr": "they are compared",
}


def chromaticities(values):
    return {"chromaticities": ("chromaticities", struct.pack("<8f", *values))}


def add_alpha(channels):
    channels["A"] = numpy.ones_like(channels["R"])


@pytest.fixture
def said(rackfocus, scene, tmp_path):
    """What a command says of two pictures, top.exr and bottom.exr."""

    def run(command, *attributes, code=0):
        names = ("top", "bottom")
        for name, x, more in zip(names, (0.04, -0.04), attributes, strict=True):
            place = {"rackfocus:lensOffset": (x, 0.0)}
            scene(f"{name}.exr", attributes={**place, **more}, change=add_alpha)
        lens = LENS if command.startswith("filter") else []
        return rackfocus(*command.split(), *lens, cwd=tmp_path, code=code).stderr

    return run


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    "top, bottom, by",
    [
        (chromaticities(ACESCG), {}, "chromaticities"),
        (chromaticities(REC_709), chromaticities(ACESCG), "chromaticities"),
        (chromaticities(P3_D65), chromaticities(P3_CINEMA), "chromaticities"),
        ({"oiio:ColorSpace": "ACEScg"}, {}, "oiio:ColorSpace"),
        ({}, {"colorInteropID": "lin_ap1_scene"}, "colorInteropID"),
    ],
)
def test_colours_of_two_kinds_are_told(said, command, top, bottom, by):
    """Both were taken as numbers of one kind, in silence."""
    text = said(command, top, bottom)
    assert "its colours have other primaries than those of " in text
    assert f", by {by} in the header of the " in text
    assert f"{COMMANDS[command]} as if they were alike; bring all into one" in text


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    "top, bottom",
    [
        ({}, chromaticities(REC_709)),
        (chromaticities(ACESCG), chromaticities(ACESCG_D65)),
        (chromaticities(ACESCG), {"oiio:ColorSpace": "ACEScg"}),
        ({"colorInteropID": "lin_rec709_scene"}, {}),
    ],
)
def test_colours_of_one_kind_are_not_told(said, command, top, bottom):
    assert "primaries" not in said(command, top, bottom)


@pytest.mark.parametrize("command", ["filter", "accumulate"])
def test_many_views_are_told_once(rackfocus, scene, tmp_path, command):
    for i in range(4):
        more = chromaticities(ACESCG) if i > 1 else {}
        scene(f"v{i}.exr", attributes={"rackfocus:lensOffset": (0.01 * i, 0.0), **more})
    words = [command, *(f"v{i}.exr" for i in range(4)), "-o", "out.exr"]
    lens = LENS if command == "filter" else []
    text = rackfocus(*words, *lens, cwd=tmp_path).stderr
    assert text.count("other primaries") == 1
    assert "warning: v2.exr: its colours" in text


def test_strict_makes_no_picture_of_them(said, tmp_path):
    command = "filter top.exr bottom.exr --over -o out.exr --strict"
    assert "other primaries" in said(command, chromaticities(ACESCG), {}, code=1)
    assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize(
    "command, name",
    [
        ("filter top.exr bottom.exr --over -o out.png", "bottom.exr"),
        ("accumulate top.exr bottom.exr -o out.png", "top.exr"),
    ],
)
def test_their_png_is_told(said, command, name):
    """As that of `filter` is of one picture."""
    aces = chromaticities(ACESCG)
    text = said(command, aces, aces)
    assert (
        f"out.png: the colours are not of Rec. 709, by {aces.popitem()[0]} in" in text
    )
    assert f"in the header of {name}, and a PNG" in text


@pytest.mark.parametrize("option", ["--guide", "--half"])
def test_finish_tells_them(rackfocus, scene, tmp_path, option):
    """Before it asks for the denoiser, which is not there."""

    def said(attributes):
        paths = [
            scene(f"{i}.exr", attributes=a, change=lambda channels: channels.pop("Z"))
            for i, a in enumerate((chromaticities(ACESCG), attributes))
        ]
        words = ["finish", paths[0], option, paths[1], "-o", tmp_path / "out.exr"]
        environment = {**os.environ, "RACKFOCUS_OIDN": "/nowhere"}
        return rackfocus(*words, code=1, env=environment).stderr

    assert "and one is mended by the other as if they were alike" in said({})
    assert "primaries" not in said(chromaticities(ACESCG))
