# SPDX-License-Identifier: Apache-2.0
"""Materials, shapes and light of the Cycles test scenes (cycles_scenes.py)."""

import math

import bpy
from mathutils import Vector


# --- materials ------------------------------------------------------------------


def _texture_nodes(tree, kind, scale, colours):
    """Adds a procedural texture in object coordinates; returns its colour socket."""
    coords = tree.nodes.new("ShaderNodeTexCoord").outputs["Object"]
    if kind == "noise":
        texture = tree.nodes.new("ShaderNodeTexNoise")
        texture.inputs["Detail"].default_value = 4.0
        ramp = tree.nodes.new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].position = 0.38
        ramp.color_ramp.elements[1].position = 0.62
        for element, colour in zip(ramp.color_ramp.elements, colours, strict=True):
            element.color = (*colour, 1.0)
        tree.links.new(texture.outputs["Fac"], ramp.inputs["Fac"])
        colour_out = ramp.outputs["Color"]
    else:
        texture = tree.nodes.new(
            {"checker": "ShaderNodeTexChecker", "brick": "ShaderNodeTexBrick"}[kind]
        )
        for index, colour in enumerate(colours, start=1):
            texture.inputs[f"Color{index}"].default_value = (*colour, 1.0)
        if kind == "brick":
            texture.inputs["Mortar"].default_value = (0.55, 0.53, 0.5, 1.0)
        colour_out = texture.outputs["Color"]
    texture.inputs["Scale"].default_value = scale
    tree.links.new(coords, texture.inputs["Vector"])
    return colour_out


def make_material(colours, kind="plain", scale=1.0, gloss=0.0, roughness=0.3):
    """A diffuse material with some gloss; one colour, or two for a texture."""
    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    if kind == "plain":
        shader.inputs["Color"].default_value = (*colours, 1.0)
    else:
        tree.links.new(
            _texture_nodes(tree, kind, scale, colours), shader.inputs["Color"]
        )
    if gloss > 0.0:
        glossy = tree.nodes.new("ShaderNodeBsdfGlossy")
        glossy.inputs["Roughness"].default_value = roughness
        mix = tree.nodes.new("ShaderNodeMixShader")
        mix.inputs["Fac"].default_value = gloss
        tree.links.new(shader.outputs[0], mix.inputs[1])
        tree.links.new(glossy.outputs[0], mix.inputs[2])
        shader = mix
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def make_glass(colour, roughness=0.0):
    """Clear glass; needs more bounces than one (see Camera.bounces)."""
    return make_shader("ShaderNodeBsdfGlass", colour, roughness)


def make_mirror(colour, roughness=0.0):
    """Polished metal."""
    return make_shader("ShaderNodeBsdfGlossy", colour, roughness)


def make_shader(kind, colour, roughness):
    """A material of one shader node that has a colour and a roughness."""
    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new(kind)
    shader.inputs["Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def make_cutout(colour, n):
    """A diffuse material in some n x n cells of a card, which is open between them."""
    material = make_material(colour)
    tree = material.node_tree
    output = tree.nodes["Material Output"]
    coords = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    cells = tree.nodes.new("ShaderNodeTexVoronoi")
    cells.inputs["Scale"].default_value = n
    inside = tree.nodes.new("ShaderNodeMath")
    inside.operation = "LESS_THAN"
    inside.inputs[1].default_value = 0.45
    mix = tree.nodes.new("ShaderNodeMixShader")
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    diffuse = tree.nodes["Diffuse BSDF"]
    tree.links.new(coords, cells.inputs["Vector"])
    tree.links.new(cells.outputs["Distance"], inside.inputs[0])
    tree.links.new(inside.outputs[0], mix.inputs["Fac"])
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(diffuse.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return material


def make_emission(colour, strength):
    """A lamp's material. It is seen but lights nothing, which keeps the noise down."""
    material = bpy.data.materials.new("lamp")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (*colour, 1.0)
    shader.inputs["Strength"].default_value = strength
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    if hasattr(material.cycles, "emission_sampling"):
        material.cycles.emission_sampling = "NONE"
    else:
        material.cycles.sample_as_light = False
    return material


# --- shapes ---------------------------------------------------------------------


def add_mesh(vertices, faces, material, location=(0, 0, 0), rotation_deg=(0, 0, 0)):
    """Links a mesh object into the scene and returns it."""
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(vertices, [], faces)
    mesh.materials.append(material)
    mesh.update()
    thing = bpy.data.objects.new("thing", mesh)
    thing.location = location
    thing.rotation_euler = [math.radians(angle) for angle in rotation_deg]
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_quad(width, height, material, location, rotation_deg=(0, 0, 0)):
    """A rectangle in its own xy plane; rotate by 90 degrees about x for a wall."""
    x, y = width / 2, height / 2
    corners = [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)]
    return add_mesh(corners, [(0, 1, 2, 3)], material, location, rotation_deg)


def add_box(size, material, location, turn_deg=0.0):
    """A box of (x, y, z) sizes around `location`, turned about the vertical."""
    x, y, z = (side / 2 for side in size)
    corners = [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    faces = [
        (0, 1, 3, 2),
        (4, 6, 7, 5),
        (0, 4, 5, 1),
        (2, 3, 7, 6),
        (0, 2, 6, 4),
        (1, 5, 7, 3),
    ]
    return add_mesh(corners, faces, material, location, (0, 0, turn_deg))


def add_rod(start, end, radius, material, sides=10):
    """A thin open cylinder between two points."""
    start, end = Vector(start), Vector(end)
    turn = (end - start).to_track_quat("Z", "Y")
    ring = [
        Vector((math.cos(angle), math.sin(angle), 0)) * radius
        for angle in (2 * math.pi * i / sides for i in range(sides))
    ]
    vertices = [tuple(p + turn @ v) for p in (start, end) for v in ring]
    faces = [
        (i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides)
    ]
    return add_mesh(vertices, faces, material)


def add_ball(radius, material, location, detail=32):
    """A smooth sphere."""
    rings, sectors = detail // 2, detail
    vertices = [(0, 0, radius)]
    for i in range(1, rings):
        theta = math.pi * i / rings
        for j in range(sectors):
            phi = 2 * math.pi * j / sectors
            ring = radius * math.sin(theta)
            vertices.append(
                (ring * math.cos(phi), ring * math.sin(phi), radius * math.cos(theta))
            )
    vertices.append((0, 0, -radius))
    last = len(vertices) - 1
    faces = []
    for j in range(sectors):
        k = (j + 1) % sectors
        faces.append((0, 1 + j, 1 + k))
        for i in range(rings - 2):
            a, b = 1 + i * sectors, 1 + (i + 1) * sectors
            faces.append((a + j, b + j, b + k, a + k))
        a = 1 + (rings - 2) * sectors
        faces.append((a + j, last, a + k))
    ball = add_mesh(vertices, faces, material, location)
    ball.data.polygons.foreach_set("use_smooth", [True] * len(faces))
    return ball


def add_lamp(location, radius, colour, strength):
    """A small glowing ball that only camera rays can see."""
    lamp = add_ball(radius, make_emission(colour, strength), location, detail=12)
    for ray in ("diffuse", "glossy", "transmission", "shadow"):
        setattr(lamp, f"visible_{ray}", False)
    return lamp


def add_leaf(length, width, material, location, rotation_deg):
    """A leaf: a hexagon folded a little along its middle."""
    h, w, fold = length / 2, width / 2, width * 0.15
    outline = [
        (0, -h, 0),
        (w, -h / 3, fold),
        (w, h / 3, fold),
        (0, h, 0),
        (-w, h / 3, fold),
        (-w, -h / 3, fold),
    ]
    faces = [(0, 1, 2, 3), (0, 3, 4, 5)]
    return add_mesh(outline, faces, material, location, rotation_deg)


# --- light ----------------------------------------------------------------------


def set_light(sky, sky_strength, sun_strength, sun_turn_deg=(50, 0, -35)):
    """One sun and a uniform sky."""
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*sky, 1.0)
    background.inputs["Strength"].default_value = sky_strength
    bpy.context.scene.world = world
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy = sun_strength
    sun.angle = math.radians(2)
    lamp = bpy.data.objects.new("sun", sun)
    lamp.rotation_euler = [math.radians(angle) for angle in sun_turn_deg]
    bpy.context.scene.collection.objects.link(lamp)
