# SPDX-License-Identifier: GPL-3.0-or-later
"""Several views in one render.

While a render runs, the Render Layers nodes of the user's scene look at a throw-away
copy of it, which Blender therefore renders in its place: N views by native multi-view,
through cameras that are children of the user's camera. Then Blender runs the filter
scene, which merges the views, and composites one picture. The user's scene, its camera
and its render settings are not touched. What is changed in its nodes is written into
the nodes themselves: a file saved in the middle of a render is put right when it opens.

Where the views differ in time (shutter spread), or where native multi-view does not
work, each view has a copy of its own, and Blender renders them one after another.

A frame whose camera is not ticked, or cannot be filtered, is rendered as the scene says:
one view, with all samples.
"""

import math

import bpy

from . import (
    bodies,
    camera_objects,
    compat,
    culling,
    denoising,
    failures,
    finishing,
    freestyle,
    group,
    handover,
    keyed,
    lens,
    memory,
    mirrors,
    moving,
    names,
    one_by_one,
    overscan,
    parts,
    passes,
    sampling,
    setup,
    sharp,
    sheared,
    strokes,
    supersample,
    switched,
    view_cameras,
    view_passes,
    view_textures,
    walked,
)
from .library import rackfocus
from .writing import set_if_other

METHODS = ("layered", "views", "accumulate")  # those that take several views
MOST_MERGED = 64
ENOUGH_SAMPLES = 32  # of a view; docs/measure_view_samples.py has the scores
DENOISED_SUB_APERTURES = 16  # beside the denoiser they cost next to nothing
PASSES = ("use_pass_combined", "use_pass_z")
KEEP_SHARP = "Objects are kept sharp with one view only"


class ViewsError(Exception):
    """The views cannot be used; the message is for the user."""


class Session:
    """A render of a scene in several views, from its start to its end."""

    def __init__(self, scene, copies, own, drawn, margin):
        self.scene_name = scene.name
        self.copy_names = [copy.name for copy in copies]
        self.own_name = own.name if own is not None else ""
        self.drawn_name = drawn.name if drawn is not None else ""
        self.margin_name = margin[0].name if margin else ""
        self.margin = margin[1:] if margin else None  # suffix of its camera, `wide`
        self.has_margin = False  # has the frame?
        self.scale = parts.factor(scene) if copies else 1
        self.is_noisy = False  # are the views rendered with their grain?
        self.is_sequence = len(copies) > 1
        self.suffixes = []  # of the views' cameras
        self.samples = sampling.samples_of(scene)
        self.camera = None  # of the frame
        self.noted = None  # the scene's camera when the frame was prepared
        self.n_views = 1  # of the frame
        self.frame_scale = 1  # of the frame: 1 too where it is not filtered
        self.is_frame_noisy = False  # has the frame its grain?
        self.places = {}  # of the frame's views, by their numbers
        self.problem = ""  # why they could not be placed
        self.note = ""  # on the frame's views, for the user
        self.is_collected = False

    def copies(self):
        """The scenes that render the views."""
        return [bpy.data.scenes[name] for name in self.copy_names]

    def n_cameras(self):
        """How many cameras the frame's views and the parts of their pixels need."""
        return self.n_views * self.frame_scale**2

    def own(self):
        """The scene that renders with the camera's own lens, or None."""
        return bpy.data.scenes[self.own_name] if self.own_name else None

    def drawn(self):
        """The scene that renders the strokes of Grease Pencil, or None."""
        return bpy.data.scenes[self.drawn_name] if self.drawn_name else None

    def margin_scene(self):
        """The scene that renders what lies beyond the border, or None."""
        return bpy.data.scenes[self.margin_name] if self.margin_name else None


_sessions = names.store()  # Session


# ---- what is asked for ------------------------------------------------------------


def view_count(settings):
    """How many views a camera's settings ask for."""
    if not settings.enabled or settings.method not in METHODS:
        return 1
    if settings.method == "accumulate":
        return settings.views
    return min(settings.views, MOST_MERGED)


def most_views(settings):
    """The same of the frame that asks for the most, where settings have keyframes."""
    methods = keyed.values(settings, "method").intersection(METHODS)
    n = keyed.most(settings, "views") if methods else 1
    return n if "accumulate" in methods else min(n, MOST_MERGED)


def least_views(settings):
    """The same of the frame that asks for the fewest."""
    is_one = not keyed.values(settings, "method").issubset(METHODS)
    return 1 if is_one else min(keyed.values(settings, "views"))


def why_one_view(scene):
    """Why a scene is rendered in one view whatever its cameras ask for, or ""."""
    if scene.render.use_multiview:
        return "With stereo, one view is rendered"
    if group.nodes_of(scene):
        return "With Rack Focus nodes on pictures, one view is rendered"
    if freestyle.is_drawn(scene):
        return "With Freestyle's lines, one view is rendered"
    return ""


def in_vain(scene):
    """Lines for the console on what cameras ask for and a render does not heed."""
    settings = keyed.ticked(camera_objects.cameras_of(scene))
    has_views = any(most_views(one) > 1 for one in settings)
    lines = [why_one_view(scene)] if has_views else []
    if any(one.supersample > 1 for one in settings):
        lines.append(parts.why_not(scene))
    if overscan.percent(scene) > 0:
        has_one = any(least_views(one) < 2 for one in settings)
        lines.append(overscan.why_not(scene) or ("" if has_one else overscan.VIEWS))
    lines += [mirrors.why_not(scene, one) for one in settings if one.mirrors]
    if are_asked(scene) and walked.once(sharp.names_of, scene):
        lines.append(KEEP_SHARP)
    return [f"{line}." for line in dict.fromkeys(lines) if line]


def describe(settings, scene, n):
    """Lines for the panel on a render in n views."""
    reason = why_one_view(scene)
    if reason:
        return [reason]
    if bodies.why_one_view(scene):
        return [
            "Rigid bodies are not baked: one view is rendered",
            "Press Scene > Rigid Body World > Cache > Bake",
        ]
    if is_unfiltered(settings, scene):
        return ["The picture is not filtered: one view is rendered"]
    width, height = lens.picture_size(scene.render)
    lines = []
    samples, scale = sampling.samples_of(scene), parts.factor(scene)
    if samples:
        each = sampling.samples_of_view(samples, n, settings.view_samples)
        cost = f"{n * each / samples:.3g} × the time of one render"
        what = "sample" if each == 1 else "samples"
        lines.append(f"{n} views of {each} {what}: {cost}")
        is_moved = sampling.is_needed(scene, settings.id_data, each, scale)
        if each < 2 and not is_moved:
            lines.append("One sample does not smooth edges")
        elif each < ENOUGH_SAMPLES:
            lines.append(
                f"Below {ENOUGH_SAMPLES} samples a view, one view may be better"
            )
            lines.append("without a denoiser, or where metal or water glints")
    if settings.views > n:
        lines.append(f"{MOST_MERGED} views at most can be merged")
    if one_by_one.is_so(settings, scene):
        lines.append("The views are rendered one after another")
        lines.append("Each prepares the scene anew, which takes longer")
    elif scene.render.use_motion_blur:
        lines.append("With Motion Blur, each view prepares what may move anew")
    lines += view_textures.describe(scene)
    if moving.may_lose_shear(scene, settings.id_data):
        lines.append("With Motion Blur, one view where this camera moves")
    if walked.once(sharp.names_of, scene):
        lines.append(KEEP_SHARP)
    return lines + memory.describe(scene, n, width * height * scale**2)


def is_unfiltered(settings, scene):
    """Are they of the scene's camera, and it one that cannot be filtered?"""
    camera = scene.camera
    is_its = camera is not None and camera.data == settings.id_data
    return is_its and bool(lens.why_not(camera))


def renders_copies(scene):
    """Are copies of a scene rendered in its place?"""
    if not _may_have_views(scene):
        return False
    if freestyle.is_drawn(scene) or bodies.why_one_view(scene):
        return False
    most, scale = _asked(scene)
    return most > 1 or scale > 1 or sampling.has_offset(scene)


def are_asked(scene):
    """Are several views of a scene rendered?"""
    return renders_copies(scene) and _asked(scene)[0] > 1


def _may_have_views(scene):
    """May a render have views? They are of no use where nodes show the plain render."""
    has_own = scene.render.use_multiview or group.nodes_of(scene)
    return not has_own and setup.is_used(scene)


def _asked(scene):
    """(most views of a camera of a scene, parts of a pixel along its side)."""
    counts = map(most_views, keyed.ticked(camera_objects.cameras_of(scene)))
    return max(counts, default=1), parts.factor(scene)


def is_copy(scene):
    """Is it one of the throw-away copies?"""
    return scene.rack_focus.is_views_copy


# ---- start and end ----------------------------------------------------------------


def begin(scene, own_samples=0, is_refocus=False):
    """Makes the copies and hands the nodes over; for the main thread.

    own_samples: of a render with the camera's own lens, 0: none. is_refocus: the passes
    are there already. Does nothing where the scene itself is all that is rendered.
    """
    clean_up()
    if not _may_have_views(scene):
        return
    has_lines = freestyle.is_drawn(scene)
    used = keyed.ticked(camera_objects.cameras_of(scene))
    most, scale = _asked(scene)
    if is_refocus:
        scale = 1
    is_shared = most > 1 or scale > 1
    has_copies = is_shared or sampling.has_offset(scene)
    has_copies = has_copies and not is_refocus and not has_lines
    has_strokes = strokes.are_taken(scene)
    is_drawn = has_strokes and not is_refocus
    has_margin = overscan.is_rendered(scene) and not is_refocus
    has_margin = has_margin and any(least_views(one) < 2 for one in used)
    if not (has_copies or own_samples or is_drawn or has_margin):
        return
    reason = bodies.why_one_view(scene)
    if reason:
        failures.note(scene, reason, is_failure=False)
        return
    is_sequence = any(one_by_one.is_so(settings, scene) for settings in used)
    n_copies = most * scale**2 if is_sequence else 1
    copies = [
        _make_copy(scene, not is_shared) for _ in range(n_copies if has_copies else 0)
    ]
    own = finishing.make_copy(scene, _make_copy, own_samples) if own_samples else None
    drawn = strokes.make_copy(scene, _make_copy) if is_drawn else None
    margin = overscan.make_copy(scene, _make_copy) if has_margin else None
    beside = [one for one in (own, margin and margin[0]) if one]
    if has_strokes:
        strokes.take_out([*copies, *beside])
    if is_drawn:
        strokes.SWITCH.need(scene, True)
        beside.append(drawn)
    session = Session(scene, copies, own, drawn, margin)
    session.is_noisy = bool(copies) and most > 1 and denoising.is_possible(scene)
    try:
        for index, copy in enumerate(copies):
            indices = [index] if is_sequence else range(most * scale**2)
            session.suffixes += view_cameras.add(scene, copy, indices)
        handover.begin(scene, copies, beside)
    except Exception:
        clean_up()
        raise
    _sessions[scene.name] = session


def end(scene):
    """Puts everything back; for the main thread."""
    _sessions.pop(scene.name, None)
    clean_up()


def is_active(scene):
    """Is the scene being rendered in views?"""
    return scene.name in _sessions


def has_copies(scene):
    """Is the scene being rendered by copies in its place?"""
    return is_active(scene) and bool(_sessions[scene.name].copy_names)


def camera_of_frame(scene):
    """The camera object that the views of a frame are of; None: it has no views."""
    session = _sessions.get(scene.name)
    return session.camera if session is not None else None


def clean_up():
    """Removes what any render that is over left behind."""
    copies = [s for s in bpy.data.scenes if is_copy(s)]
    if not copies:
        return
    used = {name for one in _sessions.values() for name in one.copy_names}
    used |= {one.own_name for one in _sessions.values()}
    used |= {one.drawn_name for one in _sessions.values()}
    used |= {one.margin_name for one in _sessions.values()}
    copies = [copy for copy in copies if copy.name not in used]
    for scene in {copy.rack_focus.viewed for copy in copies} - {None}:
        handover.end(scene)
        strokes.SWITCH.need(scene, False)
    for copy in copies:
        _remove_copy(copy)


# ---- copies -----------------------------------------------------------------------


def _make_copy(scene, has_all_passes=False):
    copy = scene.copy()
    copy.name = f"{scene.name} Rack Focus Views"
    state = copy.rack_focus
    state.filter_scene = state.nodes_off = None
    state.record = state.muted = ""
    state.viewed = scene
    state.is_views_copy = True
    render = copy.render
    render.use_compositing = render.use_sequencer = False
    render.use_persistent_data = False
    render.views_format = "MULTIVIEW"
    copy.timeline_markers.clear()
    compat.drop_compositor(copy)
    if copy.sequence_editor is not None:
        copy.sequence_editor_clear()
    if scene.render.engine == "CYCLES":
        sampling.drop_offset(copy)
    is_read = compat.writes_passes(scene) or not setup.can_mute_sources(scene)
    uses_passes = has_all_passes or is_read
    kept = PASSES + (mirrors.PASSES if mirrors.is_wanted(scene) else ())
    for layer in copy.view_layers:
        for name in layer.bl_rna.properties.keys():
            if name.startswith("use_pass_") and name not in kept and not uses_passes:
                setattr(layer, name, False)
        layer.use_pass_combined = layer.use_pass_z = True
        if sharp.names_of(scene):
            setattr(layer, sharp.SWITCH.name, True)
    return copy


def _remove_copy(copy):
    view_cameras.remove(copy)
    compat.remove_scene(copy)


# ---- frames -----------------------------------------------------------------------


def prepare_frame(scene):
    """Sets the copies up for the camera of a frame, before it is rendered."""
    session = _sessions.get(scene.name)
    if session is None:
        return
    if session.copy_names:
        passes.forget(scene)
    session.is_collected = False
    camera = camera_objects.camera_at(scene, scene.frame_current)
    _look_through(scene, session, camera)


def _look_through(scene, session, camera):
    """The rest, for a camera object."""
    session.camera, session.noted = camera, scene.camera
    margin = session.margin_scene()
    for beside in filter(None, (session.own(), session.drawn(), margin)):
        _prepare_beside(scene, beside, session.camera)
    session.places = {}
    # Where bodies are is known only once the scene is evaluated.
    distances = {session.camera.name_full: 1.0} if bodies.are_in(scene) else {}
    with lens.known(distances):
        is_unfit = bool(lens.why_not(_at_frame(session.camera, scene)))
    settings = camera_objects.settings_of(session.camera)  # with keys, now the frame's
    most = max(len(session.suffixes) // session.scale**2, 1)
    session.n_views = min(view_count(settings), most)
    session.frame_scale, session.is_frame_noisy = session.scale, session.is_noisy
    if session.copy_names and (is_unfit or not settings.enabled):
        session.n_views, session.frame_scale = 1, 1
        session.is_frame_noisy = False
    session.note = ""
    if session.n_views > 1:
        note = moving.why_one_view(scene, session.camera)
        session.note = note or sheared.why_one_view(scene, session.camera)
        session.n_views = 1 if session.note else session.n_views
    is_filtered = settings.enabled and not is_unfit
    session.has_margin = margin is not None and is_filtered and session.n_views == 1
    if session.has_margin:
        overscan.look_through(margin, session.camera, session.margin[0])
    for index, copy in enumerate(session.copies()):
        supersample.prepare(copy, session.frame_scale)
        _prepare_copy(session, copy, index)
        if session.is_noisy:
            denoising.prepare(copy, session.is_frame_noisy)


def _prepare_beside(scene, copy, camera):
    """A copy that is rendered beside the picture, for a frame: camera, layers in use."""
    set_if_other(copy, "camera", camera)
    set_if_other(copy.render, "use_multiview", False)
    for layer, own in zip(copy.view_layers, scene.view_layers, strict=True):
        layer.use = own.use


def chosen_camera(copy):
    """The camera that a script chose for a copy in this frame; None: it chose none."""
    source = copy.rack_focus.viewed
    session = _sessions.get(source.name) if source is not None else None
    if session is None or session.camera is None:
        return None
    return switched.chosen(source, copy, _camera_of_copy(session, copy), session.noted)


def _camera_of_copy(session, copy):
    """What a copy renders through."""
    if copy.name == session.margin_name and session.has_margin:
        if view_cameras.has_camera(copy, session.camera):
            return session.camera
        return view_cameras.find(copy, session.margin[0])
    if copy.name not in session.copy_names or session.n_cameras() < 2:
        return session.camera
    if view_cameras.has_camera(copy, session.camera):
        return session.camera
    index = session.copy_names.index(copy.name)
    return view_cameras.find(copy, session.suffixes[index])


def look_through(copy, camera):
    """Renders the views of a frame from a camera that a script chose for a copy."""
    source = copy.rack_focus.viewed
    session = _sessions[source.name]
    if camera == session.camera:
        session.noted = source.camera
        set_if_other(copy, "camera", _camera_of_copy(session, copy))
    else:
        _look_through(source, session, camera)


def _at_frame(camera, scene):
    """A camera object with the values of the frame that is about to be rendered.

    The filter scene, which has little else than the cameras, is evaluated for that.
    """
    ours, data = setup.filter_scene_of(scene), camera.data
    if ours is None or camera.type != "CAMERA":
        return camera
    if not (data.animation_data or data.dof.focus_object):
        return camera
    ours.frame_set(scene.frame_current, subframe=scene.frame_subframe)
    return camera.evaluated_get(ours.view_layers[0].depsgraph)


def _prepare_copy(session, copy, index):
    """One copy for a frame; `index` is its place among the copies."""
    n_cameras, source = session.n_cameras(), copy.rack_focus.viewed
    is_used = index < n_cameras or index == 0
    for layer, own in zip(copy.view_layers, source.view_layers, strict=True):
        layer.use = own.use and is_used
    _split_samples(source, copy, index)
    is_by_name = one_by_one.multiview_works or not session.is_sequence
    copy.render.use_multiview = n_cameras > 1 and is_by_name
    is_still = session.n_views > 1 and one_by_one.is_spread(
        camera_objects.settings_of(session.camera)
    )
    copy.render.use_motion_blur = source.render.use_motion_blur and not is_still
    if n_cameras < 2:
        set_if_other(copy, "camera", session.camera)
        return
    suffixes = session.suffixes[:n_cameras]
    suffixes = suffixes[index : index + 1] if session.is_sequence else suffixes
    suffixes = suffixes or session.suffixes[:1]
    view_cameras.look_through(copy, session.camera, suffixes)


def _split_samples(scene, copy, index):
    """An n-th of the samples, of the time limit, n times the variance.

    Where the camera sets the samples of a view, they are those, and the limits stay.
    """
    session = _sessions[scene.name]
    each = camera_objects.settings_of(session.camera).view_samples
    scale = session.frame_scale
    n = session.n_views
    owner, name = sampling.samples_at(copy)
    if owner is not None:
        setattr(
            owner,
            name,
            sampling.samples_of_view(sampling.samples_of(scene), n, each, scale),
        )
    for layer, own in zip(copy.view_layers, scene.view_layers, strict=True):
        if own.samples:
            layer.samples = sampling.samples_of_view(own.samples, n, each, scale)
    if scene.render.engine != "CYCLES":
        return
    sampling.prepare(copy, scene, _is_moved(scene, session), scale)
    own, ours = scene.cycles, copy.cycles
    parts = (1 if each and n > 1 else n) * scale**2
    ours.time_limit = own.time_limit * scale**2 / parts
    ours.adaptive_threshold = min(own.adaptive_threshold * math.sqrt(parts), 1)
    ours.adaptive_min_samples = own.adaptive_min_samples // parts
    if len(session.copy_names) > 1:  # multi-view does this by itself
        ours.seed = (sampling.seed_of(scene) + 1664525 * index) % 2**31


def _is_moved(scene, session):
    """Are the frame's views moved within their pixels? See sampling.py."""
    data, n, scale = session.camera.data, session.n_views, session.frame_scale
    each = camera_objects.settings_of(session.camera).view_samples
    samples = sampling.samples_of_view(sampling.samples_of(scene), n, each, scale)
    return n > 1 and sampling.is_needed(scene, data, samples, scale)


def moment_of(scene):
    """The frame, a float, that a copy shows for its view; None for the scene's own."""
    source = scene.rack_focus.viewed
    session = _sessions.get(source.name) if source is not None else None
    if session is None or not session.is_sequence or session.camera is None:
        return None
    if scene.name not in session.copy_names:
        return None
    n = session.n_views
    if n < 2 or not one_by_one.is_spread(camera_objects.settings_of(session.camera)):
        return None
    index = session.copy_names.index(scene.name) // session.frame_scale**2
    start = compat.shutter_start(source)
    time = _points(session.camera, source, n)[min(index, n - 1)][2]
    return source.frame_float + start + source.render.motion_blur_shutter * time


def follow(scene, depsgraph):
    """Puts the cameras of a copy in their places, once it is evaluated for a frame."""
    source = scene.rack_focus.viewed
    session = _sessions.get(source.name) if source is not None else None
    if session is None or session.camera is None:
        return
    if scene.name == session.margin_name and session.has_margin:
        overscan.follow(scene, session.camera.evaluated_get(depsgraph), *session.margin)
    if scene.name not in session.copy_names:  # that of its own lens, Freestyle's
        return
    n, n_parts = session.n_views, session.frame_scale**2
    if n * n_parts < 2:
        return
    index = session.copy_names.index(scene.name)
    if session.is_sequence and index >= n * n_parts:
        return
    if session.is_sequence and culling.is_on(source):
        culling.let(depsgraph.scene_eval)
    seen = session.camera.evaluated_get(depsgraph)
    points = _points(seen, source, n)
    session.problem = ""
    try:
        params = lens.camera_parameters(seen, source.render)
    except lens.CameraError as error:
        session.problem = str(error)
        return
    made = rackfocus.Lens(*lens.picture_size(source.render), **params)
    is_moved = _is_moved(source, session)
    aspect = lens.aspect_of(source.render)
    plane = sampling.plane_in_place(made, is_moved, session.frame_scale, aspect)
    spread_px = sampling.spread_px(source) if is_moved else 0.0
    for number in [index] if session.is_sequence else range(n * n_parts):
        suffix = session.suffixes[number]
        camera = view_cameras.find(scene, suffix)
        part = number % n_parts
        right_up = supersample.shift_of(
            seen.data, source.render, session.frame_scale, part
        )
        point = points[number // n_parts]
        about = *point[:3], *right_up
        place = view_cameras.put(camera, seen, made, plane, about)
        set_if_other(camera.data.dof, "use_dof", is_moved)
        if is_moved:
            sampling.open_lens(camera.data, made, spread_px, aspect)
        if part == 0:
            session.places[number // n_parts] = place._replace(spread_px=spread_px)


def _points(camera, scene, n):
    """Points of the lens: (u, v, time) each, in lens radii right and up."""
    if n < 2:
        return [(0.0, 0.0, 0.5)]
    settings = camera.data.rack_focus
    params = lens.aperture_parameters(camera.data.dof)
    params.update(settings.lens_parameters())
    params["blade_curvature"] = settings.blade_curvature
    params["method"] = settings.method
    return rackfocus.lens_points(n, frame=scene.frame_current, **params)


# ---- after the views are rendered --------------------------------------------------


def note_of(scene):
    """What the user should know of the views of the frame, or ""."""
    session = _sessions.get(scene.name)
    return session.note if session is not None else ""


def collect(scene):
    """Takes the passes of a frame's views over, once they are rendered.

    Where that fails, what there is of the first view stands for the frame.
    """
    session = _sessions.get(scene.name)
    if session is None or session.is_collected:
        return
    session.is_collected = True
    if session.own_name:
        finishing.take(scene, session.own())
    if session.drawn_name:
        strokes.take(scene, session.drawn())
    if session.has_margin:
        suffix, wide = session.margin
        overscan.take(scene, wide, _only_view(session.margin_scene(), suffix))
    if not session.copy_names:
        return
    try:
        passes.put(scene, _take(session))
    except Exception:
        found = passes.RenderedPasses(session.copies()[0])
        found.files.setdefault("", next(iter(found.files.values())))
        passes.put(scene, found)
        raise


def _take(session):
    copies, n_views, n = session.copies(), session.n_views, session.n_cameras()
    if n < 2 and not session.is_frame_noisy:
        return passes.RenderedPasses(copies[0])
    if n < 2:  # another frame's camera has several
        files = [(passes.RenderedPasses(copies[0]), "", "")]
        return view_passes.ViewPasses(files, [passes.MIDDLE], False, 1, is_noisy=True)
    if len(session.places) != n_views:
        why = "the views' cameras were not placed; the console says why"
        raise ViewsError(session.problem or why)
    if session.is_sequence:
        files = list(map(_only_view, copies[:n], session.suffixes))
    else:
        suffixes = session.suffixes[:n]
        for _ in range(2):  # seen once in a busy machine: a file that was not written
            rendered = passes.RenderedPasses(copies[0], n)
            missing = [one for one in suffixes if one not in rendered.files]
            if not missing:
                break
        else:
            one_by_one.multiview_works = False
            raise ViewsError(
                f"this Blender rendered only {n - len(missing)} of {n} views together; "
                "render again: they are rendered one after another from now on"
            )
        files = [(rendered, one, f"v{i:02d}") for i, one in enumerate(suffixes)]
    source = copies[0].rack_focus.viewed
    if not session.is_noisy and not compat.writes_passes(source):
        for rendered in {id(one): one for one, _, _ in files}.values():
            rendered.drop_guides()
    settings = session.camera.data.rack_focus
    is_look_at = settings.method == "accumulate" and settings.camera_move == "look_at"
    places = [session.places[i] for i in range(n_views)]
    about = is_look_at, session.frame_scale, session.is_noisy
    return view_passes.ViewPasses(files, places, *about)


def _only_view(copy, name):
    """What a copy rendered through the camera of a name, as of view_passes.ViewPasses."""
    rendered = passes.RenderedPasses(copy)
    if not copy.render.use_multiview:
        return rendered, "", ""
    suffix = name if name in rendered.files else ""  # 3.4 leaves it out
    return rendered, suffix, copy.render.views[0].name


# ---- merging ----------------------------------------------------------------------


def method_for(method, found):
    """The method for the views that were rendered, [(passes.Layer, passes.Place)].

    ViewsError where it cannot be had from them.
    """
    if len(found) < 2 or method not in METHODS or method == "accumulate":
        return method
    if any(place.shear_distance == 0 for _, place in found):
        raise ViewsError(
            "the last render turned the camera towards the focus (Look At): its views "
            "can be accumulated, not merged; render again"
        )
    if len(found) > MOST_MERGED:
        raise ViewsError(
            f"the last render has {len(found)} views, of which {MOST_MERGED} can be "
            "merged; render again"
        )
    return "views"


def process(made, params, found, out, report, lights=None):
    """Filters a frame from its views.

    made: the rackfocus.Filter of params; found: [(passes.Layer, passes.Place)], whose
    first one is for methods that take one view; report: as of Filter.process(); lights:
    of each view that is used what that takes as seen, or None.
    """
    first = found[0][0]
    if len(found) > 1 and params["method"] == "accumulate":
        _accumulate(found, params, out, report)
    elif len(found) > 1 and params["method"] == "views":
        _merge(made, found, out, report, lights)
    else:
        about = {"seen": lights[0] if lights else None}
        about["mean_depth"] = passes.mean_depth(made, *found[0])
        made.process(first.colour, first.depth, out, report, **about)


def are_clean(found):
    """Were the views denoised together, and their grain kept?"""
    return len(found) > 1 and all(layer.grainy is not None for layer, _ in found)


def _merge(made, found, out, report, lights):
    layers = [layer for layer, _ in found]
    is_clean = not lights and are_clean(found)
    colours = [layer.grainy if is_clean else layer.colour for layer in layers]
    views = [
        rackfocus.View(
            colour, layer.depth, *place[:2], passes.mean_depth(made, layer, place)
        )
        for colour, (layer, place) in zip(colours, found, strict=True)
    ]
    if is_clean:
        made.merge_denoised(views, [x.colour for x in layers], out, report, check=False)
    else:
        made.process_views(views, out, report, lights, check=False)


def lights_of(params):
    """The parameters that a mean of pictures reads, of rackfocus.Filter's."""
    groups = {p.field: p.group for p in rackfocus.parameters()}
    is_read = {f: f == "blend_gamma" or groups.get(f) == "highlights" for f in params}
    return {field: value for field, value in params.items() if is_read[field]}


def _accumulate(found, params, out, report):
    height, width, channels = found[0][0].colour.shape
    total = rackfocus.Accumulator(width, height, channels, **lights_of(params))
    for index, (layer, _) in enumerate(found):
        if not report(index / len(found)):
            raise rackfocus.CancelledError("cancelled")
        total.add(layer.colour)
    total.mean(out)
    report(1.0)
