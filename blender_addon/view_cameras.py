# SPDX-License-Identifier: GPL-3.0-or-later
"""The cameras of several views, children of the user's one.

Blender renders a copy of the scene through them by native multi-view, which finds the
camera of a view by its name: it takes the suffix of any view, in use or not, off the end
of the name of the scene's camera, and puts that of the view in its place. With a view that
is not in use and whose suffix is the whole name, the user's camera stays that of the copy.
So drivers, Geometry Nodes and scripts that ask for the scene's camera find it where it is
in every view (a driver that reads it: 17.2 dB where 43.1 are right).

Of a name that is longer than a suffix may be (5.0) the suffix is the end, and the names
of the views' cameras begin as it does. Where Blender has no room for those, the copy's
camera is that of a view.
"""

import math

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import camera_objects, passes
from .writing import set_if_other

MARK = "rack_focus_view"  # custom property of our cameras: what add() gave for them
LONGEST_SUFFIX = 63  # bytes, of a view's camera and of the name that Blender looks for


# ---- making them ------------------------------------------------------------------


def add(scene, copy, indices):
    """One camera for each view of a copy of a scene; returns their suffixes.

    indices: numbers of the views. Multi-view finds the cameras by their names, which end
    with these.
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
        made[MARK] = made.name
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


def find(copy, suffix):
    """The camera of a copy that add() gave a suffix for."""
    return next(o for o in copy.collection.objects if o.get(MARK) == suffix)


def is_of_view(camera):
    """Is it one of the cameras that were made for views?"""
    return camera is not None and MARK in camera


# ---- looking through them ---------------------------------------------------------


def has_camera(copy, camera):
    """Do views of a camera object leave it the copy's camera?"""
    start, end = _split(camera.name)
    render = copy.render
    if not render.use_multiview or render.views[-1].camera_suffix != end:
        return False
    ours = [o for o in copy.collection.objects if MARK in o]
    longest = max((len(o.name.encode()) for o in ours), default=0)
    is_named = all(o.name == start + o[MARK] for o in ours)
    return is_named and (not start or longest <= LONGEST_SUFFIX)


def _split(name):
    """(start, end) of a camera's name; the end is what a suffix has room for."""
    end = name.encode()[-LONGEST_SUFFIX:].decode(errors="ignore")
    return name[: len(name) - len(end)], end


def look_through(copy, camera, suffixes):
    """Lets a copy render the views of a camera object, in a frame.

    suffixes: of add(), of the views that are rendered; their cameras become children of
    the camera, which is the copy's where its name allows that. Else the first view's is.
    """
    start, end = _split(camera.name)
    for item in [o for o in copy.collection.objects if MARK in o]:
        set_if_other(item, "name", start + item[MARK])
    view_cameras = [find(copy, suffix) for suffix in suffixes]
    for view_camera in view_cameras:
        if view_camera.parent != camera:
            view_camera.parent = camera
    *views, base = copy.render.views
    for view in views:
        view.use = view.camera_suffix in suffixes
    base.use = False
    set_if_other(base, "camera_suffix", end)
    is_found = has_camera(copy, camera)
    if not is_found:  # Blender then finds them by their own names
        for item in [o for o in copy.collection.objects if MARK in o]:
            set_if_other(item, "name", item[MARK])
        set_if_other(base, "camera_suffix", camera.name)
    set_if_other(copy, "camera", camera if is_found else view_cameras[0])


def put(camera, seen, made, distance, point, wide=1.0):
    """Places one camera for a view, a child of the user's; returns its passes.Place.

    seen: the user's camera, evaluated; made: its rackfocus.Lens; distance: of the plane
    that stays in place; point: of the lens, (u, v, time), and (x, y) of the part of its
    pixels, for the shift; wide: of overscan.py.
    """
    radius = made.lens_radius
    u, v = (float(np.float32(radius * part)) for part in point[:2])
    data, own, settings = camera.data, seen.data, camera.parent.data.rack_focus
    for name in ("type", "lens", "sensor_fit", "clip_start", "clip_end"):
        set_if_other(data, name, getattr(own, name))
    for name in ("ortho_scale", "sensor_width", "sensor_height"):
        set_if_other(data, name, getattr(own, name) * wide)
    shift, factor = Vector((own.shift_x, own.shift_y)) / wide + Vector(point[3:]), 1.0
    move = Matrix.Translation((u, v, 0))
    is_look_at = settings.method == "accumulate" and settings.camera_move == "look_at"
    if is_look_at:
        move = move @ _turn_towards(Vector((u, v, distance)))
    elif own.type == "ORTHO":
        move[0][2], move[1][2] = u / distance, v / distance
        factor = 1 / math.sqrt(1 + (u * u + v * v) / distance**2)
    else:
        side = own.sensor_height if own.sensor_fit == "VERTICAL" else own.sensor_width
        shift -= Vector((u, v)) * (own.lens / (distance * side * wide))
    set_if_other(data, "shift_x", shift.x)
    set_if_other(data, "shift_y", shift.y)
    # The scale of the user's camera counts for nothing.
    lengths = [column.length for column in seen.matrix_world.to_3x3().col]
    # Where it is the same, too: 3.4 evaluates a new parent with the first write after it
    # only, and after a write to the data while the shutter is open (a shift, a lens or
    # a focus that moves) takes the camera for one without a parent: 14.9 dB for 42.
    camera.matrix_parent_inverse = Matrix.Diagonal((*lengths, 1)).inverted() @ move
    shear_distance = 0.0 if is_look_at else distance
    return passes.Place((u, v), shear_distance, factor, point[2])


def _turn_towards(back):
    """Rotation of a camera whose axis runs back along a vector, its top upwards."""
    z = back.normalized()
    x = Vector((0, 1, 0)).cross(z).normalized()
    return Matrix((x, z.cross(x), z)).transposed().to_4x4()
