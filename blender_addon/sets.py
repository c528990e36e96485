# SPDX-License-Identifier: GPL-3.0-or-later
"""Background sets: scenes whose objects a render of another scene shows too."""


def scenes_of(scene):
    """A scene, and its background set, with the set of that, and so on."""
    found = [scene]
    for one in found:
        behind = one.background_set
        if behind is not None and behind not in found:
            found.append(behind)
    return found


def objects_of(scene):
    """All objects of a scene and its background sets."""
    return [item for one in scenes_of(scene) for item in one.objects]


def layers_of(scene):
    """View layers whose objects a render shows; of a set Blender takes the first one."""
    used = [layer for layer in scene.view_layers if layer.use]
    return [*used, *(one.view_layers[0] for one in scenes_of(scene)[1:])]
