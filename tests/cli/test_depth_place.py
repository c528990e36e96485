# SPDX-License-Identifier: Apache-2.0
"""A depth that does not lie on its picture: told with the way to turn or move it."""

import numpy
import plainexr
import pytest

LENS = ["--focus-distance", "5", "--lens-radius", "0.05", "--focal-length-px", "200"]
TURNS = {
    "upside down": ("--flip", lambda a: a[::-1]),
    "mirrored": ("--flop", lambda a: a[:, ::-1]),
    "upside down and mirrored": ("--rotate180", lambda a: a[::-1, ::-1]),
}


@pytest.fixture
def passes():
    """Stones on the ground before a wall, with grain; colours and depth."""
    width, height = 200, 140
    y, x = numpy.mgrid[0:height, 0:width] + 0.5
    random = numpy.random.default_rng(5)
    z = numpy.where(y > 60, 12 * 60 / (y + 40), 8)
    colour = numpy.stack([0.3 + 0.2 * numpy.sin(x / 3 + i) for i in range(3)])
    for _ in range(40):
        at, radius = random.uniform(0, 1, 2) * (width, height), random.uniform(5, 12)
        is_inside = numpy.hypot(x - at[0], y - at[1]) < radius
        z[is_inside] = random.uniform(2, 6)
        colour[:, is_inside] = random.uniform(0.05, 1, 3)[:, None]
    colour *= numpy.exp(0.1 * random.standard_normal(colour.shape))
    return dict(zip("RGB", colour.astype("f4"), strict=True)), z.astype("f4")


@pytest.fixture
def told(rackfocus, tmp_path):
    def run(channels, *options, code=0):
        path = plainexr.write(tmp_path / "in.exr", channels)
        out = tmp_path / "o.exr"
        return rackfocus("filter", path, "-o", out, *LENS, *options, code=code).stderr

    return run


@pytest.mark.parametrize("how", TURNS)
def test_turned_depth(told, passes, how):
    colour, z = passes
    option, turn = TURNS[how]
    said = told(colour | {"Z": turn(z)})
    assert f"in.exr: the depth lies {how}: of its steps " in said
    assert f"in.exr {option} -d float -o depth.exr" in said
    assert said.count("warning") == 1
    told(colour | {"Z": turn(z)}, "--strict", code=1)


@pytest.fixture
def told_of_parts(rackfocus, tmp_path):
    """What filter says of a file whose colour and depth are parts of their own."""

    def run(colour, z, code=0):
        oiio = pytest.importorskip("OpenImageIO")
        path, specs = tmp_path / "in.exr", []
        for name, channels in (("rgba", tuple(colour)), ("depth", ("Z",))):
            specs.append(oiio.ImageSpec(*z.shape[::-1], len(channels), oiio.FLOAT))
            specs[-1].channelnames = channels
            specs[-1]["oiio:subimagename"] = name
        file = oiio.ImageOutput.create(str(path))
        assert file.open(str(path), tuple(specs)), file.geterror()
        assert file.write_image(numpy.dstack(list(colour.values())))
        assert file.open(str(path), specs[1], "AppendSubimage"), file.geterror()
        assert file.write_image(numpy.dstack([z])) and file.close()
        arguments = [path, "-o", tmp_path / "o.exr", *LENS]
        return rackfocus("filter", *arguments, code=code).stderr

    return run


def test_the_commands_name_the_part(told_of_parts, passes):
    """oiiotool looks at the first part else, which is that of the colour."""
    colour, z = passes
    said = told_of_parts(colour, z[::-1])
    assert "in.exr --subimage 1 --flip -d float -o depth.exr" in said
    said = told_of_parts(colour, numpy.roll(z, (2, -3), (0, 1)))
    assert "in.exr --subimage 1 --cshift +3-2 -d float -o depth.exr" in said
    holes = numpy.where(z == z.max(), numpy.nan, z).astype("f4")
    said = told_of_parts(colour, holes, code=1)
    assert "in.exr --subimage 1 --ch Z --fixnan black -d float -o depth.exr" in said
    broken = colour | {"R": numpy.where(z == z.max(), numpy.inf, colour["R"])}
    said = told_of_parts(broken, z, code=1)
    assert "in.exr --subimage 0 --ch R,G,B --fixnan box3 -o colour.exr, and" in said


@pytest.mark.parametrize(
    "down, right, words",
    [
        (0, 1, "1 px to the right"),
        (-1, 0, "1 px above"),
        (2, -3, "3 px to the left, 2 px below"),
        (8, 8, "8 px to the right, 8 px below"),
    ],
)
def test_moved_depth(told, passes, down, right, words):
    colour, z = passes
    said = told(colour | {"Z": numpy.roll(z, (down, right), (0, 1))})
    assert f"in.exr: the depth lies beside the picture, {words}: of its steps " in said
    assert f"in.exr --cshift {-right:+}{-down:+} -d float -o depth.exr" in said
    assert said.count("warning") == 1


def test_wide_depth_is_not_moved(told):
    """What reaches over the right sides of boards, and over one left side in six; or
    boards whose left sides nobody sees."""
    y, x = numpy.mgrid[0:140, 0:200]
    for is_seen in (y < 24, y < 0):
        start = numpy.where(is_seen, 10, 0)
        across = x % 40
        is_board = (across >= start) & (across < 20)
        is_wide = (across >= start - is_seen) & (across < 21)
        z = numpy.where(is_wide, 3, 8 - 5 * (across / 40) ** 8 * ~is_seen)
        colour = dict.fromkeys("RGB", (0.2 + 0.6 * is_board).astype("f4"))
        inverse = {"Z": (1 / z).astype("f4")}  # which is not mended
        assert "the depth lies" not in told(colour | inverse, "--depth", "inverse")


@pytest.mark.parametrize(
    "times, size", [(1.25, "160 x 112"), (2, "100 x 70"), (3.2, "63 x 44")]
)
def test_enlarged_depth(told, passes, times, size):
    """Of slanted surfaces, as nearly all are."""
    colour, z = passes
    y, x = numpy.mgrid[0:140, 0:200]
    z = z * (1 + x / 1000 + y / 1000)
    small = z[(y / times).astype(int), (x / times).astype(int)].astype("f4")
    for options in ([], ["--max-memory", "60"]):
        said = told(colour | {"Z": small}, "--depth", "planar", *options)
        assert f"in.exr: the depth was rendered in about {size} and enlarged" in said
        assert said.count("warning") == 1


def test_what_is_not_enlarged(told, passes):
    """Boards at every fourth column, and what is enlarged along one direction."""
    colour, z = passes
    y, x = numpy.mgrid[0:140, 0:200]
    boards = numpy.where(x % 8 < 4, 3, 8) + 0 * y
    for other in (boards.astype("f4"), z[:, numpy.arange(200) // 2]):
        assert "enlarged" not in told(colour | {"Z": other})


@pytest.mark.parametrize("kind", ["planar", "inverse", "normalised"])
def test_it_is_told_of_any_kind(told, passes, kind):
    colour, z = passes
    numbers = {"planar": z, "inverse": 1 / z, "normalised": (z - 1) / 14}[kind]
    options = ["--depth", kind, "--depth-near", "1", "--depth-far", "15"]
    options = options if kind == "normalised" else options[:2]
    assert "lies upside down" in told(colour | {"Z": numbers[::-1]}, *options)
    assert "the depth lies" not in told(colour | {"Z": numbers}, *options)


def test_what_lies_right_is_not_told(told, passes):
    """Nor a scene that is the same from both sides, nor a few steps."""
    colour, z = passes
    assert told(colour | {"Z": z}) == ""
    both = {n: numpy.vstack([v, v[::-1]]) for n, v in colour.items()}
    assert told(both | {"Z": numpy.vstack([z, z[::-1]])}) == ""
    shaded = {n: v.copy() for n, v in both.items()}  # upside down fits a little better
    for v in shaded.values():
        v[:140, :40] = 0.01
    assert told(shaded | {"Z": numpy.vstack([z, 0 * z + 8])}) == ""
    few = numpy.where(numpy.arange(200) < 60, 3, 8) + 0 * z
    assert "the depth lies" not in told(colour | {"Z": few.astype("f4")})


def test_a_grey_picture(told, passes):
    colour, z = passes
    assert "lies upside down" in told({"Y": colour["G"], "Z": z[::-1]})
