# SPDX-License-Identifier: Apache-2.0
"""Cameras of scenes with all their ways of saying things, against known numbers."""

import math
import re

import pytest
from conftest import EXAMPLES
from pytest import approx


def near(*numbers):
    return approx(list(numbers), abs=1e-9, rel=1e-9)


def test_condition_comments_and_strings(camera):
    found = camera("conditional.pov")
    assert found["location"] == near(1, 2, -8)
    # angle 40 with right 4/3
    assert math.hypot(*found["direction"]) == approx(4 / 6 / math.tan(math.radians(20)))
    assert found["direction"][0] / found["direction"][2] == approx(-1 / 8)
    assert math.hypot(*found["right"]) == approx(4 / 3)
    assert (found["aperture"], found["blur_samples"]) == (0.4, 7)
    assert found["focus_distance"] == approx(5)
    assert found["gamma"] == 1


def test_items_from_macros(camera):
    found = camera("macro.pov")
    assert found["location"] == near(0, 1, -8)
    assert found["direction"] == near(0, 0, 2 / 3 / math.tan(math.radians(30)))
    assert found["right"] == near(4 / 3, 0, 0)
    assert (found["aperture"], found["focus_distance"]) == (0.2, 7)
    assert found["gamma"] == 2.2


def test_declared_camera_with_transformations(camera):
    found = camera("declared.pov")
    sine, cosine = math.sin(math.radians(10)), math.cos(math.radians(10))
    assert found["location"] == near(-10 * cosine - sine + 0.5, -10 * sine + cosine, 0)
    length = 2 / 3 / math.tan(math.radians(15))
    assert found["direction"] == near(length * cosine, length * sine, 0)
    assert found["right"] == near(0, 0, -4 / 3)
    assert found["up"] == near(-sine, cosine, 0)
    assert (found["aperture"], found["focus_distance"]) == (0.5, 8)


def test_orthographic_with_angle(camera):
    found = camera("orthographic.pov")
    assert found["projection"] == "orthographic"
    # 5 away, tan(angle / 2) = 1/2
    assert math.hypot(*found["right"]) == approx(5)
    assert math.hypot(*found["up"]) == approx(3.75)
    assert found["focus_distance"] == approx(5)


def test_old_style(camera):
    found = camera("old_style.pov")
    assert found["location"] == near(0, 3, -7)
    assert found["direction"] == near(0, 0, 0.665)  # of the right that was known
    assert found["right"] == near(2, 0, 0)
    assert found["focus_distance"] == approx(5)  # from before the translation
    assert found["gamma"] == 2.2  # the curve of sRGB


def test_no_version(camera):
    found = camera("no_version.pov")
    assert found["direction"] == near(0, 0, 2)
    assert found["focus_distance"] == approx(5)
    assert found["gamma"] == 2.2  # such scenes are older than assumed_gamma


def test_no_camera(camera):
    found = camera("no_camera.pov")
    assert found["location"] == near(0, 0, 0)
    assert found["direction"] == near(0, 0, 1)
    assert found["right"] == near(1.33, 0, 0)
    assert found["aperture"] == 0


def test_include_in_include_and_clock(camera):
    assert camera("included.pov")["location"] == near(2, 1, -5)
    found = camera("included.pov", povray=["+K0.5"])
    assert found["location"] == near(2.5, 1, -5)
    assert found["gamma"] == 1.8


def test_copies_that_only_povray_can_resolve(camera):
    found = camera("guesses.pov")
    assert found["location"] == near(4, 1.5, -5)
    assert found["aperture"] == 0.2


def test_cameras_in_an_array(camera):
    found = camera("array.pov")
    assert found["location"] == near(2, 2, -6)
    assert found["aperture"] == approx(0.4)
    assert found["focus_distance"] == approx(53**0.5)


def test_guessed_cameras_render(rackfocus):
    rackfocus("povray", "guesses.pov", "-o", "out.png", "--", "+W64", "+H48")


REST = "look_at <0,1,0> aperture 0.3 focal_point <0,1,0> }"


@pytest.mark.parametrize(
    "text, location",
    [
        ("camera { location #if(0) <0,1,-5> #else <0,2,-5> #end " + REST, (0, 2, -5)),
        (
            "#declare X=1; camera { location #ifdef(X) <0,1,-5> #else 9 #end + y "
            + REST,
            (0, 2, -5),
        ),
        (
            "camera { location #switch(2) #case(1) <0,1,-5> #break #case(2) <0,3,-5> "
            "#break #end " + REST,
            (0, 3, -5),
        ),
        ('#declare N="far"; #include concat(N,".inc")', (0, 1, -7)),
        ('#declare N="near.inc"; #include N', (0, 1, -6)),
    ],
)
def test_values_that_only_povray_can_tell(camera, tmp_path, text, location):
    head = "#version 3.7; global_settings { assumed_gamma 1 }\n"
    (tmp_path / "near.inc").write_text("camera { location <0,1,-6> " + REST)
    # A computed name within what a computed name brought.
    (tmp_path / "far.inc").write_text('#declare F="farther"; #include concat(F,".inc")')
    (tmp_path / "farther.inc").write_text("camera { location <0,1,-7> " + REST)
    (tmp_path / "s.pov").write_text(head + text)
    assert camera("s.pov", cwd=tmp_path)["location"] == near(*location)


FLIGHT = (
    "#declare S = spline { linear_spline 0,<0,1,-5> 1,<0,1,5> } camera { location 0 "
    "look_at z focal_point z*6 aperture 0.3 Spline_Trans(S, 0.25, y, 0.1, 0.5) }"
)


@pytest.mark.parametrize(
    "text, location",
    [
        ("camera { location <0,1,-5> Axis_Rotate_Trans(y, 90) " + REST, (-5, 1, 0)),
        ("camera { location <0,1,-5> transform { Turn(90) } " + REST, (-5, 1, 0)),
        ("camera { location <0,1,-5> Turn(90) Turn(90) " + REST, (0, 1, 5)),
        ("camera { location <0,1,-5> Zoom(20) " + REST, (0, 2, -5)),
        ('camera { location <0,1,-5> #include "zoom.inc" ' + REST, (0, 2, -5)),
        (FLIGHT, (0, 1, -2.5)),
    ],
)
def test_transformations_from_macros(camera, tmp_path, text, location):
    (tmp_path / "zoom.inc").write_text("angle 40 translate y")
    (tmp_path / "s.pov").write_text(
        "#version 3.7; global_settings { assumed_gamma 1 }\n"
        '#include "transforms.inc"\n'
        "#macro Turn(A) rotate y*A #end #macro Zoom(A) angle A translate y #end\n"
        "box { <1,0,1>,<2,1,2> Turn(20) pigment { rgb 1 } }\n" + text
    )
    assert camera("s.pov", cwd=tmp_path)["location"] == near(*location)


@pytest.mark.parametrize("place", ["behind #version", "in the camera"])
def test_many_directives_without_semicolons(camera, tmp_path, place):
    """As scenes of the 1990s have them. Each looked beyond all that follow: 2^60 steps."""
    declared = "\n".join(f"#declare Radius{i} = {i} * 0.1" for i in range(60))
    before, within = ("", declared) if "camera" in place else (declared, "")
    (tmp_path / "s.pov").write_text(
        f"#version 3.1\n{before}\n"
        f"camera {{ location <2,1,-5>\n{within}\nlook_at y aperture 0.5 }}\n"
        "box { -1,1 pigment { rgb 1 } } light_source { <3,9,-7> rgb 1 }"
    )
    assert camera("s.pov", cwd=tmp_path)["location"] == near(2, 1, -5)


def test_what_is_as_near_as_the_probe(camera, tmp_path):
    """A camera 8e5 away from the origin, among things a unit away."""
    (tmp_path / "s.pov").write_text(
        "#version 3.7; global_settings { assumed_gamma 1 }\n"
        "camera { location <8e5,1,-5> look_at <8e5,1,0> }\n"
        "plane { y,0 pigment { checker rgb 0.9 rgb 0.3 } translate x*8e5 }\n"
        "light_source { <800003,9,-7> rgb 1 }"
    )
    assert camera("s.pov", cwd=tmp_path)["location"] == near(8e5, 1, -5)


NARROW = "location <0,0,-4> look_at 0 angle 40"
IN_SHAPE = "right x*image_width/image_height"
FLAT = (
    "orthographic location <0,0,-4> look_at 0 right x*8 up y*8*image_height/image_width"
)
SHEARED = "matrix <1,0,0.6, 0.3,1,0.2, 0,0,1, 0,0,0>"
VIEWS = {
    "narrow": f"{NARROW} {IN_SHAPE}",
    "wide": f"location <0,0,-4> look_at 0 angle 90 {IN_SHAPE}",
    "pixels that are no squares": NARROW,
    "orthographic": FLAT,
    "sheared": f"{NARROW} {IN_SHAPE} {SHEARED}",
    "sheared orthographic": f"{FLAT} {SHEARED}",
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("size", ["400x100", "100x400", "800x100", "10x10"])
def test_panoramas_and_banners(camera, tmp_path, view, size):
    """The card that tells the space leaves room for the check in any picture."""
    (tmp_path / "s.pov").write_text(
        "#version 3.7; global_settings { assumed_gamma 1.5 }\n"
        f"camera {{ {VIEWS[view]} }}\n"
        "plane { z,3 pigment { checker rgb 1 rgb 0 } }"
    )
    width, height = size.split("x")
    found = camera("s.pov", povray=[f"+W{width}", f"+H{height}"], cwd=tmp_path)
    assert found["gamma"] == 1.5
    assert found["location"] == near(0, 0, -4)
    if "image_width" in VIEWS[view]:
        shape = found["right"][0] / found["up"][1]
        assert shape == approx(int(width) / int(height))


@pytest.mark.parametrize("size", ["1500x500", "4000x128", "3200x100", "4000x3000"])
def test_large_pictures(camera, tmp_path, size):
    """Of 4000x3000 only the first rows are rendered for the check."""
    (tmp_path / "s.pov").write_text(
        "camera { location <0,0,-4> angle 40 right x*image_width/image_height }\n"
        "plane { z,3 pigment { checker rgb 1 rgb 0 } }"
    )
    width, height = size.split("x")
    found = camera("s.pov", povray=[f"+W{width}", f"+H{height}"], cwd=tmp_path)
    assert found["location"] == near(0, 0, -4)


def test_guesses_in_a_banner(camera):
    """Another camera than the scene's does not pass the check."""
    found = camera("guesses.pov", povray=["+W400", "+H40"])
    assert found["location"] == near(4, 1.5, -5)


def test_a_scene_too_small_for_povray(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(
        "camera { location <0,1e-5,-5e-5> look_at <0,1e-5,0> }\n"
        "sphere { <0,1e-5,0>,1e-5 pigment { rgb 1 } } plane { y,0 }"
    )
    text = rackfocus("povray", "s.pov", "--camera", cwd=tmp_path, code=1).stderr
    assert "less than POV-Ray draws well" in text and "scale the scene" in text


@pytest.mark.parametrize("size", [(160, 120), (40, 400), (4000, 3000), (1600, 20)])
def test_the_check_is_small(rackfocus, tmp_path, size):
    """Whatever the picture's size, which heavy scenes take long to render."""
    log = tmp_path / "sizes"
    program = tmp_path / "povray"
    program.write_text(
        f"""#!/bin/sh
case "$*" in *probe.pov*) echo "$*" >>"{log}";; esac
exec povray "$@"
"""
    )
    program.chmod(0o755)
    rackfocus("povray", "macro.pov", "--camera", "--povray", program, "--",
              f"+W{size[0]}", f"+H{size[1]}")  # fmt: skip
    rendered = [
        int(re.findall(rf" [+]{letter}([0-9]+)", log.read_text())[-1])
        for letter in "WH"
    ]
    assert rendered == [min(side, 160) for side in size]
    assert log.read_text().count("\n") == 1


@pytest.mark.parametrize(
    "scene, words",
    [
        ("fisheye.pov", ["fisheye.pov:", "type fisheye", "use a perspective"]),
        ("perturbed.pov", ["perturbed.pov:", "normal", "remove"]),
        ("broken.pov", ["broken.pov:4: Parse Error", "Undeclared"]),
        ("no_texture.pov", ["no_texture.pov:5:", "Cannot find file 'lost.png'"]),
    ],
)
def test_clear_errors(rackfocus, scene, words):
    text = rackfocus("povray", scene, "-o", "out.exr", code=1).stderr
    assert all(word in text for word in words), text


@pytest.mark.parametrize(
    "end, words",
    [
        ("sphere { 0, 1\n", "s.pov:2: Parse Error: No matching } in 'sphere', End of"),
        ("#if (1)\n", "s.pov:2: Parse Error: End of file reached but #end expected"),
        ('#debug "a\n', "s.pov:2: Parse Error: No end quote for string"),
    ],
)
def test_errors_at_the_end_are_the_scenes(rackfocus, tmp_path, end, words):
    """Not those of the lines that the command puts behind it."""
    (tmp_path / "s.pov").write_text(
        "camera { location -z look_at 0 aperture 1 }\n" + end
    )
    text = rackfocus("povray", "s.pov", "-o", "o.exr", cwd=tmp_path, code=1).stderr
    assert words in text and "global_settings" not in text


@pytest.mark.parametrize(
    "scene",
    [
        "advanced/chess2.pov",
        "advanced/bwstripe.pov",
        "advanced/diffract.pov",
        "camera/focalblur.pov",
        "camera/shear.pov",
        "camera/orthographic.pov",
        "gamma/gamma_showcase.pov",
        "incdemo/math.pov",
        "incdemo/screen.pov",
        "incdemo/woods/wood_1.pov",
        "objects/fractal3.pov",
        "textures/pigments/skies/stars.pov",
    ],
)
def test_shipped_scenes(camera, scene, tmp_path):
    path = EXAMPLES / scene
    assert camera(path.name, cwd=path.parent)["gamma"] >= 1
