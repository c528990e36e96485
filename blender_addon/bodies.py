# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid bodies: only the scene that they belong to moves them.

The filter scene has none. A camera whose focus object is one, or hangs on one, is focused
where that stands in its own scene, as the last render or the refocus found it.
A copy of the scene has those that are baked; others stand there where they started.
"""

from . import camera_objects, lens

_distances = {}  # scene name: {full name of a camera object: scene units}


def are_in(scene):
    """Does a scene move rigid bodies?"""
    world = scene.rigidbody_world
    bodies = world.collection if world is not None and world.enabled else None
    return bodies is not None and len(bodies.all_objects) > 0


def why_one_view(scene):
    """Why no copy of a scene may render, in the artist's words; "" where one may."""
    if not are_in(scene) or scene.rigidbody_world.point_cache.is_baked:
        return ""
    return (
        "Rigid bodies that are not baked are where they started in any other view: "
        "one view is rendered. Press Scene > Rigid Body World > Cache > Bake"
    )


def measure(scene, depsgraph=None):
    """Notes how far the focus objects of a scene's cameras are, where it moves bodies.

    depsgraph: one that its render has evaluated; without, as the artist's scene stands.
    """
    _distances.pop(scene.name, None)
    if not are_in(scene):
        return
    found = _distances[scene.name] = {}
    for camera in camera_objects.cameras_of(scene):
        seen = camera if depsgraph is None else camera.evaluated_get(depsgraph)
        is_there = depsgraph is None or seen.is_evaluated
        if is_there and seen.data.dof.focus_object is not None:
            found[camera.name_full] = lens.focus_distance(seen)


def distances_of(scene):
    """{full name of a camera object: distance of its focus object}, for lens.known()."""
    return _distances.get(scene.name, {})


def forget():
    """Another file is open."""
    _distances.clear()
