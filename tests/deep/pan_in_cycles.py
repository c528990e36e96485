# SPDX-License-Identifier: Apache-2.0
"""Run inside Blender by measure_hosts.py: its scene, a tenth of the size, since Blender
knows no f-stop as small as a lens radius of 0.28 wants.

    blender -b --factory-startup -P pan_in_cycles.py -- JOBS.json
"""

import json
import sys
from pathlib import Path

import bpy

ABOUT = json.loads(Path(sys.argv[-1]).read_text())
SCALE = 0.1


def glowing(colour):
    material = bpy.data.materials.new("glow")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    light = nodes.new("ShaderNodeEmission")
    light.inputs["Color"].default_value = (*colour, 1)
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(light.outputs["Emission"], output.inputs["Surface"])
    return material


def card(x0, x1, z, material):
    """A tall rectangle before the camera, which looks along -z."""
    corners = [(x0, -9, -z), (x1, -9, -z), (x1, 9, -z), (x0, 9, -z)]
    mesh = bpy.data.meshes.new("card")
    mesh.from_pydata([[SCALE * c for c in p] for p in corners], [], [(0, 1, 2, 3)])
    mesh.materials.append(material)
    bpy.context.collection.objects.link(bpy.data.objects.new("card", mesh))


def build():
    for one in list(bpy.data.objects):
        bpy.data.objects.remove(one)
    scene = bpy.context.scene
    scene.world.use_nodes = False
    scene.world.color = (0, 0, 0)
    wall = [glowing(ABOUT["dark"]), glowing(ABOUT["bright"])]
    for k in range(-8, 8):
        card(2.5 * k, 2.5 * (k + 1), 14, wall[k % 2])
    if ABOUT["has_post"]:
        card(-0.22, 0.02, 3, glowing(ABOUT["red"]))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    bpy.context.collection.objects.link(camera)
    scene.camera = camera
    lens = camera.data
    lens.sensor_fit = "HORIZONTAL"
    lens.lens = lens.sensor_width * ABOUT["focal_px"] / ABOUT["width"]
    lens.dof.focus_distance = SCALE * ABOUT["focus"]
    lens.dof.aperture_fstop = lens.lens / 1000 / (2 * SCALE * ABOUT["lens_radius"])
    lens.clip_start, lens.clip_end = 0.01, 10
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = ABOUT["width"], ABOUT["height"]
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    bpy.context.view_layer.use_pass_z = True
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_denoising = False
    return scene, camera


def main():
    scene, camera = build()
    for job in ABOUT["jobs"]:
        camera.data.dof.use_dof = job["has_lens"]
        scene.cycles.samples = job["samples"]
        scene.cycles.use_adaptive_sampling = job["is_adaptive"]
        for i in range(ABOUT["n_frames"]):
            scene.cycles.seed = i if job["other_seeds"] else 0
            camera.location = (SCALE * i * ABOUT["step"], 0, 0)
            scene.render.filepath = str(Path(job["folder"]) / f"in.{i}.exr")
            bpy.ops.render.render(write_still=True)


main()
