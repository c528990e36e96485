# SPDX-License-Identifier: GPL-3.0-or-later
"""Light objects that the camera sees, to which Cycles gives no depth.

Cycles adds their light to what is behind them, and they would be blurred like that: one in
focus before a far wall becomes a disc. Box and console say so; Accumulate needs no depth.
"""

from bpy_extras.object_utils import world_to_camera_view

from . import sets

LINES = (
    "Lights that the camera sees have no depth, and are blurred like",
    "what is behind them: take meshes with an Emission in their place",
)


def describe(scene, camera):
    """Lines for the panel on lights in what a camera of the scene shows."""
    if camera is None or camera.type != "CAMERA" or scene.render.engine != "CYCLES":
        return []
    if camera.data.rack_focus.method == "accumulate":
        return []
    items = {item for layer in sets.layers_of(scene) for item in layer.objects}
    is_seen = any(_is_seen(item, scene, camera) for item in items - {None})
    return list(LINES) if is_seen else []


def _is_seen(item, scene, camera):
    """Does a render show an object as a light with a size?"""
    if item.type != "LIGHT" or item.hide_render or not item.visible_camera:
        return False
    data = item.data
    is_area = data.type == "AREA"
    sides = (data.size, data.size_y) if is_area else (data.shadow_soft_size,)
    if data.type == "SUN" or not max(sides) > 0 or not data.energy > 0:
        return False
    # A sphere around it, of the larger side of a rectangle too.
    size = max(sides) * max(1, *item.matrix_world.to_scale())
    centre = item.matrix_world.translation
    right, up, _ = camera.matrix_world.to_3x3().normalized().transposed()
    near = [centre + sign * size * way for way in (right, up) for sign in (-1, 0, 1)]
    places = [world_to_camera_view(scene, camera, place) for place in near]
    spans = [[place[i] for place in places] for i in (0, 1)]
    is_before = places[1].z > 0
    return is_before and all(min(span) < 1 and max(span) > 0 for span in spans)
