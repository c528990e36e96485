# SPDX-License-Identifier: Apache-2.0
"""Files, comparing, reading the picture and its colours, as an artist does it."""

import os
import time

import numpy
import pytest
from conftest import DISC, FAR, HEIGHT, NEAR, WIDTH, read_exr


@pytest.fixture
def window(view, passes):
    shown = view(passes())
    shown.wait_open()
    return shown


def picture(window, name="shot"):
    return window.look_at_picture(WIDTH, HEIGHT, name)


def press(window, *keys):
    window.move(20, 20)
    window.key(*keys)


def test_save_asks_before_it_replaces(window, tmp_path):
    out = tmp_path / "passes_focus.exr"
    out.write_text("not to be lost")
    press(window, "ctrl+s")
    window.wait_text("said", "save once more")
    assert out.read_text() == "not to be lost"
    press(window, "ctrl+s")
    window.wait_text("saved", "saved")
    assert read_exr(out).shape[:2] == (HEIGHT, WIDTH)
    press(window, "ctrl+p")
    window.wait_text("said", "saved")
    before = (tmp_path / "passes_focus.params").read_text()
    press(window, "ctrl+p")
    window.wait_text("said", "save once more")
    assert (tmp_path / "passes_focus.params").read_text() == before


@pytest.mark.parametrize("name", ["passes.exr", "./passes.exr", "link.exr"])
def test_what_is_shown_is_not_replaced(window, tmp_path, name):
    """Neither at the first nor at the second try: its depth would be lost."""
    (tmp_path / "link.exr").symlink_to("passes.exr")
    before = (tmp_path / "passes.exr").read_bytes()
    window.click_control("File")
    window.type(name)
    for _ in range(2):
        window.key("ctrl+s")
        assert "another name" in window.wait_text("refused", name)
    assert (tmp_path / "passes.exr").read_bytes() == before
    window.click_control("File")
    window.type("typed.exr")
    window.key("ctrl+s")
    window.wait_text("saved", "typed.exr")


def test_a_name_that_is_being_typed_is_the_one(window, tmp_path):
    """Ctrl+S without Enter before it."""
    window.click_control("File")
    window.type("typed.exr")
    window.key("ctrl+s")
    window.wait_text("saved", "typed.exr")
    assert (tmp_path / "typed.exr").exists()


def test_open_from_the_list(window, passes, tmp_path, command_picture):
    """Up and down, Enter; the file is shown, and is a recent one afterwards."""
    other = passes("zz_other.exr", shift=9)
    press(window, "ctrl+shift+o")
    window.wait_text("list")
    window.key("Page_Down", "Page_Down", "Return")
    window.wait_text("loaded", "zz_other.exr")
    window.wait_best()
    assert window.sees(command_picture(other))
    window.quit()
    kept = tmp_path / "state/rackfocus/view.txt"
    files = [f for f in kept.read_text().splitlines() if f.startswith("file ")]
    assert files[0].endswith("zz_other.exr") and files[1].endswith("passes.exr")


def test_a_name_is_typed_into_the_list(window, passes):
    passes("aa_other.exr")
    passes("zz_other.exr")
    press(window, "ctrl+shift+o")
    window.wait_text("list")
    window.type("zq")
    assert window.wait_text("not in list") == "zq"
    time.sleep(1.5)  # a new name begins
    window.type("zz")
    assert window.wait(lambda e: e["event"] == "in list" and e["text"] == "zz")
    window.key("Return")
    window.wait_text("loaded", "zz_other.exr")


@pytest.fixture
def desktop(monkeypatch, tmp_path):
    """Installs a program that stands for a dialog of the desktop; returns what it was
    called with."""

    def install(name, answer, code=0, kind="GNOME"):
        folder = tmp_path / "bin"
        folder.mkdir(exist_ok=True)
        script = folder / name
        script.write_text(
            f"#!/bin/sh\nprintf '%s\\n' \"$@\" > '{tmp_path}/{name}.txt'\n"
            f"echo 'a warning of a library' >&2\necho '{answer}'\nexit {code}\n"
        )
        script.chmod(0o755)
        monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
        monkeypatch.setenv("XDG_CURRENT_DESKTOP", kind)
        return tmp_path / f"{name}.txt"

    return install


@pytest.mark.parametrize("name, kind", [("zenity", "GNOME"), ("kdialog", "KDE")])
def test_open_by_the_dialog_of_the_desktop(
    desktop, view, passes, command_picture, tmp_path, name, kind
):
    other = passes("zz other.exr", shift=9)
    if kind == "KDE":  # both are installed: its own is taken
        desktop("zenity", tmp_path / "wrong.exr")
    called = desktop(name, other, kind=kind)
    window = view(passes())
    window.wait_open()
    press(window, "ctrl+o")
    window.wait_text("loaded", "zz other.exr")
    window.wait_best()
    assert window.sees(command_picture(other))
    assert str(tmp_path) in called.read_text()
    assert not [e for e in window.events() if e["event"] == "list"]


def test_a_dialog_that_is_left_changes_nothing(desktop, view, passes, tmp_path):
    called = desktop("zenity", "", code=1)
    window = view(passes())
    window.wait_open()
    press(window, "ctrl+o")
    window.wait_until(called.exists, "the dialog")
    press(window, "d")
    window.wait_best(mode=1)
    assert not [e for e in window.events() if e["event"] == "list"]
    desktop("zenity", "no display", code=5)  # one that fails: the list takes its place
    window.wait_until(lambda: press(window, "ctrl+o") or has_list(window), "the list")


def has_list(window):
    return [e for e in window.events() if e["event"] == "list"] != []


def test_drop_files(window, passes, command_picture, rackfocus, tmp_path):
    """An EXR is shown, a PNG becomes the reference, parameters are set."""
    other = passes("other file.exr", shift=9)
    window.drop(other)
    window.wait_text("loaded", "other file.exr")
    window.wait_best()
    assert window.sees(command_picture(other))
    png = tmp_path / "reference.png"
    rackfocus("filter", other, "-o", png, "--focus-distance", NEAR)
    window.drop(png)
    window.wait_text("said", "reference")
    press(window, "x")
    window.wait_best(mode=4)
    press(window, "x")
    (tmp_path / "look.params").write_text("focus-distance 5\nblades 6\n")
    window.drop(tmp_path / "look.params")
    window.wait_best(focus=5.0)
    words = window.copied()
    assert words[words.index("--blades") + 1] == "6"
    window.drop(passes("a.exr"), tmp_path / "missing.exr")
    window.wait_text("said", "missing.exr")


def test_what_cannot_be_opened_leaves_the_picture(window, tmp_path):
    (tmp_path / "zz_broken.exr").write_text("nonsense")
    press(window, "ctrl+shift+o")
    window.wait_text("list")
    window.key("Page_Down", "Page_Down", "Return")
    window.wait_text("said", "zz_broken.exr")
    press(window, "d", "d")
    assert window.wait_best(mode=0)["focus"] == FAR


def test_the_window_comes_back_as_it_was_left(view, passes):
    window = view(passes())
    window.wait_open()
    window.resize(900, 640)
    window.wait(lambda e: e["event"] == "layout" and e["window"] == [900, 640])
    window.quit()
    window = view(passes())
    window.wait_open()
    assert window.layout()["window"] == [900, 640]
    window.resize(740, 780)
    window.wait(lambda e: e["event"] == "layout" and e["window"] == [740, 780])
    window.quit()


def test_compare_with_a_reference(window, passes, command_picture, rackfocus, tmp_path):
    """F flips to it, S wipes with it."""
    other = command_picture(passes(), "--focus-distance", str(NEAR))
    reference = tmp_path / "reference.exr"
    assert not numpy.array_equal(picture(window), other)
    options = ["--focus-distance", NEAR, "--type", "float"]
    rackfocus("filter", passes(), "-o", reference, *options)
    window.open_section("Compare")
    window.click_control("Reference")
    window.type(str(reference))
    window.key("Return")
    window.wait_text("said", "reference")
    press(window, "a")
    window.wait_text("said", "with the reference")
    press(window, "f")
    window.wait_shown(filter=False, pinhole=True)
    assert window.sees(other)
    press(window, "f", "s")
    window.wait_shown(split=True, pinhole=False)

    def is_wiped(seen):
        half = WIDTH // 2
        return numpy.array_equal(seen[:, : half - 2], other[:, : half - 2])

    assert is_wiped(window.look_until(is_wiped, lambda: picture(window)))


def test_keep_a_picture_and_compare(window):
    """K keeps what is shown: no difference to itself, one to another focus."""
    press(window, "k")
    window.wait_text("said", "kept as the reference")
    press(window, "x")
    window.wait_best(mode=4)
    assert picture(window).max() == 0
    press(window, "x")
    window.click(*window.on_picture(*DISC))
    window.wait_best(mode=0, focus=NEAR)
    press(window, "x")
    window.wait_best(mode=4)
    seen = window.look_until(
        lambda seen: seen.max() > 100, lambda: picture(window, "difference")
    )
    assert seen.max() > 100


def test_snapshots_of_settings(window):
    press(window, "ctrl+1")
    window.wait_text("said", "kept as 1")
    window.set_number("Focus distance", "5")
    window.wait_best(focus=5.0)
    press(window, "ctrl+2", "shift+1")
    window.wait_best(focus=FAR)
    press(window, "shift+2")
    window.wait_best(focus=5.0)
    press(window, "shift+3")
    window.wait_text("said", "nothing is kept as 3")


def test_false_colours(window):
    """Each px by its stops from middle grey; the disc is 0.8 in red."""
    press(window, "g")
    window.wait_best(mode=5)
    seen = picture(window, "exposure")
    colours = numpy.unique(seen.reshape(-1, 3), axis=0)
    assert len(colours) < 200 and len(colours) > 3


def test_histogram_and_legend_are_drawn(window):
    plain = window.look()

    def differs(seen):
        return (seen[:250, :250] != plain[:250, :250]).any(axis=-1).mean() > 0.3

    press(window, "h")
    assert differs(window.look_until(differs, lambda: window.look("scopes")))
    press(window, "h", "d")
    window.wait_best(mode=1)

    def has_legend(seen):
        at = window.layout()["area"]
        bottom = seen[at[3] - 60 : at[3] - 10, 10:200]
        return len(numpy.unique(bottom.reshape(-1, 3), axis=0)) > 20

    assert has_legend(window.look_until(has_legend, lambda: window.look("legend")))


def test_what_lies_below_the_mouse(window, passes, rackfocus, tmp_path):
    """RGB of the filtered picture, depth, blur and the side of the focus."""
    out = tmp_path / "filtered.exr"
    rackfocus("filter", passes(), "-o", out, "--type", "float")
    window.move(*window.on_picture(*DISC))
    text = window.wait_text("place", "RGB")
    x, y = (int(v) for v in text[1 : text.index(")")].split(","))
    assert abs(x - DISC[0]) <= 1 and abs(y - DISC[1]) <= 1
    rgb = read_exr(out)[y, x]
    assert f"RGB {rgb[0]:.3f} {rgb[1]:.3f} {rgb[2]:.3f}" in text
    assert "depth 3" in text and "before" in text


def test_the_mark_of_the_focus(window):
    x, y = window.on_picture(*DISC)
    before = window.look()
    window.click(x, y)
    window.wait_best(focus=NEAR)

    def is_marked(seen):
        arm = seen[round(y), round(x) - 14 : round(x) - 8].astype(int)
        return (abs(arm - (255, 193, 77)).max(axis=-1) < 3).any()

    assert not is_marked(before)
    assert is_marked(window.look("mark"))
    # It goes, so that it hides nothing.
    assert not is_marked(window.look_until(lambda seen: not is_marked(seen)))


def test_view_transforms(window, passes, command_picture):
    """Others than sRGB change what is seen, and not what is saved."""
    if "Colours" in window.layout()["off"]:
        pytest.skip("built without OpenColorIO")
    plain = picture(window)
    window.choose("Colours", -1)  # of ACES; Blender's first is sRGB, too
    window.move(20, 20)

    def differs(seen):
        return (seen != plain).any(axis=-1).mean() > 0.5

    assert differs(window.look_until(differs, lambda: picture(window, "ocio")))
    press(window, "Escape", "ctrl+s")
    window.wait_text("saved", "saved")
    window.choose("Colours", 0)
    window.move(20, 20)
    assert window.sees(command_picture(passes()))


def test_a_bad_configuration_is_said(view, passes, tmp_path):
    (tmp_path / "bad.ocio").write_text("nonsense")
    window = view(passes(), "--ocio", tmp_path / "bad.ocio")
    window.wait_open()
    assert "bad.ocio" in window.printed()
