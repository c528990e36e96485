# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render of a scene was taken with, beside the lens: region and camera.

A refocus filters that render. Where one of another size or region would be wanted, it is
refused; where the camera stands elsewhere now, the picture is made and the render says so.
What else changed since counts for Finish alone, which renders once more.
"""

from typing import NamedTuple

import numpy as np

from . import lens, names, passes

LARGEST_SCALE = 4  # of a supersampled render
CLOSE = 1e-5  # of numbers that say where a camera stands and what it sees


class Taken(NamedTuple):
    """Of one render."""

    region: tuple  # ((left, right), (low, high)) in px, None for the whole frame
    is_cut: bool  # is the picture only the region?
    size: tuple  # (width, height) in px of the whole frame
    camera: str  # name of the object
    place: np.ndarray  # numbers that say where it stands and what it sees


_taken = names.store()  # scene name: Taken of its last render
_changed = names.store()  # scene name: True, where what it shows changed since
# Datablocks whose changes are none of what is seen, or are told elsewhere.
UNSEEN = ("Camera", "Collection", "CompositorNodeTree", "Scene", "ViewLayer")


def _region(render):
    """(region, is_cut, size) of render settings; see Taken."""
    size = lens.picture_size(render)
    if not render.use_border:
        return None, False, size
    return lens.region_of(render, *size), render.use_crop_to_border, size


def _place(camera, render):
    """See Taken; camera: evaluated."""
    if camera.type != "CAMERA":
        return np.empty(0)
    data = camera.data
    kinds = data.type == "ORTHO", data.sensor_fit == "VERTICAL"
    values = [c for row in camera.matrix_world for c in row]
    values += [data.ortho_scale if kinds[0] else data.lens, *map(float, kinds)]
    values += [data.sensor_width, data.sensor_height, data.shift_x, data.shift_y]
    return np.array([*values, lens.aspect_of(render)])


def note(scene, camera):
    """A render of a scene has ended; camera: the evaluated object it looked through."""
    place = _place(camera, scene.render)
    _taken[scene.name] = Taken(*_region(scene.render), camera.name, place)
    _changed.pop(scene.name, None)


def follow(depsgraph):
    """Notes a change of what a scene shows; depsgraph: of the change, or None."""
    if depsgraph is None or depsgraph.scene.name not in _taken:
        return
    if any(map(_is_seen, depsgraph.updates)):
        _changed[depsgraph.scene.name] = True


def _is_seen(update):
    """Does a change concern what is rendered? Frames and our own changes are none."""
    changed = update.id
    kind = changed.bl_rna.identifier
    if kind != "Object":
        is_any = update.is_updated_geometry or update.is_updated_shading
        return is_any and kind not in UNSEEN
    is_empty = changed.type == "EMPTY" and changed.instance_type == "NONE"
    is_moved = update.is_updated_transform or update.is_updated_geometry
    return is_moved and changed.type != "CAMERA" and not is_empty


def has_changed(scene):
    """Was something that a scene shows changed since its last render?"""
    return scene.name in _changed


def forget(scene=None):
    """What is kept is no render of this session, or of none that is known."""
    for kept in (_taken, _changed):
        kept.clear() if scene is None else kept.pop(scene.name, None)


def why_refused(scene, size):
    """Why what is kept is no picture of the present frame, in the artist's words, or "".

    size: (width, height) in px of what is kept.
    """
    region, is_cut, whole = _region(scene.render)
    part = region and tuple(most - least for least, most in region)
    now = part if is_cut else whole
    # Of a region in a whole frame, files have the part alone.
    scales = range(1, LARGEST_SCALE + 1)
    fitting = [
        (w * scale, h * scale) for w, h in {now, part or now} for scale in scales
    ]
    if size not in fitting:
        return (
            f"the last render has {size[0]} x {size[1]} px, and the picture would have "
            f"{now[0]} x {now[1]}: press F12"
        )
    made = _taken.get(scene.name)
    if made is None or made.region is None or made.size != whole:
        return ""
    is_within = region is not None and all(
        old[0] <= new[0] and new[1] <= old[1]
        for old, new in zip(made.region, region, strict=True)
    )
    if made.is_cut == is_cut and (region == made.region if is_cut else is_within):
        return ""
    return "the last render has another render region: press F12"


def why_not_this(scene, frame, camera):
    """Why a refocus shows no picture of a frame through a camera, evaluated, or ""."""
    made = passes.frame_of(scene)
    if made not in (None, frame):
        return f"this is the render of frame {made}: press F12 for frame {frame}"
    return _why_other(scene, camera)


def _why_other(scene, camera):
    """What the artist should know of a refocus through a camera, evaluated, or ""."""
    made = _taken.get(scene.name)
    if made is None:
        return ""
    place = _place(camera, scene.render)
    is_same = place.shape == made.place.shape
    if is_same and np.allclose(place, made.place, rtol=CLOSE, atol=CLOSE):
        return ""
    if camera.name != made.camera:
        return (
            f"this is the render of camera “{made.camera}”: press F12 for that of "
            f"“{camera.name}”"
        )
    return (
        f"camera “{camera.name}” has moved, or sees another part, since this was "
        "rendered: press F12"
    )
