# SPDX-License-Identifier: GPL-3.0-or-later
"""The cameras of several views, children of the user's one.

Blender renders a copy of the scene through them by native multi-view, which finds the
camera of a view by its name: it takes the suffix of any view, in use or not, off the end
of the name of the scene's camera, and puts that of the view in its place. With a view that
is not in use and whose suffix is the whole name, the user's camera stays that of the copy.
So drivers, Geometry Nodes and scripts that ask for the scene's camera find it where it is
in every view (a driver that reads it: 17.2 dB where 43.1 are right).

A name that is longer than a suffix may be (5.0) is cut: the copy's camera is that of a
view then.
"""

import math

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import camera_objects, passes
from .writing import set_if_other

MARK = "rack_focus_view"  # custom property of our cameras


# ---- making them ------------------------------------------------------------------


def add(scene, copy, indices):
    """One camera for each view of a copy of a scene; returns the names of the objects.

    indices: numbers of the views. Multi-view finds the cameras by their names.
    """
    names, camera = [], camera_objects.camera_of(scene)
    if camera is None:
        camera = min(camera_objects.cameras_of(scene), key=lambda one: one.name)
    for index in indices:
        data = camera.data.copy()
        data.animation_data_clear()
        data.dof.use_dof = False
        data.dof.focus_object = None  # sampling.py sets a distance
        made = bpy.data.objects.new(f"Rack Focus_v{index:02d}", data)
        made[MARK] = index
        copy.collection.objects.link(made)
        names.append(made.name)
    views = copy.render.views
    while len(views) <= len(indices):
        views.new("view")
    for view, index, name in zip(views, indices, names, strict=False):
        view.name = f"v{index:02d}"
        view.camera_suffix = view.file_suffix = name
    return names


def remove(copy):
    """Removes the cameras of a copy."""
    for item in [o for o in copy.collection.objects if MARK in o]:
        data = item.data
        bpy.data.objects.remove(item)
        bpy.data.cameras.remove(data)


def is_of_view(camera):
    """Is it one of the cameras that were made for views?"""
    return camera is not None and MARK in camera


# ---- looking through them ---------------------------------------------------------


def has_camera(copy, camera):
    """Do views of a camera object leave it the copy's camera?"""
    render = copy.render
    return render.use_multiview and render.views[-1].camera_suffix == camera.name


def look_through(copy, camera, names):
    """Lets a copy render the views of a camera object, in a frame.

    names: of the objects of add() whose views are rendered; they become children of the
    camera, which is the copy's where its name allows that. Else the first view's is.
    """
    for name in names:
        view_camera = bpy.data.objects[name]
        if view_camera.parent != camera:
            view_camera.parent = camera
    *views, base = copy.render.views
    for view in views:
        view.use = view.camera_suffix in names
    base.use = False
    set_if_other(base, "camera_suffix", camera.name)
    is_found = has_camera(copy, camera)
    set_if_other(copy, "camera", camera if is_found else bpy.data.objects[names[0]])


def put(camera, seen, made, distance, point, is_first):
    """Places one camera for a view, a child of the user's; returns its passes.Place.

    seen: the user's camera, evaluated; made: its rackfocus.Lens; distance: of the plane
    that stays in place; point: of the lens, (u, v, time), and (x, y) of the part of its
    pixels, for the shift; is_first: in this frame.
    """
    radius = made.lens_radius
    u, v = (float(np.float32(radius * part)) for part in point[:2])
    data, own, settings = camera.data, seen.data, camera.parent.data.rack_focus
    for name in ("type", "lens", "ortho_scale", "sensor_width", "sensor_height"):
        set_if_other(data, name, getattr(own, name))
    for name in ("sensor_fit", "clip_start", "clip_end"):
        set_if_other(data, name, getattr(own, name))
    shift, factor = Vector((own.shift_x, own.shift_y)) + Vector(point[3:]), 1.0
    move = Matrix.Translation((u, v, 0))
    is_look_at = settings.method == "accumulate" and settings.camera_move == "look_at"
    if is_look_at:
        move = move @ _turn_towards(Vector((u, v, distance)))
    elif own.type == "ORTHO":
        move[0][2], move[1][2] = u / distance, v / distance
        factor = 1 / math.sqrt(1 + (u * u + v * v) / distance**2)
    else:
        side = own.sensor_height if own.sensor_fit == "VERTICAL" else own.sensor_width
        shift -= Vector((u, v)) * (own.lens / (distance * side))
    set_if_other(data, "shift_x", shift.x)
    set_if_other(data, "shift_y", shift.y)
    # The scale of the user's camera counts for nothing.
    lengths = [column.length for column in seen.matrix_world.to_3x3().col]
    inverse = Matrix.Diagonal((*lengths, 1)).inverted() @ move
    if is_first or camera.matrix_parent_inverse != inverse:
        camera.matrix_parent_inverse = inverse
    return passes.Place((u, v), 0.0 if is_look_at else distance, factor, point[2])


def _turn_towards(back):
    """Rotation of a camera whose axis runs back along a vector, its top upwards."""
    z = back.normalized()
    x = Vector((0, 1, 0)).cross(z).normalized()
    return Matrix((x, z.cross(x), z)).transposed().to_4x4()
