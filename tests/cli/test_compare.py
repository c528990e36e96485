# SPDX-License-Identifier: Apache-2.0
"""The figures of `compare` against formulas written here with NumPy."""

import json
import math
import pathlib
import struct
import zlib

import numpy
import plainexr
import plainpng
import pytest


REFERENCES = pathlib.Path(__file__).parents[1] / "quality/references"


def tone(image):
    return numpy.clip(image, 0, 1) ** (1 / 2.2)


def psnr(a, b):
    return -10 * math.log10(numpy.mean((a - b) ** 2))


def ssim_of_channel(a, b):
    """Wang 2004 as scikit-image has it with gaussian_weights, sigma 1.5, population
    covariance and data range 1: every window written out."""
    x = numpy.arange(11) - 5
    weights = numpy.exp(-(x**2) / (2 * 1.5**2))
    weights = numpy.outer(weights, weights)
    weights /= weights.sum()
    total, count = 0.0, 0
    for i in range(a.shape[0] - 10):
        for j in range(a.shape[1] - 10):
            p, q = a[i : i + 11, j : j + 11], b[i : i + 11, j : j + 11]
            mp, mq = (weights * p).sum(), (weights * q).sum()
            vp = (weights * p * p).sum() - mp**2
            vq = (weights * q * q).sum() - mq**2
            cov = (weights * p * q).sum() - mp * mq
            c1, c2 = 0.01**2, 0.03**2
            total += ((2 * mp * mq + c1) * (2 * cov + c2)) / (
                (mp**2 + mq**2 + c1) * (vp + vq + c2)
            )
            count += 1
    return total / count


@pytest.fixture
def pair(tmp_path):
    """Two pictures that differ by noise and a bright spot, and their files."""
    random = numpy.random.default_rng(3)
    a = random.random((40, 56, 3)).astype(numpy.float32)
    b = (a + 0.1 * random.standard_normal(a.shape)).astype(numpy.float32)
    b[12, 30, 1] = 25
    paths = []
    for name, image in (("a.exr", a), ("b.exr", b)):
        channels = {c: image[..., i] for i, c in enumerate("RGB")}
        paths.append(plainexr.write(tmp_path / name, channels))
    return a.astype(float), b.astype(float), paths


@pytest.fixture
def figures(rackfocus):
    def run(*arguments):
        return json.loads(rackfocus("compare", *arguments, "--json").stdout)

    return run


def test_figures(pair, figures):
    a, b, paths = pair
    found = figures(*paths)
    assert found["tpsnr"] == pytest.approx(psnr(tone(a), tone(b)), abs=1e-4)
    assert found["psnr"] == pytest.approx(
        psnr(numpy.clip(a, 0, 1), numpy.clip(b, 0, 1)), abs=1e-4
    )
    assert found["rmse"] == pytest.approx(numpy.sqrt(numpy.mean((a - b) ** 2)))
    assert found["energy_ratio"] == pytest.approx(a.sum() / b.sum())
    assert found["max_error"] == pytest.approx(abs(a - b).max())
    assert found["max_error_pixel"] == [30, 12]
    assert not found["identical"]


def test_ssim(pair, figures):
    a, b, paths = pair
    expected = numpy.mean(
        [ssim_of_channel(tone(a[..., c]), tone(b[..., c])) for c in range(3)]
    )
    assert 0.1 < expected < 0.95
    assert figures(*paths)["ssim"] == pytest.approx(expected, abs=1e-6)


def test_ssim_of_scikit_image(pair, figures):
    metrics = pytest.importorskip("skimage.metrics")
    a, b, paths = pair
    expected = metrics.structural_similarity(
        tone(a),
        tone(b),
        channel_axis=-1,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=1,
    )
    assert figures(*paths)["ssim"] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    "scene, expected",
    [("posts", 0.312573), ("portrait", 0.251311), ("macro", 0.396085)],
)
def test_flip_of_flip_evaluator(figures, scene, expected):
    """What the paper's own program, flip-evaluator 1.7, says at its standard 67 pixels
    per degree: evaluate(reference, pinhole, "LDR", inputsRGB=False) of clipped values.
    """
    stem = REFERENCES / scene
    found = figures(f"{stem}_pinhole.exr", f"{stem}_reference.exr")
    assert found["flip"] == pytest.approx(expected, abs=5e-6)
    again = figures(f"{stem}_reference.exr", f"{stem}_pinhole.exr")
    assert again["flip"] == pytest.approx(found["flip"], abs=1e-9)
    assert figures(f"{stem}_pinhole.exr", f"{stem}_pinhole.exr")["flip"] == 0


def test_small_pictures(scene, figures):
    """Smaller than the window of the SSIM."""
    for size in ((1, 1), (4, 40), (40, 4)):
        paths = [scene(name, size=size) for name in ("a.exr", "b.exr")]
        assert figures(*paths)["ssim"] == pytest.approx(1)


def test_text(pair, rackfocus):
    a, b, paths = pair
    lines = rackfocus("compare", *paths).stdout.splitlines()
    assert lines[-1] == f"tPSNR {psnr(tone(a), tone(b)):.2f} dB"
    assert lines[-2].startswith("maximum error ") and "pixel (30, 12)" in lines[-2]


def test_identical(scene, rackfocus, figures):
    path = scene()
    text = rackfocus("compare", path, path).stdout
    assert text.splitlines()[-1] == "tPSNR inf dB"
    found = figures(path, path)
    assert found["tpsnr"] == math.inf and found["identical"]
    assert found["ssim"] == 1 and found["energy_ratio"] == 1


def test_black_reference(scene, figures):
    black = scene("b.exr", change=lambda c: [c[n].fill(0) for n in "RGB"])
    assert figures(scene("a.exr"), black)["energy_ratio"] is None


def test_pixel_counts_from_the_display(scene, figures):
    def spot(channels):
        channels["R"][5, 6] += 9

    options = {"data": (10, 20, 57, 51), "display": (0, 0, 99, 99)}
    a, b = scene("a.exr", **options), scene("b.exr", change=spot, **options)
    assert figures(a, b)["max_error_pixel"] == [16, 25]


# ---- PNG ---------------------------------------------------------------------------


def write_png(path, image):
    """8 bit RGB or RGBA, no filters."""

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    height, width, n_channels = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    head = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[n_channels], 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )
    return path


def encode(image):
    v = numpy.clip(image, 0, 1)
    return numpy.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def test_png_against_exr(pair, figures, tmp_path):
    a, _, paths = pair
    code = numpy.round(255 * encode(a)).astype(numpy.uint8)
    png = write_png(tmp_path / "a.png", code)
    v = code / 255
    linear = numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    found = figures(png, paths[0])
    assert found["tpsnr"] == pytest.approx(psnr(tone(linear), tone(a)), abs=1e-3)
    assert found["tpsnr"] > 50
    assert figures(png, png)["identical"]


def test_png_with_alpha(pair, figures, tmp_path):
    """Its colour counts by its alpha, once."""
    a, _, _ = pair
    code = numpy.round(255 * encode(a)).astype(numpy.uint8)
    half = numpy.full(code.shape[:2] + (1,), 128, numpy.uint8)
    png = write_png(tmp_path / "half.png", numpy.concatenate([code, half], axis=2))
    v = code / 255
    linear = numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    plain = write_png(
        tmp_path / "plain.png",
        numpy.round(255 * encode(linear * 128 / 255)).astype(numpy.uint8),
    )
    assert figures(png, plain)["tpsnr"] > 45


def test_pictures_of_the_error(pair, rackfocus, tmp_path):
    a, b, paths = pair
    heat, side = tmp_path / "heat.png", tmp_path / "side.png"
    rackfocus("compare", *paths, "--heatmap", heat, "--side-by-side", side)
    hot, both = plainpng.read(heat), plainpng.read(side)
    assert hot.shape == (40, 56, 3) and both.shape == (40, 168, 3)
    assert (both[:, 112:] == hot).all()
    assert abs(both[:, :56] - 255 * encode(a)).max() <= 1
    assert abs(both[:, 56:112] - 255 * encode(b)).max() <= 1
    error = abs(tone(a) - tone(b)).max(axis=2)
    assert (hot[error >= 0.25] == 255).all() and (error >= 0.25).any()
    order = numpy.argsort(error.ravel())
    brightness = hot.reshape(-1, 3).sum(axis=1)[order]
    assert brightness[:100].mean() < brightness[-100:].mean()


def test_heatmap_of_identical_pictures_is_black(scene, rackfocus, tmp_path):
    path = scene()
    rackfocus("compare", path, path, "--heatmap", tmp_path / "heat.png")
    assert (plainpng.read(tmp_path / "heat.png") == 0).all()


def test_pictures_of_another_place(rackfocus, scene, tmp_path):
    """Of one size, but other parts of the picture: no pixel is that of the other."""
    facts = {"rackfocus:lensOffset": (0.1, 0.0)}
    here = scene("here.exr", attributes=facts)
    moved = scene("moved.exr", data=(-5, 3, 42, 34), display=(0, 0, 47, 31),
                  attributes=facts)  # fmt: skip
    out = tmp_path / "out.exr"
    for command in (
        ["compare", moved, here],
        ["compare-methods", here, "--reference", moved],
        ["accumulate", here, moved, "-o", out],
        ["filter", here, moved, "-o", out],
    ):
        done = rackfocus(*command, code=1)
        assert "(-5, 3) to (42, 34)" in done.stderr, command
        assert "(0, 0) to (47, 31)" in done.stderr
        if command[0] != "filter":
            assert "oiiotool" in done.stderr and "--origin " in done.stderr
        assert done.stdout == "" and not out.exists()
    png = tmp_path / "moved.png"
    rackfocus("filter", moved, "-o", png)
    rackfocus("compare", moved, png)


def test_what_is_no_picture_is_listed(rackfocus, scene):
    """A red alone was called a layer with R G B that the file has."""

    def red(channels):
        del channels["G"], channels["B"]

    path = scene("red.exr", change=red)
    said = rackfocus("compare", path, path, code=1).stderr
    assert f"{path}: no R G B channels; channels of the file: R, Z" in said


@pytest.mark.parametrize("turned", [False, True])
def test_a_crop_beside_the_whole(rackfocus, scene, tmp_path, turned):
    """Both may show the same: the way to compare them is named, and leads there."""
    cut = slice(3, 23), slice(5, 35)

    def crop(channels):
        for name, values in channels.items():
            channels[name] = values[cut]

    whole = scene("whole.exr")
    part = scene("part.exr", change=crop, data=(5, 3, 34, 22), display=(0, 0, 47, 31))
    pair = (whole, part) if turned else (part, whole)
    said = rackfocus("compare", *pair, code=1).stderr
    assert "pictures of one size can be compared; their display windows are" in said
    assert f": oiiotool -a {part} --croptofull -o whole.exr" in said
    other = scene("other.exr", size=(30, 20))
    assert "oiiotool" not in rackfocus("compare", other, whole, code=1).stderr


def test_other_pixel_aspects_are_named(rackfocus, scene, tmp_path):
    """Compared all the same: programs lose the aspect, and a PNG has none."""
    wide, square = scene("wide.exr", aspect=2.0), scene("square.exr")
    done = rackfocus("compare", wide, square, "--json")
    assert json.loads(done.stdout)["identical"]
    assert (
        f"warning: {wide}: its pixelAspectRatio is 2, that of {square} 1" in done.stderr
    )
    png = tmp_path / "square.png"
    rackfocus("filter", square, "-o", png, "-q")
    assert "Aspect" not in rackfocus("compare", wide, png).stderr
    assert "Aspect" not in rackfocus("compare", wide, wide).stderr
