# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that run inside Blender, and what a script of them is called with.

    SCRIPT DIST OUT [CHECK ...]    (after -- where Blender is a program)

DIST has the zips of the add-on, OUT receives the files that the tests look at.
"""

import contextlib
import io
import json
import sys
from pathlib import Path

import bpy
import common
from common import addon, render, result, rgba

DIST, OUT = (Path(a) for a in sys.argv[sys.argv.index("--") + 1 :][:2])
BASE = OUT / "base.blend"


class Checks(dict):
    """{name: function} of checks, each of which starts with the base file.

    prepare: called before each, with the file open.
    """

    def __init__(self, prepare=lambda: None):
        self.prepare = prepare

    def __call__(self, function):
        """Decorator: registers a check."""

        def run():
            bpy.ops.wm.open_mainfile(filepath=str(BASE))
            self.prepare()
            function()

        self[function.__name__] = run
        return function


def shot(scene, name):
    """(height, width, 4) of a render."""
    return rgba(render(scene, OUT / name))


def update():
    """What Blender does between the steps of a user."""
    bpy.context.view_layer.update()


def tree_with_output(scene):
    """(tree, a Render Layers node, the socket of the picture) of a scene."""
    tree, _ = addon("compat").start_compositor(scene)
    layers = next(n for n in tree.nodes if n.type == "R_LAYERS")
    return tree, layers, addon("compat").output_socket(tree)


@contextlib.contextmanager
def heard():
    """What the console is told meanwhile, an io.StringIO."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        yield said


def key_focus(data, distances):
    """Keyframes of a camera's focus distance, {frame: scene units}."""
    for frame, distance in distances.items():
        data.dof.focus_distance = distance
        data.dof.keyframe_insert("focus_distance", frame=frame)


def refocused(scene, name):
    """The picture after a refocus."""
    assert bpy.ops.rack_focus.refocus() == {"FINISHED"}
    return result(scene, OUT / name)


def show_slot(number):
    """Chooses a slot of the Render Result in the Image Editor, and returns all."""
    image = next(i for i in bpy.data.images if i.type == "RENDER_RESULT")
    while len(image.render_slots) <= number:
        image.render_slots.new()
    image.render_slots.active_index = number
    return image.render_slots


def while_it_renders(scene, task, where="render_pre"):
    """The picture of a render in the middle of which task() is done.

    where: the list of handlers with which Blender calls it.
    """
    begun, handlers = [], getattr(bpy.app.handlers, where)

    def once(*_):
        if not begun:
            begun.append(True)
            task()

    handlers.append(once)
    try:
        return shot(scene, "a.exr")
    finally:
        handlers.remove(once)


def run(checks, name, finish=lambda report: None):
    """Installs the add-on, runs all checks or those named, and leaves Blender.

    checks: {name: function}; name: of the file in OUT that receives {check: "" or what
    went wrong}; finish: called at the end with a function that adds to it.
    """
    names = sys.argv[sys.argv.index("--") + 3 :] or list(checks)
    results = {}

    def report(check, problem):
        results[check] = problem
        print("CHECK", check, problem or "ok", flush=True)
        (OUT / name).write_text(json.dumps(results, indent=1))

    common.install(DIST)
    common.make_base(BASE)
    common.run(checks, names, report)
    finish(report)
    common.leave()
