# SPDX-License-Identifier: Apache-2.0
"""filter --supersample: passes N times larger than the picture."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

REFERENCES = Path(__file__).resolve().parents[1] / "quality/references"
POSTS = REFERENCES / "posts_pinhole.exr"


def read(path):
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")
    return np.array(pixels).reshape(spec.height, spec.width, -1), spec


def write(path, pixels, names, window=(0, 0), facts=()):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "float")
    spec.channelnames = tuple(names)
    spec.x, spec.y = window
    pair = oiio.TypeDesc(oiio.FLOAT, oiio.VEC2)
    for name, value in facts:
        kind = (pair,) if isinstance(value, tuple) else ()
        spec.attribute(name, *kind, value)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(np.ascontiguousarray(pixels, np.float32))
    out.close()
    return path


def doubled(path, n=2, window=(0, 0)):
    """Posts with each pixel n x n times."""
    pixels, spec = read(POSTS)
    facts = [(f.name, f.value) for f in spec.extra_attribs if "rackfocus:" in f.name]
    facts = [
        (name, value * n if name == "rackfocus:focalLengthPx" else value)
        for name, value in facts
    ]
    big = pixels.repeat(n, 0).repeat(n, 1)
    return write(path, big, spec.channelnames, window, facts)


def test_the_picture_is_the_mean_of_the_larger_one(rackfocus, tmp_path):
    large, small = tmp_path / "large.exr", tmp_path / "small.exr"
    passes = doubled(tmp_path / "in.exr")
    rackfocus("filter", passes, "-o", large, "--type", "float")
    options = ["--supersample", 2, "--pixel-filter", "box"]
    rackfocus("filter", passes, "-o", small, "--type", "float", *options)
    whole, part = read(large)[0], read(small)
    height, width, n = part[0].shape
    mean = whole.reshape(height, 2, width, 2, n).mean((1, 3))
    assert np.allclose(part[0], mean, rtol=1e-6, atol=1e-7)
    names = [fact.name for fact in part[1].extra_attribs]
    assert "rackfocus:focalLengthPx" not in names
    assert "rackfocus:focusDistance" in names


def test_it_is_the_picture_of_the_asked_size(rackfocus, tmp_path):
    """Pixels that are twice as large, whose lens is twice as large in px."""
    once, twice = tmp_path / "once.exr", tmp_path / "twice.exr"
    rackfocus("filter", POSTS, "-o", once, "--type", "float")
    passes = doubled(tmp_path / "in.exr")
    options = ["--supersample", 2, "--pixel-filter", "box"]
    rackfocus("filter", passes, "-o", twice, "--type", "float", *options)
    done = rackfocus("compare", twice, once)
    assert float(done.stdout.split()[-2]) > 38


def test_says_what_does_not_go(rackfocus, tmp_path):
    out = tmp_path / "out.exr"
    done = rackfocus("filter", POSTS, "-o", out, "--supersample", 7, code=1)
    assert "posts_pinhole.exr" in done.stderr and "--supersample 7" in done.stderr
    options = ["--supersample", 2, "--output-coc", tmp_path / "coc.exr"]
    done = rackfocus("filter", POSTS, "-o", out, *options, code=2)
    assert "--output-coc" in done.stderr
    layers = [POSTS, POSTS, "--over", "--supersample", 2]
    assert "--over" in rackfocus("filter", *layers, "-o", out, code=2).stderr
    passes = doubled(tmp_path / "in.exr", window=(1, 0))
    done = rackfocus("filter", passes, "-o", out, "--supersample", 2, code=1)
    assert "(1, 0)" in done.stderr
    for words, said in (
        (["--pixel-filter", "gaussian"], "go with --supersample"),
        (["--pixel-filter-width", 2], "go with --supersample"),
        (
            ["--supersample", 2, "--pixel-filter", "box", "--pixel-filter-width", 2],
            "leave out --pixel-filter-width",
        ),
    ):
        assert said in rackfocus("filter", POSTS, "-o", out, *words, code=2).stderr
        words = ["finish", POSTS, POSTS, "-o", out, *words]
        assert said in rackfocus(*words, code=2).stderr
    assert not out.exists()


# ---- the renderer's pixel filter ---------------------------------------------------


def blackman_harris(x, width):
    """Cycles' pixel filter, x and width in px."""
    a = np.pi * x / width
    terms = 0.35875, 0.48829, 0.14128, 0.01168
    f = sum(term * np.cos(k * a) for k, term in enumerate(terms))
    return np.where(np.abs(x) < width, f, 0)


def gaussian(x, width):
    return np.where(np.abs(x) < 1.5 * width, np.exp(-8 * (x / width) ** 2), 0)


def edge(function, width, at):
    """Of a step from 0 to 1 at 0 that a renderer filters, in pixels at `at`."""
    x = np.linspace(-6, 6, 24001)
    f = function(x, width)
    return np.interp(at, x, np.cumsum(f) / f.sum())


@pytest.mark.parametrize(
    "n, kind, width, most",
    [
        (2, None, None, 0.015),
        (3, "blackman-harris", None, 0.015),
        (2, "blackman-harris", 2, 0.015),
        (4, "gaussian", 1.5, 0.015),
    ],
)
@pytest.mark.parametrize("is_upright", [True, False])
def test_an_edge_in_focus_is_the_renderers(
    rackfocus, tmp_path, n, kind, width, most, is_upright
):
    """Passes whose pixels have the filter come out as if it was of the asked size."""
    function, usual = (gaussian if kind == "gaussian" else blackman_harris), 1.5
    place = 10.3  # px of the asked size, so that no pixel lies on the edge
    shown = np.zeros((24 * n, 24 * n, 4), np.float32)
    at = np.arange(24 * n) + 0.5 - place * n
    shown[:, :, :3] = edge(function, width or usual, at)[None, :, None]
    shown[:, :, 3] = 2
    if not is_upright:
        shown = shown.swapaxes(0, 1)
    passes = write(tmp_path / "in.exr", shown, "RGBZ")
    words = ["--supersample", n, "--focus-distance", 2, "--lens-radius", 0.01]
    words += ["--focal-length-px", 24 * n, "--type", "float"]
    words += ["--pixel-filter", kind] if kind else []
    words += ["--pixel-filter-width", width] if width else []
    rackfocus("filter", passes, "-o", tmp_path / "out.exr", *words)
    made = read(tmp_path / "out.exr")[0][:, :, 0]
    made = made if is_upright else made.T
    right = edge(function, width or usual, np.arange(24) + 0.5 - place)
    worst = np.abs(made - right).max()
    assert worst < most


def shrunk(picture, missing):
    """By half, through a filter of so much variance, px^2 of the picture."""
    reach = np.sqrt(missing / 0.0767371)
    steps = np.arange(0.5, reach)
    steps = np.concatenate([-steps[::-1], steps])
    taps = blackman_harris(steps, reach)
    for axis in (0, 1):
        side = np.moveaxis(picture, axis, 0)
        first = np.arange(len(side) // 2) * 2 + 0.5
        at = (first[:, None] + steps).astype(int).clip(0, len(side) - 1)
        side = np.tensordot(taps / taps.sum(), side[at], (0, 1))
        picture = np.moveaxis(side, 0, axis)
    return picture


@pytest.mark.parametrize("off_px", [0, 1.5])
def test_what_views_lack_of_the_pixel_filter(rackfocus, tmp_path, off_px):
    """Views that are moved within their pixels have another filter, by their plane."""
    views = []
    for path in sorted(REFERENCES.glob("posts_view0[05].exr")):
        pixels, spec = read(path)
        facts = {f.name: f.value for f in spec.extra_attribs if "rackfocus:" in f.name}
        focus = facts["rackfocus:focusDistance"]
        scale = facts["rackfocus:lensRadius"] * facts["rackfocus:focalLengthPx"]
        facts["rackfocus:shearDistance"] = 1 / (1 / focus - off_px / scale)
        views.append(
            write(tmp_path / path.name, pixels, spec.channelnames, facts=facts.items())
        )
    large, small = tmp_path / "large.exr", tmp_path / "small.exr"
    words = ["filter", *views, "-q", "--type", "float"]
    rackfocus(*words, "-o", large)
    rackfocus(*words, "-o", small, "--supersample", 2)
    whole = 1.5**2 * 0.0767371  # of Cycles' filter
    missing = {0: 3 * whole - 1 / 8, 1.5: 4 * whole - 0.85 * (4 / 16 + 1 / 6)}
    made, picture = read(small)[0].clip(0, 1), read(large)[0].astype("f8")
    errors = {
        off: np.abs(shrunk(picture, lacks).clip(0, 1) - made).max()
        for off, lacks in missing.items()
    }
    assert errors.pop(off_px) < 1e-3 < 0.01 < errors.popitem()[1]


def test_even_light_stays_as_it_is(rackfocus, tmp_path):
    """Weights sum to one exactly, at the borders too."""
    shown = np.full((30, 42, 4), 0.7, np.float32)
    shown[:, :, 3] = 2
    passes = write(tmp_path / "in.exr", shown, "RGBZ")
    words = ["--focus-distance", 2, "--lens-radius", 0.01, "--focal-length-px", 42]
    words += ["--type", "float"]
    for n in (2, 3, 6):
        for kind in ("blackman-harris", "gaussian", "box"):
            options = ["--supersample", n, "--pixel-filter", kind]
            rackfocus("filter", passes, "-o", tmp_path / "out.exr", *words, *options)
            made = read(tmp_path / "out.exr")[0][:, :, :3]
            assert made.shape[:2] == (30 // n, 42 // n)
            assert np.abs(made - np.float32(0.7)).max() < 3e-7


def test_views_are_merged_at_their_size(rackfocus, tmp_path):
    """Each with its header's place; the result has that of none."""
    views = sorted(REFERENCES.glob("posts_view0[01].exr"))
    out = tmp_path / "out.exr"
    rackfocus("filter", *views, "-o", out, "--supersample", 2)
    pixels, spec = read(out)
    assert pixels.shape[:2] == tuple(n // 2 for n in read(views[0])[0].shape[:2])
    assert "rackfocus:lensOffset" not in [fact.name for fact in spec.extra_attribs]


def test_the_data_window_stays_in_place(rackfocus, tmp_path):
    passes = doubled(tmp_path / "in.exr", window=(-4, 8))
    out = tmp_path / "out.exr"
    rackfocus("filter", passes, "-o", out, "--supersample", 2, "--max-memory", 2000)
    spec = read(out)[1]
    assert (spec.x, spec.y) == (-2, 4)
