# SPDX-License-Identifier: Apache-2.0
"""Files that other programs made: Blender, OpenEXR's own writers, OpenImageIO."""

import pathlib

import numpy
import OpenImageIO as oiio
import plainexr
import pytest

FILES = pathlib.Path(__file__).parent / "files"
LENS = ["--lens-radius", "0.1", "--focal-length-px", "60", "--focus-distance", "6"]
PLAIN = ["--compression", "none", "--type", "float"]


def test_cryptomatte_of_blender(rackfocus, tmp_path):
    """Identifiers keep their bits, the header what names them; colour is filtered."""
    path, out = FILES / "cryptomatte.exr", tmp_path / "o.exr"
    rackfocus("filter", path, "-o", out, *LENS, *PLAIN, "--pass-through")
    (before, header), (after, kept) = plainexr.read(path), plainexr.read(out)
    names = [name for name in before if "Crypto" in name]
    assert len(names) == 8
    for name in names:
        assert before[name].tobytes() == after[name].tobytes()
    manifests = [name for name in header if name.startswith("cryptomatte/")]
    assert len(manifests) >= 4
    assert all(header[name] == kept[name] for name in manifests)
    colour = "ViewLayer.Combined.R"
    assert abs(before[colour] - after[colour]).max() > 0.05
    done = rackfocus(
        *("filter", path, "-o", out, *LENS, "--filter-layers"),
        "ViewLayer.CryptoObject00",
        code=1,
    )
    assert "holds identifiers" in done.stderr


def test_luminance_and_chroma_of_openexr(rackfocus, tmp_path):
    """The colours of make_luminance_chroma.c, through a lens that leaves them alone."""
    y, x = numpy.mgrid[0:32, 0:48]
    want = {
        "R": 0.2 + 0.6 * x / 48,
        "G": 0.2 + 0.5 * y / 32,
        "B": 0.8 - 0.5 * x / 48,
    }
    depth = plainexr.write(tmp_path / "z.exr", {"Z": numpy.full((32, 48), 6.0)})
    path, out = FILES / "luminance-chroma.exr", tmp_path / "o.exr"
    rackfocus("filter", path, depth, "-o", out, *LENS, *PLAIN)
    got, _ = plainexr.read(out)
    for name in "RGB":
        assert abs(got[name] - want[name])[2:-2, 2:-2].max() < 0.02
        assert abs(got[name] - want[name]).mean() < 0.005


@pytest.mark.parametrize("tile", [0, 16])
@pytest.mark.parametrize("window", ["cropped", "overscan"])
def test_windows_and_aspect_of_openimageio(rackfocus, tmp_path, window, tile):
    """Filtered as the same pixels in a plain file; windows and aspect are kept."""
    rng = numpy.random.default_rng(1)
    width, height = 40, 24
    pixels = rng.random((height, width, 4), dtype=numpy.float32)
    pixels[..., 3] = numpy.where(numpy.arange(width) < 20, 3, 12)
    spec = oiio.ImageSpec(width, height, 4, oiio.FLOAT)
    spec.channelnames = ("R", "G", "B", "Z")
    spec.attribute("PixelAspectRatio", 2.0)
    spec.x, spec.y = (7, 5) if window == "cropped" else (-4, -3)
    display = (0, 0, 63, 47) if window == "cropped" else (0, 0, 31, 17)
    spec.full_width, spec.full_height = display[2] + 1, display[3] + 1
    spec.tile_width = spec.tile_height = tile
    path, same = tmp_path / "a.exr", tmp_path / "same.exr"
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec) and file.write_image(pixels)
    file.close()
    data = (spec.x, spec.y, spec.x + width - 1, spec.y + height - 1)
    channels = {name: pixels[..., i] for i, name in enumerate("RGBZ")}
    plainexr.write(same, channels, data=data, display=display, aspect=2.0)
    found = []
    for source in (path, same):
        out = tmp_path / "o.exr"
        rackfocus("filter", source, "-o", out, *LENS, *PLAIN)
        found.append(plainexr.read(out))
    (a, header), (b, _) = found
    assert all((a[name] == b[name]).all() for name in "RGB")
    assert abs(a["R"] - channels["R"]).max() > 0.1
    assert header["dataWindow"] == data and header["displayWindow"] == display
    assert header["pixelAspectRatio"] == 2
