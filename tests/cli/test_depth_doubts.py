# SPDX-License-Identifier: Apache-2.0
"""Depth that can hardly be what it is taken for: in another unit, of another kind, of
another picture. Warned of with what to type, and never where it is right."""

import numpy
import plainexr
import pytest

SIZE = (160, 120)
FOCAL_PX = 150
FOCUS = 3
LENS = ["--lens-radius", "0.05", "--focal-length-px", str(FOCAL_PX)]


def rays():
    """x and y of the pixels' rays (x, y, 1), y down."""
    width, height = SIZE
    y, x = numpy.mgrid[0:height, 0:width]
    return (x + 0.5 - width / 2) / FOCAL_PX, (y + 0.5 - height / 2) / FOCAL_PX


def room():
    """Colour and planar distance: two walls that meet, a floor, posts before them."""
    x, y = rays()
    z = 6 / (1 + 0.9 * abs(x + 0.1))
    floor = y > 0.14
    z[floor] = numpy.minimum(z, 0.8 / numpy.maximum(y, 0.01))[floor]
    colour = 0.3 + 0.1 * numpy.sin(9 * x + 4 * y) * numpy.cos(7 * y)
    for at, wide, distance, light in ((-0.3, 0.05, 2, 0.8), (0.15, 0.08, 3, 0.06)):
        post = (abs(x - at) < wide) & (y > -0.2)
        z[post] = distance
        colour[post] = light
    return colour.astype("f4"), z.astype("f4")


@pytest.fixture
def said(rackfocus, tmp_path):
    """What filter says of a picture."""

    def run(colour, z, *options, focus=FOCUS, name="in.exr", code=0):
        channels = {c: colour for c in "RGB"} | {"Z": z.astype("f4")}
        path = plainexr.write(tmp_path / name, channels)
        arguments = ["--focus-distance", str(focus), *LENS, *options]
        return rackfocus(
            "filter", path, "-o", tmp_path / "o.exr", *arguments, code=code
        ).stderr

    return run


# ---- unit ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "unit,scale", [(100, "0.01"), (1000, "0.001"), (39.37, "0.0254")]
)
def test_a_depth_in_another_unit_than_the_focus(said, unit, scale):
    colour, z = room()
    told = said(colour, z * unit)
    assert "in.exr: nothing is in focus" in told and f"--depth-scale {scale}," in told
    assert "--focus-distance" in told
    assert said(colour, z * unit, "--depth-scale", scale) == ""
    assert said(colour, z * unit, "--depth-scale", "1") == ""
    assert said(colour, z * unit, "-q") == ""
    assert "nothing is in focus" in said(colour, z * unit, "--strict", code=1)


def test_a_depth_below_0_is_doubted_as_one_above(said):
    colour, z = room()
    turned = ["--depth-scale", "-1"]
    assert said(colour, -z, *turned) == ""
    assert "along the ray" in said(colour, -z * ray_length(), *turned)


def test_a_unit_that_nobody_gave(rackfocus, tmp_path):
    """Depth and focus in centimetres: the lens is a hundredth of what is meant."""
    colour, z = room()
    channels = {c: colour for c in "RGB"} | {"Z": (100 * z).astype("f4")}
    path = plainexr.write(tmp_path / "in.exr", channels)
    lens = ["--focal-length", 35, "--sensor-width", 36, "--f-stop", 1]

    def run(*options):
        return rackfocus(
            "filter", path, "-o", tmp_path / "o.exr", *lens, *options
        ).stderr

    told = run("--focus-distance", 300)
    assert "in.exr: next to nothing is blurred, by 0.0" in told
    assert "say --unit-scale 100 where they are centimetres" in told
    for options in (["--unit-scale", 100], ["--unit-scale", 1], ["-q"]):
        assert run("--focus-distance", 300, *options) == ""
    assert "next to nothing" not in run("--focus-distance", 300, "--lens-radius", 0.01)


def test_a_focus_in_another_unit_than_the_depth(said):
    colour, z = room()
    told = said(colour, z, focus=100 * FOCUS)
    assert "the focus is in centimetres" in told and "--depth-scale 100," in told


def test_a_depth_in_another_unit_in_windows(said):
    colour, z = (numpy.kron(v, numpy.ones((8, 10), "f4")) for v in room())
    told = said(colour, z * 100, "--max-memory", "200")
    assert "nothing is in focus" in told


@pytest.mark.parametrize("focus", [0.2, 0.5, 1.2, 3, 20, 60])
def test_what_is_blurred_on_purpose_is_no_mistake(said, focus):
    """A room focused near or far, a wall and a sky behind it."""
    colour, z = room()
    assert said(colour, z, focus=focus) == ""
    wall = numpy.full_like(z, 10)
    assert said(colour, wall, focus=focus) == ""
    sky = numpy.where(z > 4, 1e10, z)
    assert said(colour, sky, focus=focus) == ""


# ---- veils ---------------------------------------------------------------------------


def film(veil, rim=6):
    """Channels of a disc over transparent film whose alpha falls over `rim` px; right of
    it a square of alpha `veil`. Depth only where alpha is above 0.5."""
    width, height = SIZE
    y, x = numpy.mgrid[0:height, 0:width]
    alpha = numpy.clip((30 - numpy.hypot(x - 50, y - 60)) / rim, 0, 1)
    alpha[40:70, 110:140] = veil
    z = numpy.where(alpha > 0.5, 4, 1e10)
    return {c: (0.6 * alpha).astype("f4") for c in "RGB"} | {
        "A": alpha.astype("f4"),
        "Z": z.astype("f4"),
    }


@pytest.mark.parametrize(
    "veil,rim,options,is_told",
    [
        (0.4, 6, [], True),
        (0.4, 6, ["--film-depth", "keep"], False),
        (0.4, 6, ["--depth-repair", "off"], True),
        (0.9, 6, [], False),  # has a depth
        (0, 6, [], False),
        (0, 16, [], False),  # what edges gives a depth
    ],
)
def test_what_lets_see_through_and_has_no_depth(
    rackfocus, tmp_path, veil, rim, options, is_told
):
    path = plainexr.write(tmp_path / "in.exr", film(veil, rim))
    told = rackfocus("filter", path, "-o", tmp_path / "o.exr", "--focus-distance", "4",
                     *LENS, *options).stderr  # fmt: skip
    assert ("in.exr: 5 % of the picture is partly transparent" in told) == is_told, told
    assert is_told or "transparent" not in told


# ---- kind ----------------------------------------------------------------------------


def ray_length():
    x, y = rays()
    return numpy.sqrt(1 + x * x + y * y)


def test_inverse_depth_taken_for_distances(said):
    colour, z = room()
    told = said(colour, 8 / z)
    assert "flat only if it is 1 / distance" in told and "--depth inverse" in told
    assert said(colour, 8 / z, "--depth", "inverse") == ""
    assert said(colour, 8 / z, "--depth", "planar") == ""
    assert said(colour, 8 / z, "--depth-repair", "off") == ""


def test_radial_depth_taken_for_planar(said):
    colour, z = room()
    told = said(colour, z * ray_length())
    assert "those along the ray" in told and "--depth radial" in told
    assert said(colour, z * ray_length(), "--depth", "radial") == ""


NEAR, FAR = 1, 20
ENDS = ["--depth-near", str(NEAR), "--depth-far", str(FAR)]


@pytest.mark.parametrize("is_radial", [False, True])
@pytest.mark.parametrize("is_swapped", [False, True])
def test_which_end_is_near_and_along_what(said, is_swapped, is_radial):
    """Normalised depth of all four ways, taken for the first; what it names mends it."""
    colour, z = room()
    v = ((z * ray_length() if is_radial else z) - NEAR) / (FAR - NEAR)
    v = 1 - v if is_swapped else v
    told = said(colour, v, "--depth", "normalised", *ENDS)
    if not is_swapped and not is_radial:
        assert told == ""
        return
    assert ("and near is at 1, far at 0; say" in told) == is_swapped
    assert ("evenly along the ray" in told) == is_radial
    named = told.partition("; say ")[2].split()
    assert "flat" not in said(colour, v, *named, *([] if is_radial else ENDS))


@pytest.mark.parametrize("kind", ["buffer", "buffer-reversed"])
def test_normalised_depth_taken_for_a_buffer_and_the_other_way(said, kind):
    colour, z = room()
    v = (z - NEAR) / (FAR - NEAR)
    assert "--depth normalised --depth-scale 1" in said(
        colour, v, "--depth", kind, *ENDS
    )
    buffer = FAR * (z - NEAR) / z / (FAR - NEAR)
    told = said(colour, buffer, "--depth", "normalised", *ENDS)
    assert "only if the depth is a z-buffer" in told
    assert said(colour, buffer, "--depth", kind, *ENDS) == ""


def test_numbers_within_0_to_1_name_both_ways(said):
    """What 3ds Max and Corona write, before the kind is said: refused, or warned of."""
    colour, z = room()
    swapped = "where near is white, also --depth-scale -1 --depth-offset 1"
    v = 1 - (z - NEAR) / (FAR - NEAR)
    assert swapped in said(colour, v)
    for number in (v, 0.5 * v):  # crowded near 1, or not
        number[:9] = 0
        told = said(colour, number, code=1)
        assert swapped in told and "--depth buffer with" in told
        assert "--depth normalised with" in told and told.endswith("if they are\n")


def test_ends_that_nobody_gave(said):
    colour, z = room()
    v = (z - NEAR) / (FAR - NEAR)
    told = said(colour, v, "--depth", "normalised")
    assert "taken are depth-near 0.1, depth-far 100; give --depth-near, --dep" in told
    told = said(colour, v, "--depth", "normalised", *ENDS[:2])
    assert "taken are depth-far 100; give --depth-far" in told
    told = said(colour, NEAR / z, "--depth", "buffer-reversed-infinite")
    assert "taken are depth-near 0.1; give --depth-near" in told


def test_the_kind_of_16_bit(rackfocus, tmp_path):
    """Rounding hides the bends of near places, not of those farther apart."""
    colour, z = room()
    v = 1 - (z - NEAR) / (FAR - NEAR)
    normalised = ["--depth", "normalised", *ENDS]
    for depth, options, word in (
        (z, [], ""),
        (z * ray_length(), [], "--depth radial"),
        (8 / z, [], "--depth inverse"),
        (v, normalised, "near is at 1"),
        (v, [*normalised, "--depth-scale", "-1", "--depth-offset", "1"], ""),
    ):
        channels = {c: colour for c in "RGB"} | {"Z": depth.astype("f2")}
        path = plainexr.write(tmp_path / "in.exr", channels)
        arguments = ["--focus-distance", FOCUS, *LENS, *options]
        told = rackfocus("filter", path, "-o", tmp_path / "o.exr", *arguments).stderr
        assert word in told if word else "flat" not in told, (word, told)


@pytest.mark.parametrize("n_levels", [0, 60, 255, 4095])
@pytest.mark.parametrize("grain", [0, 0.001, 0.01])
def test_the_kind_of_right_depth_is_not_doubted(said, n_levels, grain):
    """Exact, in steps, with noise; and an orthographic camera that is named."""
    colour, z = room()
    z = z * (1 + grain * numpy.random.default_rng(1).standard_normal(z.shape))
    if n_levels:
        z = numpy.round(z / z.max() * n_levels) / n_levels * z.max() + 1e-3
    assert "flat" not in said(colour, z)


def test_curved_things_speak_for_no_kind(said):
    x, y = rays()
    colour, _ = room()
    for z in (
        4 - numpy.sqrt(2 - x * x - y * y),
        3 + numpy.sin(3 * x) * numpy.cos(4 * y),
    ):
        assert "flat" not in said(colour, z)


def test_an_orthographic_camera_is_named(said):
    x, y = rays()
    colour, _ = room()
    told = said(colour, 3 + x + y)
    assert "--projection orthographic" in told
    flat = ["--projection", "orthographic", "--ortho-scale", "4"]
    assert "flat" not in said(colour, 3 + x + y, *flat)


@pytest.mark.parametrize(
    "focus, is_sharp", [(FOCUS, True), (FOCUS * 0.3048, False), (90, False)]
)
def test_the_result_says_where_nothing_is_in_focus(
    rackfocus, tmp_path, focus, is_sharp
):
    """As where the depth is in feet: no doubt, for it may be meant, but a fact."""
    colour, z = room()
    z = numpy.where(z < 2, 2, z) if focus < FOCUS else z
    path = plainexr.write(
        tmp_path / "in.exr", {c: colour for c in "RGB"} | {"Z": z.astype("f4")}
    )
    done = rackfocus("filter", path, "-o", tmp_path / "o.exr", *LENS,
                     "--lens-radius", 0.2, "--focus-distance", focus)  # fmt: skip
    assert ("px, nothing in focus, method" in done.stdout) != is_sharp, done.stdout
