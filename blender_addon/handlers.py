# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens when renders start and end, files open, and scenes change.

Handlers of a render with a window are called in the render's thread. They write in the
main thread: writing updates what Blender is just drawing, and without that it crashed
once in some dozens of renders (5.2, busy processor).
"""

import functools
import sys

import bpy
from bpy.app.handlers import persistent

from . import (
    blended,
    bodies,
    called,
    camera_objects,
    driven,
    engine,
    failures,
    finishing,
    freestyle,
    group,
    holdouts,
    lamps,
    lens,
    local_cameras,
    main_thread,
    mirrors,
    names,
    operators,
    outputs,
    overscan,
    park,
    passes,
    refocusing,
    regions,
    running,
    setup,
    shares,
    shining,
    sharp,
    slots,
    strips,
    strokes,
    switched,
    taken,
    tap,
    ticked,
    unblurred,
    unwritten,
    view_cameras,
    view_textures,
    views,
    walked,
)
from .writing import write


@persistent
def on_render_start(scene, *_):
    """Pinhole for the beauty render; the filter scene follows its source."""
    slots.note(scene)
    running.begin(scene.name, sys._getframe().f_back)
    engine.awaited.discard(scene.name)
    failures.told.pop(scene.name, None)
    called.put_back()
    called.be_last(FRAME_HANDLERS)
    if scene.rack_focus.muted:
        return  # refocus() has prepared it; the main thread may be drawing
    try:
        main_thread.run(functools.partial(_begin, scene), BEGIN_S)
    except main_thread.BusyError as error:
        failures.note(scene, error)
        write(_start, scene)


def _begin(scene):
    """In the main thread."""
    names.follow(setup.user_scenes())
    for one in strips.linked_in(scene):
        failures.say(one, f"{setup.why_not(one)}: the picture is not filtered")
    if scene in setup.user_scenes():
        camera_objects.note_strips(scene, engine.rendering)
        try:
            _prepare(scene)
        except Exception as error:
            failures.note(scene, error)
    _start(scene)


def _prepare(scene):
    """A render, not a refocus, begins."""
    walked.forget()
    group.separate(setup.user_scenes())
    group.remove_unused()
    setup.refresh(scene)
    park.restore(scene)
    setup.sync(scene)
    setup.heal(scene)
    for one in setup.user_scenes():  # nodes and strips show other scenes
        sharp.need_pass(one)
        mirrors.need_passes(one)
        shares.need_pass(one)
        freestyle.need_pass(one)
    if setup.filter_scene_of(scene) is not None:
        for node in group.nodes_of(scene):
            group.make_ready(node.node_tree, *lens.picture_size(scene.render))
        park.lead_past(scene)
        setup.need_source(scene)
        ticked.note_render(scene)
        shown = strips.why_shown(scene)
        if shown and len(engine.rendering) == 1:  # else it is a strip of another scene
            failures.note(scene, shown, is_failure=False)
        reason = setup.why_not(scene) or camera_objects.why_unknown(scene)
        if reason:
            failures.note(scene, f"{reason}: the picture is not filtered")
        else:
            lines = unblurred.describe(scene)
            if lines:
                failures.say(scene, ". ".join(lines), is_failure=False)
            camera = camera_objects.camera_at(scene, scene.frame_current)
            for lines in (
                blended.describe(scene, camera),
                holdouts.describe(scene, camera),
                lamps.describe(scene, camera),
                shining.describe(scene, camera_objects.settings_of(camera)),
                regions.describe(scene, camera_objects.settings_of(camera)),
                strokes.describe(scene),
                outputs.why_not(scene),
                strips.of_other_layers(scene, engine.rendering),
                views.in_vain(scene),
                view_textures.describe(scene) if views.are_asked(scene) else (),
                () if bpy.app.background else local_cameras.describe(scene),
            ):
                if lines:
                    failures.say(scene, " ".join(lines), is_failure=False)
            views.begin(scene, finishing.samples_of(scene))
        setup.settle(scene)


def _start(scene):
    source = scene.rack_focus.source
    if source is not None:
        setup.sync(source)
        engine.alone.add(source.name)
        return
    for module in (
        passes,
        taken,
        finishing,
        strokes,
        overscan,
        lamps,
    ):  # of scenes that are plain, too
        module.forget(scene)
    setup.sync(scene)


@persistent
def on_render_end(scene, *_):
    """The camera gets its depth of field back, after a cancelled render too."""
    task = functools.partial(_finish, scene)
    try:
        main_thread.run(task, END_S)
    except main_thread.BusyError:
        later = functools.partial(write, task)
        bpy.app.timers.register(later, first_interval=0.05)
    finally:
        running.end(scene.name)


def _finish(scene):
    names.follow(setup.user_scenes())
    if scene.rack_focus.muted:
        _draw_again()
    _end(scene)
    if not scene.rack_focus.is_tap:
        tap.clean_up()
    if views.is_active(scene):
        views.end(scene)
    park.restore(scene)
    camera_objects.forget_strips(scene)


@persistent
def on_render_complete(scene, *args):
    """The same; a render of one view layer, which calls no scene of a node, is told."""
    is_ours = scene.name in engine.awaited and setup.is_filtered(scene)
    if is_ours and setup.is_used(scene) and not strips.why_shown(scene):
        failures.say(scene, ONE_LAYER)
        engine.last_run[scene.name] = {"seconds": {}, "message": ONE_LAYER}
    on_render_end(scene, *args)


@persistent
def on_frame(scene, *_):
    """A frame of a render begins."""
    engine.awaited.add(scene.name)
    names.follow(setup.user_scenes())
    if views.is_active(scene):
        task = functools.partial(views.prepare_frame, scene)
        main_thread.run_or_here(task, FRAME_S)


@persistent
def on_write(scene, *_):
    """The file of a frame has been written."""
    outputs.complete(scene)


@persistent
def on_frame_change_pre(scene, *_):
    """A copy that renders views, or the filter scene, is about to be evaluated."""
    if scene.rack_focus.source is not None:
        seen = views.camera_of_frame(scene.rack_focus.source)
        camera = switched.other_camera(scene, seen)
        if camera is not None:
            task = functools.partial(setattr, scene, "camera", camera)
            main_thread.run_or_here(task, FRAME_S)
    _follow_script(scene)
    moment = views.moment_of(scene) if views.is_copy(scene) else None
    if moment is not None:
        task = functools.partial(setattr, scene, "frame_float", moment)
        main_thread.run_or_here(task, FRAME_S)


def _follow_script(scene):
    """Views through the camera that a script chose for a copy, where one did."""
    camera = views.chosen_camera(scene) if views.is_copy(scene) else None
    if camera is not None:
        task = functools.partial(views.look_through, scene, camera)
        main_thread.run_or_here(task, FRAME_S)


@persistent
def on_frame_change_post(scene, depsgraph=None):
    """A scene has been evaluated: pinhole for a render, and cameras of views follow."""
    if depsgraph is None or depsgraph.mode != "RENDER":
        return
    is_copy = views.is_copy(scene)
    _follow_script(scene)
    source = scene.rack_focus.viewed if is_copy else scene
    is_filtered = source is not None and setup.is_filtered(source)
    if source == scene and not is_filtered:
        _note_plain(scene, depsgraph)
    if is_filtered and (is_copy or setup.is_composited(source, engine.rendering)):
        are_open = scene.rack_focus.is_own_lens
        cameras, ours = camera_objects.cameras_of(source), setup.filter_scene_of(source)
        seen = set() if view_cameras.is_of_view(scene.camera) else {scene.camera}
        write(camera_objects.open_lenses, cameras | seen, depsgraph, are_open)
        write(driven.follow, cameras, depsgraph.scene_eval, ours)
        write(setup.follow_subframe, source, ours)
        bodies.measure(source, depsgraph)
        lamps.measure(source, depsgraph)
    if is_copy:
        task = functools.partial(views.follow, scene, depsgraph)
        main_thread.run_or_here(task, FRAME_S)


def _note_plain(scene, depsgraph):
    """What is not filtered now may be by a Refocus, once the box is ticked."""
    is_ours = scene.rack_focus.source is not None or scene.rack_focus.is_tap
    if is_ours or scene.library is not None or scene.camera is None:
        return
    passes.set_frame(scene, scene.frame_current)
    taken.note(scene, scene.camera.evaluated_get(depsgraph))


def _draw_again():
    """Shows the new picture now: Blender looks for it every 0.2 s."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.tag_redraw()


def _end(scene):
    source = scene.rack_focus.source
    if source is None:
        unwritten.unmute(scene)
    elif source.name in engine.alone:
        engine.alone.discard(source.name)
        if not bpy.app.background:
            task = functools.partial(write, operators.refocus_later, source.name)
            bpy.app.timers.register(task, first_interval=0.05)


@persistent
def on_load(*_):
    """A file that was saved in the middle of a render opens as it was before."""
    called.put_back()
    running.forget()
    engine.last_run.clear()
    camera_objects.forget_strips()
    failures.told.clear()
    bodies.forget()
    names.forget()
    slots.forget()
    taken.forget()
    passes.forget()
    finishing.forget()
    strokes.forget()
    overscan.forget()
    lamps.forget()
    ticked.forget()
    write(_mend)


def _mend():
    walked.forget()
    refocusing.forget()
    park.forget()
    for scene in setup.user_scenes():
        park.restore(scene)
    views.clean_up()
    tap.clean_up()
    camera_objects.show_dof()
    park.remove_notice()
    for scene in setup.user_scenes():
        unwritten.unmute(scene)
        setup.heal(scene)
        # A tick of a linked camera, by a script, is not in the file.
        is_known = not any(getattr(o, "is_missing", False) for o in bpy.data.libraries)
        if is_known and setup.filter_scene_of(scene) is not None:
            setup.refresh(scene)
    setup.remove_orphans()


@persistent
def on_save_start(*_):
    """The file that is written shows the sharp picture where the add-on is missing."""
    if not running.is_any():
        write(_park)


def _park():
    for scene in setup.user_scenes():
        setup.sync(scene)
        park.park(scene)
    park.add_notice()


@persistent
def on_save_end(*_):
    """The open file goes on as it was."""
    write(_restore)


def _restore():
    park.remove_notice()
    for scene in setup.user_scenes():
        park.restore(scene)


_is_busy = False


@persistent
def on_change(_scene=None, depsgraph=None):
    """Follows a change of the scene's camera, its view layers, or a copied scene."""
    global _is_busy
    called.put_back()
    walked.follow(depsgraph)
    taken.follow(depsgraph)
    if _is_busy or running.is_any():
        return
    _is_busy = True
    try:
        write(_follow)
    finally:
        _is_busy = False


def _follow():
    names.follow(setup.user_scenes())
    views.clean_up()
    group.separate(setup.user_scenes())
    for scene in setup.user_scenes():
        if unwritten.is_left_muted(scene):
            unwritten.unmute(scene)
        is_changed = setup.refresh(scene)
        park.restore(scene)
        setup.sync(scene)
        if is_changed:
            setup.settle(scene)
        refocusing.follow(scene)
        ticked.follow(scene)


# Seconds that the main thread may take until it comes to a task.
BEGIN_S, FRAME_S, END_S = 20, 20, 3

ONE_LAYER = (
    "Blender rendered one view layer by itself, and filters none then: the picture is an "
    "old one, or black. Press F12"
)

FRAME_HANDLERS = (
    ("render_pre", on_frame),
    ("frame_change_pre", on_frame_change_pre),
    ("frame_change_post", on_frame_change_post),
)
HANDLERS = (
    ("render_init", on_render_start),
    *FRAME_HANDLERS,
    ("render_write", on_write),
    ("render_complete", on_render_complete),
    ("render_cancel", on_render_end),
    ("load_post", on_load),
    ("save_pre", on_save_start),
    ("save_post", on_save_end),
    ("save_post_fail", on_save_end),  # newer than 3.4
    ("depsgraph_update_post", on_change),
)


def register():
    """Adds the handlers."""
    passes.clear_dead_folders()
    called.add(HANDLERS)


def unregister():
    """Removes them."""
    called.remove()
    passes.forget()
