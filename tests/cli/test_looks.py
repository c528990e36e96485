# SPDX-License-Identifier: Apache-2.0
"""--look and --aperture-image: kinds of lenses, and pictures of the aperture."""

import numpy
import plainexr
import pytest

LENS = ["--focus-distance", "3", "--f-stop", "0.1"]


def made(rackfocus, scene, tmp_path, *options):
    out = tmp_path / "out.exr"
    rackfocus("filter", scene(), "-o", out, "--compression", "none", *LENS, *options)
    return numpy.stack([plainexr.read(out)[0][name] for name in "RGB"])


@pytest.mark.parametrize("name", "vintage anamorphic fast bubble miniature".split())
def test_looks_do_something(rackfocus, scene, tmp_path, name):
    plain = made(rackfocus, scene, tmp_path)
    assert not numpy.array_equal(
        plain, made(rackfocus, scene, tmp_path, "--look", name)
    )


def test_a_look_is_its_options_and_typed_ones_win(rackfocus, scene, tmp_path):
    look = made(rackfocus, scene, tmp_path, "--look", "bubble", "--spherical", "0")
    typed = made(rackfocus, scene, tmp_path, "--cat-eye", "0.4")
    assert numpy.array_equal(look, typed)


def test_a_look_of_ones_own(rackfocus, scene, tmp_path, monkeypatch):
    folder = tmp_path / "config/rackfocus/looks"
    folder.mkdir(parents=True)
    (folder / "mine.params").write_text("blades 5\n")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    own = made(rackfocus, scene, tmp_path, "--look", "mine")
    assert numpy.array_equal(own, made(rackfocus, scene, tmp_path, "--blades", "5"))


@pytest.mark.parametrize(
    "options, part",
    [
        (["--look", "sharp"], "there are vintage, anamorphic"),
        (["--aperture", "image"], "--aperture-image FILE"),
        (["--aperture-image", "a.exr", "--method", "box"], "layered, views and scatter"),
    ],
)
def test_what_is_wrong_is_said(rackfocus, scene, tmp_path, options, part):
    out = tmp_path / "out.exr"
    done = rackfocus("filter", scene(), "-o", out, *options, code=2)
    assert part in done.stderr
    assert not out.exists()
