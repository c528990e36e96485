# SPDX-License-Identifier: GPL-3.0-or-later
"""Refocus without rendering, and the node of the compositor's Add menu."""

import bpy
from bpy.props import IntProperty

from . import (
    bodies,
    camera_objects,
    compat,
    engine,
    exr,
    failures,
    finishing,
    group,
    inserted,
    keep,
    lens,
    names,
    overscan,
    passes,
    refocusing,
    setup,
    strips,
    taken,
)
from . import unblurred, unwritten, views


REFUSED = (exr.ExrError, passes.PassesError, finishing.FinishError)


def scene_of(context):
    """The user's scene, also when the filter scene is shown."""
    return context.scene.rack_focus.source or context.scene


def refocus(scene, call, own_samples=0):
    """Composites a scene again with the kept passes; call: EXEC_ or INVOKE_DEFAULT.

    Where the nodes use the scene's own render as well, it is rendered again.
    own_samples: of a render with the camera's own lens, which comes before that.
    """
    names.follow(setup.user_scenes())
    reason = setup.why_not(scene)
    if reason:
        raise passes.PassesError(f"{reason}: the picture cannot be filtered")
    shown = strips.why_shown(scene)
    if shown:
        raise passes.PassesError(f"{shown}: switch it off to refocus")
    if not setup.can_mute_sources(scene):
        return bpy.ops.render.render(call, scene=scene.name)
    if not setup.is_used(scene):
        raise passes.PassesError(". ".join(unblurred.NOT_SHOWN))
    keep_passes(scene)
    rendered = passes.rendered(scene)
    for layer in scene.view_layers:
        if layer.use and setup.is_shown(scene, layer.name):
            rendered.need(layer.name, *camera_objects.first_view(scene.render))
    reason = taken.why_refused(scene, rendered.size())
    if reason:
        raise passes.PassesError(reason)
    if own_samples:
        views.begin(scene, own_samples, is_refocus=True)
    unwritten.mute(scene)
    for node in group.nodes_of(scene):  # redone, they have lost their images
        group.make_ready(node.node_tree, *lens.picture_size(scene.render))
    setup.sync(scene)
    unwritten.begin(scene)
    bodies.measure(scene)
    is_job = False
    try:
        done = bpy.ops.render.render(call, scene=scene.name)
        is_job = "RUNNING_MODAL" in done
        return done
    finally:
        if not is_job:  # else the end of the job does it
            unwritten.unmute(scene)
            views.end(scene)


def keep_passes(scene):
    """Keeps the passes of the last render, else those of the camera's folder.

    Those of the folder come first where the last render was of another frame.
    """
    camera = camera_objects.camera_of(scene)
    folder = keep.folder_of(camera.data) if camera is not None else None
    frame, now = passes.frame_of(scene), scene.frame_current
    if folder is not None and frame not in (None, now):
        try:
            _keep_files(scene, folder)
            return
        except passes.PassesError:
            if isinstance(passes.rendered(scene), keep.KeptFiles):
                raise
    try:
        passes.keep(scene)
    except passes.PassesError:
        if folder is None:
            raise
        _keep_files(scene, folder)


def _keep_files(scene, folder):
    passes.put(scene, keep.KeptFiles(scene, folder, scene.frame_current))
    taken.forget(scene)
    overscan.forget(scene)
    passes.set_frame(scene, scene.frame_current)


def refocus_later(scene_name):
    """After the node's own button, which filters without compositing; for timers."""
    if bpy.app.is_job_running("RENDER"):
        return 0.05
    scene = bpy.data.scenes.get(scene_name)
    windows = bpy.context.window_manager.windows
    if scene is not None and len(windows) and not setup.why_not(scene):
        with bpy.context.temp_override(window=windows[0]):
            try:
                refocus(scene, "INVOKE_DEFAULT")
            except REFUSED as error:
                failures.note(scene, error)
    return None


class Composites:
    """An operator that ends with a new composite of a scene that is set up."""

    @classmethod
    def poll(cls, context):
        """Only where Rack Focus is set up."""
        return setup.filter_scene_of(scene_of(context)) is not None

    def execute(self, context):
        """Waits for the picture."""
        return self._run(context, "EXEC_DEFAULT")

    def invoke(self, context, _event):
        """Runs as a job, with progress and Esc."""
        return self._run(context, "INVOKE_DEFAULT")


class RACK_FOCUS_OT_refocus(Composites, bpy.types.Operator):
    """Filter the last render again with the present focus, f-stop and blades"""

    bl_idname = "rack_focus.refocus"
    bl_label = "Refocus"

    def _run(self, context, call):
        scene = scene_of(context)
        if not setup.can_mute_sources(scene):
            self.report({"INFO"}, "The nodes use other passes too: rendering again")
        try:
            return refocus(scene, call)
        except (RuntimeError, *REFUSED) as error:
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
            return {"CANCELLED"}


class RACK_FOCUS_OT_finish(Composites, bpy.types.Operator):
    """Render some samples with the camera's own lens, and clean them with the picture \
that is there: mirrors, glass and smoke come out as the renderer sees them"""

    bl_idname = "rack_focus.finish"
    bl_label = "Finish"

    samples: IntProperty(
        name="Samples",
        description="For each pixel; 0 takes those of the camera",
        min=0,
        default=0,
        options={"SKIP_SAVE"},
    )

    def _run(self, context, call):
        scene = scene_of(context)
        try:
            reason = finishing.why_not(scene)
            if reason:
                raise finishing.FinishError(reason)
            finishing.need_denoiser()
            refocusing.shown.pop(scene.name, None)
            samples = self.samples or scene.camera.data.rack_focus.finish_samples
            return refocus(scene, call, samples)
        except (RuntimeError, *REFUSED) as error:
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
            return {"CANCELLED"}


def make_active(context, tree, node, is_at_cursor):
    """Selects a new node alone; in the node editor it may lie where the cursor is."""
    for other in tree.nodes:
        other.select = other == node
    tree.nodes.active = node
    space = context.space_data
    if is_at_cursor and space is not None and space.type == "NODE_EDITOR":
        node.location = space.cursor_location


class RACK_FOCUS_OT_add_node(bpy.types.Operator):
    """Make the depth of field of the scene's camera after the render"""

    bl_idname = "rack_focus.add_node"
    bl_label = "Rack Focus"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        """Needs a camera to read the lens from."""
        return camera_objects.camera_of(scene_of(context)) is not None

    def execute(self, context):
        """Sets the scene up, or adds one more node for the active view layer."""
        scene = scene_of(context)
        settings = scene.camera.data.rack_focus
        if setup.filter_scene_of(scene) is None:
            settings.enabled = True
            setup.refresh(scene)
            return {"FINISHED"}
        tree = compat.compositor_tree(scene)
        if tree is None:
            self.report({"ERROR"}, f"Not added: {setup.NO_COMPOSITOR}")
            return {"CANCELLED"}
        layer = context.view_layer.name
        if layer not in scene.view_layers:
            layer = scene.view_layers[0].name
        node = setup.add_node(tree, scene, layer)
        make_active(context, tree, node, True)
        return {"FINISHED"}


class RACK_FOCUS_OT_add_picture_node(bpy.types.Operator):
    """Add a node that blurs the picture linked to it: after Denoise, a composite, \
    a sequence of files"""

    bl_idname = "rack_focus.add_picture_node"
    bl_label = "Rack Focus on an Image"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        """Needs a camera to read the lens from."""
        return camera_objects.camera_of(scene_of(context)) is not None

    def execute(self, context):
        """Puts it behind the active node."""
        scene = scene_of(context)
        tree, _ = compat.start_compositor(scene)
        node = tree.nodes.new("CompositorNodeGroup")
        node.node_tree = group.new_group()
        node.label, node.width = setup.NODE_LABEL, 180
        before = tree.nodes.active
        if before is not None and before != node:
            setup.put_behind(scene, tree, before, node)
        inserted.give_way(tree, node)
        setup.unblur_before(scene, tree, node)
        make_active(context, tree, node, before is None)
        if not node.inputs["Depth"].is_linked:
            scene.camera.data.rack_focus.enabled = True
        setup.refresh(scene)
        setup.sync(scene)
        return {"FINISHED"}


def draw_menu(self, _context):
    """The entries in Add > Filter."""
    self.layout.operator(RACK_FOCUS_OT_add_node.bl_idname)
    self.layout.operator(RACK_FOCUS_OT_add_picture_node.bl_idname)


def last_message(scene):
    """What went wrong in the last run of a scene, or ""."""
    return engine.last_run.get(scene.name, {}).get("message", "")


CLASSES = (
    RACK_FOCUS_OT_refocus,
    RACK_FOCUS_OT_finish,
    RACK_FOCUS_OT_add_node,
    RACK_FOCUS_OT_add_picture_node,
)


def register():
    """Adds the operators and the menu entry."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for name in compat.FILTER_MENUS:
        if hasattr(bpy.types, name):
            getattr(bpy.types, name).append(draw_menu)


def unregister():
    """Removes them."""
    for name in compat.FILTER_MENUS:
        if hasattr(bpy.types, name):
            getattr(bpy.types, name).remove(draw_menu)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
