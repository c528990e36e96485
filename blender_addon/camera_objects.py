# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects that a render of a scene looks through."""

import types

import bpy

from . import keyed

FILTERED = ("PERSP", "ORTHO")  # types of cameras; panoramic ones have no plane of depth


def view_cameras(scene, camera):
    """The cameras that a multi-view render uses in the place of `camera`."""
    render = scene.render
    if not render.use_multiview or render.views_format != "MULTIVIEW":
        return [camera]
    return [view_camera(scene, camera, view) for view in render.views if view.use]


def view_camera(scene, camera, view):
    """The camera of a view: same name with the suffix of the view, else `camera`."""
    for other in scene.render.views:
        suffix = other.camera_suffix
        if suffix and camera.name.endswith(suffix):
            name = camera.name[: -len(suffix)] + view.camera_suffix
            return bpy.data.objects.get(name, camera)
    return bpy.data.objects.get(camera.name + view.camera_suffix, camera)


def views_of(render):
    """The stereo views that are rendered; none without stereo."""
    if not render.use_multiview:
        return []
    is_stereo = render.views_format == "STEREO_3D"
    used = [view for view in render.views if view.use]
    return [v for v in used if not is_stereo or v.name in ("left", "right")]


def first_view(render):
    """(suffix of its file, name) of the first stereo view; empty without stereo."""
    views = views_of(render)
    return (views[0].file_suffix, views[0].name) if views else ("", "")


def cameras_of(scene):
    """All camera objects that a render of the scene may look through.

    Those of strips where they may be ticked: to look at 2000 strips takes 3 ms.
    """
    cameras = {scene.camera, *(marker.camera for marker in scene.timeline_markers)}
    known = {camera.data for camera in cameras if camera is not None}
    others = [data.rack_focus for data in bpy.data.cameras if data not in known]
    if any(keyed.most(settings, "enabled") for settings in others):
        cameras |= {strip.scene_camera for _, strip in strips_of(scene)}
    found = set()
    for camera in cameras:
        if camera is not None and camera.type == "CAMERA":
            found.update(view_cameras(scene, camera))
    return found


def camera_of(scene):
    """The camera object of a scene; None without one, and where it is something else.

    Blender renders through any object that is the scene's camera, or bound to a marker.
    """
    camera = camera_of_strip(scene) or scene.camera
    return camera if camera is not None and camera.type == "CAMERA" else None


def camera_at(scene, frame):
    """The camera of a frame; those of a strip, and bound to markers, count."""
    if camera_of_strip(scene) is not None:
        return camera_of_strip(scene)
    markers = [m for m in scene.timeline_markers if m.camera]
    markers = [m for m in markers if not m.camera.hide_render]  # Blender skips those
    bound = [m for m in markers if m.frame <= frame]
    if bound:
        return max(bound, key=lambda marker: marker.frame).camera
    return min(markers, key=lambda m: m.frame).camera if markers else scene.camera


NO_CAMERA = types.SimpleNamespace(
    enabled=False, method="layered", views=1, view_samples=0, shutter_spread=False
)


def settings_of(item):
    """What an object that is rendered through asks for: nothing where it is no camera."""
    return item.data.rack_focus if item.type == "CAMERA" else NO_CAMERA


# ---- those of strips ----------------------------------------------------------------

# scene name: camera of the strip by which a render shows the scene; None: Blender renders
# it through one of several, and tells nobody which
_of_strips = {}


def strips_of(scene):
    """(scene of the sequencer, strip) of strips that show a scene through a camera."""
    for edit in bpy.data.scenes:
        editor = edit.sequence_editor
        if editor is None:
            continue
        is_new = hasattr(editor, "strips_all")
        for strip in editor.strips_all if is_new else editor.sequences_all:
            is_scene = strip.type == "SCENE" and strip.scene_input == "CAMERA"
            if is_scene and strip.scene == scene and not strip.mute:
                yield edit, strip


def strips_rendered(scene, rendered):
    """Strips by which a frame shows a scene; rendered: names of scenes that are rendered."""
    return [
        strip
        for edit, strip in strips_of(scene)
        if edit != scene and edit.name in rendered and edit.render.use_sequencer
        if strip.frame_final_start <= edit.frame_current < strip.frame_final_end
    ]


def note_strips(scene, rendered):
    """A scene is about to be rendered; rendered: names of scenes that are, it too."""
    _of_strips.pop(scene.name, None)
    seen = {strip.scene_camera for strip in strips_rendered(scene, rendered)}
    if seen - {None}:
        _of_strips[scene.name] = seen.pop() if len(seen) == 1 else None


def forget_strips(scene=None):
    """A scene, or any, is not rendered any more."""
    _of_strips.clear() if scene is None else _of_strips.pop(scene.name, None)


def camera_of_strip(scene):
    """The camera that the strip has by which the scene is rendered now, or None."""
    return _of_strips.get(scene.name)


def why_unknown(scene):
    """Why nobody knows what a scene is rendered through, in the artist's words, or ""."""
    if _of_strips.get(scene.name, scene) is not None:
        return ""
    return (
        "several strips show the scene through several cameras in one frame: give each "
        "of them a scene of its own (a linked copy)"
    )


# ---- their own depth of field -------------------------------------------------------


def open_lenses(cameras, depsgraph, are_open):
    """Switches the own depth of field of objects on or off in what a render evaluated.

    cameras: objects, of which those that are no cameras count for nothing. Those of the
    file are not touched: nothing is seen of it, nor saved. Panoramic ones stay as they
    are: their picture is not filtered.
    """
    for camera in filter(None, cameras):
        if settings_of(camera) is not NO_CAMERA:
            seen = camera.evaluated_get(depsgraph)
            is_seen = seen.is_evaluated and seen.data.is_evaluated
            is_filtered = is_seen and seen.data.type in FILTERED
            is_filtered = is_filtered and seen.data.rack_focus.enabled
            if is_filtered and seen.data.dof.use_dof != are_open:
                seen.data.dof.use_dof = are_open


def show_dof():
    """Switches on what earlier versions had off in files saved in mid-render."""
    for data in bpy.data.cameras:
        if data.rack_focus.is_dof_hidden:
            data.dof.use_dof = True
            data.rack_focus.is_dof_hidden = False
