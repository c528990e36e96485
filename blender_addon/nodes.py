# SPDX-License-Identifier: GPL-3.0-or-later
"""Filtering the nodes with sockets of a scene, once it is rendered."""

import contextlib
import functools
import time

import numpy as np

from . import (
    compat,
    exr,
    group,
    halos,
    lens,
    look,
    main_thread,
    names,
    passes,
    preferences,
    sampling,
    setup,
    tap,
)
from .library import rackfocus

PUT_S = 20.0  # that the main thread may take until it comes to the images
BAND_COLOUR = np.array([0.05, 1.0, 0.2, 1.0], np.float32)

_kept = names.store()  # scene name: {node name: (tap.Tapped, depth)} of the last render


def forget(scene=None):
    """Lets go of what nodes were given, of a scene or of all."""
    if scene is None:
        _kept.clear()
    else:
        _kept.pop(scene.name, None)


def overlay(picture, coc, limit_px):
    """The picture with the band in focus in false colour; same shapes."""
    shown = picture.copy()
    band = np.abs(coc[..., 0]) <= limit_px
    shown[band] = 0.5 * shown[band] + 0.5 * BAND_COLOUR
    return shown


def run(scene, depsgraph, engine, seconds):
    """Filters all nodes of a scene and puts the images into their groups.

    engine: for progress and Esc; seconds: {step: of each}, added to. What fails first
    is raised after all nodes; a node that fails passes its picture through.
    """
    found = group.nodes_of(scene)
    if not found:
        return
    is_refocus = bool(scene.rack_focus.muted)
    if not is_refocus:
        forget(scene)
    problem = None
    with contextlib.ExitStack() as stack:
        files = None
        for node in found:
            try:
                given = _kept.get(scene.name, {}).get(node.name)
                if given is None:
                    started = time.perf_counter()
                    if files is None:
                        files = _save(stack, scene)
                    given = _given(scene, node, files)
                    _kept.setdefault(scene.name, {})[node.name] = given
                    _add(seconds, "tap", started)
                _filter(scene, depsgraph, node, given, engine, seconds)
            except Exception as error:
                _pass_through(scene, node, files)
                problem = problem or _named(node, error)
    if problem:
        raise problem


def _pass_through(scene, node, files):
    """Puts what came in into the group's images, else the render, else the default."""
    given = _kept.get(scene.name, {}).get(node.name)
    if given is not None:
        picture = given[0].colour
    elif files:
        layer = group.layer_of(scene, node)
        picture = passes.find_layer(exr.read_exr(files[scene]), layer).colour
    else:
        width, height = lens.picture_size(scene.render)
        colour = np.float32(node.inputs["Image"].default_value)
        picture = np.broadcast_to(colour, (height, width, 4))
    pixels = {group.PICTURE: picture, group.FOCUS: picture}
    pixels[group.DATA] = np.zeros((*picture.shape[:2], 4), np.float32)
    main_thread.run_or_here(functools.partial(_put, node.node_tree, pixels), PUT_S)


def _named(node, error):
    """The error with the node's name, where it is one of ours."""
    if isinstance(error, tap.TapError):
        return tap.TapError(f"node “{node.name}”: {error}")
    return error


def _add(seconds, step, started):
    seconds[step] = seconds.get(step, 0) + time.perf_counter() - started


def _save(stack, scene):
    """{scene: path} of the passes of a scene that is in its own compositor."""
    tree = compat.compositor_tree(scene)
    if not setup.layer_nodes(tree, scene):
        return {}
    files = stack.enter_context(passes.RenderedPasses.saved(scene))
    return {scene: files.get("", next(iter(files.values())))}


def _given(scene, node, files):
    """(tap.Tapped, depth) of a node."""
    tapped = tap.read(scene, node, files)
    if tapped.depth is not None:
        return tapped, np.ascontiguousarray(tapped.depth)
    layer = group.layer_of(scene, node)
    path = files.get(scene)
    if path is None:
        raise tap.TapError("no Depth is linked, and the scene is not rendered")
    depth = passes.find_layer(exr.read_exr(path), layer).depth
    if depth is None:
        raise tap.TapError(f"view layer “{layer}” has no depth: link one")
    reason = sampling.why_no_depth(scene, depth)
    if reason:
        raise tap.TapError(reason)
    return tapped, np.array(depth)


def parameters(scene, camera, size):
    """Those of rackfocus.Filter for a picture of `size` px of the scene."""
    settings, render = camera.data.rack_focus, scene.render
    is_cut = render.use_border and render.use_crop_to_border
    if is_cut:
        return lens.frame_parameters(camera, settings, render, size)
    params = lens.camera_parameters(camera, render)
    white = lens.white_of(render.id_data)
    params.update(settings.method_parameters(), white=white)
    return params


def _filter(scene, depsgraph, node, given, engine, seconds):
    tapped, depth = given
    camera = group.camera_of(scene, node)
    if camera is None:
        raise tap.TapError("the scene has no camera to take the lens from")
    height, width = tapped.colour.shape[:2]
    if depth.shape != (height, width):
        raise tap.TapError(
            f"the Image is of {width} x {height} px, the depth of {depth.shape[1]} x "
            f"{depth.shape[0]}: link a Depth of the same size"
        )
    if not np.isscalar(tapped.mask) and tapped.mask.shape != depth.shape:
        raise tap.TapError("the Mask is of another size than the Image")
    seen = camera.evaluated_get(depsgraph)
    params = parameters(scene, seen, (width, height))
    if params["method"] in ("views", "accumulate"):
        params["method"] = "layered"  # one picture comes in
    is_flat = params["projection"] == "orthographic"
    focus, values = params["focus_distance"], look.of(seen.data.rack_focus)
    is_masked = not np.isscalar(tapped.mask) or tapped.mask < 1
    if not is_flat and (is_masked or values != (1, 1)):
        focus = look.focus_of(depth.shape, params)
    used = look.with_mask(depth, tapped.mask, focus, is_flat)
    used = passes.with_some_depth(look.depth(used, values, focus, is_flat))
    started = time.perf_counter()
    made = rackfocus.Filter(
        width, height, threads=preferences.threads(), **params,
        **seen.data.rack_focus.light_keywords(),
    )  # fmt: skip
    if scene.render.film_transparent:
        engine._note(scene, halos.why_wrong(tapped.colour, used, made, params))
    picture = np.empty((height, width, 4), np.float32)
    made.process(tapped.colour, used, picture, engine._report)
    coc = np.zeros((height, width, 1), np.float32)
    wanted = group.linked(node)
    if wanted & {"CoC", "Focus"}:
        made.coc(used, coc[..., 0])
    _add(seconds, "filter", started)
    started = time.perf_counter()
    pixels = {group.PICTURE: picture}
    if wanted & {"CoC", "Depth"}:
        zero = np.zeros_like(coc)
        data = (coc, depth[..., None], zero, zero + 1)
        pixels[group.DATA] = np.concatenate(data, -1)
    if "Focus" in wanted:
        pixels[group.FOCUS] = overlay(picture, coc, made.lens.coc_limit_px)
    main_thread.run_or_here(functools.partial(_put, node.node_tree, pixels), PUT_S)
    _add(seconds, "write", started)


def _put(tree, pixels):
    for name, values in pixels.items():
        group.put(tree, name, values[::-1])
