#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Random scenes of flat layers, one view against their lens, without any renderer.

    tests/quality/layers.py [--edges] FOLDER RACKFOCUS[,OTHER ..] [FIRST [END]]

needs numpy and OpenImageIO of Python. Each number is a scene: posts, discs, leaves,
walls and frames before a background, textured, some slanted, some with lamps or as
bright as a sky, at radii of -25 to 55 px; with --edges posts before the straight edge of
a wall, which stands before a sky or another wall. What every point of the lens sees of
them is known, so the mean over 1600 points is the lens's picture, and the pinhole's
depth is exact. Prints tPSNR in dB, 20 px and more within the border, of the sharp
picture and of each program's. The scenes are kept in FOLDER (15 s each); so are sheets
of what is worst: pinhole, lens, the first program's picture, twice the difference. What
it found: docs/notebook/methods.md.
"""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

WIDTH, HEIGHT, MARGIN = 200, 140, 90  # px; layers go on beyond the picture
FINE = 3  # pixels of a layer for one of the picture, along each axis
BORDER = 20
# r = SCALE (1 / FOCUS - 1 / z), which these parameters are.
SCALE, FOCUS, FARTHEST = 200.0, 4.0, 49.9
LENS = "--focus-distance 4 --lens-radius 0.2 --focal-length-px 1000".split()


@dataclass
class Layer:
    radius: float  # px, in the middle of the picture
    slope: tuple  # of the radius, along x and y
    colour: np.ndarray
    mask: np.ndarray


def texture(rng, shape, cell):
    """Random colours `cell` px apart, linear between them."""
    height, width = shape
    tones = rng.random((height // cell + 3, width // cell + 3, 3))
    y, x = np.arange(height) / cell, np.arange(width) / cell
    top, left = y.astype(int), x.astype(int)
    down, right = (y - top)[:, None, None], (x - left)[None, :, None]
    above = tones[top][:, left] * (1 - right) + tones[top][:, left + 1] * right
    below = tones[top + 1][:, left] * (1 - right) + tones[top + 1][:, left + 1] * right
    return above * (1 - down) + below * down


def colours(rng, x, y, is_background):
    base = rng.random(3) * rng.choice([0.15, 0.5, 0.9])
    tones = texture(rng, x.shape, int(rng.choice([3, 6, 12, 30])) * FINE)
    side = rng.choice([2, 4, 8])
    is_light = ((x // side + y // side) % 2)[..., None] < 1
    kinds = [
        np.broadcast_to(base, (*x.shape, 3)).copy(),
        base * (0.4 + 1.2 * tones),
        np.where(is_light, base, base * 0.2 + 0.02),
        base * (0.2 + 1.6 * (tones > 0.5)),
    ]
    found = kinds[rng.integers(4)]
    if is_background and rng.random() < 0.3:  # a sky
        found = found * 0 + np.array([0.6, 0.8, 1.2]) * rng.uniform(0.5, 4)
    if rng.random() < (0.6 if is_background else 0.2):
        for _ in range(rng.integers(1, 12)):
            at = rng.uniform(10, WIDTH - 10), rng.uniform(10, HEIGHT - 10)
            is_lamp = np.hypot(x - at[0], y - at[1]) < rng.uniform(1.5, 3)
            found[is_lamp] = rng.random(3) * rng.choice([3, 20])
    return found.astype("f4")


def mask(rng, x, y):
    kind = rng.integers(5)
    if kind == 0:  # posts, wires
        size, apart = rng.choice([1.2, 2.5, 5, 10]), rng.choice([25, 60, 500])
        angle = rng.uniform(0, np.pi)
        across = x * np.cos(angle) + y * np.sin(angle) + rng.uniform(0, apart)
        return np.abs(across % apart - apart / 2) < size / 2
    if kind == 1:  # discs
        found = np.zeros(x.shape, bool)
        for _ in range(rng.integers(1, 6)):
            at = rng.uniform(0, WIDTH), rng.uniform(0, HEIGHT)
            found |= np.hypot(x - at[0], y - at[1]) < rng.choice([4, 12, 30])
        return found
    if kind == 2:  # a wall
        angle = rng.uniform(0, 2 * np.pi)
        dx, dy = x - WIDTH * rng.uniform(0.3, 0.7), y - HEIGHT * rng.uniform(0.3, 0.7)
        return dx * np.cos(angle) + dy * np.sin(angle) > 0
    if kind == 3:  # leaves
        tones = texture(rng, x.shape, int(rng.choice([4, 9, 18])) * FINE)[..., 0]
        return tones > rng.uniform(0.5, 0.75)
    is_beside = np.abs(x - WIDTH / 2) > WIDTH * rng.uniform(0.15, 0.4)
    return is_beside | (np.abs(y - HEIGHT / 2) > HEIGHT * rng.uniform(0.15, 0.4))


def make_layers(rng):
    """From near to far."""
    y, x = np.mgrid[: (HEIGHT + 2 * MARGIN) * FINE, : (WIDTH + 2 * MARGIN) * FINE]
    x, y = x / FINE - MARGIN, y / FINE - MARGIN
    radii = sorted(rng.uniform(-25, 25, rng.integers(1, 6)))
    if rng.random() < 0.6:
        radii[rng.integers(len(radii))] = rng.uniform(-0.3, 0.3)
        radii.sort()
    least = max(radii[-1] + 2, 5)
    layers = []
    for radius in [*radii, rng.uniform(least, least + 30)]:
        is_last = len(layers) == len(radii)
        slope = rng.uniform(-0.03, 0.03, 2) if rng.random() < 0.25 else (0, 0)
        colour = colours(rng, x, y, is_last)
        shape = np.ones(x.shape, bool) if is_last else mask(rng, x, y)
        layers.append(Layer(radius, slope, colour, shape))
    return layers


def make_edges(rng):
    """Posts, a wall with a straight edge behind them, and what is behind it."""
    y, x = np.mgrid[: (HEIGHT + 2 * MARGIN) * FINE, : (WIDTH + 2 * MARGIN) * FINE]
    x, y = x / FINE - MARGIN, y / FINE - MARGIN
    post = rng.uniform(-25, 2)
    wall = max(0, post + 3) if rng.random() < 0.3 else rng.uniform(post + 3, 12)
    back = rng.uniform(max(wall + 3, 2), 35)
    angle, width = rng.uniform(0, np.pi), rng.choice([5, 10, 15])
    across = (x - WIDTH / 2) * np.cos(angle) + (y - HEIGHT / 2) * np.sin(angle)
    masks = [np.abs(x % 60 - 30) < width / 2, across > 0, np.ones(x.shape, bool)]
    return [
        Layer(radius, (0, 0), colours(rng, x, y, radius == back), shape)
        for radius, shape in zip((post, wall, back), masks, strict=True)
    ]


def seen(layers, u, v, dx, dy):
    """What the point (u, v) of the lens sees at (dx, dy) of each pixel, and its radius.

    A layer's point q is seen at p = q + (u, v) r(q), with r linear in q.
    """
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype("f8")
    x, y = x + dx - WIDTH / 2, y + dy - HEIGHT / 2
    colour = np.zeros((HEIGHT, WIDTH, 3), "f4")
    radius, is_open = np.zeros((HEIGHT, WIDTH)), np.ones((HEIGHT, WIDTH), bool)
    for layer in layers:
        gx, gy = layer.slope
        qx, qy = x - u * layer.radius, y - v * layer.radius
        rise = (gx * qx + gy * qy) / (1 + u * gx + v * gy)
        qx, qy = qx - u * rise, qy - v * rise
        column = np.floor((qx + WIDTH / 2 + MARGIN) * FINE).astype(int)
        row = np.floor((qy + HEIGHT / 2 + MARGIN) * FINE).astype(int)
        row = np.clip(row, 0, layer.mask.shape[0] - 1)
        column = np.clip(column, 0, layer.mask.shape[1] - 1)
        is_hit = is_open & layer.mask[row, column]
        colour[is_hit] = layer.colour[row, column][is_hit]
        radius[is_hit] = (layer.radius + rise)[is_hit]
        is_open &= ~is_hit
    return colour, radius


def pinhole(layers, n=5):
    at = [(i + 0.5) / n for i in range(n)]
    colour = sum(seen(layers, 0, 0, x, y)[0] for x in at for y in at) / n**2
    return colour, seen(layers, 0, 0, 0.5, 0.5)[1]


def through_lens(layers, rng, n=40):
    """The mean over n x n points, each at another place of the pixels."""
    total, order = np.zeros((HEIGHT, WIDTH, 3)), rng.permutation(n * n)
    for i in range(n * n):
        height = np.sqrt((i % n + rng.random()) / n)
        angle = 2 * np.pi * (i // n + rng.random()) / n
        dx, dy = (order[i] % n + rng.random()) / n, (order[i] // n + rng.random()) / n
        u, v = height * np.cos(angle), height * np.sin(angle)
        total += seen(layers, u, v, dx, dy)[0]
    return total / n**2


def write(path, pixels, names):
    spec = oiio.ImageSpec(WIDTH, HEIGHT, len(names), oiio.FLOAT)
    spec.channelnames = tuple(names)
    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), spec)
    out.write_image(pixels.astype("f4"))
    out.close()


def read(path):
    file = oiio.ImageInput.open(str(path))
    pixels = np.array(file.read_image(oiio.FLOAT))[..., :3]
    file.close()
    return pixels


def make_scene(folder, seed, make):
    """Files of the pinhole and of the lens, if they are not there."""
    files = folder / f"{seed}.exr", folder / f"{seed}_lens.exr"
    if not files[1].exists():
        rng = np.random.default_rng(seed)
        layers = make(rng)
        colour, radius = pinhole(layers)
        depth = 1 / (1 / FOCUS - np.minimum(radius, FARTHEST) / SCALE)
        write(files[0], np.concatenate([colour, depth[..., None]], 2), "RGBZ")
        write(files[1], through_lens(layers, rng), "RGB")
    return files


def toned(pixels):
    return np.clip(pixels, 0, 1) ** (1 / 2.2)


def score(a, b):
    inner = np.s_[BORDER:-BORDER, BORDER:-BORDER]
    return -10 * np.log10(((toned(a) - toned(b))[inner] ** 2).mean() + 1e-9)


def main():
    arguments = [a for a in sys.argv[1:] if a != "--edges"]
    make = make_layers if arguments == sys.argv[1:] else make_edges
    folder, commands = Path(arguments[0]), arguments[1].split(",")
    first = int(arguments[2]) if len(arguments) > 2 else 0
    end = int(arguments[3]) if len(arguments) > 3 else first + 20
    folder.mkdir(parents=True, exist_ok=True)
    out, scores = folder / "out.exr", []
    for seed in range(first, end):
        files = make_scene(folder, seed, make)
        sharp, lens, row = read(files[0]), read(files[1]), []
        for command in commands:
            options = ["-o", out, "--type", "float", "-q", *LENS]
            subprocess.run([command, "filter", files[0], *options], check=True)
            row.append(score(read(out), lens))
            if command == commands[0]:
                mine = read(out)
        scores.append(row)
        print(f"{seed:4} sharp {score(sharp, lens):5.2f}", *(f"{s:6.2f}" for s in row))
        sheet = [toned(p) for p in (sharp, lens, mine)]
        sheet.append(np.clip(2 * np.abs(sheet[2] - sheet[1]), 0, 1))
        buffer = oiio.ImageBuf(oiio.ImageSpec(4 * WIDTH, HEIGHT, 3, oiio.UINT8))
        buffer.set_pixels(oiio.ROI.All, np.concatenate(sheet, 1).astype("f4"))
        buffer.write(str(folder / f"{row[0]:05.2f}_{seed}.png"))
    print("mean            ", *(f"{s:6.2f}" for s in np.mean(scores, 0)))


if __name__ == "__main__":
    main()
