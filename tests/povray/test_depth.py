# SPDX-License-Identifier: Apache-2.0
"""Depth from fog against the geometry of a plane and two spheres."""

import numpy
import pytest
from conftest import SCENES, read_exr

FOG = "fog { distance 9 color rgb <0.6, 0.7, 0.9> }"
GROUND_FOG = "fog { distance 9 fog_type 2 fog_alt 0.5 turbulence 0.4 rgb 0.7 }"
ROOM = "sphere { <0, 1, -4>, 100 pigment { rgb 1 } }"
RADIOSITY = "global_settings { radiosity { count 20 error_bound 0.5 } }"
WALL = "plane { z, 20 pigment { checker rgb 1 rgb 0.1 } }"


def sphere_distance(rays, start, centre, radius):
    away = start - numpy.array(centre)
    a = (rays * rays).sum(-1)
    b = rays @ away
    inside = b * b - a * (away @ away - radius**2)
    return numpy.where(
        inside > 0, (-b - numpy.sqrt(numpy.maximum(inside, 0))) / a, numpy.inf
    )


def expected_depth(width, height):
    y, x = numpy.mgrid[:height, :width] + 0.5
    focal = width / 2 / numpy.tan(numpy.radians(25))
    rays = numpy.stack(
        [(x - width / 2) / focal, (height / 2 - y) / focal, numpy.ones_like(x)], -1
    )
    start = numpy.array([0, 1, -4.0])
    depth = numpy.full((height, width), 24.0)
    for centre, radius in (((0, 1, 0), 1), ((0.9, 0.8, -2.5), 0.3)):
        depth = numpy.minimum(depth, sphere_distance(rays, start, centre, radius))
    return depth


@pytest.mark.parametrize(
    "gamma, extra",
    [
        ("1.0", ""),
        ("2.2", ""),
        ("srgb", ""),
        ("3", ""),
        ("1.0", FOG),
        ("2.2", FOG),
        ("1.0", GROUND_FOG),
        ("1.0", "sky_sphere { pigment { rgb 3 } }"),
        ("1.0", "media { scattering { 1, 0.02 } absorption 0.01 }"),
        ("1.5", ROOM),
        ("1.0", RADIOSITY),
        ("srgb", RADIOSITY + ROOM),
    ],
    ids=[
        "1",
        "2.2",
        "srgb",
        "3",
        "fog",
        "fog 2.2",
        "ground fog",
        "sky",
        "media",
        "room",
        "radiosity",
        "radiosity in a room",
    ],
)
def test_depth_of_known_geometry(rackfocus, tmp_path, gamma, extra):
    text = (SCENES / "depth.template").read_text()
    text = text.replace("GAMMA", gamma).replace("EXTRA", extra)
    check_depth(rackfocus, tmp_path, text)


def test_the_camera_within_what_an_include_holds(rackfocus, tmp_path):
    """All before a plane is within it: fog is seen in a copy with hollow shapes, in
    includes of includes, too.
    """
    text = (SCENES / "depth.template").read_text()
    assert WALL in text
    text = text.replace("GAMMA", "1.0").replace("EXTRA", "")
    (tmp_path / "stage.inc").write_text('#include "wall.inc"\n')
    (tmp_path / "wall.inc").write_text(WALL)
    check_depth(rackfocus, tmp_path, text.replace(WALL, '#include "stage.inc"'))


#: What is as bright as the fog shows no difference to it.
LAMPS = WALL.replace("rgb 0.1 }", "rgb %d } finish { ambient 1 diffuse 0 }")
BRIGHT_SKY = "sky_sphere { pigment { rgb %d } }"


@pytest.mark.parametrize("gamma", ["1.0", "2.2", "srgb"])
@pytest.mark.parametrize("brightness", [95, 255, 2000])
def test_depth_of_what_is_bright(rackfocus, tmp_path, gamma, brightness):
    """255 is more than half floats hold in a gamma of 2.2."""
    text = (SCENES / "depth.template").read_text()
    text = text.replace("GAMMA", gamma).replace("EXTRA", BRIGHT_SKY % brightness)
    text = text.replace(WALL, LAMPS % brightness)
    check_depth(rackfocus, tmp_path, text, bar=3e-3)


#: A room that needs the word, and things that must not get it.
ROOMS = {
    "plane": "%s",
    "blob of a macro": "#macro C(X) sphere { X,0.1,1 } #end "
    "blob { threshold 0.5 C(<9,9,-9>) } %s",
    "pattern": "#declare P=pigment { object { sphere { 0,1.2 } rgb 1, rgb 0.5 } } %s",
    "bounds": "intersection { sphere { <9,9,-9>,1 } box { 8,10 } bounded_by "
    "{ box { -99,99 } } } %s",
    "macro": "#macro Room() %s #end Room()",
    "declared": "#declare Room = %s Room",
}


@pytest.mark.parametrize("kind", ROOMS)
def test_rooms_among_what_cannot_be_hollow(rackfocus, tmp_path, kind):
    text = (SCENES / "depth.template").read_text()
    room = WALL if kind == "plane" else ROOM
    text = text.replace("GAMMA", "1.0").replace("EXTRA", ROOMS[kind] % room)
    if kind == "plane":
        text = text.replace(WALL, "", 1)
    check_depth(rackfocus, tmp_path, text)


def check_depth(rackfocus, tmp_path, text, bar=1e-3):
    (tmp_path / "depth.pov").write_text(text)
    rackfocus(
        "povray",
        "depth.pov",
        "-o",
        "out.exr",
        "--keep",
        "kept",
        "--",
        "+W160",
        "+H120",
        cwd=tmp_path,
    )
    found = read_exr(tmp_path / "kept" / "passes.exr")["Z"]
    expected = expected_depth(160, 120)
    assert (expected < 2).sum() > 125
    error = numpy.abs(found / expected - 1)
    # A pixel on a rim may fall on either side.
    assert numpy.quantile(error, 0.9995) < bar
    assert numpy.median(error) < 3e-4


def test_infinity(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(
        "#version 3.7; global_settings { assumed_gamma 1 } background { rgb 0.5 }\n"
        "camera { location -5*z look_at 0 aperture 0.2 focal_point 0 }\n"
        "sphere { 0, 1 pigment { rgb 1 } }"
    )
    rackfocus(
        "povray",
        "s.pov",
        "-o",
        "out.exr",
        "--keep",
        "kept",
        "--",
        "+W64",
        "+H48",
        cwd=tmp_path,
    )
    depth = read_exr(tmp_path / "kept" / "passes.exr")["Z"]
    assert numpy.isinf(depth[0, 0]) and depth[24, 32] == pytest.approx(4, rel=3e-3)
