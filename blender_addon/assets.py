# SPDX-License-Identifier: GPL-3.0-or-later
"""rack_focus.make_assets: an asset library of cameras with looks and of the node.

It is written by the Blender that uses it, from presets.LOOKS: the same add-on makes the
same assets, and nothing binary travels with it. Cameras are dragged into a 3D view, the
node into a compositor.
"""

import os
from pathlib import Path

import bpy
import numpy as np
from bpy.props import StringProperty

from . import group, lens, presets, preferences
from .library import rackfocus

LIBRARY = "Rack Focus"  # its name in the preferences
FILE, CATALOGS = "rack_focus.blend", "blender_assets.cats.txt"
# name: id, any that nobody else has
IDS = {
    "Rack Focus": "5d0c9e2e-6f0a-4b1e-9d55-1d7c0f3a8b10",
    "Rack Focus/Cameras": "0f3a4a77-3a65-4f0f-8a62-6c0f7f9f2c11",
    "Rack Focus/Nodes": "7a1f3c55-91d4-4d39-9e0a-2b0c53f0aa12",
}
PREVIEW_PX = 128


def default_folder():
    """Where the library is made if nothing else is said."""
    return Path(bpy.utils.user_resource("DATAFILES")) / "rack_focus_assets"


def _catalogs():
    lines = ["VERSION 1", ""]
    lines += [f"{key}:{name}:{name.replace('/', '-')}" for name, key in IDS.items()]
    return "\n".join(lines) + "\n"


def bokeh(data):
    """(px, px, 4) of what a lens makes of a small light, for a preview."""
    px = PREVIEW_PX
    colour, depth = np.zeros((px, px, 4), np.float32), np.full((px, px), 10, np.float32)
    colour[..., 3] = 1
    colour[px // 2, px // 2, :3] = 1
    size = {"focus_distance": 5, "lens_radius": 1, "focal_length_px": 4 * px}
    params = {**data.rack_focus.method_parameters(), **size, "max_radius": 0}
    params.update(lens.aperture_parameters(data.dof), method="layered")
    made = rackfocus.apply(colour, depth, threads=preferences.threads(), **params)
    made[..., :3] /= max(float(made[..., :3].max()), 1e-9)
    made[..., 3] = 1
    return np.ascontiguousarray(made[::-1])


def _mark(item, catalog, about, picture=None):
    item.asset_mark()
    item.asset_data.catalog_id = IDS[catalog]
    item.asset_data.description = about
    item.asset_data.tags.new("Rack Focus")
    if picture is not None:
        preview = item.preview_ensure()
        preview.image_size = picture.shape[1::-1]
        preview.image_pixels_float.foreach_set(picture.reshape(-1))


def _new_cameras():
    """A camera object for each look."""
    for name, (about, of_lens, of_settings) in presets.LOOKS.items():
        data = bpy.data.cameras.new(name)
        item = bpy.data.objects.new(name, data)
        data.rack_focus.enabled = True
        for target, values in ((data.dof, of_lens), (data.rack_focus, of_settings)):
            for field, value in values.items():
                setattr(target, field, value)
        _mark(item, "Rack Focus/Cameras", about, bokeh(data))
        yield item


def write(folder):
    """Writes the library into a folder, made where it is missing; names of its assets.

    OSError where the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    cameras, node = list(_new_cameras()), group.new_group()
    try:
        about = "Blurs the picture linked to it: after Denoise, a composite, files"
        _mark(node, "Rack Focus/Nodes", about)
        items = {*cameras, node}
        names = sorted(item.name for item in items)
        part = folder / f"part_{FILE}"
        bpy.data.libraries.write(str(part), items, fake_user=True, compress=True)
        os.replace(part, folder / FILE)
        (folder / CATALOGS).write_text(_catalogs(), encoding="utf-8")
    except RuntimeError as error:
        raise OSError(str(error)) from error
    finally:
        for camera in cameras:
            data = camera.data
            bpy.data.objects.remove(camera)
            bpy.data.cameras.remove(data)
        bpy.data.node_groups.remove(node)
    return names


def name_library(folder):
    """Puts the folder into the preferences' list of asset libraries, once."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    found = next((one for one in libraries if one.name == LIBRARY), None)
    if found is None:
        bpy.ops.preferences.asset_library_add(directory=str(folder))
        found = libraries[-1]
        found.name = LIBRARY
    found.path = str(folder)


class RACK_FOCUS_OT_make_assets(bpy.types.Operator):
    """Make an asset library of cameras with looks, and of the node on an image"""

    bl_idname = "rack_focus.make_assets"
    bl_label = "Make Asset Library"

    directory: StringProperty(
        name="Folder",
        description="Of the library; empty: in Blender's folder of the user",
        subtype="DIR_PATH",
    )

    def execute(self, _context):
        """Writes it and names it in the preferences."""
        folder = default_folder()
        if self.directory:
            folder = Path(bpy.path.abspath(self.directory))
        try:
            names = write(folder)
        except OSError as error:
            self.report({"ERROR"}, f"“{folder}” cannot be written: {error}")
            return {"CANCELLED"}
        name_library(folder)
        self.report({"INFO"}, f"{len(names)} assets in “{folder}”")
        return {"FINISHED"}


def register():
    """Adds the operator."""
    bpy.utils.register_class(RACK_FOCUS_OT_make_assets)


def unregister():
    """Removes it."""
    bpy.utils.unregister_class(RACK_FOCUS_OT_make_assets)
