# SPDX-License-Identifier: Apache-2.0
"""Times Blender's Defocus node on one frame, inside Blender.

    blender -b --factory-startup -P defocus_node.py -- IN.exr OUT.exr K FOCUS RADIUS
        RUNS THREADS

IN.exr holds R G B A and Z. K is the lens: the radius of a point at depth z is
K (1/FOCUS - 1/z) px, RADIUS the largest. Prints one line per run: "defocus WALL CPU
BASE_WALL BASE_CPU" in seconds, BASE the same render with the node muted.
"""

import os
import sys
import time

import bpy

FOCAL_MM, SENSOR_MM = 50.0, 36.0
#: Depth in Blender's units; keeps the f-stop within the range of the node.
DEPTH_SCALE = 1e-3


def seconds():
    """Wall and CPU seconds."""
    times = os.times()
    return time.perf_counter(), times.user + times.system


def set_lens(node, camera, width, height, lens_k, focus):
    """Makes the node's radius K (1/focus - 1/z) px, exactly.

    Blender 3.4 computes r = a/2 (d (1/f - 1/z) - 1), a = focal / (2 aspect sensor
    f-stop), d = min(width, height) 2 focal / sensor (ConvertDepthToRadiusOperation):
    the -1 moves the focus, and the camera's focus distance moves it back.
    """
    aspect = min(width, height) / max(width, height)
    to_distance = min(width, height) * 2 * FOCAL_MM / SENSOR_MM
    camera.data.lens = FOCAL_MM
    camera.data.sensor_width = SENSOR_MM
    camera.data.sensor_fit = "HORIZONTAL"
    camera.data.dof.focus_distance = 1 / (1 / (focus * DEPTH_SCALE) + 1 / to_distance)
    aperture = 2 * lens_k * DEPTH_SCALE / to_distance
    node.f_stop = 0.5 * FOCAL_MM / (aspect * SENSOR_MM) / aperture


def build(path, lens_k, focus, radius):
    """Compositor nodes: the picture through the Defocus node; returns that node."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    image = bpy.data.images.load(path)
    scene.render.resolution_x, scene.render.resolution_y = image.size
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Raw"
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    source = tree.nodes.new("CompositorNodeImage")
    source.image = image
    scale = tree.nodes.new("CompositorNodeMath")
    scale.operation = "MULTIPLY"
    scale.inputs[1].default_value = DEPTH_SCALE
    node = tree.nodes.new("CompositorNodeDefocus")
    node.scene = scene
    node.use_zbuffer = True
    node.use_preview = False
    node.blur_max = radius
    node.bokeh = "CIRCLE"
    composite = tree.nodes.new("CompositorNodeComposite")
    outputs = source.outputs
    colour = outputs.get("Combined") or outputs["Image"]
    tree.links.new(outputs["Depth"], scale.inputs[0])
    tree.links.new(colour, node.inputs["Image"])
    tree.links.new(scale.outputs[0], node.inputs["Z"])
    tree.links.new(node.outputs["Image"], composite.inputs["Image"])
    set_lens(node, camera, *image.size, lens_k, focus)
    return node


def render():
    """Renders once and returns wall and CPU seconds."""
    before = seconds()
    bpy.ops.render.render(write_still=True)
    return [b - a for a, b in zip(before, seconds(), strict=True)]


def main():
    path, out, lens_k, focus, radius, runs, threads = sys.argv[
        sys.argv.index("--") + 1 :
    ]
    node = build(path, float(lens_k), float(focus), float(radius))
    render_settings = bpy.context.scene.render
    render_settings.threads_mode = "FIXED"
    render_settings.threads = int(threads)
    render_settings.filepath = out
    render_settings.image_settings.file_format = "OPEN_EXR"
    render_settings.image_settings.color_depth = "32"
    render_settings.image_settings.exr_codec = "NONE"
    for _ in range(int(runs)):
        node.mute = True
        base = render()
        node.mute = False
        full = render()
        print("defocus", *(f"{t:.4f}" for t in full + base), flush=True)


main()
