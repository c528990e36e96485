# SPDX-License-Identifier: Apache-2.0
"""Depth through flat clear glass and in flat mirrors, against the geometry."""

import numpy
import pytest
from conftest import SIZE, read_exr

SCENE = """
#version 3.7;
global_settings { assumed_gamma GAMMA }
camera { location <0, 1, -4> look_at <0, 1, 0> right x*4/3 angle 50
  aperture 0.2 focal_point <0, 1, 0> }
light_source { <3, 9, -5> rgb 1 }
plane { z, 10 pigment { checker rgb 0.9 rgb 0.2 } }
"""
OPEN = SCENE.replace("plane { z, 10 pigment { checker rgb 0.9 rgb 0.2 } }", "")
PANE = """box { <-1, 0, 0>, <1, 2, 0.02> THING
  pigment { rgbf <0.9, 1, 0.9, 0.9> } finish { diffuse 0.05 reflection 0.05 }
  interior { ior 1.5 } }"""
BALL = """sphere { <0, 1, 0>, 0.8 pigment { rgbf <0.9, 1, 0.9, 0.9> }
  finish { diffuse 0.05 } interior { ior 1.5 } }"""
MIRROR = """box { <-1, 0, 0>, <1, 2, 0.02> pigment { rgb 0 }
  finish { reflection 0.8 diffuse 0 } }
plane { z, -7 pigment { checker rgb 0.9 rgb 0.2 } }"""
STONE = """box { <-1, 0, 0>, <1, 2, 0.02> pigment { rgb 0.7 } finish { reflection 0.2 } }
plane { z, -7 pigment { rgb 0.9 } }"""
MIDDLE = numpy.s_[45:75, 65:95]


@pytest.fixture
def depth(rackfocus, tmp_path):
    """The depth pass of SCENE with some more, and what was said."""

    def run(more, *options, gamma="1.0", kept="k/passes.exr", scene=SCENE):
        (tmp_path / "s.pov").write_text(scene.replace("GAMMA", gamma) + more)
        done = rackfocus(
            "povray", "s.pov", "-o", "o.exr", "--keep", "k", *options, "--", *SIZE,
            cwd=tmp_path,
        )  # fmt: skip
        return read_exr(tmp_path / kept)["Z"], done.stderr

    return run


@pytest.mark.parametrize(
    "more, gamma, without, through",
    [
        (PANE.replace("THING", ""), "1.0", 4, 14),
        (PANE.replace("THING", ""), "2.2", 4, 14),
        (PANE.replace("THING", "rotate y*25"), "1.0", None, 14),
        (MIRROR, "1.0", 4, 11),
        (MIRROR.replace("0.8", "0.3"), "2.2", 4, 11),
    ],
    ids=["pane", "pane 2.2", "turned pane", "mirror", "dark mirror 2.2"],
)
def test_what_is_seen_there_has_its_own_depth(depth, more, gamma, without, through):
    """The whole way of the ray; without the option that of the first surface."""
    before, _ = depth(more, gamma=gamma)
    after, said = depth(more, "--through-glass", gamma=gamma)
    if without:
        assert numpy.allclose(before[MIDDLE], without, rtol=0.002)
    assert numpy.allclose(after[MIDDLE], through, rtol=0.01)
    assert "--through-glass" not in said
    is_wall = before > 13.9
    assert (before[is_wall] == after[is_wall]).all() and is_wall.any()


@pytest.mark.parametrize("more", [BALL, STONE], ids=["ball", "polished"])
def test_other_things_keep_their_depth(depth, more):
    """Bent light and surfaces that show themselves; a warning that nothing changed."""
    before, _ = depth(more)
    after, said = depth(more, "--through-glass")
    assert (before == after).all()
    assert "--through-glass: no flat clear glass or mirror is seen" in said


def test_views_look_through_glass(depth):
    """Each of them."""
    depths = depth(
        PANE.replace("THING", ""), "--through-glass", "--views", 2,
        kept="k/passes_v01.exr",
    )  # fmt: skip
    assert numpy.allclose(depths[0][MIDDLE], 14, rtol=0.01)


# Before the whole scene: the depth of what is to be blurred is that of the pane.
CLEAR = {
    "box": "box { <-9, -9, -2.5>, <9, 9, 12> pigment { rgbt 1 } hollow }",
    "plane": """plane { -z, 2.5 pigment { rgbf <1, 0.9, 0.7, 1> }
        finish { ambient 0 diffuse 0 } hollow no_shadow }""",
    "pane": "object { " + PANE.replace("THING", "") + " translate -z * 2.5 }",
    "texture": """#include "colors.inc"
        box { <-9, -9, -2.5>, <9, 9, -2.4> texture { pigment { Clear } } hollow }""",
    "vector": """box { <-9, -9, -2.5>, <9, 9, -2.4>
        pigment { color <0, 0, 0, 1, 1> } hollow }""",
}
MIRRORS = {
    "number": "reflection 0.8",
    "dark": "reflection 0.3",
    "colour": "reflection rgb <0.6, 0.8, 0.8>",
    "block": "reflection { 0.7, 0.9 fresnel off falloff 1 }",
    "variable": "reflection #local Share = 0.8; Share",
    "name": '#include "finish.inc"\n Mirror',
}
SEEN_THROUGH = "of the picture is seen through something flat and clear"


@pytest.mark.parametrize("name", CLEAR)
def test_what_is_seen_through_clear_things_is_told(depth, name):
    """Unless the option is there."""
    _, said = depth(CLEAR[name])
    assert SEEN_THROUGH in said and "--through-glass" in said
    assert "accumulate" not in said
    after, said = depth(CLEAR[name], "--through-glass")
    assert said == "" and numpy.allclose(after[MIDDLE], 14, rtol=0.01)


@pytest.mark.parametrize("name", MIRRORS)
def test_what_flat_mirrors_show_is_told(depth, name):
    """Without a word of clear things in the scene."""
    mirror = MIRROR.replace("reflection 0.8", MIRRORS[name])
    _, said = depth(mirror, "--aperture", 0.6)
    assert SEEN_THROUGH in said and "--through-glass" in said


def test_it_is_told_once_of_views_and_frames(depth):
    for more in (["--views", 3], ["--frames", "1-2"]):
        _, said = depth(
            CLEAR["box"], *more,
            kept="k/passes_v00.exr" if "--views" in more else "k/passes0001.exr",
        )  # fmt: skip
        assert said.count(SEEN_THROUGH) == 1


def test_media_in_a_clear_box_have_another_way(depth):
    """They are nearer than what is behind them."""
    media = "hollow interior { media { emission 0.1 } }"
    _, said = depth(CLEAR["box"].replace("hollow", media))
    assert SEEN_THROUGH in said and "--method accumulate" in said


HOLDER = "sphere { <0, 1, 0>, 0.9 pigment { rgbt 1 } hollow INTERIOR }"
#: Ways to write an interior that holds media.
HOLDERS = {
    "own": HOLDER.replace("INTERIOR", "interior { MEDIA }"),
    "ior 1": HOLDER.replace("INTERIOR", "interior { ior 1 MEDIA }"),
    "material": HOLDER.replace("INTERIOR", "material { interior { MEDIA } }"),
    "declared interior": "#declare Inner = interior { MEDIA }"
    + HOLDER.replace("INTERIOR", "interior { Inner }"),
    "declared material": "#declare Smoke = material { interior { MEDIA } }"
    + HOLDER.replace("INTERIOR", "material { Smoke }"),
    "macro": "#macro Smoke() " + HOLDER.replace("INTERIOR", "interior { MEDIA }")
    + "#end Smoke()",
}  # fmt: skip
SEEN_THROUGH_MEDIA = "of the picture is seen through smoke, clouds or other media"


@pytest.fixture
def media_depth(depth):
    """Of things before a hollow wall, as without that there are no media."""

    def run(more, *options, media="media { emission 0.05 }"):
        wall = "plane { z, 9.9 hollow pigment { checker rgb 0.9 rgb 0.2 } }"
        return depth(more.replace("MEDIA", media) + wall, *options, scene=OPEN)

    return run


@pytest.mark.parametrize("name", HOLDERS)
def test_what_is_seen_through_thin_media_is_told(media_depth, name):
    """Of whatever shape their thing is; with the option it has its own depth."""
    before, said = media_depth(HOLDERS[name])
    assert SEEN_THROUGH_MEDIA in said
    assert "--through-glass" in said and "--method accumulate" in said
    assert (before[MIDDLE] < 4.2).all()
    after, said = media_depth(HOLDERS[name], "--through-glass")
    assert said == "" and numpy.allclose(after[MIDDLE], 13.9, rtol=0.002)


@pytest.mark.parametrize(
    "more, media",
    [
        (HOLDERS["own"], "media { absorption 9 }"),
        (HOLDERS["own"], "ior 1.5 media { emission 0.05 }"),
        (HOLDERS["own"].replace("rgbt 1", "rgb 1"), "media { emission 0.05 }"),
    ],
    ids=["dense", "glass", "opaque"],
)
def test_what_hides_or_bends_keeps_its_depth(media_depth, more, media):
    before, said = media_depth(more, media=media)
    assert said == "" and (before[MIDDLE] < 4.2).all()
    after, _ = media_depth(more, "--through-glass", media=media)
    assert (before[MIDDLE] == after[MIDDLE]).all()


def test_bumps_scatter_what_is_seen(depth):
    """No depth is right for that."""
    bumpy = MIRROR.replace(
        "pigment { rgb 0 }", "pigment { rgb 0 } normal { bumps 0.1 }"
    )
    _, said = depth(bumpy, "--aperture", 0.6)
    assert SEEN_THROUGH in said and "bumps (normal)" in said
    assert "--method accumulate" in said


SMALL_PANE = CLEAR["pane"].replace("translate", "scale 0.1 translate y * 0.9 translate")
NEAR_PANE = """box { <-9, -9, 9.8>, <9, 9, 9.9> pigment { rgbt 1 } hollow }"""


@pytest.mark.parametrize(
    "more",
    [BALL, STONE, SMALL_PANE, NEAR_PANE],
    ids=["ball", "polished", "small", "near what it shows"],
)
def test_what_does_not_count_is_not_told(depth, more):
    """Balls show an image near them; the rest changes little."""
    _, said = depth(more)
    assert said == ""


def test_strict_takes_it_for_an_error(rackfocus, tmp_path):
    """--quiet alone asks for no such render."""
    (tmp_path / "s.pov").write_text(SCENE.replace("GAMMA", "1.0") + CLEAR["box"])
    words = ["povray", "s.pov", "-o", "o.exr", "--quiet"]
    assert rackfocus(*words, "--", *SIZE, cwd=tmp_path).stderr == ""
    said = rackfocus(*words, "--strict", "--", *SIZE, cwd=tmp_path, code=1).stderr
    assert SEEN_THROUGH in said
