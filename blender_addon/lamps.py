# SPDX-License-Identifier: GPL-3.0-or-later
"""Light objects that the camera sees, to which Cycles gives no depth.

Cycles adds their light to what is behind them, and they would be blurred like that: one in
focus before a far wall becomes a disc. Their shape is known, so that pixels which are
mostly their light get its depth. Of a point p of the picture and (u, v) of the lens, with
the plane at D that stays in place, the ray at the planar distance t is at

    (u, v) + t (p - (u, v) / D)    perspective, p as a slope
    p + (u, v) (1 - t / D)         orthographic, p in scene units

What a light shines into the camera is P / (pi A) for an area A, P / (4 pi^2 r^2) for a ball
(measured, 4.2 and 5.0; of areas 3.4 has pi / 4 of that). With a Spread s an area shines
at the angle a to its axis

    max(tan(s / 2) - tan(a), 0) / (tan(s / 2) - s / 2)

times that (area_light_spread_attenuation(), intern/cycles/kernel/light/area.h; measured in
3.4, 4.2 and 5.0). Where textures change it, box and console say what to do. Accumulate
needs no depth.
"""

import math
from typing import NamedTuple

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view

from . import lens, names, passes, sets, walked

WAY_OUT = "what is behind it: take a mesh with an Emission in its place"
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
# Of a pixel's light, what must be the lamp's. Rims have a part of the lamp; where more than
# twice of what is there should be, something dims it that is not known here.
LEAST_SHARE, MOST_SHARE = 0.5, 2.0
LEAST_SPREAD = math.radians(1)  # Cycles' own
ARE_BALLS = bpy.app.version >= (
    4,
    0,
    0,
)  # before, points are discs that face the camera


class Lamp(NamedTuple):
    """A light as a render has it."""

    kind: str  # "ball", "rectangle" or "ellipse"
    matrix: np.ndarray  # (4, 4), to the world
    half: tuple  # half sides along x and y of its own, or the radius twice
    radiance: np.ndarray  # (3,), what it shines into the camera
    spread: float = math.pi  # of an area, radians


_lamps = names.store()  # scene name: {name of a view layer: [Lamp]} of the last render


# ---- what shines ------------------------------------------------------------------


def _sides_of(data):
    """(x, y) of an area light, or the diameter of a ball twice."""
    if data.type != "AREA":
        return (2 * data.shadow_soft_size,) * 2
    is_long = data.shape in ("RECTANGLE", "ELLIPSE")
    return data.size, data.size_y if is_long else data.size


def _shines(item):
    """Is an object a light with a size that a camera may see?"""
    if item.type != "LIGHT" or not item.visible_camera or item.data.type == "SUN":
        return False
    return max(_sides_of(item.data)) > 0 and item.data.energy > 0


def _colour_of_nodes(data):
    """What nodes multiply the colour of a light by, (3,); None where that varies.

    5.2 gives each light an Emission in white with the strength 1, others with Use Nodes.
    """
    if not data.use_nodes or data.node_tree is None or not len(data.node_tree.nodes):
        return np.ones(3, np.float32)
    nodes = data.node_tree.nodes
    ends = [n for n in nodes if n.type == "OUTPUT_LIGHT" and n.is_active_output]
    links = [link for n in ends for link in n.inputs["Surface"].links]
    node = links[0].from_node if len(links) == 1 else None
    if node is None or node.type != "EMISSION" or node.mute:
        return None
    colour, strength = node.inputs["Color"], node.inputs["Strength"]
    if colour.is_linked or strength.is_linked:
        return None
    return np.array(colour.default_value, np.float32)[:3] * strength.default_value


def _why_unknown(data):
    """Why it is not known what a light shines into the camera; ""."""
    has_cycles = hasattr(data, "cycles")
    if has_cycles and getattr(data.cycles, "is_portal", False):
        return "a portal"
    if _colour_of_nodes(data) is None:
        return "its nodes are no single Emission"
    return ""


def _radiance(data, area):
    """(3,) that a light shines into the camera; area: of the lamp, scene units²."""
    colour = np.array(data.color, np.float32) * _colour_of_nodes(data)
    if getattr(data, "use_temperature", False):  # 4.5 and later, as the next two
        colour = colour * np.array(data.temperature_color, np.float32)
    power = data.energy * 2.0 ** getattr(data, "exposure", 0.0)
    if getattr(data, "normalize", True):
        power /= area
    return colour * (power / math.pi)


def _lamp_of(data, matrix):
    """The Lamp of a light's data at a place, (4, 4)."""
    half = tuple(side / 2 for side in _sides_of(data))
    if data.type != "AREA":
        area = 4 * math.pi * half[0] ** 2
        return Lamp("ball", matrix, half, _radiance(data, area))
    is_round = data.shape in ("DISK", "ELLIPSE")
    x, y = matrix[:3, 0] * half[0], matrix[:3, 1] * half[1]
    area = np.linalg.norm(np.cross(x, y)) * (math.pi if is_round else 4)
    kind = "ellipse" if is_round else "rectangle"
    spread = max(data.spread, LEAST_SPREAD)
    return Lamp(kind, matrix, half, _radiance(data, max(area, 1e-12)), spread)


def measure(scene, depsgraph):
    """Notes the lights of a scene that its render has evaluated, instances too."""
    layers = _lamps.setdefault(scene.name, {})
    found = layers[depsgraph.view_layer.name] = []
    is_cycles = scene.render.engine == "CYCLES"
    if not is_cycles or not any(map(_shines, bpy.data.objects)):
        return
    for one in depsgraph.object_instances:
        item = one.object
        if _shines(item) and not _why_unknown(item.data):
            found.append(_lamp_of(item.data, np.array(one.matrix_world)))


def forget(scene=None):
    """Lets go of the lights of a scene's render, or of all."""
    if scene is None:
        _lamps.clear()
    else:
        _lamps.pop(scene.name, None)


# ---- their depth ------------------------------------------------------------------


def placed(found, scene, layer, camera, wide=1.0):
    """The views of a view layer, [(passes.Layer, passes.Place)], with lights in the depth.

    camera: evaluated, with the scene's own pixels; a part of them in a render region.
    wide: of overscan.py.
    """
    lamps = _lamps.get(scene.name, {}).get(passes.old_name(scene, layer), ())
    if not lamps or scene.render.use_multiview or lens.why_not(camera):
        return found
    axes = np.array(camera.matrix_world.to_3x3().normalized())
    eye = np.array(camera.matrix_world.translation)
    to_camera = np.eye(4)
    to_camera[:3, :3] = axes.T * [[1], [1], [-1]]  # right, up, away
    to_camera[:3, 3] = -to_camera[:3, :3] @ eye
    is_ortho = camera.data.type == "ORTHO"
    seen = [lamp._replace(matrix=to_camera @ lamp.matrix) for lamp in lamps]
    seen.sort(key=lambda lamp: -lamp.matrix[2, 3])  # the nearest last
    corners = [np.array(c) for c in camera.data.view_frame(scene=scene)]
    if not is_ortho:
        corners = [corner / -corner[2] for corner in corners]
    if wide != 1:
        middle = (corners[0] + corners[2]) / 2
        corners = [middle + wide * (corner - middle) for corner in corners]
    return [
        (_with_lamps(one, place, seen, corners, (scene, is_ortho)), place)
        for one, place in found
    ]


def _share_of(lamp, way):
    """What of an area's light its Spread lets through along rays, (..., 3), from 0 up."""
    if lamp.spread > math.pi - 1e-3:
        return 1.0
    axis = lamp.matrix[:3, 2] / np.linalg.norm(lamp.matrix[:3, 2])
    along = np.maximum(way @ axis, 1e-9)
    across = np.linalg.norm(way - (way @ axis)[..., None] * axis, axis=-1)
    edge = math.tan(lamp.spread / 2)
    return np.maximum(edge - across / along, 0) / (edge - lamp.spread / 2)


def _shown(lamp, way, cycles):
    """Luminance of a lamp in the picture: Clamping > Direct Light, and Film > Exposure."""
    share, most = _share_of(lamp, way), cycles.sample_clamp_direct
    if most > 0:
        share = np.minimum(share, most / max(lamp.radiance.mean(), 1e-12))
    return lamp.radiance @ LUMINANCE * (share * cycles.film_exposure)


def _pixels(shape, corners, render):
    """(x of each column, y of each row): the middles of pixels, as of view_frame()."""
    height, width = shape
    whole = np.array(lens.picture_size(render))
    first = np.zeros(2)
    if render.use_border and tuple(whole) != (width, height):
        (left, _), (_, high) = lens.region_of(render, *whole)
        first = np.array([left, whole[1] - high])
    else:
        whole = np.array([width, height])
    (right, top), (left, low) = corners[0][:2], corners[2][:2]
    x = left + (right - left) * (np.arange(width) + first[0] + 0.5) / whole[0]
    y = top - (top - low) * (np.arange(height) + first[1] + 0.5) / whole[1]
    return x, y


def _with_lamps(layer, place, lamps, corners, about):
    """A passes.Layer with lights in its depth; about: (scene, is_ortho)."""
    scene, is_ortho = about
    (u, v), distance = place.offset, place.shear_distance
    if layer.depth is None or (distance == 0 and (u, v) != (0, 0)):
        return layer
    depth = np.array(layer.depth, np.float32)
    x, y = _pixels(depth.shape, corners, scene.render)
    du, dv = (u / distance, v / distance) if distance else (0.0, 0.0)
    for lamp in lamps:
        columns, rows = _box(lamp, x, y, (u, v, du, dv), is_ortho)
        if not columns or not rows:
            continue
        part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        px, py = np.meshgrid(x[part[1]], y[part[0]])
        if is_ortho:
            start = np.stack([px + u, py + v, np.zeros_like(px)], -1)
            way = np.stack(np.broadcast_arrays(-du, -dv, np.ones_like(px)), -1)
        else:
            start = np.broadcast_to([u, v, 0.0], (*px.shape, 3))
            way = np.stack([px - du, py - dv, np.ones_like(px)], -1)
        t = _distance(lamp, start, way)
        light = layer.colour[part][..., :3] @ LUMINANCE
        own = _shown(lamp, way, scene.cycles)
        is_its = (own >= LEAST_SHARE * light) & (own <= MOST_SHARE * light)
        is_its &= (t > 0) & (t < depth[part])
        depth[part][is_its] = t[is_its]
    return layer._replace(depth=depth)


def _box(lamp, x, y, lens_point, is_ortho):
    """Columns and rows of pixels in which a lamp may be seen."""
    u, v, du, dv = lens_point
    centre = lamp.matrix[:3, 3]
    axes = lamp.matrix[:3, :2] * lamp.half
    size = lamp.half[0] if lamp.kind == "ball" else np.abs(axes).sum()
    near, far = centre[2] - size, centre[2] + size
    found = []
    for p, place, shift, slope in ((x, centre[0], u, du), (y, centre[1], v, dv)):
        if far <= 0:
            return (), ()
        if is_ortho:
            ends = [
                place + s * size - shift + slope * t
                for s in (-1, 1)
                for t in (near, far)
            ]
        elif near <= 0.01 * size:
            ends = [-np.inf, np.inf]
        else:
            ends = [
                (place + s * size - shift) / t + slope
                for s in (-1, 1)
                for t in (near, far)
            ]
        found.append(np.flatnonzero((p >= min(ends)) & (p <= max(ends))))
    return tuple(range(f[0], f[-1] + 1) if len(f) else () for f in found)


def _distance(lamp, start, way):
    """Planar distance of a lamp along rays, (..., 3) each; infinity where they miss it."""
    to_centre = lamp.matrix[:3, 3] - start
    if lamp.kind == "ball":
        along = (to_centre * way).sum(-1) / (way * way).sum(-1)
        off = ((to_centre - along[..., None] * way) ** 2).sum(-1)
        left = lamp.half[0] ** 2 - off
        if ARE_BALLS:
            along -= np.sqrt(np.maximum(left, 0) / (way * way).sum(-1))
        return np.where(left >= 0, along, np.inf)
    x, y = (lamp.matrix[:3, i] * lamp.half[i] for i in (0, 1))
    normal = np.cross(x, y)
    # It shines to where its own z axis does not point.
    faces = (to_centre @ lamp.matrix[:3, 2]) > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (to_centre @ normal) / (way @ normal)
        at = t[..., None] * way - to_centre
        over_x, over_y = np.cross(y, normal), np.cross(x, normal)
        a, b = (at @ over_x) / (x @ over_x), (at @ over_y) / (y @ over_y)
        is_round = lamp.kind == "ellipse"
        inside = a * a + b * b <= 1 if is_round else np.maximum(abs(a), abs(b)) <= 1
    return np.where(faces & inside, t, np.inf)


# ---- what is told -----------------------------------------------------------------


def describe(scene, camera):
    """Lines for the panel on lights in the picture whose depth is not known."""
    if camera is None or camera.type != "CAMERA" or scene.render.engine != "CYCLES":
        return []
    if camera.data.rack_focus.method == "accumulate":
        return []
    for item in _shining(scene) if walked.once(_are_in, scene) else ():
        reason = _why_unknown(item.data)
        if scene.render.use_multiview:
            reason = "stereo"
        if reason and _is_seen(item, scene, camera):
            return [
                f"The light “{item.name}”, which the camera sees, has no depth",
                f"({reason}) and is blurred like {WAY_OUT}",
            ]
    return []


def _shining(scene):
    """The lights of a scene that a camera may see."""
    items = {item for layer in sets.layers_of(scene) for item in layer.objects}
    return [item for item in items - {None} if not item.hide_render and _shines(item)]


def _are_in(scene):
    """Has a scene such lights?"""
    return bool(_shining(scene))


def _is_seen(item, scene, camera):
    """Is a light in the picture of a camera?"""
    # A sphere around it, of the larger side of a rectangle too.
    size = max(_sides_of(item.data)) * max(1, *item.matrix_world.to_scale())
    centre = item.matrix_world.translation
    right, up, _ = camera.matrix_world.to_3x3().normalized().transposed()
    near = [centre + sign * size * way for way in (right, up) for sign in (-1, 0, 1)]
    places = [world_to_camera_view(scene, camera, place) for place in near]
    spans = [[place[i] for place in places] for i in (0, 1)]
    is_before = places[1].z > 0
    return is_before and all(min(span) < 1 and max(span) > 0 for span in spans)
