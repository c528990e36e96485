# SPDX-License-Identifier: Apache-2.0
"""Real files, made with OpenImageIO and by hand, read and written through exr_dump.

EXR_DUMP names the program; a build with -Db_sanitize=address,undefined makes the tests
of damaged files worth more.
"""

import os
import random
import struct
import subprocess
import zlib
from pathlib import Path

import pytest

np = pytest.importorskip("numpy")
oiio = pytest.importorskip("OpenImageIO")

DUMP = os.environ.get("EXR_DUMP") or (
    os.environ.get("RACKFOCUS_BUILD", "build") + "/tests/exr/exr_dump"
)
COMPRESSIONS = "none rle zips zip piz pxr24 b44 b44a dwaa dwab".split()
LOSSLESS = COMPRESSIONS[:5]
WIDTH, HEIGHT = 67, 45
TYPES = {"half": oiio.HALF, "float": oiio.FLOAT, "uint": oiio.UINT}


def run(*arguments, timeout=60):
    return subprocess.run(
        [DUMP, *map(str, arguments)], capture_output=True, text=True, timeout=timeout
    )


def dump(*arguments):
    result = run(*arguments)
    assert result.returncode == 0, result.stderr
    return result.stdout


def picture(seed=1, n=5):
    """Smooth colours and a depth, with some noise."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    planes = [
        np.sin(x * 0.1) * 0.5 + 0.5,
        np.cos(y * 0.07) * 0.5 + 0.5,
        x * y / (WIDTH * HEIGHT),
        np.clip(x / WIDTH * 1.2, 0, 1),
        1 + x * 0.5 + y,
    ]
    pixels = np.stack((planes * (n // 5 + 1))[:n], -1).astype("f4")
    return pixels + rng.random(pixels.shape).astype("f4") * 0.02


def spec_of(names, kind="float", compression="zip", tile=0, **attributes):
    spec = oiio.ImageSpec(WIDTH, HEIGHT, len(names), oiio.FLOAT)
    spec.channelnames = tuple(names)
    if kind == "mixed":
        spec.channelformats = ("half",) * (len(names) - 1) + ("float",)
    else:
        spec.format = TYPES[kind]
    spec["compression"] = compression
    spec.x, spec.y = -5, 7
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = 0, 0, 80, 60
    if tile:
        spec.tile_width = spec.tile_height = tile
    for name, value in attributes.items():
        spec[name] = value
    return spec


def write(path, spec, pixels):
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(pixels), output.geterror()
    output.close()


def write_parts(path, specs, pixels):
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(specs)), output.geterror()
    for i, (spec, plane) in enumerate(zip(specs, pixels, strict=True)):
        if i:
            assert output.open(str(path), spec, "AppendSubimage"), output.geterror()
        assert output.write_image(plane), output.geterror()
    output.close()


def read_reference(path, part=0, kind=oiio.FLOAT):
    """Channels by name as OpenImageIO reads them."""
    source = oiio.ImageInput.open(str(path))
    assert source, oiio.geterror()
    assert source.seek_subimage(part, 0)
    pixels = source.read_image(kind)
    assert pixels is not None, source.geterror()
    return {n: pixels[..., i] for i, n in enumerate(source.spec().channelnames)}


def spec_in(path, part=0):
    source = oiio.ImageInput.open(str(path))
    assert source and source.seek_subimage(part, 0)
    return source.spec()


def read_ours(path, folder, part=0, width=WIDTH, height=HEIGHT):
    """Channels by name as image_read reads them."""
    raw = Path(folder) / "ours.raw"
    dump("read", path, part, raw)
    names = [
        line.split()[2]
        for line in dump("info", path).splitlines()
        if line.startswith(f"channel {part} ")
    ]
    pixels = np.fromfile(raw, "f4").reshape(height, width, len(names))
    return {n: pixels[..., i] for i, n in enumerate(names)}


@pytest.mark.parametrize("tile", [0, 16, 200])
@pytest.mark.parametrize("kind", ["half", "float", "uint", "mixed"])
@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_reads(tmp_path, compression, kind, tile):
    path = tmp_path / "a.exr"
    pixels = picture()
    if kind == "uint":
        pixels = (pixels * 1000).astype("u4")
    write(path, spec_of("RGBAZ", kind, compression, tile), pixels)
    want = read_reference(path, kind=oiio.UINT if kind == "uint" else oiio.FLOAT)
    got = read_ours(path, tmp_path)
    assert sorted(got) == sorted(want)
    for name in got:
        if compression.startswith("dwa") and name in "RGB" and kind != "uint":
            # A DCT with another order of sums: sometimes one step of a half before
            # the power of 2.2, measured in 0.4 % of the samples.
            limit = 0.003 * np.abs(want[name]) + 1e-6
            assert np.all(np.abs(got[name] - want[name]) <= limit)
            assert np.mean(got[name] == want[name]) > 0.99
        else:
            assert np.array_equal(got[name], want[name].astype("f4")), name


@pytest.mark.parametrize("compression", ["dwaa", "dwab"])
def test_reads_dwa_layers(tmp_path, compression):
    """Two R G B sets, a grey, alphas, flat areas and bright values."""
    names = "R G B A a.R a.G a.B a.A m.Y Z id.R".split()
    pixels = picture(3, 11)
    pixels[:20, :40] = 0.25
    pixels[30:, 50:, :3] = 300.0
    path = tmp_path / "a.exr"
    write(path, spec_of(names, "half", compression), pixels)
    want, got = read_reference(path), read_ours(path, tmp_path)
    for name in names:
        # Above 1 the code is logarithmic: a step of a half at 300 is 0.4 %.
        limit = np.where(want[name] > 1, 0.009, 0.004) * want[name] + 1e-6
        assert np.all(np.abs(got[name] - want[name]) <= limit), name


N_SIZES = 11  # numbers at the start of a DWA chunk, 64 bit each
UNKNOWN_BYTES, AC_BYTES, DC_BYTES, RLE_BYTES, N_AC = 2, 3, 4, 5, 8


def change_dwa_chunk(path, change):
    """Rewrites the only chunk of a scan-line file: `change` gets its sizes, its rules and
    its four streams and changes them in place.
    """
    data = bytearray(path.read_bytes())
    # The offset of the chunk stands before it and points behind itself.
    start = next(
        i for i in range(8, len(data)) if data[i : i + 8] == struct.pack("<Q", i + 8)
    )
    y, n = struct.unpack_from("<ii", data, start + 8)
    chunk = bytes(data[start + 16 : start + 16 + n])
    sizes = list(struct.unpack_from(f"<{N_SIZES}Q", chunk))
    at = 8 * N_SIZES
    n_rules = struct.unpack_from("<H", chunk, at)[0]
    rules, at, streams = chunk[at : at + n_rules], at + n_rules, []
    for size in (UNKNOWN_BYTES, AC_BYTES, DC_BYTES, RLE_BYTES):
        streams.append(chunk[at : at + sizes[size]])
        at += sizes[size]
    change(sizes, streams)
    chunk = struct.pack(f"<{N_SIZES}Q", *sizes) + rules + b"".join(streams)
    data[start + 8 :] = struct.pack("<ii", y, len(chunk)) + chunk
    path.write_bytes(bytes(data))


@pytest.fixture
def dwa_file(tmp_path):
    path = tmp_path / "a.exr"
    write(path, spec_of("RGBA", "half", "dwab"), picture(n=4))
    change_dwa_chunk(path, lambda sizes, streams: None)
    assert read_ours(path, tmp_path)
    return path


@pytest.mark.parametrize("which", [UNKNOWN_BYTES, AC_BYTES, DC_BYTES, RLE_BYTES])
@pytest.mark.parametrize("more", [1, 1000, 1 << 62])
def test_dwa_streams_end_within_their_chunk(dwa_file, tmp_path, which, more):
    """zlib would read the last one all the same: it says itself where it ends."""

    def change(sizes, streams):
        sizes[which] += more

    change_dwa_chunk(dwa_file, change)
    done = run("read", dwa_file, 0, tmp_path / "out")
    assert done.returncode == 1 and "damaged" in done.stderr, done


def test_dwa_blocks_end_with_their_coefficients(dwa_file, tmp_path):
    def change(sizes, streams):
        sizes[AC_BYTES] = sizes[N_AC] = 0
        streams[1] = b""

    change_dwa_chunk(dwa_file, change)
    done = run("read", dwa_file, 0, tmp_path / "out")
    assert done.returncode == 1 and "damaged" in done.stderr, done


def test_reads_mip_map(tmp_path):
    source, path = tmp_path / "a.exr", tmp_path / "mip.exr"
    write(source, spec_of("RGBA", "float"), picture(n=4))
    buffer = oiio.ImageBuf(str(source))
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, buffer, str(path))
    width = spec_in(path).width
    height = spec_in(path).height
    got = read_ours(path, tmp_path, 0, width, height)
    want = read_reference(path)
    for name in want:
        assert np.array_equal(got[name], want[name])


@pytest.mark.parametrize("order", ["increasingY", "decreasingY"])
def test_line_order(tmp_path, order):
    path = tmp_path / "a.exr"
    spec = spec_of("RGBAZ", "float", "zip", **{"openexr:lineOrder": order})
    write(path, spec, picture())
    want, got = read_reference(path), read_ours(path, tmp_path)
    assert all(np.array_equal(want[n], got[n]) for n in want)


def test_info(tmp_path):
    path = tmp_path / "a.exr"
    write(path, spec_of("RGBAZ", "mixed", "piz", PixelAspectRatio=2.0), picture())
    lines = dump("info", path).splitlines()
    assert lines[0] == "part '' '' piz lines -5 7 61 51 0 0 79 59 2"
    assert lines[1:] == [
        "channel 0 A half 1 1",
        "channel 0 B half 1 1",
        "channel 0 G half 1 1",
        "channel 0 R half 1 1",
        "channel 0 Z float 1 1",
    ]


def multi_part(path, compression="zip", tile=0):
    """As Blender 5: a part for each pass."""
    specs, pixels = [], []
    for i, (name, channels) in enumerate(
        [
            ("ViewLayer.Combined", "RGBA"),
            ("ViewLayer.Depth", "Z"),
            ("ViewLayer.Normal", "XYZ"),
        ]
    ):
        spec = spec_of(channels, "float" if i else "half", compression, tile)
        spec["oiio:subimagename"] = name
        spec["name"] = name
        specs.append(spec)
        pixels.append(picture(i, len(channels)))
    write_parts(path, specs, pixels)


def test_multi_part(tmp_path):
    path = tmp_path / "a.exr"
    multi_part(path)
    assert dump("layer", path) == "'ViewLayer.Combined' R G B A Z\n"
    for part in range(3):
        want = read_reference(path, part)
        got = read_ours(path, tmp_path, part)
        for name in got:
            wanted = want.get(name, want.get(f"ViewLayer.Combined.{name}"))
            assert np.array_equal(got[name], wanted)


def test_views(tmp_path):
    """Multi-view as Blender 3 and 4 write it: the view after the pass."""
    path = tmp_path / "a.exr"
    names = [
        f"ViewLayer.{p}.{v}.{c}"
        for v in ("left", "right")
        for p, cs in (("Combined", "RGBA"), ("Depth", "Z"))
        for c in cs
    ]
    spec = spec_of(names, "float")
    spec.attribute("multiView", "string[2]", ("left", "right"))
    write(path, spec, picture(n=10))
    left = "ViewLayer.Combined.left"
    depth = "ViewLayer.Depth.left.Z"
    for layer in ("-", "left", "ViewLayer", "ViewLayer.left"):
        assert dump("layer", path, layer) == (
            f"'{left}' {left}.R {left}.G {left}.B {left}.A {depth}\n"
        )
    for layer in ("right", "ViewLayer.right", "Combined.right"):
        assert (
            dump("layer", path, layer).split()[1:]
            == f"{left}.R {left}.G {left}.B {left}.A {depth}".replace(
                "left", "right"
            ).split()
        )


def test_views_keep_their_own_depth(tmp_path):
    """In one part the first view has no prefix, so its Z is not of the second."""
    path = tmp_path / "a.exr"
    names = [*"RGBZ", *(f"right.{c}" for c in "RGBZ")]
    spec = spec_of(names, "float")
    spec.attribute("multiView", "string[2]", ("left", "right"))
    write(path, spec, picture(n=8))
    assert dump("view", path, "left") == "'' R G B - Z\n"
    right = "right.R right.G right.B - right.Z"
    assert dump("view", path, "right") == f"'right' {right}\n"
    assert dump("layer", path, "right") == f"'right' {right}\n"
    assert dump("layer", path, "left") == "'' R G B - Z\n"
    assert dump("views", path) == "left\nright\n"


def test_joins_views(tmp_path):
    """Read by OpenImageIO: one part per view, its pixels and attributes untouched."""
    paths, out = [tmp_path / f"{name}.exr" for name in "abc"], tmp_path / "all.exr"
    for i, path in enumerate(paths):
        kind, compression = ("half", "zip") if i < 2 else ("mixed", "piz")
        spec = spec_of("RGBZ", kind, compression)
        spec.attribute("rackfocus:focusDistance", float(i))
        spec.attribute("remark", f"the {i}th")
        write(path, spec, picture(seed=i, n=4))
    dump("join", out, *paths)
    names = [path.name.removesuffix(".exr") for path in paths]
    assert dump("views", out).split() == names
    for i, path in enumerate(paths):
        got, want = read_reference(out, i), read_reference(path)
        assert sorted(got) == sorted(want)
        assert all(np.array_equal(got[name], want[name]) for name in want)
        made = spec_in(out, i)
        assert made["view"] == made["name"] == names[i]
        assert made["remark"] == f"the {i}th"
        assert made["compression"] == ("zip" if i < 2 else "piz")
        assert float(dump("number", out, names[i], "rackfocus:focusDistance")) == i
    for name, value in (("PixelAspectRatio", 2.0), ("displayWindow", 9)):
        spec = spec_of("RGBZ")
        if name == "displayWindow":
            spec.full_width = value
        else:
            spec.attribute(name, value)
        write(tmp_path / "d.exr", spec, picture(n=4))
        failed = run("join", tmp_path / "no.exr", paths[0], tmp_path / "d.exr")
        assert failed.returncode == 1 and name[1:] in failed.stderr
        assert not (tmp_path / "no.exr").exists()
    multi_part(tmp_path / "parts.exr")
    failed = run("join", tmp_path / "no.exr", paths[0], tmp_path / "parts.exr")
    assert failed.returncode == 1
    assert "parts.exr has several parts" in failed.stderr
    assert not (tmp_path / "no.exr").exists()


@pytest.mark.parametrize("name", ["displayWindow", "pixelAspectRatio"])
def test_parts_that_differ_are_not_kept(tmp_path, name):
    """No reader but that of OpenEXRCore before 3.3 opens such a file: no second one."""
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    multi_part(path)
    data = bytearray(path.read_bytes())
    at = data.rindex(name.encode() + b"\0")
    at = data.index(b"\0", at + len(name) + 1) + 5  # behind type and size
    data[at : at + 4] = struct.pack("<i", -3) if "W" in name else struct.pack("<f", 2)
    path.write_bytes(data)
    failed = run("copy", path, copy, "pass", "half", "compression=zip")
    assert failed.returncode == 1 and name in failed.stderr
    assert not copy.exists()


@pytest.mark.parametrize("target", [c for c in COMPRESSIONS if "dwa" not in c])
@pytest.mark.parametrize("kind", ["half", "float", "mixed"])
def test_round_trip(tmp_path, target, kind):
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    write(path, spec_of("RGBAZ", kind, "zip"), picture())
    word = "half" if kind == "half" else "float"
    dump("copy", path, copy, "pass", word, f"compression={target}")
    want, got = read_reference(path), read_reference(copy)
    assert sorted(want) == sorted(got)
    assert spec_in(copy)["compression"] == target
    for name in want:
        if target in LOSSLESS:
            assert np.array_equal(want[name], got[name]), name
        else:
            assert np.allclose(want[name], got[name], rtol=0.06, atol=0.06), name


def test_chunk_that_does_not_shrink(tmp_path):
    """Noise: stored as it is by every compression, and read as such."""
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    rng = np.random.default_rng(5)
    bits = rng.integers(0, 2**31, (HEIGHT, WIDTH, 3), dtype="u4")
    pixels = (bits & 0x3FFFFFFF | 0x20000000).view("f4")
    write(path, spec_of("RGB", "float", "none"), pixels)
    for target in LOSSLESS:
        dump("copy", path, copy, "float", f"compression={target}")
        want, got = read_reference(path), read_reference(copy)
        assert all(np.array_equal(want[n], got[n]) for n in want)
        ours = read_ours(copy, tmp_path)
        assert all(np.array_equal(want[n], ours[n]) for n in want)


def test_keeps_attributes(tmp_path):
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    spec = spec_of("RGBAZ", "half", "piz", PixelAspectRatio=1.5, Software="x 1.0")
    spec["owner"] = "me"
    spec["aperture"] = 2.8
    spec["BlenderMultiChannel"] = "Blender V2.55.1 and newer"
    spec["a name of more than thirty-one characters"] = 7
    spec.attribute("worldToCamera", "matrix", tuple(range(16)))
    primaries = (0.6, 0.3, 0.2, 0.7, 0.1, 0.1, 0.3, 0.3)
    spec.attribute("chromaticities", "float[8]", primaries)
    spec.attribute("my_v2", "vec2", (1.0, 2.0))
    spec.attribute("my_v3", "vector", (1.0, 2.0, 3.0))
    spec.attribute("smpte:TimeCode", "timecode", (18356486, 4294967295))
    spec.attribute("names", "string[2]", ("a", "bc"))
    write(path, spec, picture())
    dump("copy", path, copy, "pass")
    a, b = spec_in(path), spec_in(copy)
    values = {x.name: x.value for x in b.extra_attribs}
    for attribute in a.extra_attribs:
        assert values.get(attribute.name) == attribute.value, attribute.name
    assert (b.x, b.y, b.width, b.height) == (a.x, a.y, a.width, a.height)
    assert (b.full_x, b.full_width, b.full_height) == (0, 80, 60)
    dump("copy", path, copy, "attribute")
    b = spec_in(copy)
    # The names of OpenImageIO for "owner" and "aperture".
    assert b["Copyright"] == "replaced" and b["FNumber"] == pytest.approx(2.8)
    assert b["rackfocus:blades"] == 6 and b["rackfocus:depth"] == "planar"
    assert b.channelnames == ("R", "G", "B", "A")


def attribute(name, kind, data):
    size = struct.pack("<i", len(data))
    return name.encode() + b"\0" + kind.encode() + b"\0" + size + data


def hand_made(channels, planes, extra=b"", compression=0):
    """A scan-line file without compression, from (name, type, step) and arrays."""
    width, height = 8, 6
    names = b"".join(
        n.encode() + b"\0" + struct.pack("<iBBBBii", t, 0, 0, 0, 0, s, s)
        for n, t, s in channels
    )
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01\x02\0\0\0" + b"".join(
        [
            attribute("channels", "chlist", names + b"\0"),
            attribute("compression", "compression", bytes([compression])),
            attribute("dataWindow", "box2i", box),
            attribute("displayWindow", "box2i", box),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
            extra,
            b"\0",
        ]
    )
    chunks = []
    for y in range(height):
        data = b""
        for (_, _, step), plane in zip(channels, planes, strict=True):
            data += plane[y // step].tobytes() if y % step == 0 else b""
        chunks.append(struct.pack("<ii", y, len(data)) + data)
    offset = len(header) + 8 * height
    table = b""
    for chunk in chunks:
        table += struct.pack("<Q", offset)
        offset += len(chunk)
    return header + table + b"".join(chunks)


def test_unknown_attribute_type(tmp_path):
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    extra = attribute("strange", "aTypeOfOurOwn", b"\1\2\3\0\4 bytes")
    plane = np.arange(48, dtype="f4").reshape(6, 8)
    path.write_bytes(hand_made([("Y", 2, 1)], [plane], extra))
    dump("copy", path, copy, "float")
    assert extra in copy.read_bytes()


@pytest.mark.parametrize("kind", ["bytes", "deepImageState"])
def test_types_that_openexr_does_not_write(tmp_path, kind):
    """OpenEXRCore 3.4 reads them: no picture was written, after all the work."""
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    data = {"bytes": struct.pack("<i", 2) + b"hintext", "deepImageState": b"\3"}[kind]
    extra = attribute("theirs", kind, data) + attribute("z", "string", b"after it")
    plane = np.arange(48, dtype="f4").reshape(6, 8)
    path.write_bytes(hand_made([("Y", 2, 1)], [plane], extra))
    dump("copy", path, copy, "float")
    assert attribute("z", "string", b"after it") in copy.read_bytes()
    pixels = read_reference(copy)
    assert (pixels["Y"] == plane).all()


def test_sub_sampled(tmp_path):
    """Channels of half size beside full ones: each sample fills its block, and is
    kept as it is.
    """
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    chroma = np.arange(12, dtype="f4").reshape(3, 4)
    full = np.arange(48, dtype="f4").reshape(6, 8)
    channels = [("B", 2, 1), ("BY", 2, 2), ("G", 2, 1), ("R", 2, 1), ("RY", 1, 2)]
    planes = [full, chroma, full + 100, full + 200, chroma.astype("f2")]
    path.write_bytes(hand_made(channels, planes))
    got = read_ours(path, tmp_path, 0, 8, 6)
    assert np.array_equal(got["BY"], chroma.repeat(2, 0).repeat(2, 1))
    assert np.array_equal(got["RY"], got["BY"]) and np.array_equal(got["B"], full)
    dump("copy", path, copy, "pass", "float", "compression=none")
    ours, theirs = copy.read_bytes(), path.read_bytes()
    # The same rows, behind headers that may differ in order.
    assert ours[-len(theirs) // 2 :] == theirs[-len(theirs) // 2 :]
    for compression in LOSSLESS:
        again, back = tmp_path / "c.exr", tmp_path / "d.exr"
        dump("copy", path, again, "pass", "float", f"compression={compression}")
        dump("copy", again, back, "pass", "float", "compression=none")
        assert back.read_bytes() == ours, compression


def test_luminance_and_chroma(tmp_path):
    path = tmp_path / "a.exr"
    chroma = np.zeros((3, 4), "f2")
    channels = [("BY", 1, 2), ("RY", 1, 2), ("Y", 1, 1)]
    path.write_bytes(hand_made(channels, [chroma, chroma, np.zeros((6, 8), "f2")]))
    assert run("layer", path).stdout.split() == ["''", "Y", "RY", "BY", "-", "-"]


@pytest.mark.parametrize("compression", ["zip", "piz", "b44", "dwaa"])
@pytest.mark.parametrize("tile", [0, 32])
def test_parts_pass_through(tmp_path, compression, tile):
    """The touched part changes, the others are the same chunks as before."""
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    multi_part(path, compression, tile)
    dump("copy", path, copy, "pass", "scale=0.5")
    before, after = read_reference(path, 0), read_reference(copy, 0)
    for name in before:
        assert np.allclose(before[name] * 0.5, after[name], rtol=0.03, atol=0.03)
    assert not np.array_equal(before[name], after[name])
    for part in (1, 2):
        a, b = read_reference(path, part), read_reference(copy, part)
        assert a.keys() == b.keys()
        assert all(np.array_equal(a[n], b[n]) for n in a)
        assert spec_in(copy, part)["compression"] == spec_in(path, part)["compression"]
        assert spec_in(copy, part).tile_width == tile


@pytest.mark.parametrize("compression", ["pxr24", "b44", "dwab"])
def test_lossy_neighbours_are_kept(tmp_path, compression):
    """Channels of the touched part are not compressed with loss a second time."""
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    names = "R G B A other.R other.G other.B Z".split()
    write(path, spec_of(names, "half", compression), picture(n=8))
    dump("copy", path, copy, "pass", "scale=0.5")
    before, after = read_ours(path, tmp_path), read_ours(copy, tmp_path)
    for name in names[4:]:
        assert np.array_equal(before[name], after[name]), name
    assert spec_in(copy)["compression"] == "zip"


def test_inherits_lossy_compression(tmp_path):
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    for compression, want in [("b44", "b44"), ("pxr24", "pxr24"), ("dwaa", "zip")]:
        write(path, spec_of("RGBA", "half", compression), picture(n=4))
        dump("copy", path, copy)
        assert spec_in(copy)["compression"] == want


def flat_and_deep():
    """Two parts of 8 x 6 px by hand: half Y, and a deep Z; no compression."""
    width, height = 8, 6
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)

    def part(name, kind, channel, pixel_type, extra=b""):
        channels = channel + b"\0" + struct.pack("<iiii", pixel_type, 0, 1, 1) + b"\0"
        return extra + b"".join(
            [
                attribute("channels", "chlist", channels),
                attribute("chunkCount", "int", struct.pack("<i", height)),
                attribute("compression", "compression", b"\0"),
                attribute("dataWindow", "box2i", box),
                attribute("displayWindow", "box2i", box),
                attribute("lineOrder", "lineOrder", b"\0"),
                attribute("name", "string", name),
                attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
                attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
                attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
                attribute("type", "string", kind),
                b"\0",
            ]
        )

    version = attribute("version", "int", struct.pack("<i", 1))
    header = struct.pack("<ii", 20000630, 2 | 0x1000 | 0x800)
    # OpenEXRCore 3.1 wants the version in flat parts too and refuses files without.
    header += part(b"flat", b"scanlineimage", b"Y", 1, version)
    header += part(b"deep", b"deepscanline", b"Z", 2, version) + b"\0"
    flat, deep = [], []
    for y in range(height):
        row = np.arange(width, dtype="f2").tobytes()
        flat.append(struct.pack("<iii", 0, y, len(row)) + row)
        counts = np.cumsum(np.arange(width) % 3, dtype="i4")
        data = np.arange(counts[-1], dtype="f4").tobytes()
        sizes = struct.pack("<iiqqq", 1, y, 4 * width, len(data), len(data))
        deep.append(sizes + counts.tobytes() + data)
    offset = len(header) + 8 * (len(flat) + len(deep))
    table = b""
    for chunk in flat + deep:
        table += struct.pack("<Q", offset)
        offset += len(chunk)
    return header + table + b"".join(flat + deep), b"".join(deep)


def test_deep_is_refused_and_passed_through(tmp_path):
    """A deep part cannot be read, but does not stop work on the others."""
    path, copy = tmp_path / "a.exr", tmp_path / "b.exr"
    data, deep_chunks = flat_and_deep()
    path.write_bytes(data)
    assert oiio.ImageInput.open(str(path)).read_native_deep_image(1, 0).samples(5) == 2
    result = run("read", path, 1, tmp_path / "raw")
    assert result.returncode == 1
    assert "holds deep samples, and here a flat picture is needed" in result.stderr
    assert_survives(result, path)
    got = read_ours(path, tmp_path, 0, 8, 6)
    assert np.array_equal(got["Y"], np.tile(np.arange(8, dtype="f4"), (6, 1)))
    dump("copy", path, copy, "pass", "scale=2")
    assert copy.read_bytes().endswith(deep_chunks)
    after = read_reference(copy)["Y"]
    assert np.array_equal(after, 2 * np.tile(np.arange(8, dtype="f4"), (6, 1)))
    assert oiio.ImageInput.open(str(copy)).read_native_deep_image(1, 0).samples(5) == 2


def sample_files(folder):
    """One file of each compression, plus tiles and parts, all small."""
    files = []
    for compression in COMPRESSIONS:
        path = folder / f"{compression}.exr"
        write(path, spec_of("RGBAZ", "mixed", compression), picture())
        files.append(path)
    path = folder / "tiles.exr"
    write(path, spec_of("RGBAZ", "half", "zip", 16), picture())
    multi_part(folder / "parts.exr")
    return files + [path, folder / "parts.exr"]


def assert_survives(result, path):
    """Either it reads, or it says in one line what is wrong with which file."""
    assert result.returncode in (0, 1), (path, result.returncode, result.stderr[-2000:])
    if result.returncode == 1:
        assert result.stderr.startswith(f"{path}: "), result.stderr
        assert len(result.stderr.splitlines()) == 1, result.stderr


def test_truncated(tmp_path):
    for source in sample_files(tmp_path):
        data = source.read_bytes()
        path = tmp_path / "cut.exr"
        for share in (0.01, 0.1, 0.3, 0.6, 0.9, 0.999):
            path.write_bytes(data[: int(len(data) * share)])
            result = run("read", path, 0, tmp_path / "raw")
            assert_survives(result, path)
            # Part 0 of several may be whole in what is left.
            assert result.returncode == 1 or source.name == "parts.exr"


def test_bit_flips(tmp_path):
    """200 files with a few bits turned, in headers and in data, all readers."""
    rng = random.Random(11)
    files = [f.read_bytes() for f in sample_files(tmp_path)]
    path = tmp_path / "flipped.exr"
    n_failed = 0
    for i in range(200):
        data = bytearray(files[i % len(files)])
        end = 700 if i % 2 else len(data)
        for _ in range(rng.choice((1, 1, 3, 20))):
            data[rng.randrange(4, end)] ^= 1 << rng.randrange(8)
        path.write_bytes(data)
        result = run("read", path, 0, tmp_path / "raw")
        assert_survives(result, path)
        n_failed += result.returncode
        assert_survives(run("copy", path, tmp_path / "copy.exr", "pass"), path)
    assert n_failed > 40


@pytest.mark.parametrize("number", [10, 13, 200])
def test_newer_compression(tmp_path, number):
    """HTJ2K and ZSTD of later OpenEXR, which the library itself takes for ZIP."""
    path = tmp_path / "new.exr"
    plane = np.zeros((6, 8), "f4")
    path.write_bytes(hand_made([("Y", 2, 1)], [plane], compression=number))
    result = run("info", path)
    assert result.returncode == 1
    assert f"its compression, number {number}, is newer" in result.stderr
    assert "write the file with zip" in result.stderr


def test_huge_header(tmp_path):
    """A small file that claims a huge picture is refused before any allocation."""
    plane = np.zeros((6, 8), "f4")
    data = hand_made([("Y", 2, 1)], [plane])
    box = struct.pack("<4i", 0, 0, 7, 5)
    path = tmp_path / "huge.exr"
    for size in ((65534, 65534), (1 << 30, 5), (7, 1 << 30)):
        path.write_bytes(data.replace(box, struct.pack("<4i", 0, 0, *size)))
        result = run("info", path)
        assert result.returncode == 1
        assert_survives(result, path)


def test_threads_agree(tmp_path):
    path = tmp_path / "a.exr"
    write(path, spec_of("RGBAZ", "mixed", "zips"), picture())
    sums = set()
    for threads in (1, 2, 8):
        dump("read", path, 0, tmp_path / "raw", threads)
        sums.add(zlib.crc32((tmp_path / "raw").read_bytes()))
    assert len(sums) == 1
