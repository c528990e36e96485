# SPDX-License-Identifier: Apache-2.0
"""Depth as renderers write it: undone and said, or refused with the reason."""

import json

import numpy
import plainexr
import pytest

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "100"]
PLAIN = ["--compression", "none", "--type", "float"]
SIZE = (96, 64)


def smooth_disc(channels, radius=18, filter_px=1):
    """Coverage of a disc of distance 3 before a wall of 12, anti-aliased."""
    height, width = channels["Z"].shape
    y, x = numpy.mgrid[0:height, 0:width]
    r = numpy.hypot(x + 0.5 - width / 2, y + 0.5 - height / 2)
    return numpy.clip((radius - r) / filter_px + 0.5, 0, 1).astype("f4")


def add_alpha(channels):
    """The disc alone, premultiplied, nothing behind it."""
    alpha = smooth_disc(channels)
    for name, v in zip("RGB", (0.8, 0.4, 0.1), strict=True):
        channels[name] = (v * alpha).astype("f4")
    channels["A"] = alpha
    channels["Z"] = numpy.where(alpha > 0, 3, 0).astype("f4")


@pytest.fixture
def filtered(rackfocus, scene, tmp_path):
    """Filters the changed scene: its channels and what was said."""

    def run(change, *arguments, code=0):
        out = tmp_path / "o.exr"
        path = scene(size=SIZE, change=change)
        done = rackfocus(
            "filter", path, "-o", out, *LENS, *PLAIN, *arguments, code=code
        )
        return (plainexr.read(out)[0] if code == 0 else None), done.stderr

    return run


@pytest.fixture
def seen(rackfocus, scene):
    def run(change):
        path = scene(size=SIZE, change=change)
        assert rackfocus("info", path).returncode == 0
        return json.loads(rackfocus("info", path, "--json").stdout)["depth"]

    return run


def difference(a, b):
    return max(abs(a[name] - b[name]).max() for name in a)


def test_premultiplied(filtered, seen):
    """Divided by alpha, the picture is that of the depth before."""

    def premultiply(channels):
        add_alpha(channels)
        channels["Z"] *= channels["A"]

    want, said = filtered(add_alpha)
    assert said == ""
    got, said = filtered(premultiply)
    assert "was multiplied by alpha" in said
    assert difference(got, want) < 1e-4
    as_it_is, said = filtered(premultiply, "--depth-repair", "off")
    assert said == "" and difference(as_it_is, want) > 0.02
    assert seen(premultiply)["premultiplied"] and not seen(add_alpha)["premultiplied"]


def mix(share, far, channels):
    """Colour and depth, averaged with these weights of the near side."""
    near = numpy.clip(share, 0, 1)
    for name, v in zip("RGB", (0.8, 0.4, 0.1), strict=True):
        channels[name] = near * v + (1 - near) * channels[name] * 0.5
    channels["Z"] = (share * 3 + (1 - share) * far).astype("f4")


@pytest.mark.parametrize("filter_px", [1, 2, 3.5])
@pytest.mark.parametrize("far", [12, 1000, 1e10])
def test_anti_aliased(filtered, seen, filter_px, far):
    """Values between two sides become one of them, whatever the pixel filter."""

    def averaged(channels):
        mix(smooth_disc(channels, 18, filter_px), far, channels)

    def one_sample(channels):
        averaged(channels)
        share = smooth_disc(channels, 18, filter_px)
        channels["Z"] = numpy.where(share < 0.5, far, 3).astype("f4")

    want, said = filtered(one_sample)
    assert said == ""
    got, said = filtered(averaged)
    assert "was anti-aliased" in said
    as_it_is, said = filtered(averaged, "--depth-repair", "off")
    assert said == ""
    error = {n: abs(got[n] - want[n]).mean() for n in got}
    before = {n: abs(as_it_is[n] - want[n]).mean() for n in got}
    assert all(error[n] < 0.3 * before[n] for n in got)
    assert seen(averaged)["anti_aliased"]


@pytest.mark.parametrize("sky", [None, 1e10, -1e10, 0])
@pytest.mark.parametrize("fault", ["was anti-aliased", "was multiplied by alpha"])
def test_what_is_below_0_is_mended_as_what_is_above(filtered, fault, sky):
    """Positions in a camera's space that looks along -z are as often filtered."""

    def change(channels, sign):
        mix(smooth_disc(channels, 18, 3), 100, channels)
        if "alpha" in fault:
            add_alpha(channels)
            channels["Z"] = 3 * channels["A"]
        z = channels["Z"]
        z *= sign
        if sky is not None:
            z[:8] = sky if sign < 0 or sky >= 0 else -sky

    want, said = filtered(lambda c: change(c, 1))
    assert fault in said
    got, same = filtered(lambda c: change(c, -1), "--depth-scale", "-1")
    assert same == said
    assert all((got[name] == want[name]).all() for name in got)


@pytest.mark.parametrize("radius", [0.6, 1.2, 2])
def test_anti_aliased_thin_things_before_nothing(rackfocus, scene, tmp_path, radius):
    """Averages of what is thin and 0, where nothing was hit, are no distances: lamps at
    30 would have pixels before the lens, with a blur of the whole picture."""

    def change(channels):
        height, width = channels["Z"].shape
        y, x = numpy.mgrid[0:height, 0:width]
        share = smooth_disc(channels, 14, 2)
        z = 3 * share
        for at_x, at_y in ((6, 8.4), (40.3, 4), (90.5, 30.2), (3, 55.7)):
            lamp = numpy.clip(radius - numpy.hypot(x - at_x, y - at_y) + 0.5, 0, 1)
            share, z = share + lamp, z + 30 * lamp
        channels["Z"] = z.astype("f4")
        for name in "RGB":
            channels[name] = share.astype("f4")

    coc = tmp_path / "coc.exr"
    done = rackfocus(
        "filter", scene(size=SIZE, change=change), "-o", tmp_path / "o.exr", *LENS,
        "--output-coc", coc, *PLAIN,
    )  # fmt: skip
    assert "was anti-aliased" in done.stderr
    radii = plainexr.read(coc)[0]["Y"]
    near, lamps, sky = (10 * (1 / 6 - 1 / z) for z in (3, 30, numpy.inf))
    is_near = abs(radii - near) < 0.01
    assert 0.8 < is_near.sum() / (numpy.pi * 14**2) < 1.2
    assert abs(radii[~is_near & (radii < sky - 0.01)] - lamps).max() < 0.3


@pytest.mark.parametrize("far", [100, 1e10])
def test_anti_aliased_by_a_filter_with_negative_lobes(filtered, far):
    """Beside a high step depth is below 0, which is no reason to refuse it."""

    def sharpen(channels):
        share = smooth_disc(channels)
        around = numpy.pad(share, 1, mode="edge")
        blurred = (around[:-2, 1:-1] + around[2:, 1:-1]) / 4
        blurred += (around[1:-1, :-2] + around[1:-1, 2:]) / 4
        mix(share + 0.15 * (share - blurred), far, channels)
        assert (channels["Z"] < 0).sum() > 20

    got, said = filtered(sharpen)
    assert "was anti-aliased" in said
    want, _ = filtered(lambda c: mix(numpy.round(smooth_disc(c)), far, c))
    plain, _ = filtered(lambda c: mix(smooth_disc(c), far, c))
    for name in got:
        assert abs(got[name] - plain[name]).mean() < 5e-4
        assert abs(got[name] - want[name]).mean() < 5e-3


def test_the_nearest_depth_of_a_filter(filtered, seen):
    """Pixels beside a disc in focus that have its depth and show the wall are the wall's."""

    def change(channels, least):
        share = smooth_disc(channels, filter_px=4)
        channels["Z"] = numpy.where(share > least, 6, 20).astype("f4")
        for i, name in enumerate("RGB"):
            channels[name] = (share * 0.2 * i + (1 - share) * 0.6).astype("f4")

    def change_wide(channels):
        change(channels, 0)

    got, said = filtered(change_wide)
    assert "depth was wider than what is seen" in said and "--depth-repair off" in said
    assert seen(change_wide)["widened"] is True
    assert seen(lambda c: change(c, 0.5))["widened"] is False
    want, said = filtered(lambda c: change(c, 0.5))
    assert said == ""
    raw, said = filtered(change_wide, "--depth-repair", "off")
    assert said == ""
    wrong = [sum(abs(a[c] - want[c]).sum() for c in "RGB") for a in (got, raw)]
    # 3.8 and 8.9; 6.7 and 22.5 while what is in focus shared its bin with the wall.
    assert wrong[0] < 5 and wrong[0] < 0.45 * wrong[1]
    nearer, said = filtered(change_wide, "--depth", "inverse")
    assert "wider" not in said and nearer


@pytest.mark.parametrize("limit", [[], ["--max-memory", "150"]])
def test_holes_of_fog(rackfocus, scene, tmp_path, limit):
    """Scattered pixels without depth get that of their surface, in every view, and in
    windows with the bits of the whole; other files of the frame say how wrong it was.
    """
    size = (300, 1101)

    def make(name, x, has_fog):
        rng = numpy.random.default_rng(7 + has_fog * round(100 * x))

        def change(channels):
            share = numpy.round(smooth_disc(channels, 100))
            mix(share, 12, channels)
            for i, colour in enumerate("RGB"):
                channels[colour] = (0.2 * i + 0.3 * share).astype("f4")
            if has_fog:
                channels["Z"][rng.random(share.shape) < 0.4] = 1e10

        facts = {"rackfocus:lensOffset": (x, 0.0)}
        return scene(name, size, attributes=facts, change=change)

    for places in ((0.0,), (-0.05, 0.05)):
        clear = [make(f"clear{x}.exr", x, False) for x in places]
        foggy = [make(f"foggy{x}.exr", x, True) for x in places]
        made, said = {}, {}
        for name, paths, words in (
            ("want", clear, limit),
            ("got", foggy, limit),
            ("whole", foggy, []),
            ("raw", foggy, ["--depth-repair", "off"]),
        ):
            out = tmp_path / f"{name}.exr"
            done = rackfocus("filter", *paths, "-o", out, *LENS, *PLAIN, *words)
            made[name], said[name] = plainexr.read(out)[0], done.stderr
        assert "scattered as fog" in said["got"]
        assert "--depth-repair off" in said["got"]
        # The two views are one picture, which is told where no windows are.
        assert all(" same render" in line for line in said["want"].splitlines())
        assert "fog" not in said["raw"]
        assert difference(made["got"], made["whole"]) == 0
        wrong = [
            sum(abs(made[name][c] - made["want"][c]).sum() for c in "RGB")
            for name in ("got", "raw")
        ]
        assert wrong[0] < 0.1 * wrong[1]


def test_info_tells_fog(seen):
    def fog(channels):
        rng = numpy.random.default_rng(1)
        channels["Z"][rng.random(channels["Z"].shape) < 0.3] = 1e10
        for name in "RGB":
            channels[name] = smooth_disc(channels)

    assert seen(fog)["speckled"] is True and seen(None)["speckled"] is False


@pytest.mark.parametrize("kind", ["normalised", "buffer", "buffer-reversed"])
def test_what_is_no_distance_is_refused(filtered, seen, kind):
    def remap(channels):
        z = channels["Z"]
        if kind == "normalised":
            channels["Z"] = (z - 3) / 9
        else:
            v = (100 / z - 100 / 0.1) / (1 - 100 / 0.1)  # near 0.1, far 100
            channels["Z"] = v if kind == "buffer" else numpy.where(z > 5, 0, 1 - v)

    _, said = filtered(remap, code=1)
    assert f"say --depth {kind}" in said and "passes.exr" in said
    assert f"--depth {kind}" in seen(remap)["refused"]
    filtered(remap, "--depth", kind, "--depth-near", "0.1", "--depth-far", "100")
    filtered(remap, "--depth", "planar")
    filtered(remap, "--depth-repair", "off")


@pytest.mark.parametrize(
    "falloff, power", [("linear", 1), ("quadratic", 2), ("inverse-quadratic", 0.5)]
)
def test_mist(filtered, seen, falloff, power):
    """Blender's Mist pass: refused without its range, and exact with it."""

    def mist(channels):
        t = numpy.clip((channels.pop("Z") - 2) / 20, 0, 1)
        channels["ViewLayer.Mist.Z"] = (t**power).astype("f4")

    _, said = filtered(mist, code=1)
    assert "Blender's Mist pass" in said and "--mist-falloff" in said
    assert seen(mist)["mist"] is True
    lens = ["--depth", "normalised", "--depth-near", "2", "--depth-far", "22"]
    got, said = filtered(mist, *lens, "--mist-falloff", falloff)
    want, _ = filtered(None)
    assert said == ""
    assert difference(got, want) < 1e-3


def test_half_with_banding(filtered, seen):
    """A plane far away under a strong lens: 16 bit are coarse, and that is said."""

    def to_half(channels, factor=1.0):
        height, width = channels["Z"].shape
        z = numpy.linspace(4, 40, width)[None].repeat(height, 0) * factor
        channels["Z"] = z.astype("f2")

    lens = ["--lens-radius", "30", "--max-radius", "900"]
    _, said = filtered(to_half, *lens)
    assert said.count("the depth is 16 bit, radii come in steps of up to") == 1
    _, said = filtered(to_half)
    assert said == ""
    assert seen(to_half)["half"] is True and seen(None)["half"] is False
    z = 4.0
    step = 3000 * (1 / z - 1 / (z * (1 + 1 / 1024)))
    assert f"{step:.1f} px" in filtered(to_half, *lens)[1]


def test_missing_in_places(filtered, seen):
    """NaN is refused with its place and count; 0 is nothing hit, and info counts it."""

    def holes(value):
        def change(channels):
            channels["Z"][10:14, 20:25] = value

        return change

    _, said = filtered(holes(numpy.nan), code=1)
    assert "20 bad depth values" in said and "(20, 10)" in said
    _, said = filtered(holes(-1), code=1)
    assert "20 bad depth values" in said
    found = seen(holes(0))
    assert found["zero_share"] == pytest.approx(20 / (SIZE[0] * SIZE[1]))
    zero, _ = filtered(holes(0))
    infinite, _ = filtered(holes(numpy.inf))
    assert difference(zero, infinite) == 0


@pytest.mark.parametrize("limit", [[], ["--max-memory", "150"]])
def test_depth_of_several_views(rackfocus, scene, tmp_path, limit):
    """What is seen in the first view's depth is undone in all of them."""
    size = (300, 1101)

    def make(name, x, is_mixed):
        def change(channels):
            share = smooth_disc(channels, 100)
            mix(share if is_mixed else numpy.round(share), 12, channels)
            for i, colour in enumerate("RGB"):
                channels[colour] = (0.2 * i + 0.3 * share).astype("f4")

        facts = {"rackfocus:lensOffset": (x, 0.0)}
        return scene(name, size, attributes=facts, change=change)

    pictures = []
    for is_mixed in (False, True):
        paths = [make(f"{is_mixed}{x}.exr", x, is_mixed) for x in (-0.05, 0.05)]
        out = tmp_path / f"{is_mixed}.exr"
        done = rackfocus("filter", *paths, "-o", out, *LENS, *PLAIN, *limit)
        assert ("was anti-aliased" in done.stderr) == is_mixed
        pictures.append(plainexr.read(out)[0])
    raw = tmp_path / "raw.exr"
    rackfocus("filter", *paths, "-o", raw, *LENS, *PLAIN, "--depth-repair", "off")
    as_it_is = difference(pictures[0], plainexr.read(raw)[0])
    assert as_it_is > 0.02 and difference(*pictures) < 0.1 * as_it_is


def test_small_numbers_are_doubted(filtered, seen):
    """All below 1 and no end of it reached: a small scene, or V-Ray's ZDepth, or 1/z."""

    def within(channels):
        channels["Z"] = channels["Z"] / 50

    _, said = filtered(within)
    assert said.count("taken for distances; normalised and inverse depth may") == 1
    assert "--depth planar" in said and "0.06 to 0.24" in said
    uncut = "--max-radius", "16384", "--depth-scale", "1"
    assert filtered(within, "--depth", "planar", *uncut)[1] == ""
    assert filtered(within, "--depth", "inverse", *uncut)[1] == ""
    _, said = filtered(within, "--strict", code=1)
    assert "taken for distances" in said


@pytest.mark.parametrize("sky, doubt", [(0, "refused"), (1e10, None)])
def test_inverse_depth_of_near_things(filtered, sky, doubt):
    """1 / distance is above 1 for what is nearer than 1; the rest tells."""

    def inverse(channels):
        z = channels["Z"] / 6
        channels["Z"] = numpy.where(z < 1, 1 / z, 1 / (4 * z)).astype("f4")
        channels["Z"][:5] = sky

    if doubt is None:
        assert filtered(inverse, "--max-radius", "16384")[1] == ""
        return
    _, said = filtered(inverse, code=1)
    assert "like 1 / distance" in said and "say --depth inverse" in said
    assert "--depth buffer-reversed-infinite with --depth-near" in said
    filtered(inverse, "--depth", "inverse")


def test_zero_where_nothing_was_hit_is_planar(filtered, seen):
    def holes(channels):
        channels["Z"][:5] = 0

    assert seen(holes)["guess"] == "planar"
    assert filtered(holes)[1] == ""


def test_negative_depth(filtered, seen):
    """Camera space looks along -z in many programs."""

    def negate(channels):
        channels["Z"] = -channels["Z"]

    _, said = filtered(negate, code=1)
    assert "say --depth-scale -1" in said
    assert "--depth-scale -1" in seen(negate)["refused"]
    got, said = filtered(negate, "--depth-scale", "-1")
    assert said == "" and difference(got, filtered(None)[0]) == 0


def renamed(*names):
    def change(channels):
        z = channels.pop("Z")
        for i, name in enumerate(names):
            channels[name] = (z + i).astype("f4")

    return change


@pytest.mark.parametrize(
    "names, want, other",
    [
        (("Z", "depth.Z"), "Z", "depth.Z"),
        (("Depth.R", "ZDepth.R"), "Depth.R", "ZDepth.R"),
        (("VRayZDepth.R", "Depth.Y"), "Depth.Y", "VRayZDepth.R"),
        (("Z", "depth"), "Z", "depth"),
        (("Z", "ZDepth.R"), "Z", "ZDepth.R"),
        (("Z", "z"), "Z", "z"),
        (("ZDepth", "depth"), "ZDepth", "depth"),
    ],
)
def test_two_depths_that_fit_as_well(filtered, names, want, other):
    _, said = filtered(renamed(*names))
    assert f"taken from {want}, but {other} may be meant" in said
    assert filtered(renamed(*names), "--depth-channel", want)[1] == ""
    assert filtered(renamed(*names), "--depth-channel", other)[1] == ""


@pytest.mark.parametrize(
    "name",
    ["VRayZDepth_Invert.R", "inverse_depth.Z", "disparity.Z", "depthNormalized.R"],
)
def test_names_of_other_numbers(filtered, name):
    _, said = filtered(renamed(name))
    assert f"the name of its channel, {name}, says" in said
    assert filtered(renamed(name), "--depth", "planar")[1] == ""


def test_distances_along_the_ray(filtered):
    """Mitsuba's: LAYER.T of any layer."""
    planar, said = filtered(renamed("aov.T"))
    assert "aov.T" in said and "say --depth radial" in said
    radial, said = filtered(renamed("aov.T"), "--depth", "radial")
    assert said == "" and difference(planar, radial) > 0.001
    assert filtered(renamed("aov.T"), "--depth", "planar")[1] == ""


def test_a_position_of_an_unknown_space(filtered):
    """pbrt's are in the camera's space unless the scene says otherwise."""

    def position(channels):
        channels["Pz"] = channels.pop("Z")

    def position_whole(channels):
        position(channels)
        channels["Px"] = channels["Py"] = channels["Pz"] * 0

    assert filtered(position)[1] == ""
    assert "third number of a position" in filtered(position_whole)[1]
    assert filtered(position_whole, "--depth", "planar")[1] == ""


NORMALISED = ["--depth", "normalised", "--depth-near", "2", "--depth-far", "12"]


def test_normalised_depth_that_goes_on_beyond_its_end(filtered, rackfocus, scene):
    """Unclamped depth is not sky: what to type gives the picture of the distances."""

    def normalise(channels):
        z = channels["Z"]
        z[:] = numpy.linspace(3, 32, z.shape[1])
        channels["Z"] = (z - 2) / 10

    def distances(channels):
        normalise(channels)
        channels["Z"] = 2 + 10 * channels["Z"]

    _, said = filtered(normalise, *NORMALISED, code=1)
    assert "goes on beyond 1 in 68.8 % of the pixels, up to 3," in said
    typed = ["--depth-far", "102", "--depth-scale", "0.1"]
    assert "say " + " ".join(typed) in said
    got, said = filtered(normalise, *NORMALISED, *typed)
    want, _ = filtered(distances)
    assert "beyond" not in said and difference(got, want) < 1e-4
    path = scene(size=SIZE, change=normalise)
    info = json.loads(rackfocus("info", path, "--json", *NORMALISED).stdout)["depth"]
    assert "goes on beyond 1" in info["refused"]
    assert info["no_hit_share"] == pytest.approx(66 / 96)


def test_normalised_depth_with_specks_beyond_its_end(filtered):
    """An overshoot of a pixel filter is warned of, rounding is not."""

    def change(channels, most):
        channels["Z"] = numpy.clip((channels["Z"] - 2) / 10, 0, 1).astype("f4")
        channels["Z"][3, 4:9] = most

    _, said = filtered(lambda c: change(c, 1.0625), *NORMALISED)
    assert "is above 1 in 5 pixels, up to 1.062" in said and "--depth-scale 0.1" in said
    for most in (1 + 1e-6, 1e10, numpy.inf):
        assert filtered(lambda c, most=most: change(c, most), *NORMALISED)[1] == ""


def slope(channels, low, high, kind="f4"):
    z = channels["Z"]
    z[:] = numpy.linspace(low, high, z.shape[1]).round()
    channels["Z"] = z.astype(kind)


@pytest.mark.parametrize("kind", ["f2", "f4"])
def test_whole_numbers_of_8_bit(filtered, rackfocus, scene, kind):
    def change(channels):
        slope(channels, 0, 255, kind)

    lens = ["--focus-distance", "100"]
    _, said = filtered(change, *lens)
    assert "holds whole numbers from 0 to 255, as maps of 8 bit do" in said
    assert "--depth normalised --depth-scale 0.00392157" in said
    for sure in (["--depth", "planar"], ["--depth-scale", "1"]):
        assert filtered(change, *lens, *sure)[1] == ""
    typed = [*NORMALISED, "--depth-scale", "0.00392157"]
    assert filtered(change, *typed)[1] == ""
    path = scene(size=SIZE, change=change)
    assert "filter warns" in rackfocus("info", path, *lens).stdout


def test_whole_numbers_of_16_bit(filtered):
    lens = ["--focus-distance", "9000"]
    _, said = filtered(lambda c: slope(c, 0, 65535), *lens)
    assert "as maps of 16 bit do" in said and "--depth-scale 1.5259e-05" in said
    # Depth cameras count millimetres; half floats are whole where they are large.
    for low, high, kind in ((500, 9000, "f4"), (2050, 60000, "f2"), (2, 8, "f4")):
        _, said = filtered(lambda c, a=(low, high, kind): slope(c, *a), *lens)
        assert "whole numbers" not in said


@pytest.mark.parametrize("other", ["depth", "depth.Z", "ZDepth.R"])
def test_copies_of_the_depth_are_no_rivals(filtered, other):
    """Equal to rounding; or for viewing, under a less usual name."""

    def add(channels, copy):
        channels[other] = copy(channels["Z"])

    for copy in (lambda z: z.copy(), lambda z: (z * 1.0003).astype("f2")):
        assert filtered(lambda c, copy=copy: add(c, copy))[1] == ""
    _, said = filtered(lambda c: add(c, lambda z: z / 12))
    assert (said == "") is (other != "depth.Z")
    _, said = filtered(lambda c: add(c, lambda z: z + (z == 3) * 0.01))
    assert f"taken from Z, but {other} may be meant as well" in said


@pytest.mark.parametrize(
    "name", ["depth_id", "depth_variance.Y", "depth_variance.Z", "depthMask.R"]
)
def test_what_is_told_of_a_depth_is_none(filtered, name):
    _, said = filtered(renamed(name), code=1)
    assert "no depth channel" in said and name in said and "--depth-channel" in said
    _, said = filtered(renamed("worldDepth", name))
    assert said == ""


@pytest.mark.parametrize(
    "name", ["hitPz", "hitPz.R", "hitPz.Y", "hitPz.V", "ray:hitPz"]
)
def test_karmas_depth(filtered, name):
    want, _ = filtered(None)
    for names in ([name], [name, "hitdist"]):
        got, said = filtered(renamed(*names))
        assert said == "" and difference(got, want) == 0


@pytest.mark.parametrize("name", ["ray:hitdist", "distance", "Distance.R"])
def test_distances_along_the_ray(filtered, name):
    """Karma's and Iray's."""
    _, said = filtered(renamed(name))
    assert f"{name}, taken for" in said and "--depth radial" in said
    assert filtered(renamed(name), "--depth", "radial")[1] == ""


def test_a_vector_that_was_hit_is_no_depth(filtered):
    _, said = filtered(renamed("hitPz.x", "hitPz.y", "hitPz.z"), code=1)
    assert "no depth channel" in said


def sky(value, factor=1):
    def change(channels):
        z = channels["Z"] * numpy.float32(factor)
        z[:9] = value
        channels["Z"] = z.astype("f4")

    return change


@pytest.mark.parametrize("value", [0, 1e10, numpy.inf])
def test_negative_depth_with_a_sky(filtered, value):
    """Whatever means that nothing was hit means it of turned numbers, too."""
    assert "--depth-scale -1" in filtered(sky(value, -1), code=1)[1]
    got, said = filtered(sky(value, -1), "--depth-scale", "-1")
    want, _ = filtered(sky(numpy.inf))
    assert said == "" and difference(got, want) == 0


@pytest.mark.parametrize(
    "value, factor, steps",
    [
        (numpy.nan, 1, "--ch Z --fixnan black -d float"),
        (-1, 1, "--ch Z --maxc 0 -d float"),
        (-numpy.inf, 1, "--ch Z --maxc 0 -d float"),
        (7, -1, "--ch Z --mulc -1 --maxc 0 -d float"),
    ],
)
def test_a_sky_that_is_refused_has_a_way_out(
    filtered, rackfocus, scene, tmp_path, value, factor, steps
):
    """The command that is named gives the picture of an infinite sky."""
    scale = ["--depth-scale", str(factor)]
    _, said = filtered(sky(value, factor), *scale, code=1)
    path = scene(size=SIZE, change=sky(value, factor))
    named = f"oiiotool {path} {steps} -o depth.exr, and say --depth-file depth.exr"
    assert "864 bad depth values" in said and named in said
    depth = scene("depth.exr", size=SIZE, change=sky(0))
    got, _ = filtered(sky(value, factor), "--depth-file", depth)
    assert difference(got, filtered(sky(numpy.inf))[0]) == 0
    path = scene(size=SIZE, change=sky(value, factor))
    for command in ("info", path), ("focus", path, "4,2"):
        done = rackfocus(*command, *scale, code=int(command[0] == "focus"))
        assert steps in done.stdout + done.stderr


def test_several_bad_numbers_have_no_such_way_out(filtered):
    def change(channels):
        channels["Z"][3, 4:6] = -1, -2

    assert "oiiotool" not in filtered(change, code=1)[1]


def test_a_reversed_infinite_buffer_is_named(filtered):
    """near / distance, and 0 for the sky: what to type gives the picture."""

    def reverse(channels):
        sky(numpy.inf)(channels)
        channels["Z"] = numpy.float32(0.5) / channels["Z"]

    _, said = filtered(reverse, code=1)
    assert "--depth buffer-reversed-infinite with --depth-near" in said
    got, said = filtered(
        reverse, "--depth", "buffer-reversed-infinite", "--depth-near", "0.5"
    )
    assert said == "" and difference(got, filtered(sky(numpy.inf))[0]) < 1e-5


def test_a_depth_file_of_equal_colours(filtered, scene, rackfocus):
    """LuxCore's DEPTH: three times one number."""

    def triple(channels):
        z = channels.pop("Z")
        for name in "RGB":
            channels[name] = z.copy()

    def differ(channels):
        triple(channels)
        channels["G"][5, 3] += 1

    def round_off(channels):
        """As Mitsuba's films of colours do, of half floats."""
        triple(channels)
        channels["G"] = numpy.nextafter(channels["R"].astype("f2"), numpy.float16(99))

    def bare(channels):
        del channels["Z"]

    want, _ = filtered(None)
    got, said = filtered(
        bare, "--depth-file", scene("nearly.exr", size=SIZE, change=round_off)
    )
    assert difference(got, want) == 0 and "taken from R" in said
    grey = scene("grey.exr", size=SIZE, change=triple)
    got, said = filtered(bare, "--depth-file", grey)
    assert difference(got, want) == 0
    assert "grey.exr: the depth is taken from R of a picture whose red" in said
    got, said = filtered(bare, "--depth-file", grey, "--depth-channel", "R")
    assert said == "" and difference(got, want) == 0
    colour = scene("colour.exr", size=SIZE, change=bare)
    done = rackfocus("focus", colour, "48,32", "--depth-file", grey)
    assert "--focus-distance 3" in done.stdout and "taken from R" in done.stderr
    assert "taken from R" in rackfocus("info", colour, "--depth-file", grey).stdout
    other = scene("other.exr", size=SIZE, change=differ)
    _, said = filtered(bare, "--depth-file", other, code=1)
    assert "(--depth-channel R if the picture is it)" in said


@pytest.mark.parametrize(
    "first, says",
    [
        (b"Pf\n4 2\n-1.0\n", "is a PFM file"),
        (b"\x93NUMPY\x01\x00", "is a NumPy array"),
        (b"PIEH\x04\x00\x00\x00", "is a depth file of Middlebury's"),
        (b"II*\x00\x08\x00\x00\x00", "is a TIFF file"),
    ],
)
def test_depth_in_other_files(filtered, tmp_path, first, says):
    path = tmp_path / "depth.dat"
    path.write_bytes(first + bytes(100))
    _, said = filtered(None, "--depth-file", path, code=1)
    assert says in said
    assert "oiiotool FILE -d float -o" in said or "'Depth in other files'" in said
