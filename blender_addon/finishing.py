# SPDX-License-Identifier: GPL-3.0-or-later
"""Finish: the camera's own lens, rendered with few samples and cleaned with our picture.

A copy of the scene renders with depth of field, after the views if there are any
(views.py). Our picture is kept where the grain of that render does not contradict it;
mirrors, glass, smoke and motion blur come out as the renderer sees them. What was
rendered is kept for as long as camera and frame are the same.
"""

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

from . import group, lens, look, passes, preferences, props, setup, sharp
from .library import rackfocus

# Passes of Cycles, where denoising data is stored, by what they guide as.
GUIDES = {"albedo": ("Denoising Albedo", "RGB"), "normal": ("Denoising Normal", "XYZ")}
OTHER_SEED = 7919  # its noise is not that of the pinhole's samples

_kept = {}  # scene name: (key, passes.RenderedPasses) of the last render of its lens


_found = set()  # what library() gave, of libraries that have worked


class FinishError(Exception):
    """The picture is filtered, not finished; the message is for the user."""


# ---- what is asked for ------------------------------------------------------------


def why_not(scene):
    """Why a scene cannot be finished, or "": for the box and the operator."""
    if scene.camera is None or not scene.camera.data.rack_focus.enabled:
        return "Rack Focus is not ticked for the scene's camera"
    if scene.render.use_multiview:
        return "Finish does not work with stereo"
    if group.nodes_of(scene):
        return "Finish does not work with Rack Focus nodes on pictures"
    if not setup.can_mute_sources(scene):
        return "Finish does not work where your nodes use other passes too"
    settings = scene.camera.data.rack_focus
    if look.of(settings) != (1, 1) or props.has_look(settings):
        return "Finish follows the camera's own lens: set Look back to its defaults"
    if sharp.names_of(scene):
        return "Finish follows the camera's own lens: no object can be kept sharp"
    return ""


def samples_of(scene):
    """Samples of the own lens that every render of a scene has, or 0."""
    settings = scene.camera.data.rack_focus if scene.camera is not None else None
    if settings is None or not settings.use_finish or why_not(scene):
        return 0
    return settings.finish_samples


# ---- the denoiser -----------------------------------------------------------------

# Of builds of blender.org and of PyPI's bpy, from the folder above that of the version.
OWN_DENOISER = (
    "lib/libOpenImageDenoise.so*",
    "lib/libOpenImageDenoise*.dylib",
    "blender.shared/OpenImageDenoise.dll",
)
DENOISER = "RACKFOCUS_OIDN"  # names it, before the preferences
FAILED = 3  # exit status of BESIDE that goes with a message
# Finishes in a process of its own; see clean().
BESIDE = f"""
import sys
sys.path[:0], library, threads, folder = sys.argv[1:3], *sys.argv[3:]
import numpy, rackfocus
own, ours, *guides = (
    numpy.load(f"{{folder}}/{{n}}.npy") for n in ("own", "ours", "albedo", "normal")
)
albedo, normal = (guide if guide.size else None for guide in guides)
try:
    rackfocus.finish(
        own, ours, ours, albedo=albedo, normal=normal,
        library=library or None, threads=int(threads),
    )
except Exception as error:
    print(error, file=sys.stderr)
    sys.exit({FAILED})
numpy.save(f"{{folder}}/ours.npy", ours)
"""


def library():
    """(path of Open Image Denoise or None: the system looks, is it Blender's own?)"""
    chosen = os.environ.get(DENOISER) or preferences.get("denoiser", "")
    if chosen:
        return bpy.path.abspath(chosen), False
    home = Path(bpy.utils.resource_path("LOCAL")).parent
    found = [path for place in OWN_DENOISER for path in sorted(home.glob(place))]
    return (str(found[0]), True) if found else (None, False)


def clean(own, ours, guides=None):
    """rackfocus.finish() into the colours of `ours`, (height, width, 3 or 4).

    `guides`: albedo and normals of the own render, by these names, where known. A
    library that is not Blender's own runs in another process: that of PyPI (2.5) and
    the memory allocator of Debian's Blenders (3.4, 5.2) end both. FinishError.
    """
    path, is_own = library()
    try:
        if is_own:
            about = {**(guides or {}), "library": path}
            about["threads"] = preferences.threads()
            rackfocus.finish(own, ours, ours[..., :3], **about)
        else:
            ours[..., :3] = _clean_beside(own, ours, guides or {}, path)
    except (rackfocus.Error, ValueError, MemoryError, OSError) as error:
        more = " (or in the add-on's preferences)" if DENOISER in str(error) else ""
        raise FinishError(f"not finished: {error}{more}") from error


def _clean_beside(own, ours, guides, path):
    """The colours, finished by Python in another process; OSError with its message."""
    nothing = np.zeros((0, 0, 3), np.float32)
    given = {"own": own[..., :3], "ours": ours[..., :3]}
    given |= {name: guides.get(name, nothing) for name in GUIDES}
    with passes.own_folder(passes.memory_folder(4 * own[..., :3].nbytes)) as folder:
        for name, values in given.items():
            np.save(folder / f"{name}.npy", np.ascontiguousarray(values, np.float32))
        places = [str(Path(m.__file__).parents[1]) for m in (rackfocus, np)]
        options = [path or "", str(preferences.threads()), str(folder)]
        command = [sys.executable, "-c", BESIDE, *places, *options]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode == FAILED:
            raise OSError(done.stderr.strip())
        if done.returncode:
            raise OSError(f"Open Image Denoise failed ({done.returncode})")
        return np.load(folder / "ours.npy")


def need_denoiser():
    """FinishError where there is none: better known before a render than after it."""
    if library() not in _found:
        clean(*np.zeros((2, 16, 16, 3), np.float32))
        _found.add(library())


# ---- the render -------------------------------------------------------------------


def make_copy(scene, new_copy, samples):
    """A copy of a scene that renders through the camera's own lens.

    new_copy: function of a scene, which makes a copy for a render.
    """
    copy = new_copy(scene)
    copy.name = f"{scene.name} Rack Focus Finish"
    copy.rack_focus.is_own_lens = True
    for owner, name in (("cycles", "samples"), ("eevee", "taa_render_samples")):
        if hasattr(getattr(copy, owner, None), name):
            setattr(getattr(copy, owner), name, samples)
    if scene.render.engine == "CYCLES":
        copy.cycles.use_denoising = False
        copy.cycles.seed = (scene.cycles.seed + OTHER_SEED) % 2**31
        copy.cycles.time_limit = 0
    for layer in copy.view_layers:
        if layer.samples:
            layer.samples = samples
        if hasattr(layer, "cycles"):
            layer.cycles.denoising_store_passes = True
    return copy


def prepare_copy(scene, copy, camera):
    """For a frame: its camera, the layers that are in use."""
    copy.camera = camera
    copy.render.use_multiview = False
    for layer, own in zip(copy.view_layers, scene.view_layers, strict=True):
        layer.use = own.use


# ---- what was rendered ------------------------------------------------------------


def _key(scene):
    """What the render depends on that a refocus may change."""
    camera = scene.camera
    try:
        params = lens.camera_parameters(camera, scene.render)
    except lens.CameraError:
        params = {}
    return scene.frame_current, camera.name, tuple(sorted(params.items()))


def take(scene, copy):
    """Keeps the passes of the copy, once it is rendered."""
    _kept[scene.name] = _key(scene), passes.RenderedPasses(copy)


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
    """(passes.Layer, guides of clean()) of a view layer; None where there is none."""
    if not is_finished(scene):
        return None
    rendered = _kept[scene.name][1]
    channels = next(iter(rendered.files.values()))
    guides = {}
    for guide, (part, axes) in GUIDES.items():
        names = [f"{layer}.{part}.{c}" for c in axes]
        if all(name in channels for name in names):
            guides[guide] = passes.side_by_side([channels[name] for name in names])
    return rendered.layer(layer), guides
