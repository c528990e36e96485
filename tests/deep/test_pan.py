# SPDX-License-Identifier: Apache-2.0
"""Temporal stability: how much a slow pan over sharp edges flickers through the filter,
against the lens itself.

The camera moves by an eighth of a pixel (of the plane in focus) per frame. Flicker is
the mean of abs(I(t - 1) - 2 I(t) + I(t + 1)) in gamma 2.2: what is no steady change.
"""

import numpy as np
from deepscene import (
    Camera,
    Layer,
    deep_samples,
    grid,
    oiio,
    read,
    reference,
    trace,
    write_deep,
)

CAMERA = Camera(64, 40, 75, 0.28, 6)
N_FRAMES = 5


def scene(shift):
    """Post, leaf-like discs and a wall of stripes, moved sideways by `shift`."""

    def post(x, y):
        return (np.abs(x + shift + 0.1) < 0.12).astype(float)

    def discs(x, y):
        fx, fy = (x + shift) % 1.5 - 0.75, y % 1.5 - 0.75
        return (fx * fx + fy * fy < 0.15).astype(float)

    def stripes(x, y):
        k = (np.floor((x + shift) * 0.4) % 2)[..., None]
        return np.array([0.05, 0.05, 0.1]) * (1 - k) + np.array([0.9, 0.8, 0.6]) * k

    def paint(*rgb):
        return lambda x, y: np.broadcast_to(np.array(rgb, float), x.shape + (3,))

    return [
        Layer(3, paint(0.9, 0.2, 0.1), post),
        Layer(5, paint(0.2, 0.7, 0.3), discs),
        Layer(14, stripes, lambda x, y: np.ones(x.shape)),
    ]


def pinhole(layers, n_pixel=16):
    """Anti-aliased colour, and the depth of one place in each pixel."""
    colour, _ = trace(CAMERA, layers, *grid(CAMERA, n_pixel), 0, 0)
    px, py = grid(CAMERA, 1)
    fx = (px - CAMERA.width / 2) / CAMERA.focal_px
    fy = (py - CAMERA.height / 2) / CAMERA.focal_px
    depth = np.full(px.shape, np.inf)
    for layer in sorted(layers, key=lambda one: -one.z):
        hit = layer.alpha(fx * layer.z, fy * layer.z) > 0.5
        depth = np.where(hit, layer.z, depth)
    return np.dstack([colour.mean(2), depth[..., 0]]).astype("f4")


def write(path, pixels, attributes=()):
    height, width, _ = pixels.shape
    spec = oiio.ImageSpec(width, height, 4, oiio.FLOAT)
    spec.channelnames = ("R", "G", "B", "Z")
    for attribute in attributes:
        spec.attribute(*attribute)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(pixels)
    output.close()


def flicker(frames):
    t = np.clip(np.stack(frames), 0, 1) ** (1 / 2.2)
    return np.abs(t[:-2] - 2 * t[1:-1] + t[2:]).mean()


def filtered(rackfocus, folder, make):
    for i in range(N_FRAMES):
        make(folder / f"in.{i}.exr", i)
    lens = ["--type", "float", *CAMERA.options()]
    rackfocus("filter", folder / "in.#.exr", "-o", folder / "out.#.exr", *lens)
    return [read(folder / f"out.{i}.exr")[0][..., :3] for i in range(N_FRAMES)]


def test_a_slow_pan_does_not_flicker(rackfocus, tmp_path):
    """Flat frames have one depth per pixel, which jumps from one side of an edge to the
    other; deep ones do not. Both flicker more than the lens, by as much: their figures
    are only kept from growing.
    """
    step = CAMERA.focus / CAMERA.focal_px / 8
    scenes = [scene(i * step) for i in range(N_FRAMES)]
    lens = flicker([reference(CAMERA, s, 48, 4)[..., :3] for s in scenes])
    pinholes = [pinhole(one) for one in scenes]
    flat = filtered(rackfocus, tmp_path, lambda path, i: write(path, pinholes[i]))
    deep = filtered(
        rackfocus,
        tmp_path,
        lambda path, i: write_deep(path, CAMERA, deep_samples(CAMERA, scenes[i], 8)),
    )
    ratios = {
        "deep": flicker(deep) / lens,
        "flat": flicker(flat) / lens,
        "pinhole": flicker([one[..., :3] for one in pinholes]) / lens,
    }
    print("flicker, times the lens's:", ratios)
    assert ratios["deep"] < 2.6
    assert ratios["flat"] < 2.6
    assert ratios["pinhole"] > 1.5
