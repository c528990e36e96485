# SPDX-License-Identifier: Apache-2.0
"""The controls tell the truth: tips, what is off, errors at the field, undo, layout."""

import os
import subprocess

import numpy
import plainexr
import pytest
from conftest import FAR, Display


@pytest.fixture
def window(view, passes):
    shown = view(passes())
    shown.wait_open()
    return shown


def flat(tmp_path, attributes=None):
    """A ramp with depth; without attributes no camera."""
    y, x = numpy.mgrid[0:120, 0:160].astype(numpy.float32)
    channels = {c: (x / 160).astype(numpy.float32) for c in "RGB"}
    channels["Z"] = (2 + y / 12).astype(numpy.float32)
    return plainexr.write(tmp_path / "flat.exr", channels, attributes or {})


def test_tip_after_a_rest(window):
    """The text of the parameter table, its option, its default."""
    window.move(*window.control("Blades"))
    tip = window.wait_text("tip", "Blades of a polygonal")
    assert "--blades" in tip and "default 0" in tip
    window.move(20, 20)
    window.wait(lambda e: e["event"] == "tip" and e["text"] == "", "no tip")


def test_what_is_not_read_is_off_and_says_why(window):
    """Mouse and keyboard leave it alone; the tip has the reason."""
    assert "Rotation" in window.layout()["off"]  # there are no blades
    window.move(*window.control("Rotation"))
    assert "3 blades" in window.wait_text("tip", "Without effect")
    before = window.events()
    window.click_control("Rotation")
    window.type("20")
    window.key("Return")
    window.set_number("Blades", "5")
    window.wait(lambda e: e["event"] == "layout" and "Rotation" not in e["off"], "on")
    assert not [e for e in window.events()[len(before) :] if "error" in e["event"]]
    words = window.copied()
    assert "--blades" in words and "--blade-rotation" not in words


def test_expressions(window):
    for text, focus in (("2*3", 6.0), ("1/4 + 2", 2.25), ("0.4 m", 4.0)):
        window.set_number("Focus distance", text)
        window.wait_best(focus=focus)  # ten units a metre
    window.set_number("Focus distance", "inf")
    window.wait_best(focus=1e9)


@pytest.mark.parametrize(
    "text, part", [("abc", "abc"), ("1e99", "from"), ("-3", "from"), ("2*", "missing")]
)
def test_errors_at_the_field(window, text, part):
    """Nothing is ignored or cut off in silence."""
    window.set_number("f-stop", text)
    assert part in window.wait_text("field error", part)
    window.key("Escape")
    window.wait(lambda e: e["event"] == "tip", "no error")
    assert "--f-stop" not in window.copied()


def test_what_cannot_be_keeps_nobody_from_quitting(window):
    """Other commands wait until it is mended: they would be about what was typed."""
    window.set_number("Blades", "40")
    assert "from 0 to 16 is possible" == window.wait_text("field error")
    window.quit()


def test_what_makes_no_lens_is_said_at_the_field(window):
    """Yu's lens cannot focus inside its focal length."""
    window.choose("Optics", 2)
    window.wait_best()
    window.set_number("Focus distance", "0.3")
    assert "focal length" in window.wait_text("field error", "focal")


def test_double_click_resets(window):
    window.set_number("Focus distance", "5")
    window.wait_best(focus=5.0)
    window.double_click("Focus distance")
    window.wait_best(focus=FAR)
    assert "--focus-distance" not in window.copied()


def test_undo_and_redo(window):
    """A drag is one step; typed and clicked ones are, too."""
    window.set_number("Focus distance", "5")
    window.wait_best(focus=5.0)
    x, y = window.control("f-stop")
    window.drag([(x - 4 * i, y) for i in range(6)])
    dragged = [e for e in window.events() if e["event"] == "shown"][-1]["f_stop"]
    assert dragged != 2.0
    window.move(20, 20)
    window.key("ctrl+z")
    window.wait_best(f_stop=2.0, focus=5.0)
    window.key("ctrl+z")
    window.wait_best(f_stop=2.0, focus=FAR)
    window.key("ctrl+z")
    window.wait_text("said", "nothing to undo")
    window.key("ctrl+y")
    window.wait_best(f_stop=2.0, focus=5.0)
    window.key("ctrl+shift+z")
    window.wait_best(f_stop=dragged, focus=5.0)


def test_guesses_are_marked(view, tmp_path):
    """A file without a camera: the tip says that the default is a guess."""
    window = view(flat(tmp_path))
    window.wait_open()
    window.move(*window.control("Focal length"))
    assert "guess" in window.wait_text("tip", "Focal length")
    window.set_number("Focal length", "85mm")
    window.move(20, 20)
    window.move(*window.control("Focal length"))
    assert "guess" not in window.wait_text("tip", "From you")


def test_a_lens_without_millimetres(view, tmp_path):
    """As POV-Ray's: f-stop and focal length are off, and no value is invented."""
    about = {"lensRadius": 0.05, "focusDistance": 4.0, "focalLengthPx": 200.0}
    about = {f"rackfocus:{k}": v for k, v in about.items()}
    window = view(flat(tmp_path, about))
    shown = window.wait_open()
    assert shown["f_stop"] is None and shown["screen"] is None
    assert {"f-stop", "Focal length", "Screen position"} <= set(window.layout()["off"])
    window.move(*window.control("f-stop"))
    assert "set the lens radius" in window.wait_text("tip", "Without effect")
    window.set_number("Lens radius", "0.1")
    assert window.wait_best()["f_stop"] is None
    # A radius that was typed wakes them no more than that of the file.
    assert {"f-stop", "Focal length"} <= set(window.layout()["off"])


def test_all_parameters_are_there(window, rackfocus):
    """Every row of the table has a control in some section."""
    for name in ("Character", "Focus surface", "Camera", "Depth", "Not read"):
        window.open_section(name)
    controls = " ".join(window.layout()["controls"])
    for label in ("Swirl", "Tilt x", "Sensor width", "Depth near", "Copies"):
        assert label in controls
    count = len([c for c in window.layout()["controls"]])
    n_params = sum(len(line) > 0 for line in params_of(rackfocus))
    assert count > n_params


def params_of(rackfocus):
    """Keys of the parameters, from the list of options."""
    text = rackfocus("filter", "--help").stdout
    heads = ("Lens", "Aperture", "Depth", "Method")
    keys, is_in = [], False
    for line in text.splitlines():
        if line and not line.startswith(" "):
            is_in = line.strip(":").capitalize() in heads
        if is_in and line.strip().startswith("--"):
            keys.append(line.split()[0])
    return keys


def test_a_look_sets_its_parameters(window):
    window.open_section("Character")
    window.choose("Look", 5)
    window.wait_text("said", "bubble")
    words = window.copied()
    assert abs(float(words[words.index("--spherical") + 1])) == 3


def test_looks_are_walked_by_keys(window):
    """Each takes the place of the one before; one step back brings that again."""
    window.open_section("Character")
    window.click_control("Look")  # opens the list
    window.key("Down")
    assert window.wait_text("said", "look ") == "look vintage is set"
    window.key("Down")
    assert window.wait_text("said", "look ") == "look anamorphic is set"
    window.key("Return")
    window.wait_until(lambda: window.layout()["list"][3] == 0, "the list to close")
    words = window.copied()
    assert "--swirl" not in words and "--aperture-ratio" in words
    window.key("ctrl+z")
    words = window.copied()
    assert "--swirl" in words and "--aperture-ratio" not in words
    window.set_number("Swirl", "0.2")
    window.choose("Look", 6)
    said = window.wait_text("said", "look miniature")
    assert said == "look miniature is set; swirl stays as it was set"
    window.choose("Look", 0)
    assert (
        window.wait_text("said", "no look")
        == "no look is set; swirl stays as it was set"
    )
    words = window.copied()
    assert "--swirl" in words and "--tilt-y" not in words and "--cat-eye" not in words


def test_the_tip_says_whose_the_value_is(view, passes):
    window = view(passes(), "--cat-eye", "0.1")
    window.wait_open()
    window.open_section("Character")
    window.set_number("Swirl", "0.2")

    def tip(label, whose):
        """The one that shows before the value was set is not waited for."""
        window.move(*window.control(label))
        return window.wait_text("tip", whose)

    assert "--swirl" in tip("Swirl", "From you.")
    assert "--cat-eye," in tip("Cat's eye", "From the command line.")
    assert "--f-stop" in tip("f-stop", "From the header rackfocus:fStop.")
    window.choose("Look", 1)
    assert "--astigmatism" in tip("Astigmatism", "From the look vintage.")


def test_paste_into_a_number(window):
    """What was copied from one field is pasted into another."""
    window.set_number("Focus distance", "7.5")
    window.wait_best(focus=7.5)
    window.click_control("Focus distance")
    window.key("ctrl+a", "ctrl+c", "Escape")
    window.click_control("Lens radius")
    window.key("ctrl+v", "Return")
    window.wait_best(focus=7.5)
    words = window.copied()
    assert words[words.index("--lens-radius") + 1] == "7.5"


@pytest.mark.parametrize(
    "size, scale",
    [((800, 600), 1), ((800, 600), 2), ((3840, 2160), 1), ((3840, 2160), 2)],
)
def test_layout_at_every_size(binary, passes, tmp_path, size, scale):
    """Panel, picture and every control are reached; a large screen magnifies."""
    from conftest import Window

    display = Display(size)
    window = Window(binary, display, tmp_path, passes(), "--scale", scale)
    try:
        window.wait_open()
        window.tool("windowmove", window.id(), 0, 0)
        window.resize(*size)
        window.wait(lambda e: e["event"] == "layout" and e["window"] == list(size))
        window.place()
        left, top, wide, tall = window.layout()["panel"]
        assert wide >= 14 * 14 * scale and left + wide == size[0]
        assert window.layout()["area"][2] >= size[0] * 0.4
        if size[0] > 3000:
            assert window.layout()["scale"] >= 8
        x, y = window.control("Save picture")
        assert left <= x < left + wide and top <= y < top + tall
        assert left <= window.control("Focus distance")[0] < left + wide
    finally:
        window.close()
        display.close()


def test_full_screen(window):
    """Without a window manager the window itself grows."""
    before = window.layout()["window"]
    window.move(20, 20)
    window.key("F11")
    window.wait(lambda e: e["event"] == "layout" and e["window"] == [1280, 900], "full")
    window.key("F11")
    window.wait(lambda e: e["event"] == "layout" and e["window"] == before, "back")


def test_help_scrolls(binary, passes, tmp_path):
    """At 800x600 the last line comes into sight with Page Down."""
    from conftest import Window

    display = Display((800, 600))
    window = Window(binary, display, tmp_path, passes())
    try:
        window.wait_open()
        window.key("F1")
        first = window.look_until(lambda seen: seen[40:60, 20:200].max() > 200)
        window.key("Page_Down", "Page_Down", "Page_Down", "Page_Down")

        def has_moved(seen):
            return (seen[40:500, 20:300] != first[40:500, 20:300]).mean() > 0.02

        assert has_moved(window.look_until(has_moved))
    finally:
        window.close()
        display.close()


def test_an_empty_video_driver_is_none(binary, passes):
    """SDL_VIDEODRIVER set but empty: no window that nobody sees."""
    about = {k: v for k, v in os.environ.items() if "DISPLAY" not in k}
    done = subprocess.run(
        [binary, "view", str(passes())],
        env={**about, "SDL_VIDEODRIVER": ""},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode != 0 and "no display" in done.stderr
