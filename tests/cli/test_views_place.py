# SPDX-License-Identifier: Apache-2.0
"""Views whose headers say another place than that which they were taken from."""

import numpy
import plainexr
import pytest

FOCAL, FOCUS, RADIUS = 90.0, 4.0, 0.3
PLACES = [(0.0, 0.0), (0.15, 0.1), (-0.2, 0.12), (0.05, -0.22)]
LENS = {
    "rackfocus:lensRadius": RADIUS,
    "rackfocus:focalLengthPx": FOCAL,
    "rackfocus:focusDistance": FOCUS,
}


def make(path, taken, said, shear=FOCUS, said_shear=FOCUS):
    """Discs at distances of 2 and 3 before a wall, seen from a point of the lens."""
    random = numpy.random.default_rng(5)
    y, x = numpy.mgrid[0:80, 0:120] + 0.5
    depth, grey = numpy.full(x.shape, 8.0), 0.5 + 0.3 * numpy.sin(x)
    for z in numpy.repeat([3, 2], 7):
        times = FOCAL * ((1 / shear if shear else 0) - 1 / z)
        at_x, at_y = random.uniform(0, 1, 2) * (120, 80) + times * numpy.array(
            [taken[0], -taken[1]]
        )
        is_disc = numpy.hypot(x - at_x, y - at_y) < 7
        depth[is_disc], grey[is_disc] = z, random.uniform()
    channels = dict.fromkeys("RGB", grey.astype("f4")) | {"Z": depth.astype("f4")}
    place = {"rackfocus:lensOffset": said}
    if said_shear:
        place["rackfocus:shearDistance"] = said_shear
    return plainexr.write(path, channels, LENS | place)


@pytest.fixture
def said(rackfocus, tmp_path):
    """What filter says of views; `change` makes the header's place of the true one."""

    def run(change=lambda i, place: place, take=lambda place: place, **shears):
        paths = [
            make(tmp_path / f"v{i}.exr", take(place), change(i, place), **shears)
            for i, place in enumerate(PLACES)
        ]
        return rackfocus("filter", *paths, "-o", tmp_path / "o.exr").stderr

    return run


def test_views_at_their_places_are_taken_in_silence(said):
    assert "elsewhere" not in said()
    assert "elsewhere" not in said(shear=0, said_shear=0)


@pytest.mark.parametrize(
    "change, text",
    [
        (lambda x, y: (-x, y), "x of rackfocus:lensOffset had the other sign"),
        (lambda x, y: (x, -y), "y of rackfocus:lensOffset had the other sign"),
        (lambda x, y: (-x, -y), "both numbers"),
        (lambda x, y: (y, x), "were swapped"),
        (lambda x, y: (100 * x, 100 * y), "were 0.01 times what it is"),
        (lambda x, y: (x / RADIUS, y / RADIUS), "were 0.3 times what it is"),
        (lambda x, y: (x / 2, y / 2), "were 2 times what it is"),
    ],
)
def test_another_meaning_of_the_places(said, change, text):
    """38.3 dB for 19.5 to 23.3 of posts, in silence."""
    assert text in said(lambda i, place: change(*place))


def test_shears_and_renders_that_are_none(said):
    assert "were sheared to the focus" in said(said_shear=0)
    assert "the cameras were parallel" in said(shear=0)
    assert "they are the same render" in said(take=lambda place: (0, 0))


def test_one_view_that_lies_elsewhere(said):
    text = said(lambda i, place: (-place[0], -place[1]) if i == 2 else place)
    assert "v2.exr: lies elsewhere than its header says" in text
