# SPDX-License-Identifier: GPL-3.0-or-later
"""The filter scene's engine: Blender runs it between render and compositing."""

import sys
import time
import traceback
from typing import NamedTuple

import bpy
import numpy as np

from . import (
    bodies,
    called,
    camera_objects,
    compat,
    denoising,
    exr,
    failures,
    finishing,
    fog,
    freestyle,
    group,
    halos,
    keep,
    lamps,
    lens,
    look,
    main_thread,
    mirrors,
    names,
    nodes,
    overscan,
    passes,
    pictures,
    preferences,
    refocusing,
    running,
    sampling,
    setup,
    sharp,
    strokes,
    supersample,
    taken,
    tap,
    unwritten,
    veils,
    view_passes,
    views,
)
from .library import rackfocus

EXTRA_PASSES = (
    # name, channels, channel ids, type
    ("Depth", 1, "Z", "VALUE"),
    ("CoC", 1, "X", "VALUE"),
    ("Focus", 4, "RGBA", "COLOR"),
)
# Blender draws the picture again for each update of the progress, on the cores that the
# filter wants (with software OpenGL 0.1 s at 1080p). A refocus of less than this has none.
UPDATE_S = 0.5
UNTICKED = (
    "Rack Focus was unticked during this render, and the picture is sharp: press F12"
)
RENAMED = (
    "view layer “{}” was renamed to “{}” during this render, and Blender lost its "
    "picture, which is black: press F12"
)

LATE = (
    "filtering takes longer than the window should wait; the picture is sharp until "
    "Refocus is pressed"
)

rendering = running.scenes
alone = set()  # names of scenes whose filter scene renders by itself: a node's button
awaited = set()  # names of scenes of which a frame has begun, and was not filtered yet
last_run = names.store()  # {"seconds": of each step, "message": of a failure, or ""}


class Problem(Exception):
    """The picture stays as it is; the message is for the user."""


class BlackError(Exception):
    """There is nothing to show; the message is for the user."""


class MismatchError(Exception):
    """The picture is there all the same; the message is for the user."""


EXPECTED = (
    Problem,
    passes.PassesError,
    exr.ExrError,
    lens.CameraError,
    views.ViewsError,
    pictures.PictureError,
    rackfocus.Error,
    tap.TapError,
    main_thread.BusyError,
    MemoryError,
)


# Those whose messages say what became of the picture.
SAID = (BlackError, MismatchError, keep.KeepError, denoising.DenoiserError)


class Frame(NamedTuple):
    """One view of one view layer."""

    layer: str
    view: str  # "" without stereo
    suffix: str  # of the view's file
    camera: object  # evaluated
    stereo: str = ""  # the view, where one camera has both


def no_depth(scene, layer_name):
    """The message for a view layer without a depth pass."""
    layer = scene.view_layers.get(layer_name)
    if layer is not None and layer.use_pass_z:
        return f"view layer “{layer_name}” was rendered without its depth: press F12"
    return f"view layer “{layer_name}” has no depth: switch on Passes > Data > Z"


def looked(layer, settings, params, kept_sharp=()):
    """A passes.Layer with the blur that the settings ask for.

    kept_sharp: names of objects.
    """
    values, focus = look.of(settings), params["focus_distance"]
    is_flat = params["projection"] == "orthographic"
    covered = sharp.coverage(layer.mattes, kept_sharp)
    if not is_flat and (covered is not None or values != (1, 1)):
        focus = look.focus_of(layer.depth.shape, params)
    depth = look.depth(layer.depth, values, focus, is_flat)
    if covered is not None:
        depth = look.with_mask(depth, 1 - covered, focus, is_flat)
    rays = layer.rays if depth is layer.depth else None
    return layer._replace(depth=depth, mattes=(), rays=rays)


def cut_out(found, render):
    """The rendered part of passes.Layer where a border is rendered in a whole frame."""
    if not render.use_border or render.use_crop_to_border:
        return found
    height, width = found.colour.shape[:2]
    whole = lens.picture_size(render)
    if width % whole[0] or height % whole[1]:  # kept files have the part alone
        return found
    (left, right), (low, high) = lens.region_of(render, width, height)
    part = np.s_[height - high : height - low, left:right]
    depth = found.depth[part] if found.depth is not None else None
    mattes = tuple(
        (ids if ids is None else ids[part], covered[part])
        for ids, covered in found.mattes
    )
    seen = found.seen and found.seen.part(part)
    grainy = found.grainy[part] if found.grainy is not None else None
    lines = found.lines[part] if found.lines is not None else None
    rays = found.rays[part] if found.rays is not None else None
    facing = found.facing[part] if found.facing is not None else None
    about = mattes, seen, grainy, lines, rays, facing
    return passes.Layer(found.colour[part], depth, *about)


def fitted(values, width, height):
    """(height, width, n) of an array: its last row and column again, or without some."""
    if values.shape[:2] == (height, width):
        return values
    missing = ((0, max(height - len(values), 0)), (0, max(width - values.shape[1], 0)))
    padded = np.pad(values[:height, :width], (*missing, (0, 0)), "edge")
    return np.ascontiguousarray(padded)


def coc_picture(coc):
    """(height, width, 4) of a signed CoC: blue behind the focus, orange before it."""
    size = np.abs(coc) / max(float(np.abs(coc).max()), 1e-6)
    behind, before = np.float32([0.1, 0.35, 1, 1]), np.float32([1, 0.45, 0.05, 1])
    shown = np.where(coc > 0, behind, before) * size
    shown[..., 3] = 1
    return shown.astype(np.float32)


def last_layer(scene):
    """Name of the view layer of a filter scene that Blender renders last."""
    return [layer.name for layer in scene.view_layers if layer.use][-1]


def new_name_of(source, layer_name):
    """The name that a view layer got since the render of its scene began, or ""."""
    known = setup.filter_scene_of(source).view_layers.keys()
    now = source.view_layers.keys()
    if layer_name in now or layer_name not in known or len(known) != len(now):
        return ""
    return now[known.index(layer_name)]


def is_called_for_nodes_only(source, layer_name):
    """Does the layer's node only let Blender call us?"""
    has_nodes = bool(group.nodes_of(source))
    return has_nodes and not setup.linked_outputs(source, layer_name)


class RackFocusEngine(bpy.types.RenderEngine):
    """Filters the passes of the source scene's render."""

    bl_idname = setup.ENGINE
    bl_label = "Rack Focus"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False

    def update_render_passes(self, scene, renderlayer):
        """Declares the sockets of the node."""
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for about in EXTRA_PASSES:
            self.register_pass(scene, renderlayer, *about)

    def render(self, depsgraph):
        """Filters one view layer, all its views."""
        scene = depsgraph.scene
        if scene.rack_focus.is_tap:
            self._write_nothing(depsgraph)
            return
        source = scene.rack_focus.source
        if source is None:
            failures.say(scene, setup.NO_RENDERER)
            self.report({"ERROR"}, f"Rack Focus: {setup.NO_RENDERER}")
            return
        source = source.original
        awaited.discard(source.name)
        run = last_run[source.name] = {"seconds": {}, "message": ""}
        run["message"] = failures.told.get(source.name, "")
        self.doing = "Rack Focus"
        self.next_update_s = time.perf_counter() + UPDATE_S
        if source.name not in alone:
            refocusing.note(source)
        with lens.known(bodies.distances_of(source)):
            self._render_layer(depsgraph, source, run)

    def _render_layer(self, depsgraph, source, run):
        """The same once it is known which scene is filtered; run: of last_run."""
        scene = depsgraph.scene
        try:
            name = depsgraph.view_layer.name
            is_wanted = source.name in alone | rendering
            is_shown = is_wanted or setup.is_shown(source, name)
            if not is_shown or is_called_for_nodes_only(source, name):
                self._write_nothing(depsgraph)
            else:
                self._render_shown(depsgraph, source, run["seconds"])
            if depsgraph.view_layer.name == last_layer(scene):
                nodes.run(source, depsgraph, self, run["seconds"])
        except Exception as problem:
            error = problem
            if (
                isinstance(error, EXPECTED) and self._is_stopped()
            ):  # so nothing is there
                error = rackfocus.CancelledError("cancelled")
            is_stopped = isinstance(error, rackfocus.CancelledError)
            is_late = is_stopped and refocusing.is_late()
            run["message"] = LATE if is_late else self._explain(error)
            self.report({"ERROR"}, f"Rack Focus: {run['message']}")
            if not is_stopped:
                failures.say(source, run["message"])

    @staticmethod
    def _explain(error):
        """The message of an error in the artist's words."""
        if isinstance(error, rackfocus.CancelledError):
            return "stopped; the picture is not filtered"
        if isinstance(error, SAID):
            return str(error)
        if isinstance(error, EXPECTED):
            text = getattr(error, "message", "") or str(error) or "out of memory"
        else:
            traceback.print_exception(error)
            text = f"a fault of Rack Focus ({type(error).__name__}: {error})"
        return f"{text}. The picture is not filtered"

    def _write_nothing(self, depsgraph):
        """A result of no use: Blender wants one of every view layer."""
        width, height = lens.picture_size(depsgraph.scene.render)
        layer = depsgraph.view_layer.name  # else those of all layers are replaced
        self.end_result(self.begin_result(0, 0, width, height, layer=layer))

    # ---- frames -------------------------------------------------------------------

    def _frames(self, depsgraph):
        """The frames of this view layer."""
        scene, layer = depsgraph.scene, depsgraph.view_layer.name
        camera = scene.camera
        if camera is None:
            raise Problem("the scene has no camera")
        if not scene.render.use_multiview:
            return [Frame(layer, "", "", camera.evaluated_get(depsgraph))]
        is_stereo = scene.render.views_format == "STEREO_3D"
        frames = []
        for view in camera_objects.views_of(scene.render):
            own = camera
            if not is_stereo:
                own = camera_objects.view_camera(scene, camera.original, view)
            seen = own.evaluated_get(depsgraph)
            stereo = view.name if is_stereo else ""
            frames.append(Frame(layer, view.name, view.file_suffix, seen, stereo))
        return frames

    def _render_shown(self, depsgraph, source, seconds):
        """The views; nothing where nodes show none, and Blender renders no scene for them."""
        layer = depsgraph.view_layer.name
        new_name = new_name_of(source, layer)
        if new_name:
            passes.look_for(source, layer, new_name)
        try:
            self._render_views(depsgraph, source, seconds)
        except passes.RoomError as error:
            raise BlackError(f"{error}. The picture is black") from error
        except passes.PassesError as error:
            if new_name:
                raise BlackError(RENAMED.format(layer, new_name)) from error
            if setup.is_used(source):
                raise
            self._write_nothing(depsgraph)

    def _render_views(self, depsgraph, source, seconds):
        started = time.perf_counter()
        frames = self._frames(depsgraph)
        is_refocus = bool(source.rack_focus.muted)
        self.show = refocusing.shown.get(source.name, "picture")
        if not is_refocus:  # a render is never an overlay
            self.show = "picture"
            refocusing.shown.pop(source.name, None)
            if source.name not in alone | rendering:  # another scene's nodes show it
                passes.forget(source)
            if source.name not in alone:
                passes.set_frame(source, depsgraph.scene.frame_current)
                taken.note(source, frames[0].camera)
        else:
            about = source, depsgraph.scene.frame_current, frames[0].camera
            self._note(source, unwritten.added(source, taken.why_not_this(*about)))
        self.linked = setup.linked_outputs(source, depsgraph.view_layer.name)
        problem = None
        if not rendering and source.name not in alone:  # nobody was told of its begin
            called.put_back()
            problem = Problem(called.LOST)
        self._note(source, views.note_of(source))
        try:
            views.collect(source)
        except Exception as error:
            problem = problem or error
        self.is_broken = problem is not None
        rendered = passes.rendered(source)
        seconds["passes"] = time.perf_counter() - started
        for frame in frames:
            problem = problem or self._denoise(rendered, frame, source, seconds)
            found = rendered.views(frame.layer, frame.suffix, frame.view)
            if not isinstance(rendered, keep.KeptFiles):  # their lines are ours
                found = freestyle.taken(found, source, frame.layer)
                found = strokes.added(found, source, frame.layer)
            found = [(cut_out(one, source.render), place) for one, place in found]
            found = fog.filled(found, source)
            if not isinstance(rendered, keep.KeptFiles):  # theirs have lights
                found = lamps.placed(found, source, frame.layer, frame.camera)
            try:
                self._render_frame(frame, found, depsgraph.scene, seconds)
                self._keep(frame, found, depsgraph.scene, source)
            except Exception as error:
                problem = problem or error
        if problem:
            raise problem
        seconds["total"] = time.perf_counter() - started

    def _denoise(self, rendered, frame, source, seconds):
        """Cleans views that were rendered with their grain; returns the problem."""
        started = time.perf_counter()
        if self.is_broken or not isinstance(rendered, view_passes.ViewPasses):
            return None
        if rendered.is_clean(frame.layer):
            return None
        self.doing = "Rack Focus: denoise"
        try:
            denoising.clean(rendered, frame, source, self._report)
        except (denoising.DenoiserError, rackfocus.CancelledError) as problem:
            return problem
        seconds["denoise"] = time.perf_counter() - started
        return None

    def _render_frame(self, frame, found, scene, seconds):
        """Fills the passes of one frame, after a problem with what was rendered.

        found: [(passes.Layer, passes.Place)] of its views.
        """
        first, source = found[0][0], scene.rack_focus.source.original
        height, width = first.colour.shape[:2]
        scale = supersample.scale_of((width, height), scene.render)
        # Blender's rows run upwards, those of the file and of the filter downwards.
        picture = np.empty((height, width, 4), np.float32)
        coc = np.zeros((height, width, 1), np.float32)
        limit_px, depth = None, first.depth
        try:
            settings = camera_objects.settings_of(frame.camera)
            # After the node's button a refocus follows, which filters.
            is_final = bpy.app.background or source.name not in alone
            is_final = is_final and not camera_objects.why_unknown(source)
            if running.is_tick_late and not settings.enabled:
                self._note(source, UNTICKED)
            if settings.enabled and is_final and not self.is_broken:
                limit_px = self._filter(
                    frame, found, settings, scene, (picture, coc), seconds, scale
                )
        finally:
            started = time.perf_counter()
            if limit_px is None:
                picture[::-1] = first.colour
            if scale > 1:
                spread_px = found[0][1].spread_px
                picture, coc = supersample.to_size(
                    source, scale, picture, coc, spread_px
                )
                depth = depth if depth is None else supersample.middle(depth, scale)
                limit_px = limit_px and limit_px / scale
            problem = self._finish(frame, source, picture, limit_px, seconds)
            freestyle.draw(first.lines, picture[::-1])
            self._write(frame, scene, self._passes(picture, coc, depth, limit_px))
            seconds["write"] = time.perf_counter() - started
        if problem:
            raise problem

    def _finish(self, frame, source, picture, limit_px, seconds):
        """Cleans the own lens with a filtered picture, in place; returns the problem."""
        started = time.perf_counter()
        own = finishing.own_of(source, frame.layer) if limit_px is not None else None
        if own is None:
            return None
        self.update_stats("", "Rack Focus: finish")
        colour = cut_out(own[0], source.render).colour
        guides = own[1] if colour.shape == own[0].colour.shape else None
        try:
            doubt = finishing.clean(source, colour, picture[::-1], guides, own[2])
        except finishing.FinishError as problem:
            return problem
        self._note(source, doubt)
        seconds["finish"] = time.perf_counter() - started
        return None

    def _passes(self, picture, coc, depth, limit_px):
        """{name: (height, width, channels), rows upwards}; only of linked sockets.

        limit_px: radius that counts as sharp, None where the picture is not filtered.
        """
        by_name = {"Combined": picture}
        show = self.show if limit_px is not None else "picture"
        if "Depth" in self.linked:
            by_name["Depth"] = planar = np.zeros_like(coc)
            if depth is not None:
                planar[::-1, :, 0] = depth
        if show == "coc":
            by_name["Combined"] = coc_picture(coc)
        elif show == "focus":
            by_name["Combined"] = nodes.overlay(picture, coc, limit_px)
        if "CoC" in self.linked:
            by_name["CoC"] = coc
        if "Focus" in self.linked:
            is_filtered = limit_px is not None
            shown = nodes.overlay(picture, coc, limit_px) if is_filtered else picture
            by_name["Focus"] = shown
        return by_name

    @staticmethod
    def _keep(frame, found, scene, source):
        """Writes what was rendered to the folder that the camera names."""
        if frame.camera.type != "CAMERA":
            return
        folder = keep.folder_of(frame.camera.data)
        is_render = not source.rack_focus.muted and source.name not in alone
        reason = keep.why_not(frame.camera.data)
        if reason and is_render:
            raise keep.KeepError(reason)
        if folder is None or not is_render:
            return
        stem = keep.stem_of(source, scene.frame_current, frame.layer, frame.suffix)
        height, width = found[0][0].depth.shape
        settings = frame.camera.data.rack_focus
        scale = supersample.scale_of((width, height), scene.render)
        params = lens.frame_parameters(
            frame.camera, settings, scene.render, (width, height), scale, frame.stereo
        )
        others = keep.stems_of(source, scene.frame_current)
        keep.write(folder, stem, found, params, sharp.names_of(source), others)

    def _filter(self, frame, found, settings, scene, targets, seconds, scale):
        """Filters into (picture, coc), rows upwards; returns the CoC limit in px."""
        picture, coc = targets
        source, render = scene.rack_focus.source.original, scene.render
        if any(layer.depth is None for layer, _ in found):
            raise Problem(no_depth(source, frame.layer))
        reason = sampling.why_no_depth(source, found[0][0].depth)
        if reason:
            raise Problem(reason)
        found = [
            (layer._replace(depth=passes.with_some_depth(layer.depth)), place)
            for layer, place in found
        ]
        height, width = found[0][0].depth.shape
        params = lens.frame_parameters(
            frame.camera, settings, render, (width, height), scale, frame.stereo
        )
        margin, problem = None, ""
        if len(found) < 2 and views.view_count(settings) < 2:
            margin, problem = overscan.margin_of(source, frame, (width, height))
        self._note(source, problem)
        if margin is not None:
            found = [(margin.around(layer), place) for layer, place in found]
            params = lens.padded_parameters(params, (width, height), margin.whole)
            width, height = margin.whole
            picture = np.empty((height, width, 4), np.float32)
            coc = np.zeros((height, width, 1), np.float32)
        kept_sharp = sharp.names_of(source) if len(found) < 2 else ()
        rendered, found = found, [
            (looked(layer, settings, params, kept_sharp), place)
            for layer, place in found
        ]
        depth = found[0][0].depth
        params["method"] = views.method_for(params["method"], found)
        if views.are_clean(found):
            params.setdefault("sub_apertures", views.DENOISED_SUB_APERTURES)
        if params["method"] != "accumulate":
            self._note(source, fog.why_wrong(found, source))
        started = time.perf_counter()
        made = rackfocus.Filter(
            width,
            height,
            threads=preferences.threads(),
            **params,
            **settings.light_keywords(),
        )
        if render.film_transparent and params["method"] != "accumulate":
            colour = found[0][0].colour
            self._note(source, halos.why_wrong(colour, depth, made, params))
        elif params["method"] != "accumulate":
            self._note(source, veils.why_wrong(rendered[0][0], source))
        lights = self._lights(frame, source, (rendered, found), params, made)
        self.doing = f"Rack Focus: {params['method']}, {width} x {height}"
        views.process(made, params, found, picture[::-1], self._report, lights)
        seconds["filter"] = time.perf_counter() - started
        started = time.perf_counter()
        if self.linked & {"CoC", "Focus"} or self.show != "picture":
            made.coc(depth, coc[::-1, :, 0])
        seconds["coc"] = time.perf_counter() - started
        if margin is not None:
            targets[0][:], targets[1][:] = picture[margin.inside], coc[margin.inside]
        return made.lens.coc_limit_px

    def _lights(self, frame, source, found, params, made):
        """What mirrors and panes show in each view, for views.process(), or None.

        found: [(passes.Layer, passes.Place)] as rendered, and as the filter takes them.
        """
        rendered, used = found
        layers, settings = [layer for layer, _ in used], frame.camera.data.rack_focus
        if not settings.mirrors or params["method"] == "accumulate":
            return None
        if all(layer.seen is not None for layer in layers):
            threads = preferences.threads()
            if params["method"] != "views":
                layers = layers[:1]
            elif len(layers) >= mirrors.MATCHED_FROM:
                self.doing = "Rack Focus: mirrors and glass"
                part = frame.layer, frame.suffix, layers[0].depth.shape
                key = passes.rendered(source), part
                return mirrors.lights_of_views(made, rendered, key, self._report)
            about = params, frame.camera.data.clip_start, threads
            return [mirrors.lights_of(made, layer, *about) for layer in layers]
        if not mirrors.why_not(source, settings):
            message = "Mirrors and Glass: this render lacks the passes; press F12"
            last_run[source.name]["message"] = message
            failures.say(source, message)
        return None

    def _note(self, scene, message):
        """What the user should know of a picture that is filtered all the same."""
        if not message:
            return
        last_run[scene.name]["message"] = message
        self.report({"WARNING"}, f"Rack Focus: {message}")
        print(
            f"Rack Focus: scene “{scene.name}”: {message}", file=sys.stderr, flush=True
        )

    def _report(self, fraction):
        """Progress to the status bar, now and then; False once Esc was pressed."""
        now = time.perf_counter()
        if now >= self.next_update_s:
            self.next_update_s = now + UPDATE_S
            self.update_stats("", self.doing)
            self.update_progress(fraction)
        return not self._is_stopped()

    def _is_stopped(self):
        """Was Esc pressed, or does the window wait for too long?"""
        return self.test_break() or refocusing.is_late()

    # ---- results ------------------------------------------------------------------

    def _write(self, frame, scene, by_name):
        """Hands passes, {name: (height, width, channels), rows upwards}, to Blender."""
        height, width = by_name["Combined"].shape[:2]
        for about in EXTRA_PASSES:
            if about[0] in by_name:
                self.add_pass(*about[:3], layer=frame.layer)
        # Blender gives what there is of that.
        whole = lens.picture_size(scene.render)
        result = self.begin_result(0, 0, *whole, layer=frame.layer, view=frame.view)
        real = result.resolution_x, result.resolution_y
        try:
            for name, values in by_name.items():
                target = result.layers[0].passes.find_by_name(name, frame.view)
                if target is not None:
                    compat.set_rect(target, fitted(values, *real))
        finally:
            self.end_result(result)
        if real != (width, height):
            raise MismatchError(
                f"the picture has {width} x {height} px, Blender's result {real[0]} x "
                f"{real[1]}: its last row or column may be wrong"
            )


def register():
    """Adds the engine."""
    bpy.utils.register_class(RackFocusEngine)


def unregister():
    """Removes it."""
    bpy.utils.unregister_class(RackFocusEngine)
