# SPDX-License-Identifier: Apache-2.0
"""What was asked for happens, or the user is told why not and what to type."""

import json
import os
import pathlib
import resource
import stat
import struct
import subprocess

import numpy
import plainexr
import pytest

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "60"]
PLACES = [(0.05, 0.0), (-0.06, 0.09), (0.0, -0.16)]


@pytest.fixture
def run(rackfocus, tmp_path):
    def run_filter(*arguments, code=0, name="out.exr", lens=LENS, **options):
        return rackfocus(
            *("filter", *arguments, "-o", tmp_path / name, *lens), code=code, **options
        )

    return run_filter


def no_effect(name):
    return f"rackfocus: warning: --{name}: has no effect: "


# ---- options that do not apply -------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ["--copies", "4"],
        ["--slices", "3"],
        ["--box-repeats", "2"],
        ["--depth-near", "1"],
        ["--depth-far", "9"],
        ["--lens-seed", "3"],
        ["--screen-position", "2"],
        ["--blade-rotation", "10"],
        ["--blades", "6", "--method", "scatter"],
        ["--blades", "6", "--method", "box"],
        ["--quality", "normal", "--method", "scatter"],
        ["--png-bits", "8"],
        ["--ortho-scale", "4", "--projection", "perspective"],
        ["--f-stop", "2"],
        ["--format", "exr"],
        ["--coc-limit", "2"],
        ["--film-depth", "all"],
    ],
)
def test_a_useless_option_is_named(run, scene, tmp_path, arguments):
    path = scene()
    done = run(path, *arguments)
    assert no_effect(arguments[0][2:]) in done.stderr
    assert run(path, *arguments, "-q").stderr == ""
    (tmp_path / "out.exr").unlink()
    done = run(path, *arguments, "--strict", code=1)
    assert arguments[0] + ": has no effect" in done.stderr
    assert not (tmp_path / "out.exr").exists()


def test_stages_say_what_they_do_not_show(run, scene):
    alpha = ["--method", "box", "--stage", "alpha", "--blend", "region"]
    said = run(scene(), *alpha, "--highlight-gain", "3", "--box-repeats", "2").stderr
    assert no_effect("highlight-gain") in said and no_effect("box-repeats") in said
    assert "--focus" not in said
    done = run(scene(), *alpha, "--denoise", "--strict", code=1)
    assert "--denoise: has no effect" in done.stderr
    levels = ["--method", "mipmap", "--stage", "levels"]
    said = run(scene(), *levels, lens=["--focus-distance", "6"]).stderr
    assert said == f"{no_effect('focus-distance')}stage levels shows the levels of " + (
        "detail of the picture, whatever its lens and depth are\n"
    )


@pytest.mark.parametrize("name", ["type", "compression"])
def test_options_of_exr_on_png(run, scene, name):
    value = {"type": "half", "compression": "zip"}[name]
    assert no_effect(name) in run(scene(), f"--{name}", value, name="o.png").stderr


def test_radial_depth_of_an_orthographic_camera_is_planar(run, scene):
    lens = ["--focus-distance", "6", "--f-stop", "2", "--ortho-scale", "5"]
    assert no_effect("depth") in run(scene(), "--depth", "radial", lens=lens).stderr


def test_what_is_read_is_not_warned_of(run, scene):
    arguments = ["--blades", "6", "--blade-rotation", "10", "--quality", "normal"]
    assert run(scene(), *arguments).stderr == ""
    assert run(scene(), "--png-bits", "16", name="o.png").stderr == ""
    limit = ["--coc-limit", "2", "--method", "box", "--blend", "region"]
    assert "coc-limit" not in run(scene(), *limit).stderr


def test_scale_of_an_orthographic_camera_says_that_it_is_one(run, scene, tmp_path):
    path = scene()
    lens = ["--focus-distance", "6", "--lens-radius", "0.1", "--ortho-scale", "4"]
    assert run(path, lens=lens, name="a.exr").stderr == ""
    run(path, "--projection", "orthographic", lens=lens, name="b.exr")
    a, b = (plainexr.read(tmp_path / name)[0] for name in ("a.exr", "b.exr"))
    assert all((a[name] == b[name]).all() for name in "RGB")


def test_mist_falloff_is_for_normalised_depth(run, scene):
    done = run(scene(), "--mist-falloff", "linear", code=2)
    assert (
        "--mist-falloff: is for depth from 0 to 1; add --depth normalised"
        in done.stderr
    )


def test_layers_over_each_other_have_no_other_layers(run, scene):
    done = run(scene("a.exr"), scene("b.exr"), "--over", "--filter-layers", "x", code=2)
    assert "--filter-layers is of one picture" in done.stderr


@pytest.mark.parametrize("method", ["mipmap", "mipmap-offset", "recursive-offset"])
def test_methods_that_take_pixels_for_square_say_so(run, scene, method):
    warning = f"--pixel-aspect: the method {method} blurs as if pixels were square"
    stretched = scene("wide.exr", aspect=2.0)
    assert warning in run(stretched, "--method", method).stderr
    assert warning in run(scene(), "--method", method, "--pixel-aspect", "2").stderr
    assert run(scene(), "--method", method).stderr == ""
    run(stretched, "--method", method, "--strict", code=1)


@pytest.mark.parametrize("method", ["layered", "scatter", "box", "lowres", "offset"])
def test_others_blur_round_on_the_screen(run, scene, method, tmp_path):
    assert run(scene(aspect=2.0), "--method", method).stderr == ""
    run(scene(), "--method", method, name="square.exr")
    wide, square = (plainexr.read(tmp_path / n)[0] for n in ("out.exr", "square.exr"))
    assert (wide["R"] != square["R"]).any()


# ---- pictures that no lens takes -----------------------------------------------------


@pytest.mark.parametrize("kind, where", [(0, "the poles"), (1, "the cube's sides")])
def test_environment_maps_are_warned_of(run, rackfocus, scene, kind, where):
    path = scene(attributes={"envmap": ("envmap", bytes([kind]))})
    name = "cube" if kind else "latlong"
    done = run(path)
    assert f"environment map (envmap {name} in its header)" in done.stderr
    assert where in done.stderr
    run(path, "--strict", code=1)
    assert f"environment map  {name}" in rackfocus("info", path).stdout
    facts = json.loads(rackfocus("info", path, "--json").stdout)
    assert facts["files"][0]["parts"][0]["environment"] == name


@pytest.mark.parametrize(
    "space, is_coded",
    [
        ("srgb_rec709_scene", True),  # what OpenImageIO 3 makes of a PNG file
        ("sRGB", True),  # OpenImageIO 2
        ("g22_rec709_scene", True),
        ("Utility - sRGB - Texture", True),
        ("lin_rec709_scene", False),
        ("Linear Rec.709 (sRGB)", False),
        ("ACEScg", False),
        ("scene_linear", False),
        ("data", False),
    ],
)
@pytest.mark.parametrize("name", ["colorInteropID", "oiio:ColorSpace"])
def test_what_is_coded_for_a_screen_is_no_light(run, scene, name, space, is_coded):
    """plane: 35.9 dB where its light has 45.7."""
    told = run(scene(attributes={name: space})).stderr
    assert (f"is not linear light, by {name} {space} in its header" in told) == is_coded
    if is_coded:
        run(scene(attributes={name: space}), "--strict", code=1)


def test_the_mean_of_what_is_coded_for_a_screen(rackfocus, scene, tmp_path):
    for space in ("sRGB", "scene_linear"):
        view = scene(attributes={"oiio:ColorSpace": space})
        said = rackfocus("accumulate", view, view, "-o", tmp_path / "o.exr").stderr
        assert ("is not linear light, by oiio:ColorSpace" in said) == (space == "sRGB")


# ---- the camera ----------------------------------------------------------------------


def test_values_that_nobody_gave_are_named(run, scene):
    path = scene()
    done = run(path, lens=[])
    for text in (
        "focus distance 10",
        "f/2.8",
        "focal length 50 mm",
        "1 units per metre",
    ):
        assert text in done.stderr
    assert "largest radius is 0.1 px; give --focus-distance, --f-stop" in done.stderr
    some = run(path, lens=["--focus-distance", "5", "--unit-scale", "0.01"]).stderr
    assert "f/2.8" in some and "focus distance" not in some and "units" not in some
    assert run(path, lens=["--focus-distance", "5", "--f-stop", "0.2"]).stderr == ""
    assert run(path, lens=[], code=1, *["--strict"]).returncode == 1


@pytest.mark.parametrize("quiet", [[], ["-q"]])
def test_strict_and_quiet_is_strict(run, scene, tmp_path, quiet):
    """Nobody hears of the radii, but a warning about them ends the run."""
    tiny = ["--focus-distance", "6", "--f-stop", "8", "--focal-length", "9"]
    for lens, part in ((tiny, "next to nothing"), ([*LENS, "--max-radius", "0"], None)):
        done = run(scene(), *quiet, "--strict", lens=lens, code=1 if part else 0)
        assert part in done.stderr if part else done.stderr == ""
        assert (tmp_path / "out.exr").exists() == (part is None)


def test_one_line_says_what_was_done(run, scene, tmp_path):
    done = run(scene(), "--method", "scatter")
    line = done.stdout.splitlines()
    assert line == [
        f"{tmp_path / 'out.exr'}: focus 6, lens radius 0.1, radii -1.0 to 0.5 px, "
        "method scatter"
    ]
    done = run(scene(), lens=["--focus-distance", "6", "--f-stop", "1.4"])
    assert "focus 6, f/1.4, 50 mm, radii" in done.stdout
    assert run(scene(), "-q").stdout == ""


def test_an_f_stop_that_cannot_be_applied_says_what_to_type(run, scene):
    attributes = {"rackfocus:lensRadius": 0.1, "rackfocus:focalLengthPx": 60.0}
    path = scene(attributes=attributes)
    done = run(path, "--f-stop", "1.4", lens=[], code=1)
    assert "give --lens-radius 0.141 for one stop more blur" in done.stderr
    assert "--lens-radius 0.0707 for one stop less" in done.stderr
    run(path, "--lens-radius", "0.141", "--focus-distance", "6", lens=[])


# ---- names ---------------------------------------------------------------------------


def test_one_file_is_no_sequence(run, scene, tmp_path):
    done = run(scene(), name="out.####.exr", code=2)
    assert "names frames of a sequence" in done.stderr
    done = run(scene("shot.0007.exr"), name="out.####.exr", code=2)
    assert f"give '{tmp_path / 'shot.####.exr'}' as the input" in done.stderr
    assert not (tmp_path / "out.####.exr").exists()


def test_frames_that_a_shell_named(run, scene, tmp_path):
    for n in (2, 3):
        frames = [scene(f"shot.{i:04d}.exr") for i in range(n)]
        done = run(*frames, code=2)
        assert f"'{tmp_path / 'shot.####.exr'}' as the input" in done.stderr
    done = run(tmp_path / "shot.*.exr", code=2)
    assert f"'{tmp_path / 'shot.####.exr'}'" in done.stderr


@pytest.mark.parametrize("mark", ["%04d", "$F4", "####"])
def test_names_of_other_programs(run, scene, tmp_path, mark):
    for i in (8, 12):
        scene(f"shot.{i:04d}.exr")
    done = run(tmp_path / f"shot.{mark}.exr", name=f"out.{mark}.exr")
    assert "2 frames: 2 filtered" in done.stdout
    assert (tmp_path / "out.0008.exr").exists() and (tmp_path / "out.0012.exr").exists()


@pytest.mark.parametrize("name", ["b.exr", "b.####.exr"])
@pytest.mark.parametrize("folder", ["####", "v1_%04d_x", "v1 %04d (b)"])
@pytest.mark.parametrize("is_whole", [False, True])
@pytest.mark.parametrize("shell", ["sh", "bash"])
def test_numbers_of_folders(run, scene, tmp_path, folder, name, is_whole, shell):
    """The command that is named makes a sequence of them."""
    pattern = f"it's $x/{folder}/{name}"
    for i in (8, 12):
        path = tmp_path / pattern.replace("####", f"{i:04d}").replace(
            "%04d", f"{i:04d}"
        )
        path.parent.mkdir(parents=True)
        pathlib.Path(scene()).rename(path)
    pattern = str(tmp_path / pattern) if is_whole else pattern
    for out in ("out.####.exr", "out.exr"):
        done = run(pattern, name=out, code=2, cwd=tmp_path)
        assert f"{pattern}: the number of a frame is looked for" in done.stderr
    links = done.stderr.split("side by side: ")[1]
    subprocess.run([shell, "-e", "-c", links], cwd=tmp_path, check=True)
    done = run(tmp_path / "frame.####.exr", name="out.####.exr")
    assert "2 frames: 2 filtered" in done.stdout


def test_a_folder_with_a_number_sign(run, scene, tmp_path):
    """C# and the like are no frames."""
    (tmp_path / "take #2").mkdir()
    pathlib.Path(scene()).rename(tmp_path / "take #2" / "shot.0001.exr")
    done = run(tmp_path / "take #2" / "shot.####.exr", name="out.####.exr")
    assert "1 frame: 1 filtered" in done.stdout


@pytest.mark.parametrize(
    "mark",
    [
        "@@@@",  # Shake, RV
        "<frame04>",  # Maya's tokens
        "<frame>",
        "<f4>",  # RenderMan
        "<F4>",
        "{frame}",
        "{frame_number}",  # Unreal
        "[1-240]",  # RV, DJV
        "[####]",  # After Effects
        "$frame",  # Cinema 4D
        "0001-0240",
        "8-12x2",
        "8-12@@@@",
    ],
)
def test_marks_that_are_named(run, scene, tmp_path, mark):
    for i in (8, 12):
        scene(f"shot.{i:04d}.exr")
    name, pattern = f"shot.{mark}.exr", f"'{tmp_path / 'shot.####.exr'}'"
    done = run(tmp_path / name, name="o.####.exr", code=2)
    assert f"{tmp_path / name}: there is no such file" in done.stderr
    assert f"by --frames: {pattern}" in done.stderr
    done = run(tmp_path / "shot.####.exr", name=f"o.{mark}.exr", code=2)
    assert f"with #, as in '{tmp_path / 'o.####.exr'}'" in done.stderr
    assert not list(tmp_path.glob("o.*"))


def test_what_nuke_copies(run, scene, tmp_path):
    """'shot.%04d.exr 1-12' in one word."""
    scene("shot.0008.exr")
    name = tmp_path / "shot.%04d.exr"
    done = run(f"{name} 1-12", name="o.%04d.exr", code=2)
    assert f"by --frames: '{name}'" in done.stderr


def test_a_date_is_no_range(run, tmp_path):
    done = run(tmp_path / "shot_2026-11-30.exr", code=1)
    assert "No such file" in done.stderr and "####" not in done.stderr


def test_a_file_may_be_called_so(run, scene, tmp_path):
    """What is there is taken, whatever it is called."""
    assert run(scene("shot.1-3.exr")).returncode == 0
    assert run(scene("take1-2.0001.exr"), name="o1-2.exr").returncode == 0
    frames = tmp_path / "take1-2.####.exr"
    assert run(frames, name="o1-2.####.exr").returncode == 0
    assert run(scene("me@@home[1].exr"), name="o<f>.exr").returncode == 0
    assert (tmp_path / "o<f>.exr").exists()


def test_numbers_without_zeros(run, scene, tmp_path):
    for i in (8, 12):
        scene(f"shot.{i}.exr")
    run(tmp_path / "shot.%d.exr", name="out.$F.exr")
    assert (tmp_path / "out.8.exr").exists() and (tmp_path / "out.12.exr").exists()


# ---- frames that are taken up again --------------------------------------------------


def test_another_place_of_the_aperture_makes_frames_anew(run, scene, tmp_path):
    attributes = {
        "rackfocus:lensRadius": 0.2,
        "rackfocus:focalLengthPx": 50.0,
        "rackfocus:focusDistance": 6.0,
        "rackfocus:shearDistance": 6.0,
    }
    for i, place in enumerate(PLACES):
        scene(f"v{i}.1.exr", attributes=attributes | {"rackfocus:lensOffset": place})
    views = [tmp_path / f"v{i}.#.exr" for i in range(3)]
    lens = ["--lens-radius", "0.05"]
    assert "1 filtered" in run(*views, name="o.#.exr", lens=lens).stdout
    assert "1 skipped" in run(*views, name="o.#.exr", lens=lens).stdout
    done = run(*views, "--aperture-at", "0.02,0", name="o.#.exr", lens=lens)
    assert "1 filtered, 0 skipped" in done.stdout


def test_another_depth_file_makes_frames_anew(run, scene, tmp_path):
    scene("shot.1.exr")
    scene("z.1.exr", change=lambda c: [c.pop(n) for n in "RGB"])
    scene("y.1.exr", change=lambda c: ([c.pop(n) for n in "RGB"], c["Z"].fill(4)))
    depths = [["--depth-file", tmp_path / f"{name}.#.exr"] for name in "zy"]
    source = tmp_path / "shot.#.exr"
    assert "1 filtered" in run(source, *depths[0], name="o.#.exr").stdout
    assert "1 skipped" in run(source, *depths[0], name="o.#.exr").stdout
    assert "1 filtered, 0 skipped" in run(source, *depths[1], name="o.#.exr").stdout
    # The same name with other pixels, of another time.
    path = tmp_path / "y.1.exr"
    scene("y.1.exr", change=lambda c: ([c.pop(n) for n in "RGB"], c["Z"].fill(5)))
    os.utime(path, ns=(1, 1))
    assert "1 filtered, 0 skipped" in run(source, *depths[1], name="o.#.exr").stdout


# ---- standard input and output -------------------------------------------------------


@pytest.mark.parametrize("kind", ["exr", "png"])
def test_pipes(binary, run, scene, tmp_path, kind):
    path = scene()
    run(path, name=f"out.{kind}")
    with open(path, "rb") as file:
        done = subprocess.run(
            [binary, "filter", "-", "-o", "-", "--format", kind, *LENS],
            stdin=file, capture_output=True, timeout=60,
            env={**os.environ, "TMPDIR": str(tmp_path)},
        )  # fmt: skip
    assert b"standard output: focus" in done.stderr
    assert done.returncode == 0, done.stderr
    assert done.stdout == (tmp_path / f"out.{kind}").read_bytes()
    assert b"method layered" in done.stderr
    assert not list(tmp_path.glob("rackfocus-*"))


def test_info_of_a_pipe(binary, scene):
    with open(scene(), "rb") as file:
        done = subprocess.run([binary, "info", "-"], stdin=file, capture_output=True)
    assert done.returncode == 0 and b"48 x 32" in done.stdout


@pytest.mark.parametrize("kind", ["exr", "png"])
def test_compare_reads_a_pipe(binary, run, scene, tmp_path, kind):
    run(scene(), name=f"a.{kind}")
    path = tmp_path / f"a.{kind}"
    with open(path, "rb") as file:
        done = subprocess.run(
            [binary, "compare", "-", path], stdin=file, capture_output=True
        )
    assert done.returncode == 0 and b"tPSNR inf dB" in done.stdout


def test_a_bad_pipe_is_named(binary, tmp_path):
    done = subprocess.run(
        [binary, "filter", "-", "-o", tmp_path / "o.exr"],
        input=b"no picture", capture_output=True,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == b"rackfocus: standard input: is not an OpenEXR file\n"


@pytest.mark.parametrize("words", [["filter", "-", "-o", "o.exr"], ["info", "-"]])
def test_a_closed_input_is_said(binary, tmp_path, words):
    """Descriptor 0 is then free: the pipe of signals got it, and was waited for."""
    done = subprocess.run(
        [binary, *words], cwd=tmp_path, capture_output=True, timeout=20,
        preexec_fn=lambda: os.close(0),
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == b"rackfocus: -: standard input is closed; send it a file\n"


def test_a_closed_output_is_said_before_the_work(binary, scene, tmp_path):
    done = subprocess.run(
        [binary, "filter", scene(), "-o", "-", *LENS], stderr=subprocess.PIPE,
        timeout=20, preexec_fn=lambda: os.close(1),
    )  # fmt: skip
    assert done.returncode == 1
    assert b"-: standard output is closed; send it into a file" in done.stderr


def test_no_file_gets_the_number_of_a_closed_stream(binary, scene, tmp_path):
    """Messages would be written into it."""
    out = tmp_path / "out.exr"
    child = subprocess.Popen(
        [binary, "filter", "-", "-o", out, *LENS], stdin=subprocess.PIPE,
        preexec_fn=lambda: os.closerange(1, 3),
    )  # fmt: skip
    while len(os.listdir(f"/proc/{child.pid}/fd")) < 5:  # it catches signals
        assert child.poll() is None
    places = [os.readlink(f"/proc/{child.pid}/fd/{n}") for n in (1, 2)]
    child.communicate(pathlib.Path(scene()).read_bytes(), timeout=60)
    assert places == ["/dev/null", "/dev/null"]
    assert child.returncode == 0 and out.exists()


def test_pipes_have_no_other_name(binary, scene, tmp_path):
    """Warnings, results and info say standard input, never a file of ours."""
    data = pathlib.Path(scene(attributes={})).read_bytes()
    for words in (["filter", "-", "-o", "-"], ["info", "-"], ["info", "-", "--json"]):
        done = subprocess.run(
            [binary, *words], input=data, capture_output=True, check=True
        )
        said = done.stderr if words[-1] == "-" and "-o" in words else done.stdout
        assert b"standard input" in said, words
        assert b"standard-" not in done.stderr + done.stdout
        assert b"rackfocus-" not in said


def test_folders_of_killed_commands_are_cleared(binary, scene, tmp_path):
    """By the next one that needs a folder; those of living ones stay."""
    private = tmp_path / "private"
    private.mkdir()
    variables = {**os.environ, "TMPDIR": str(private)}
    waiting = [
        subprocess.Popen(
            [binary, "filter", "-", "-o", tmp_path / "o.exr"],
            stdin=subprocess.PIPE, env=variables,
        )
        for _ in range(2)
    ]  # fmt: skip
    try:
        while len(list(private.glob("*/standard-input.exr"))) < 2:
            assert all(process.poll() is None for process in waiting)
        waiting[0].kill()
        waiting[0].wait()
        assert len(list(private.iterdir())) == 2
        data = pathlib.Path(scene()).read_bytes()
        subprocess.run([binary, "info", "-"], input=data, env=variables, check=True)
        assert len(list(private.iterdir())) == 1 and waiting[1].poll() is None
    finally:
        for process in waiting:
            process.kill()
            process.communicate()


# ---- kinds of pictures ---------------------------------------------------------------


@pytest.mark.parametrize(
    "name, kind, command",
    [
        ("o.jpg", "JPEG", "magick NAME.png NAME.jpg"),
        ("o.JPEG", "JPEG", "magick NAME.png NAME.jpeg"),
        ("o.tif", "TIFF", "oiiotool NAME.exr -o NAME.tif"),
        ("o.tiff", "TIFF", "oiiotool NAME.exr -o NAME.tiff"),
        ("o.gif", "EXR or PNG", "end the name in .exr or .png"),
    ],
)
def test_other_kinds_of_output_are_refused_by_name(
    rackfocus, scene, tmp_path, name, kind, command
):
    path, out = scene(), tmp_path / name
    for words in (["filter", path], ["accumulate", path], ["povray", "s.pov"]):
        done = rackfocus(*words, "-o", out, code=2)
        assert f"{out}: " in done.stderr and kind in done.stderr
        assert command in done.stderr and not out.exists()


# ---- info ----------------------------------------------------------------------------


def test_info_shows_what_matters_first(rackfocus, scene):
    short = rackfocus("info", scene(), *LENS).stdout
    full = rackfocus("info", scene(), *LENS, "--all").stdout
    assert short.index("Blur") < short.index("Parameters")
    assert "focus-distance" in short and "mipmap-bias" not in short
    assert "mipmap-bias" in full and len(short.splitlines()) < 40
    assert "read only by the method box" in rackfocus(
        "info", scene(), "--box-repeats", "2"
    ).stdout  # fmt: skip


# ---- headers -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "attribute, said",
    [
        ("rackfocus:nope", "is not read: there is no such parameter"),
        ("rackfocus:fstop", "is not read; is rackfocus:fStop meant?"),
        ("rackfocus:fStop", None),
        ("rackfocus:fStop.left", None),
        ("rackfocus:lensOffset.left", None),
        ("rackfocus:shearDistance", None),
        ("rackfocus:shutterTime", None),
        ("other:nope", None),
    ],
)
def test_attributes_that_nothing_reads(run, scene, attribute, said):
    path = scene(attributes={attribute: 2.0})
    done = run(path)
    if said:
        assert f"{path}: attribute {attribute} of the header {said}" in done.stderr
        assert done.stderr.count(attribute) == 1
        run(path, "--strict", code=1)
    else:
        assert done.stderr == ""


def test_a_mean_of_one_view_says_so(run, scene):
    done = run(scene(), "--method", "accumulate", lens=[])
    assert "one view is its own mean: nothing is blurred" in done.stderr
    assert "is its own mean" not in run(scene()).stderr


def test_half_a_pixel_is_not_0(run, scene):
    def one(channels):
        for name in channels:
            channels[name] = channels[name][:1, :1]

    done = run(scene(change=one), lens=["--lens-radius", "5", "--focus-distance", "1"])
    assert "cut at a radius of 0.5 px" in done.stderr


# ---- hostile files -------------------------------------------------------------------


@pytest.mark.parametrize("command", ["info", "compare"])
def test_a_pipe_with_a_name_is_refused(rackfocus, tmp_path, command):
    pipe = tmp_path / "pipe.exr"
    os.mkfifo(pipe)
    done = rackfocus(
        command, pipe, *[pipe] * (command == "compare"), code=1, timeout=60
    )
    assert "is not a regular file but a pipe or device" in done.stderr
    assert "name it -, which filter, info and compare take" in done.stderr


def test_too_many_attributes(rackfocus, scene):
    attributes = {f"a{i}": float(i) for i in range(5000)}
    done = rackfocus("info", scene(attributes=attributes), code=1)
    assert "more than 4096 attributes" in done.stderr
    rackfocus("info", scene(attributes={f"a{i}": float(i) for i in range(4000)}))


def test_too_many_channels(rackfocus, tmp_path):
    pixel = numpy.zeros((1, 1), numpy.float16)
    path = plainexr.write(tmp_path / "c.exr", {f"c{i:05d}": pixel for i in range(9000)})
    done = rackfocus("info", path, code=1)
    assert "more than 8192 channels" in done.stderr


def attribute(name, kind, data):
    return (
        name.encode()
        + b"\0"
        + kind.encode()
        + b"\0"
        + struct.pack("<i", len(data))
        + data
    )


def deep_file(path, n_lines, n_samples):
    """A deep file of one column whose lines say that they have so many samples."""
    channels = b"".join(
        name + b"\0" + struct.pack("<iIii", 2, 0, 1, 1)
        for name in (b"A", b"B", b"G", b"R", b"Z")
    )
    box = struct.pack("<4i", 0, 0, 0, n_lines - 1)
    header = struct.pack("<II", 20000630, 2 | 0x800)
    header += attribute("channels", "chlist", channels + b"\0")
    header += attribute("compression", "compression", b"\2")
    header += attribute("dataWindow", "box2i", box)
    header += attribute("displayWindow", "box2i", box)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    header += attribute("type", "string", b"deepscanline")
    header += attribute("name", "string", b"deep")
    header += attribute("version", "int", struct.pack("<i", 1))
    header += attribute("chunkCount", "int", struct.pack("<i", n_lines)) + b"\0"
    chunks, offsets, at = b"", b"", len(header) + 8 * n_lines
    for y in range(n_lines):
        table, data = struct.pack("<i", n_samples), b"\0" * 64
        chunk = struct.pack("<iQQQ", y, len(table), len(data), 20 * n_samples)
        chunks += chunk + table + data
        offsets += struct.pack("<Q", at)
        at = len(header) + 8 * n_lines + len(chunks)
    path.write_bytes(header + offsets + chunks)
    return path


def test_a_small_deep_file_takes_no_large_memory(run, tmp_path):
    path = deep_file(tmp_path / "deep.exr", 120, 100_000_000)
    done = run(path, code=1)
    assert "12000000000 deep samples do not fit into" in done.stderr


def test_no_rights_are_lent_to_the_new_file(run, scene, tmp_path):
    out = tmp_path / "out.exr"
    out.write_bytes(b"old")
    out.chmod(0o6751)
    run(scene())
    assert stat.S_IMODE(out.stat().st_mode) == 0o751


@pytest.mark.parametrize("value", [3e38, -3e38])
def test_the_largest_values_stay_finite(run, scene, tmp_path, value):
    path = scene(change=lambda c: [c[name].fill(value) for name in "RGB"])
    run(path, "--method", "recursive-offset", "--type", "float")
    channels, _ = plainexr.read(tmp_path / "out.exr")
    assert all(numpy.isfinite(channels[name]).all() for name in "RGB")


@pytest.mark.parametrize(
    "data, kind",
    [
        (b"\x89PNG\r\n\x1a\n", "a PNG"),
        (b"\xff\xd8\xff\xe0", "a JPEG"),
        (b"II*\0", "a TIFF"),
        (b"MM\0*", "a TIFF"),
        (b"#?RADIANCE", "a Radiance HDR"),
    ],
)
def test_other_kinds_of_input_are_named(rackfocus, scene, tmp_path, data, kind):
    path, out = tmp_path / "picture", tmp_path / "o.exr"
    path.write_bytes(data + bytes(100))
    words = ["filter", path, "-o", out]
    assert f"{path}: is {kind} file; colour" in rackfocus(*words, code=1).stderr
    words = ["filter", scene(), path, "-o", out]
    assert f"{path}: is {kind} file; colour" in rackfocus(*words, code=1).stderr


# ---- headers of 25 MB ----------------------------------------------------------------

BOMB_BYTES = 25 << 20


def bomb(kind):
    """A header that does not end before BOMB_BYTES."""
    begin = struct.pack("<II", 20000630, 2 | (0x1000 if kind == "parts" else 0))
    channel = b"%s\0" + struct.pack("<iIii", 2, 0, 1, 1)
    if kind == "attributes":
        one = attribute("a%07d", "float", bytes(4)).replace(b"%07d", b"1234567")
        return begin + one * (BOMB_BYTES // len(one))
    if kind == "channels":
        n = BOMB_BYTES // (len(channel) + 6)
        names = b"".join(channel % (b"c%07d" % i) for i in range(n))
        return begin + attribute("channels", "chlist", names + b"\0")
    if kind == "parts":
        names = attribute("channels", "chlist", channel % b"R" + b"\0")
        one = names + attribute("type", "string", b"scanlineimage") + b"\0"
        return begin + one * (BOMB_BYTES // len(one))
    if kind == "strings":
        words = (struct.pack("<i", 4) + b"word") * (BOMB_BYTES // 8)
        return begin + attribute("a", "stringvector", words) * 2
    assert kind == "string"
    return begin + attribute("a", "string", b"x" * BOMB_BYTES) * 2


@pytest.mark.parametrize(
    "kind", ["attributes", "channels", "parts", "strings", "string"]
)
@pytest.mark.parametrize("command", ["info", "filter", "compare"])
def test_a_header_of_25_megabytes_is_refused(binary, tmp_path, kind, command):
    """Long before the system ends it: alone the slowest takes 0.7 s of the processor."""
    path, out = tmp_path / "bomb.exr", tmp_path / "out.exr"
    path.write_bytes(bomb(kind))
    words = {"filter": ["-o", out], "compare": [path]}.get(command, [])
    done = subprocess.run(
        [binary, command, path, *words], capture_output=True, text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (20, 20)),
    )  # fmt: skip
    assert done.returncode == 1, done
    assert done.stderr.startswith(f"rackfocus: {path}: ") and not out.exists()


# ---- a blur that is cut --------------------------------------------------------------


def test_a_blur_that_the_largest_radius_cuts_is_said(run, scene):
    """By default that is half the longer side; typed, it is meant."""
    path = scene()
    cut = "the blur is cut at a radius of 24 px, half the longer side; --max-radius"
    wide = [*LENS, "--lens-radius", "10"]
    assert cut in run(path, lens=wide).stderr
    run(path, "--strict", lens=wide, code=1)
    assert "is cut" not in run(path, "--max-radius", "24", lens=wide).stderr
    assert "is cut" not in run(path, "--max-radius", "4000", lens=wide).stderr
    assert "is cut" not in run(path).stderr


# ---- a window that is not the display's ----------------------------------------------


@pytest.fixture(params=["crop", "overscan"])
def windowed(request, scene):
    """A picture of 48 x 32 px that is part of the display window, or beyond it."""
    sides = {"crop": (99, 79), "overscan": (39, 27)}[request.param]
    return scene(data=(4, 4, 51, 35), display=(0, 0, *sides))


def test_the_sensor_of_a_window_is_read(run, windowed):
    lens = ["--focus-distance", "6", "--f-stop", "2", "--unit-scale", "1"]
    given = ["--focal-length", "50", "--sensor-width", "36"]
    assert run(windowed, *given, "--strict", lens=lens).stderr == ""
    useless = run(windowed, *given, "--focal-length-px", "60", lens=lens).stderr
    assert no_effect("sensor-width") + "focal-length-px is given" in useless


def test_the_sensor_that_is_taken_for_a_window_is_said(run, windowed):
    done = run(windowed, lens=["--focus-distance", "6"])
    assert "sensor 36 mm wide" in done.stderr and "--sensor-width" in done.stderr


def test_a_blur_that_is_cut_in_a_window_is_said(run, windowed):
    done = run(windowed, lens=[*LENS, "--lens-radius", "20"])
    assert "the blur is cut at a radius of" in done.stderr
