# SPDX-License-Identifier: GPL-3.0-or-later
"""In how many parts a render takes a pixel: as cameras say, or, with 0, as is best.

Of one view 2 x 2 parts are worth 0.2 to 5.0 dB on eleven of twelve scenes, and of eight
denoised ones 0.3 to 3.4 dB, for the same samples (docs/notebook/blender.md). So they are
taken where they cost the renderer no more, and nothing is lost that a render without has.
A camera that says 1 has whole pixels in all frames, unless another one says more.
"""

from . import (
    camera_objects,
    compat,
    copied,
    denoising,
    keyed,
    lens,
    memory,
    one_by_one,
    sampling,
    setup,
    sharp,
)

MOST = 4
LARGEST_PX = 32768  # of a side, for Blender and the filter
AUTOMATIC = 2  # 3 are worse than 2 on three of six scenes
# The other methods are previews, or take the mean of many views.
METHODS = ("layered", "views")
# Of samples that are no multiple of the parts so many are taken: 0.6 dB more grain.
LEAST_KEPT = 0.875
# Samples a part of several views that nobody denoises: eight views of seven files of strangers
# lose 1.1 dB with 1, four of these gain 1.0 with 2.
LEAST_OF_VIEWS = 2
# Passes of view layers that a supersampled render has, too.
PASSES = ("use_pass_combined", "use_pass_z", sharp.SWITCH.name)
NO_PASS = "use_pass_cryptomatte_accurate"  # is a setting


def why_not(scene):
    """Why the pictures of a scene are not supersampled, or "": for the box."""
    if scene.render.engine != "CYCLES":
        return "Supersample works with Cycles"
    reason = copied.why_not(scene, "Supersample")
    if reason:
        return reason
    if setup.filter_scene_of(scene) is not None and not setup.can_mute_sources(scene):
        return "Your nodes use other passes too: without Supersample"
    return ""


def factor(scene):
    """N of a render of a scene; 1 where it is not supersampled."""
    settings = _used(scene)
    if not settings or why_not(scene):
        return 1
    asked = max(keyed.most(one, "supersample") for one in settings)
    if asked == 0 and not why_not_automatic(scene):
        asked = AUTOMATIC
    longest = max(lens.picture_size(scene.render))
    return max(min(asked, LARGEST_PX // longest), 1)


def why_not_automatic(scene):
    """Why a scene whose cameras leave Supersample at 0 is not supersampled, or "".

    What why_not() says is not said again.
    """
    for settings in _used(scene):
        reason = _why_no_gain(scene, settings) or _why_dear(scene, settings)
        if reason:
            return f"Without Supersample: {reason}"
    if compat.writes_passes(scene) or any(map(_has_other_passes, scene.view_layers)):
        return "Without Supersample: other passes are only in a render without"
    return ""


def _used(scene):
    return keyed.ticked(camera_objects.cameras_of(scene))


def _why_no_gain(scene, settings):
    methods, qualities = (keyed.values(settings, f) for f in ("method", "quality"))
    if not methods.issubset(METHODS) or "preview" in qualities:
        return "it is for final pictures"
    if keyed.most(settings, "mirrors"):
        return "it does not work with Mirrors and Glass"
    if settings.id_data.type == "ORTHO":
        return "orthographic cameras do as well"
    if scene.render.use_motion_blur:
        return "what moves comes out better"
    n = keyed.most(settings, "views")
    shared = sampling.samples_of(scene), n, settings.view_samples
    each = sampling.samples_of_view(*shared)
    kept = sampling.samples_of_view(*shared, AUTOMATIC)
    if not LEAST_KEPT * each <= kept * AUTOMATIC**2 <= each:
        return f"{each} samples a pixel cannot be shared out"
    is_few = n > 1 and kept < LEAST_OF_VIEWS and not denoising.is_asked(scene)
    return f"{each} samples a view are too few for parts" if is_few else ""


def _why_dear(scene, settings):
    if one_by_one.is_so(settings, scene):
        return "each part would prepare the scene anew"
    if getattr(scene.cycles, "use_guiding", False):
        return "each part would train Path Guiding anew"
    width, height = lens.picture_size(scene.render)
    n_views = keyed.most(settings, "views")
    n_bytes = memory.needed(scene, n_views, width * height * AUTOMATIC**2)
    is_much = n_bytes >= memory.LOUD_BYTES
    return f"it needs some {n_bytes / 1e9:.0f} GB of memory" if is_much else ""


def _has_other_passes(layer):
    owners = (layer, getattr(layer, "cycles", None))
    names = [
        name
        for owner in owners
        if owner is not None
        for name in owner.bl_rna.properties.keys()
        if name.startswith("use_pass_")
        and name not in (*PASSES, NO_PASS)
        and getattr(owner, name)
    ]
    return bool(names) or len(getattr(layer, "aovs", ())) > 0
