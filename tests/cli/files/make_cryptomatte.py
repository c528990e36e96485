# SPDX-License-Identifier: Apache-2.0
"""Makes cryptomatte.exr with Blender: two objects, depth, object identifiers.

blender -b --factory-startup -P make_cryptomatte.py -- cryptomatte.exr
"""

import sys

import bpy

scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.samples = 4
scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = 48, 32
scene.render.resolution_percentage = 100
bpy.ops.mesh.primitive_uv_sphere_add(location=(2, 2, 1))
layer = scene.view_layers[0]
layer.use_pass_z = True
layer.use_pass_cryptomatte_object = True
layer.pass_cryptomatte_depth = 4
settings = scene.render.image_settings
settings.file_format = "OPEN_EXR_MULTILAYER"
settings.exr_codec = "ZIP"
settings.color_depth = "32"
scene.render.filepath = sys.argv[-1]
scene.render.use_file_extension = False
bpy.ops.render.render(write_still=True)
