# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes of a render as files that the command and this add-on read.

passesFFFF.exr, with several view layers passesFFFF_LAYER.exr, with several views
passesFFFF_v00.exr and so on (FFFF: number of the frame): R G B A Z of 32-bit floats,
uncompressed; Freestyle.R to .A where there are lines. The header says what the camera was and where on the lens a view was taken
(rackfocus:lensOffset, rackfocus:shearDistance).
"""

import glob
import os
import re
import struct
from pathlib import Path

import bpy

from . import camera_objects, exr, freestyle, passes, sharp
from .library import rackfocus

OFFSET, SHEAR = "rackfocus:lensOffset", "rackfocus:shearDistance"
TIME, SPREAD = "rackfocus:shutterTime", "rackfocus:pixelSpread"
NEW = ".new"  # behind the names of files until all of them are there
SHARP = "sharp.coverage"  # channel: how much of a pixel stays sharp
# of parameters that say what the camera was, and what it makes of the light
GROUPS = ("lens", "aperture", "depth", "highlights")


class KeepError(Exception):
    """The passes were not kept; the message is for the user."""


# ---- names ------------------------------------------------------------------------


def why_not(camera_data):
    """Why passes are not kept though a camera's settings ask for it, or ""."""
    path = camera_data.rack_focus.passes_folder
    if path.startswith("//") and not bpy.data.filepath:  # Blender takes where it runs
        return f"Keep Passes: “{path}” lies beside the file, which is not saved yet: save it"
    return ""


def folder_of(camera_data):
    """The folder that a camera's settings name, or None."""
    path = camera_data.rack_focus.passes_folder
    is_known = path and not why_not(camera_data)
    return Path(bpy.path.abspath(path)) if is_known else None


def stem_of(scene, frame, layer, suffix=""):
    """Start of the name of a frame's files; suffix: of the view in stereo."""
    used = [one.name for one in scene.view_layers if one.use]
    part = "_" + re.sub(r"[^\w.-]", "_", layer) if len(used) > 1 else ""
    return f"passes{frame:04d}{part}{suffix}"


def stems_of(scene, frame):
    """Those of all view layers and views of a frame."""
    suffixes = ["", *(view.file_suffix for view in scene.render.views)]
    layers = [layer.name for layer in scene.view_layers]
    return {stem_of(scene, frame, name, end) for name in layers for end in suffixes}


def _views_of(folder, stem, others=()):
    """Paths of a frame's views in their order; others: stems that are no views."""
    paths = folder.glob(f"{glob.escape(stem)}_v*.exr")
    number = re.compile(re.escape(stem) + r"_v(\d+)")
    found = {p: number.fullmatch(p.stem) for p in paths if p.stem not in others}
    found = {path: int(match[1]) for path, match in found.items() if match}
    return sorted(found, key=found.get)


# ---- writing ----------------------------------------------------------------------


def lens_attributes(params):
    """Header attributes, as bytes, of the parameters of GROUPS."""
    found = b""
    for p in rackfocus.parameters():
        if p.group not in GROUPS or p.field not in params:
            continue
        value = params[p.field]
        if p.field == "lens_radius" and not value:
            continue  # it follows from f-stop and focal length
        if p.type == "enum":
            found += exr.text(p.attribute, value)
        elif p.type == "float":
            found += exr.attribute(p.attribute, "double", struct.pack("<d", value))
        else:
            found += exr.attribute(p.attribute, "int", struct.pack("<i", value))
    return found + exr.text("rackfocus:depth", "planar")


def place_attributes(place):
    """Header attributes, as bytes, of a passes.Place."""
    offset = struct.pack("<2f", *place.offset)
    numbers = {SHEAR: place.shear_distance, TIME: place.time}
    if place.spread_px:
        numbers[SPREAD] = place.spread_px
    return exr.attribute(OFFSET, "v2f", offset) + b"".join(
        exr.attribute(name, "double", struct.pack("<d", value))
        for name, value in numbers.items()
    )


def write(folder, stem, found, params, kept_sharp=(), others=()):
    """Writes the views of a view layer, [(passes.Layer, passes.Place)].

    folder: Path, made where it is missing; stem: from stem_of(); params: of the lens;
    kept_sharp: names of objects, whose coverage is a channel; others: from stems_of().
    What an earlier render of the frame left goes once all views are there.
    KeepError where the folder cannot be written.
    """
    paths = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, channels, attributes in _files(stem, found, params, kept_sharp):
            paths.append(folder / f"{name}.exr")
            exr.write_exr(f"{paths[-1]}{NEW}", channels, attributes)
        for path in paths:
            os.replace(f"{path}{NEW}", path)
        for old in [*_views_of(folder, stem, others), folder / f"{stem}.exr"]:
            if old not in paths:
                old.unlink(missing_ok=True)
    except OSError as error:
        raise KeepError(
            f"Keep Passes: “{folder}” cannot be written ({error.strerror}); choose "
            "another folder"
        ) from error
    finally:
        for path in paths:
            Path(f"{path}{NEW}").unlink(missing_ok=True)


def _files(stem, found, params, kept_sharp):
    """(name, channels, attributes) of each view; see write()."""
    lens = lens_attributes(params)
    for index, (one, place) in enumerate(found):
        is_view = len(found) > 1
        name = stem + (f"_v{index:02d}" if is_view else "")
        channels = {c: one.colour[..., i] for i, c in enumerate("RGBA")}
        channels["Z"] = one.depth
        if one.rays is not None:
            channels[f"{passes.RAYS}.Z"] = one.rays
        covered = sharp.coverage(one.mattes, kept_sharp)
        if covered is not None:
            channels[SHARP] = covered
        if one.lines is not None:
            channels |= {
                f"{freestyle.NAME}.{c}": one.lines[..., i] for i, c in enumerate("RGBA")
            }
        yield name, channels, lens + (place_attributes(place) if is_view else b"")


# ---- reading ----------------------------------------------------------------------


class KeptFiles:
    """The files of a frame in the place of its render."""

    def __init__(self, scene, folder, frame):
        self.scene, self.folder, self.frame = scene, folder, frame
        if not self._all_paths():
            raise passes.PassesError(
                f"there is no render to filter yet, nor passes of frame {frame} in "
                f"“{folder}”: press F12 first"
            )

    def _all_paths(self):
        views = camera_objects.views_of(self.scene.render)
        suffixes = [view.file_suffix for view in views] or [""]
        used = [one.name for one in self.scene.view_layers if one.use]
        return [p for name in used for end in suffixes for p in self._paths(name, end)]

    def _paths(self, layer, suffix=""):
        stem = stem_of(self.scene, self.frame, layer, suffix)
        views = _views_of(self.folder, stem, stems_of(self.scene, self.frame))
        single = self.folder / f"{stem}.exr"
        if not single.exists():
            return views
        is_older = views and single.stat().st_mtime < views[0].stat().st_mtime
        return views if is_older else [single]  # both: as an earlier version left them

    def views(self, name, suffix="", _view=""):
        """[(passes.Layer, passes.Place)] of a view layer."""
        self.need(name, suffix)
        return [_read(path) for path in self._paths(name, suffix)]

    def need(self, name, suffix="", _view=""):
        """PassesError where a view layer is missing."""
        if not self._paths(name, suffix):
            raise passes.PassesError(
                f"view layer “{name}” has no passes of frame {self.frame} in "
                f"“{self.folder}”: press F12"
            )

    def size(self):
        """(width, height) in px."""
        height, width = _read(self._all_paths()[0])[0].depth.shape
        return width, height

    def layer(self, name, suffix="", _view=""):
        """The passes.Layer of the first view."""
        return self.views(name, suffix)[0][0]


def _read(path):
    try:
        channels, attributes = exr.read_file(path)
    except (KeyError, ValueError, exr.ExrError, struct.error) as error:
        raise passes.PassesError(f"“{path}” is damaged ({error})") from error
    planes = {name.lstrip("."): plane for name, plane in channels.items()}
    missing = [c for c in "RGBAZ" if c not in planes]
    if missing:
        raise passes.PassesError(f"“{path}” lacks the channel {missing[0]}")
    mattes = ((None, planes[SHARP]),) if SHARP in planes else ()
    colour = passes.side_by_side([planes[c] for c in "RGBA"])
    lines = freestyle.lines_of(planes)
    rays = planes.get(f"{passes.RAYS}.Z")
    layer = passes.Layer(colour, planes["Z"], mattes, lines=lines, rays=rays)
    if OFFSET not in attributes:
        return layer, passes.MIDDLE
    shear = struct.unpack("<d", attributes[SHEAR])[0]
    time = struct.unpack("<d", attributes[TIME])[0]
    spread = struct.unpack("<d", attributes.get(SPREAD, b"\0" * 8))[0]
    return layer, passes.Place(
        struct.unpack("<2f", attributes[OFFSET]), shear, 1.0, time, spread
    )
