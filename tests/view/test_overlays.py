# SPDX-License-Identifier: Apache-2.0
"""What lies above the picture: the graphs of the circle of confusion."""

import re

import numpy
import pytest


def diameter(distance, focus=3.0, f_stop=1.4, focal=0.085, sensor=0.036, width=480):
    """|a (s (1/f - 1/d) - 1)|, Yu 2004, of the demo's lens in px."""
    screen = focal * focus / (focus - focal)
    return abs(
        focal / f_stop * width / sensor * (screen * (1 / focal - 1 / distance) - 1)
    )


def graphs(window):
    """(distance, [a, s, f, d as marked], diameter in px)"""
    text = window.wait_text("graphs")
    numbers = [float(n) for n in re.findall(r"[\d.]+(?:e[+-]?\d+)?", text)]
    return numbers[0], numbers[1:5], numbers[5]


def test_graphs_follow_mouse_and_lens(view):
    window = view("--demo", "--demo-width", 480)
    window.wait_open()
    before = window.look("graphs_off")
    window.move(*window.on_picture(240 + 117, 135 - 15))  # the far picture
    window.key("y")
    distance, now, c = graphs(window)
    assert distance == pytest.approx(6, abs=0.01)
    assert c == pytest.approx(diameter(6), rel=1e-3)
    assert now == pytest.approx([85 / 1.4, 87.4786, 85, 6], rel=1e-4)
    window.look_until(lambda seen: (seen != before).any(axis=-1).mean() > 0.1)
    window.move(*window.on_picture(127, 157))  # the near one
    distance, now, c = graphs(window)
    assert distance == pytest.approx(2, abs=0.01)
    window.set_number("f-stop", "2.8")
    *_, c = graphs(window)
    while c != pytest.approx(diameter(2, f_stop=2.8), rel=1e-3):
        *_, c = graphs(window)  # the mouse went over the picture on its way
    curve = (window.look("graphs") == (0x7F, 0xB4, 0xFF)).all(axis=-1)
    assert curve.sum() > 4 * 100


def test_graphs_and_scopes_share_a_place(view):
    """H takes the place of Y and the other way round; both keys again: neither."""
    window = view("--demo", "--demo-width", 480)
    window.wait_open()
    plain = window.look("overlay_none")
    window.move(2, 2)
    window.key("y", "h", "y")
    window.wait_text("graphs")
    window.key("y")
    seen = window.look_until(lambda seen: numpy.array_equal(seen, plain))
    assert numpy.array_equal(seen, plain)


def test_stages_of_the_thesis(view, passes, command_picture):
    """The mip chain is a choice of the method that has one; box says that it has none."""
    path = passes()
    window = view(path, "--method", "mipmap")
    window.wait_open()
    window.choose("Stage", 1)
    window.wait_best(method="mipmap")
    chain = command_picture(path, "--method", "mipmap", "--stage", "levels")
    assert window.sees(chain, "stage_levels")
    assert (chain[100:, 240:] == 0).all() and chain[:100, :160].mean() > 30
    window.choose("Method", 2)
    assert "no levels of detail" in window.wait_text("refused")


def test_no_graphs_without_millimetres(view, passes):
    window = view(passes(), "--projection", "orthographic")
    window.wait_open()
    before = window.look("graphs_none_off")
    window.key("y")
    seen = window.look_until(lambda seen: (seen != before).any())
    assert (seen != before).any()
    assert not [e for e in window.events() if e["event"] == "graphs"]
