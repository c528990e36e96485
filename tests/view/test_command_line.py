# SPDX-License-Identifier: Apache-2.0
"""The copied command line makes the picture that the window shows, whatever is set."""

import subprocess

import numpy
import pytest
from conftest import CAMERA, FAR, HEIGHT, NEAR, WIDTH, plainexr, read_exr


def channels(prefix="", shift=0):
    """A near disc before a far wall, in a layer."""
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(numpy.float32)
    near = (x - 160 + shift) ** 2 + (y - 100) ** 2 < 45**2
    found = {
        "R": numpy.where(near, 0.8, 0.2 + 0.5 * ((x // 7 + y // 11) % 2)),
        "G": numpy.where(near, 0.4 * y / HEIGHT, 0.3),
        "B": numpy.where(near, 0.1, 0.9 - x / WIDTH),
        "Z": numpy.where(near, NEAR, FAR),
    }
    return {prefix + name: plane.astype(numpy.float32) for name, plane in found.items()}


@pytest.fixture
def files(tmp_path):
    """Every file that the options below name."""
    both = {**channels("front."), **channels("back.", 60)}
    plainexr.write(tmp_path / "layers.exr", both, CAMERA)
    one = channels()
    z = one.pop("Z")
    plainexr.write(tmp_path / "colour.exr", one, CAMERA)
    plainexr.write(tmp_path / "depth of it.exr", {"Z": z})
    plainexr.write(tmp_path / "named.exr", {**one, "far.D": z, "Z": z + 2}, CAMERA)
    mist = ((z - 2) / 20).astype(numpy.float32) ** 2
    plainexr.write(tmp_path / "mist.exr", {**one, "Mist.Z": mist}, CAMERA)
    alpha = numpy.clip(numpy.mgrid[0:HEIGHT, 0:WIDTH][1] - 99.5, 0, 1)
    soft = {name: plane * alpha for name, plane in {**one, "Z": z}.items()}
    plainexr.write(tmp_path / "soft.exr", {**soft, "A": alpha}, CAMERA)
    plainexr.write(tmp_path / "one.exr", {**one, "Z": z}, CAMERA)
    y, x = numpy.mgrid[0:16, 0:16].astype(numpy.float32)
    light = ((x > 4) | (y > 11)).astype(numpy.float32)
    plainexr.write(tmp_path / "l.exr", dict.fromkeys("RGB", light))
    (tmp_path / "my.params").write_text("f-stop 1.3\nblades 5\n")
    return tmp_path


SCATTER = ["--method", "scatter"]
CASES = {
    "layer": ["layers.exr", "--layer", "back"],
    "depth file": ["colour.exr", "--depth-file", "depth of it.exr"],
    "two files": ["colour.exr", "depth of it.exr"],
    "depth channel": ["named.exr", "--depth-channel", "far.D"],
    "depth repair": ["soft.exr", "--depth-repair", "off"],
    "mist": [
        "mist.exr", "--depth-channel", "Mist.Z", "--mist-falloff", "quadratic",
        "--depth", "normalised", "--depth-near", "2", "--depth-far", "22",
    ],
    "params": ["one.exr", "--params", "my.params"],
    "light": ["one.exr", *SCATTER, "--distribution-image", "l.exr"],
    "method": [
        "one.exr", "--method", "mipmap", "--blend", "coc", "--blend-gamma", "2.2",
    ],
    "lens": [
        "one.exr", "--optics", "yu", "--aperture-ratio", "1.4", "--blades", "7",
        "--blade-rotation", "12", "--max-radius", "9", "--quality", "preview",
    ],
    "switches": [
        "one.exr", "--no-exact-highlights", "--depth-scale", "1.5", *SCATTER,
        "--distribution", "ring", "--blend-gamma", "1.8",
    ],
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_copied_line_makes_the_same_picture(view, binary, files, case):
    """To the bit."""
    window = view(*CASES[case])
    window.wait_open()
    window.move(20, 20)
    window.key("n")  # focus on the nearest thing, beside what was typed
    window.wait(
        lambda e: e["event"] == "shown" and e["quality"] == "best" and e["is_newest"]
    )
    window.click_control("File")
    window.type("saved.exr")
    window.key("Return")
    window.click_control("Save picture")
    window.wait_text("saved", "saved saved.exr")
    window.move(20, 20)
    words = window.copied()
    window.quit()
    saved = read_exr(files / "saved.exr")
    (files / "saved.exr").unlink()
    subprocess.run([binary, *words[1:]], check=True, cwd=files)
    assert numpy.array_equal(read_exr(files / "saved.exr"), saved)
    assert "--focus-distance" in words


def test_the_light_of_a_picture(view, rackfocus, files, command_picture):
    """The window shows it; with another method its options are not copied."""
    options = [*SCATTER, "--distribution-image", files / "l.exr"]
    near = ["--focus-distance", NEAR]
    want = command_picture(files / "one.exr", *options, *near)
    plain = command_picture(files / "one.exr", *SCATTER, *near)
    assert not numpy.array_equal(want, plain)
    window = view(files / "one.exr", *options, *near)
    window.wait_open()
    assert window.sees(want)
    window.click_control("Method")  # opens the list; layered is the first
    x, y = window.control("Method")
    window.click(x, y + 26)
    window.wait_best(method="layered")
    window.move(20, 20)
    words = window.copied()
    assert "--distribution-image" not in words
    rackfocus(*words[1:], cwd=files)


@pytest.mark.parametrize(
    "arguments, part, code",
    [
        (["--over", "one.exr"], "two to eight layers", 2),
        (["one.exr", "--stereo", "--over"], "do not go together", 2),
        (["one.exr", "--stereo"], "holds one view", 1),
        (["--demo", "--stereo", "--demo-views", 8], "one eye", 2),
        (["--demo", "--demo-views", 8, "--reference", "one.exr"], "leave out", 2),
        (["--demo", "--over"], "two to eight layers", 2),
        (["one.exr", "--demo-views", 8], "go with --demo", 2),
        (["one.exr", "--distribution-image", "l.exr"], "--method scatter", 2),
        (["one.exr", *SCATTER, "--distribution", "image"], "--distribution-image", 2),
        (["one.exr", *SCATTER, "--distribution-image", "none.exr"], "none.exr", 1),
    ],
)
def test_what_the_window_does_not_take(
    rackfocus, display, files, arguments, part, code
):
    """Said at once, with the way out."""
    done = rackfocus(
        "view", *arguments, code=code, cwd=files, env=display.environment()
    )
    assert part in done.stderr
