# SPDX-License-Identifier: GPL-3.0-or-later
"""Views of a camera that its parent shears, which EEVEE cannot render before 4.2.

A parent that is scaled unevenly and turned makes the camera's axes askew. Where its shift
is negative too, as that of half of the views is, EEVEE takes what the camera sees for
outside of the picture, without Rack Focus too: views without a thing in them, and with
4 views 25.0 dB where one has 36.8.
"""

from . import compat

# Cosine between two axes: things go from 0.037 on, at 0.019 all are there (3.4).
MOST_SHEAR = 0.01


def why_one_view(scene, camera):
    """Why a frame of a camera has one view, in the artist's words; "" where it need not."""
    is_eevee = scene.render.engine.startswith("BLENDER_EEVEE")
    if not (is_eevee and compat.EEVEE_LOSES_THINGS and camera.data.type == "PERSP"):
        return ""
    x, y, z = (column.normalized() for column in camera.matrix_world.to_3x3().col)
    if max(abs(x @ y), abs(x @ z), abs(y @ z)) < MOST_SHEAR:
        return ""
    return (
        f"a parent with uneven scale shears the camera “{camera.name}”, and EEVEE loses "
        "things in views of such: one view is rendered. Apply the scale of the parent "
        "(Object > Apply > Scale)"
    )
