# SPDX-License-Identifier: Apache-2.0
"""What is seen in mirrors, by its own depth: Filter.process(seen=), seen_depth()."""

import numpy
import pytest
import rackfocus
from mirror_room import HEIGHT, MIRROR, ROOM, WALL, WIDTH, room

SHEAR = 100.0


def frame(moved=0.0):
    """Colour, depth and the mirror's light from `moved` lens radii to the right."""
    mirror, light = room(moved)
    light = numpy.repeat(light[..., None], 3, axis=2)
    colour = light + numpy.where(mirror, 0.05, 0.2)[..., None]
    depth = numpy.where(mirror, MIRROR, WALL)
    return [a.astype(numpy.float32) for a in (colour, depth, light)]


@pytest.fixture(scope="module")
def lens_filter():
    return rackfocus.Filter(
        WIDTH, HEIGHT, focus_distance=100.0, lens_radius=1.6, focal_length_px=1000
    )


def test_two_views_tell_the_depth(lens_filter):
    colour, depth, light = frame()
    lights = [(light, (0, 0), SHEAR), (frame(0.9)[2], (1.44, 0), SHEAR)]
    found = numpy.empty_like(depth)
    lens_filter.seen_depth(colour, depth, lights, found)
    inner = found[12:52, 34:76]
    assert numpy.isfinite(inner).mean() > 0.95
    assert abs(numpy.nanmedian(inner) / ROOM - 1) < 0.05
    assert numpy.isnan(found[depth == numpy.float32(WALL)]).all()


def test_light_is_blurred_by_its_own_depth(lens_filter):
    colour, depth, light = frame()
    far = numpy.where(depth == numpy.float32(MIRROR), ROOM, numpy.nan)
    plain, own, nowhere = (numpy.empty_like(colour) for _ in range(3))
    lens_filter.process(colour, depth, plain)
    lens_filter.process(colour, depth, own, seen=[(light, far.astype("f4"))])
    lens_filter.process(
        colour, depth, nowhere, seen=[(light, numpy.full_like(depth, numpy.nan))]
    )
    middle = (slice(24, 40), slice(34, 62), 1)
    assert plain[middle].std() > 0.1 and own[middle].std() < plain[middle].std() / 4
    assert numpy.array_equal(nowhere, plain)


def test_each_view_has_lights_of_its_own():
    """Four views without the lights show copies of the room's pattern, with them none."""
    many = rackfocus.Filter(
        *(WIDTH, HEIGHT), method="views", focus_distance=100.0, lens_radius=1.6,
        focal_length_px=1000,
    )  # fmt: skip
    views, seen = [], []
    for moved in (-0.75, -0.25, 0.25, 0.75):
        colour, depth, light = frame(moved)
        far = numpy.where(depth == numpy.float32(MIRROR), ROOM, numpy.nan)
        views.append((colour, depth, (1.6 * moved, 0), SHEAR))
        seen.append([(light, far.astype("f4"))])
    plain, own, nowhere = (numpy.empty_like(views[0][0]) for _ in range(3))
    many.process_views(views, plain)
    many.process_views(views, own, seen=seen)
    many.process_views(views, nowhere, seen=[[]] * 4)
    middle = (slice(24, 40), slice(34, 62), 1)
    assert own[middle].std() < plain[middle].std() / 2
    assert numpy.array_equal(nowhere, plain)
    for wrong in (seen[:3], seen[0], [*seen[:3], []], [*seen[:3], seen[:1]]):
        with pytest.raises((TypeError, ValueError)):
            many.process_views(views, own, seen=wrong)


def test_the_way_of_rays(lens_filter):
    colour, depth, light = frame()
    way = numpy.where(depth == numpy.float32(MIRROR), ROOM, depth).astype("f4")
    lens_filter.seen_way(colour, depth, light, way, way)
    assert abs(way[32, 48] / ROOM - 1) < 0.01 and numpy.isnan(way[2, 2])


def test_what_is_wrong_is_said(lens_filter):
    colour, depth, light = frame()
    out = numpy.empty_like(colour)
    for wrong in (
        (light, depth),
        [light],
        [(light,)],
        [(light, depth, 1)],
        [(light[:9], depth)],
        [(light, depth)] * 5,
    ):
        with pytest.raises((TypeError, ValueError)):
            lens_filter.process(colour, depth, out, seen=wrong)
    one = (light, (0, 0), SHEAR)
    for lights in ([one], [one, one], [light, light], [one] * 65, [one, (light, 0)]):
        with pytest.raises((TypeError, ValueError)):
            lens_filter.seen_depth(colour, depth, lights, numpy.empty_like(depth))
