# SPDX-License-Identifier: Apache-2.0
"""`rackfocus povray --views N`: views from points of the lens, merged."""

import json
import re
import subprocess
import sys

import numpy
import pytest
from conftest import EXAMPLES, HERE

sys.path.insert(0, str(HERE.parent / "cli"))
import plainexr  # noqa: E402

REFERENCES = HERE.parent / "quality" / "references" / "povray"
SIZE = ["--", "+W160", "+H120"]
FOCUS, FAR, RADIUS = 10, 30, 0.25
#: A plane in focus with smooth colours, a small bright sphere far behind it in a gap.
SCENE = """
#version 3.7;
global_settings {{ assumed_gamma 1 }}
camera {{ {camera} location <1,2,-3> direction z*1.5
          aperture 1 focal_point <1,2,7> blur_samples 20 }}
box {{ <-20,-20,7>,<-0.5,20,7.001> texture {{ pigment {{ gradient x scale 4
    color_map {{ [0 rgb 0.1][0.5 rgb 0.9][1 rgb 0.1] }} }}
    finish {{ ambient 1 diffuse 0 }} }} }}
sphere {{ <4,3,27>,0.6 pigment {{ rgb 1 }} finish {{ ambient 1 diffuse 0 }} }}
"""


#: Camera, on which side of the picture the sphere is, and how far it moves in px per
#: scene unit on the lens.
CAMERAS = {
    "perspective": ("right x*4/3 up y", 1, 180 * (1 / FOCUS - 1 / FAR)),
    "left-handed": ("right -x*4/3 up y", -1, 180 * (1 / FOCUS - 1 / FAR)),
    "orthographic": ("orthographic right x*16 up y*12", 1, 10 * (FAR / FOCUS - 1)),
}


@pytest.fixture(params=["perspective"])
def scene(request, tmp_path):
    camera, side, shift = CAMERAS[request.param]
    (tmp_path / "plane.pov").write_text(SCENE.format(camera=camera))
    return "plane.pov", side, shift


def views_of(rackfocus, tmp_path, name, n, *povray):
    rackfocus(
        "povray", name, "--views", n, "-o", "out.exr", "--keep", "kept", *SIZE,
        *povray, cwd=tmp_path,
    )  # fmt: skip
    paths = sorted((tmp_path / "kept").glob("*.exr"))
    assert [path.name for path in paths] == [f"passes_v{i:02}.exr" for i in range(n)]
    return [plainexr.read(path) for path in paths]


def centre(picture, side):
    """Where the far sphere is, px."""
    bright = picture["G"].astype(float).copy()
    half = bright.shape[1] // 2
    bright[:, slice(0, half) if side > 0 else slice(half, None)] = 0
    y, x = numpy.mgrid[0 : bright.shape[0], 0 : bright.shape[1]] + 0.5
    return (bright * x).sum() / bright.sum(), (bright * y).sum() / bright.sum()


@pytest.mark.parametrize("scene", CAMERAS, indirect=True)
def test_only_the_plane_in_focus_stays(rackfocus, scene, tmp_path):
    name, side, shift = scene
    views = views_of(rackfocus, tmp_path, name, 3, "+A0.0", "+AM1", "+R6", "-J")
    first = views[0][0]
    plane = slice(5, 50) if side > 0 else slice(110, 155)
    places = []
    for channels, facts in views:
        assert facts["rackfocus:shearDistance"] == pytest.approx(FOCUS)
        difference = channels["G"][:, plane].astype(float) - first["G"][:, plane]
        assert numpy.abs(difference).max() < 2e-3
        assert channels["Z"][:, plane] == pytest.approx(FOCUS, rel=2e-3)
        u, v = facts["rackfocus:lensOffset"]
        x, y = centre(channels, side)
        places.append((x - u * shift, y + v * shift))
    spread = numpy.ptp(numpy.array(places), axis=0)
    assert spread.max() < 0.05, places


def test_faint_textures_in_focus_are_smooth(rackfocus, tmp_path):
    # Stripes of 1.3 px, darker and brighter by 0.0075: a ray for each pixel leaves 0.0076,
    # rays where neighbours differ 0.0044, 9 rays everywhere 0.0031, POV-Ray's own blur of
    # 200 samples 0.0018. All views have their rays at the same places.
    stripes = """
#version 3.7;
global_settings { assumed_gamma 1 }
camera { right x*4/3 up y location <1,2,-3> direction z*1.5
         aperture 1 focal_point <1,2,7> blur_samples 20 }
plane { z, 7 texture { pigment { gradient x scale 0.07
    color_map { [0 rgb 0.5][0.5 rgb 0.5][0.5 rgb 0.515][1 rgb 0.515] } }
    finish { ambient 1 diffuse 0 } } }
"""
    (tmp_path / "stripes.pov").write_text(stripes)
    views_of(rackfocus, tmp_path, "stripes.pov", 2)
    pixels = plainexr.read(tmp_path / "out.exr")[0]["G"][20:100, 20:140].astype(float)
    assert pixels.mean() == pytest.approx(0.5075, abs=5e-4)
    assert pixels.std() < 0.0055


def test_points_lie_on_the_lens(rackfocus, scene, tmp_path):
    views = views_of(rackfocus, tmp_path, scene[0], 8)
    offsets = numpy.array([facts["rackfocus:lensOffset"] for _, facts in views])
    radii = numpy.hypot(*offsets.T)
    assert radii == pytest.approx(RADIUS * numpy.sqrt((numpy.arange(8) + 0.5) / 8))
    assert numpy.abs(offsets.mean(axis=0)).max() < 0.1 * RADIUS


def test_kept_views_refocus(rackfocus, scene, tmp_path):
    views_of(rackfocus, tmp_path, scene[0], 4)
    kept = sorted((tmp_path / "kept").glob("*.exr"))
    rackfocus("filter", *kept, "-o", "same.exr", cwd=tmp_path)
    rackfocus("filter", *kept, "-o", "far.exr", "--focus-distance", FAR, cwd=tmp_path)
    whole, same, far = (
        plainexr.read(tmp_path / f"{n}.exr")[0]["G"].astype(float)
        for n in ("out", "same", "far")
    )
    assert numpy.array_equal(whole, same)
    sphere = slice(70, 130)
    lit = [(picture[:, sphere] > 0.05).sum() for picture in (same, far)]
    assert lit[1] < 0.7 * lit[0], lit


#: The camera moves along x with the clock and keeps its focus on the plane.
MOVING = SCENE.replace("location <1,2,-3>", "location <1+clock,2,-3>")


def test_an_animation_is_its_frames(rackfocus, tmp_path):
    """Frames made at once are bit for bit those of runs of their own, and differ."""
    (tmp_path / "moving.pov").write_text(
        MOVING.format(camera=CAMERAS["perspective"][0])
    )
    options = ["--views", 4, "--", "+W80", "+H60", "+KI0", "+KF1", "+KFI1", "+KFF4"]
    rackfocus("povray", "moving.pov", "-o", "a.exr", "--frames", "1-4", *options,
              cwd=tmp_path)  # fmt: skip
    pictures = {n: (tmp_path / f"a{n:04}.exr").read_bytes() for n in range(1, 5)}
    assert len(set(pictures.values())) == 4
    for frame in (1, 3):
        rackfocus("povray", "moving.pov", "-o", "b.exr", "--frames", f"{frame}-{frame}",
                  *options, cwd=tmp_path)  # fmt: skip
        assert (tmp_path / f"b{frame:04}.exr").read_bytes() == pictures[frame], frame


def test_one_file_keeps_all_views(rackfocus, scene, tmp_path):
    rackfocus("povray", scene[0], "--views", 3, "-o", "out.exr", "--keep", "all.exr",
              *SIZE, cwd=tmp_path)  # fmt: skip
    views_of(rackfocus, tmp_path, scene[0], 3)
    kept = sorted((tmp_path / "kept").glob("*.exr"))
    found = json.loads(rackfocus("info", "all.exr", "--json", cwd=tmp_path).stdout)
    assert [part["view"] for part in found["files"][0]["parts"]] == [
        "v00", "v01", "v02",
    ]  # fmt: skip
    for path, view in zip(kept, found["views"], strict=True):
        place = plainexr.read(path)[1]["rackfocus:lensOffset"]
        assert view["lens_offset"] == pytest.approx(place)
    rackfocus("filter", "all.exr", "-o", "again.exr", cwd=tmp_path)
    a, b = (plainexr.read(tmp_path / name)[0] for name in ("out.exr", "again.exr"))
    assert all(numpy.array_equal(a[name], b[name]) for name in "RGB")


@pytest.mark.parametrize(
    "options, text",
    [
        (["--method", "layered"], "merged by the method views"),
        (["--f-stop", "2", "--optics", "lens"], "--aperture"),
    ],
)
def test_wrong_usage(rackfocus, scene, tmp_path, options, text):
    done = rackfocus("povray", scene[0], "--views", 4, "-o", "o.exr", *options,
                     cwd=tmp_path, code=2)  # fmt: skip
    assert text in done.stderr


#: Focus distances of references/povray/focalblur_focus_*.exr, scene units.
CAPTURED, OTHERS = 51.449, (40, 46, 58)


@pytest.fixture(scope="module")
def focalblur_views(binary, tmp_path_factory):
    """Eight small views of focalblur.pov, from the lens that the scene has."""
    folder = tmp_path_factory.mktemp("focalblur")
    path = EXAMPLES / "camera" / "focalblur.pov"
    subprocess.run(
        [binary, "povray", path.name, "--views", "8", "-o", folder / "out.exr",
         "--keep", folder / "kept", "--", "+W320", "+H240"],
        cwd=path.parent, check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    return sorted((folder / "kept").glob("*.exr"))


def score_at(rackfocus, views, focus, out):
    """tPSNR of views refocused to a distance, against POV-Ray's own lens there."""
    rackfocus("filter", *views, "-o", out, "--focus-distance", focus)
    reference = REFERENCES / f"focalblur_focus_{int(focus)}.exr"
    text = rackfocus("compare", out, reference).stdout
    return float(re.search(r"tPSNR ([0-9.]+) dB", text).group(1))


def test_refocused_views_are_what_the_lens_shows(rackfocus, focalblur_views, tmp_path):
    captured = score_at(rackfocus, focalblur_views, CAPTURED, tmp_path / "o.exr")
    scores = {
        focus: score_at(rackfocus, focalblur_views, focus, tmp_path / "o.exr")
        for focus in OTHERS
    }
    print(f"as captured {captured:.2f} dB;", scores)
    assert captured > 40
    for focus in OTHERS:
        assert scores[focus] > captured - 1.5, focus


def test_beats_one_view(rackfocus, focalblur_views, tmp_path):
    path = EXAMPLES / "camera" / "focalblur.pov"
    out, reference = tmp_path / "one.exr", f"focalblur_focus_{int(CAPTURED)}.exr"
    rackfocus("povray", path.name, "-o", out, "--", "+W320", "+H240", cwd=path.parent)
    text = rackfocus("compare", out, REFERENCES / reference).stdout
    one = float(re.search(r"tPSNR ([0-9.]+) dB", text).group(1))
    several = score_at(rackfocus, focalblur_views, CAPTURED, tmp_path / "o.exr")
    print(f"one view {one:.2f} dB, 8 views {several:.2f} dB")
    assert several > one
