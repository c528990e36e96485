# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens when renders start and end, files open, and scenes change.

Handlers of a render with a window are called in the render's thread. They write in the
main thread: writing updates what Blender is just drawing, and without that it crashed
once in some dozens of renders (5.2, busy processor).
"""

import functools

import bpy
from bpy.app.handlers import persistent

from . import engine, main_thread, operators, passes, setup, views
from .writing import write

_rendering = set()  # names of scenes


@persistent
def on_render_start(scene, *_):
    """Pinhole for the beauty render; the filter scene follows its source."""
    _rendering.add(scene.name)
    engine.told.pop(scene.name, None)
    try:
        main_thread.run(functools.partial(_begin, scene), BEGIN_S)
    except main_thread.BusyError as error:
        engine.tell(scene, error)
        write(_start, scene)


def _begin(scene):
    """In the main thread."""
    if scene in setup.user_scenes() and not scene.rack_focus.muted:
        try:
            _prepare(scene)
        except Exception as error:
            engine.tell(scene, error)
    _start(scene)


def _prepare(scene):
    """A render, not a refocus, begins."""
    setup.refresh(scene)
    if setup.filter_scene_of(scene) is not None:
        views.begin(scene)
        setup.settle(scene)


def _start(scene):
    source = scene.rack_focus.source
    if source is not None:
        setup.sync(source)
        engine.alone.add(source.name)
    elif setup.filter_scene_of(scene) is not None:
        if not scene.rack_focus.muted:  # a render, not a refocus
            passes.forget(scene)
        setup.sync(scene)
        setup.hide_dof(scene)


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
        _rendering.discard(scene.name)


def _finish(scene):
    _end(scene)
    if views.is_active(scene):
        views.end(scene)


@persistent
def on_frame(scene, *_):
    """A frame of a render begins."""
    if views.is_active(scene):
        task = functools.partial(views.prepare_frame, scene)
        main_thread.run_or_here(task, FRAME_S)


@persistent
def on_frame_change_pre(scene, *_):
    """A copy that renders views is about to be evaluated."""
    moment = views.moment_of(scene) if views.is_copy(scene) else None
    if moment is not None:
        task = functools.partial(setattr, scene, "frame_float", moment)
        main_thread.run_or_here(task, FRAME_S)


@persistent
def on_frame_change_post(scene, depsgraph=None):
    """It has been evaluated: its cameras can follow."""
    if depsgraph is not None and views.is_copy(scene):
        task = functools.partial(views.follow, scene, depsgraph)
        main_thread.run_or_here(task, FRAME_S)


def _end(scene):
    source = scene.rack_focus.source
    if source is None:
        setup.show_dof(scene)
        setup.unmute_sources(scene)
    elif source.name in engine.alone:
        engine.alone.discard(source.name)
        if not bpy.app.background:
            task = functools.partial(write, operators.refocus_later, source.name)
            bpy.app.timers.register(task, first_interval=0.05)


@persistent
def on_load(*_):
    """A file that was saved in the middle of a render opens as it was before."""
    _rendering.clear()
    passes.forget()
    write(_mend)


def _mend():
    views.clean_up()
    setup.show_dof()
    for scene in setup.user_scenes():
        setup.unmute_sources(scene)
    setup.remove_orphans()


_is_busy = False


@persistent
def on_change(*_):
    """Follows a change of the scene's camera, its view layers, or a copied scene."""
    global _is_busy
    if _is_busy or _rendering or bpy.app.is_job_running("RENDER"):
        return
    _is_busy = True
    try:
        write(_follow)
    finally:
        _is_busy = False


def _follow():
    views.clean_up()
    for scene in setup.user_scenes():
        is_changed = setup.refresh(scene)
        setup.sync(scene)
        if is_changed:
            setup.settle(scene)


# Seconds that the main thread may take until it comes to a task.
BEGIN_S, FRAME_S, END_S = 20, 20, 3

HANDLERS = (
    ("render_init", on_render_start),
    ("render_pre", on_frame),
    ("frame_change_pre", on_frame_change_pre),
    ("frame_change_post", on_frame_change_post),
    ("render_complete", on_render_end),
    ("render_cancel", on_render_end),
    ("load_post", on_load),
    ("depsgraph_update_post", on_change),
)


def register():
    """Adds the handlers."""
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    """Removes them."""
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    passes.forget()
