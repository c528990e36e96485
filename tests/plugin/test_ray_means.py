# SPDX-License-Identifier: Apache-2.0
"""Mean distances: made of Cycles' Denoising Depth, and read at edges."""

import numpy as np
import pytest
import rackfocus

HEIGHT, WIDTH, FOCAL_PX, CLIP = 40, 60, 80, 0.1
LENS = {"focus_distance": 4, "lens_radius": 0.1, "focal_length_px": FOCAL_PX}
EDGE, SHARE = 30, 0.3  # column of mixed pixels, and how much of them is near


def frame(offset=(0, 0), shear=0, aspect=1, clip=CLIP, far=4):
    """Colours, depths, mean distances and mean lengths of rays of a near half."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    near = np.where(x < EDGE, 1, np.where(x < EDGE + 1, SHARE, 0))
    grey = near * 0.4 + (1 - near) * (0.5 + 0.3 * np.sin(y))
    mean = near * 2 + (1 - near) * far
    u, v = (part / shear if shear else 0 for part in offset)
    across = np.hypot(
        (x - WIDTH / 2) / FOCAL_PX - u, (y - HEIGHT / 2) / (FOCAL_PX * aspect) + v
    )
    rays = (mean - clip) * np.sqrt(1 + across**2)
    depth = np.where(near > 0.5, 2, far)
    planes = np.stack([grey] * 3, -1), depth, mean, rays
    return [plane.astype("f4") for plane in planes]


def filtered(made, colour, depth, **more):
    out = np.empty_like(colour)
    made.process(colour, depth, out, **more)
    return out


@pytest.mark.parametrize(
    "offset, shear, aspect", [((0, 0), 0, 1), ((0.4, -0.3), 2.0, 1), ((0, 0), 0, 0.5)]
)
def test_planar_means_of_rays(offset, shear, aspect):
    _, depth, mean, rays = frame(offset, shear, aspect)
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS, pixel_aspect=aspect)
    wide = np.zeros((HEIGHT, 2 * WIDTH), "f4")
    out = wide[:, ::2]  # any strides
    assert made.mean_depth(rays[::-1][::-1], depth, out, offset, shear)
    assert np.allclose(out, mean, rtol=1e-4)
    assert (wide[:, 1::2] == 0).all()


@pytest.mark.parametrize("clip, far", [(1.5, 4), (1.9, 3.6)])
def test_things_nearer_than_twice_the_near_clip(clip, far):
    """Of which the rays are shorter than half of the distance; here the near half, and all."""
    _, depth, mean, rays = frame(clip=clip, far=far)
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS)
    out = np.empty_like(depth)
    assert made.mean_depth(rays, depth, out)
    assert np.allclose(out, mean, rtol=1e-4)


@pytest.mark.parametrize("no_hit", [0, np.finfo("f4").max / 4])  # Blender's from 5.2 on
@pytest.mark.parametrize("is_near", [True, False])
@pytest.mark.parametrize("clip", [CLIP, 1.5])
def test_rays_that_hit_nothing(no_hit, is_near, clip):
    """The near half before a sky, whatever such rays count and the depth sample hit."""
    _, depth, mean, rays = frame(clip=clip)
    mixed = np.s_[:, EDGE]
    depth[:, EDGE:] = 1e10
    depth[mixed] = 2 if is_near else 1e10
    rays[:, EDGE:] = no_hit
    rays[mixed] = SHARE * rays[:, EDGE - 1] + np.float32((1 - SHARE) * no_hit)
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS)
    out = np.empty_like(depth)
    assert made.mean_depth(rays, depth, out)
    assert np.allclose(out[:, :EDGE], 2, rtol=1e-4)
    assert (out[:, EDGE + 1 :] == 0).all()
    assert np.allclose(out[mixed], SHARE * 2, rtol=1e-4)


def test_reflected_rays_that_hit_nothing_are_not_believed():
    _, depth, mean, rays = frame()
    rays[10:20, 5:15] = 0.5 * np.finfo("f4").max / 4
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS)
    out = np.empty_like(depth)
    assert made.mean_depth(rays, depth, out)
    assert np.isnan(out[8:22, 3:17]).all()
    assert np.allclose(out[24:], mean[24:], rtol=1e-4)


def test_the_depth_scale_is_that_of_the_rays():
    _, depth, mean, rays = frame()
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS, depth_scale=0.01, depth_offset=0.5)
    out = np.empty_like(depth)
    assert made.mean_depth(100 * rays, 100 * (depth - 0.5), out)
    assert np.allclose(out, mean, rtol=1e-4)


def test_rays_of_something_else_are_of_no_use():
    _, depth, _, rays = frame()
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS)
    out = np.empty_like(depth)
    assert not made.mean_depth(rays**2, depth, out)
    assert not made.mean_depth(np.full_like(rays, np.nan), depth, out)


def test_they_are_read_at_edges():
    colour, depth, mean, _ = frame()
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS)
    without = filtered(made, colour, depth)
    given = filtered(made, colour, depth, mean_depth=mean)
    assert (given != without).any()
    unknown = np.full_like(mean, np.nan)
    assert (filtered(made, colour, depth, mean_depth=unknown) == without).all()
    assert (filtered(made, colour, depth, mean_depth=None) == without).all()


def test_so_they_are_of_views():
    colour, depth, mean, _ = frame()
    made = rackfocus.Filter(WIDTH, HEIGHT, method="views", **LENS)
    outs = []
    for means in (mean, None):
        views = [rackfocus.View(colour, depth, (0, 0), 0, means)]
        outs.append(np.empty_like(colour))
        made.process_views(views, outs[-1])
    assert (outs[0] != outs[1]).any()
    made.process_views([(colour, depth, (0, 0), 0)], outs[0])
    assert (outs[0] == outs[1]).all()


def test_wrong_sizes_are_refused():
    colour, depth, mean, rays = frame()
    made = rackfocus.Filter(WIDTH, HEIGHT, **LENS)
    with pytest.raises(rackfocus.Error, match="mean_depth"):
        filtered(made, colour, depth, mean_depth=mean[:-1].copy())
    with pytest.raises(ValueError, match=r"must be \(40, 60\)"):
        made.mean_depth(rays[:-1], depth, np.empty_like(depth))
