# SPDX-License-Identifier: GPL-3.0-or-later
"""Blended materials of EEVEE, to which it gives no depth.

Pictures on planes and what comes from glTF files have them, opaque parts too: they are
blurred like what is behind them. Box and console name one, and what to set.
"""

import bpy

from . import sets, shining, walked

IS_NEW = "surface_render_method" in bpy.types.Material.bl_rna.properties  # from 4.2 on
FIELD, VALUE, INSTEAD = (
    ("surface_render_method", "BLENDED", "Surface > Render Method to Dithered")
    if IS_NEW
    else ("blend_method", "BLEND", "Blend Mode to Alpha Hashed")
)


def describe(scene, camera):
    """Lines for the panel on such a material in what a camera of the scene shows."""
    if camera is None or camera.type != "CAMERA":
        return []
    needs_depth = camera.data.rack_focus.method != "accumulate"
    if not needs_depth or not scene.render.engine.startswith("BLENDER_EEVEE"):
        return []
    name = walked.once(_name_in, scene)
    if not name:
        return []
    return [
        f"“{name}” is blended: EEVEE gives it no depth.",
        f"Set Material > Settings > {INSTEAD}",
    ]


def _name_in(scene):
    """Name of such a material of an object that is rendered, or ""."""
    for layer in sets.layers_of(scene):
        for item in layer.objects:
            for material in shining.materials_of(item):
                if getattr(material, FIELD) == VALUE:
                    return material.name
    return ""
