# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenEXR MultiLayer files of renders in whose place copies of the scene are rendered.

Blender writes such a file from the result of the scene itself, which has nothing but the
composite then: its view layers are black, and their passes are missing. Once it is
written, a file takes its place that has the layers of the first view beside it, of one
part and without loss (ZIP, where the artist asked for another codec). What the Image
Editor saves has the picture alone: the box says so.
"""

from pathlib import Path

import bpy
import numpy as np

from . import compat, exr, failures, passes, view_passes, views

SAVED = (
    "The OpenEXR MultiLayer file of a render has the passes of one of the views;",
    "one that the Image Editor saves has the picture alone (Composite)",
)
LACKS = (
    "With several views or Supersample the OpenEXR MultiLayer file",
    "has the picture alone (Composite), and black view layers, where a",
    "colour space of its own is set: save passes with File Output nodes",
)
LARGEST_HALF = 65504


def is_asked(scene):
    """Does the scene's own file lack the passes of its view layers?"""
    return compat.writes_passes(scene) and views.renders_copies(scene)


def _has_own_space(scene):
    """Have the files another colour space than the scene, which passes come in?"""
    settings = scene.render.image_settings
    return getattr(settings, "color_management", "") == "OVERRIDE"


def describe(scene):
    """Lines for the panel on what a file of the scene lacks."""
    if not is_asked(scene):
        return []
    return list(LACKS if _has_own_space(scene) else SAVED)


def why_not(scene):
    """Lines for the console on why the file of a render stays without passes."""
    return list(LACKS) if is_asked(scene) and _has_own_space(scene) else []


def complete(scene):
    """Puts the passes of a frame into the file that Blender has just written."""
    if not views.has_copies(scene) or not is_asked(scene) or _has_own_space(scene):
        return
    found, path = passes.rendered(scene), _path_of(scene)
    if path is None:
        return
    rendered, suffix, view = found, "", ""
    if isinstance(found, view_passes.ViewPasses):
        rendered, suffix, view = found.files[0]
    try:
        _write(scene, path, rendered.files[suffix], rendered.about[suffix], view)
    except OSError as error:
        failures.say(
            scene,
            f"“{path}” has the picture alone: its passes cannot be written "
            f"({error.strerror}). Make room, or choose another folder",
        )


def _path_of(scene):
    """The file that has just been written, of which one frame has no number; or None."""
    render = scene.render
    name = bpy.path.abspath(render.filepath)
    if render.use_file_extension:
        name = bpy.path.ensure_ext(name, render.file_extension)
    paths = [Path(name), Path(render.frame_path(frame=scene.frame_current))]
    times = {path: path.stat().st_mtime_ns for path in paths if path.is_file()}
    return max(times, key=times.get, default=None)


def _write(scene, path, layers, about, view):
    """Replaces a file; layers, about: of a view, as of passes.RenderedPasses."""
    own = passes.RenderedPasses(scene)
    planes = dict(next(iter(own.files.values())))
    planes |= {name.replace(f".{view}.", "."): one for name, one in layers.items()}
    if len({plane.shape for plane in planes.values()}) > 1:
        return
    settings = scene.render.image_settings
    if settings.color_depth == "16":
        planes = {name: _as_blender(name, plane) for name, plane in planes.items()}
    attributes = about | next(iter(own.about.values()))
    codec = settings.exr_codec if settings.exr_codec in exr.CODECS else "ZIP"
    exr.write_exr(path, planes, b"".join(attributes.values()), codec)


def _as_blender(name, plane):
    """A plane of a file of 16 bits, in which colours alone are halves."""
    if name.rsplit(".", 1)[-1] not in "RGBA":
        return plane
    return np.clip(plane, -LARGEST_HALF, LARGEST_HALF).astype("<f2")
