# SPDX-License-Identifier: Apache-2.0
"""Layers that are put over each other, and stereo pairs."""

import json
import pathlib
import struct

import numpy
import OpenImageIO
import plainexr
import pytest

LENS = {
    "rackfocus:lensRadius": 0.2,
    "rackfocus:focalLengthPx": 50.0,
    "rackfocus:focusDistance": 6.0,
}
SHARP = ["--lens-radius", "1e-9"]


@pytest.fixture
def layer(tmp_path):
    """Makes NAME.exr: a premultiplied disc of glass at distance z, alone."""

    def make(name, at, z, alpha=0.6, size=(48, 32), attributes=LENS, opaque=False):
        width, height = size
        y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
        inside = (x - at[0]) ** 2 + (y - at[1]) ** 2 < 64
        cover = numpy.where(inside, alpha, 0).astype(numpy.float32)
        channels = {
            "R": cover * (0.2 + 0.7 * (x % 4 < 2)),
            "G": cover * 0.5,
            "B": cover * y / height,
            "Z": numpy.where(inside, z, 1e10),
        }
        if not opaque:
            channels["A"] = cover
        return plainexr.write(
            tmp_path / f"{name}.exr",
            {k: v.astype(numpy.float32) for k, v in channels.items()},
            attributes,
        )

    return make


def filtered(rackfocus, path, tmp_path, *options):
    out = tmp_path / f"{pathlib.Path(path).stem}_filtered.exr"
    rackfocus("filter", path, "-o", out, "--type", "float", *options)
    return plainexr.read(out)[0]


def over(top, bottom):
    """Per channel, premultiplied, from the definition."""
    return {
        name: top[name].astype(float) + (1 - top["A"].astype(float)) * bottom[name]
        for name in bottom
        if name in "RGBA"
    }


# ---- layers --------------------------------------------------------------------------


@pytest.mark.parametrize("options", [[], SHARP, ["--method", "scatter"]])
@pytest.mark.parametrize("has_alpha", [True, False])
def test_layers_are_filtered_each_on_its_own(
    rackfocus, scene, layer, tmp_path, options, has_alpha
):
    top, middle = layer("top", (18, 14), 3), layer("middle", (28, 18), 6, 0.3)
    alpha = numpy.full((32, 48), 0.75, numpy.float32)
    bottom = scene(
        "bottom.exr", attributes=LENS,
        change=lambda c: c.update({"A": alpha} if has_alpha else {}),
    )  # fmt: skip
    out = tmp_path / "out.exr"
    rackfocus("filter", top, middle, bottom, "--over", "-o", out, "--type", "float",
              *options)  # fmt: skip
    got = plainexr.read(out)[0]
    parts = [filtered(rackfocus, p, tmp_path, *options) for p in (top, middle, bottom)]
    want = over(parts[0], over(parts[1], parts[2]))
    assert sorted(want) == sorted(got) == sorted("RGBA" if has_alpha else "RGB")
    for name, values in want.items():
        assert got[name] == pytest.approx(values, abs=1e-6)
    assert not list(tmp_path.glob("out.exr.*"))


def test_glass_in_focus_stays_sharp_before_a_blurred_ground(
    rackfocus, scene, layer, tmp_path
):
    """One picture with the depth of the glass would show what is behind it sharp."""
    wide = LENS | {"rackfocus:lensRadius": 1.0}
    top = layer("top", (24, 16), 6, attributes=wide)
    bottom = scene("bottom.exr", attributes=wide)
    out = tmp_path / "out.exr"
    rackfocus("filter", top, bottom, "--over", "-o", out, "--type", "float")
    got = plainexr.read(out)[0]["R"].astype(float)
    glass = plainexr.read(top)[0]["R"].astype(float)
    ground = filtered(rackfocus, bottom, tmp_path)["R"].astype(float)
    behind = plainexr.read(bottom)[0]["R"].astype(float)
    inside = (slice(13, 20), slice(21, 28))
    assert got[inside] == pytest.approx((glass + 0.4 * ground)[inside], abs=5e-3)
    assert numpy.abs(got - glass - 0.4 * behind)[inside].max() > 0.05


def test_the_output_is_that_of_the_last(rackfocus, scene, layer, tmp_path):
    bottom = scene("bottom.exr", attributes=LENS | {"owner": "me"})
    top = layer("top", (20, 14), 3, attributes=LENS | {"owner": "you"})
    out = tmp_path / "out.exr"
    rackfocus("filter", top, bottom, "--over", "-o", out)
    channels, attributes = plainexr.read(out)
    assert attributes["owner"] == "me"
    assert channels["R"].dtype == numpy.float16
    rackfocus("filter", top, bottom, "--over", "-o", tmp_path / "out.png")
    scores = json.loads(
        rackfocus("compare", tmp_path / "out.png", out, "--json").stdout
    )
    assert scores["tpsnr"] > 45


@pytest.mark.parametrize(
    "options, text, code",
    [
        (["--over"], "--over takes two", 2),
        (["opaque.exr", "--over"], "opaque.exr: has no alpha", 1),
        (["small.exr", "--over"], "another data window", 1),
        (["--over", "--stereo"], "do not go together", 2),
        (["top.exr", "--over", "--pass-through"], "of one picture", 2),
        (["top.exr", "--over", "--depth-file", "z.exr"], "", 2),
        (["none.exr", "--over"], "none.exr", 1),
    ],
)
def test_what_cannot_be_put_over(
    rackfocus, scene, layer, tmp_path, options, text, code
):
    scene("bottom.exr", attributes=LENS)
    layer("top", (20, 14), 3)
    layer("opaque", (20, 14), 3, opaque=True)
    layer("small", (10, 10), 3, size=(20, 20))
    files = [word for word in options if word.endswith(".exr") and word != "z.exr"]
    rest = [word for word in options if word not in files]
    done = rackfocus("filter", *files, "bottom.exr", *rest, "-o", "out.exr",
                     cwd=tmp_path, code=code)  # fmt: skip
    assert text in done.stderr
    assert not list(tmp_path.glob("out.exr*"))


# ---- stereo --------------------------------------------------------------------------


def parts_of(path):
    """View, name and channels of every part of a multi-part file."""
    parts = {}
    picture = OpenImageIO.ImageInput.open(str(path))
    i = 0
    while picture.seek_subimage(i, 0):
        spec = picture.spec()
        pixels = picture.read_image(i, 0, 0, spec.nchannels, "float")
        parts[spec.getattribute("view")] = dict(
            zip(spec.channelnames, numpy.moveaxis(pixels, -1, 0), strict=True)
        )
        i += 1
    return parts


@pytest.fixture
def pair(scene):
    """Left and right; the right one's header says another focus."""

    def shift(channels):
        for name in channels:
            channels[name] = numpy.roll(channels[name], 3, axis=1)

    return (
        scene("left.exr", attributes=LENS),
        scene("right.exr", attributes=LENS | {"rackfocus:focusDistance": 3.0},
              change=shift),
    )  # fmt: skip


@pytest.fixture
def both(pair, tmp_path):
    """The pair in one file of one part, after OpenEXR's multi-view convention."""
    left, right = (plainexr.read(path)[0] for path in pair)
    channels = left | {f"right.{name}": values for name, values in right.items()}
    attributes = LENS | {"multiView": ["left", "right"]}
    return plainexr.write(tmp_path / "both.exr", channels, attributes)


def test_the_eye_without_depth_is_named(rackfocus, both, tmp_path):
    channels = plainexr.read(both)[0]
    del channels["right.Z"]
    attributes = LENS | {"multiView": ["left", "right"]}
    path = plainexr.write(tmp_path / "one.exr", channels, attributes)
    out = tmp_path / "out.exr"
    done = rackfocus("filter", path, "--stereo", "-o", out, code=1)
    assert "one.exr: there is no depth channel of the view right;" in done.stderr
    assert not out.exists()
    done = rackfocus("filter", path, "--layer", "right", "-o", out, code=1)
    assert "one.exr: there is no depth channel;" in done.stderr


@pytest.mark.parametrize("layer", ["right.key.{}", "key.right.{}"])
def test_layers_of_the_same_eye_are_filtered(rackfocus, both, tmp_path, layer):
    """Both are flat; the other's number never comes into an eye's file."""
    channels = plainexr.read(both)[0]
    for c in "RGB":
        channels[f"key.{c}"] = numpy.full_like(channels["R"], 0.25)
        channels[layer.format(c)] = numpy.full_like(channels["R"], 0.75)
    attributes = LENS | {"multiView": ["left", "right"]}
    path = plainexr.write(tmp_path / "keys.exr", channels, attributes)
    words = ("--filter-layers", "key", "-o", tmp_path / "out_%V.exr")
    rackfocus("filter", path, "--stereo", *words)
    for view, value in (("left", 0.25), ("right", 0.75)):
        made = plainexr.read(tmp_path / f"out_{view}.exr")[0]
        keys = [name for name in made if "key" in name]
        assert len(keys) == 3 and ("right" in keys[0]) == (view == "right")
        for name in keys:
            assert abs(made[name] - value).max() < 1e-3
    name = layer.removesuffix(".{}")
    out = tmp_path / "one.exr"
    rackfocus("filter", path, "--layer", "right", "--filter-layers", name, "-o", out)


def test_one_depth_for_both_eyes_is_told(rackfocus, both, tmp_path):
    """A layer without a view may be of all of them; it fits one."""
    channels = plainexr.read(both)[0]
    channels["depth.Z"] = channels.pop("Z")
    del channels["right.Z"]
    attributes = LENS | {"multiView": ["left", "right"]}
    path = plainexr.write(tmp_path / "one.exr", channels, attributes)
    words = ("filter", path, "--stereo", "-o", tmp_path / "out.exr")
    said = rackfocus(*words).stderr
    assert said.count("\n") == 1 and "is depth.Z, which says no view, and what" in said
    assert rackfocus(*words, "--depth-channel", "depth.Z").stderr == ""


def each(rackfocus, pair, tmp_path):
    """What each gives with the focus of the left one."""
    return [filtered(rackfocus, path, tmp_path, "--focus-distance", 6) for path in pair]


@pytest.mark.parametrize("kind", ["pair", "both"])
def test_stereo_to_one_file(rackfocus, pair, both, tmp_path, kind):
    inputs = pair if kind == "pair" else [both]
    out = tmp_path / "out.exr"
    done = rackfocus("filter", *inputs, "--stereo", "-o", out, "--type", "float")
    lines = done.stdout.splitlines()
    assert [line.split(":")[0] for line in lines] == [
        f"{out}, view left",
        f"{out}, view right",
    ]
    assert all("radii" in line and "method layered" in line for line in lines)
    parts = parts_of(out)
    assert list(parts) == ["left", "right"]
    for got, want in zip(parts.values(), each(rackfocus, pair, tmp_path), strict=True):
        assert sorted(got) == ["B", "G", "R"]
        for name in "RGB":
            assert numpy.array_equal(got[name], want[name])
    assert not list(tmp_path.glob("out.exr.*"))
    # Our own reader finds both again, and stereo goes on from there.
    rackfocus("info", out)


@pytest.mark.parametrize("kind", ["pair", "both"])
@pytest.mark.parametrize("mark, names", [("%V", ("left", "right")), ("%v", "lr")])
def test_stereo_to_a_file_each(rackfocus, pair, both, tmp_path, kind, mark, names):
    inputs = pair if kind == "pair" else [both]
    rackfocus("filter", *inputs, "--stereo", "-o", tmp_path / f"out_{mark}.exr",
              "--type", "float")  # fmt: skip
    rackfocus("filter", *inputs, "--stereo", "-o", tmp_path / f"out_{mark}.png")
    for name, want in zip(names, each(rackfocus, pair, tmp_path), strict=True):
        got, attributes = plainexr.read(tmp_path / f"out_{name}.exr")
        for channel in "RGB":
            assert numpy.array_equal(got[channel], want[channel])
        assert "multiView" not in attributes
        assert (tmp_path / f"out_{name}.png").exists()


@pytest.mark.parametrize("layer", [None, "left", "right"])
def test_one_eye_says_so(rackfocus, pair, both, tmp_path, layer):
    """A file of two eyes, of which one is filtered: no silent choice, and no header that
    names views which are not there."""
    out = tmp_path / "out.exr"
    options = ["--layer", layer] if layer else []
    if layer == "right":
        options += ["--focus-distance", "6"]
    done = rackfocus("filter", both, "-o", out, "--type", "float", *options)
    want = each(rackfocus, pair, tmp_path)[layer == "right"]
    got, attributes = plainexr.read(out)
    assert sorted(got) == ["B", "G", "R"]
    assert all(numpy.array_equal(got[name], want[name]) for name in "RGB")
    assert "multiView" not in attributes and attributes["view"] == (layer or "left")
    assert ("holds the views left, right; only left" in done.stderr) is not bool(layer)
    assert layer or "--stereo" in done.stderr and "--layer" in done.stderr
    if layer:
        assert done.stderr == ""
    else:
        (tmp_path / "out.exr").unlink()
        rackfocus("filter", both, "-o", out, "--strict", code=1)
    done = rackfocus("filter", both, "-o", out, "--pass-through", *options)
    assert ("right" if layer != "right" else "left") + " without blur" in done.stderr
    assert "multiView" in plainexr.read(out)[1]


def test_stereo_of_one_view(rackfocus, both, tmp_path):
    """Said before any work, where the second eye had no layer of the first one's name."""
    arguments = ["filter", both, "--stereo", "-o", tmp_path / "out.exr"]
    done = rackfocus(*arguments, "--layer", "left", code=2)
    assert "--layer left: names one view" in done.stderr and done.stdout == ""
    assert not list(tmp_path.glob("out*"))


def test_eyes_in_windows(rackfocus, scene, tmp_path):
    """The same file where the picture is filtered strip by strip."""
    path = scene("large.exr", size=(1600, 1600), attributes=LENS)
    channels = plainexr.read(path)[0]
    channels |= {f"right.{name}": values for name, values in channels.items()}
    both = plainexr.write(
        tmp_path / "both.exr", channels, LENS | {"multiView": ["left", "right"]}
    )
    out, parts = tmp_path / "out.exr", tmp_path / "parts.exr"
    rackfocus("filter", both, "-o", out, "--layer", "right", "--quality", "preview")
    rackfocus(
        "filter", both, "-o", parts, "--layer", "right", "--quality", "preview",
        "--max-memory", "60",
    )  # fmt: skip
    assert out.read_bytes() == parts.read_bytes()
    assert plainexr.read(out)[1]["view"] == "right"


def test_names_of_views_are_kept(rackfocus, scene, tmp_path):
    paths = [scene(f"{n}.exr", attributes=LENS | {"view": n}) for n in ("main", "side")]
    out = tmp_path / "out.exr"
    rackfocus("filter", *paths, "--stereo", "-o", out)
    assert list(parts_of(out)) == ["main", "side"]


def test_half_a_pair_is_not_left_behind(rackfocus, scene, tmp_path):
    def spoil(channels):
        channels["Z"][3, 4] = numpy.nan

    left = scene("left.exr", attributes=LENS)
    right = scene("right.exr", attributes=LENS, change=spoil)
    for out in ("out.exr", "out_%V.exr"):
        done = rackfocus("filter", left, right, "--stereo", "-o", tmp_path / out,
                         code=1)  # fmt: skip
        assert "right.exr" in done.stderr
        assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize(
    "options, text, code",
    [
        (["left.exr"], "holds 0 views", 1),
        (["left.exr", "right.exr", "left.exr"], "one multi-view file or two", 2),
        (["left.exr", "right.exr", "-o", "o.png"], "%V", 2),
        (["both.exr", "--output-coc", "c.exr"], "of one picture", 2),
    ],
)
def test_wrong_stereo(rackfocus, pair, both, tmp_path, options, text, code):
    if "-o" not in options:
        options = [*options, "-o", "o.exr"]
    done = rackfocus("filter", *options, "--stereo", cwd=tmp_path, code=code)
    assert text in done.stderr


def chromaticities(*values):
    return {"chromaticities": ("chromaticities", struct.pack("<8f", *values))}


def time_code(value):
    return {"timeCode": ("timecode", struct.pack("<2I", value, 0))}


REC709 = chromaticities(0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
ACES = chromaticities(0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767)


@pytest.mark.parametrize(
    "left, right, words, is_refused_each",
    [
        ({"display": (0, 0, 59, 39)}, {}, "displayWindow 48x32 60x40 size", True),
        ({}, {"aspect": 2.0}, "pixelAspectRatio 2 1 itself", True),
        ({"display": (0, 0, 59, 39)}, {"display": (1, 0, 60, 39)},
         "displayWindow (1,0)to(60,39) (0,0)to(59,39) out_%V.exr", False),
        (REC709, ACES, "chromaticities 0.7347 0.64 out_%V.exr", False),
        ({}, ACES, "chromaticities 0.7347 Rec.709 out_%V.exr", False),
        (ACES, {}, "chromaticities 0.7347 Rec.709 out_%V.exr", False),
    ],
)  # fmt: skip
def test_eyes_that_fit_no_file(
    rackfocus, scene, tmp_path, left, right, words, is_refused_each
):
    """EXR wants these alike in all parts; no reader opens a file where they differ."""
    for name, eye in (("left", left), ("right", right)):
        options = {key: eye[key] for key in ("display", "aspect") if key in eye}
        own = {key: eye[key] for key in eye if key not in options}
        scene(f"{name}.exr", attributes=LENS | own, **options)
    for out, is_refused in (("o.exr", True), ("o_%V.exr", is_refused_each)):
        done = rackfocus("filter", "left.exr", "right.exr", "--stereo", "-o", out,
                         cwd=tmp_path, code=1 if is_refused else 0)  # fmt: skip
        if not is_refused:
            assert (tmp_path / "o_left.exr").exists()
            continue
        assert "radii" not in done.stdout  # nothing was filtered
        assert "right.exr: its" in done.stderr and "that of left.exr" in (
            done.stderr.replace("those of", "that of")
        )
        text = done.stderr.replace(" x ", "x").replace(" ", "")
        assert all(word in text for word in words.split())
        assert not list(tmp_path.glob("o*.exr"))


@pytest.mark.parametrize(
    "left, right",
    [
        (ACES | time_code(7), ACES | time_code(8)),
        (REC709, {}),
        ({}, REC709 | time_code(8)),
        (time_code(7), {}),
    ],
)
def test_one_time_code_and_one_kind_of_colours(rackfocus, scene, tmp_path, left, right):
    """The first eye's value in all, where EXR wants one."""
    scene("left.exr", attributes=LENS | left)
    scene("right.exr", attributes=LENS | right)
    rackfocus("filter", "left.exr", "right.exr", "--stereo", "-o", "o.exr",
              cwd=tmp_path)  # fmt: skip
    rackfocus("info", "o.exr", cwd=tmp_path)
    assert list(parts_of(tmp_path / "o.exr")) == ["left", "right"]
    header = (tmp_path / "o.exr").read_bytes()[:4096]
    for name in ("chromaticities", "timeCode"):
        want = left.get(name, right.get(name))
        kind, data = want or (name.lower(), b"")
        given = name.encode() + b"\0" + kind.encode() + b"\0"
        assert header.count(given) == (2 if want else 0)
        if want:
            assert header.count(given + struct.pack("<i", len(data)) + data) == 2


def test_eyes_with_other_data_windows(rackfocus, scene, tmp_path):
    """What a compositor crops to its content is in one display all the same."""
    for name, x in (("left", 0), ("right", 4)):
        scene(f"{name}.exr", attributes=LENS, data=(x, 0, x + 47, 31),
              display=(0, 0, 59, 39))  # fmt: skip
    rackfocus("filter", "left.exr", "right.exr", "--stereo", "-o", "o.exr",
              cwd=tmp_path)  # fmt: skip
    assert "at (4, 0)" in rackfocus("info", "o.exr", cwd=tmp_path).stdout


# ---- sequences -----------------------------------------------------------------------


def test_layers_of_a_sequence(rackfocus, scene, layer, tmp_path):
    for i in (1, 2):
        layer(f"top.{i:02}", (15 + 5 * i, 14), 3)
        scene(f"bottom.{i:02}.exr", attributes=LENS)
    rackfocus("filter", "top.##.exr", "bottom.##.exr", "--over", "-o", "out.##.exr",
              cwd=tmp_path)  # fmt: skip
    rackfocus("filter", "top.02.exr", "bottom.02.exr", "--over", "-o", "one.exr",
              cwd=tmp_path)  # fmt: skip
    got, want = (plainexr.read(tmp_path / n)[0] for n in ("out.02.exr", "one.exr"))
    assert all(numpy.array_equal(got[name], want[name]) for name in "RGB")
    # Finished frames are skipped, but not where the layers are put together in another
    # way.
    again = rackfocus("filter", "top.##.exr", "bottom.##.exr", "-o", "out.##.exr",
                      "--over", cwd=tmp_path)  # fmt: skip
    assert "skipped" in again.stdout + again.stderr


def test_a_sequence_of_pairs_is_of_multi_view_files(rackfocus, pair, tmp_path):
    for path in pair:
        path = pathlib.Path(path)
        path.rename(path.with_name(path.stem + ".1.exr"))
    names = ["left.#.exr", "right.#.exr"]
    rackfocus("filter", *names, "--stereo", "-o", "out.#.exr", cwd=tmp_path)
    assert list(parts_of(tmp_path / "out.1.exr")) == ["left", "right"]
    done = rackfocus("filter", *names, "--stereo", "-o", "%V.#.exr", cwd=tmp_path,
                     code=2)  # fmt: skip
    assert "%V" in done.stderr
