# SPDX-License-Identifier: Apache-2.0
"""The Python extension: lists, optics, pictures, errors, progress, threads."""

import gc
import os
import re
import subprocess
import threading
import warnings

import numpy as np
import OpenImageIO as oiio
import pytest
import rackfocus

LENS = dict(focus_distance=2.0, f_stop=0.5, focal_length=50, sensor_width=36)


def make_frame(height=40, width=60, channels=4):
    """A colour ramp with a bright dot over a slanted depth."""
    rng = np.random.default_rng(1)
    colour = rng.random((height, width, channels), np.float32)
    colour[height // 2, width // 2] = 30
    depth = np.linspace(1, 6, height * width, dtype=np.float32)
    return colour, depth.reshape(height, width)


def filtered(colour, depth, method="scatter", **params):
    """One frame through the filter."""
    return rackfocus.apply(colour, depth, method=method, **{**LENS, **params})


# ---- lists ------------------------------------------------------------------------


def test_parameters_are_those_of_the_core(root):
    """Every line of params.def, in its order."""
    text = (root / "core/include/rackfocus/params.def").read_text()
    keys = re.findall(r'^RF_(?:FLOAT|INT|BOOL|ENUM)\("([^"]+)"', text, re.M)
    assert [p.key for p in rackfocus.parameters()] == keys


def test_what_lies_behind_is_seen():
    """A wall in focus behind a blurred post: known, its pixels come through."""
    height, width = 40, 60
    wall = np.random.default_rng(1).random((height, width, 3), np.float32)
    post = np.s_[:, 27:33]
    colour, depth = wall.copy(), np.full((height, width), 4, np.float32)
    colour[post], depth[post] = 0.3, 1
    behind = np.full((height, width), np.nan, np.float32)
    made = rackfocus.Filter(
        width, height, focus_distance=4.0, lens_radius=0.15, focal_length_px=100
    )
    alone, known = np.empty_like(wall), np.empty_like(wall)
    made.process(colour, depth, alone, behind=(wall, behind))
    made.process(colour, depth, known)
    assert np.array_equal(alone, known)  # nothing was known
    behind[post] = 4
    made.process(colour, depth, known, behind=(wall, behind))
    share = np.linalg.lstsq(
        np.stack([(wall[post] - 0.3).ravel()], 1),
        (known[post] - 0.3).ravel(),
        rcond=None,
    )
    inner = known[12:-12, 27:33] - 0.3
    fit = (wall[12:-12, 27:33] - 0.3) * share[0][0]
    assert share[0][0] > 0.4 and np.abs(inner - fit).mean() < 0.02
    for wrong in ((wall,), (wall, behind, 1), [wall, behind], (wall[:9], behind)):
        with pytest.raises((TypeError, ValueError)):
            made.process(colour, depth, known, behind=wrong)


def test_parameters_are_complete():
    """Types, ranges, defaults and choices."""
    for p in rackfocus.parameters():
        assert p.help and p.attribute.startswith("rackfocus:")
        assert p.group in ("lens", "aperture", "depth", "method", "highlights")
        if p.type == "enum":
            assert p.default in [choice.name for choice in p.choices]
        else:
            assert p.min <= p.default <= p.max and not p.choices


def test_methods_are_the_choices_of_the_parameter():
    """The list of methods and the parameter agree."""
    by_field = {p.field: p for p in rackfocus.parameters()}
    names = [method.name for method in rackfocus.methods()]
    assert names == [choice.name for choice in by_field["method"].choices]
    assert all(method.source and method.cost for method in rackfocus.methods())


def test_cpu_level_is_that_of_the_machine():
    """AVX2 where the processor has it."""
    with open("/proc/cpuinfo") as file:
        flags = set(file.read().split())
    best = "sse4" if "sse4_1" in flags else "generic"
    assert rackfocus.cpu_level() == ("avx2" if "avx2" in flags else best)


def test_cpu_level_is_that_of_the_environment(monkeypatch):
    """RACKFOCUS_CPU chooses, and a wrong name says which there are."""
    monkeypatch.setenv("RACKFOCUS_CPU", "generic")
    assert rackfocus.cpu_level() == "generic"
    monkeypatch.setenv("RACKFOCUS_CPU", "z80")
    with pytest.raises(ValueError, match="z80.*generic"):
        rackfocus.cpu_level()


@pytest.mark.parametrize("p", rackfocus.parameters(), ids=lambda p: p.key)
def test_every_parameter_is_taken(p):
    """Its default is accepted by field and by key; a wrong value names it."""
    rackfocus.Lens(10, 10, **{p.field: p.default})
    rackfocus.Lens(10, 10, **{p.key: p.default})
    bad = "no such choice" if p.type == "enum" else float("nan")
    with pytest.raises(rackfocus.ParameterError) as caught:
        rackfocus.Lens(10, 10, **{p.field: bad})
    assert caught.value.field == p.field


# ---- optics -----------------------------------------------------------------------


def test_radius_is_that_of_the_thin_lens():
    """r = K (1/s - 1/z), K = R f_px."""
    lens = rackfocus.Lens(600, 400, **LENS)
    k = 50e-3 / (2 * 0.5) * 600 * 50 / 36
    for z in (1.0, 2.0, 5.0, float("inf")):
        assert lens.radius_px(z) == pytest.approx(k * (1 / 2 - 1 / z), abs=1e-9)
    assert lens.depth_at(lens.radius_px(3.0)) == pytest.approx(3.0)


def test_depth_of_field_is_where_the_radius_reaches_the_limit():
    """Both ends; the hyperfocal distance has its far end at infinity."""
    lens = rackfocus.Lens(600, 400, **LENS, coc_limit=1.5)
    near, far = lens.depth_of_field()
    assert lens.radius_px(near) == pytest.approx(-1.5)
    assert lens.radius_px(far) == pytest.approx(1.5)
    there = {**LENS, "focus_distance": lens.hyperfocal() * 0.9999}
    assert rackfocus.Lens(600, 400, **there, coc_limit=1.5).depth_of_field()[1] > 1e4


# ---- pictures ---------------------------------------------------------------------


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_energy_is_kept(channels):
    """A bright dot far from the borders keeps its light."""
    colour = np.zeros((80, 80, channels), np.float32)
    colour[40, 40], colour[..., 3:] = 100, 1
    depth = np.full((80, 80), 1.5, np.float32)
    out = filtered(colour, depth, f_stop=0.1)
    assert out[40, 40, 0] < 50
    assert np.allclose(out[..., :3].sum((0, 1)), 100, rtol=1e-4)
    assert (out[20:60, 20:60, 3:] > 0.999).all() and (out[..., 3:] <= 1).all()


def test_grey_needs_no_third_dimension():
    """(height, width) is (height, width, 1)."""
    colour, depth = make_frame(channels=1)
    flat = filtered(np.ascontiguousarray(colour[..., 0]), depth)
    assert np.array_equal(flat, filtered(colour, depth)[..., 0])


def test_strides_do_not_matter():
    """Planes, mirrored rows, columns taken out of wider rows: the same bits."""
    colour, depth = make_frame(channels=3)
    expected = filtered(colour, depth)
    planes = np.ascontiguousarray(colour.transpose(2, 0, 1)).transpose(1, 2, 0)
    mirrored = np.ascontiguousarray(colour[::-1])[::-1]
    wide = np.full((40, 120, 5), np.nan, np.float32)
    wide[:, ::2, 1:4] = colour
    for view in (planes, mirrored, wide[:, ::2, 1:4]):
        assert np.array_equal(filtered(view, depth), expected)
    out = np.full((40, 120, 5), -7, np.float32)
    rackfocus.apply(colour, depth, out[:, ::2, 1:4], method="scatter", **LENS)
    assert np.array_equal(out[:, ::2, 1:4], expected)
    assert np.all(out[:, 1::2] == -7) and np.all(out[..., 0] == -7)


def test_memoryviews_do():
    """No NumPy is needed."""
    colour, depth = make_frame()
    out = memoryview(bytearray(colour.nbytes)).cast("f", colour.shape)
    source = memoryview(colour.tobytes()).cast("f", colour.shape)
    rackfocus.apply(source, depth, out, method="scatter", **LENS)
    assert np.array_equal(np.asarray(out), filtered(colour, depth))


def test_in_place():
    """out may be the colour itself."""
    colour, depth = make_frame()
    expected = filtered(colour, depth)
    rackfocus.apply(colour, depth, colour, method="scatter", **LENS)
    assert np.array_equal(colour, expected)


def test_coc_and_planar_depth():
    """What the filter makes of every pixel's depth."""
    _, depth = make_frame()
    depth[0, 0] = 1e10
    made = rackfocus.Filter(60, 40, **LENS)
    coc, planar = np.empty_like(depth), np.empty_like(depth)
    made.coc(depth, coc)
    made.planar_depth(depth, planar)
    assert np.isinf(planar[0, 0]) and np.array_equal(planar[1:], depth[1:])
    expected = [made.lens.radius_px(float(z)) for z in depth[:, 7]]
    assert np.allclose(coc[:, 7], expected, rtol=1e-6, atol=1e-6)


def test_threads_do_not_change_the_result():
    """The same bits on one thread and on three."""
    colour, depth = make_frame()
    one = filtered(colour, depth, threads=1)
    assert np.array_equal(one, filtered(colour, depth, threads=3))
    assert rackfocus.Filter(8, 8, threads=3).threads == 3


def test_a_filter_is_shared_by_threads():
    """Several Python threads at once, and the lock of the interpreter is free."""
    colour, depth = make_frame(200, 300)
    made = rackfocus.Filter(300, 200, method="scatter", threads=1, **LENS)
    outs = [np.empty_like(colour) for _ in range(4)]
    threads = [
        threading.Thread(target=made.process, args=(colour, depth, out)) for out in outs
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for out in outs:
        assert np.array_equal(out, filtered(colour, depth))


# ---- views ------------------------------------------------------------------------


def posts_views(root, n=3):
    """(paths, views for process_views(), parameters) of the scene posts."""
    paths = [root / f"tests/quality/references/posts_view{i:02}.exr" for i in range(n)]
    views = []
    for path in paths:
        image = oiio.ImageBuf(str(path))
        pixels = image.get_pixels(oiio.FLOAT)
        names = image.spec().channelnames
        colour = pixels[..., [names.index(c) for c in "RGB"]]
        shear = image.spec().getattribute("rackfocus:shearDistance")
        offset = tuple(image.spec().getattribute("rackfocus:lensOffset"))
        views.append((colour, pixels[..., names.index("Z")], offset, shear))
    known = {p.attribute: p for p in rackfocus.parameters()}
    params = {
        known[a.name].field: a.value
        for a in image.spec().extra_attribs
        if a.name in known
    }
    return paths, views, params


def test_views_give_what_the_command_gives(root, tmp_path):
    """Bit for bit, from files and from memory."""
    paths, views, params = posts_views(root)
    out = np.empty_like(views[0][0])
    height, width = out.shape[:2]
    made = rackfocus.Filter(width, height, **{**params, "method": "views"})
    made.process_views(views, out)
    path = tmp_path / "out.exr"
    command = [os.environ["RACKFOCUS"], "filter", *paths, "-o", path]
    subprocess.run([*command, "--type", "float", "--quiet"], check=True)
    assert np.array_equal(out, oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT))


def test_one_view_is_a_frame():
    """process_views() with one view is process()."""
    colour, depth = make_frame()
    made = rackfocus.Filter(60, 40, method="views", **LENS)
    a, b = np.empty_like(colour), np.empty_like(colour)
    made.process(colour, depth, a)
    made.process_views([(colour, depth, (0.0, 0.0), 0.0)], b)
    assert np.array_equal(a, b)


def test_views_that_are_hardly_of_one_lens_are_warned_of(root, recwarn):
    """Of another place than is said, or of another exposure; the command says the same."""
    _, views, params = posts_views(root)
    height, width = views[0][0].shape[:2]
    made = rackfocus.Filter(width, height, **{**params, "method": "views"})
    out, other = np.empty_like(views[0][0]), np.empty_like(views[0][0])
    made.process_views(views, out)
    assert not recwarn
    with pytest.warns(rackfocus.ViewsWarning, match="both numbers of lens_offset"):
        made.process_views([(c, z, (-u, -v), d) for c, z, (u, v), d in views], out)
    bright = [*views[:2], (2 * views[2][0], *views[2][1:])]
    with pytest.warns(rackfocus.ViewsWarning, match="view 2 is 2 times as bright"):
        made.process_views(bright, out)
    with pytest.warns(rackfocus.ViewsWarning, match="view 2 is 2 times as bright"):
        made.merge_denoised(bright, [view[0] for view in bright], other)
    made.process_views(bright, other, check=False)
    assert not recwarn.list


def test_bad_views_are_named():
    """None, too many, not tuples, wrong buffers, a method of one view."""
    colour, depth = make_frame()
    out = np.empty_like(colour)
    one = (colour, depth, (0.0, 0.0), 2.0)
    made = rackfocus.Filter(60, 40, method="views", **LENS)
    for views, error, text in (
        ([], ValueError, "1 to 64"),
        ([one] * 65, ValueError, "1 to 64"),
        ([one, 3], TypeError, "view 1"),
        ([(colour.astype(float), depth, (0.0, 0.0), 2.0)], TypeError, "colour"),
        ([one, (colour, depth[1:], (0.1, 0.0), 2.0)], rackfocus.Error, "depth"),
        ([one, (colour, depth, (np.inf, 0.0), 2.0)], rackfocus.Error, "lens"),
    ):
        with pytest.raises(error, match=text):
            made.process_views(views, out)
    with pytest.raises(rackfocus.Error, match="scatter"):
        rackfocus.Filter(60, 40, method="scatter", **LENS).process_views([one] * 2, out)


# ---- errors -----------------------------------------------------------------------


def test_out_of_range_names_the_field():
    """The message and the field."""
    with pytest.raises(rackfocus.ParameterError, match="f_stop") as caught:
        rackfocus.Filter(8, 8, f_stop=-1)
    assert caught.value.field == "f_stop" and caught.value.message
    assert isinstance(caught.value, ValueError)


def test_unknown_parameter():
    """A misspelt keyword is not ignored."""
    with pytest.raises(rackfocus.ParameterError, match="fstop"):
        rackfocus.Filter(8, 8, fstop=2)


@pytest.mark.parametrize("value", [None, [], object()])
def test_value_of_the_wrong_type(value):
    """Neither a number nor a text."""
    with pytest.raises(TypeError, match="f_stop"):
        rackfocus.Filter(8, 8, f_stop=value)


def test_bad_depth_and_bad_colour():
    """The first bad pixel is named."""
    colour, depth = make_frame()
    depth[3, 5] = np.nan
    with pytest.raises(rackfocus.DepthError, match=r"\(5, 3\)"):
        filtered(colour, depth)
    colour, depth = make_frame()
    colour[2, 4, 0] = np.inf
    with pytest.raises(rackfocus.PixelError, match=r"4, 2"):
        filtered(colour, depth)


@pytest.mark.parametrize(
    "spoil, error, name",
    [
        (lambda c, d, o: (c.astype("f8"), d, o), TypeError, "colour"),
        (lambda c, d, o: (c, d.astype("i4"), o), TypeError, "depth"),
        (lambda c, d, o: (c, d[:5], o), ValueError, "depth"),
        (lambda c, d, o: (c, d, o[:, :5]), ValueError, "out"),
        (lambda c, d, o: (c, d, o.tobytes()), TypeError, "out"),
        (lambda c, d, o: (c.ravel(), d, o), ValueError, "colour"),
        (lambda c, d, o: (c[:0], d, o), ValueError, "colour"),
        (lambda c, d, o: (c, d, None), TypeError, "this NoneType is not; make it by"),
        (
            lambda c, d, o: (c.tolist(), d, o),
            TypeError,
            "list; give numpy.asarray.colour",
        ),
        (lambda c, d, o: (c[..., :2], d, o), ValueError, "colour"),
        (lambda c, d, o: (c, c, o), ValueError, "depth has 4 channels"),
        (lambda c, d, o: (c, d, np.broadcast_to(o[:1, :1], o.shape)), TypeError, "out"),
    ],
)
def test_wrong_buffers_are_named(spoil, error, name):
    """Type, shape, size and access of each argument."""
    colour, depth = make_frame()
    made = rackfocus.Filter(60, 40, **LENS)
    with pytest.raises(error, match=name):
        made.process(*spoil(colour, depth, np.empty_like(colour)))


@pytest.mark.parametrize(
    "colour, error, text",
    [
        (b"abcd", ValueError, "colour: .*not of 1 dimensions"),
        (np.float32(1), ValueError, "colour: .*not of 0 dimensions"),
        (
            None,
            TypeError,
            "colour: a readable buffer of floats is needed, not NoneType",
        ),
        (
            [[1.0, 2.0]],
            TypeError,
            r"colour: .*, not list; give numpy.asarray\(colour, numpy.float32\)",
        ),
        (np.ones((2, 3, 4, 5), "f4"), ValueError, "colour: .*not of 4 dimensions"),
    ],
)
def test_what_is_no_picture_is_named(colour, error, text):
    """And not that too few values were unpacked."""
    with pytest.raises(error, match=text):
        rackfocus.apply(colour, np.ones((2, 3), "f4"))
    with pytest.raises(error, match=text.replace("colour", "pictures")):
        rackfocus.accumulate([colour])


def test_masked_arrays_are_refused():
    """Their buffer has the masked numbers as well. Without a mask they are arrays."""
    colour, depth = make_frame()
    want = rackfocus.apply(colour, depth, **LENS)
    masked = np.ma.masked_array(depth, depth > depth.mean())
    assert masked.mask.any()
    with pytest.raises(TypeError, match=r"depth: its mask .*depth.filled\("):
        rackfocus.apply(colour, masked, **LENS)
    with pytest.raises(TypeError, match=r"colour: its mask"):
        rackfocus.apply(np.ma.masked_array(colour, colour > 0.3), depth, **LENS)
    for mask in (np.ma.nomask, np.zeros(depth.shape, bool)):
        bare = np.ma.masked_array(depth, mask)
        assert (rackfocus.apply(colour, bare, **LENS) == want).all()
    filled = masked.filled(12).astype("f4")
    assert rackfocus.apply(colour, filled, **LENS).shape == colour.shape


# ---- progress ---------------------------------------------------------------------


def test_progress_rises_from_0_to_1():
    """0 first, never falling, 1 last."""
    colour, depth = make_frame(300, 200)
    seen = []
    filtered(colour, depth, progress=seen.append)
    assert seen[0] == 0 and seen[-1] == 1 and seen == sorted(seen)


@pytest.mark.parametrize("at", [0, 0.3])
def test_false_cancels(at):
    """The error has a class of its own."""
    colour, depth = make_frame(300, 200)
    with pytest.raises(rackfocus.CancelledError):
        filtered(colour, depth, progress=lambda fraction: fraction < at)


def test_an_exception_in_the_callback_comes_through():
    """Not swallowed, not replaced."""

    def fail(fraction):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        filtered(*make_frame(), progress=fail)


# ---- memory -----------------------------------------------------------------------


def resident_bytes():
    """Memory of this process that is in use."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def test_memory_does_not_grow():
    """Objects, errors and buffers are released."""
    colour, depth = make_frame(100, 100)
    bad = depth.copy()
    bad[0, 0] = np.nan

    def once():
        filtered(colour, depth)
        rackfocus.parameters()
        with pytest.raises(rackfocus.DepthError):
            filtered(colour, bad)

    for _ in range(50):
        once()
    gc.collect()
    before = resident_bytes()
    for _ in range(300):
        once()
    gc.collect()
    assert resident_bytes() - before < 4 << 20


# ---- views from points of the lens ---------------------------------------------------


def test_lens_points_follow_the_parameters():
    """Tuples of (u, v, time); blades and rotation by keyword; errors name the field."""
    points = np.array(rackfocus.lens_points(64))
    assert points.shape == (64, 3)
    assert np.hypot(*points.T[:2]) ** 2 == pytest.approx((np.arange(64) + 0.5) / 64)
    circle = rackfocus.lens_points(6, lens_pattern="circle")
    assert (circle[0].u, circle[0].v) == (1, 0)
    assert rackfocus.lens_points(8, frame=1) == rackfocus.lens_points(8, frame=2)
    frames = [rackfocus.lens_points(8, frame=i, lens_random=True) for i in (1, 2)]
    assert frames[0] != frames[1]
    square = np.array(rackfocus.lens_points(400, blades=4))
    assert np.abs(square[:, :2]).max() < 0.5**0.5  # edges to the right and above
    with pytest.raises(rackfocus.ParameterError) as caught:
        rackfocus.lens_points(1)
    assert caught.value.field == "n"
    with pytest.raises(rackfocus.ParameterError) as caught:
        rackfocus.lens_points(8, lens_pattern="polygon")
    assert caught.value.field == "blades"


@pytest.mark.parametrize("shape", [(9, 7), (9, 7, 3), (9, 7, 4)])
def test_accumulate_is_the_mean(shape):
    """One picture in memory at a time; the blend gamma leaves alpha alone."""
    rng = np.random.default_rng(3)
    pictures = [rng.random(shape, np.float32) for _ in range(20)]
    mean = rackfocus.accumulate(iter(pictures))
    assert mean == pytest.approx(np.mean(pictures, axis=0, dtype=float), rel=1e-6)
    bent = rackfocus.accumulate(pictures, blend_gamma=2, threads=1)
    want = np.mean(np.sqrt(pictures, dtype=float), axis=0) ** 2
    if shape[-1] == 4:
        want[..., 3] = mean[..., 3]
    assert bent == pytest.approx(want, rel=1e-6)


def test_accumulator_refuses_bad_pictures():
    """NaN, another shape, nothing at all; what was added stays."""
    total = rackfocus.Accumulator(4, 3, 1)
    out = np.empty((3, 4), np.float32)
    with pytest.raises(rackfocus.Error):
        total.mean(out)
    total.add(np.ones((3, 4), np.float32))
    with pytest.raises(rackfocus.PixelError):
        total.add(np.full((3, 4), np.nan, np.float32))
    with pytest.raises(rackfocus.Error):
        total.add(np.ones((4, 3), np.float32))
    total.mean(out)
    assert total.count == 1 and (out == 1).all()
    with pytest.raises(ValueError):
        rackfocus.accumulate([])


def test_a_mean_says_what_it_does_not_read():
    """What it reads are the blend gamma and the highlights of each picture."""
    pictures = [np.ones((3, 5), np.float32)] * 2
    with pytest.warns(rackfocus.UnreadParameterWarning, match="^f_stop: has no effect"):
        rackfocus.accumulate(pictures, f_stop=2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rackfocus.accumulate(np.stack(pictures * 4), blend_gamma=2, blades=0)
        light = {"highlight_gain": 3, "highlight_threshold": 0.5}
        bright = rackfocus.accumulate(pictures, **light)
    assert bright == pytest.approx(np.full((3, 5), 2))


def test_a_picture_as_the_distribution():
    """Its light is normalised; other types and black are refused by name."""
    colour, depth = make_frame(channels=3)
    ramp = np.outer(np.arange(1, 9), np.arange(1, 6)).astype(np.float32)
    image = rackfocus.apply(
        colour, depth, method="scatter", distribution_image=ramp, **LENS
    )
    brighter = rackfocus.apply(
        colour, depth, method="scatter", distribution_image=9 * ramp, **LENS
    )
    assert image == pytest.approx(brighter, rel=1e-5)
    assert np.abs(image - filtered(colour, depth)).max() > 0.01
    with pytest.raises(rackfocus.PixelError):
        rackfocus.Filter(9, 9, distribution_image=0 * ramp, aperture="image")
    with pytest.raises(TypeError, match="distribution_image"):
        rackfocus.Filter(9, 9, distribution_image="ring.png", aperture="image")
    with pytest.raises(rackfocus.ParameterError) as caught:
        filtered(colour, depth, distribution="image")
    assert caught.value.field == "distribution"


def test_what_is_not_read_says_why():
    """For panels: nothing with the method, a reason without."""
    assert rackfocus.why_not_read("copies", method="offset") == ""
    assert "offset" in rackfocus.why_not_read("copies", method="layered")
    assert rackfocus.why_not_read("no_such_field")
    with pytest.raises(rackfocus.ParameterError):
        rackfocus.why_not_read("copies", no_such_field=2)


def test_looks(monkeypatch, tmp_path):
    """Those of the program, and the artist's own, which win; as keywords they work."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    given = {look.name: look for look in rackfocus.looks()}
    assert list(given)[:2] == ["vintage", "anamorphic"]
    assert given["mirror"].parameters == {"obstruction": 0.45, "cat_eye": 0.25}
    assert "portrait lens" in given["vintage"].about
    own = tmp_path / "rackfocus" / "looks"
    own.mkdir(parents=True)
    (own / "fast.params").write_text("# mine\nblades 7  # odd\nexact-highlights off\n")
    (own / "mine.params").write_text("method scatter\n")
    found = {look.name: look for look in rackfocus.looks()}
    assert list(found) == [*given, "mine"]
    assert found["fast"].is_own and found["fast"].about == "your own"
    assert rackfocus.look("fast") == {"blades": 7, "exact_highlights": False}
    rackfocus.Filter(8, 8, **{**rackfocus.look("mine"), "focus_distance": 3})
    with pytest.raises(ValueError, match="'nosuch'; there are vintage, "):
        rackfocus.look("nosuch")
    (own / "mine.params").write_text("method\n")
    (own / "odd.params").write_bytes(b"swirl \xff\n")
    with pytest.warns(UserWarning) as wrong:
        left = [look.name for look in rackfocus.looks()]
    assert left == list(given), "the others are there"
    assert [str(w.message)[:10] for w in wrong][0] == "look mine,"
    assert "odd.params: cannot be read" in str(wrong[1].message)
    assert rackfocus.look("vintage") == given["vintage"].parameters
    with monkeypatch.context() as elsewhere:  # no full path: as if it were not there
        elsewhere.chdir(tmp_path.parent)
        elsewhere.setenv("XDG_CONFIG_HOME", tmp_path.name)
        elsewhere.setenv("HOME", str(tmp_path))
        assert "odd" not in rackfocus._looks.sources()
    with pytest.raises(ValueError, match="look mine, line 1: 'method'"):
        rackfocus.look("mine")


# ---- depth ------------------------------------------------------------------------


def foggy(share):
    """Colours, the depth of a floor and a box, and the same with holes in a share."""
    rng = np.random.default_rng(2)
    y, x = np.mgrid[0:160, 0:200].astype(np.float32)
    is_box = (abs(x - 100) < 40) & (abs(y - 80) < 50)
    depth = np.where(is_box, 3, 400 / (y + 20)).astype(np.float32)
    colour = np.repeat(np.where(is_box, 0.7, 0.2).astype(np.float32)[..., None], 3, 2)
    with_holes = depth.copy()
    with_holes[rng.random(depth.shape) < share] = 1e10
    return colour, depth, with_holes


def test_fog_is_filled():
    colour, truth, depth = foggy(0.4)
    n_holes = (depth > 1e9).sum()
    n_filled, share = rackfocus.fill_depth(depth, colour)
    assert 0.98 * n_holes < n_filled <= n_holes and abs(share - 0.4) < 0.02
    assert (abs(depth - truth) < 0.05 * truth).mean() > 0.99
    assert rackfocus.fill_depth(depth, colour)[0] == 0


def test_always_fills_what_the_picture_does_not_tell():
    colour, truth, depth = foggy(0)
    depth[20:40:5, 20:40:5] = np.inf  # too few
    as_it_is = depth.copy()
    assert rackfocus.fill_depth(depth, colour)[0] == 0
    assert np.array_equal(depth, as_it_is)
    wide = np.repeat(depth[:, :, None], 2, 2)
    assert rackfocus.fill_depth(wide[..., :1], colour, always=True)[0] == 16
    assert (abs(wide[..., 0] - truth) < 0.05 * truth).all()
    assert np.array_equal(wide[..., 1], as_it_is)
    far = np.where(depth > 50, 60, depth)
    assert rackfocus.fill_depth(far, colour, always=True)[0] == 0
    assert rackfocus.fill_depth(far, colour, always=True, infinity=55)[0] == 16


def test_what_cannot_be_filled_is_refused():
    colour, _, depth = foggy(0.4)
    with pytest.raises(ValueError, match="depth: 1 channel is needed, not 3"):
        rackfocus.fill_depth(colour, colour)
    with pytest.raises(ValueError, match="colour: is 200 x 150 px"):
        rackfocus.fill_depth(depth, colour[:150])
    with pytest.raises(TypeError):
        depth.flags.writeable = False
        rackfocus.fill_depth(depth, colour)


def colour_of(*shape):
    return np.zeros(shape, np.float32)


@pytest.mark.parametrize(
    "field, call",
    [
        ("pictures", lambda: rackfocus.accumulate([])),
        ("pictures", lambda: rackfocus.accumulate(colour_of(5, 4, 3))),  # one alone
        ("pictures", lambda: rackfocus.accumulate([colour_of(3, 4, 2)])),
        ("colour", lambda: rackfocus.apply(colour_of(3), colour_of(3, 4))),
        ("colour", lambda: rackfocus.apply(colour_of(3, 4, 5, 3), colour_of(3, 4))),
        ("colour", lambda: rackfocus.apply(colour_of(3, 4, 2), colour_of(3, 4))),
        ("colour", lambda: rackfocus.apply(colour_of(3, 4, 5), colour_of(3, 4))),
        ("depth", lambda: rackfocus.apply(colour_of(3, 4, 3), colour_of(3))),
        ("name", lambda: rackfocus.look("nope")),
        ("width", lambda: rackfocus.Filter(2**40, 1)),
        ("height", lambda: rackfocus.Filter(1, -(2**70))),
        ("width", lambda: rackfocus.Lens(0, 4)),
        ("z", lambda: rackfocus.Lens(3, 4).radius_px(0)),
        ("max_bytes", lambda: rackfocus.Context(max_bytes=-1)),
        ("max_bytes", lambda: rackfocus.Context(max_bytes=2**80)),
        ("threads", lambda: rackfocus.Context(threads=2**40)),
        ("colour", lambda: rackfocus.fill_depth(colour_of(3, 4), colour_of(3, 5))),
        ("depth", lambda: rackfocus.fill_depth(colour_of(3, 4, 3), colour_of(3, 4))),
        ("views", lambda: rackfocus.Filter(4, 3).process_views([], colour_of(3, 4))),
        ("first", lambda: deep_of(np.zeros(3, np.uint64))),
        ("first", lambda: deep_of(np.zeros((3, 4), np.uint64))),
        ("samples", lambda: deep_of(np.zeros(13, np.uint64), colour_of(0, 3))),
        ("library", lambda: finish_of(library="/nowhere/at/all.so")),
        ("quality", lambda: finish_of(quality="best")),
        ("threads", lambda: finish_of(threads=-(2**40))),
        ("white", lambda: finish_of(white=0)),
        ("ours", lambda: finish_of(ours=colour_of(3, 5, 3))),
    ],
)
def test_errors_have_a_field(field, call, monkeypatch):
    """As python.md says: of all that is wrong but for a type."""
    monkeypatch.delenv("RACKFOCUS_OIDN", raising=False)
    with pytest.raises(rackfocus.Error) as caught:
        call()
    assert caught.value.field == field
    assert str(caught.value) == f"{field}: {caught.value.message}"
    if field != "library":
        assert isinstance(caught.value, (rackfocus.ParameterError, ValueError))


def deep_of(first, samples=None):
    samples = colour_of(0, 7) if samples is None else samples
    rackfocus.Filter(4, 3).process_deep(first, samples, colour_of(3, 4, 4))


def finish_of(ours=None, **keywords):
    ours = colour_of(3, 4, 3) if ours is None else ours
    return rackfocus.finish(colour_of(3, 4, 3), ours, **keywords)


def test_errors_that_python_raises_have_members():
    assert rackfocus.Error("x").field == "" and rackfocus.DepthError("x").message == ""


@pytest.mark.parametrize("kind", ["f8", "f2", ">f4"])
def test_other_floats_are_told_how_to_become_ours(kind):
    for name, arrays in (
        ("colour", (colour_of(3, 4, 3).astype(kind), colour_of(3, 4))),
        ("depth", (colour_of(3, 4, 3), colour_of(3, 4).astype(kind))),
    ):
        with pytest.raises(TypeError, match=rf"{name}: .*{name}\.astype\(numpy\.float"):
            rackfocus.apply(*arrays)
    out = np.zeros((3, 4, 3), kind)
    with pytest.raises(TypeError, match="out: .*with dtype=numpy.float32"):
        rackfocus.apply(colour_of(3, 4, 3), colour_of(3, 4), out)


def test_views_that_are_none_are_described():
    one = colour_of(3, 4, 3), colour_of(3, 4)
    views = rackfocus.Filter(4, 3, method="views")
    for wrong in (one, (*one, 3, 4), (*one, (0, 0)), 5):
        with pytest.raises(TypeError, match=r"view 0 must be a rackfocus\.View"):
            views.process_views([wrong], colour_of(3, 4, 3))
    with pytest.raises(TypeError, match="views: a list or a tuple is needed"):
        views.process_views((view for view in [one]), colour_of(3, 4, 3))


def test_a_look_that_cannot_be_read(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    folder = tmp_path / "rackfocus" / "looks"
    (folder / "mine.params").mkdir(parents=True)
    with pytest.raises(rackfocus.ParameterError, match="mine.params: cannot be read"):
        rackfocus.look("mine")
    (folder / "mine.params").rmdir()
    (folder / "mine.params").write_bytes(b"\xef\xbb\xbff-stop 2\r\n")
    assert rackfocus.look("mine") == {"f_stop": 2}
    (folder / "mine.params").write_text("f-stop two\n")
    with pytest.raises(rackfocus.ParameterError, match="line 1: 'two' is no number"):
        rackfocus.look("mine")
