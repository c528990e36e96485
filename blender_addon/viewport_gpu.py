# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures out of 3D views and back onto them."""

import contextlib
import inspect

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from .pictures import for_view, to_linear

HAS_DPI = bpy.app.version < (4, 0, 0)  # blf.size() takes it
FONT_PX = 14
# What is drawn on a view is encoded as sRGB before 5.0 (measured on 3.4 and 5.2; the
# argument that came with the change tells).
VIEW_ENCODES = (
    "is_scene_linear_with_rec709_srgb_target"
    not in inspect.signature(draw_texture_2d).parameters
)


class ViewError(Exception):
    """The view cannot be had; the message is for the user."""


# Overlays that leave a depth where they are drawn; the grid does since 5.x.
WITH_DEPTH = (
    "show_extras show_bones show_motion_paths show_relationship_lines "
    "show_outline_selected show_wireframes show_annotation show_cursor "
    "show_object_origins show_face_orientation show_light_colors "
    "show_floor show_ortho_grid show_axis_x show_axis_y show_axis_z"
).split()


@contextlib.contextmanager
def _bare(space):
    """A 3D view without what is not of the scene and has a depth of its own.

    Overlays as such are on: without them EEVEE and Cycles leave no depth.
    """
    overlay = space.overlay
    wanted = {name: False for name in WITH_DEPTH if hasattr(overlay, name)}
    wanted["show_overlays"] = True
    before = {name: getattr(overlay, name) for name in wanted}
    changed = [name for name in wanted if before[name] != wanted[name]]
    try:
        for name in changed:
            setattr(overlay, name, wanted[name])
        yield
    finally:
        for name in changed:
            setattr(overlay, name, before[name])


# ---- out of a view ----------------------------------------------------------------


def colour_of(frame, width, height):
    """What a scene was drawn as: (height, width, 4), premultiplied, rows downwards.

    frame: the frame buffer that Blender draws the scene of a 3D view into, which is
    active when its PRE_VIEW handlers run: scene-linear and without overlays.
    """
    if frame is None:
        raise ViewError("Blender has not drawn the scene of this view")
    colour = frame.read_color(0, 0, width, height, 4, 0, "FLOAT")
    colour.dimensions = width * height * 4  # 3.4 gives false strides
    return np.asarray(colour).reshape(height, width, 4)[::-1]


def leaves_depth(space):
    """Is the depth of a 3D view's scene in the buffer that it is drawn into?

    EEVEE, Cycles and other engines only leave it for the overlays.
    """
    shading = space.shading
    if shading.type == "SOLID":
        return not shading.show_xray
    return shading.type != "WIREFRAME" and space.overlay.show_overlays


def draws_lines(space):
    """Do overlays of a 3D view leave a depth of their own in that buffer?"""
    overlay = space.overlay
    return overlay.show_overlays and any(
        getattr(overlay, name, False) for name in WITH_DEPTH
    )


def depth_of(frame, width, height):
    """The depth buffer of colour_of()'s frame, (height, width), rows downwards."""
    depth = frame.read_depth(0, 0, width, height)
    depth.dimensions = width * height
    return np.asarray(depth).reshape(height, width)[::-1]


def without_lines(depth):
    """A depth buffer, (height, width), without what is near and at most 2 px wide."""
    for extreme in (np.maximum, np.minimum):
        wide = np.pad(depth, 1, mode="edge")
        wide = extreme(extreme(wide[:-2], wide[1:-1]), wide[2:])
        depth = extreme(extreme(wide[:, :-2], wide[:, 1:-1]), wide[:, 2:])
    return depth


def nearest(picture, width, height):
    """The px of a (height, width) picture at the middles of fewer and larger ones."""
    rows, columns = (
        ((np.arange(n) + 0.5) * old / n).astype(int)
        for n, old in zip((height, width), picture.shape, strict=True)
    )
    return picture[np.ix_(rows, columns)]


def shrunk(picture, width, height):
    """Means of a picture's px, (height, width, 4); not larger than it was."""
    for axis, n in ((0, height), (1, width)):
        n_old = picture.shape[axis]
        if n >= n_old:
            continue
        starts = np.arange(n + 1) * n_old // n
        counts = np.diff(starts)
        lines = np.moveaxis(picture, axis, 0)
        sums = lines[starts[:-1]]
        for k in range(1, counts.max()):  # several times as fast as np.add.reduceat
            more = np.flatnonzero(counts > k)
            sums[more] += lines[starts[more] + k]
        sums /= counts[:, None, None].astype(np.float32)
        picture = np.moveaxis(sums, 0, axis)
    return np.ascontiguousarray(picture)


class Grabber:
    """Draws a 3D view into memory of its own, at one size, for its depth."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self._offscreen = gpu.types.GPUOffScreen(width, height)

    def depth(self, context):
        """Depth buffer of the context's view, (height, width), rows downwards."""
        view = context.region_data
        with _bare(context.space_data):
            self._offscreen.draw_view3d(
                context.scene, context.view_layer, context.space_data, context.region,
                view.view_matrix, view.window_matrix,
            )  # fmt: skip
        with self._offscreen.bind():
            frame = gpu.state.active_framebuffer_get()
            depth = frame.read_depth(0, 0, self.width, self.height)
        depth.dimensions = self.width * self.height
        return np.asarray(depth).reshape(self.height, self.width)[::-1]

    def free(self):
        """Gives the memory back."""
        self._offscreen.free()


# ---- onto a view ------------------------------------------------------------------


def _texture_of(pixels):
    """A texture of (height, width, 4) values, rows upwards."""
    height, width = pixels.shape[:2]
    pixels = np.ascontiguousarray(pixels, np.float32)
    data = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
    return gpu.types.GPUTexture((width, height), format="RGBA32F", data=data)


def _draw_texture(texture, width, height):
    gpu.state.blend_set("NONE")
    draw_texture_2d(texture, (0, 0), width, height)


def _background(context, height):
    """What is behind the scene of a 3D view, linear: (3,) or (height, 1, 3)."""
    shading = context.space_data.shading
    kind = shading.background_type if shading.type in ("SOLID", "WIREFRAME") else ""
    if kind == "VIEWPORT":
        return np.float32(shading.background_color)
    if kind == "WORLD" and context.scene.world is not None:
        return np.float32(context.scene.world.color)
    theme = context.preferences.themes[0].view_3d.space.gradients
    top = to_linear(np.float32(theme.high_gradient))
    if theme.background_type != "LINEAR":
        return top
    below = np.linspace(0, 1, height, dtype=np.float32)[:, None, None]
    return top * (1 - below) + to_linear(np.float32(theme.gradient)) * below


def to_texture(context, picture, alpha_before):
    """A texture for draw_into() of a scene-linear (height, width, 4) picture.

    Premultiplied, rows downwards; alpha_before: (height, width) of what it replaces.
    """
    behind = _background(context, len(picture))
    return _texture_of(for_view(picture, alpha_before, behind)[::-1])


def to_shown_texture(picture):
    """A texture for draw_over() of a (height, width, 4) picture as it is to be shown.

    Rows downwards.
    """
    return _texture_of((to_linear(picture) if VIEW_ENCODES else picture)[::-1])


def draw_into(frame, region, texture):
    """Puts a texture in the place of the scene, below overlays and view transform."""
    with frame.bind():
        _draw_texture(texture, region.width, region.height)


def draw_over(region, texture):
    """Covers a region with a texture."""
    _draw_texture(texture, region.width, region.height)


def draw_message(text):
    """One line at the lower left."""
    blf.size(0, FONT_PX, *([72] if HAS_DPI else []))
    blf.color(0, 1, 0.75, 0.3, 1)
    blf.position(0, 20, 20, 0)
    blf.draw(0, f"Rack Focus: {text}")
