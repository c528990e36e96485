# SPDX-License-Identifier: Apache-2.0
"""Every way to get it wrong has its own message and exit code, and leaves no file."""

import math
import os
import resource
import subprocess

import numpy
import plainexr
import pytest


@pytest.fixture
def fails(rackfocus, tmp_path):
    """`filter` with these arguments fails, says all of `texts` and writes nothing."""

    def check(*arguments, code, texts, output="out.exr", **options):
        before = sorted(os.listdir(tmp_path))
        done = rackfocus(
            "filter", *arguments, "-o", tmp_path / output, code=code, **options
        )
        assert done.stdout == ""
        lines = done.stderr.splitlines()
        assert len(lines) == 1 and lines[0].startswith("rackfocus: "), done.stderr
        for text in texts:
            assert text in lines[0], f"{text!r} is not in {lines[0]!r}"
        assert sorted(os.listdir(tmp_path)) == before
        return lines[0]

    return check


# ---- files -------------------------------------------------------------------------


def test_missing_file(fails):
    fails("nowhere.exr", code=1, texts=["nowhere.exr: ", "No such file"])


@pytest.mark.parametrize(
    "arguments, option",
    [
        (["--aperture-image", "no.png"], "aperture-image"),
        (
            ["--method", "scatter", "--distribution-image", "no.png"],
            "distribution-image",
        ),
        (["--depth-file", "no.png"], "depth-file"),
        (["--params", "no.params"], "params"),
        (["--look", "./no.params"], "look"),
    ],
)
def test_missing_file_of_an_option(fails, scene, arguments, option):
    """The option is named, of several files it may be any, with the way out."""
    texts = [f"--{option}: there is no file {arguments[-1]}", "leave the option out"]
    fails(scene(), *arguments, code=2 if option == "look" else 1, texts=texts)


def test_no_picture_at_all(fails, tmp_path):
    path = tmp_path / "text.exr"
    path.write_text("hello")
    fails(path, code=1, texts=["text.exr: "])


def test_empty_file(fails, tmp_path):
    path = tmp_path / "empty.exr"
    path.write_bytes(b"")
    fails(path, code=1, texts=["empty.exr: "])


def test_cut_file(fails, scene):
    path = scene()
    with open(path, "r+b") as file:
        file.truncate(os.path.getsize(path) // 2)
    fails(path, code=1, texts=["passes.exr: "])


def test_folder_as_input(fails, tmp_path):
    (tmp_path / "folder.exr").mkdir()
    fails(tmp_path / "folder.exr", code=1, texts=["folder.exr: "])


def test_unreadable_file(binary, scene):
    path = scene()
    os.chmod(path, 0)
    user = 65534 if os.geteuid() == 0 else None
    command = [binary, "info", path]
    try:
        done = subprocess.run(command, capture_output=True, text=True, user=user)
    except PermissionError:
        pytest.skip("only root may run the command here, and root reads every file")
    assert done.returncode == 1
    assert "passes.exr: " in done.stderr and "Permission denied" in done.stderr


def test_output_folder_is_missing(rackfocus, scene, tmp_path):
    out = tmp_path / "nowhere" / "out.exr"
    done = rackfocus("filter", scene(), "-o", out, code=1)
    assert "cannot write into its folder: No such file or directory" in done.stderr


@pytest.mark.parametrize("option", ["-o", "--output-coc"])
def test_output_of_a_name_that_is_too_long(rackfocus, scene, tmp_path, option):
    """Told before any work: the depth, which is read first, cannot be filtered."""
    path = scene(change=lambda channels: channels["Z"].fill(math.nan))
    good = [] if option == "-o" else ["-o", tmp_path / "out.exr"]
    name = tmp_path / ("x" * 300 + ".exr")
    done = rackfocus("filter", path, option, name, *good, code=1)
    assert "the name is too long for its file system" in done.stderr


def test_output_is_a_folder(rackfocus, scene, tmp_path):
    (tmp_path / "out.exr").mkdir()
    done = rackfocus("filter", scene(), "-o", tmp_path / "out.exr", code=1)
    assert "out.exr: is a folder" in done.stderr


# ---- channels and sizes ------------------------------------------------------------


def test_no_depth_channel(fails, scene):
    path = scene(change=lambda c: c.pop("Z"))
    fails(
        path,
        code=1,
        texts=[
            "passes.exr: there is no depth channel",
            "B, G, R",
            "--depth-channel",
            "--depth-file",
        ],
    )


def test_no_colour(fails, scene):
    def keep_depth(channels):
        for name in "RGB":
            channels.pop(name)

    fails(
        scene(change=keep_depth), code=1, texts=["passes.exr: there is no colour", "Z"]
    )


def test_depth_file_without_depth(fails, scene):
    colour = scene("colour.exr", change=lambda c: c.pop("Z"))
    texts = ["colour.exr: there is no depth channel", "B, G, R", "--depth-channel"]
    fails(colour, "--depth-file", colour, code=1, texts=texts)


def test_unknown_depth_channel(fails, scene):
    fails(scene(), "--depth-channel", "W", code=1, texts=["W", "B, G, R, Z"])


def test_unknown_layer(fails, scene):
    fails(scene(), "--layer", "Fog", code=1, texts=["passes.exr: ", "Fog"])


def test_sizes_differ(fails, scene):
    colour = scene("colour.exr", change=lambda c: c.pop("Z"))
    depth = scene("depth.exr", size=(40, 32))
    texts = ["depth.exr: the depth is 40 x 32", "colour.exr is 48 x 32"]
    fails(colour, "--depth-file", depth, code=1, texts=texts)


def test_windows_differ(fails, scene):
    colour = scene("colour.exr", change=lambda c: c.pop("Z"))
    depth = scene("depth.exr", data=(5, 0, 52, 31), display=(0, 0, 47, 31))
    fails(colour, depth, code=1, texts=["depth.exr: the depth begins at pixel (5, 0)"])


def test_two_whole_pictures(fails, scene):
    texts = ["b.exr: has colour and depth, and so has", "a.exr", "--depth-file"]
    fails(scene("a.exr"), scene("b.exr"), code=1, texts=texts)


# ---- pixels ------------------------------------------------------------------------


@pytest.mark.parametrize("nothing", [0, -0.0])
def test_empty_depth(fails, scene, nothing):
    path = scene(change=lambda c: c["Z"].fill(nothing))
    fails(path, code=1, texts=["passes.exr: "])


@pytest.mark.parametrize("nothing", [numpy.inf, 1e10])
def test_nothing_but_sky_is_no_error(rackfocus, scene, tmp_path, nothing):
    path = scene(change=lambda c: c["Z"].fill(nothing))
    rackfocus("filter", path, "-o", tmp_path / "out.exr")


def test_nan_colour(fails, scene):
    def spoil(channels):
        channels["G"][4, 7] = channels["B"][5, 8] = numpy.nan

    # The first warning is on the camera, which the file does not say.
    fails(
        scene(change=spoil),
        *("--focus-distance", "6", "--lens-radius", "0.1"),
        code=1,
        texts=["passes.exr: ", "2 colour values", "7, 4"],
    )


def test_nan_depth(fails, scene):
    def spoil(channels):
        channels["Z"][4, 7] = numpy.nan

    fails(scene(change=spoil), code=1, texts=["passes.exr: ", "depth", "7, 4"])


def test_bad_depth_names_the_depth_file(fails, scene):
    def spoil(channels):
        channels["Z"][4, 7] = -1

    colour = scene("colour.exr", change=lambda c: c.pop("Z"))
    depth = scene("depth.exr", change=spoil)
    fails(colour, "--depth-file", depth, code=1, texts=["depth.exr: ", "7, 4"])


# ---- parameters --------------------------------------------------------------------


def test_zero_f_stop(fails, scene):
    texts = ["--f-stop is 0; its range is 0.001 to 1e+06"]
    fails(scene(), "--f-stop", "0", code=2, texts=texts)


def test_zero_f_stop_in_the_header(fails, scene):
    path = scene(attributes={"rackfocus:fStop": 0.0})
    texts = ["passes.exr: attribute rackfocus:fStop", "is 0", "give --f-stop"]
    fails(path, code=1, texts=texts)


def test_bad_attribute_is_overruled(rackfocus, scene, tmp_path):
    path = scene(attributes={"rackfocus:fStop": 0.0})
    rackfocus("filter", path, "-o", tmp_path / "out.exr", "--f-stop", "4")


def test_focus_inside_focal_length(fails, scene):
    arguments = ["--optics", "lens", "--focus-distance", "0.04"]
    texts = ["--focus-distance: ", "inside the focal length"]
    fails(scene(), *arguments, code=2, texts=texts)


def test_focus_inside_focal_length_in_the_header(fails, scene):
    path = scene(
        attributes={"rackfocus:focusDistance": 0.04, "rackfocus:optics": "lens"}
    )
    texts = [
        "passes.exr: ",
        "inside the focal length",
        "header rackfocus:focusDistance",
    ]
    fails(path, code=1, texts=texts)


def test_conflict_with_a_default(fails, scene):
    arguments = ["--optics", "lens", "--focal-length", "50000"]
    texts = ["passes.exr: ", "inside the focal length", "from the default"]
    fails(scene(), *arguments, code=2, texts=texts)


def test_two_blades(fails, scene):
    fails(scene(), "--blades", "2", code=2, texts=["--blades: ", "3 to 16"])


@pytest.mark.parametrize(
    "arguments, texts",
    [
        (["--fstop", "2"], ["unknown option --fstop", "did you mean --f-stop?"]),
        (["--focus", "2"], ["unknown option --focus", "--focus-distance?"]),
        (["--ouput", "x"], ["unknown option --ouput", "--output?"]),
        (["--xyzzy"], ["unknown option --xyzzy", "rackfocus filter --help"]),
        (["--f_stop", "2"], ["unknown option --f_stop", "--f-stop?"]),
        (["-x"], ["unknown option -x"]),
        (["--f-stop", "wide"], ["--f-stop cannot be 'wide'", "0.001 to 1e+06"]),
        (["--f-stop", "2,8"], ["--f-stop cannot be '2,8'"]),
        (["--f-stop", "nan"], ["--f-stop is nan"]),
        (["--f-stop="], ["--f-stop cannot be ''"]),
        (["--method", "magic"], ["--method cannot be 'magic'", "layered, scatter"]),
        (["--blades", "4.5"], ["--blades is 4.5", "whole numbers"]),
        (["--split-edges=maybe"], ["--split-edges cannot be 'maybe'"]),
        (["--no-f-stop"], ["unknown option --no-f-stop"]),
        (["--no-split-edges=1"], ["--no-split-edges takes no value"]),
        (["-j", "-1"], ["--threads: '-1' is not a number from 0 to 1024"]),
        (["-j", "0x10"], ["--threads: '0x10' is not a number from 0 to 1024"]),
        (["--f-stop", "0x10"], ["f-stop cannot be '0x10'; it is a number from"]),
        (["-j", "1.5"], ["--threads: '1.5' is not a whole number"]),
        (["--type", "double"], ["--type: 'double' is none of half|float"]),
        (["--quiet=yes"], ["--quiet takes no value"]),
        (["--depth-file", ""], ["--depth-file: the value is empty"]),
        (["third.exr", "fourth.exr"], ["one file of colour and one of depth"]),
    ],
)
def test_wrong_usage(fails, scene, arguments, texts):
    fails(scene(), *arguments, code=2, texts=texts)


def test_value_is_missing(rackfocus):
    done = rackfocus("filter", "in.exr", "--f-stop", code=2)
    assert "--f-stop: the value is missing" in done.stderr


def test_no_output_and_no_input(rackfocus, scene):
    assert "filter needs an output" in rackfocus("filter", scene(), code=2).stderr
    assert "filter needs an input" in rackfocus("filter", code=2).stderr


def test_unknown_kind_of_output(fails, scene):
    texts = [
        "out.jpg: pictures are written as EXR or PNG, not as JPEG",
        "end the name in .png",
    ]
    fails(scene(), code=2, texts=texts, output="out.jpg")
    texts = ["--output-coc: ", ".exr"]
    fails(scene(), "--output-coc", "c.png", code=2, texts=texts)


def test_names_that_begin_with_a_dash(rackfocus, scene, tmp_path):
    scene("-x.exr")
    done = rackfocus("filter", "-x.exr", "-o", "o.exr", cwd=tmp_path, code=2)
    assert "if '-x.exr' is a file, name it ./-x.exr" in done.stderr
    assert "./" not in rackfocus("filter", "-Q", "-o", "o.exr", code=2).stderr
    rackfocus("filter", "./-x.exr", "-o", "o.exr", cwd=tmp_path)


@pytest.mark.parametrize(
    "arguments, texts",
    [
        (["in.exr", "-o", "ff", "--format", "exr"],
         ["ff: --format is of the standard output, -o -", ".exr or .png"]),
        (["in.exr", "-o", "/dev/null"], ["/dev/null: is no file on a disk", "-o -"]),
        (["in.exr", "-o", "o.exr", "--depth-file", "-"],
         ["--depth-file: takes a file", "rackfocus filter colour.exr - -o"]),
        (["in.exr", "-o", "o.exr", "--params", "-"], ["--params: takes a file"]),
        (["in.exr", "-o", "o.exr", "--aperture-image", "-"], ["--aperture-image: takes"]),
    ],
)  # fmt: skip
def test_where_a_pipe_can_be(rackfocus, scene, tmp_path, arguments, texts):
    scene("in.exr")
    done = rackfocus("filter", *arguments, cwd=tmp_path, code=2)
    assert all(text in done.stderr for text in texts), done.stderr
    assert not (tmp_path / "o.exr").exists()


def test_depth_comes_through_a_pipe_as_an_input(rackfocus, scene, tmp_path):
    def keep(names):
        return lambda channels: [channels.pop(n) for n in set(channels) - set(names)]

    scene("colour.exr", change=keep("RGB"))
    with open(scene("depth.exr", change=keep("Z")), "rb") as file:
        rackfocus("filter", "colour.exr", "-", "-o", "o.exr", cwd=tmp_path, stdin=file)


def test_unknown_command(rackfocus):
    assert "did you mean 'rackfocus filter'?" in rackfocus("fliter", code=2).stderr
    assert "rackfocus --help" in rackfocus("xyzzyx", code=2).stderr
    assert "Usage: rackfocus COMMAND" in rackfocus(code=2).stdout
    assert "unknown option --json" in rackfocus("--json", code=2).stderr


# ---- no room -----------------------------------------------------------------------


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 64 KiB, or else a limit on the size of files."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if subprocess.run(command, capture_output=True).returncode == 0:
        yield folder, None
        subprocess.run(["umount", str(folder)], check=True)
    else:
        size = 65536
        yield folder, lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.parametrize("name", ["out.exr", "out.png"])
def test_full_disk(rackfocus, scene, small_disk, name):
    folder, limit = small_disk

    def add_noise(channels):
        noise = numpy.random.default_rng(1)
        for channel in "RGB":
            channels[channel][:] = noise.random(channels[channel].shape)

    path = scene(size=(400, 300), change=add_noise)
    arguments = ["filter", path, "-o", folder / name, "--lens-radius", "1e-9"]
    done = rackfocus(*arguments, code=1, preexec_fn=limit)
    assert f"{name}: " in done.stderr
    assert "no space left" in done.stderr.lower() or "too large" in done.stderr.lower()
    assert os.listdir(folder) == []


def test_old_file_survives_a_full_disk(rackfocus, scene, small_disk):
    folder, limit = small_disk
    old = folder / "out.exr"
    old.write_bytes(b"old")
    noise = numpy.random.default_rng(2)
    path = scene(
        size=(400, 300),
        change=lambda c: c.update(R=noise.random((300, 400)).astype(numpy.float32)),
    )
    arguments = ["filter", path, "-o", old, "--compression", "none"]
    rackfocus(*arguments, "--lens-radius", "1e-9", code=1, preexec_fn=limit)
    assert old.read_bytes() == b"old"
    assert os.listdir(folder) == ["out.exr"]


def test_full_standard_output(binary):
    with open("/dev/full", "w") as full:
        done = subprocess.run([binary, "methods"], stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert b"standard output: No space left" in done.stderr


# ---- compare -----------------------------------------------------------------------


def test_compare_sizes_differ(rackfocus, scene):
    done = rackfocus("compare", scene("a.exr"), scene("b.exr", size=(20, 20)), code=1)
    assert "a.exr: is 48 x 32, but" in done.stderr


def test_compare_nan(rackfocus, scene):
    def spoil(channels):
        channels["R"][3, 2] = numpy.nan

    done = rackfocus("compare", scene("a.exr"), scene("b.exr", change=spoil), code=1)
    assert (
        "b.exr: 1 values are NaN or infinite, the first at pixel (2, 3)" in done.stderr
    )
    options = {"data": (10, 20, 57, 51), "display": (0, 0, 99, 99)}
    paths = scene("a.exr", **options), scene("b.exr", change=spoil, **options)
    assert "first at pixel (12, 23)" in rackfocus("compare", *paths, code=1).stderr


def test_compare_wrong_usage(rackfocus, scene):
    assert "takes two pictures, not 1" in rackfocus("compare", scene(), code=2).stderr
    arguments = ["compare", "a.exr", "b.exr", "--heatmap", "h.exr"]
    assert "does not end in .png" in rackfocus(*arguments, code=2).stderr
    assert "a.exr" in rackfocus("compare", "a.exr", "b.exr", code=1).stderr


# ---- povray ------------------------------------------------------------------------


def test_povray_is_missing(rackfocus, tmp_path):
    scene = tmp_path / "scene.pov"
    scene.write_text("camera { location <0, 0, -5> look_at 0 }")
    done = rackfocus(
        "povray", scene, "-o", tmp_path / "out.exr", code=1, env={"PATH": str(tmp_path)}
    )
    assert "povray" in done.stderr and "install" in done.stderr
    assert os.listdir(tmp_path) == ["scene.pov"]


def test_plainexr_reads_what_it_writes(tmp_path):
    values = numpy.arange(6, dtype=numpy.float32).reshape(2, 3)
    path = plainexr.write(tmp_path / "a.exr", {"Y": values}, {"note": "x"})
    channels, attributes = plainexr.read(path)
    assert (channels["Y"] == values).all() and attributes["note"] == "x"
