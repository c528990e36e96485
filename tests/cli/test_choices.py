# SPDX-License-Identifier: Apache-2.0
"""What is taken of files with several pictures, or with none, by other commands than
`filter`: it was taken in silence."""

import os

import numpy
import plainexr
import pytest

COMMANDS = {
    "accumulate": "accumulate a.exr b.exr -o out.exr",
    "compare": "compare a.exr b.exr",
    "finish": "finish a.exr --half b.exr -o out.exr",
    "guide": "finish plain.exr --guide a.exr -o out.exr",
}
NEEDS = ("finish", "guide")  # a denoiser, which is not there

LIGHTS = [f"{layer}.{c}" for layer in ("diffuse", "specular") for c in "RGB"]
EYES = [*"RGB", *(f"right.{c}" for c in "RGB")]
IDS = [f"crypto00.{c}" for c in "RGBA"]


@pytest.fixture
def said(rackfocus, tmp_path):
    """What a command says of files with such channels."""

    def run(command, names, *more, attributes=None, code=None):
        generator = numpy.random.default_rng(4)
        for name in ("a", "b", "plain"):
            own = "RGB" if name == "plain" else names
            channels = {n: generator.random((16, 24), numpy.float32) for n in own}
            header = None if name == "plain" else attributes
            plainexr.write(tmp_path / f"{name}.exr", channels, header)
        environment = {**os.environ, "RACKFOCUS_OIDN": "/nowhere"}
        if code is None:
            code = int(command in NEEDS)
        words = [*COMMANDS[command].split(), *more]
        return rackfocus(*words, cwd=tmp_path, code=code, env=environment).stderr

    return run


WAYS_OUT = {
    "accumulate": "; name one with --layer",
    "compare": "; name one with --layer",
    "finish": "; write the one that is meant to a file of its own: oiiotool a.exr --ch ",
    "guide": "; write the one that is meant to a file of its own: oiiotool a.exr --ch ",
}


@pytest.mark.parametrize("command", COMMANDS)
def test_layers_that_fit_equally_well(said, command):
    text = said(command, LIGHTS)
    told = "a.exr: the picture is the first of the layers diffuse, specular, which fit "
    assert told + "equally well" + WAYS_OUT[command] in text


@pytest.mark.parametrize("command", COMMANDS)
def test_one_view_of_several(said, command):
    text = said(command, EYES, attributes={"multiView": ["left", "right"]})
    told = "a.exr: holds the views left, right; only left is taken"
    assert told + WAYS_OUT[command] in text


@pytest.mark.parametrize("command", ["accumulate", "compare"])
@pytest.mark.parametrize(
    "names, attributes, layer",
    [
        (LIGHTS, None, "specular"),
        (EYES, {"multiView": ["left", "right"]}, "right"),
        (EYES, {"multiView": ["left", "right"]}, "left"),
        (IDS, None, "crypto00"),
    ],
)
def test_what_is_named_is_meant(said, command, names, attributes, layer):
    assert not said(command, names, "--layer", layer, attributes=attributes)


@pytest.mark.parametrize("eye", ["left", "right"])
def test_the_mean_of_an_eye_is_alone(said, tmp_path, eye):
    """Its header listed the other eye, which was not in the file."""
    views = {"multiView": ["left", "right"]}
    said("accumulate", EYES, "--layer", eye, attributes=views)
    channels, attributes = plainexr.read(tmp_path / "out.exr")
    assert sorted(channels) == ["B", "G", "R"]
    assert attributes["view"] == eye and "multiView" not in attributes
    first = plainexr.read(tmp_path / "a.exr")[0]["R" if eye == "left" else "right.R"]
    second = plainexr.read(tmp_path / "b.exr")[0]["R" if eye == "left" else "right.R"]
    assert abs(channels["R"] - (first + second) / 2).max() < 1e-6


@pytest.mark.parametrize("command", COMMANDS)
def test_the_only_picture_is_meant(said, command):
    text = said(command, [*"RGB", *IDS, *LIGHTS])
    assert "equally well" not in text and "is taken;" not in text


@pytest.mark.parametrize("command", ["accumulate", "finish"])
def test_data_are_no_picture(said, tmp_path, command):
    """Of identifiers a mean is another one."""
    text = said(command, IDS, code=1)
    assert "a.exr: there is no picture: by " in text and "crypto00" in text
    assert not (tmp_path / "out.exr").exists()
