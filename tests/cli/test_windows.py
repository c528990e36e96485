# SPDX-License-Identifier: Apache-2.0
"""Pictures larger than --max-memory: the same pixels, in windows."""

import json
import pathlib
import re
import struct
import subprocess

import numpy
import plainexr
import pytest

LENS = {
    "rackfocus:lensRadius": 0.2,
    "rackfocus:focalLengthPx": 400.0,
    "rackfocus:focusDistance": 6.0,
}
FAST = ("--sub-apertures", 1, "--type", "float")


@pytest.fixture
def large(binary, tmp_path):
    """Makes a picture with the lens that its header says, in tiles or scan lines."""
    generator = pathlib.Path(binary).parents[1] / "tests" / "bench" / "large_exr"

    def make(width, height, tile, compression, radius):
        path = tmp_path / f"large{tile}.exr"
        arguments = (path, width, height, tile, compression, radius)
        subprocess.run([generator, *map(str, arguments)], check=True)
        return path

    return make


def is_tiled(path):
    version = struct.unpack("<i", path.read_bytes()[4:8])[0]
    return bool(version & 0x200)


def largest_error(rackfocus, a, b):
    return json.loads(rackfocus("compare", a, b, "--json").stdout)["max_error"]


@pytest.mark.parametrize("tile, compression", [(64, "zip"), (0, "none"), (48, "piz")])
def test_windows_have_the_pixels_of_the_whole(
    rackfocus, large, tmp_path, tile, compression
):
    path = large(701, 1603, tile, compression, 5)
    whole, windows = tmp_path / "whole.exr", tmp_path / "windows.exr"
    blur = (*FAST, "--blades", 6)
    rackfocus("filter", path, "-o", whole, *blur)
    rackfocus("filter", path, "-o", windows, *blur, "--max-memory", 200)
    assert largest_error(rackfocus, windows, whole) == 0
    assert is_tiled(windows) == (tile > 0)
    facts = rackfocus("info", windows).stdout
    assert re.search(r"blades +6 .* header rackfocus:blades", facts)
    # A PNG is made of a whole picture, for which that memory is not enough.
    png = tmp_path / "whole.png"
    done = rackfocus("filter", path, "-o", png, *FAST, "--max-memory", 60, code=1)
    assert "--max-memory: 60 MiB are too few" in done.stderr
    assert not png.exists()


def test_windows_take_nothing_from_frames_beside(rackfocus, large, tmp_path):
    path = large(701, 1603, 0, "none", 5)
    for i in (1, 2):
        (tmp_path / f"shot.{i:04d}.exr").write_bytes(path.read_bytes())
    shot = (tmp_path / "shot.####.exr", "-o", tmp_path / "out.####.exr", *FAST)
    bounded = ("--max-memory", 200, "--frames", "1")
    done = rackfocus("filter", *shot, "--temporal", 1, *bounded, code=2)
    assert "--temporal: takes" in done.stderr
    assert "allow more by --max-memory, or leave it out" in done.stderr
    assert not list(tmp_path.glob("out.0*.exr"))
    rackfocus("filter", *shot, *bounded)


def test_too_little_memory_for_windows(rackfocus, large, tmp_path):
    path, out = large(400, 900, 32, "none", 4), tmp_path / "out.exr"
    done = rackfocus("filter", path, "-o", out, "--max-memory", 1, code=1)
    assert f"--max-memory: 1 MiB are too few to read {path}: " in done.stderr
    assert "0 x 0 px" not in done.stderr
    done = rackfocus("filter", path, "-o", out, "--max-memory", 40, code=1)
    assert "--max-memory: 40 MiB are too few" in done.stderr
    assert not out.exists()
    numbers = re.search(
        r"in windows it takes (\d+) MiB, and is quick with (\d+)", done.stderr
    )
    for is_slow, mib in zip((True, False), numbers.groups()):
        done = rackfocus("filter", path, "-o", out, *FAST, "--max-memory", mib)
        assert ("each pixel is filtered" in done.stdout) == is_slow
    assert done.stderr == ""


def test_windows_that_take_more_than_the_whole(rackfocus, large, tmp_path):
    """Their margins do, of a small picture: the least is named, and is enough."""
    path, out = large(400, 300, 32, "none", 4), tmp_path / "out.exr"
    done = rackfocus("filter", path, "-o", out, "--max-memory", 20, code=1)
    found = re.search(r"windows take no less than the whole, (\d+) MiB", done.stderr)
    rackfocus("filter", path, "-o", out, *FAST, "--max-memory", found[1])


def test_a_split_diopter_needs_the_whole_picture(rackfocus, large, tmp_path):
    path, out = large(701, 1603, 64, "zip", 5), tmp_path / "out.exr"
    split = [*FAST, "--split-diopter", 1000, "--max-memory", 200]
    done = rackfocus("filter", path, "-o", out, *split, code=2)
    assert "a split diopter needs the whole picture at once" in done.stderr
    assert "allow more by --max-memory, or leave it out" in done.stderr
    assert not out.exists()


def test_what_needs_the_whole_picture_is_named(rackfocus, large, tmp_path):
    path, out = large(701, 1603, 64, "zip", 5), tmp_path / "out.exr"
    square = {name: numpy.ones((8, 8), numpy.float32) for name in "RGB"}
    square["B"][:, :4] = 0
    aperture = plainexr.write(tmp_path / "aperture.exr", square)
    for looks, code in (
        (["--lateral-chroma", 0.01], 2),
        (["--aperture-image", aperture], 1),
    ):
        bounded = [*FAST, *looks, "--max-memory", 200]
        done = rackfocus("filter", path, "-o", out, *bounded, code=code)
        assert "whole picture at once; allow more by --max-memory" in done.stderr
        assert "axial-chroma" not in done.stderr


def test_a_grey_aperture_of_three_channels_is_grey(rackfocus, large, tmp_path):
    """As most pictures of apertures are: windows of it, and no cost of colours."""
    path = large(701, 1603, 64, "zip", 5)
    square = numpy.ones((8, 8), numpy.float32)
    square[3:5, 3:5] = 0.5
    outputs = [tmp_path / "grey.exr", tmp_path / "three.exr"]
    for names, out in zip(("Y", "RGB"), outputs, strict=True):
        aperture = plainexr.write(tmp_path / "a.exr", dict.fromkeys(names, square))
        bounded = [*FAST, "--aperture-image", aperture, "--max-memory", 200]
        rackfocus("filter", path, "-o", out, *bounded)
    assert largest_error(rackfocus, *outputs) == 0


def spoil(channels):
    """A depth multiplied by alpha, as compositors save it."""
    height, width = channels["Z"].shape
    x = numpy.arange(width) % 9
    alpha = numpy.where(x == 4, 0.5, 1) * numpy.ones((height, 1))
    channels["A"] = alpha.astype(numpy.float32)
    for name in "RGBZ":
        channels[name] = (channels[name] * alpha).astype(numpy.float32)


def mix(channels):
    """A depth that was anti-aliased."""
    z = channels["Z"]
    is_edge = z[:, 1:-1] != z[:, 2:]
    z[:, 1:-1] = numpy.where(is_edge, (z[:, :-2] + z[:, 2:]) / 2, z[:, 1:-1])


def widen(channels):
    """The depth of the nearest sample within a filter of 3 px, the colours' mean."""
    height, width = channels["Z"].shape
    y, x = numpy.mgrid[0:height, 0:width]
    share = numpy.clip((100 - numpy.hypot(x - 150, y % 300 - 150)) / 3 + 0.5, 0, 1)
    channels["Z"] = numpy.where(share > 0, 3, 12).astype("f4")
    for i, name in enumerate("RGB"):
        channels[name] = (0.1 + 0.3 * i * (1 - share) + 0.5 * share).astype("f4")


def turned(change):
    """The same, of numbers below 0."""

    def change_and_turn(channels):
        change(channels)
        channels["Z"] = -channels["Z"]

    return change_and_turn


def buffer(channels):
    """An anti-aliased z-buffer of 0.1 to 100."""
    channels["Z"] = (100 * (1 - 0.1 / channels["Z"]) / 99.9).astype("f4")
    mix(channels)


@pytest.mark.parametrize(
    "change, remark",
    [
        (buffer, "anti-aliased"),
        (spoil, "multiplied by alpha"),
        (mix, "anti-aliased"),
        (widen, "wider than what is seen"),
        (turned(mix), "anti-aliased"),
        (turned(widen), "wider than what is seen"),
    ],
)
def test_depth_is_repaired_in_windows(rackfocus, scene, tmp_path, change, remark):
    path = scene(size=(300, 1501), attributes=LENS, change=change)
    whole, windows = tmp_path / "whole.exr", tmp_path / "windows.exr"
    is_turned = plainexr.read(path)[0]["Z"].max() < 0
    options = [*FAST, "--depth-scale", -1 if is_turned else 1]
    if change is buffer:
        options += "--depth buffer --depth-near 0.1 --depth-far 100".split()
    done = rackfocus("filter", path, "-o", whole, *options)
    assert remark in done.stderr
    done = rackfocus("filter", path, "-o", windows, *options, "--max-memory", 150)
    assert remark in done.stderr
    (a, _), (b, _) = plainexr.read(windows), plainexr.read(whole)
    assert a.keys() == b.keys()
    assert all(numpy.array_equal(a[name], b[name]) for name in b)


def test_bad_depth_in_windows(rackfocus, scene, tmp_path):
    def break_depth(channels):
        channels["Z"][1207, 33] = numpy.nan

    path = scene(size=(300, 1501), attributes=LENS, change=break_depth)
    out = tmp_path / "out.exr"
    done = rackfocus("filter", path, "-o", out, "--max-memory", 150, code=1)
    assert "1 bad depth value" in done.stderr and "(33, 1207)" in done.stderr
    assert not out.exists()


def test_other_channels_are_kept_in_windows(rackfocus, large, tmp_path):
    path, out = large(500, 1400, 0, "zip", 4), tmp_path / "out.exr"
    rackfocus("filter", path, "-o", out, *FAST, "--max-memory", 150, "--pass-through")
    (kept, _), (before, _) = plainexr.read(out), plainexr.read(path)
    assert numpy.array_equal(kept["Z"], before["Z"])
    assert not numpy.array_equal(kept["R"], before["R"])


def test_windows_say_what_a_whole_picture_says(rackfocus, scene, tmp_path):
    """Values that nobody gave are named, and --strict makes errors of that."""
    path, out = scene(size=(300, 1501), attributes={}), tmp_path / "out.exr"
    words = ["filter", path, "-o", out, "--f-stop", "2", "--sub-apertures", 1]
    whole = rackfocus(*words).stderr
    assert "give --focus-distance, --focal-length" in whole
    windows = [*words, "--max-memory", 150]
    assert rackfocus(*windows).stderr == whole
    out.unlink()
    done = rackfocus(*windows, "--strict", code=1)
    assert "give --focus-distance, --focal-length" in done.stderr
    assert not list(tmp_path.glob("out.exr*"))
