# SPDX-License-Identifier: Apache-2.0
"""Eight views of a wall behind two layers of leaves, and the lens that they stand for."""

import numpy
import plainexr
import pytest

FINE, WIDTH, HEIGHT = 4, 144, 96  # samples to a pixel along an axis; px
FOCUS, LENS_RADIUS, FOCAL_PX = 2.0, 0.08, 200.0
PARTS = 8
WALL, DEPTHS = 5.0, (1.0, 1.3)
GOLDEN = 2.399963
LENS_POINTS = 400


def radius_px(depth):
    return LENS_RADIUS * FOCAL_PX * (1 / FOCUS - 1 / depth)


def fine(margin, seed, n):
    """Leaves as a mask, `margin` px wider than the picture on each side."""
    random = numpy.random.default_rng(seed)
    size = ((HEIGHT + 2 * margin) * FINE, (WIDTH + 2 * margin) * FINE)
    y, x = numpy.mgrid[: size[0], : size[1]]
    mask = numpy.zeros(size, bool)
    for _ in range(n):
        radius = FINE * random.uniform(2, 4)
        middle = random.uniform(0, size)
        mask |= (y - middle[0]) ** 2 + (x - middle[1]) ** 2 < radius**2
    return mask


class Scene:
    MARGIN = 16

    def __init__(self):
        self.leaves = [fine(self.MARGIN, seed, 260) for seed in (1, 2)]
        y, x = numpy.mgrid[tuple(slice(n) for n in self.leaves[0].shape)] / FINE
        self.wall = numpy.where((numpy.floor(x / 5) + numpy.floor(y / 5)) % 2, 0.8, 0.1)

    def _shifted(self, plane, u, v, depth):
        """A plane as it is seen from (u, v) of the unit lens, in fine samples."""
        shift = radius_px(depth) * FINE
        x = self.MARGIN * FINE - round(u * shift)
        y = self.MARGIN * FINE + round(v * shift)
        return plane[y : y + HEIGHT * FINE, x : x + WIDTH * FINE]

    def seen(self, u, v):
        """(colour of the pixels, depth at their middle) from a point of the lens."""
        colour = self._shifted(self.wall, u, v, WALL)
        depth = numpy.full(colour.shape, WALL)
        for mask, at, grey in zip(self.leaves[::-1], DEPTHS[::-1], (0.5, 0.3)):
            leaves = self._shifted(mask, u, v, at)
            colour = numpy.where(leaves, grey, colour)
            depth = numpy.where(leaves, at, depth)
        boxes = colour.reshape(HEIGHT, FINE, WIDTH, FINE)
        return boxes.mean((1, 3)), depth[FINE // 2 :: FINE, FINE // 2 :: FINE]


def places(n):
    i = numpy.arange(n)
    rho, theta = numpy.sqrt((i + 0.5) / n), GOLDEN * i
    return list(zip(rho * numpy.cos(theta), rho * numpy.sin(theta)))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """(the files of the views, what the lens shows)."""
    scene, folder = Scene(), tmp_path_factory.mktemp("views")
    paths = []
    for i, (u, v) in enumerate(places(PARTS)):
        grey, depth = (plane.astype("f4") for plane in scene.seen(u, v))
        facts = {
            "rackfocus:lensRadius": LENS_RADIUS,
            "rackfocus:focalLengthPx": FOCAL_PX,
            "rackfocus:focusDistance": FOCUS,
            "rackfocus:shearDistance": FOCUS,
            "rackfocus:lensOffset": (u * LENS_RADIUS, v * LENS_RADIUS),
        }
        channels = {"R": grey, "G": grey, "B": grey, "Z": depth}
        paths.append(plainexr.write(folder / f"v{i}.exr", channels, attributes=facts))
    lens = numpy.mean([scene.seen(u, v)[0] for u, v in places(LENS_POINTS)], 0)
    return paths, lens


def test_parts_of_the_lens_look_through_other_gaps(rackfocus, files, tmp_path):
    paths, lens = files
    out, errors, made = tmp_path / "o.exr", {}, {}
    for options in ((), (3,), (5,), (16,)):
        more = ("--sub-apertures", *options) if options else ()
        rackfocus("filter", *paths, "-o", out, "--type", "float", *more)
        made[options] = plainexr.read(out)[0]["R"]
        inside = numpy.s_[12:-12, 12:-12]
        errors[options] = numpy.square(made[options] - lens)[inside].mean()
    print({key: f"{-10 * numpy.log10(e):.2f} dB" for key, e in errors.items()})
    # Three of four, as three of five; two of three.
    assert (made[()] == made[5,]).all()
    assert errors[()] < errors[3,] / 1.1
    assert errors[16,] < errors[()] / 1.1
