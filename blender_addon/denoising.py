# SPDX-License-Identifier: GPL-3.0-or-later
"""Open Image Denoise: where it is, and the grain of several views.

Where Cycles' own denoiser is on, views that are merged are rendered with their grain,
with albedo and normals, and cleaned together: each is told what the others show of the
same points (rackfocus.Filter.denoise_views()). That happens once per render; a refocus
merges what came out with what went in (Filter.merge_denoised()). Without Open Image
Denoise Cycles cleans each view by itself.
"""

import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import bpy
import numpy as np

from . import camera_objects, fog, keyed, lens, passes, preferences, supersample
from .library import rackfocus

# Of builds of blender.org and of PyPI's bpy, from the folder above that of the version.
OWN_DENOISER = (
    "lib/libOpenImageDenoise.so*",
    "lib/libOpenImageDenoise*.dylib",
    "blender.shared/OpenImageDenoise.dll",
)
DENOISER = "RACKFOCUS_OIDN"  # names it, before the preferences
FAILED = 3  # exit status of BESIDE that goes with a message
POLL_S = 0.2
# Works in a process of its own; see _run_beside().
BESIDE = f"""
import json, sys, warnings
sys.path[:0], folder = sys.argv[1:3], sys.argv[3]
from pathlib import Path
import numpy, rackfocus
def array(name):
    path = Path(folder, name + ".npy")
    return numpy.load(path) if path.exists() else None
about = json.loads(Path(folder, "about.json").read_text())
given = {{name: about[name] for name in ("library", "quality", "threads")}}
doubts = []
try:
    if about["places"]:
        size, threads = about["size"], about["threads"]
        made = rackfocus.Filter(*size, threads=threads, **about["params"])
        views = [
            (array(f"colour{{j}}"), array(f"depth{{j}}"), tuple(offset), distance)
            for j, (offset, distance) in enumerate(about["places"])
        ]
        outs = [view[0] for view in views]
        guides = [
            (array(f"albedo{{j}}"), array(f"normal{{j}}")) for j in range(len(views))
        ]
        made.denoise_views(views, outs, guides, **given)
    else:
        outs = [array("ours")]
        names = ("albedo", "normal")
        guides = {{name: array(name) for name in names}}
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", rackfocus.ViewsWarning)
            given |= {{name: about[name] for name in ("white", "samples")}}
            rackfocus.finish(array("own"), outs[0], outs[0], **guides, **given)
        doubts = [getattr(one.message, "about", "") for one in told]
except Exception as error:
    print(error, file=sys.stderr)
    sys.exit({FAILED})
for j, out in enumerate(outs):
    numpy.save(f"{{folder}}/out{{j}}.npy", out)
Path(folder, "doubts.json").write_text(json.dumps(doubts))
"""

_found = set()  # what library() gave, of libraries that have worked
_missing = set()  # and of those that have not


class DenoiserError(Exception):
    """Grain stays in the picture; the message is for the user."""


# ---- the library ------------------------------------------------------------------


def library():
    """(path of Open Image Denoise or None: the system looks, is it Blender's own?)"""
    chosen = os.environ.get(DENOISER) or preferences.get("denoiser", "")
    if chosen:
        return bpy.path.abspath(chosen), False
    home = Path(bpy.utils.resource_path("LOCAL")).parent
    found = [path for place in OWN_DENOISER for path in sorted(home.glob(place))]
    return (str(found[0]), True) if found else (None, False)


def explained(error):
    """The message of an error of a denoiser."""
    more = " (or in the add-on's preferences)" if DENOISER in str(error) else ""
    return f"{error}{more}"


def quality_of(scene):
    """Of the denoiser's filters, as Cycles is set (Render > Sampling), since 4.2."""
    cycles = getattr(scene, "cycles", None)
    return getattr(cycles, "denoising_quality", "HIGH").lower()


def finish(own, ours, guides, quality="high", white=1.0, samples=0):
    """rackfocus.finish() into the colours of `ours`, (height, width, 3 or 4).

    `guides`: albedo and normals of the own render, by these names, where known; white,
    samples: as of rackfocus.finish(). Returns in what `ours` differs from `own` though it should
    not: "light", "lens" (a set). A library that is not Blender's own runs in another
    process: that of PyPI (2.5) and the memory allocator of Debian's Blenders (3.4, 5.2)
    end both.
    """
    path, is_own = library()
    about = {"quality": quality, "white": white, "samples": samples}
    if not is_own:
        given = {"own": own[..., :3], "ours": ours[..., :3], **guides}
        outs, doubts = _run_beside(path, given, {"places": [], **about})
        ours[..., :3] = outs[0]
        return set(doubts)
    about |= {"library": path, "threads": preferences.threads()}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", rackfocus.ViewsWarning)
        rackfocus.finish(own, ours, ours[..., :3], **guides, **about)
    return {getattr(one.message, "about", "") for one in told}


def _run_beside(path, given, about, report=lambda _: True):
    """What BESIDE writes, done by Python in another process: pictures, doubts of finish().

    OSError with its message. given: arrays by name; about: what else it reads.
    """
    about = {**about, "library": path, "threads": preferences.threads()}
    n_bytes = sum(4 * values.size for values in given.values())
    with passes.own_folder(passes.memory_folder(2 * n_bytes)) as folder:
        for name, values in given.items():
            np.save(folder / f"{name}.npy", np.ascontiguousarray(values, np.float32))
        (folder / "about.json").write_text(json.dumps(about))
        places = [str(Path(m.__file__).parents[1]) for m in (rackfocus, np)]
        command = [sys.executable, "-c", BESIDE, *places, str(folder)]
        _wait(command, report)
        n = max(len(about["places"]), 1)
        outs = [np.load(folder / f"out{j}.npy") for j in range(n)]
        return outs, json.loads((folder / "doubts.json").read_text())


def _wait(command, report):
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:
        while True:
            try:
                printed = process.communicate(timeout=POLL_S)[1]
                break
            except subprocess.TimeoutExpired:
                if not report(0.0):
                    process.kill()
                    raise rackfocus.CancelledError("cancelled") from None
    if process.returncode == FAILED:
        raise OSError(printed.strip())
    if process.returncode:
        raise OSError(f"Open Image Denoise failed ({process.returncode})")


def need():
    """DenoiserError where there is none: better known before a render than after it."""
    if library() in _found:
        return
    try:
        finish(*np.zeros((2, 16, 16, 3), np.float32), {})
    except (rackfocus.Error, ValueError, MemoryError, OSError) as error:
        _missing.add(library())
        raise DenoiserError(explained(error)) from error
    _found.add(library())


# ---- several views ----------------------------------------------------------------


def is_asked(scene):
    """Are a scene's views to be cleaned together, where there is a denoiser?"""
    used = keyed.ticked(camera_objects.cameras_of(scene))
    is_merged = all(one.method != "accumulate" for one in used)
    is_wanted = all(one.denoise_together for one in used)
    is_on = scene.render.engine == "CYCLES" and scene.cycles.use_denoising
    return bool(used) and is_on and is_merged and is_wanted


def is_possible(scene):
    """Are they? Looks for the denoiser, which may take a second."""
    if not is_asked(scene):
        return False
    try:
        need()
    except DenoiserError:
        return False
    return True


def why_not(scene):
    """Why each view is cleaned by itself though it is asked otherwise, or ""."""
    if _missing and is_asked(scene) and library() in _missing:
        return "No Open Image Denoise: each view is denoised by itself"
    return ""


def prepare(copy, is_noisy):
    """Lets a copy that renders views keep what guides the denoiser; its grain too?"""
    copy.cycles.use_denoising = not is_noisy
    for layer in copy.view_layers:
        layer.cycles.denoising_store_passes = True


def clean(rendered, frame, scene, report):
    """Takes the grain out of the views of a frame, once; DenoiserError.

    rendered: view_passes.ViewPasses; frame: engine.Frame of a view layer; scene: the
    user's; report: as of Filter.process().
    """
    found = fog.filled(rendered.views(frame.layer), scene)
    if any(layer.depth is None for layer, _ in found):
        return  # is said later
    height, width = found[0][0].depth.shape
    scale = supersample.scale_of((width, height), scene.render)
    settings = camera_objects.settings_of(frame.camera)
    try:
        params = lens.frame_parameters(
            frame.camera, settings, scene.render, (width, height), scale
        )
    except lens.CameraError:
        return  # is said later
    guides = [rendered.guides(frame.layer, j) for j in range(len(found))]
    try:
        made = _denoised(scene, (width, height), params, found, guides, report)
    except rackfocus.CancelledError:
        raise
    except (rackfocus.Error, ValueError, MemoryError, OSError) as error:
        message = f"the views are not denoised: {explained(error)}"
        raise DenoiserError(message) from error
    rendered.put_clean(frame.layer, made)


def _denoised(scene, size, params, found, guides, report):
    """Colours of the views without grain."""
    path, is_own = library()
    quality = quality_of(scene)
    places = [(place.offset, place.shear_distance) for _, place in found]
    if not is_own:
        given = {}
        for j, (layer, _) in enumerate(found):
            given |= {f"colour{j}": layer.colour, f"depth{j}": layer.depth}
            given |= {f"{name}{j}": values for name, values in guides[j].items()}
        about = {"places": places, "size": size, "params": params, "quality": quality}
        return _run_beside(path, given, about, report)[0]
    views = [
        (layer.colour, layer.depth, *place)
        for (layer, _), place in zip(found, places, strict=True)
    ]
    outs = [np.empty(layer.colour.shape, np.float32) for layer, _ in found]
    known = [(one.get("albedo"), one.get("normal")) for one in guides]
    threads = preferences.threads()
    made = rackfocus.Filter(*size, threads=threads, **params)
    about = {"library": path, "quality": quality, "threads": threads}
    made.denoise_views(views, outs, known, report, **about)
    return outs
