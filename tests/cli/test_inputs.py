# SPDX-License-Identifier: Apache-2.0
"""Files as studios have them: luminance and chroma, sub-sampled channels, depth larger
than the picture, tiles with levels, pixels that are not square, identifiers and other
layers beside the colour.
"""

import json

import numpy
import plainexr
import pytest

oiio = pytest.importorskip("OpenImageIO")

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "100"]
WEIGHTS = (0.2126, 0.7152, 0.0722)


def smooth(width=64, height=48):
    y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
    return {
        "R": 0.5 + 0.3 * numpy.sin(x / 9),
        "G": 0.4 + 0.3 * numpy.cos(y / 8),
        "B": 0.6 + 0.2 * numpy.sin((x + y) / 11),
        "Z": 4 + x / 8,
    }


def to_chroma(rgb):
    luminance = sum(w * rgb[n] for w, n in zip(WEIGHTS, "RGB", strict=True))
    return {
        "Y": luminance,
        "RY": ((rgb["R"] - luminance) / luminance)[::2, ::2],
        "BY": ((rgb["B"] - luminance) / luminance)[::2, ::2],
        "Z": rgb["Z"],
    }


@pytest.fixture
def both(rackfocus, tmp_path):
    """Filters two files in one way; returns what is in the results."""

    def run(one, other, *arguments):
        results = []
        for path in (one, other):
            out = tmp_path / "out.exr"
            plain = ["--compression", "none", "--type", "float"]
            rackfocus("filter", path, "-o", out, *LENS, *plain, *arguments)
            results.append(plainexr.read(out)[0])
        return results

    return run


def test_luminance_and_chroma(both, rackfocus, tmp_path):
    rgb = smooth()
    want = plainexr.write(tmp_path / "rgb.exr", rgb)
    steps = {"RY": 2, "BY": 2}
    path = plainexr.write(tmp_path / "yc.exr", to_chroma(rgb), steps=steps)
    a, b = both(want, path)
    assert set(b) == {"R", "G", "B"}
    for name in "RGB":
        inner = abs(a[name] - b[name])[8:-8, 8:-8]
        assert inner.max() < 0.005  # at the border OpenEXR's filter has one side
        assert abs(a[name] - b[name]).max() < 0.04
    assert rackfocus("compare", path, want).stdout.splitlines()[-1].split()[1] > "40"
    assert "Y RY BY" in rackfocus("info", path).stdout


def test_other_primaries(both, tmp_path):
    """The header's chromaticities say how much green is in Y."""
    rgb = {
        n: numpy.full((8, 8), v, "f4")
        for n, v in zip("RGBZ", (1, 2, 3, 5), strict=True)
    }
    luminance = 0.25 * 1 + 0.5 * 2 + 0.25 * 3
    chroma = {
        "Y": numpy.full((8, 8), luminance, "f4"),
        "RY": numpy.full((4, 4), (1 - luminance) / luminance, "f4"),
        "BY": numpy.full((4, 4), (3 - luminance) / luminance, "f4"),
        "Z": rgb["Z"],
    }
    path = tmp_path / "yc.exr"
    # Primaries at (1, 0.25), (0, 0.5), (-1, 0.25) have, for a white at the middle of
    # them by weight, a quarter, a half and a quarter of its Y.
    plainexr.write(path, chroma, steps={"RY": 2, "BY": 2})
    values = primaries_for((0.25, 0.5, 0.25))
    add_chromaticities(path, values)
    want = plainexr.write(tmp_path / "rgb.exr", rgb)
    a, b = both(want, path)
    for name in "RGB":
        assert abs(a[name] - b[name]).max() < 1e-3


def primaries_for(weights):
    """Rec. 709 primaries with the white that has these weights in Y."""
    xy = [(0.64, 0.33), (0.3, 0.6), (0.15, 0.06)]
    white = numpy.zeros(3)
    for w, (x, y) in zip(weights, xy, strict=True):
        white += w * numpy.array([x / y, 1, (1 - x - y) / y])
    return [v for p in xy for v in p] + list(white[:2] / white.sum())


def add_chromaticities(path, values):
    """Puts the attribute into the header of a file without compression."""
    data = open(path, "rb").read()
    packed = numpy.array(values, "<f4").tobytes()
    extra = b"chromaticities\0chromaticities\0" + (32).to_bytes(4, "little") + packed
    _, _, end = plainexr.read_header(data)
    n_rows = 8
    table = numpy.frombuffer(data, "<u8", n_rows, end) + len(extra)
    rest = data[end + 8 * n_rows :]
    open(path, "wb").write(data[: end - 1] + extra + b"\0" + table.tobytes() + rest)


def test_sub_sampled_depth(both, tmp_path):
    """A depth of half size stands for its blocks."""
    rgb = smooth()
    full = dict(rgb, Z=rgb["Z"][::2, ::2].repeat(2, 0).repeat(2, 1))
    want = plainexr.write(tmp_path / "a.exr", full)
    half = dict(rgb, Z=rgb["Z"][::2, ::2])
    path = plainexr.write(tmp_path / "b.exr", half, steps={"Z": 2})
    a, b = both(want, path)
    assert all((a[name] == b[name]).all() for name in "RGB")


def test_depth_with_overscan(both, rackfocus, scene, tmp_path):
    """Depth beyond the picture is cut off; one that ends within it is refused."""
    whole, _ = plainexr.read(scene())
    inner = {n: whole[n][4:28, 6:42] for n in "RGB"}
    window = {"data": (6, 4, 41, 27), "display": (0, 0, 47, 31)}
    colour = plainexr.write(tmp_path / "colour.exr", inner, **window)
    small = dict(inner, Z=whole["Z"][4:28, 6:42])
    want = plainexr.write(tmp_path / "want.exr", small, **window)
    large = plainexr.write(tmp_path / "z.exr", {"Z": whole["Z"]})
    outs = []
    for arguments in ([want], [colour, large]):
        out = tmp_path / "o.exr"
        plain = ["--compression", "none", "--type", "float"]
        rackfocus("filter", *arguments, "-o", out, *LENS, *plain)
        outs.append(plainexr.read(out)[0])
    assert all((outs[0][n] == outs[1][n]).all() for n in "RGB")
    cut = plainexr.write(tmp_path / "cut.exr", {"Z": whole["Z"][:20]})
    done = rackfocus("filter", colour, cut, "-o", tmp_path / "o.exr", code=1)
    assert "render both in one size" in done.stderr


def test_a_depth_that_is_cropped_to_what_is_seen(rackfocus, scene, tmp_path):
    """As Arnold's and Redshift's autocrop and Nuke's bounding boxes make it."""
    whole = plainexr.read(scene("whole.exr"))[0]
    colour = plainexr.write(tmp_path / "colour.exr", {n: whole[n] for n in "RGB"})
    window = {"data": (6, 4, 41, 27), "display": (0, 0, 47, 31)}
    cut = plainexr.write(tmp_path / "z.exr", {"Z": whole["Z"][4:28, 6:42]}, **window)
    done = rackfocus("filter", colour, cut, "-o", tmp_path / "o.exr", code=1)
    assert "the depth is cropped to (6, 4) to (41, 27)" in done.stderr
    assert f"oiiotool {cut} --croptofull -d float -o depth.exr" in done.stderr


@pytest.mark.parametrize("compression", ["zip", "piz"])
def test_mip_map(both, tmp_path, compression):
    """Of tiles with levels the full one is the picture."""
    channels = smooth()
    path = tmp_path / "mip.exr"
    source = tmp_path / "flat.exr"
    plainexr.write(source, channels)
    texture = oiio.ImageSpec()
    texture["compression"] = compression
    image = oiio.ImageBuf(str(source))
    make = oiio.ImageBufAlgo.make_texture
    assert make(oiio.MakeTxTexture, image, str(path), texture)
    found = oiio.ImageInput.open(str(path))
    level = numpy.array(found.read_image(format="float"))
    assert level.shape[2] == 4 and level[..., 3].max() > 3
    channels = dict(
        zip(found.spec().channelnames, numpy.moveaxis(level, 2, 0), strict=True)
    )
    assert found.seek_subimage(0, 3), "no levels in the file"
    want = plainexr.write(tmp_path / "want.exr", channels)
    a, b = both(want, path)
    for name in "RGB":
        assert abs(a[name] - b[name]).max() < 1e-6


def test_pixels_that_are_not_square(both, tmp_path):
    """Half as many rows of double height: the same picture, sampled more coarsely."""
    channels = smooth(64, 64)
    tall = {n: a[::2] for n, a in channels.items()}
    want = plainexr.write(tmp_path / "a.exr", channels)
    path = plainexr.write(tmp_path / "b.exr", tall, aspect=0.5)
    a, b = both(want, path)
    for name in "RGB":
        rows = a[name].reshape(32, 2, 64).mean(1)
        assert abs(rows - b[name])[4:-4, 4:-4].mean() < 0.02


def test_identifiers_pass_through_and_are_not_blurred(rackfocus, scene, tmp_path):
    rng = numpy.random.default_rng(2)
    ids = rng.integers(0, 2**32, (32, 48), dtype=numpy.uint32).view(numpy.float32)
    ids = numpy.where(numpy.isfinite(ids), ids, 0)

    def add(channels):
        channels["CryptoObject00.R"] = ids

    path, out = scene(change=add), tmp_path / "o.exr"
    rackfocus("filter", path, "-o", out, *LENS, "--pass-through")
    kept, _ = plainexr.read(out)
    assert kept["CryptoObject00.R"].tobytes() == ids.tobytes()
    arguments = [path, "-o", out, "--filter-layers", "CryptoObject00"]
    done = rackfocus("filter", *arguments, code=1)
    assert "holds identifiers" in done.stderr
    done = rackfocus("filter", *arguments[:-1], ",", code=1)
    assert "--filter-layers: ',' names no layer" in done.stderr


def light_groups(channels):
    x = numpy.linspace(0.2, 0.9, channels["R"].shape[1], dtype="f4")
    for name in "RGB":
        channels[f"key.{name}"] = x * channels[name]
        channels[f"fill.{name}"] = channels[name] - channels[f"key.{name}"]
    channels["N.X"] = numpy.where(channels["Z"] < 5, -1, 0.5).astype("f4")
    channels["N.Y"] = numpy.where(channels["Z"] < 5, 0.25, -0.75).astype("f4")


def test_layers_are_filtered_with_the_same_weights(rackfocus, scene, tmp_path):
    """Light groups add up to a layer that is their sum and, but for its edges and
    highlights, to the beauty; normals stay within their range.
    """

    def change(channels):
        light_groups(channels)
        channels["key.R"][:3, 40:50] = 5  # a lamp at the border
        channels["both.R"] = channels["key.R"] + channels["fill.R"]

    path, out = scene(change=change), tmp_path / "o.exr"
    plain = ["--compression", "none", "--type", "float", *LENS]
    rackfocus("filter", path, "-o", out, *plain, "--filter-layers", "key,both,fill,N")
    got, _ = plainexr.read(out)
    before, _ = plainexr.read(path)
    assert set(got) == set(before) - {"Z"}
    error = abs(got["key.R"] + got["fill.R"] - got["both.R"])
    assert (error / (1 + got["both.R"])).max() < 1e-5
    for name in "GB":  # no lamps
        total = got[f"key.{name}"] + got[f"fill.{name}"]
        assert abs(total - got[name]).mean() < 0.01
        assert abs(got[f"key.{name}"] - before[f"key.{name}"]).max() > 0.05
    assert got["N.X"].min() >= -1.001 and got["N.X"].max() <= 0.501
    assert ((got["N.X"] > -0.9) & (got["N.X"] < 0.4)).any()
    share = (got["N.X"] - 0.5) / -1.5  # of the near disc, from either channel
    assert abs(share - (got["N.Y"] + 0.75)).max() < 1e-4


@pytest.mark.parametrize(
    "options",
    [
        ["--blend-gamma", 2.2],
        ["--highlight-clamp", 0.7],
        ["--highlight-gain", 3, "--highlight-threshold", 0.4],
        ["--highlight-saturation", 0.5, "--highlight-threshold", 0.4],
    ],
)
def test_layers_stay_in_linear_light_and_say_so(rackfocus, scene, tmp_path, options):
    path, out = scene(change=light_groups), tmp_path / "o.exr"
    arguments = ["filter", path, "-o", out, *LENS, "--filter-layers", "key,fill,N"]
    plain = rackfocus(*arguments)
    assert "--filter-layers" not in plain.stderr
    before, _ = plainexr.read(out)
    told = rackfocus(*arguments, *options).stderr
    assert told.count("--filter-layers: the layers are filtered in plain linear") == 1
    assert all(name in told for name in options[::2])
    after, _ = plainexr.read(out)
    assert (after["R"] != before["R"]).any()
    for name in before:
        if "." in name:
            assert after[name].tobytes() == before[name].tobytes()
    rackfocus(*arguments, *options, "--strict", code=1)
    assert "--filter-layers" not in rackfocus("filter", path, "-o", out, *LENS,
                                              *options).stderr  # fmt: skip


def test_a_lens_disperses_layers_of_colour_alone(rackfocus, scene, tmp_path):
    """A copy of the beauty has the beauty's fringes, normals and a mask have none."""

    def change(channels):
        for name in "RGB":
            channels[f"copy.{name}"] = channels[name]
        for name, value in zip("XYZ", (-1, 0.25, 0.5)):
            channels[f"N.{name}"] = numpy.where(channels["Z"] < 5, value, 1).astype(
                "f4"
            )
        channels["mask"] = (channels["Z"] < 5).astype("f4")

    def made(*options):
        path, out = scene(change=change), tmp_path / "o.exr"
        plain = ["--compression", "none", "--type", "float", *LENS]
        plain += ["--split-edges", 0, "--exact-highlights", 0]
        layers = ["--filter-layers", "copy,N,mask"]
        rackfocus("filter", path, "-o", out, *plain, *layers, *options)
        return plainexr.read(out)[0]

    without = made()
    fringed = made("--lateral-chroma", 0.05, "--axial-chroma", 1)
    for name in "N.X", "N.Y", "N.Z", "mask":
        assert fringed[name].tobytes() == without[name].tobytes()
    for name in "RB":
        fringe = abs(fringed[name] - without[name]).mean()
        assert fringe > 0.01
        assert abs(fringed[f"copy.{name}"] - fringed[name]).mean() < fringe / 10


def add_nan(channels):
    channels["light.R"] = channels["Z"] * numpy.nan


def test_layers_that_cannot_be_filtered(rackfocus, scene, tmp_path):
    path, out = scene(change=light_groups), tmp_path / "o.exr"

    def fails(text, *arguments, code=1):
        done = rackfocus("filter", path, "-o", out, *arguments, code=code)
        assert text in done.stderr
        assert not out.exists()

    fails('layer "rim" is not beside the colour', "--filter-layers", "key,rim")
    nan = scene("nan.exr", change=add_nan)
    done = rackfocus("filter", nan, "-o", out, "--filter-layers", "light", code=1)
    assert "in the layers to filter" in done.stderr
    image = ["--aperture-image", path, "--filter-layers", "key"]
    fails("leave out --aperture-image", *image, code=2)
    done = rackfocus("filter", path, "-o", "o.png", "--filter-layers", "key", code=2)
    assert "ends in .exr" in done.stderr


def test_pass_through_and_filtered_layers(rackfocus, scene, tmp_path):
    path, out = scene(change=light_groups), tmp_path / "o.exr"
    arguments = ["--filter-layers", "key", "--pass-through", "--type", "float"]
    rackfocus("filter", path, "-o", out, *LENS, *arguments, "--compression", "none")
    got, _ = plainexr.read(out)
    before, _ = plainexr.read(path)
    assert set(got) == set(before)
    for name in ("fill.R", "N.X", "Z"):
        assert (got[name] == before[name]).all()
    assert abs(got["key.R"] - before["key.R"]).max() > 0.05
    info = json.loads(rackfocus("info", out, "--json").stdout)
    assert info["filtered"] is True
