# SPDX-License-Identifier: Apache-2.0
"""A scene of textured planes whose picture through a lens can be worked out exactly,
its deep render with everything that is hidden, and deep EXR files.

Each layer is a plane z = const with a colour and an opacity as functions of (X, Y). The
camera looks along +z from the origin, focal length F px; the lens is a disc of radius R
whose plane of focus is z = S (a CG camera: the picture does not breathe).
"""

import numpy as np
import OpenImageIO as oiio


class Layer:
    """One plane. `colour(x, y)` gives (..., 3); `alpha(x, y)` the opacity there."""

    def __init__(self, z, colour, alpha, back=None):
        self.z, self.colour, self.alpha, self.back = z, colour, alpha, back


class Camera:
    def __init__(self, width, height, focal_px, lens_radius, focus):
        self.width, self.height = width, height
        self.focal_px, self.lens_radius, self.focus = focal_px, lens_radius, focus

    def options(self):
        return [
            *("--focal-length-px", str(self.focal_px)),
            *("--lens-radius", str(self.lens_radius)),
            *("--focus-distance", str(self.focus)),
        ]


def grid(camera, n):
    """Sub-pixel places, n x n in each pixel or n = (across, down): arrays of
    (height, width, places).
    """
    at_x, at_y = ((np.arange(k) + 0.5) / k for k in (n if np.size(n) == 2 else (n, n)))
    y, x = np.meshgrid(np.arange(camera.height), np.arange(camera.width), indexing="ij")
    sy, sx = np.meshgrid(at_y, at_x, indexing="ij")
    px = x[..., None] + sx.ravel()
    py = y[..., None] + sy.ravel()
    return px, py


def lens_points(n):
    """n points spread evenly over the unit disc (sunflower)."""
    k = np.arange(n) + 0.5
    r, t = np.sqrt(k / n), k * np.pi * (3 - np.sqrt(5))
    return np.stack([r * np.cos(t), r * np.sin(t)], -1)


def trace(camera, layers, px, py, u, v):
    """Colour and alpha, composited near to far along the rays through lens (u, v)."""
    colour, left = np.zeros(px.shape + (3,)), np.ones(px.shape)
    fx = (px - camera.width / 2) / camera.focal_px
    fy = (py - camera.height / 2) / camera.focal_px
    for layer in sorted(layers, key=lambda one: one.z):
        k = layer.z / camera.focus
        x = u * camera.lens_radius * (1 - k) + fx * layer.z
        y = v * camera.lens_radius * (1 - k) + fy * layer.z
        a = layer.alpha(x, y)
        colour += (left * a)[..., None] * layer.colour(x, y)
        left = left * (1 - a)
    return colour, 1 - left


def reference(camera, layers, n_lens=256, n_pixel=2):
    """What the lens sees: the physical mean over lens and pixel."""
    px, py = grid(camera, n_pixel)
    total = np.zeros((camera.height, camera.width, 4))
    for u, v in lens_points(n_lens):
        colour, alpha = trace(camera, layers, px, py, u, v)
        total[..., :3] += colour.mean(2)
        total[..., 3] += alpha.mean(2)
    return total / n_lens


def deep_samples(camera, layers, n_pixel=4, keep_hidden=True):
    """Per layer: coverage, premultiplied colour and depth of every pixel, through the
    middle of the lens. Without `keep_hidden` as a renderer writes it that stops at the
    first opaque surface.
    """
    px, py = grid(camera, n_pixel)
    fx = (px - camera.width / 2) / camera.focal_px
    fy = (py - camera.height / 2) / camera.focal_px
    out, left = [], np.ones(px.shape[:2])
    for layer in sorted(layers, key=lambda one: one.z):
        a = layer.alpha(fx * layer.z, fy * layer.z)
        colour = layer.colour(fx * layer.z, fy * layer.z) * a[..., None]
        coverage = a.mean(2)
        if not keep_hidden:
            colour = colour * (left > 0)[..., None, None]
            coverage = coverage * (left > 0)
        out.append((layer, coverage, colour.mean(2)))
        left = left * (1 - coverage)
        left[left < 1e-3] = 0
    return out


CHANNELS = ("R", "G", "B", "A", "Z", "ZBack")


def write_deep(
    path, camera, samples, tile=0, compression="zips", attrs=(), names=CHANNELS
):
    """Writes what deep_samples() gave as a deep EXR file."""
    spec = oiio.ImageSpec(camera.width, camera.height, len(names), oiio.FLOAT)
    spec.channelnames = names
    spec.channelformats = ("float",) * spec.nchannels
    spec.deep = True
    spec["compression"] = compression
    for name, value in attrs:
        spec[name] = value
    if tile:
        spec.tile_width = spec.tile_height = tile
    data = oiio.DeepData()
    data.init(spec)
    for y in range(camera.height):
        for x in range(camera.width):
            here = [
                dict(
                    zip(
                        CHANNELS,
                        (*colour[y, x], coverage[y, x], layer.z, layer.back or layer.z),
                    )
                )
                for layer, coverage, colour in samples
                if coverage[y, x] > 0 or colour[y, x].any()
            ]
            pixel = y * camera.width + x
            data.set_samples(pixel, len(here))
            for s, values in enumerate(here):
                for c, name in enumerate(names):
                    data.set_deep_value(pixel, c, s, float(values[name]))
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_deep_image(data), output.geterror()
    output.close()
    return path


def read(path):
    """Channels of a flat file as one array (height, width, n), and the names."""
    source = oiio.ImageInput.open(str(path))
    assert source, oiio.geterror()
    spec = source.spec()
    pixels = np.array(source.read_image(format="float"))
    return pixels.reshape(spec.height, spec.width, -1), list(spec.channelnames)


def tpsnr(a, b):
    a, b = (np.clip(v[..., :3], 0, 1) ** (1 / 2.2) for v in (a, b))
    return -10 * np.log10(np.mean((a - b) ** 2))
