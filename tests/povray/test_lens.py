# SPDX-License-Identifier: Apache-2.0
"""The recovered lens against what POV-Ray makes of the unmodified scene."""

import re
import subprocess

import numpy
import pytest
from conftest import SCENE, SIZE, read_exr

WORLD = """
sphere { <0,1,0>,1 pigment { checker rgb 1 rgb 0.2 scale 0.2 } }
plane { y,0 pigment { checker rgb 0.9 rgb 0.3 } }
sphere { <0.3,0.8,-2.5>,0.2 pigment { checker rgb 1 rgb 0.2 scale 0.05 } }
light_source { <3,9,-7> rgb 1 }
"""
LENS = "aperture 0.25 blur_samples 100 variance 0"
SMALL = ["+W80", "+H60"]


def scene(camera, version="3.7", world=WORLD):
    return (
        f"#version {version}; global_settings {{ assumed_gamma 1 }}\n"
        f"camera {{ {camera} }}\n{world}"
    )


def picture(path):
    channels = read_exr(path)
    return numpy.stack([channels[name] for name in "RGB"], -1).astype(float)


def encoded(pixels):
    return numpy.clip(pixels, 0, 1) ** (1 / 2.2)


def tpsnr(a, b):
    return -10 * numpy.log10(((encoded(a) - encoded(b)) ** 2).mean() + 1e-12)


def povray_itself(name, folder, *options, size=SIZE):
    command = ["povray", f"+I{name}", "+Ohost.exr", "+FE", "-D", *size, *options]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return picture(folder / "host.exr")


@pytest.mark.parametrize(
    "camera, distance",
    [
        # |direction| as angle, or look_at, left it; 1 where neither is given.
        ("location <0,1,-5> angle 30 look_at <0,1,0>", 2.4818),
        ("location <0,1,-5> direction z*3 angle 40", 1.82707),
        ("location <0,1,-5> direction z*2", 1),
        ("location <0,1,-5> direction z*2 look_at <0,1,0>", 2),
        ("location <0,0.5,-2.5> look_at <0,0.5,0> angle 30 scale 2", 2.4818),
        ("location <0,1,-5> look_at <0,1,0> focal_point <0,1,-5>", 1),
    ],
)
@pytest.mark.parametrize("version", ["3.7", "3.1"])
def test_an_aperture_without_a_focal_point(
    rackfocus, tmp_path, camera, distance, version
):
    """The focus is where POV-Ray's own parser puts it, and where it is said to be."""
    (tmp_path / "s.pov").write_text(scene(f"{camera} {LENS}", version))
    host = povray_itself("s.pov", tmp_path, size=SMALL)
    done = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *SMALL, cwd=tmp_path)
    said = done.stdout
    found = float(re.search(r"focus distance ([0-9.]+)", said).group(1))
    assert found == pytest.approx(distance, rel=1e-4)
    assert ("length of the camera's direction" in said) == ("focal_point" not in camera)
    assert tpsnr(host, picture(tmp_path / "o.exr")) > 35


def test_a_lens_for_a_scene_without_one(rackfocus, tmp_path):
    """What the camera looks at is in focus, and that is said."""
    (tmp_path / "s.pov").write_text(
        scene("location <0,1,-2.5> look_at <0,1,0> translate -z*1 scale <2,1,2>")
    )
    (tmp_path / "t.pov").write_text(scene("location <0,1,-5>"))
    for lens in (["--aperture", 0.5], ["--f-stop", 2.8], ["--lens-radius", 0.1]):
        said = rackfocus("povray", "s.pov", "-o", "o.exr", *lens, "--", *SIZE,
                         cwd=tmp_path).stdout  # fmt: skip
        assert "focus distance 5 (on the camera's look_at" in said
        assert "lens radius 0 " not in said and "lens radius 0," not in said
        text = rackfocus("povray", "t.pov", "-o", "o.exr", *lens, "--", *SIZE,
                         cwd=tmp_path, code=1).stderr  # fmt: skip
        assert "neither focal_point nor look_at" in text and "--focus-distance" in text
    rackfocus("povray", "t.pov", "-o", "o.exr", "--aperture", 0.5, "--focal-point",
              "< 0, 1,-1>", "--", *SIZE, cwd=tmp_path)  # fmt: skip


@pytest.mark.parametrize("options", [[], ["--views", 3], ["--method", "accumulate"]])
@pytest.mark.parametrize("camera", ["", "orthographic "])
def test_an_f_stop_is_the_lens_radius(rackfocus, tmp_path, camera, options):
    """The border, the views, the reference and what is kept are those of its lens."""
    items = f"{camera}location <0,1,-5> look_at <0,1,0> {LENS}"
    (tmp_path / "s.pov").write_text(scene(items))
    lens = {
        "a.exr": ["--lens-radius", 0.1],
        "b.exr": ["--f-stop", 5 if camera else 0.5, "--focal-length", 100,
                  "--sensor-width", 12],
    }  # fmt: skip
    for name, typed in lens.items():
        kept = ["--keep", "kept-" + name] if not options else []
        rackfocus("povray", "s.pov", "-o", name, *typed, *options, *kept, "--", *SMALL,
                  cwd=tmp_path)  # fmt: skip
    expected = picture(tmp_path / "a.exr")
    assert tpsnr(picture(tmp_path / "b.exr"), expected) > 60
    if not options:
        rackfocus("filter", "kept-b.exr", "-o", "c.exr", cwd=tmp_path)
        assert tpsnr(picture(tmp_path / "c.exr"), expected) > 60
    if not camera and not options:
        said = rackfocus("povray", "s.pov", "-o", "b.exr", "--reference", 60,
                         *lens["b.exr"], "--", *SMALL, cwd=tmp_path).stdout  # fmt: skip
        assert float(re.search(r"tPSNR ([0-9.]+)", said)[1]) > 30


@pytest.mark.parametrize("views", [[], ["--views", 2]])
def test_a_tilt_goes_by_the_focal_length(rackfocus, tmp_path, views):
    """1 / distance in focus grows by sin A / f per unit of the tangent."""
    items = f"location <0,1,-5> look_at <0,1,0> {LENS}"
    (tmp_path / "s.pov").write_text(scene(items))
    tilts = {
        "plain.exr": ["--lens-radius", 0.1, "--tilt-x", 4],
        "long.exr": ["--lens-radius", 0.1, "--tilt-x", 4, "--focal-length", 100],
        "asin.exr": ["--lens-radius", 0.1, "--tilt-x", 1.99939],
    }
    if not views:
        tilts["stop.exr"] = ["--f-stop", 0.5, "--focal-length", 100, "--tilt-x", 4]
    made = {}
    for name, typed in tilts.items():
        rackfocus("povray", "s.pov", "-o", name, *typed, *views, "--", *SMALL,
                  cwd=tmp_path)  # fmt: skip
        made[name] = picture(tmp_path / name)
    assert tpsnr(made["plain.exr"], made["asin.exr"]) < 40
    for name in set(made) - {"plain.exr", "asin.exr"}:
        assert tpsnr(made[name], made["asin.exr"]) > 60


@pytest.mark.parametrize(
    "typed",
    [
        ["--focal-length", 85, "--sensor-width", 36],
        ["--focal-length", 85],
        ["--sensor-height", 24],
        ["--unit-scale", 100],
    ],
)
def test_the_view_stays_whatever_sensor_is_typed(rackfocus, tmp_path, typed):
    items = f"location <0,1,-5> look_at <0,1,0> {LENS}"
    (tmp_path / "s.pov").write_text(scene(items))
    words = ["povray", "s.pov", "-o"]
    rackfocus(*words, "plain.exr", "--", *SMALL, cwd=tmp_path)
    said = rackfocus(*words, "o.exr", *typed, "--", *SMALL, cwd=tmp_path).stderr
    assert f"{typed[0]}: has no effect" in said
    assert numpy.array_equal(
        picture(tmp_path / "o.exr"), picture(tmp_path / "plain.exr")
    )


@pytest.mark.parametrize(
    "look, named",
    [
        (["--tilt-x", 8, "--cat-eye", 0.5], "no --cat-eye, --tilt-x,"),
        (["--look", "vintage"], "--swirl"),
        (["--swirl", 0], ""),
        (["--f-stop", 2, "--lens-radius", 0.1], ""),
    ],
)
def test_a_reference_without_the_look_is_told(rackfocus, tmp_path, look, named):
    items = f"location <0,1,-5> look_at <0,1,0> {LENS}"
    (tmp_path / "s.pov").write_text(scene(items))
    words = ["povray", "s.pov", "-o", "o.exr", "--reference", 4, *look]
    done = rackfocus(*words, "--", "+W64", "+H48", cwd=tmp_path)
    assert ("POV-Ray's focal blur has no" in done.stderr) == bool(named)
    assert named in done.stderr
    if named:
        rackfocus(*words, "--strict", "--", "+W64", "+H48", cwd=tmp_path, code=2)


def test_a_look_is_measured_without_the_border(rackfocus, tmp_path):
    """Where it cannot be, what to type is said, and no file of a private folder."""
    items = f"location <0,1,-5> look_at <0,1,0> {LENS}"
    (tmp_path / "s.pov").write_text(scene(items))
    split = ["--split-diopter", 2.5, "--split-offset", 0.4]
    found = []
    for border in (8, 60):
        words = ["povray", "s.pov", "-o", "o.exr", "--overscan", border, *split]
        assert "--split" not in rackfocus(*words, "--", *SIZE, cwd=tmp_path).stderr
        found.append(picture(tmp_path / "o.exr"))
    assert tpsnr(*found) > 55  # 32.7 dB where it is measured with the border
    words = ["povray", "s.pov", "-o", "o.exr", "--cat-eye", 3.99]
    said = rackfocus(*words, "--", *SIZE, cwd=tmp_path).stderr
    assert "--overscan 0" in said and "passes.exr" not in said


@pytest.mark.parametrize(
    "camera",
    [
        "orthographic location <0,2,-8> look_at <0,1,0> right x*4/3 up y angle 0",
        "orthographic location <0,2,-8> direction z*4 look_at <0,1,0>",
        "orthographic location <0,2,-8> direction z*0.5 right x*2 angle 40 "
        "look_at <0,1,0>",
        "orthographic angle 0 location <0,2,-8> direction z*3 right x*4/3",
    ],
)
def test_orthographic_scales(rackfocus, tmp_path, camera):
    """An angle, be it 0, scales right and up with |look_at - location| / |direction|."""
    (tmp_path / "s.pov").write_text(scene(camera))
    host = povray_itself("s.pov", tmp_path, "+A0.05", "+AM2", "+R3", "-J")
    rackfocus("povray", "s.pov", "-o", "o.exr", "--aperture", 1e-6, "--focus-distance",
              5, "--supersample", 1, "--", *SIZE, "-J", cwd=tmp_path)  # fmt: skip
    assert tpsnr(host, picture(tmp_path / "o.exr")) > 40


def test_nothing_is_in_focus(rackfocus, tmp_path):
    """Told of the scene, not of its passes in a private folder, whose unit is known."""
    (tmp_path / "s.pov").write_text(
        "camera { location <0, 1, -3> look_at <0, 1, 300> }\n"
        "plane { z, 1 pigment { checker rgb 1 rgb 0 } }\n"
        "sphere { <0, 1, -1>, 0.5 pigment { rgb 0.5 } }\n"
        "light_source { <3, 9, -9> rgb 1 }\n"
    )
    command = [
        "povray",
        "s.pov",
        "-o",
        "o.exr",
        "--aperture",
        "2",
        "--",
        "+W80",
        "+H60",
    ]
    said = rackfocus(*command, cwd=tmp_path).stderr
    assert "s.pov: nothing is in focus" in said and "--focal-point" in said
    assert "--depth-scale" not in said and "passes" not in said
    focus = ["--focus-distance", 2]
    said = rackfocus(*command[:4], *focus, *command[4:], cwd=tmp_path).stderr
    assert "in focus" not in said


@pytest.mark.parametrize("camera", ["", "orthographic right 4*x up 3*y"])
def test_kept_passes_take_another_f_stop(rackfocus, tmp_path, camera):
    """They know the one that they were rendered for."""
    (tmp_path / "s.pov").write_text(scene(f"{camera} location <0,1,-5> look_at y"))
    unit = ["--unit-scale", 0.1 if camera else 10]
    for name, stop in (("a", 1.4), ("b", 2.8)):
        rackfocus("povray", "s.pov", "-o", f"{name}.exr", "--f-stop", stop, *unit,
                  "--keep", name, "--", *SIZE, cwd=tmp_path)  # fmt: skip
    rackfocus("filter", "a/passes.exr", "-o", "c.exr", "--f-stop", 2.8, "--strict",
              cwd=tmp_path)  # fmt: skip
    assert numpy.array_equal(picture(tmp_path / "b.exr"), picture(tmp_path / "c.exr"))


def test_a_blur_that_is_cut(rackfocus, tmp_path):
    """Of things, with the scene's name and the picture's px; not of a far background."""
    camera = "orthographic location <3,3,-6> look_at y right 8*x up 6*y focal_point y"
    (tmp_path / "s.pov").write_text(
        scene(f"{camera} aperture 0.5", world="sphere { y,1 pigment { rgb 1 } }")
    )
    command = ["povray", "s.pov", "-o", "o.exr", "--overscan", "0"]
    for views in ("1", "2"):
        done = rackfocus(*command, "--views", views, "--", *SIZE, cwd=tmp_path)
        assert "is cut" not in done.stderr
    done = rackfocus(*command, "--aperture", "900", "--", *SIZE, cwd=tmp_path)
    half = max(int(option[2:]) for option in SIZE) // 2
    assert f"s.pov: the blur is cut at a radius of {half} px, half" in done.stderr


def test_a_far_background_of_a_file_is_not_cut(rackfocus, tmp_path):
    """Nor where the picture is filtered in windows, here in too little memory."""
    camera = "orthographic location <3,3,-6> look_at y right 8*x up 6*y focal_point y"
    (tmp_path / "s.pov").write_text(
        scene(f"{camera} aperture 0.5", world="sphere { y,1 pigment { rgb 1 } }")
    )
    rackfocus("povray", "s.pov", "-o", "o.exr", "--keep", "p", "--", *SIZE,
              cwd=tmp_path)  # fmt: skip
    for code, more in enumerate(([], ["--max-memory", "1"])):
        for radius, is_cut in (("0.1", False), ("300", True)):
            done = rackfocus("filter", "p/passes.exr", "-o", "o.exr", *more,
                             "--lens-radius", radius, code=code,
                             cwd=tmp_path)  # fmt: skip
            assert ("is cut" in done.stderr) == is_cut


def test_an_aperture_that_opens(rackfocus, tmp_path):
    """0 in the first frame of an animation, which is as sharp as POV-Ray's own."""
    (tmp_path / "s.pov").write_text(SCENE.replace("aperture 0.6", "aperture 0.6*clock"))
    size = ["--", "+W64", "+H48"]
    said = rackfocus("povray", "s.pov", "-o", "o.#.exr", "--frames", "0-1", *size,
                     cwd=tmp_path).stdout  # fmt: skip
    first, second = map(float, re.findall(r"lens radius (\S+),", said))
    assert 0 < first < 1e-6 and second == pytest.approx(0.15, rel=1e-5)
    said = rackfocus("povray", "s.pov", "-o", "o.exr", *size, cwd=tmp_path, code=1)
    assert "has no aperture; give one with --aperture" in said.stderr
