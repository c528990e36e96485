# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file that a render writes lacks where copies of the scene are rendered.

Blender writes an OpenEXR MultiLayer file from the result of the scene itself, which has
nothing but the composite then: its view layers are black, and their passes are missing.
Box and console say so. File Output nodes get the passes of one of the views.
"""

from . import views

LINES = (
    "With several views or Supersample the OpenEXR MultiLayer file",
    "has the picture alone (Composite), and black view layers:",
    "save passes with File Output nodes, or take one view",
)


def describe(scene):
    """Lines for the panel on what the scene's own file lacks."""
    is_multilayer = scene.render.image_settings.file_format == "OPEN_EXR_MULTILAYER"
    return list(LINES) if is_multilayer and views.renders_copies(scene) else []
