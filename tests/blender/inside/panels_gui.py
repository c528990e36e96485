# SPDX-License-Identifier: GPL-3.0-or-later
"""A session with a window that shows every panel of the add-on in its states.

See stepping.py; FOUND["shown"] is {name: (left, right, top, bottom) of it in px}.
"""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import artist_gui  # noqa: E402
import common  # noqa: E402
import stepping  # noqa: E402
from artist_gui import into_tab, open_parts, render  # noqa: E402
from common import addon  # noqa: E402
from stepping import (  # noqa: E402
    DIST,
    FOUND,
    OUT,
    SCROLL,
    area_of,
    hands,
    override,
    screenshot,
    window,
)

PART = 0.4  # of the 3D view's width, for the panels
WIDTH = 440  # px of what pops up


def left(area):
    """Where an area begins."""
    return area.x


def shown(name, area, region_type="WINDOW"):
    """A screenshot of a region."""
    area.tag_redraw()
    yield 0.5
    yield from screenshot(name)
    region = next(r for r in area.regions if r.type == region_type)
    top = window().height - region.y - region.height
    box = (region.x, region.x + region.width, top, top + region.height)
    FOUND["shown"][name] = box


def to_the_end(area):
    """Scrolls a panel down."""
    middle = area.x + area.width // 2, area.y + area.height // 2
    yield from hands("mousemove", *middle, "click", *SCROLL, "5")
    yield 0.4


def in_camera(area, scene):
    """The box in the camera's properties."""
    settings = scene.camera.data.rack_focus
    area.spaces.active.context = "DATA"
    settings.enabled = False
    yield 0.3
    yield from to_the_end(area)
    yield from shown("off", area)
    settings.enabled = True
    yield from to_the_end(area)
    yield from shown("final", area)
    settings.views, settings.supersample = 8, 2
    yield from to_the_end(area)
    yield from shown("views", area)
    settings.views, settings.supersample = 1, 0
    scene.render.use_compositing = False
    yield from to_the_end(area)
    yield from shown("compositing_off", area)
    scene.render.use_compositing = True
    scene.camera.data.dof.focus_distance = 1
    scene.rack_focus.is_automatic = False
    yield from to_the_end(area)
    yield from shown("out_of_date", area)
    yield from another_camera(area, scene)
    open_parts()
    settings.quality, settings.method = "custom", "scatter"
    yield from to_the_end(area)
    yield from shown("scatter", area)
    settings.quality, settings.method = "normal", "layered"
    yield from to_the_end(area)
    yield from shown("look", area)


def another_camera(area, scene):
    """The box of a camera that the scene does not render."""
    data = bpy.data.cameras.new("Other")
    other = bpy.data.objects.new("Other", data)
    scene.collection.objects.link(other)
    data.rack_focus.enabled = True
    area.spaces.active.pin_id = data
    yield from to_the_end(area)
    yield from shown("not_active", area)
    area.spaces.active.use_pin_id = False
    bpy.data.cameras.remove(data)
    yield 0.3


def in_object(area, scene):
    """Keep Sharp."""
    found = next(o for o in scene.objects if o.type == "MESH")
    bpy.context.view_layer.objects.active = found
    area.spaces.active.context = "OBJECT"
    panel = addon("ui").ObjectPanel
    bpy.utils.unregister_class(panel)
    panel.bl_options, panel.bl_order = set(), -1
    bpy.utils.register_class(panel)
    yield 0.4
    middle = area.x + area.width // 2, area.y + area.height // 2
    yield from hands("mousemove", *middle, "click", *SCROLL, "4")
    yield from shown("keep_sharp", area)
    bpy.context.view_layer.objects.active = scene.camera


def in_preferences(area):
    """The add-on's own."""
    area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Rack Focus"
    yield 0.4
    with override(area):
        bpy.ops.preferences.addon_expand(module=common.MODULE)
    yield 0.4
    yield from shown("preferences", area)


def in_image(area):
    """The sidebar beside the picture, with each overlay."""
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = bpy.data.images["Render Result"]
    into_tab("ImagePanel", "Tool")
    area.spaces.active.show_region_ui = True
    yield 0.4
    yield from shown("sidebar", area, "UI")
    for show in ("focus", "coc"):
        bpy.ops.rack_focus.show("INVOKE_DEFAULT", show=show)
        yield 0.3
        yield from stepping.until(artist_gui.is_quiet, show)
        yield from shown(show, area)


def popped_up(area, panel, name):
    """A panel that Blender opens at the mouse."""
    x, y = area.x + 60, 90
    yield from hands("mousemove", x, y)
    yield 0.3
    with override(area):
        bpy.ops.wm.call_panel("INVOKE_DEFAULT", name=panel)
    yield 0.6
    yield from screenshot(name)
    FOUND["shown"][name] = (area.x, area.x + WIDTH, 30, 500)
    yield from hands("key", "Escape")
    yield 0.6


def steps():
    """The session; yields the seconds to wait."""
    bpy.context.preferences.view.ui_scale = 0.9
    bpy.context.preferences.view.render_display_type = "NONE"
    common.install(DIST)
    common.make_base(OUT / "base.blend")
    FOUND["shown"] = {}
    scene = bpy.context.scene
    scene.cycles.samples = 8
    scene.render.resolution_x, scene.render.resolution_y = 360, 240
    scene.camera.data.dof.use_dof = scene.camera.data.rack_focus.enabled = True
    yield 0.5
    with override(area_of("VIEW_3D")):
        bpy.context.view_layer.objects.active = scene.camera
    yield from render()
    large = area_of("VIEW_3D")
    with override(large):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=PART)
    yield 0.4
    large = min((a for a in window().screen.areas if a.type == "VIEW_3D"), key=left)
    large.type = "PROPERTIES"
    yield 0.5
    yield from in_camera(large, scene)
    yield from in_object(large, scene)
    yield from in_preferences(large)
    yield from in_image(large)
    beside = area_of("VIEW_3D")
    yield from popped_up(beside, "VIEW3D_PT_overlay", "in_3d_views")
    yield from popped_up(beside, "VIEW3D_PT_rack_focus_presets", "looks")


if __name__ == "__main__":
    stepping.play(steps())
