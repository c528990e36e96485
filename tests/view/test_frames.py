# SPDX-License-Identifier: Apache-2.0
"""Sequences: the slider, playing from memory, key frames for the command."""

import time

import numpy
import pytest
from conftest import FAR, HEIGHT, WIDTH, read_exr, read_png

N_FRAMES = 4


@pytest.fixture
def frames(passes, tmp_path):
    """A folder of frames whose wall moves."""
    folder = tmp_path / "shots"
    folder.mkdir()
    for i in range(N_FRAMES):
        passes(f"shots/passes.{i + 11:04d}.exr", shift=3.0 * i)
    return folder


@pytest.fixture
def window(view, frames):
    shown = view(frames)
    shown.wait_open()
    return shown


def picture(window):
    return window.look_at_picture(WIDTH, HEIGHT)


def test_the_slider_goes_to_a_frame(window, frames, command_picture):
    """Typed and dragged; a frame that is named while another is read comes after it."""
    window.set_number("Frame", "3")
    window.wait_text("loaded", "0013")
    window.wait_best()
    assert window.sees(command_picture(frames / "passes.0013.exr"))
    x, y, width, height = window.box("Frame")
    window.press(x + width / 2, y + height / 2)
    for at in (0.6, 0.3, 0.99):
        window.move(x + width * at, y + height / 2)
    window.release()
    window.wait_text("loaded", "0014")
    window.set_number("Frame", "9")
    assert "from 1 to 4" in window.wait_text("field error")


def test_a_damaged_frame_is_marked(view, frames):
    """As long as the slider stands at it, over the picture of another one."""
    bad = frames / "passes.0012.exr"
    bad.write_bytes(bad.read_bytes()[:2000])
    window = view(frames)
    window.wait_open()
    plain = window.look()
    window.move(20, 20)
    window.key("Next")
    said = window.wait_text("unshown", bad.name)
    assert "is not shown" in said and "this is still passes.0011.exr" in said
    marked = window.look_until(lambda seen: (seen[:40] != plain[:40]).any())
    assert (marked[:40] != plain[:40]).any()
    window.key("Next")  # a good one
    window.wait(lambda e: e["event"] == "unshown" and e["text"] == "", "no mark")


def test_playing(window, frames, command_picture):
    """All frames in their order, again and again; from memory at the given speed."""
    window.set_number("Frames a second", "10")
    window.move(20, 20)
    window.key("l")
    played = [window.wait_text("frame") for _ in range(3 * N_FRAMES)]
    numbers = [int(text.split()[0]) for text in played]
    order = [11 + (numbers[0] - 11 + i) % N_FRAMES for i in range(3 * N_FRAMES)]
    assert numbers == order
    loads = len([e for e in window.events() if e["event"] == "loaded"])
    for _ in range(N_FRAMES):
        window.wait_text("frame")
    assert len([e for e in window.events() if e["event"] == "loaded"]) == loads
    window.key("l")
    time.sleep(0.5)
    last = [e for e in window.events() if e["event"] == "frame"][-1]
    number = int(last["text"].split()[0])
    assert window.sees(command_picture(frames / f"passes.{number:04d}.exr"))


def test_a_change_while_playing_is_played(window, frames, command_picture):
    """What was kept with other settings is not shown any more."""
    window.set_number("Frames a second", "20")
    window.move(20, 20)
    window.key("l")
    for _ in range(N_FRAMES + 1):
        window.wait_text("frame")
    window.set_number("f-stop", "1.2")
    window.wait_best(f_stop=1.2)
    for _ in range(2 * N_FRAMES):
        window.wait_text("frame")
    window.move(20, 20)
    window.key("l")
    time.sleep(0.5)
    last = [e for e in window.events() if e["event"] == "frame"][-1]
    number = int(last["text"].split()[0])
    want = command_picture(frames / f"passes.{number:04d}.exr", "--f-stop", "1.2")
    assert window.sees(want)


def play_from_memory(window):
    """Plays until frames are shown that are not the one which was read last."""
    window.set_number("Frames a second", "20")
    window.move(20, 20)
    window.key("l")
    for _ in range(2 * N_FRAMES):
        window.wait_text("frame", "played")


def frame_shown(window):
    """The number of the frame at which playing has stopped."""
    played = [e["text"] for e in window.events() if e["event"] == "frame"]
    return int(played[-1].split()[0])


def test_the_frame_that_is_played_is_saved(window, frames, rackfocus, tmp_path):
    """Not the one that was read last; key and command line are that frame's, too."""
    for _ in range(2):  # one of both is not the one that was read last
        play_from_memory(window)
        window.key("ctrl+s")
        name = window.wait_text("saved", "saved").split()[-1]
        number = frame_shown(window)
        assert f"passes.{number:04d}" in name
        out = tmp_path / "out.exr"
        rackfocus("filter", frames / f"passes.{number:04d}.exr", "-o", out)
        assert numpy.array_equal(read_exr(tmp_path / name), read_exr(out))
        (tmp_path / name).unlink()
        play_from_memory(window)
        copied = window.copied()
        assert f"passes.{frame_shown(window):04d}.exr" in copied[2]
        play_from_memory(window)
        window.key("m")
        said = window.wait_text("said", "key at frame")
        assert f"frame {frame_shown(window)}:" in said


def test_what_needs_the_pixels_waits_for_the_frame(window):
    said = ""
    for _ in range(9):  # it may be the one that was read last
        play_from_memory(window)
        window.key("k")
        said = window.wait_text("said")
        if "playing stops" in said:
            break
        window.key("l")
    number = frame_shown(window)
    assert f"at frame {number}," in said
    window.wait_text("loaded", f"{number:04d}")


def test_a_frame_played_that_is_gone(window, frames, command_picture):
    """The window shows what it says it shows."""
    names = sorted(frames.iterdir())
    kept = {path.name: command_picture(path) for path in names}
    unshown = []
    for _ in range(9):  # it may be the one that was read last
        play_from_memory(window)
        for path in names:
            path.rename(f"{path}.away")
        window.key("l")
        window.copied()  # after all that was done before
        time.sleep(0.5)
        told = [e["text"] for e in window.events() if e["event"] == "unshown"]
        unshown = [text for text in told if text]
        for path in names:
            path.with_name(f"{path.name}.away").rename(path)
        if unshown:
            break
    assert f"passes.{frame_shown(window):04d}.exr is not shown" in unshown[0]
    assert window.sees(kept[unshown[0].split()[-1]])


def test_key_frames(window, frames, rackfocus, tmp_path):
    """What the window shows between two keys is what the command makes of their file."""
    window.set_number("Focus distance", "3")
    window.wait_best(focus=3.0)
    window.move(20, 20)
    window.key("m")
    window.wait_text("said", "key at frame 11")
    window.set_number("Frame", "4")
    window.wait_text("loaded", "0014")
    window.wait_best()
    window.set_number("Focus distance", str(FAR))
    window.wait_best(focus=FAR)
    window.move(20, 20)
    window.key("m")
    window.wait_text("said", "key at frame 14")
    window.click_control("Save keys")
    window.wait_text("saved", "saved")
    window.set_number("Frame", "2")
    window.wait_text("loaded", "0012")
    share = (1 / 3) ** 2 * (3 - 2 / 3)
    shown = window.wait_best(focus=3 + 9 * share)
    assert shown["f_stop"] == pytest.approx(2.0)
    keys = next(tmp_path.glob("*.csv"))
    pattern, out = frames / "passes.####.exr", tmp_path / "out.####.png"
    rackfocus("filter", pattern, "-o", out, "--frame-parameters", keys)
    assert window.sees(read_png(tmp_path / "out.0012.png"))


def test_one_picture_has_no_frames(view, passes):
    window = view(passes())
    window.wait_open()
    window.move(20, 20)
    window.key("l")
    window.wait_text("said", "one picture")
    assert not [c for c in window.layout()["controls"] if c.startswith("Frame")]
