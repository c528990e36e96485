# SPDX-License-Identifier: Apache-2.0
"""Makes the file of the tutorial in docs/blender.md: a table with lamps behind it.

blender -b --factory-startup -P docs/make_blender_sample.py -- rack_focus_sample.blend
"""

import math
import os
import sys

import bpy


def material(name, colour, light=0.0, roughness=0.4):
    """A plain material, or one that glows."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    if light:
        glow = nodes.new("ShaderNodeEmission")
        glow.inputs["Color"].default_value = (*colour, 1)
        glow.inputs["Strength"].default_value = light
        links.new(glow.outputs[0], nodes["Material Output"].inputs["Surface"])
    else:
        shader = nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colour, 1)
        shader.inputs["Roughness"].default_value = roughness
    return made


def ball(name, radius, place, look):
    """A smooth sphere."""
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=32, ring_count=16, radius=radius, location=place
    )
    bpy.ops.object.shade_smooth()
    bpy.context.object.name = name
    bpy.context.object.data.materials.append(look)


def make_scene():
    """Table, balls at 0.8, 1.5 and 3 m, lamps at 8 m; the camera looks along y."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 4, -0.25))
    bpy.context.object.data.materials.append(material("table", (0.25, 0.14, 0.07)))
    for name, x, y, colour in (
        ("near", -0.18, 0.8, (0.7, 0.05, 0.04)),
        ("middle", 0.05, 1.5, (0.05, 0.3, 0.7)),
        ("far", 0.6, 3.0, (0.1, 0.5, 0.12)),
    ):
        ball(name, 0.12, (x, y, -0.13), material(name, colour))
    warm = material("lamp", (1.0, 0.7, 0.35), light=60)
    for index in range(24):
        x, z = (index % 8 - 3.5) * 0.8, 0.3 + (index // 8) * 0.7
        ball(f"lamp {index}", 0.025, (x + 0.3 * math.sin(3 * index), 8, z), warm)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2, (0.8, 0.2, 0.5)
    scene.collection.objects.link(sun)
    data = bpy.data.cameras.new("Camera")
    data.lens, data.dof.focus_distance, data.dof.aperture_fstop = 50, 1.5, 0.4
    camera = bpy.data.objects.new("Camera", data)
    camera.rotation_euler = (math.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def main(path):
    """Saves the file; some Blenders refuse names that do not begin at the root."""
    scene = make_scene()
    scene.render.engine, scene.cycles.samples = "CYCLES", 64
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(path))


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1])
