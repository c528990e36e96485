# SPDX-License-Identifier: GPL-3.0-or-later
"""Is the picture out of date, and refocusing by itself when it is.

What a picture was made with is a key: the lens, the camera's settings, those of the
nodes. After each change of the scene it is compared with the present one. Where the
scene refocuses by itself, a timer waits until nothing has changed for a moment, and
starts the job that the button starts: off the main thread, with progress and Esc.
"""

import contextlib
import functools
import math
import time

import bpy
from bpy.props import EnumProperty

from . import camera_objects, failures, group, lens, look, names, passes, setup
from .library import rackfocus
from .writing import write

PAUSE_S = 0.3  # without a change, before it begins
SHOWN = (("picture", "Picture"), ("focus", "Focus"), ("coc", "CoC"))

# Each {scene name: ...}
_keys = names.store()  # key of its picture
_wanted = {}  # the key that a timer waits for
_stopped = {}  # key at which Esc was pressed
shown = names.store()  # what a refocus puts in the picture's place
_ends_s = math.inf  # of the clock, at which the filter stops


def key_of(scene):
    """What the picture of a scene depends on, beside the render; None: it has none."""
    if setup.filter_scene_of(scene) is None or camera_objects.camera_of(scene) is None:
        return None
    cameras = [scene.camera]
    cameras += [group.camera_of(scene, node) for node in group.nodes_of(scene)]
    found = []
    size = lens.picture_size(scene.render)
    for camera in cameras:
        settings = camera.data.rack_focus
        try:
            params = lens.frame_parameters(camera, settings, scene.render, size)
            params.pop("white")  # an exposure is no reason to filter anew
        except (lens.CameraError, rackfocus.Error):
            params = {}
        found.append((camera.name, tuple(sorted(params.items())), look.of(settings)))
        picture = settings.use_aperture_image, settings.distribution_image
        found.append((settings.enabled, *picture))
    masks = [n.inputs["Mask"].default_value for n in group.nodes_of(scene)]
    return (*found, tuple(masks))


def note(scene):
    """The picture is being made with what the scene has now.

    Nothing may come between a render and its picture: what fails here fails again in the
    filter, which says so.
    """
    _keys.pop(scene.name, None)
    with contextlib.suppress(Exception):
        _keys[scene.name] = key_of(scene)


def forget(scene=None):
    """There is no picture of a scene, or of any."""
    for kept in (_keys, _wanted, _stopped, shown):
        kept.clear() if scene is None else kept.pop(scene.name, None)


@contextlib.contextmanager
def within(longest_s):
    """Lets a refocus that the window waits for stop after some seconds."""
    global _ends_s
    _ends_s = time.monotonic() + longest_s
    try:
        yield
    finally:
        _ends_s = math.inf


def is_late():
    """Did those pass?"""
    return time.monotonic() > _ends_s


def is_out_of_date(scene):
    """Was the picture made with other settings? False where there is none."""
    made = _keys.get(scene.name)
    return made is not None and made != key_of(scene)


def follow(scene):
    """After a change: refocuses in a moment where the scene does so by itself."""
    if not scene.rack_focus.is_automatic or bpy.app.background:
        return
    key = key_of(scene)
    name = scene.name
    if not is_out_of_date(scene) or key in (_wanted.get(name), _stopped.get(name)):
        return
    is_waiting = name in _wanted
    _wanted[name] = key
    if not is_waiting:
        task = functools.partial(write, _go_on, name, key)
        bpy.app.timers.register(task, first_interval=PAUSE_S)


def _go_on(name, key):
    """The timer: begins once nothing has changed for the pause and no job runs."""
    scene = bpy.data.scenes.get(name)
    if scene is None or not is_out_of_date(scene):
        _wanted.pop(name, None)
        return None
    now = _wanted.get(name)
    is_busy = bpy.app.is_job_running("RENDER") or bpy.context.screen is None
    if now != key or is_busy:
        task = functools.partial(write, _go_on, name, now)
        bpy.app.timers.register(task, first_interval=PAUSE_S)
        return None
    _wanted.pop(name, None)
    windows = bpy.context.window_manager.windows
    if len(windows) and setup.can_mute_sources(scene):
        _stopped[name] = key  # until it changes: not again after Esc
        with bpy.context.temp_override(window=windows[0]):
            try:
                bpy.ops.rack_focus.refocus("INVOKE_DEFAULT")
            except RuntimeError as error:
                failures.note(scene, error)
    return None


class RACK_FOCUS_OT_show(bpy.types.Operator):
    """Show the picture, what is in focus, or how far each pixel is blurred"""

    bl_idname = "rack_focus.show"
    bl_label = "Show"

    show: EnumProperty(
        name="Show",
        items=[(name, text, "") for name, text in SHOWN],
        default="picture",
    )

    @classmethod
    def poll(cls, context):
        """Only where a picture can be refocused."""
        scene = context.scene.rack_focus.source or context.scene
        return setup.filter_scene_of(scene) is not None

    def execute(self, context):
        """Refocuses; a render shows the picture again."""
        return self._run(context, "EXEC_DEFAULT")

    def invoke(self, context, _event):
        """As a job."""
        return self._run(context, "INVOKE_DEFAULT")

    def _run(self, context, call):
        scene = context.scene.rack_focus.source or context.scene
        if not setup.can_mute_sources(scene):
            self.report({"ERROR"}, "The nodes use other passes too: use their sockets")
            return {"CANCELLED"}
        try:
            passes.rendered(scene)
        except passes.PassesError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        shown[scene.name] = self.show
        return bpy.ops.rack_focus.refocus(call)


def register():
    """Adds the operator."""
    bpy.utils.register_class(RACK_FOCUS_OT_show)


def unregister():
    """Removes it."""
    bpy.utils.unregister_class(RACK_FOCUS_OT_show)
    forget()
