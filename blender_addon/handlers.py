# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens when renders start and end, files open, and scenes change."""

import functools

import bpy
from bpy.app.handlers import persistent

from . import engine, operators, passes, setup
from .writing import write


@persistent
def on_render_start(scene, *_):
    """Pinhole for the beauty render; the filter scene follows its source."""
    write(_start, scene)


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
    write(_end, scene)


def _end(scene):
    source = scene.rack_focus.source
    if source is None:
        setup.show_dof(scene)
        setup.unmute_sources(scene)
    elif source.name in engine.alone:
        engine.alone.discard(source.name)
        if not bpy.app.background:
            task = functools.partial(operators.refocus_later, source.name)
            bpy.app.timers.register(task, first_interval=0.05)


@persistent
def on_load(*_):
    """A file that was saved in the middle of a render opens as it was before."""
    passes.forget()
    setup.show_dof()
    for scene in setup.user_scenes():
        setup.unmute_sources(scene)
    setup.remove_orphans()


_is_busy = False


@persistent
def on_change(*_):
    """Follows a change of the scene's camera, its view layers, or a copied scene."""
    global _is_busy
    if _is_busy or bpy.app.is_job_running("RENDER"):
        return
    _is_busy = True
    try:
        for scene in setup.user_scenes():
            setup.refresh(scene)
            setup.sync(scene)
    finally:
        _is_busy = False


HANDLERS = (
    ("render_init", on_render_start),
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
