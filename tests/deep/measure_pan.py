#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Temporal stability as docs/notebook/reliability.md has it: the pan of test_pan.py
without its discs, 17 frames of 64 x 16 px, of which the 8 px at either side are not counted.

    RACKFOCUS=build/cli/rackfocus tests/deep/measure_pan.py

All edges are vertical, so that pixels and lens can be worked out without places or rays:
what flickers is then the filter, not the noise of its input or of the reference. With

  x = (X - u R (1 - z/S)) F/z + w/2     place of a scene's X at depth z from lens point u
  I(x0, x1, u)                          mean of the scene over a pixel, in closed form

the lens is the integral of I over u with the disc's width 2/pi sqrt(1 - u^2) as weight,
by Gauss and Chebyshev's rule.
"""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import test_pan
from deepscene import Camera, grid, lens_points, read, tpsnr, trace, write_deep

CAMERA = Camera(64, 16, 75, 0.28, 6)
N_FRAMES = 17
N_LENS = 2000
BORDER = 8
POST, WALL = 0, 2  # of test_pan.scene()
STEP = CAMERA.focus / CAMERA.focal_px / 8


def stripes_until(t):
    """How much of (0, t) is bright: the second half of every unit."""
    return np.floor(t) / 2 + np.maximum(t % 1 - 0.5, 0)


class Strip:
    """One row of the scene at a shift, seen from lens point u: means over [x, x + 1]."""

    def __init__(self, shift, u, has_post):
        self.shift, self.u, self.has_post = shift, u, has_post
        dark, bright = (
            test_pan.scene(0)[WALL].colour(np.array(x), np.array(0.0)) for x in (1, 3)
        )
        self.wall_colours = dark, bright - dark
        self.post_colour = test_pan.scene(0)[POST].colour(np.zeros(1), np.zeros(1))[0]

    def scene_x(self, x, z):
        parallax = self.u * CAMERA.lens_radius * (1 - z / CAMERA.focus)
        return parallax + (x - CAMERA.width / 2) / CAMERA.focal_px * z

    def wall(self, x0, x1):
        """Integral of the wall's colour over (x0, x1), px."""
        t0, t1 = (0.2 * (self.scene_x(x, 14) + self.shift) for x in (x0, x1))
        dark, more = self.wall_colours
        per_px = 0.2 * 14 / CAMERA.focal_px
        lit = (stripes_until(t1) - stripes_until(t0)) / per_px
        return (x1 - x0)[..., None] * dark + lit[..., None] * more

    def post(self, x):
        """Where the post begins and ends, within the pixels."""
        z = test_pan.scene(0)[POST].z
        middle = self.scene_x(x, z) + self.shift + 0.1
        per_px = z / CAMERA.focal_px
        ends = (np.clip(x + (e - middle) / per_px, x, x + 1) for e in (-0.12, 0.12))
        return tuple(ends) if self.has_post else (x, x)

    def coverage(self):
        x = np.arange(float(CAMERA.width))
        begin, end = self.post(x)
        return end - begin

    def colour(self):
        x = np.arange(float(CAMERA.width))
        begin, end = self.post(x)
        covered = (end - begin)[:, None] * self.post_colour
        return covered + self.wall(x, begin) + self.wall(end, x + 1)


def lens(shift, has_post):
    angle = np.arange(1, N_LENS + 1) * np.pi / (N_LENS + 1)
    weights = 2 / (N_LENS + 1) * np.sin(angle) ** 2
    views = [Strip(shift, u, has_post).colour() for u in np.cos(angle)]
    return rows(np.tensordot(weights, np.array(views), 1))


def rows(strip):
    shape = (CAMERA.height, *strip.shape)
    return np.ascontiguousarray(np.broadcast_to(strip, shape))


# ---- inputs ------------------------------------------------------------------------


def flat_pixels(strip):
    """Colour, and the depth at the pixel's middle."""
    x = np.arange(float(CAMERA.width))
    begin, end = strip.post(x)
    is_post = (begin < x + 0.5) & (x + 0.5 < end)
    depth = np.where(is_post, 3.0, 14.0)[:, None]
    return rows(np.concatenate([strip.colour(), depth], 1)).astype("f4")


def deep_samples(strip, keep_hidden):
    """As deepscene.deep_samples() gives them."""
    x = np.arange(float(CAMERA.width))
    post, wall = (test_pan.scene(0)[k] for k in (POST, WALL))
    cover = strip.coverage()
    seen = 1.0 * (keep_hidden | (cover < 1))
    return [
        (post, rows(cover), rows(cover[:, None] * strip.post_colour)),
        (wall, rows(seen), rows(seen[:, None] * strip.wall(x, x + 1))),
    ]


def write_view(path, strip, place):
    offset = tuple(CAMERA.lens_radius * p for p in place)
    vector = oiio.TypeDesc(oiio.FLOAT, oiio.VEC2)
    attributes = [
        ("rackfocus:lensOffset", vector, offset),
        ("rackfocus:shearDistance", float(CAMERA.focus)),
    ]
    test_pan.write(path, flat_pixels(strip), attributes)


# ---- measuring ---------------------------------------------------------------------


def rackfocus(*arguments):
    command = [os.environ["RACKFOCUS"], "filter", "--type", "float", "-q"]
    subprocess.run([*command, *CAMERA.options(), *arguments], check=True)


def filtered(make, *options):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for i in range(N_FRAMES):
            make(folder / f"in.{i}.exr", i)
        rackfocus(folder / "in.#.exr", "-o", folder / "out.#.exr", *options)
        return [read(folder / f"out.{i}.exr")[0][..., :3] for i in range(N_FRAMES)]


def merged(n_views, has_post):
    """What `views` makes of views from n points of the lens."""
    frames = []
    with tempfile.TemporaryDirectory() as name:
        files = [Path(name) / f"view{k}.exr" for k in range(n_views)]
        for i in range(N_FRAMES):
            for path, place in zip(files, lens_points(n_views), strict=True):
                write_view(path, Strip(i * STEP, place[0], has_post), place)
            rackfocus(*files, "-o", Path(name) / "out.exr")
            frames.append(read(Path(name) / "out.exr")[0][..., :3])
    return frames


def random_lens(layers, n, rng):
    """The mean of n rays per pixel, as a renderer takes them."""
    shape = (CAMERA.height, CAMERA.width, n)
    r, t = np.sqrt(rng.random(shape)), 2 * np.pi * rng.random(shape)
    y, x = np.indices(shape[:2])[..., None] + rng.random((2, *shape))
    return trace(CAMERA, layers, x, y, r * np.cos(t), r * np.sin(t))[0].mean(2)


def sampled_pixels(layers, n):
    """Pixels that are means over n places."""
    colour, _ = trace(CAMERA, layers, *grid(CAMERA, n), 0, 0)
    return colour.mean(2)


def flicker_linear(frames):
    t = np.stack(frames)
    return np.abs(t[:-2] - 2 * t[1:-1] + t[2:]).mean()


def measure(title, has_post):
    strips = [Strip(i * STEP, 0, has_post) for i in range(N_FRAMES)]
    parts = [POST, WALL] if has_post else [WALL]
    scenes = [[test_pan.scene(i * STEP)[k] for k in parts] for i in range(N_FRAMES)]
    inner = np.s_[:, :, BORDER:-BORDER]
    want = np.stack([lens(i * STEP, has_post) for i in range(N_FRAMES)])[inner]

    def show(name, frames):
        got = np.stack(frames)[inner]
        ratios = (f(got) / f(want) for f in (test_pan.flicker, flicker_linear))
        ratios = " | ".join(f"{ratio:.1f}" for ratio in ratios)
        print(
            f"| {title} | {name} | {ratios} | {tpsnr(got, want):.1f} dB |", flush=True
        )

    def flat(path, i):
        test_pan.write(path, flat_pixels(strips[i]))

    def deep(path, i, keep_hidden=True):
        write_deep(path, CAMERA, deep_samples(strips[i], keep_hidden))

    def coarse(path, i):
        pixels = flat_pixels(strips[i])
        pixels[..., :3] = sampled_pixels(scenes[i], 8)
        test_pan.write(path, pixels)

    show("pinhole, not filtered", [rows(one.colour()) for one in strips])
    show("flat frames", filtered(flat))
    if has_post:
        show("flat, `--fill-hidden off`", filtered(flat, "--fill-hidden", "off"))
        show("flat, `--split-edges off`", filtered(flat, "--split-edges", "off"))
        show("deep frames", filtered(deep))
        show("deep, nothing hidden", filtered(lambda p, i: deep(p, i, False)))
    for n in (4, 8):
        show(f"{n} views", merged(n, has_post))
    show("flat frames of 8 x 8 places", filtered(coarse))
    for n in (64, 1024):
        rng = np.random.default_rng(1)
        show(f"lens of {n} random rays", [random_lens(s, n, rng) for s in scenes])


def main():
    measure("wall", False)
    measure("post, wall", True)


if __name__ == "__main__":
    main()
