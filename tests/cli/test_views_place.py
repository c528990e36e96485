# SPDX-License-Identifier: Apache-2.0
"""Views that were taken from another place than they say, or in other light."""

import numpy
import plainexr
import pytest

FOCAL, FOCUS, RADIUS = 90.0, 4.0, 0.3
PLACES = [(0.0, 0.0), (0.15, 0.1), (-0.2, 0.12), (0.05, -0.22)]
ORTHO_PX = 60.0
LENS = {
    "rackfocus:lensRadius": RADIUS,
    "rackfocus:focalLengthPx": FOCAL,
    "rackfocus:focusDistance": FOCUS,
}

ORTHO = LENS | {"rackfocus:projection": "orthographic", "rackfocus:orthoScale": 2.0}


def make(
    path,
    taken,
    said,
    shear=FOCUS,
    said_shear=FOCUS,
    light=1,
    is_ortho=False,
    times=1,
    unit=1,
    moves=True,
):
    """Discs at distances of 2 and 3 before a wall, seen from a point of the lens; of a
    picture `times` as large, from places nearer to its middle. The camera moves there, or
    only its frame does."""
    taken, said = numpy.divide(taken, times**0.5), numpy.divide(said, times**0.5)
    random = numpy.random.default_rng(5)
    y, x = (numpy.mgrid[0 : 80 * times, 0 : 120 * times] + 0.5) / times
    depth, grey = numpy.full(x.shape, 8.0), 0.5 + 0.3 * numpy.sin(x)
    for z in numpy.repeat([3, 2], 7):
        shift = FOCAL * ((1 / shear if shear else 0) - moves / z)
        if is_ortho:
            shift = ORTHO_PX * ((z / shear if shear else 0) - moves)
        at_x, at_y = random.uniform(0, 1, 2) * (120, 80) + shift * numpy.array(
            [taken[0], -taken[1]]
        )
        is_disc = numpy.hypot(x - at_x, y - at_y) < 7
        depth[is_disc], grey[is_disc] = z, random.uniform()
    colour = grey[..., None] * light
    channels = {c: colour[..., i % colour.shape[2]] for i, c in enumerate("RGB")}
    channels = {n: v.astype("f4") for n, v in (channels | {"Z": depth * unit}).items()}
    place = {
        "rackfocus:lensOffset": tuple(said),
        "rackfocus:focalLengthPx": FOCAL * times,
        "rackfocus:lensRadius": RADIUS / times**0.5,
    }
    if said_shear:
        place["rackfocus:shearDistance"] = said_shear
    return plainexr.write(path, channels, (ORTHO if is_ortho else LENS) | place)


@pytest.fixture
def said(rackfocus, tmp_path):
    """What filter says of views; `change` makes the header's place of the true one."""

    def run(
        change=lambda i, place: place,
        take=lambda place: place,
        lights=(1, 1, 1, 1),
        units=(1, 1, 1, 1),
        command=("filter",),
        code=0,
        **how,
    ):
        paths = [
            make(
                tmp_path / f"v{i}.exr",
                take(place),
                change(i, place),
                **{"light": light, "unit": unit, **how},
            )
            for i, (place, light, unit) in enumerate(
                zip(PLACES, lights, units, strict=False)
            )
        ]
        return rackfocus(*command, *paths, "-o", tmp_path / "o.exr", code=code).stderr

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


@pytest.mark.parametrize("is_ortho", [False, True])
def test_cameras_that_did_not_move(said, is_ortho):
    """Of a timeline's marker, which held a scene's camera: 24 dB for 47."""
    assert "sheared and had not moved" in said(moves=False, is_ortho=is_ortho)


def test_one_view_that_lies_elsewhere(said):
    text = said(lambda i, place: (-place[0], -place[1]) if i == 2 else place)
    assert "v2.exr: lies elsewhere than its header says" in text


def test_orthographic_views(said):
    assert "elsewhere" not in said(is_ortho=True)
    assert "y of rackfocus" in said(lambda i, p: (p[0], -p[1]), is_ortho=True)
    assert "0.5 times" in said(lambda i, p: (2 * p[0], 2 * p[1]), is_ortho=True)


def test_views_in_windows(said):
    """Told of a band of rows, before that memory turns out too little for windows."""
    how = {
        "command": ("filter", "--max-memory", "110", "-j", "1"),
        "times": 4,
        "code": 1,
    }
    text = said(**how)
    assert "110 MiB are too few" in text and len(text.splitlines()) == 1
    assert "y of rackfocus:lensOffset" in said(lambda i, p: (p[0], -p[1]), **how)
    assert "v1.exr: is 2 times as bright" in said(lights=(1, 2, 1), **how)


@pytest.mark.parametrize(
    "command", [("filter",), ("filter", "--method", "accumulate"), ("accumulate",)]
)
def test_a_view_of_another_exposure(said, command):
    """38.3 dB for 29.1 of posts, one of eight a stop brighter, in silence."""
    assert "bright" not in said(command=command)
    assert "bright" not in said(command=command, lights=(1, 1.05, 1, 0.95))
    text = said(command=command, lights=(1, 1, 2, 1))
    assert "v2.exr: is 2 times as bright as the other views (+1.00 stops)" in text
    assert "multiply its colour by 0.5," in text
    assert "v0.exr: is 0.5 times" in said(command=command, lights=(0.5, 1, 1, 1))
    assert "v1.exr: is 4 times" in said(command=command, lights=(1, 4))
    text = said(command=command, lights=(1, 2, 2.5, 1, 1))
    assert "v2.exr: is 2.5 times as bright as most views, and 1 more differ" in text
    assert "v3.exr: is black" in said(command=command, lights=(1, 1, 1, 0))
    tint = said(command=command, lights=(1, 1, 1, numpy.array([1.3, 1, 0.8])))
    assert "v3.exr: has 1.3, 1 and 0.8 times the red, green and blue" in tint


def test_a_view_with_depth_of_another_unit(said):
    """Silent of two views, else taken for a view of another place."""
    assert "v1.exr: its depth is 100 times that of the other" in said(units=(1, 100))
    text = said(units=(1, 1, 0.001, 1))
    assert "v2.exr: its depth is 0.001 times" in text and "multiply it by 1e+03" in text
    assert "elsewhere" not in text
