# SPDX-License-Identifier: GPL-3.0-or-later
"""Finish: the camera's own lens, rendered with few samples and cleaned with our picture.

A copy of the scene renders with depth of field, after the views if there are any
(views.py). Our picture is kept where the grain of that render does not contradict it;
mirrors, glass, smoke and motion blur come out as the renderer sees them. What was
rendered is kept for as long as camera and frame are the same.
"""

from . import (
    bodies,
    camera_objects,
    denoising,
    group,
    keyed,
    lens,
    look,
    names,
    passes,
    props,
    sampling,
    setup,
    sharp,
    taken,
    walked,
)
from .library import rackfocus

OTHER_SEED = 7919  # its noise is not that of the pinhole's samples

# scene name: (key, passes.RenderedPasses, samples) of the last render of its lens
_kept = names.store()


# Below that the grain tells little that the picture does not know: one view of 64 samples
# gains 0.1 to 3 dB by 4 of the own lens, 8 views gain -0.1 to 0.3 (docs/notebook).
ENOUGH = 10

FEW = f"Finish adds little with fewer than {ENOUGH} samples: 16 or more"

OTHER_LIGHT = (
    "Finish: the camera's own lens shows more or less light than the picture: press F12, "
    "then Finish, where lights or materials were changed since"
)
OTHER_THINGS = (
    "Finish: the scene was changed since it was rendered, and the camera's own lens "
    "shows another picture: press F12, then Finish"
)


class FinishError(denoising.DenoiserError):
    """The picture is filtered, not finished; the message is for the user."""


# ---- what is asked for ------------------------------------------------------------


def why_not(scene):
    """Why a scene cannot be finished, or "": for the box and the operator."""
    camera = camera_objects.camera_of(scene)
    if camera is None or not keyed.ticked([camera]):
        return "Rack Focus is not ticked for the scene's camera"
    if scene.render.engine == "BLENDER_WORKBENCH":  # its lens is that of its shading
        return "Finish does not work with Workbench: take Cycles or EEVEE"
    if scene.render.use_multiview:
        return "Finish does not work with stereo"
    if group.nodes_of(scene):
        return "Finish does not work with Rack Focus nodes on pictures"
    if not setup.can_mute_sources(scene):
        return "Finish does not work where your nodes use other passes too"
    if bodies.why_one_view(scene):
        return "Finish needs rigid bodies to be baked: Scene > Rigid Body World > Cache"
    settings = camera.data.rack_focus
    if look.of(settings) != (1, 1) or props.has_look(settings):
        return "Finish follows the camera's own lens: set Look back to its defaults"
    if walked.once(sharp.names_of, scene):
        return "Finish follows the camera's own lens: no object can be kept sharp"
    return ""


def why_little(scene):
    """What few samples do to the picture, or "": for the box."""
    return FEW if scene.camera.data.rack_focus.finish_samples < ENOUGH else ""


def samples_of(scene):
    """Samples of the own lens that every render of a scene has, or 0."""
    if why_not(scene):
        return 0
    settings = camera_objects.camera_of(scene).data.rack_focus
    is_every = keyed.most(settings, "use_finish")
    return keyed.most(settings, "finish_samples") if is_every else 0


def clean(scene, own, ours, guides=None, samples=0):
    """rackfocus.finish() into the colours of `ours`, (height, width, 3 or 4).

    `guides`: albedo and normals of the own render, by these names, where known; samples:
    of its pixels, 0: not known. Returns
    what the artist should know of the result, or "". FinishError.
    """
    about = denoising.quality_of(scene), lens.white_of(scene), samples
    try:
        doubts = denoising.finish(own, ours, guides or {}, *about)
    except (rackfocus.Error, ValueError, MemoryError, OSError) as error:
        message = f"not finished: {denoising.explained(error)}"
        raise FinishError(message) from error
    if "light" in doubts:
        return OTHER_LIGHT
    # Fur and mirrors look so, too, and are what Finish is for: 34.8 to 38.2 and 23.3 to
    # 40.6 dB (tests/quality, 64 samples).
    return OTHER_THINGS if "lens" in doubts and taken.has_changed(scene) else ""


def need_denoiser():
    """FinishError where there is none: better known before a render than after it."""
    try:
        denoising.need()
    except denoising.DenoiserError as error:
        raise FinishError(f"not finished: {error}") from error


# ---- the render -------------------------------------------------------------------


def make_copy(scene, new_copy, samples):
    """A copy of a scene that renders through the camera's own lens.

    new_copy: function of a scene, which makes a copy for a render.
    """
    copy = new_copy(scene)
    copy.name = f"{scene.name} Rack Focus Finish"
    copy.rack_focus.is_own_lens = True
    copy.render.use_freestyle = False  # lines come over the finished picture
    for owner, name in (("cycles", "samples"), ("eevee", "taa_render_samples")):
        if hasattr(getattr(copy, owner, None), name):
            setattr(getattr(copy, owner), name, samples)
    if scene.render.engine == "CYCLES":
        copy.cycles.use_denoising = False
        copy.cycles.seed = (copy.cycles.seed + OTHER_SEED) % 2**31
        copy.cycles.time_limit = 0
    for layer in copy.view_layers:
        if layer.samples:
            layer.samples = samples
        if hasattr(layer, "cycles"):
            layer.cycles.denoising_store_passes = True
    return copy


# ---- what was rendered ------------------------------------------------------------


def _key(scene):
    """What the render depends on that a refocus may change."""
    camera = camera_objects.camera_of(scene)
    try:
        params = lens.camera_parameters(camera, scene.render)
    except lens.CameraError:
        params = {}
    return scene.frame_current, camera.name, tuple(sorted(params.items()))


def take(scene, copy):
    """Keeps the passes of the copy, once it is rendered."""
    samples = sampling.samples_of(copy)
    _kept[scene.name] = _key(scene), passes.RenderedPasses(copy), samples


def forget(scene=None):
    """Lets go of what was rendered, of a scene or of all."""
    if scene is None:
        _kept.clear()
    else:
        _kept.pop(scene.name, None)


def is_finished(scene):
    """Is there a render of the present lens, which a refocus takes too?"""
    found = _kept.get(scene.name)
    return found is not None and not why_not(scene) and found[0] == _key(scene)


def own_of(scene, layer):
    """(passes.Layer, guides and samples of clean()) of a view layer; None: there is none."""
    if not is_finished(scene):
        return None
    _, rendered, samples = _kept[scene.name]
    channels = next(iter(rendered.files.values()))
    return rendered.layer(layer), passes.guides_of(channels, layer), samples
