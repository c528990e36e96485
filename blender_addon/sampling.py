# SPDX-License-Identifier: GPL-3.0-or-later
"""Views of few samples: where in a pixel they are taken.

Cycles takes the first sample of every pixel in its middle, whatever the seed, so of 8
views of 2 samples half are at one place, where things in focus are the same in all
views. Two things put them elsewhere:

- the plane that stays in place in all views is not that in focus but one where the
  blur has a radius of OFF_FOCUS_PX: each view has its own part of the pixel in focus;
- in place of the pixel filter each camera has a tiny lens focused close before it,
  which the first sample does not escape: all that is farther is spread over a disc.

    1/D = 1/focus - OFF_FOCUS_PX / K      K = lens radius * focal length in px
    radius of the tiny lens = spread * z / (focal length in px), its focus z

Pixels that are not square have another focal length on each axis: K has their geometric
mean, and the tiny lens is as much narrower on one, so that its disc is round in pixels.

The variance of a disc of radius r is r^2 / 4 on each axis; merging adds that of placing
the views between pixels. The parts of a supersampled pixel are pixels in all of this but
for the disc, which is as large as ever: supersample.py takes it off what is left for the
shrinking. docs/notebook/rivals.md has the scores.
"""

import math

from . import freestyle, group, passes, supersample
from .writing import set_if_other

OFFSET_SEED = 104729  # seeds apart of the views of one sample offset and the next
FEW = 4  # samples of a view, at most
OFF_FOCUS_PX = 1.5
SPREAD = 1 / 3  # radius of the disc in widths of the pixel filter, 0.5 px of 1.5
CLOSE = 0.01  # of the focus distance
NO_FILTER = 0.01  # px, the least that Cycles takes


def samples_of(scene):
    """Samples per pixel of the scene's engine, or 0 where it has none."""
    if scene.render.engine == "CYCLES":
        return subset_of(scene)[1]
    owner, name = samples_at(scene)
    return getattr(owner, name) if owner is not None else 0


def samples_at(scene):
    engines = {"CYCLES": ("cycles", "samples")}
    owner, name = engines.get(scene.render.engine, ("eevee", "taa_render_samples"))
    owner = getattr(scene, owner, None)
    return (owner, name) if hasattr(owner, name) else (None, "")


def samples_of_view(whole, n, each, scale=1):
    """Samples of a pixel of each of n views.

    whole: of the scene; each: as set, 0: share out; scale: of a supersampled frame,
    whose pixels are scale^2 as many.
    """
    samples = each if each and n > 1 else whole // n
    return max(samples // scale**2, 1)


def is_needed(scene, data, samples, scale):
    """Is a view of a scene moved within its pixels?

    data: of the user's camera; samples: of a view; scale: of a supersampled frame, where
    the pixel filter has to be wide enough for it.
    """
    return (
        scene.render.engine == "CYCLES"
        and data.type == "PERSP"
        and data.rack_focus.method != "accumulate"  # all must stay in focus
        and 0 < samples <= FEW
        and (scale == 1 or supersample.leaves_room(scene, scale, spread_px(scene)))
    )


def subset_of(scene):
    """(offset, samples) of the part of its samples that a scene of Cycles renders.

    From 4.5 on the offset counts where a subset is asked for.
    """
    cycles = scene.cycles
    if not hasattr(cycles, "use_sample_subset"):
        return cycles.sample_offset, cycles.samples
    if not cycles.use_sample_subset:
        return 0, cycles.samples
    left = cycles.samples - cycles.sample_offset
    return cycles.sample_offset, max(min(cycles.sample_subset_length, left), 1)


def has_offset(scene):
    """Does Cycles leave the first sample out, with which alone it writes depth?"""
    return scene.render.engine == "CYCLES" and subset_of(scene)[0] > 0


def seed_of(scene):
    """The seed of copies of a scene, whose samples have no offset."""
    return (scene.cycles.seed + OFFSET_SEED * subset_of(scene)[0]) % 2**31


def drop_offset(copy):
    """Lets a copy of a scene take as many first samples with another seed instead.

    Renders with offsets that follow one another still have noise of their own.
    """
    ours, seed, samples = copy.cycles, seed_of(copy), subset_of(copy)[1]
    ours.samples, ours.sample_offset, ours.seed = samples, 0, seed
    if hasattr(ours, "use_sample_subset"):
        ours.use_sample_subset = False


def why_no_depth(scene, depth):
    """Why Cycles wrote no depth pass where no copy could render in a scene's place."""
    has_no_copies = scene.render.use_multiview or group.nodes_of(scene)
    if not has_offset(scene) or depth.min() < passes.NOTHING_HIT:
        return ""
    if not has_no_copies and not freestyle.is_drawn(scene):
        return ""
    return (
        "Sampling > Sample Offset leaves out the first sample, with which alone Cycles "
        "writes depth; with stereo, Freestyle's lines or Rack Focus nodes on pictures set "
        "it to 0"
    )


def spread_px(scene):
    """Radius of the disc over which moved views spread a pixel, px of the asked size."""
    return SPREAD * scene.cycles.filter_width


def prepare(copy, scene, is_moved, scale):
    """Sets the pixel filter of a copy of a scene for a frame; supersample.prepare() did
    where the frame is supersampled and not moved."""
    own, ours = scene.cycles, copy.cycles
    if scale > 1 and not is_moved:
        return
    ours.pixel_filter_type = "BLACKMAN_HARRIS" if is_moved else own.pixel_filter_type
    ours.filter_width = NO_FILTER if is_moved else own.filter_width


def plane_in_place(made, is_moved, scale, aspect):
    """Distance of the plane that stays in place in all views.

    made: rackfocus.Lens; scale: of a supersampled frame; aspect: of lens.aspect_of(). That of
    moved views is beyond the focus, where all beyond blurs by much more.
    """
    blur_px = made.lens_radius * made.focal_length_px * math.sqrt(aspect)
    if not is_moved or not blur_px > 0:
        return made.focus_distance
    in_focus, off = 1 / made.focus_distance, OFF_FOCUS_PX / scale / blur_px
    return 1 / (in_focus - off if in_focus > 2 * off else in_focus + off)


def open_lens(data, made, radius_px, aspect):
    """Gives a view's camera the tiny lens in place of the pixel filter.

    data: bpy.types.Camera without a focus object; made: rackfocus.Lens; radius_px: from
    spread_px(); aspect: of lens.aspect_of().
    """
    close = CLOSE * made.focus_distance
    focal_length_px = made.focal_length_px * aspect  # upwards, as the lens's radius is
    radius = radius_px / focal_length_px * close / (1 - CLOSE)
    dof = data.dof
    set_if_other(dof, "focus_distance", close)
    set_if_other(dof, "aperture_fstop", data.lens * 1e-3 / (2 * radius))
    set_if_other(dof, "aperture_blades", 0)
    set_if_other(dof, "aperture_ratio", 1 / aspect)  # Cycles divides the width by it
