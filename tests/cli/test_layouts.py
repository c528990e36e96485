# SPDX-License-Identifier: Apache-2.0
"""One picture in many layouts: whatever a file looks like, the pixels come out the
same, bit for bit. Files by OpenImageIO; values are exact in half floats.
"""

import numpy
import plainexr
import pytest

oiio = pytest.importorskip("OpenImageIO")

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "100"]
PLAIN = ["--type", "float", "--compression", "none"]
SIZE = (40, 28)
KINDS = {"half": oiio.HALF, "float": oiio.FLOAT, "uint": oiio.UINT32}


def picture(size=SIZE):
    width, height = size
    y, x = numpy.mgrid[0:height, 0:width].astype("f4")
    near = (x - width / 2) ** 2 + (y - height / 2) ** 2 < (height / 4) ** 2
    stripes = (x // 3 + y // 5) % 2
    channels = {
        "R": numpy.where(near, 0.75, 0.25 + 0.5 * stripes),
        "G": numpy.where(near, 0.375, 0.625 * stripes),
        "B": numpy.where(near, 0.125, 0.875 - 0.5 * stripes),
        "Z": numpy.where(near, 3, 8 + numpy.floor(x) / 16),
    }
    return {name: values.astype("f4") for name, values in channels.items()}


def spec_of(channels, kind="float", tile=0, at=(0, 0), name="", **attributes):
    height, width = next(iter(channels.values())).shape
    spec = oiio.ImageSpec(width, height, len(channels), KINDS[kind])
    spec.channelnames = tuple(channels)
    spec.tile_width = spec.tile_height = tile
    spec.x, spec.y = at
    spec.full_x, spec.full_y = at
    spec.full_width, spec.full_height = width, height
    if name:
        spec["oiio:subimagename"] = name
    for key, value in attributes.items():
        spec[key] = value
    return spec


def write(path, *parts):
    """Each part is (channels, spec)."""
    file = oiio.ImageOutput.create(str(path))
    specs = tuple(spec for _, spec in parts)
    if len(parts) == 1:
        assert file.open(str(path), specs[0]), file.geterror()
    else:
        assert file.open(str(path), specs), file.geterror()
    for i, (channels, spec) in enumerate(parts):
        if i:
            assert file.open(str(path), spec, "AppendSubimage"), file.geterror()
        assert file.write_image(numpy.dstack(list(channels.values())))
    assert file.close()
    return path


@pytest.fixture
def filtered(rackfocus, tmp_path):
    """Filters a file; its colours in the order R G B, whatever their names."""

    def run(path, names="RGB", *arguments):
        out = tmp_path / "out.exr"
        rackfocus("filter", path, "-o", out, *LENS, *PLAIN, *arguments)
        found = plainexr.read(out)[0]
        return numpy.dstack([found[name] for name in names])

    return run


@pytest.fixture
def want(filtered, tmp_path):
    return filtered(plainexr.write(tmp_path / "plain.exr", picture()))


@pytest.mark.parametrize("tile", [0, 16, 13])
@pytest.mark.parametrize("kind", ["half", "float"])
@pytest.mark.parametrize("compression", ["none", "rle", "zips", "zip", "piz"])
def test_storage(filtered, want, tmp_path, compression, kind, tile):
    spec = spec_of(picture(), kind, tile, compression=compression)
    got = filtered(write(tmp_path / "a.exr", (picture(), spec)))
    assert (got == want).all()


@pytest.fixture
def compressed(tmp_path):
    """Makes a picture in that compression, tiled or not."""

    def make(compression, tile=0, name="a.exr", size=SIZE):
        channels = picture(size)
        spec = spec_of(channels, "half", tile, compression=compression)
        return write(tmp_path / name, (channels, spec))

    return make


def spec_at(path):
    return oiio.ImageInput.open(str(path)).spec()


@pytest.mark.parametrize("tile", [0, 16])
@pytest.mark.parametrize("options", [(), ("--pass-through",)])
@pytest.mark.parametrize("compression", ["dwaa", "dwab"])
def test_zip_takes_the_place_of_dwa(
    rackfocus, compressed, tmp_path, compression, options, tile
):
    path, out = compressed(compression, tile), tmp_path / "out.exr"
    rackfocus("filter", path, "-o", out, *LENS, *options)
    assert spec_at(out)["compression"] == "zip"


def test_zip_takes_the_place_of_dwa_in_windows(rackfocus, compressed, tmp_path):
    path, out = compressed("dwaa", 16, size=(701, 1603)), tmp_path / "out.exr"
    lens = (*LENS, "--sub-apertures", "1", "--max-radius", "5")
    rackfocus("filter", path, "-o", out, *lens, "--max-memory", "200")
    assert spec_at(out).tile_width > 0  # windows alone keep tiles
    assert spec_at(out)["compression"] == "zip"


def test_zip_takes_the_place_of_dwa_in_a_mean(rackfocus, compressed, tmp_path):
    paths = [compressed("dwaa", name=f"{i}.exr") for i in range(2)]
    out = tmp_path / "out.exr"
    rackfocus("accumulate", *paths, "-o", out)
    assert spec_at(out)["compression"] == "zip"


def test_kept_channels_are_not_compressed_twice(rackfocus, compressed, tmp_path):
    """Inherited b44 serves the picture alone, zip a picture beside its depth."""
    path, out = compressed("b44"), tmp_path / "out.exr"
    for options, want in (((), "b44"), (("--pass-through",), "zip")):
        rackfocus("filter", path, "-o", out, *LENS, *options)
        assert spec_at(out)["compression"] == want


NAMES = {
    "Blender": ("ViewLayer.Combined.{}", "RGB", "ViewLayer.Depth.Z"),
    "Blender, a space": ("View Layer.Combined.{}", "RGB", "View Layer.Depth.Z"),
    "rgba": ("rgba.{}", "RGB", "depth.Z"),
    "rgba, small": ("rgba.{}", "rgb", "depth.z"),
    "small": ("{}", "rgb", "z"),
    "words": ("beauty.{}", ("red", "green", "blue"), "depth.depth"),
    "Image": ("Image.{}", "RGB", "Depth.V"),
    "RenderMan": ("Ci.{}", "rgb", "z"),
    "Redshift": ("{}", "RGB", "Z.R"),
    "V-Ray": ("{}", "RGB", "VRayZDepth.R"),
    "Nuke": ("{}", "RGB", "deep.Z"),
    "Arnold": ("{}", "RGB", "depth"),
    "Unreal": ("{}", "RGB", "FinalImageMovieRenderQueue_WorldDepth.R"),
    "Corona": ("{}", "RGB", "CGeometry_ZDepth.R"),
    "a blank": ("{}", "RGB", "Z depth.X"),
    "red": ("{}", "RGB", "Depth.red"),
    "no layer": ("{}", "RGB", "linear_depth"),
    "distance": ("beauty.{}", "RGB", "beauty.Distance"),
    "Houdini": ("C.{}", "rgb", "Pz"),
    "Mitsuba": ("{}", "RGB", "aov.T"),
}


@pytest.mark.parametrize("layout", NAMES)
def test_names(filtered, want, tmp_path, layout):
    pattern, bases, depth = NAMES[layout]
    names = [pattern.format(base) for base in bases]
    channels = dict(zip([*names, depth], picture().values(), strict=True))
    path = write(tmp_path / "a.exr", (channels, spec_of(channels)))
    assert (filtered(path, names) == want).all()


def layer(name, channels, bases="RGB"):
    """The channels as those of a layer."""
    return {f"{name}.{b}": channels[c] for b, c in zip(bases, "RGB", strict=True)}


PICTURES = (
    "rgba RGB Beauty final render.main primary color C ViewLayer.Combined lit".split()
)
DATA = [
    ("crypto_object00", ("red", "green", "blue")),
    ("CryptoAsset", "RGB"),
    ("uCryptoMaterial01", "rgb"),
    ("ObjectId", "RGB"),
    ("albedo", "RGB"),
    ("VRayMtlID", "RGB"),
    ("N", "RGB"),
    ("aWorldNormal", "RGB"),
    ("P", "RGB"),
    ("a_motion_vectors", "RGB"),
    ("UV", "RGB"),
]


@pytest.mark.parametrize("name", PICTURES)
def test_data_is_no_picture(filtered, want, tmp_path, name):
    """Whatever of it stands before or behind the picture in the file's order."""
    channels = {"Z": picture()["Z"], **layer(name, picture())}
    blank = {base: 1 - picture()[base] for base in "RGB"}
    for data, bases in DATA:
        channels |= layer(data, blank, bases)
    path = plainexr.write(tmp_path / "a.exr", channels)
    got = filtered(path, [f"{name}.{base}" for base in "RGB"], "--strict")
    assert (got == want).all()


def test_data_alone_is_refused(rackfocus, filtered, want, tmp_path):
    channels = {"Z": picture()["Z"], **layer("albedo", picture())}
    path = plainexr.write(tmp_path / "a.exr", channels)
    done = rackfocus("filter", path, "-o", tmp_path / "o.exr", *LENS, code=1)
    assert "there is no picture: by their names all layers hold data (albedo)" in (
        done.stderr
    )
    assert "filter refuses   there is no picture" in rackfocus("info", path).stdout
    names = [f"albedo.{base}" for base in "RGB"]
    assert (filtered(path, names, "--layer", "albedo", "--strict") == want).all()


def test_several_pictures_are_warned_of(rackfocus, filtered, want, tmp_path):
    channels = {"Z": picture()["Z"], **layer("fill", picture())}
    channels |= layer("key", picture()) | layer("N", picture())
    path, out = plainexr.write(tmp_path / "a.exr", channels), tmp_path / "o.exr"
    said = "the picture is the first of the layers fill, key, which fit equally well"
    assert said in rackfocus("filter", path, "-o", out, *LENS).stderr
    assert said in rackfocus("info", path).stdout
    rackfocus("filter", path, "-o", out, *LENS, "--strict", code=1)
    names = [f"key.{base}" for base in "RGB"]
    assert (filtered(path, names, "--layer", "key", "--strict") == want).all()


def test_of_many_pictures_the_first_are_named(rackfocus, tmp_path):
    channels = {}
    for i in range(30):
        channels |= layer(f"light_{i:02}", picture())
    path = plainexr.write(tmp_path / "a.exr", channels)
    said = rackfocus("info", path).stdout
    assert "layers light_00, light_01, " in said
    assert ", ..., which fit equally well" in said


def test_parts_of_the_picture_are_named(rackfocus, tmp_path):
    """Where a part's name says no more than plain R G B, --layer takes it all the same."""
    parts = [(picture(), spec_of(picture(), name=name)) for name in ("rgb", "beauty")]
    path, out = write(tmp_path / "a.exr", *parts), tmp_path / "o.exr"
    done = rackfocus("filter", path, "-o", out, *LENS)
    assert "the first of the layers rgb, beauty, which" in done.stderr
    for name in ("rgb", "beauty"):
        rackfocus("filter", path, "-o", out, *LENS, "--layer", name, "--strict")


def test_an_unusual_name_must_be_the_only_one(rackfocus, tmp_path):
    """The channels of one layer are one; two layers are a question."""
    channels = picture()
    z = channels.pop("Z")
    for name in "RGBA":
        channels[f"WorldDepth.{name}"] = z
    path = plainexr.write(tmp_path / "a.exr", channels)
    facts = rackfocus("info", path).stdout
    assert "WorldDepth.R of" in facts
    channels["MatteDepth.R"] = z
    path = plainexr.write(tmp_path / "b.exr", channels)
    done = rackfocus("filter", path, "-o", tmp_path / "o.exr", *LENS, code=1)
    assert "there is no depth channel" in done.stderr
    assert "name the depth with --depth-channel" in done.stderr


def test_depth_in_alpha_is_no_alpha(filtered, want, rackfocus, tmp_path):
    """Unreal's captures of a scene have the depth there, in centimetres."""
    channels = picture()
    channels["A"] = 100 * channels.pop("Z")
    path = plainexr.write(tmp_path / "a.exr", channels)
    words = ("--depth-channel", "A", "--depth-scale", "0.01")
    assert (filtered(path, "RGB", *words) == want).all()
    assert set(plainexr.read(tmp_path / "out.exr")[0]) == set("RGB")
    assert "with alpha" not in rackfocus("info", path, *words).stdout


def colour_and_depth():
    channels = picture()
    return {n: channels[n] for n in "RGB"}, {"Z": channels["Z"]}


@pytest.mark.parametrize("order", ["colour first", "depth first", "normals first"])
@pytest.mark.parametrize("tile", [0, 16])
def test_parts(filtered, want, tmp_path, order, tile):
    """Colour in one part, depth in another."""
    colour, depth = colour_and_depth()
    normals = {name: colour["R"] for name in ("N.X", "N.Y", "N.Z")}
    parts = [
        (colour, spec_of(colour, "half", tile, name="rgb", compression="piz")),
        (depth, spec_of(depth, "float", tile, name="depth", compression="zips")),
        (normals, spec_of(normals, "half", tile, name="normals")),
    ]
    first = {"colour first": 0, "depth first": 1, "normals first": 2}[order]
    path = write(tmp_path / "a.exr", *parts[first:], *parts[:first])
    assert (filtered(path) == want).all()


ALPHAS = {
    "plain": [("RGB", ""), ("A", "")],
    "a layer": [("RGB", ""), ("A", "alpha.")],
    "a part": [("RGB", "rgb"), ("A", "RGBA")],
    "a part called alpha": [("RGB", "rgb"), ("A", "alpha")],
}


@pytest.mark.parametrize("where", ALPHAS)
def test_alpha_of_its_own(rackfocus, tmp_path, where):
    """It was left out in silence where it is not beside the colours."""
    channels = picture()
    channels["A"] = (channels["Z"] < 9).astype("f4")
    for base in "RGB":
        channels[base] *= channels["A"]
    plain = plainexr.write(tmp_path / "plain.exr", channels)
    path = tmp_path / "a.exr"
    layers = ALPHAS[where]
    if layers[1][1] in ("", "alpha."):
        renamed = {layers[1][1] + "A" if n == "A" else n: channels[n] for n in channels}
        write(path, (renamed, spec_of(renamed)))
    else:
        parts = [({n: channels[n] for n in names}, name) for names, name in layers]
        parts.append(({"Z": channels["Z"]}, "depth"))
        write(path, *[(some, spec_of(some, name=name)) for some, name in parts])
    got, want = tmp_path / "o.exr", tmp_path / "w.exr"
    rackfocus("filter", plain, "-o", want, *LENS, *PLAIN)
    rackfocus("filter", path, "-o", got, *LENS, *PLAIN)
    got, want = plainexr.read(got)[0], plainexr.read(want)[0]
    alpha = "alpha.A" if where == "a layer" else "A"
    for name in "RGBA":
        assert (got[alpha if name == "A" else name] == want[name]).all()
    assert "with alpha" in rackfocus("info", path).stdout


def test_an_alpha_of_another_picture_is_not_taken(rackfocus, tmp_path):
    """A part with a picture keeps its alpha, and so does a part of other pixels."""
    colour, depth = colour_and_depth()
    other = {**colour, "A": 0 * colour["R"]}
    small = {"A": numpy.zeros((4, 4), "f4")}
    for some in (other, small):
        named = [(colour, "rgb"), (some, "RGBA"), (depth, "depth")]
        parts = [(channels, spec_of(channels, name=name)) for channels, name in named]
        for _, spec in parts:
            spec.full_width, spec.full_height = SIZE
        path = write(tmp_path / "a.exr", *parts)
        assert "with alpha" not in rackfocus("info", path).stdout


def test_depth_part_with_a_larger_window(filtered, want, tmp_path):
    colour, depth = colour_and_depth()
    depth["Z"] = numpy.pad(depth["Z"], 8, mode="edge")
    spec = spec_of(depth, name="depth", at=(-8, -8))
    spec.full_x = spec.full_y = 0
    spec.full_width, spec.full_height = SIZE
    first = (colour, spec_of(colour, name="rgb"))
    assert (filtered(write(tmp_path / "a.exr", first, (depth, spec))) == want).all()


def test_a_depth_of_another_size_is_refused(rackfocus, tmp_path):
    """A quarter of a larger one was taken, in silence."""
    colour, depth = colour_and_depth()
    small = plainexr.write(tmp_path / "a.exr", colour)
    twice = {"Z": numpy.kron(depth["Z"], numpy.ones((2, 2), numpy.float32))}
    large = plainexr.write(tmp_path / "z.exr", twice)
    out = tmp_path / "o.exr"
    done = rackfocus("filter", small, "--depth-file", large, "-o", out, *LENS, code=1)
    width, height = SIZE
    assert f"z.exr: the depth is {2 * width} x {2 * height}, but" in done.stderr
    assert "render both in one size" in done.stderr


@pytest.mark.parametrize("at", [(-10, -7), (1000, 2000)])
def test_any_origin(filtered, want, tmp_path, at):
    path = write(tmp_path / "a.exr", (picture(), spec_of(picture(), at=at)))
    assert (filtered(path) == want).all()


def test_whole_numbers(rackfocus, filtered, tmp_path):
    """32-bit integers as colour and as depth are what they are as floats."""
    channels = {n: numpy.ceil(v * 8) for n, v in picture().items()}
    whole = {n: v.astype("u4") for n, v in channels.items()}
    path = write(tmp_path / "a.exr", (whole, spec_of(whole, "uint")))
    lens = ["--focus-distance", "50", "--lens-radius", "1"]
    got = filtered(path, "RGB", *lens)
    done = rackfocus("filter", path, "-o", tmp_path / "o.exr", *LENS, *lens)
    assert (
        "a.exr: is of whole numbers (UINT), taken for light as they are" in done.stderr
    )
    assert "--mulc 65537 of 16" in done.stderr
    plain = plainexr.write(tmp_path / "b.exr", channels)
    assert (got == filtered(plain, "RGB", *lens)).all()
    assert abs(got[..., 0] - channels["R"]).max() > 0.5


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (1, 40), (40, 1), (3, 3)])
def test_few_pixels(filtered, tmp_path, size):
    """Nothing but an edge: one colour stays that colour, and all stay near theirs."""
    channels = picture(size)
    got = filtered(plainexr.write(tmp_path / "a.exr", channels))
    assert got.shape == (size[1], size[0], 3)
    assert got.min() > -0.01 and got.max() < 0.95
    grey = {n: numpy.full_like(v, 0.5) for n, v in channels.items()}
    grey["Z"] = channels["Z"]
    got = filtered(plainexr.write(tmp_path / "a.exr", grey))
    assert abs(got - 0.5).max() < 1e-4


@pytest.mark.parametrize("nothing", [0, -0.0, 1e10, 1e20, 3.4e38])
def test_many_ways_to_say_that_nothing_was_hit(filtered, tmp_path, nothing):
    found = []
    for value in (numpy.inf, nothing):
        channels = picture()
        channels["Z"][5:9, 5:12] = value
        found.append(filtered(plainexr.write(tmp_path / "a.exr", channels)))
    assert (found[0] == found[1]).all()


@pytest.mark.parametrize("method", ["layered", "scatter", "lowres"])
def test_nothing_but_sky(filtered, tmp_path, method):
    """It is blurred as what is very far away."""
    found = []
    for value in (1e9, numpy.inf, 1e10):
        channels = picture()
        channels["Z"][:] = value
        path = plainexr.write(tmp_path / "a.exr", channels)
        found.append(filtered(path, "RGB", "--method", method))
    assert abs(found[0] - found[1]).max() < 1e-5
    assert (found[1] == found[2]).all()
    flat = numpy.dstack([picture()[n] for n in "RGB"])
    assert abs(found[1] - flat).max() > 0.01


def test_frames_of_a_sequence_that_show_nothing_but_sky(rackfocus, tmp_path):
    for frame, value in enumerate([5, 1e10, numpy.inf, 0]):
        channels = picture()
        channels["Z"][:] = value
        plainexr.write(tmp_path / f"a.{frame:04d}.exr", channels)
    names = [tmp_path / "a.####.exr", "-o", tmp_path / "o.####.exr"]
    done = rackfocus("filter", *names, "--frames", "0-3", *LENS, code=1)
    assert "4 frames: 3 filtered, 0 skipped, 1 failed" in done.stdout
    assert "a.0003.exr" in done.stderr and "every depth is 0" in done.stderr


def test_a_sequence_with_gaps(rackfocus, tmp_path):
    """Frames that are missing or cut off are named; the others are made."""
    for frame in (1, 2, 5, 7):
        plainexr.write(tmp_path / f"a.{frame:04d}.exr", picture())
    whole = (tmp_path / "a.0007.exr").read_bytes()
    (tmp_path / "a.0006.exr").write_bytes(whole[: len(whole) // 2])
    names = [tmp_path / "a.####.exr", "-o", tmp_path / "o.####.exr"]
    done = rackfocus("filter", *names, "--frames", "1-7", *LENS, code=1)
    failed = [line for line in done.stderr.splitlines() if "failed: frame" in line]
    assert [line.split("frame ")[1][0] for line in failed] == ["3", "4", "6"]
    assert "7 frames: 4 filtered, 0 skipped, 3 failed" in done.stdout
    made = sorted(path.name for path in tmp_path.glob("o.*.exr"))
    assert made == [f"o.{frame:04d}.exr" for frame in (1, 2, 5, 7)]
    done = rackfocus("filter", *names, "--frames", "1-2,5-7x2", *LENS)
    assert "4 frames: 0 filtered, 4 skipped, 0 failed" in done.stdout


def test_the_depth_of_another_layer(rackfocus, tmp_path):
    """Blender's view layers, of which one was rendered without Z."""
    plain = picture()
    depth = {"Back.Depth.Z": plain["Z"]}
    back = {f"Back.Combined.{c}": plain[c] for c in "RGB"}
    fore = {f"Fore.Combined.{c}": plain[c] for c in "RGB"}
    own = {"Fore.Depth.Z": plain["Z"]}
    said = "the depth is Back.Depth.Z, of another layer with a picture of its own: "
    out = ["-o", tmp_path / "o.exr", *LENS]
    for channels, layer, is_said in (
        (back | fore | depth, "Fore.Combined", True),
        (back | fore | depth, "Back.Combined", False),
        (back | fore | depth | own, "Fore.Combined", False),
        (fore | depth, "Fore.Combined", False),  # a layer of data
    ):
        path = plainexr.write(tmp_path / "in.exr", channels)
        done = rackfocus("filter", path, *out, "--layer", layer)
        assert (said + "Fore.Combined has none" in done.stderr) == is_said
    path = plainexr.write(tmp_path / "in.exr", back | fore | depth)
    meant = ["--layer", "Fore.Combined", "--depth-channel", "Back.Depth.Z"]
    assert "another layer" not in rackfocus("filter", path, *out, *meant).stderr
    told = rackfocus("info", path, "--layer", "Fore.Combined").stdout
    assert "of another layer with a picture" in told
