# SPDX-License-Identifier: Apache-2.0
"""What `filter` reads and writes; the picture itself is tested with the core."""

import hashlib
import json
import struct

import numpy
import OpenImageIO
import plainexr
import pytest

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "100"]
PLAIN = ["--compression", "none", "--type", "float"]


@pytest.fixture
def filtered(rackfocus, scene, tmp_path):
    """Filters the scene; returns channels and attributes of the result."""

    def run(*arguments, path=None, **options):
        out = tmp_path / "out.exr"
        path = path or scene(**options)
        rackfocus("filter", path, "-o", out, *LENS, "--compression", "none", *arguments)
        return plainexr.read(out)

    return run


@pytest.mark.parametrize("method", ["layered", "scatter"])
def test_same_bits_for_any_number_of_threads(rackfocus, scene, tmp_path, method):
    path = scene(size=(131, 97))
    hashes = set()
    for n in (1, 2, 7):
        out = tmp_path / f"out{n}.exr"
        arguments = ["--method", method, *LENS, *PLAIN, f"-j{n}"]
        rackfocus("filter", path, "-o", out, *arguments)
        hashes.add(hashlib.sha256(out.read_bytes()).hexdigest())
    assert len(hashes) == 1


def test_blurs(filtered, scene):
    before, _ = plainexr.read(scene())
    after, _ = filtered("--type", "float")
    assert set(after) == {"R", "G", "B"}
    assert abs(after["R"] - before["R"]).max() > 0.1


def test_keeps_what_is_in_focus(filtered, scene):
    path = scene(change=lambda c: c["Z"].fill(6))
    before, _ = plainexr.read(path)
    after, _ = filtered("--type", "float", path=path)
    for name in "RGB":
        assert (after[name] == before[name]).all()


def test_half_is_the_default(filtered):
    channels, _ = filtered()
    assert all(array.dtype == numpy.float16 for array in channels.values())


def test_values_beyond_half(rackfocus, scene, tmp_path):
    path = scene(change=lambda c: c["R"].fill(1e6))
    out = tmp_path / "out.exr"
    arguments = ["filter", path, "-o", out, *LENS, "--compression", "none"]
    assert "--type float" in rackfocus(*arguments).stderr
    assert plainexr.read(out)[0]["R"].max() == 65504
    assert rackfocus(*arguments, "-q").stderr == ""
    assert rackfocus(*arguments, "--type", "float").stderr == ""


def test_windows_aspect_and_attributes_are_kept(filtered):
    attributes = {"owner": "me", "rackfocus:blades": 6, "capDate": "today"}
    options = {"data": (4, 5, 51, 36), "display": (0, 0, 59, 39), "aspect": 1.5}
    _, found = filtered(attributes=attributes, **options)
    assert found["dataWindow"] == (4, 5, 51, 36)
    assert found["displayWindow"] == (0, 0, 59, 39)
    assert found["pixelAspectRatio"] == 1.5
    for name, value in attributes.items():
        assert found[name] == value


def test_says_that_it_filtered(filtered, rackfocus, scene, tmp_path):
    _, found = filtered("--f-stop", "4", "--pass-through")
    text = found["rackfocus:filtered"]
    assert text.startswith("rackfocus ") and "--focus-distance 6" in text
    assert "--f-stop 4" in text
    out = tmp_path / "out.exr"
    assert "already filtered" in rackfocus("info", out).stdout
    assert json.loads(rackfocus("info", out, "--json").stdout)["filtered"]
    again = ["filter", out, "-o", tmp_path / "again.exr"]
    assert "was filtered before" in rackfocus(*again).stderr
    assert rackfocus(*again, "--quiet").stderr == ""


def test_alpha_is_kept(filtered):
    def add_alpha(channels):
        channels["A"] = (channels["Z"] < 5).astype(numpy.float32)
        for name in "RGB":
            channels[name] *= channels["A"]

    channels, _ = filtered("--type", "float", change=add_alpha)
    assert set(channels) == {"R", "G", "B", "A"}
    assert channels["A"].min() >= 0 and channels["A"].max() <= 1.0001
    assert ((channels["A"] > 0.1) & (channels["A"] < 0.9)).any()


def test_grey(filtered):
    def make_grey(channels):
        channels["Y"] = channels.pop("R")
        channels.pop("G"), channels.pop("B")

    grey, _ = filtered("--type", "float", change=make_grey)
    assert set(grey) == {"Y"}

    def add_alpha(channels):
        make_grey(channels)
        channels["A"] = numpy.ones_like(channels["Z"])

    both, _ = filtered("--type", "float", change=add_alpha)
    assert set(both) == {"Y", "A"}
    assert abs(both["Y"] - grey["Y"]).max() < 1e-4
    assert abs(both["A"] - 1).max() < 1e-5


def test_depth_from_a_second_file(filtered, scene, tmp_path):
    reference, _ = filtered("--type", "float")
    colour = scene("colour.exr", change=lambda c: c.pop("Z"))
    depth = scene("depth.exr", change=lambda c: [c.pop(n) for n in "RGB"])
    for arguments in ([depth], ["--depth-file", depth], ["--", depth]):
        found, _ = filtered("--type", "float", *arguments, path=colour)
        assert all((found[n] == reference[n]).all() for n in "RGB")


def test_depth_file_before_the_depth_of_the_colour(filtered, scene):
    reference, _ = filtered("--type", "float")
    colour = scene("colour.exr", change=lambda c: c["Z"].fill(6))
    depth = scene("depth.exr", change=lambda c: [c.pop(n) for n in "RGB"])
    for arguments in ([depth], ["--depth-file", depth], ["--depth-file", scene()]):
        found, _ = filtered("--type", "float", *arguments, path=colour)
        assert all((found[n] == reference[n]).all() for n in "RGB")


def test_depth_channel(filtered):
    def rename(channels):
        channels["distance"] = channels.pop("Z")
        channels["Z"] = 0 * channels["R"] + 6

    reference, _ = filtered("--type", "float")
    found, _ = filtered("--type", "float", "--depth-channel", "distance", change=rename)
    assert (found["R"] == reference["R"]).all()


def test_layer(filtered):
    def add_layer(channels):
        for name in "RGB":
            channels[f"fog.{name}"] = 0.5 * channels[name]

    found, _ = filtered("--type", "float", "--layer", "fog", change=add_layer)
    assert set(found) == {"fog.R", "fog.G", "fog.B"}


def test_pass_through(filtered, scene):
    def add_channel(channels):
        channels["id.X"] = numpy.arange(48 * 32, dtype=numpy.float32).reshape(32, 48)

    path = scene("more.exr", change=add_channel)
    before, _ = plainexr.read(path)
    after, _ = filtered("--pass-through", path=path)
    assert set(after) == {"R", "G", "B", "Z", "id.X"}
    assert (after["Z"] == before["Z"]).all() and (after["id.X"] == before["id.X"]).all()


def test_an_old_output_is_replaced(rackfocus, scene, tmp_path):
    path = scene()
    out = tmp_path / "out.exr"
    rackfocus("filter", path, "-o", out, *LENS, *PLAIN)
    made = out.read_bytes()
    out.write_bytes(b"old")
    rackfocus("filter", path, "-o", out, *LENS, *PLAIN)
    assert out.read_bytes() == made
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.exr", "passes.exr"]


def test_compression(rackfocus, scene, tmp_path):
    out = tmp_path / "out.exr"
    for name, number in (("none", 0), ("zip", 3), ("piz", 4), ("input", 0)):
        rackfocus("filter", scene(), "-o", out, *LENS, "--compression", name)
        found, _, _ = plainexr.read_header(out.read_bytes())
        assert found["compression"] == number


@pytest.mark.parametrize("name", ["dwaa", "dwab"])
def test_dwa_is_refused_before_anything_is_read(rackfocus, tmp_path, name):
    out = tmp_path / "out.exr"
    done = rackfocus("filter", "no.exr", "-o", out, "--compression", name, code=2)
    assert f"--compression: '{name}' is none of input|none|" in done.stderr
    assert "dwaa|" not in rackfocus("filter", "--help").stdout


def test_coc(rackfocus, scene, tmp_path):
    radii = tmp_path / "coc.exr"
    path = scene()
    rackfocus("filter", path, "-o", tmp_path / "o.exr", *LENS, "--output-coc", radii)
    found = plainexr.read(radii)[0]["Y"]
    depth = plainexr.read(path)[0]["Z"].astype(float)
    expected = 0.1 * 100 * (1 / 6 - 1 / depth)
    assert abs(found - expected).max() < 1e-5


def test_png_of_a_sky_without_alpha(rackfocus, scene, tmp_path):
    """Its light is in the file, and transparent."""

    def lit_sky(channels):
        channels["A"] = (channels["Z"] < 5).astype("f4")

    path, png, exr = scene(change=lit_sky), tmp_path / "o.png", tmp_path / "o.exr"
    said = rackfocus("filter", path, "-o", png, *LENS).stderr
    assert f"{png}: 8" in said and "% of the picture have light but no alpha" in said
    assert "no alpha" not in rackfocus("filter", path, "-o", exr, *LENS).stderr

    def film(channels):
        lit_sky(channels)
        for name in "RGB":
            channels[name] *= channels["A"]

    path = scene(change=film)
    assert "no alpha" not in rackfocus("filter", path, "-o", png, *LENS).stderr


@pytest.mark.parametrize("bits", [8, 16])
def test_png(rackfocus, scene, tmp_path, bits):
    out = tmp_path / "out.PNG"
    rackfocus("filter", scene(), "-o", out, *LENS, "--png-bits", bits)
    data = out.read_bytes()
    width, height, depth, colour = struct.unpack_from(">IIBB", data, 16)
    assert (width, height, depth, colour) == (48, 32, bits, 2)
    exr = tmp_path / "out.exr"
    rackfocus("filter", scene(), "-o", exr, *LENS)
    text = rackfocus("compare", out, exr).stdout
    assert float(text.split()[-2]) > (50 if bits == 8 else 60)


def test_looks_of_a_crop_are_warned_of(rackfocus, scene, tmp_path):
    """They are measured in what is there."""
    out = tmp_path / "o.exr"
    crop = scene("crop.exr", data=(3, 4, 50, 35), display=(0, 0, 99, 79))
    said = rackfocus("filter", crop, "-o", out, *LENS, "--swirl", "0.5").stderr
    assert "--swirl: is measured in the data window of" in said
    assert "48 x 32 px" in said and "100 x 80 px" in said
    assert f"oiiotool -a {crop} --croptofull" in said  # all parts of a file
    for beside in ((3, 24, 50, 55), (26, 4, 73, 35)):  # in the middle one way only
        crop = scene("crop.exr", data=beside, display=(0, 0, 99, 79))
        said = rackfocus("filter", crop, "-o", out, *LENS, "--swirl", "0.5").stderr
        assert "--swirl: is measured in the data window of" in said
    assert "window" not in rackfocus("filter", crop, "-o", out, *LENS).stderr
    box = ["--method", "box", "--swirl", "0.5"]
    assert "data window" not in rackfocus("filter", crop, "-o", out, *LENS, *box).stderr
    whole = scene()
    options = [*LENS, "--swirl", "0.5"]
    assert "window" not in rackfocus("filter", whole, "-o", out, *options).stderr


LOOKS = {
    "eyes": "--cat-eye 0.9 --cat-eye-exposure keep",
    "doors": "--barn-left 0.8 --barn-top 0.6",
    "stretched": "--astigmatism 0.8 --swirl -0.5",
    "bent": "--field-curvature 0.3",
    "split": "--split-diopter 3.5 --split-offset 0.2 --split-softness 0.3",
    "colours": "--lateral-chroma 0.02",
}


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_looks_of_a_crop_in_the_middle(rackfocus, scene, tmp_path, look):
    """They are as in the whole picture; beyond their range they are warned of."""

    def set_back(channels):
        channels["Z"][:] = 12

    # Footprints are of the tile's middle: the crop begins where a tile does.
    cut, inside = (slice(64, 192), slice(64, 256)), (slice(20, -20), slice(20, -20))
    whole = scene("whole.exr", size=(320, 256), change=set_back)
    crop, out = tmp_path / "crop.exr", tmp_path / "o.exr"
    windows = {"data": (64, 64, 255, 191), "display": (0, 0, 319, 255)}
    channels, _ = plainexr.read(whole)
    plainexr.write(crop, {n: a[cut] for n, a in channels.items()}, **windows)
    lens = ["--focus-distance", "6", "--lens-radius", "0.8", "--focal-length-px", "100"]
    lens += [*PLAIN, *look.split()]
    found = []
    for path in (whole, crop):
        assert "window" not in rackfocus("filter", path, "-o", out, *lens).stderr
        found.append(plainexr.read(out)[0]["R"].astype(float))
    off = (found[0][cut] - found[1])[inside]
    assert (off**2).mean() ** 0.5 < 4e-4  # 0.004 and more in the data window
    far = ["--split-diopter", "3.5", "--split-offset", "1.9"]
    said = rackfocus("filter", crop, "-o", out, *lens, *far).stderr
    assert "is measured in the data window" in said


def test_window_of_a_crop(rackfocus, scene, tmp_path):
    """A crop in its display window is filtered as in the whole picture."""
    lens = ["--focus-distance", "6", "--lens-radius", "0.05", "--depth", "radial"]

    def scale_back(channels):
        channels["Z"][:] = 9

    whole = scene("whole.exr", change=scale_back)
    crop = scene("crop.exr", size=(20, 10), data=(3, 4, 22, 13), display=(0, 0, 47, 31))
    channels, _ = plainexr.read(whole)
    cut = {n: a[4:14, 3:23] for n, a in channels.items()}
    plainexr.write(crop, cut, data=(3, 4, 22, 13), display=(0, 0, 47, 31))
    found = []
    for name, path in (("w", whole), ("c", crop)):
        radii = tmp_path / f"{name}.exr"
        out = tmp_path / "out.exr"
        rackfocus("filter", path, "-o", out, *lens, "--output-coc", radii)
        found.append(plainexr.read(radii)[0]["Y"])
    assert abs(found[0][4:14, 3:23] - found[1]).max() < 1e-5
    assert numpy.ptp(found[1]) > 1e-3


def test_orthographic(filtered):
    arguments = ["--projection", "orthographic", "--ortho-scale", "4"]
    perspective, _ = filtered("--type", "float")
    orthographic, _ = filtered("--type", "float", *arguments)
    assert abs(perspective["R"] - orthographic["R"]).max() > 0.01


def test_colours_that_are_no_numbers_are_mended(rackfocus, scene, tmp_path):
    """The command that is named does it."""

    def break_two(channels):
        channels["R"][4, 5], channels["G"][20, 30] = numpy.nan, numpy.inf

    path, out = scene(change=break_two), tmp_path / "o.exr"
    done = rackfocus("filter", path, "-o", out, *LENS, code=1)
    assert (
        "2 colour values are NaN or infinite, the first at pixel (5, 4)" in done.stderr
    )
    assert (
        f"oiiotool {path} --ch R,G,B --fixnan box3 -o colour.exr, and filter "
        f"colour.exr --depth-file {path}"
    ) in done.stderr
    buffer = OpenImageIO.ImageBuf(str(path))
    colour = OpenImageIO.ImageBufAlgo.channels(buffer, ("R", "G", "B"))
    mended = OpenImageIO.ImageBuf()
    OpenImageIO.ImageBufAlgo.fixNonFinite(mended, colour, OpenImageIO.NONFINITE_BOX3)
    mended.write(str(tmp_path / "colour.exr"))
    rackfocus("filter", tmp_path / "colour.exr", "--depth-file", path, "-o", out, *LENS)
