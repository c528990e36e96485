# SPDX-License-Identifier: Apache-2.0
"""Looks of lenses in the window: the menu, --look, one's own, and parts of a picture."""

import numpy
import plainexr
import pytest
from conftest import CAMERA, read_exr


@pytest.fixture(autouse=True)
def looks(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return tmp_path / "config" / "rackfocus" / "looks"


def part(tmp_path, name, data, display):
    y, x = numpy.mgrid[0:120, 0:160].astype(numpy.float32)
    channels = {c: (x % 9 / 9).astype(numpy.float32) for c in "RGB"}
    channels["Z"] = (2 + y / 12).astype(numpy.float32)
    return plainexr.write(tmp_path / name, channels, CAMERA, data=data, display=display)


def saids(window):
    return [e["text"] for e in window.events() if e["event"] == "said"]


def test_looks_of_a_part_of_the_picture_are_told(view, rackfocus, tmp_path):
    """What the command warns of, silent before: as soon as a look is set, once, with a
    note as long as it holds. With the same middle it is right, and nothing is said."""
    overscan = part(tmp_path, "over.exr", (0, 0, 159, 119), (10, 10, 149, 109))
    crop = part(tmp_path, "crop.exr", (3, 4, 162, 123), (0, 0, 319, 199))
    words = (crop, "-o", tmp_path / "o.exr", "--swirl", "0.3")
    warned = rackfocus("filter", *words).stderr
    window = view(overscan, "--swirl", "0.3")
    window.wait_open()
    window.drop(crop)
    said = window.wait_text("said", "--swirl: is measured in the data window of")
    assert said in warned and said.endswith("--croptofull -o whole.exr")
    window.open_section("Character")
    window.set_number("Cat's eye", "0.4")
    window.set_number("Swirl", "0")
    window.copied()
    assert [s for s in saids(window) if "is measured" in s] == [said]
    assert window.printed().count("is measured in the data window") == 1
    window.drop(overscan)
    window.wait_text("loaded", "over.exr")
    window.drop(crop)
    window.wait_text("said", "--cat-eye: is measured in the data window of")


def test_a_look_of_one_s_own_is_kept(view, passes, looks, rackfocus, tmp_path):
    window = view(passes(), "--f-stop", "1.4")
    window.wait_open()
    window.open_section("Character")
    window.set_number("Look's name", "mine")
    window.click_control("Keep as a look")
    assert "nothing is to be kept" in window.wait_text("said", "kept")
    window.set_number("Blades", "6")
    window.set_number("Swirl", "0.3")
    window.click_control("Keep as a look")
    window.wait_text("said", "look mine is kept: --look mine sets it")
    lines = (looks / "mine.params").read_text().splitlines()
    assert lines[1:] == ["swirl 0.3", "blades 6"] or lines[1:] == [
        "blades 6",
        "swirl 0.3",
    ]
    window.set_number("Swirl", "0.2")
    window.click_control("Keep as a look")
    window.wait_text("said", "mine.params is there: save once more to replace it")
    window.click_control("Keep as a look")
    window.wait_text("said", "look mine is kept")
    assert "swirl 0.2\n" in (looks / "mine.params").read_text()
    for name, answer in (
        ("a b", "'a b' is no name of a look; take letters"),
        ("fast", "in place of the one of that name that comes with the program"),
    ):
        window.set_number("Look's name", name)
        window.click_control("Keep as a look")
        window.wait_text("said", answer)
    (looks / "fast.params").unlink()
    rackfocus("looks", "--save", "another", "--swirl", "0.1")
    # no look, six of ours, mine, another
    window.wait_until(lambda: n_items(window) == 9, "the new look")


def n_items(window):
    """Opens the list of looks, counts, and closes it."""
    window.click_control("Look")
    window.wait_until(lambda: window.layout()["list"][3] > 0, "the list")
    n = window.layout()["list"][3] / window.box("Look")[3]
    window.click_control("Look")
    window.wait_until(lambda: window.layout()["list"][3] == 0, "no list")
    return round(n)


def test_the_command_line_names_a_look(view, passes, rackfocus, tmp_path):
    """As filter takes it: what is typed wins. It is the menu's, too."""
    out, saved = tmp_path / "o.exr", tmp_path / "s.exr"
    words = (passes(), "--look", "vintage", "--cat-eye", "0.8")
    rackfocus("filter", *words, "-o", out)
    window = view(*words, "-o", saved)
    window.wait_open()
    window.key("ctrl+s")
    window.wait_until(lambda: any(s.startswith("saved") for s in saids(window)))
    assert numpy.array_equal(read_exr(saved), read_exr(out))
    window.open_section("Character")
    window.choose("Look", 2)
    said = window.wait_text("said", "look anamorphic")
    assert said == "look anamorphic is set; cat-eye stays as it was set"
    assert "--swirl" not in window.copied()
    assert "there is no such look" in rackfocus("view", *words[:2], "no", code=2).stderr
