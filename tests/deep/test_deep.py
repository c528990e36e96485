# SPDX-License-Identifier: Apache-2.0
"""Deep files against the physical picture of scenes whose hidden parts are known, and
against flattening them first.
"""

import functools
import json
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest
from deepscene import (
    CHANNELS,
    Camera,
    Layer,
    deep_samples,
    oiio,
    read,
    reference,
    tpsnr,
    write_deep,
)
from parts import join

FILES = pathlib.Path(__file__).parent / "files"
CAMERA = Camera(120, 80, 130, 0.22, 6)
SMALL = Camera(40, 30, 45, 0.22, 6)


def stripes(fx, fy, a, b):
    def colour(x, y):
        k = ((np.floor(x * fx) + np.floor(y * fy)) % 2)[..., None]
        return np.array(a) * (1 - k) + np.array(b) * k

    return colour


def plain(*rgb):
    return lambda x, y: np.broadcast_to(np.array(rgb, float), x.shape + (3,))


def everywhere(v):
    return lambda x, y: np.full(x.shape, float(v))


def disc(cx, cy, r, v=1.0):
    return lambda x, y: v * ((x - cx) ** 2 + (y - cy) ** 2 < r * r)


def wall(z=12):
    return Layer(z, stripes(1, 1.5, (0.05, 0.1, 0.6), (0.7, 0.6, 0.5)), everywhere(1))


def solids():
    """A disc before another that it hides in part, before a wall."""
    return [
        Layer(3, plain(0.8, 0.3, 0.1), disc(0, 0, 0.45)),
        Layer(7, stripes(6, 6, (0.1, 0.5, 0.2), (0.9, 0.9, 0.1)), disc(0.3, 0.1, 1)),
        wall(),
    ]


def fog(n):
    """Half dense from 8 to 10: as n sheets, or with n = 0 as one volume."""
    z = [8 + 2 * (i + 0.5) / n for i in range(n)] or [8]
    v = 1 - 0.5 ** (1 / max(n, 1))
    grey = plain(0.6, 0.6, 0.65)
    return [
        Layer(one, grey, disc(-0.5, 0, 1.2, v), back=10 if n == 0 else None)
        for one in z
    ]


def panes():
    """Two panes, a disc and a target in the open: alpha ends below 1."""
    return [
        Layer(2.5, plain(0.1, 0.7, 0.9), disc(-0.25, 0.1, 0.25, 0.4)),
        Layer(3, plain(0.9, 0.8, 0.2), disc(0.1, 0, 0.35, 0.5)),
        Layer(4, plain(0.8, 0.2, 0.1), disc(0.5, -0.2, 0.35)),
        Layer(14, wall().colour, disc(0, 0, 4)),
    ]


@pytest.fixture
def filtered(rackfocus, tmp_path):
    """Filters a deep file, and the flat file made of it; returns both pictures."""

    def run(path, *arguments):
        lens = [*CAMERA.options(), "--type", "float"]
        out, flat, both = (tmp_path / name for name in ("o.exr", "f.exr", "b.exr"))
        rackfocus("filter", path, "-o", out, "--flattened", flat, *lens, *arguments)
        rackfocus("filter", flat, "-o", both, *lens)
        return read(out)[0], read(both)[0], read(flat)[0]

    return run


@functools.cache
def solid_reference():
    return reference(CAMERA, solids(), n_lens=160)


def test_hidden_surfaces(filtered, tmp_path):
    layers = solids()
    want = solid_reference()
    path = write_deep(tmp_path / "a.exr", CAMERA, deep_samples(CAMERA, layers))
    deep, flat, sharp = filtered(path)
    # 41.9 and 4.0 where the border's pixels are repeated, by chance right for these checks.
    assert tpsnr(deep, want) > 40.9
    assert tpsnr(deep, want) > tpsnr(flat, want) + 3.4 > tpsnr(sharp, want) + 15
    assert np.abs(deep[..., 3] - 1).max() < 1e-5


def test_without_what_is_hidden(filtered, tmp_path):
    """A renderer that stops at the first opaque surface: edges are still better."""
    layers = solids()
    want = solid_reference()
    samples = deep_samples(CAMERA, layers, keep_hidden=False)
    path = write_deep(tmp_path / "a.exr", CAMERA, samples)
    deep, flat, _ = filtered(path)
    assert tpsnr(deep, want) > tpsnr(flat, want) + 1


def test_panes_and_volume(filtered, tmp_path):
    """Also against sheets: the fog of the reference is 24 of them."""
    want = reference(CAMERA, panes() + fog(24), n_lens=128)
    samples = deep_samples(CAMERA, panes() + fog(0))
    path = write_deep(tmp_path / "a.exr", CAMERA, samples)
    deep, flat, _ = filtered(path)
    assert tpsnr(deep, want) > 40
    assert tpsnr(deep, want) > tpsnr(flat, want) + 3
    assert np.sqrt(np.mean((deep[..., 3] - want[..., 3]) ** 2)) < 0.004
    assert want[..., 3].min() < 0.2


def test_holdout(rackfocus, tmp_path):
    """Black where it stands, without alpha, blurred as a thing would be."""
    hole = [Layer(4, plain(0, 0, 0), disc(0.4, -0.2, 0.5))]
    rest = [panes()[1], wall(14)]
    black = reference(CAMERA, rest + hole, n_lens=128)
    hole[0].colour = plain(1, 1, 1)
    share = reference(CAMERA, rest + hole, n_lens=128)[..., 0] - black[..., 0]
    files = [tmp_path / "rest.exr", tmp_path / "hole.exr", tmp_path / "out.exr"]
    write_deep(files[0], CAMERA, deep_samples(CAMERA, rest))
    write_deep(files[1], CAMERA, deep_samples(CAMERA, hole), names=CHANNELS[:5])
    lens = [*CAMERA.options(), "--type", "float"]
    rackfocus("filter", files[0], "--holdout", files[1], "-o", files[2], *lens)
    got, _ = read(files[2])
    assert tpsnr(got, black) > 40
    alpha = black[..., 3] - share
    assert np.sqrt(np.mean((got[..., 3] - alpha) ** 2)) < 0.01
    assert alpha.min() < 0.05


def lamps(value):
    """A dark wall with three lamps, a post before them."""

    def wall_colour(x, y):
        colour = np.full(x.shape + (3,), 0.08)
        for cx, cy in ((-2.5, -1.2), (0.3, 0.9), (2.4, -0.6)):
            colour[(x - cx) ** 2 + (y - cy) ** 2 < 0.15**2] = value
        return colour

    def post(x, y):
        return (np.abs(x - 0.08) < 0.12).astype(float)

    return [
        Layer(3.2, plain(0.5, 0.3, 0.1), post),
        Layer(14, wall_colour, everywhere(1)),
    ]


@pytest.mark.parametrize("value, least", [(10, 40), (100, 29)])
def test_highlights(rackfocus, tmp_path, value, least):
    """Lamps keep their light, without dark rings; things before them cut their discs.
    Exact highlights are for flat frames: here they change no bit.
    """
    camera = Camera(64, 44, 75, 0.25, 6)
    want = reference(camera, lamps(value), n_lens=320, n_pixel=4)
    path = write_deep(tmp_path / "a.exr", camera, deep_samples(camera, lamps(value), 8))
    flat, out, both = (tmp_path / name for name in ("f.exr", "o.exr", "b.exr"))
    lens = [*camera.options(), "--type", "float"]
    rackfocus("filter", path, "-o", out, "--flattened", flat, *lens)
    rackfocus("filter", flat, "-o", both, *lens)
    deep = read(out)[0]
    assert tpsnr(deep, want) > least
    assert tpsnr(deep, want) > tpsnr(read(both)[0], want) + 2
    assert deep[..., :3].sum() == pytest.approx(want[..., :3].sum(), rel=0.02)
    assert deep[..., :3].min() > 0.075  # of 0.08: 2 of 255 steps as displayed
    assert deep.max() == pytest.approx(want.max(), rel=0.2)
    rackfocus("filter", path, "-o", both, *lens, "--exact-highlights", "off")
    assert (read(both)[0] == deep).all()


def in_fog(colour):
    return [
        Layer(3, plain(0.6, 0.6, 0.6), everywhere(0.4)),
        Layer(20, colour, everywhere(1)),
    ]


def test_bright_sky_in_fog_up_to_the_border(rackfocus, tmp_path):
    samples = deep_samples(SMALL, in_fog(plain(4, 4, 4)), 1)
    path, out = write_deep(tmp_path / "a.exr", SMALL, samples), tmp_path / "o.exr"
    rackfocus("filter", path, "-o", out, *SMALL.options(), "--type", "float")
    want = 0.4 * 0.6 + 0.6 * 4
    assert np.abs(read(out)[0][..., :3] / want - 1).max() < 0.01


def test_lamp_in_fog_that_the_border_cuts(rackfocus, tmp_path):
    """It is no bar of light: no more comes in than what the picture shows of it."""
    camera = Camera(60, 50, 45, 2, 6)  # 10 px of blur
    path, out, flat = (tmp_path / name for name in ("a.exr", "o.exr", "f.exr"))

    def light(lamp):
        def colour(x, y):
            row = y / 20 * camera.focal_px + camera.height / 2
            is_lit = (np.abs(x) < 3) & (np.minimum(row, camera.height - row) < 2)
            return (0.1 + lamp * is_lit)[..., None] * np.ones(3)

        write_deep(path, camera, deep_samples(camera, in_fog(colour)))
        files = [path, "-o", out, "--flattened", flat]
        rackfocus("filter", *files, *camera.options(), "--type", "float")
        return np.array([read(p)[0][..., :3].sum() for p in (out, flat)])

    blurred, shown = light(40) - light(0)
    assert 0.3 * shown < blurred < shown


def over(samples, shape):
    colour, left = np.zeros(shape + (3,)), np.ones(shape)
    for _, coverage, rgb in samples:
        colour += left[..., None] * rgb
        left = left * (1 - coverage)
    return np.dstack([colour, 1 - left])


def test_flattened_is_over(rackfocus, tmp_path):
    samples = deep_samples(SMALL, panes() + fog(5))
    path = write_deep(tmp_path / "a.exr", SMALL, samples)
    flat, out = tmp_path / "flat.exr", tmp_path / "out.exr"
    rackfocus("filter", path, "-o", out, "--flattened", flat, *SMALL.options())
    got, names = read(flat)
    assert names == ["R", "G", "B", "A", "Z"]
    samples.sort(key=lambda one: one[0].z)
    assert np.abs(got[..., :4] - over(samples, (30, 40))).max() < 1e-5
    solid = got[..., 3] > 0.5
    assert set(np.unique(got[solid][:, 4])) <= {np.float32(one[0].z) for one in samples}
    assert np.isinf(got[got[..., 3] == 0][:, 4]).all()


def test_pinhole_is_the_flat_picture(rackfocus, tmp_path):
    path = write_deep(tmp_path / "a.exr", SMALL, deep_samples(SMALL, panes()))
    flat, out = tmp_path / "flat.exr", tmp_path / "out.exr"
    lens = ["--lens-radius", "1e-9", "--focal-length-px", "45", "--type", "float"]
    rackfocus("filter", path, "-o", out, "--flattened", flat, *lens)
    assert (read(out)[0] == read(flat)[0][..., :4]).all()


def test_order_of_samples_and_threads_do_not_matter(rackfocus, tmp_path):
    samples = deep_samples(SMALL, solids() + fog(0))
    pictures = []
    for name, order in (("a", samples), ("b", samples[::-1])):
        path = write_deep(tmp_path / f"{name}.exr", SMALL, order)
        for n in (1, 3):
            out = tmp_path / f"{name}{n}.exr"
            lens = [*SMALL.options(), "--type", "float", f"-j{n}"]
            rackfocus("filter", path, "-o", out, *lens)
            pictures.append(read(out)[0])
    for picture in pictures[1:]:
        assert (picture == pictures[0]).all()


def test_many_sheets_and_equal_depths_in_any_order(rackfocus, tmp_path):
    """48 sheets, two at each depth: more than the short sort is for."""
    colours = [stripes(3, 2, (0.1 * k, 0.5, 1 - 0.1 * k), (0.9, 0, 0)) for k in (2, 7)]
    sheets = [
        Layer(8 + k // 2, colours[k % 2], disc(0, 0, 2, 0.05 + 0.1 * (k % 2)))
        for k in range(48)
    ]
    samples = deep_samples(SMALL, [*sheets, wall(40)])
    pictures = []
    for name, order in (("a", samples), ("b", samples[::-1])):
        path = write_deep(tmp_path / f"{name}.exr", SMALL, order)
        out = tmp_path / f"{name}_out.exr"
        rackfocus("filter", path, "-o", out, *SMALL.options(), "--type", "float")
        pictures.append(read(out)[0])
    assert (pictures[0] == pictures[1]).all()


def test_blend_gamma(rackfocus, tmp_path):
    """A pane of 0.9 before a wall of 0.1: the mean of their roots, not of their light."""
    pane = Layer(4, plain(0.9, 0.9, 0.9), everywhere(0.25))
    far = Layer(12, plain(0.1, 0.1, 0.1), everywhere(1))
    path = write_deep(tmp_path / "a.exr", SMALL, deep_samples(SMALL, [pane, far], 1))
    for gamma in (1, 2.2):
        out = tmp_path / f"{gamma}.exr"
        lens = [*SMALL.options(), "--type", "float", "--blend-gamma", str(gamma)]
        rackfocus("filter", path, "-o", out, *lens)
        want = (0.25 * 0.9 ** (1 / gamma) + 0.75 * 0.1 ** (1 / gamma)) ** gamma
        inner = read(out)[0][8:-8, 8:-8, :3]
        assert np.abs(inner - want).max() < 1e-5


def test_one_opaque_sample_per_pixel_is_the_flat_filter(rackfocus, tmp_path):
    """Nothing but what the flat picture has: the same bits as the method layered."""
    samples = [
        (layer, np.round(coverage), np.where(np.round(coverage)[..., None], rgb, 0))
        for layer, coverage, rgb in deep_samples(SMALL, solids(), 1, keep_hidden=False)
    ]
    path = write_deep(tmp_path / "a.exr", SMALL, samples)
    flat, out, want = (tmp_path / name for name in ("f.exr", "o.exr", "w.exr"))
    lens = [*SMALL.options(), "--type", "float", "--exact-highlights", "off"]
    rackfocus("filter", path, "-o", out, "--flattened", flat, *lens)
    rackfocus("filter", flat, "-o", want, *lens, "--split-edges", "off")
    assert np.abs(read(out)[0] - read(want)[0]).max() < 1e-6


@pytest.mark.parametrize("tile", [0, 16, 13])
@pytest.mark.parametrize("compression", ["none", "zips"])
def test_storage(rackfocus, tmp_path, tile, compression):
    """Scan lines and tiles, plain and compressed: the same picture."""
    samples = deep_samples(SMALL, panes() + fog(0))
    first = write_deep(tmp_path / "first.exr", SMALL, samples)
    path = write_deep(tmp_path / "a.exr", SMALL, samples, tile, compression)
    pictures = []
    for source in (first, path):
        rackfocus("filter", source, "-o", tmp_path / "o.exr", *SMALL.options())
        pictures.append(read(tmp_path / "o.exr")[0])
    assert (pictures[0] == pictures[1]).all()
    found = json.loads(rackfocus("info", path, "--json").stdout)
    assert found["files"][0]["parts"][0]["deep"] is True
    assert found["files"][0]["parts"][0]["tiled"] is (tile > 0)


def write_flat(path, camera, names):
    spec = oiio.ImageSpec(camera.width, camera.height, len(names), oiio.FLOAT)
    spec.channelnames = names
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    grey = np.full((camera.height, camera.width, len(names)), 0.5, np.float32)
    assert output.write_image(grey), output.geterror()
    output.close()
    return path


@pytest.mark.parametrize("name", ["flat", "beauty"])
def test_a_flat_picture_beside_deep_samples(rackfocus, tmp_path, name):
    """It took its depth from these: `info` showed nothing, and `filter` named an option
    for deep files, which this was none of."""
    deep = write_deep(tmp_path / "d.exr", SMALL, deep_samples(SMALL, solids()))
    flat = write_flat(tmp_path / "f.exr", SMALL, ("R", "G", "B"))
    both = join(tmp_path / "both.exr", **{name: flat, "hidden": deep})
    assert "part 1 hidden: deep scan lines" in rackfocus("info", both).stdout
    out, want = tmp_path / "o.exr", tmp_path / "w.exr"
    done = rackfocus("filter", both, "-o", out, *SMALL.options(), code=1)
    assert "there is no depth channel beside the flat picture" in done.stderr
    assert "or filter the deep part with --layer hidden" in done.stderr
    layer = ("--layer", "hidden", *SMALL.options())
    rackfocus("filter", both, "-o", out, *layer)
    rackfocus("filter", deep, "-o", want, *SMALL.options())
    assert (read(out)[0] == read(want)[0]).all()
    depth = write_flat(tmp_path / "z.exr", SMALL, ("Z",))
    rackfocus("filter", both, "--depth-file", depth, "-o", out, *SMALL.options(), "-q")
    assert np.allclose(read(out)[0], 0.5)


def test_files_of_openexr(rackfocus, tmp_path):
    """Run lengths, which OpenImageIO does not write; samples of make_deep.cpp."""
    found = []
    for kind in ("rle", "zips"):
        path, flat = FILES / f"deep-{kind}.exr", tmp_path / "flat.exr"
        info = rackfocus("info", path).stdout
        assert f"deep scan lines, {kind}" in info
        out = ["-o", tmp_path / "o.exr", "--flattened", flat, "--type", "float"]
        rackfocus("filter", path, *out, *SMALL.options())
        found += [read(tmp_path / "o.exr")[0], read(flat)[0]]
    assert (found[0] == found[2]).all() and (found[1] == found[3]).all()
    n = 1 + np.arange(24 * 16) // 5 % 3
    alpha = np.array([[1, 0, 0], [0.25, 1, 0], [0.25, 0.5, 1]])[n - 1]
    left = np.cumprod(np.hstack([np.ones((n.size, 1)), 1 - alpha[:, :2]]), 1)
    assert np.allclose((left * alpha).sum(1), 1)
    want = 0.6 * np.ones((16, 24))  # R is 0.6 times the opacity
    flat, names = read(flat)
    assert np.abs(flat[..., names.index("R")] - want).max() < 1e-6
    depth = np.where(n == 1, 3, np.where(n == 2, 7, 7)).reshape(16, 24)
    assert (flat[..., names.index("Z")] == depth).all()


def test_info_counts_samples(rackfocus, tmp_path):
    layers = solids() + fog(0)
    samples = deep_samples(SMALL, layers)
    path = write_deep(tmp_path / "a.exr", SMALL, samples)
    deep = json.loads(rackfocus("info", path, "--json").stdout)["deep"]
    assert deep["n_samples"] == sum((c > 0).sum() for _, c, _ in samples)
    assert deep["n_volumes"] == (samples[2][1] > 0).sum()
    hit = samples[0][1] >= 0.999
    behind = sum((c[hit] > 0).sum() for _, c, _ in samples[1:])
    hit = (samples[0][1] < 0.999) & (samples[1][1] >= 0.999)
    behind += sum((c[hit] > 0).sum() for _, c, _ in samples[2:])
    assert deep["n_hidden"] == behind > 0
    assert deep["n_empty"] == 0
    assert "deep samples" in rackfocus("info", path).stdout


def test_info_shows_a_shadow_map(rackfocus, tmp_path):
    """Deep samples without colour: what the file holds, and that it cannot be blurred."""
    samples, path = deep_samples(SMALL, solids()), tmp_path / "a.exr"
    write_deep(path, SMALL, samples, names=("A", "Z", "ZBack"))
    done = rackfocus("info", path)
    assert re.search(r"channels +A \(float\) Z \(float\) ZBack", done.stdout)
    assert "its deep samples have no colour" in done.stderr


def test_coc_is_that_of_the_flat_depth(rackfocus, tmp_path):
    path = write_deep(tmp_path / "a.exr", SMALL, deep_samples(SMALL, solids()))
    coc, flat = tmp_path / "coc.exr", tmp_path / "flat.exr"
    out = ["-o", tmp_path / "o.exr", "--output-coc", coc, "--flattened", flat]
    rackfocus("filter", path, *out, *SMALL.options())
    z = read(flat)[0][..., 4]
    want = 45 * 0.22 * (1 / 6 - 1 / z)
    assert np.abs(read(coc)[0][..., 0] - want).max() < 1e-4


def test_header_is_kept(rackfocus, tmp_path):
    attributes = [("rackfocus:focusDistance", 6.0), ("shotNumber", "7")]
    samples = deep_samples(SMALL, solids())
    path = write_deep(tmp_path / "a.exr", SMALL, samples, attrs=attributes)
    rackfocus("filter", path, "-o", tmp_path / "o.exr", "--lens-radius", "0.1")
    spec = oiio.ImageInput.open(str(tmp_path / "o.exr")).spec()
    assert spec.getattribute("shotNumber") == "7"
    assert not spec.deep and spec.getattribute("maxSamplesPerPixel") is None


def test_what_cannot_be(rackfocus, tmp_path):
    deep = write_deep(tmp_path / "a.exr", SMALL, deep_samples(SMALL, solids()))
    other = write_deep(tmp_path / "b.exr", CAMERA, deep_samples(CAMERA, [wall()]))
    flat, out = tmp_path / "flat.exr", tmp_path / "o.exr"
    rackfocus("filter", deep, "-o", out, "--flattened", flat, *SMALL.options())
    out.unlink()

    def fails(text, *arguments, code=1):
        assert text in rackfocus("filter", *arguments, "-o", out, code=code).stderr
        assert not out.exists()

    fails("method layered only", deep, "--method", "scatter", code=2)
    fails("leave it out", deep, "--pass-through", code=2)
    fails("one flat picture, and", deep, "--filter-layers", "N", code=2)
    fails("holds no deep samples", flat, "--holdout", deep, code=2)
    fails("holds no deep samples", flat, "--flattened", tmp_path / "x.exr", code=2)
    fails("its data window is not that", deep, "--holdout", other)
    fails("has no deep samples", deep, "--holdout", flat)
    fails("leave the file of the depth out", deep, "--depth-file", flat)
    fails("does not end in .exr", deep, "--flattened", "x.png", code=2)
    assert "--flattened makes one" in rackfocus("compare", deep, flat, code=1).stderr


@pytest.mark.parametrize("channel, value", [("Z", -1), ("Z", np.nan), ("R", np.inf)])
def test_bad_samples_are_counted(rackfocus, tmp_path, channel, value):
    samples = deep_samples(SMALL, solids())
    layer, coverage, colour = samples[0]
    if channel == "Z":
        layer.z = layer.back = value
    else:
        colour[..., 0] = np.where(coverage > 0, value, 0)
    path = write_deep(tmp_path / "a.exr", SMALL, samples)
    done = rackfocus("filter", path, "-o", tmp_path / "o.exr", code=1)
    y, x = np.argwhere(coverage > 0)[0]
    assert f"{(coverage > 0).sum()} deep samples" in done.stderr
    assert f"at pixel ({x}, {y})" in done.stderr


def changed(channel, change):
    """Small samples with a change of the depth, or of the colours by coverage."""
    samples = deep_samples(SMALL, panes() + solids())
    for layer, _, _ in samples if channel == "Z" else ():
        layer.z, layer.back = change(layer.z), None
    return [
        (layer, coverage, colour if channel == "Z" else change(colour, coverage))
        for layer, coverage, colour in samples
    ]


def straight(colour, coverage):
    return colour / np.where(coverage > 0, coverage, 1)[..., None]


def test_doubtful_samples_are_told(rackfocus, tmp_path):
    """What is said of flat files: straight colours (35.6 dB for 41.0), no distances,
    half floats; and samples without alpha, of which the nearest hides all."""
    out = tmp_path / "o.exr"

    def said(samples, *arguments, code=0, **options):
        path = write_deep(tmp_path / "a.exr", SMALL, samples, **options)
        lens = [*SMALL.options(), *arguments]
        return rackfocus("filter", path, "-o", out, *lens, code=code).stderr

    good = changed("Z", lambda z: z)
    hidden = said(good, names=(*"RGB", "Z", "ZBack"))
    assert "no alpha, so that the nearest of a pixel hides the others" in hidden
    assert "not multiplied by alpha" in said(changed("R", straight))
    assert "warning" not in said(good)
    assert "taken for distances" in said(changed("Z", lambda z: z / 20))
    reached = said(changed("Z", lambda z: z / 12), code=1)
    assert "like normalised depth" in reached
    negative = changed("Z", lambda z: -z)
    assert "say --depth-scale -1" in said(negative, code=1)
    assert "warning" not in said(negative, "--depth-scale", "-1")


def test_damaged(rackfocus, tmp_path):
    """Cut off or changed anywhere: an error or a picture, and never a crash."""
    rng = np.random.default_rng(3)
    samples = deep_samples(SMALL, solids())
    n_refused = 0
    for compression, tile in (("rle", 0), ("zips", 0), ("zips", 16), ("none", 16)):
        source = write_deep(tmp_path / "a.exr", SMALL, samples, tile, compression)
        data = bytearray(source.read_bytes())
        for k in range(12):
            bad = bytearray(data)
            if k < 4:
                bad = bad[: len(bad) * (k + 1) // 5]
            else:
                bad[rng.integers(300, len(bad))] ^= 1 << int(rng.integers(8))
            path = tmp_path / "bad.exr"
            path.write_bytes(bad)
            out = tmp_path / "o.exr"
            done = subprocess.run(
                [os.environ["RACKFOCUS"], "filter", path, "-o", out, "-q"],
                capture_output=True,
                text=True,
                timeout=60,
            )
            assert done.returncode in (0, 1), done.stderr
            assert done.returncode == 0 or str(path) in done.stderr
            n_refused += done.returncode
    assert n_refused >= 16
