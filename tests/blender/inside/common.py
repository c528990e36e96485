# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scripts that run inside Blender share: install, scenes, pictures."""

import os
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np

V = bpy.app.version
# 4.2 and 4.5, which go the way of 3.4 or of 5.0 (compat.py): what takes many renders is
# asked of those.
IS_BETWEEN = (4, 2, 0) <= V < (5, 0, 0)
IS_EXTENSION = V >= (4, 2, 0)
MODULE = "bl_ext.user_default.rack_focus" if IS_EXTENSION else "rack_focus"
KINDS = (
    "scenes objects cameras node_groups images materials meshes collections worlds "
    "textures actions texts"
).split()


# ---- the add-on -------------------------------------------------------------------


def install(dist):
    """Installs the zip of this Blender's form and enables it."""
    form = "extension" if IS_EXTENSION else "addon"
    path = str(next(Path(dist).glob(f"rack_focus-*-{form}.zip")))
    if IS_EXTENSION:
        bpy.ops.extensions.package_install_files(
            filepath=path, repo="user_default", enable_on_install=True
        )
    else:
        bpy.ops.preferences.addon_install(filepath=path, overwrite=True)
        bpy.ops.preferences.addon_enable(module=MODULE)


def uninstall():
    """Disables the add-on and removes its files."""
    bpy.ops.preferences.addon_disable(module=MODULE)
    if IS_EXTENSION:
        repos = [r.module for r in bpy.context.preferences.extensions.repos]
        bpy.ops.extensions.package_uninstall(
            repo_index=repos.index("user_default"), pkg_id="rack_focus"
        )
        return
    try:
        bpy.ops.preferences.addon_remove(module=MODULE)
    except RuntimeError as error:  # 3.4 wants to redraw a window; there is none
        assert "tag_redraw" in str(error), error


def addon(name=""):
    """A module of the installed add-on."""
    return sys.modules[f"{MODULE}.{name}" if name else MODULE]


def user_files():
    """Files of the user's Blender folder that belong to the add-on."""
    folder = Path(bpy.utils.resource_path("USER"))
    return sorted(str(p) for p in folder.rglob("*") if "rack" in p.name.lower())


# ---- scenes -----------------------------------------------------------------------


def emitter(name, colour, size, location):
    """A cube that glows in one colour."""
    mesh = bpy.data.meshes.new(name)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [
        (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4),
        (1, 5, 7, 3),
    ]  # fmt: skip
    mesh.from_pydata([[size * c / 2 for c in corner] for corner in corners], [], faces)
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    glow.inputs["Color"].default_value = (*colour, 1)
    material.node_tree.links.new(glow.outputs[0], out.inputs["Surface"])
    mesh.materials.append(material)
    found = bpy.data.objects.new(name, mesh)
    found.location = location
    bpy.context.scene.collection.objects.link(found)
    return found


def set_up_cycles(scene, samples=4):
    """Cycles on the CPU, the same bits every time."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 0
    scene.render.use_persistent_data = False
    scene.view_settings.view_transform = "Raw"


def make_base(path):
    """Cubes at different depths before a grey world; saved to `path`."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene = bpy.context.scene
    set_up_cycles(scene)
    render = scene.render
    render.resolution_x, render.resolution_y = 72, 48
    render.resolution_percentage = 100
    rng = np.random.default_rng(5)
    for depth in (1.5, 2, 3, 4, 6, 9):
        for _ in range(4):
            x, z = rng.uniform(-0.3, 0.3, 2) * depth
            emitter("cube", rng.random(3) ** 2, 0.07 * depth, (x, depth, z))
    data = bpy.data.cameras.new("Camera")
    data.lens, data.dof.focus_distance, data.dof.aperture_fstop = 50, 3, 0.2
    camera = bpy.data.objects.new("Camera", data)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.data.orphans_purge(do_recursive=True)  # of Blender's start file
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def counts():
    """Number of datablocks of every kind, our own images and results aside."""
    return {kind: len(getattr(bpy.data, kind)) for kind in KINDS}


def tree_of(scene):
    """The scene's compositor tree, or None."""
    return addon("compat").compositor_tree(scene)


def settings_of(scene):
    """Every plain value of the scene's render settings, its camera and its nodes."""
    owners = [
        scene.render,
        scene.render.image_settings,
        scene.cycles,
        scene.view_layers[0],
    ]
    owners += [scene.camera.data, scene.camera.data.dof, scene.camera.data.rack_focus]
    found = [(v.name, v.use, v.camera_suffix) for v in scene.render.views]
    for owner in owners:
        for item in owner.bl_rna.properties:
            value = getattr(owner, item.identifier, None)
            is_plain = isinstance(value, bool | int | float | str)
            if is_plain and not item.identifier.startswith("session_u"):
                found.append((str(owner.rna_type), item.identifier, value))
    for node in tree_of(scene).nodes:
        sockets = [(s.name, s.enabled, s.is_linked) for s in node.outputs]
        looks_at = (node.scene, node.layer) if node.type == "R_LAYERS" else None
        found.append((node.name, node.mute, looks_at, list(node.keys()), sockets))
    return found


def unchanged(scene, before):
    """Nothing differs from an earlier settings_of(); no scene was left."""
    after = settings_of(scene)
    differences = [(a, b) for a, b in zip(before, after, strict=True) if a != b]
    assert not differences, differences
    assert len(bpy.data.scenes) == 2, [s.name for s in bpy.data.scenes]


def snapshot(scene):
    """Everything of a scene that enabling may touch."""
    tree = tree_of(scene)
    nodes = sorted((n.name, n.type) for n in tree.nodes) if tree else None
    links = tree and sorted(
        (k.from_node.name, k.from_socket.name, k.to_node.name, k.to_socket.name)
        for k in tree.links
    )
    passes = [(layer.name, layer.use_pass_z) for layer in scene.view_layers]
    cameras = [(c.name, c.dof.use_dof) for c in bpy.data.cameras]
    return counts(), nodes, links, passes, cameras, scene.render.use_compositing


# ---- pictures ---------------------------------------------------------------------


def set_output(scene, path, multilayer=False):
    """An uncompressed float EXR."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    settings.color_depth = "32"
    settings.exr_codec = "NONE"
    settings.color_mode = "RGBA"
    scene.render.use_file_extension = False
    scene.render.filepath = str(path)


def render(scene, path, multilayer=False):
    """Renders a scene into a file; returns its channels."""
    set_output(scene, path, multilayer)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return read(path)


def result(scene, path):
    """(height, width, 4) of the Render Result as it stands, by way of a file."""
    set_output(scene, path)
    bpy.data.images["Render Result"].save_render(str(path), scene=scene)
    return rgba(read(path))


def read(path):
    """{channel: (height, width) float32 copy} of an EXR; plain RGBA without a dot."""
    found = addon("exr").read_exr(path)
    return {
        name.lstrip(".") if name.count(".") < 2 else name: np.array(plane)
        for name, plane in found.items()
    }


def rgba(channels, layer=""):
    """(height, width, 4) of channels."""
    names = [f"{layer}.Combined.{c}" if layer else c for c in "RGBA"]
    if names[0] not in channels:
        names = [next(n for n in channels if n.split(".")[-1] == c) for c in "RGBA"]
    return np.stack([channels[name] for name in names], -1)


def depth_of(channels, layer="ViewLayer"):
    """(height, width) depth of a layer."""
    return next(
        plane
        for name, plane in channels.items()
        if name.startswith(f"{layer}.Depth") or name.startswith(f"{layer}.Z")
    )


def pinhole(scene, path):
    """All passes of the scene's render without filter and without depth of field."""
    kept = [(c, c.rack_focus.enabled, c.dof.use_dof) for c in bpy.data.cameras]
    for data, _, _ in kept:
        data.rack_focus.enabled = False
        data.dof.use_dof = False
    without_z = [layer for layer in scene.view_layers if not layer.use_pass_z]
    for layer in without_z:
        layer.use_pass_z = True
    channels = render(scene, path, multilayer=True)
    for layer in without_z:
        layer.use_pass_z = False
    for data, is_enabled, use_dof in kept:
        data.dof.use_dof = use_dof
        data.rack_focus.enabled = is_enabled
    return channels


def filtered(scene, colour, depth, size=None):
    """The filter on given pictures with the parameters of the scene's camera."""
    camera = scene.camera
    height, width = depth.shape
    params = addon("lens").frame_parameters(
        camera, camera.data.rack_focus, scene.render, size or (width, height)
    )
    library = addon("library").rackfocus
    return library.apply(np.ascontiguousarray(colour), depth, **params)


def start(**settings):
    """Enables the camera with settings; returns (scene, camera data).

    Without the pass of Clean Edges, and with whole pixels: what is rendered is what
    filtered() makes.
    """
    scene = bpy.context.scene
    data = scene.camera.data
    data.rack_focus.clean_edges, data.rack_focus.supersample = False, 1
    for name, value in settings.items():
        setattr(data.rack_focus, name, value)
    data.rack_focus.enabled = True
    return scene, data


def same(a, b):
    """Same shape and bits."""
    assert a.shape == b.shape, (a.shape, b.shape)
    if not np.array_equal(a, b):
        raise AssertionError(f"differ by up to {np.abs(a - b).max()}")


def last_message(scene):
    """What the last run of the engine had to say."""
    return addon("engine").last_run[scene.name]["message"]


def kept(scene):
    """[(passes.Layer, passes.Place)] of the last render's views."""
    return addon("passes").rendered(scene).views("ViewLayer")


def tpsnr(a, b):
    """As of the command, dB."""
    pictures = (np.ascontiguousarray(picture) for picture in (a, b))
    return addon("library").rackfocus.compare(*pictures)["tpsnr"]


class Watch:
    """Calls a function in the middle of the filter, once per frame."""

    def __init__(self, function):
        self.engine = addon("engine").RackFocusEngine
        self.function, self.seen = function, []

    def __enter__(self):
        self.kept = self.engine._render_frame
        watch = self

        def watched(engine, *args):
            watch.seen.append(watch.function())
            return watch.kept(engine, *args)

        self.engine._render_frame = watched
        return self.seen

    def __exit__(self, *_):
        self.engine._render_frame = self.kept


def copy_of(scene):
    """The first throw-away copy of a scene."""
    return next(s for s in bpy.data.scenes if s.rack_focus.viewed == scene)


def resident_bytes():
    """Memory of this process that is in use."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def own_memory_folders():
    """What this process left in the memory file system."""
    return list(Path("/dev/shm").glob(f"rack_focus_{os.getpid()}_*"))


def curves_of(item):
    """The F-curves of an object's action."""
    action = item.animation_data.action
    if hasattr(action, "fcurves"):
        return action.fcurves
    return action.layers[0].strips[0].channelbags[0].fcurves  # 5.x


# ---- running checks ---------------------------------------------------------------


def run(checks, names, report):
    """Runs the checks one after the other; report(name, "" or what went wrong)."""
    for name in names:
        try:
            checks[name]()
            report(name, "")
        except Exception:
            report(name, traceback.format_exc())


def leave():
    """Ends Blender at once: 4.5 as a module hangs at its exit after a render."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)
