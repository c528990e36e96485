# SPDX-License-Identifier: Apache-2.0
"""The command line wins over the header, and the header over the default."""

import json
import os
import re
import subprocess

import numpy
import pytest


@pytest.fixture
def parameters(rackfocus, scene):
    """Values and origins as `info` sees them: {key: (value, origin)}."""

    def run(attributes, *arguments, **options):
        path = scene(attributes=attributes, **options)
        found = json.loads(rackfocus("info", path, "--json", *arguments).stdout)
        return {
            key: (entry["value"], entry["origin"])
            for key, entry in found["parameters"].items()
        }

    return run


def test_default(parameters):
    found = parameters({})
    assert found["f-stop"] == (2.8, "default")
    assert found["method"] == ("layered", "default")
    assert found["split-edges"] == (True, "default")


def test_own_attributes(parameters):
    found = parameters(
        {
            "rackfocus:focusDistance": 7.5,
            "rackfocus:blades": 5,
            "rackfocus:depth": "radial",
            "rackfocus:fillHidden": 0,
        }
    )
    assert found["focus-distance"] == (7.5, "header rackfocus:focusDistance")
    assert found["blades"] == (5, "header rackfocus:blades")
    assert found["depth"] == ("radial", "header rackfocus:depth")
    assert found["fill-hidden"] == (False, "header rackfocus:fillHidden")


def test_standard_attributes(parameters):
    found = parameters(
        {
            "aperture": 4.0,
            "focus": 2.5,
            "nominalFocalLength": 85.0,
            "sensorOverallDimensions": (24.0, 16.0),
        }
    )
    assert found["f-stop"] == (4, "header aperture")
    assert found["focus-distance"] == (2.5, "header focus")
    assert found["focal-length"] == (85, "header nominalFocalLength")
    assert found["sensor-width"] == (24, "header sensorOverallDimensions")
    assert found["sensor-height"] == (16, "header sensorOverallDimensions")
    assert found["sensor-fit"][0] == "horizontal"


def test_focus_is_in_metres(parameters):
    attributes = {"focus": 2.5, "rackfocus:unitScale": 100.0}
    assert parameters(attributes)["focus-distance"][0] == 250
    typed = parameters(attributes, "--unit-scale", "10")
    assert typed["focus-distance"][0] == 25


def test_unknown_standard_values_are_ignored(parameters):
    found = parameters({"aperture": 0.0, "focus": -1.0})
    assert found["f-stop"][1] == found["focus-distance"][1] == "default"


def test_own_before_standard(parameters):
    found = parameters({"aperture": 4.0, "rackfocus:fStop": 2.0})
    assert found["f-stop"] == (2, "header rackfocus:fStop")


def test_command_line_before_header(parameters):
    attributes = {"rackfocus:fStop": 2.0, "focus": 3.0, "rackfocus:depth": "radial"}
    found = parameters(attributes, "--f-stop", "8", "--depth=planar")
    assert found["f-stop"] == (8, "command line")
    assert found["depth"] == ("planar", "command line")
    assert found["focus-distance"] == (3, "header focus")


def test_default_typed_still_wins(parameters):
    found = parameters({"rackfocus:fStop": 2.0}, "--f-stop", "2.8")
    assert found["f-stop"] == (2.8, "command line")


def test_pixel_aspect_of_the_file(parameters):
    assert parameters({}, aspect=2.0)["pixel-aspect"] == (2, "header pixelAspectRatio")


def test_forms_of_options(parameters):
    for form in (["--no-split-edges"], ["--split-edges=off"], ["--split-edges", "no"]):
        assert parameters({}, *form)["split-edges"] == (False, "command line")
    assert parameters({}, "--split-edges")["split-edges"] == (True, "command line")
    assert parameters({}, "--blade-rotation", "-15")["blade-rotation"][0] == -15


# ---- one fact in two parameters ----------------------------------------------------

LENS = {"rackfocus:lensRadius": 0.02, "rackfocus:fStop": 2.0}


def test_f_stop_scales_the_lens_radius(parameters):
    found = parameters(LENS, "--f-stop", "4")
    assert found["lens-radius"][0] == pytest.approx(0.01)
    assert found["lens-radius"][1] == "command line (--f-stop)"


def test_focal_length_scales_the_lens_radius(parameters):
    attributes = {"rackfocus:lensRadius": 0.02, "rackfocus:focalLength": 50.0}
    found = parameters(attributes, "--focal-length", "100")
    assert found["lens-radius"][0] == pytest.approx(0.04)


def test_lens_radius_from_the_formula(parameters):
    found = parameters(
        {"rackfocus:lensRadius": 0.02}, "--f-stop", "4", "--focal-length", "80"
    )
    assert found["lens-radius"] == (0, "command line (--f-stop, --focal-length)")


def test_lens_radius_typed(parameters):
    found = parameters(LENS, "--f-stop", "4", "--lens-radius", "0.5")
    assert found["lens-radius"] == (0.5, "command line")


@pytest.mark.parametrize("lens, is_said", [([], False), (["--lens-radius", 0.5], True)])
@pytest.mark.parametrize("typed", [["--f-stop", "4"], ["--focal-length", "100"]])
def test_what_scales_a_fact_has_an_effect(
    rackfocus, scene, tmp_path, typed, lens, is_said
):
    """It is hidden by a lens radius that was typed, not by one that it made."""
    facts = {"focalLength": 50.0, "focalLengthPx": 60.0, "focusDistance": 6.0}
    more = {f"rackfocus:{name}": value for name, value in facts.items()}
    path, out = scene(attributes={**LENS, **more}), tmp_path / "out.exr"
    said = rackfocus("filter", path, "-o", out, *typed, *lens).stderr
    is_hidden = is_said and typed[0] == "--f-stop"
    assert (f"{typed[0]}: has no effect" in said) == is_hidden


def test_f_stop_without_the_old_one(rackfocus, scene, tmp_path):
    path = scene(attributes={"rackfocus:lensRadius": 0.02})
    out = tmp_path / "out.exr"
    done = rackfocus("filter", path, "-o", out, "--f-stop", "4", code=1)
    assert "gives the lens radius (0.02) without an f-stop" in done.stderr
    assert "give --lens-radius" in done.stderr
    assert not out.exists()


def test_f_stop_of_an_orthographic_camera(parameters):
    attributes = {
        "rackfocus:lensRadius": 0.02,
        "rackfocus:projection": "orthographic",
    }
    assert parameters(attributes, "--f-stop", "4")["lens-radius"][0] == 0


def test_focal_length_in_px_gives_way(parameters):
    attributes = {
        "rackfocus:focalLengthPx": 100.0,
        "rackfocus:focalLength": 50.0,
        "rackfocus:lensRadius": 0.02,
    }
    found = parameters(attributes, "--focal-length", "100")
    assert found["focal-length-px"][0] == pytest.approx(200)
    found = parameters(
        {**attributes, "rackfocus:sensorWidth": 36.0}, "--focal-length=9"
    )
    assert found["focal-length-px"] == (0, "command line (--focal-length)")


def test_focal_length_in_px_alone(rackfocus, scene):
    path = scene(attributes={"rackfocus:focalLengthPx": 100.0})
    done = rackfocus("info", path, "--focal-length", "100", code=1)
    assert "gives the focal length in pixels only (100)" in done.stderr
    arguments = ["--focal-length", "100", "--sensor-width", "36"]
    rackfocus("info", path, *arguments)


def test_focus_distance_before_screen_position(parameters):
    attributes = {"rackfocus:screenPosition": 0.06, "rackfocus:optics": "yu"}
    found = parameters(attributes, "--focus-distance", "3")
    assert found["screen-position"][0] == 0


def test_depth_file_supplies_what_the_colour_lacks(rackfocus, scene):
    colour = scene(
        "colour.exr",
        attributes={"rackfocus:fStop": 2.0},
        change=lambda channels: channels.pop("Z"),
    )
    attributes = {"rackfocus:fStop": 9.0, "rackfocus:depth": "radial"}
    depth = scene("depth.exr", attributes=attributes)
    text = rackfocus("info", colour, depth, "--json").stdout
    found = json.loads(text)["parameters"]
    assert found["f-stop"]["value"] == 2
    assert found["depth"]["value"] == "radial"


# ---- info --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "odd, letters",
    [
        (b"\xff", "?"),
        (b"\xe9t\xe9", "?t?"),  # Latin-1
        (b"\xc3", "?"),
        (b"\xc0\xaf", "??"),
        (b"\xed\xa0\x80", "???"),
        (b"\xf4\x90\x80\x80", "????"),
        ("žluť 漢 𝄞".encode(), "žluť 漢 𝄞"),
    ],
)
def test_names_of_any_bytes_are_json(binary, scene, tmp_path, odd, letters):
    path = os.fsencode(tmp_path) + b"/" + odd + b".exr"
    os.rename(scene(), path)
    done = subprocess.run([binary, "info", path, "--json"], capture_output=True)
    name = json.loads(done.stdout.decode())["files"][0]["path"]
    assert name == f"{tmp_path}/{letters.replace('?', chr(0xFFFD))}.exr"


def test_info_reports_the_lens(rackfocus, scene):
    facts = {"rackfocus:focalLengthPx": 1000.0, "rackfocus:blendGamma": 2.2}
    path = scene(attributes=facts)
    arguments = ["--focus-distance", "6", "--lens-radius", "0.03"]
    found = json.loads(rackfocus("info", path, "--json", *arguments).stdout)
    scale = 0.03 * 1000
    assert found["lens"]["min_radius_px"] == pytest.approx(scale * (1 / 6 - 1 / 3))
    assert found["lens"]["max_radius_px"] == pytest.approx(scale * (1 / 6 - 1 / 12))
    assert found["lens"]["near_limit"] == pytest.approx(1 / (1 / 6 + 0.5 / scale))
    assert found["lens"]["far_limit"] == pytest.approx(1 / (1 / 6 - 0.5 / scale))
    assert found["lens"]["hyperfocal_distance"] == pytest.approx(scale / 0.5)
    assert found["depth"]["min"] == 3 and found["depth"]["max"] == 12
    text = rackfocus("info", path, *arguments).stdout
    assert "R (float)" in text and "48 x 32 at (0, 0)" in text
    # The header holds the nearest float.
    assert re.search(r"blend-gamma +2\.2 +header", text)
    assert re.search(r"lens-radius +0\.03 ", text)


@pytest.mark.parametrize(
    "kind, remap",
    [
        ("planar", lambda z: z),
        ("normalised", lambda z: (z - 3) / 9),
        ("buffer", lambda z: (1 / 0.1 - 1 / z) / (1 / 0.1 - 1 / 100)),
        ("buffer-reversed", lambda z: (z == 3) * 0.03),
        ("planar", lambda z: (z == 3) * 8.0),
        (
            "inverse",
            lambda z: numpy.where(z == 3, 1.2, numpy.arange(len(z))[:, None] / 99),
        ),
    ],
)
def test_info_guesses_the_kind(rackfocus, scene, kind, remap):
    path = scene(change=lambda channels: channels.update(Z=remap(channels["Z"])))
    found = json.loads(rackfocus("info", path, "--json").stdout)
    assert found["depth"]["guess"] == kind
    assert not found["depth"]["anti_aliased"]


def test_info_suspects_anti_aliasing(rackfocus, scene):
    def blur(channels):
        z = channels["Z"]
        z[:, 1:-1] = (z[:, :-2] + 2 * z[:, 1:-1] + z[:, 2:]) / 4

    def rows(channels):
        channels["Z"][:] = 12
        channels["Z"][:, 20:] = 3
        blur(channels)
        channels["Z"][:, 19] = channels["Z"][:, 20]
        channels["Z"][:, 20] = 3

    found = json.loads(rackfocus("info", scene(change=rows), "--json").stdout)
    assert found["depth"]["anti_aliased"]


def test_info_suspects_premultiplication(rackfocus, scene):
    def premultiply(channels):
        alpha = 0 * channels["Z"] + 1
        alpha[:, 24] = 0.5
        alpha[:, 25:] = 0
        channels["A"] = alpha
        channels["Z"][:] = 5 * alpha

    found = json.loads(rackfocus("info", scene(change=premultiply), "--json").stdout)
    assert found["depth"]["premultiplied"]


def test_info_of_a_file_without_depth(rackfocus, scene):
    path = scene(change=lambda channels: channels.pop("Z"))
    assert "depth            none" in rackfocus("info", path).stdout


def test_info_of_a_file_of_depth(rackfocus, scene):
    path = scene(change=lambda c: [c.pop(n) for n in "RGB"])
    found = json.loads(rackfocus("info", path, "--json").stdout)
    assert not found["has_colour"] and found["depth"]["max"] == 12


def test_info_shows_bad_depth(rackfocus, scene):
    def spoil(channels):
        channels["Z"][0, 0:3] = [float("nan"), -1, float("inf")]

    text = rackfocus("info", scene(change=spoil), "--json").stdout
    found = json.loads(text)
    assert found["depth"]["n_nan"] == found["depth"]["n_negative"] == 1
    assert found["depth"]["no_hit_share"] == pytest.approx(1 / (48 * 32))
    assert "radius_problem" in found


def test_data_window_keeps_the_rays(rackfocus, scene):
    """A crop is blurred with the lens of the whole picture."""
    whole = json.loads(rackfocus("info", scene("whole.exr"), "--json").stdout)
    crop = scene("crop.exr", size=(20, 10), data=(3, 4, 22, 13), display=(0, 0, 47, 31))
    cropped = json.loads(rackfocus("info", crop, "--json").stdout)
    for name in ("focal_length_px", "lens_radius", "hyperfocal_distance"):
        assert cropped["lens"][name] == pytest.approx(whole["lens"][name])


# ---- cameras of other programs -----------------------------------------------------

# As V-Ray for Maya and for 3ds Max write it: 50 mm and a film of 36 mm, of which the
# picture shows 24 mm.
VRAY = {
    "cameraAperture": 36.0,
    "cameraFNumber": 4.0,
    "cameraFocalLength": 50.0,
    "cameraFov": 26.991466,
    "cameraProjection": 0,
    "cameraTargetDistance": 65.5,
}


def test_the_camera_of_vray(parameters):
    found = parameters(VRAY)
    assert found["focal-length"] == (50, "header cameraFocalLength")
    assert found["sensor-width"] == (pytest.approx(24), "header cameraFov")
    assert found["sensor-fit"][0] == "horizontal"
    assert found["f-stop"] == (4, "header cameraFNumber")
    assert found["focus-distance"] == (65.5, "header cameraTargetDistance")
    assert found["unit-scale"][1] == "default"


def test_vray_with_a_camera_of_its_host(parameters):
    """It writes neither an f-number nor a focal length, and any target."""
    facts = {k: v for k, v in VRAY.items() if k[6:9] not in ("FNu", "Foc")}
    found = parameters(facts)
    assert found["focal-length"][0] == pytest.approx(75)
    assert found["sensor-width"] == (36, "header cameraAperture")
    assert found["focus-distance"][1] == found["f-stop"][1] == "default"


def test_vray_that_says_nothing(parameters):
    assert parameters({**VRAY, "cameraTargetDistance": 1e18})["focus-distance"][0] == 10
    assert parameters({**VRAY, "cameraProjection": 1})["focal-length"][1] == "default"
    assert parameters({**VRAY, "cameraFov": 180.0})["focal-length"][1] == "default"


UNREAL = {
    "unreal/camera/curPos/x": "4.5",
    "unreal/camera/FinalImage/fstop": "2.8",
    "unreal/camera/FinalImage/fov": "39.6",
    "unreal/camera/FinalImage/focalDistance": "331.5",
    "unreal/camera/FinalImage/sensorWidth": "23.76",
    "unreal/camera/FinalImage/minFocalLength": "4.0",
    "unreal/camera/FinalImage/focalLength": "35.0",
    "unreal/camera/FinalImageUI/focalLength": "85.0",
}


@pytest.mark.parametrize("camera", ["camera", "CineCam_2"])
def test_the_camera_of_unreal(parameters, camera):
    facts = {k.replace("camera", camera): v for k, v in UNREAL.items()}
    found = parameters(facts)
    prefix = f"header unreal/{camera}/FinalImage/"
    assert found["focal-length"] == (35, prefix + "focalLength")
    assert found["sensor-width"] == (23.76, prefix + "sensorWidth")
    assert found["f-stop"] == (2.8, prefix + "fstop")
    assert found["focus-distance"] == (331.5, prefix + "focalDistance")
    assert found["unit-scale"] == (100, prefix + "*")
    assert parameters(facts, "--f-stop=4")["f-stop"] == (4, "command line")


def test_a_focus_of_unreal_that_is_off(parameters):
    facts = {**UNREAL, "unreal/camera/FinalImage/focalDistance": "0.0"}
    assert parameters(facts)["focus-distance"][1] == "default"


# As Redshift 2.6 and later write it: the angle in degrees, the film in the host's unit.
REDSHIFT = {
    "rs/camera/DOFFocusDistance": 6.0,
    "rs/camera/FStop": 8.0,
    "rs/camera/aperture": (1.41732, 0.94488),
    "rs/camera/aspect": 1.5,
    "rs/camera/fov": 39.5978,
}


@pytest.mark.parametrize("angle", [39.5978, 0.691112])
def test_the_camera_of_redshift(parameters, angle):
    """Its page says radians, who reads its files says degrees; FStop may be a meter's."""
    facts = {**REDSHIFT, "rs/camera/fov": angle}
    found = parameters(facts)
    by_angle = "header rs/camera/fov"
    assert found["sensor-width"] == (pytest.approx(36, rel=1e-4), by_angle)
    assert found["sensor-fit"][0] == "horizontal"
    assert found["focus-distance"] == (6, "header rs/camera/DOFFocusDistance")
    assert found["f-stop"][1] == found["focal-length"][1] == "default"
    found = parameters(facts, "--focal-length=25")
    assert found["sensor-width"][0] == pytest.approx(18, rel=1e-4)


def test_redshift_that_does_not_fit(parameters):
    """A camera of another shape than the picture, an angle of all around, no focus."""
    other = {**REDSHIFT, "rs/camera/DOFFocusDistance": 0.0}
    for name, value in (("aspect", 1.78), ("fov", 180.0), ("fov", 0.0)):
        found = parameters({**other, f"rs/camera/{name}": value})
        assert found["sensor-width"][1] == found["focus-distance"][1] == "default"


# A render of Houdini: 50 mm and its film of 41.4214 mm, 1280 x 720 px.
HOUDINI = {
    "worldToCamera": (
        *(-0.243232, -0.429738, -0.869577, 0),
        *(-4.55991e-08, 0.8965, -0.443043, 0),
        *(-0.969968, 0.107762, 0.218058, 0),
        *(-0.49336, -0.356619, 6.48486, 1),
    ),
    "worldToNDC": (
        *(-0.587216, -1.84441, -8.69577e-05, 0.869577),
        *(-1.10086e-07, 3.84773, -4.43043e-05, 0.443043),
        *(-2.34172, 0.462509, 2.18058e-05, -0.218058),
        *(-1.19108, -1.53059, 0.000648386, -6.48486),
    ),
}


def ndc_from_0_to_1(matrix):
    """x and y of the rows to x / 2 + w / 2, as RenderMan counts them."""
    rows = numpy.reshape(matrix, (4, 4)).copy()
    rows[:, :2] = rows[:, :2] / 2 + rows[:, 3:] / 2
    return tuple(rows.ravel())


@pytest.mark.parametrize("change", [lambda m: m, ndc_from_0_to_1])
def test_the_sensor_by_world_to_ndc(parameters, change):
    facts = {**HOUDINI, "worldToNDC": change(HOUDINI["worldToNDC"])}
    found = parameters(facts, size=(64, 36))
    assert found["focal-length"] == (50, "default")
    assert found["sensor-width"] == (
        pytest.approx(41.4214, rel=1e-4),
        "header worldToNDC",
    )
    assert found["sensor-fit"][0] == "horizontal"
    found = parameters(facts, "--focal-length=100", size=(64, 36))
    assert found["sensor-width"][0] == pytest.approx(82.8428, rel=1e-4)
    found = parameters(facts, "--sensor-width=36", size=(64, 36))
    assert found["sensor-width"] == (36, "command line")
    assert found["sensor-fit"] == ("auto", "default")


def test_world_to_ndc_of_another_picture(parameters):
    """That of a square, of an orthographic camera, of a matrix without an inverse."""
    ortho = (*(0.2, 0, 0, 0), *(0, 0.3, 0, 0), *(0, 0, 1, 0), *(0, 0, 0, 1))
    flat = {**HOUDINI, "worldToCamera": (0.0,) * 16}
    for facts in (flat, {**HOUDINI, "worldToNDC": tuple(map(float, ortho))}):
        assert parameters(facts, size=(64, 36))["sensor-width"][1] == "default"
    assert parameters(HOUDINI, size=(48, 48))["sensor-width"][1] == "default"


def test_own_angle_before_world_to_ndc(parameters):
    facts = {**HOUDINI, "rackfocus:focalLengthPx": 100.0}
    assert parameters(facts, size=(64, 36))["sensor-width"][1] == "default"


def test_another_angle_of_view_is_warned_of(rackfocus, scene, tmp_path):
    """Nothing else tells: 26 dB where the right one has 36."""
    path = scene(attributes=HOUDINI, size=(64, 36))
    lens = ["-o", tmp_path / "out.exr", "--f-stop", "2", "--focus-distance", "6"]
    for wrong in (["--sensor-width", "36"], ["--focal-length-px", "90"]):
        done = rackfocus("filter", path, *lens, *wrong)
        assert "by worldToNDC of its header 0.8284" in done.stderr
        assert "say --sensor-width 41.42" in done.stderr
    for right in (["--sensor-width", "41.2"], ["--focal-length", "85"], []):
        assert "side by side" not in rackfocus("filter", path, *lens, *right).stderr
    vray = scene("vray.exr", attributes=VRAY)
    done = rackfocus("filter", vray, *lens, "--focal-length", "85")
    assert "by cameraFov of its header 0.48" in done.stderr


def test_the_focus_of_redshift_is_told(rackfocus, scene, tmp_path):
    path, out = scene(attributes=REDSHIFT), tmp_path / "out.exr"
    done = rackfocus("filter", path, "-o", out, "--sensor-width", "24")
    assert "the focus is 6 away, by rs/camera/DOFFocusDistance" in done.stderr
    assert "by rs/camera/fov of its header 0.72" in done.stderr
    done = rackfocus("filter", path, "-o", out, "--focus-distance", "6")
    assert "rs/camera" not in done.stderr


def test_a_target_for_a_focus_is_told(rackfocus, scene, tmp_path):
    lens = ["-o", tmp_path / "out.exr", "--unit-scale", "100"]
    path = scene(attributes={**VRAY, "cameraTargetDistance": 6.0})
    done = rackfocus("filter", path, *lens)
    assert "the focus is at the camera's target, 6 away" in done.stderr
    assert "all of the camera" not in done.stderr
    done = rackfocus("filter", path, *lens, "--focus-distance", "6")
    assert done.stderr.count("warning") == 0
