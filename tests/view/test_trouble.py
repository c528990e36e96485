# SPDX-License-Identifier: Apache-2.0
"""No display, no OpenGL, files that go, windows of one px and of 8k."""

import os
import pathlib
import re
import shutil
import subprocess

import numpy
import pytest
import test_views_place
from conftest import DISC, HEIGHT, NEAR, WAIT_S, WIDTH, Display, plainexr, read_exr


def run(binary, *arguments, environment, code):
    done = subprocess.run(
        [binary, "view", *map(str, arguments)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=90,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stderr


def test_no_display(binary, passes):
    hidden = ("DISPLAY", "SDL_VIDEODRIVER")
    about = {k: v for k, v in os.environ.items() if not k.endswith(hidden)}
    text = run(binary, passes(), environment=about, code=1)
    last = text.splitlines()[-1]  # other libraries may have their say before
    assert last.startswith("rackfocus: view: there is no display") and "xvfb" in last


def test_no_opengl(binary, passes):
    """A display that has none."""
    display = Display(options=("-extension", "GLX"))
    try:
        text = run(binary, passes(), environment=display.environment(), code=1)
    finally:
        display.close()
    assert text.startswith("rackfocus: view: ") and "OpenGL" in text, text
    assert len(text.splitlines()) == 1


def test_no_window_in_this_build(binary, passes, tmp_path):
    """The command without the window's program beside it says what is missing."""
    alone = tmp_path / "bin" / "rackfocus"
    alone.parent.mkdir()
    shutil.copy(binary, alone)
    text = run(alone, passes(), environment=dict(os.environ), code=1)
    assert "libsdl2-dev" in text


@pytest.mark.parametrize(
    "arguments, part, code",
    [
        (["missing.exr"], "missing.exr: No such file", 1),
        ([], "needs something to show", 2),
        (["--demo", "a.exr", "b.exr"], "one picture", 2),
        (["--demo", "--benchmark-turn"], "--benchmark", 2),
        (["a.exr", "--views", "4"], "POV-Ray", 2),
        (["a.exr", "--params", "missing.params"], "missing.params", 1),
        (["PASSES", "--reference", "missing.png"], "missing.png", 1),
        (["PASSES", "--font", "PASSES"], "is no font file", 1),
        (["PASSES", "-o", "a.jpg"], "EXR or PNG", 2),
        (["PASSES", "--layer", "none"], "none", 1),
        (["PASSES", "--optics", "yu", "--focus-distance", "0.1"], "focal length", 1),
    ],
)
def test_bad_calls(binary, display, passes, arguments, part, code):
    path = str(passes())
    words = [path if word == "PASSES" else word for word in arguments]
    text = run(binary, *words, environment=display.environment(), code=code)
    assert text.startswith("rackfocus: ") and part in text, text


def test_bad_pixels_are_told(view, passes):
    path = passes()
    data = bytearray(open(path, "rb").read())
    data[-4:] = numpy.float32("nan").tobytes()  # of Z, the last channel
    open(path, "wb").write(data)
    window = view(path)
    said = window.wait_text("said", "no distances; where NaN means")
    assert "--fixnan black" in said
    problem = window.wait_text("problem")  # stays at the bottom
    assert "NaN" in problem and said.split("no distances")[1] in problem
    window.quit()
    assert f"oiiotool {path}" in window.printed()


def test_a_way_out_of_bad_colours(view, rackfocus, tmp_path):
    """That of rackfocus filter."""
    channels = {c: numpy.full((40, 60), 0.5, numpy.float32) for c in "RGB"}
    channels["Z"] = numpy.full((40, 60), 5, numpy.float32)
    channels["R"][3, 4] = numpy.nan
    plainexr.write(tmp_path / "a.exr", channels)
    words = ["a.exr", "--focus-distance", "4", "--depth-repair", "off"]
    window = view(*words)
    said = window.wait_text("said", "NaN or infinite; or give them")
    assert said.split("; or")[1] in window.wait_text("problem")  # stays at the bottom
    window.quit()
    filtered = rackfocus("filter", *words, "-o", "o.exr", code=1, cwd=tmp_path).stderr
    assert said.split("; or")[1] in filtered


@pytest.mark.parametrize(
    "attribute, part",
    [
        ({"rackfocus:filtered": "a lens"}, "the picture was filtered before (a lens)"),
        ({"envmap": ("envmap", b"\0")}, "environment map (envmap latlong"),
        ({"multiView": ["left", "right"]}, "the picture is the view left, one of 2"),
    ],
)
def test_doubts_of_the_picture_are_told(view, tmp_path, attribute, part):
    """Those that the command warns of before it reads a pixel."""
    channels = {name: numpy.full((40, 60), 0.5, "f4") for name in "RGB"}
    channels["Z"] = numpy.full((40, 60), 5, "f4")
    attributes = {"rackfocus:lensRadius": 0.2, "rackfocus:focalLengthPx": 400.0}
    path = plainexr.write(tmp_path / "a.exr", channels, {**attributes, **attribute})
    window = view(path, "--focus-distance", "4")
    assert part in window.wait_text("said")
    window.quit()


REFERENCES = pathlib.Path(__file__).parents[1] / "quality" / "references"


def test_a_depth_that_is_upside_down_is_told_in_whole(view, tmp_path):
    """As filter warns of it: over the picture where it is wider than its line, and on the
    terminal."""
    pixels = read_exr(REFERENCES / "posts_pinhole.exr")
    channels = dict(zip("RGB", numpy.moveaxis(pixels[..., :3], 2, 0), strict=True))
    path = plainexr.write(tmp_path / "a.exr", channels | {"Z": pixels[::-1, :, 3]})
    lens = ("--focus-distance", 1, "--lens-radius", 0.03125, "--focal-length-px", 667)
    window = view(path, *lens)
    said = window.wait_text("said")
    assert "the depth lies upside down" in said and "a.exr --flip -d float" in said
    assert f"{path}: {said}" in window.printed()
    window.wait_open()
    left, top, width, height = window.layout()["area"]

    def lines(seen):
        """Rows of the picture's lower part with letters of warnings."""
        part = seen[top + height // 2 : top + height, left : left + width].astype(int)
        is_letter = (part[..., 0] > 200) & (part[..., 2] < 110) & (part[..., 1] > 140)
        return is_letter.any(axis=1).sum()

    assert lines(window.look_until(lambda seen: lines(seen) > 25)) > 25
    window.quit()


def test_straight_alpha_is_told(view, tmp_path):
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    alpha = numpy.clip((90 - numpy.hypot(x - 160, y - 100)) / 4, 0, 1)
    light = 0.4 + 0.2 * numpy.sin(x / 5)
    channels = {name: numpy.where(alpha > 0, light, 0) for name in "RGB"}
    channels |= {"A": alpha, "Z": alpha * 0 + 5}
    channels = {name: values.astype("f4") for name, values in channels.items()}
    attributes = {"rackfocus:lensRadius": 0.2, "rackfocus:focalLengthPx": 400.0}
    path = plainexr.write(tmp_path / "a.exr", channels, attributes)
    window = view(path, "--focus-distance", "4")
    said = window.wait_text("said")
    assert "not multiplied by alpha" in said and "a.exr --ch R,G,B,A --premult" in said
    window.quit()


@pytest.mark.parametrize(
    "ending, light, alpha, part",
    [
        (
            "exr",
            1e6,
            1,
            "7200 values above 65504 were clipped to it, the largest "
            "half; float samples (--type float) keep them",
        ),
        ("png", 0.5, 0, "have light but no alpha"),
        ("png", 0.5, 1, ""),
    ],
)
def test_what_a_saved_file_loses_is_told(view, tmp_path, ending, light, alpha, part):
    """As filter warns of it: it was saved without a word."""
    values = dict.fromkeys("RGB", light) | {"A": alpha, "Z": 5}
    channels = {name: numpy.full((40, 60), v, "f4") for name, v in values.items()}
    attributes = {"rackfocus:lensRadius": 0.2, "rackfocus:focalLengthPx": 400.0}
    path = plainexr.write(tmp_path / "a.exr", channels, attributes)
    out = tmp_path / f"out.{ending}"
    window = view(path, "--focus-distance", 5, "-o", out)
    window.wait_open()
    window.key("ctrl+s")
    said = window.wait_text("saved")
    assert said.startswith(f"saved {out}") and part in said
    assert bool(part) == (said != f"saved {out}")
    window.quit()


def test_a_long_message_does_not_cover_a_tip(view, passes, tmp_path):
    """The tip's frame is whole: a line above it and one below."""
    out = tmp_path / "a_name_that_takes_more_than_a_line" / "of_the_window.exr"
    window = view(passes(), "-o", out)
    window.wait_open()
    window.resize(740, 780)
    window.wait_until(lambda: window.layout()["window"] == [740, 780], "the size")
    window.control("Samples")
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("said", "cannot write")
    window.move(*window.control("Samples"))
    window.wait_text("tip", "Samples of the EXR file")

    def n_lines(seen):
        return ((seen == (0xB8, 0xB8, 0xBE)).all(2).sum(1) > 200).sum()

    seen = window.look_until(
        lambda seen: n_lines(seen) == 2, lambda: window.look_still("tip")
    )
    assert n_lines(seen) == 2
    window.quit()


def test_float_samples_keep_what_half_loses(view, rackfocus, tmp_path):
    """By the control that the remark names, by --type and by the copied line."""
    values = {"R": 1e6, "G": 0.1, "B": 2e5, "Z": 5}
    channels = {name: numpy.full((40, 60), v, "f4") for name, v in values.items()}
    attributes = {"rackfocus:lensRadius": 0.2, "rackfocus:focalLengthPx": 400.0}
    path = plainexr.write(tmp_path / "a.exr", channels, attributes)
    out = tmp_path / "out.exr"
    want = numpy.array([1e6, 0.1, 2e5], "f4")
    window = view(path, "--focus-distance", 5, "-o", out)
    window.wait_open()
    window.choose("Samples", 1)
    window.click_control("Save picture")
    assert window.wait_text("saved") == f"saved {out}"
    assert (read_exr(out) == want).all()
    out.unlink()
    words = window.copied()
    window.quit()
    rackfocus(*words[1:])
    assert (read_exr(out) == want).all()
    out.unlink()
    window = view(path, "--focus-distance", 5, "-o", out, "--type", "float")
    window.wait_open()
    window.key("ctrl+s")
    assert window.wait_text("saved") == f"saved {out}"
    assert (read_exr(out) == want).all()
    window.quit()


def test_views_that_do_not_fit_are_told(view, tmp_path):
    """As `rackfocus filter` tells it: another place, another exposure; of right ones
    nothing."""
    other_place = "y of rackfocus:lensOffset had the other sign"
    for sign, light, words in (
        (-1, 1, other_place),
        (1, 2, "is 2 times as bright as the other views"),
        (1, 1, None),
    ):
        paths = [
            test_views_place.make(
                tmp_path / f"v{sign}{light}{i}.exr",
                (x, y),
                (x, sign * y),
                light=light if i == 2 else 1,
            )
            for i, (x, y) in enumerate(test_views_place.PLACES)
        ]
        window = view(*paths)
        if words:
            assert words in window.wait_text("said")
        else:
            window.wait_open()
        said = window.printed()
        assert ("elsewhere" in said, "bright" in said) == (sign < 0, light > 1), said
        window.quit()


def test_depth_that_was_multiplied_by_alpha(view, tmp_path, rackfocus):
    """Mended as the command mends it, and said."""
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(numpy.float32)
    alpha = numpy.clip(x - 99.5, 0, 1).astype(numpy.float32)  # half at 100
    stripes = ((x // 5) % 2 * alpha).astype(numpy.float32)
    channels = {"R": stripes, "G": stripes, "B": alpha, "A": alpha, "Z": 8 * alpha}
    attributes = {"rackfocus:lensRadius": 0.2, "rackfocus:focalLengthPx": 400.0}
    path = plainexr.write(tmp_path / "soft.exr", channels, attributes)
    window = view(path, "--focus-distance", "2")
    assert "multiplied by alpha" in window.wait_text("said")
    window.wait_open()
    window.key("ctrl+s")
    window.wait_text("saved", "saved soft_focus.exr")
    out = tmp_path / "command.exr"
    rackfocus("filter", path, "-o", out, "--focus-distance", "2")
    assert numpy.array_equal(read_exr(tmp_path / "soft_focus.exr"), read_exr(out))
    window.quit()


def test_a_file_that_vanishes(view, passes, tmp_path, command_picture):
    """The picture stays, can be filtered and saved; reading it again says why not."""
    path = passes()
    want = command_picture(path, "--focus-distance", str(NEAR))
    window = view(path)
    window.wait_open()
    os.unlink(path)
    window.wait_text("missing", "passes.exr")
    window.click(*window.on_picture(*DISC))
    window.wait_best(focus=NEAR)
    assert window.sees(want)
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved passes_focus.exr")
    window.key("r")
    assert "passes.exr" in window.wait_text("error")
    passes()
    window.key("r")
    window.wait_text("loaded", "passes.exr")
    window.wait_best()
    window.quit()


def test_one_pixel_and_8k(view, passes):
    """The window survives both, and shows the picture again."""
    window = view(passes())
    window.wait_open()
    before = window.look_at_picture(WIDTH, HEIGHT)
    for size in [(1, 1), (7680, 4320), (3, 2000), (900, 700)]:
        window.resize(*size)
        window.wait(
            lambda e, size=size: e["event"] == "layout" and e["window"] == [*size],
            f"a window of {size}",
        )
    window.place()
    window.move(20, 20)
    window.key("d", "d")
    window.wait_best(mode=0)
    assert window.sees(before)
    window.quit()


def test_dense_displays_have_larger_letters(view, passes):
    display = Display(size=(2400, 1500), options=("-dpi", "192"))
    try:
        window = view(passes(), on=display)
        window.wait_open()
        assert window.layout()["letters"] == 28
        window.look("dense")
        window.quit()
        chosen = ["-f", "RESOURCE_MANAGER", "8s", "-set", "RESOURCE_MANAGER"]
        subprocess.run(
            ["xprop", "-root", *chosen, "Xft.dpi: 144"],
            env=display.environment(),
            check=True,
        )
        window = view(passes(), on=display)
        window.wait_open()
        assert window.layout()["letters"] == 21
        window.quit()
        window = view(passes(), "--scale", "1.5", on=display)
        window.wait_open()
        assert window.layout()["letters"] == 21
    finally:
        window.close()
        display.close()


def test_interruption_ends_it(view, passes):
    window = view(passes())
    window.wait_open()
    window.process.terminate()
    assert window.process.wait(timeout=WAIT_S) == 143


@pytest.mark.parametrize("turn", [False, True])
def test_benchmark_prints_what_it_measured(view, passes, turn):
    """Figures of any size: how fast it is depends on the machine."""
    what = ["--demo", "--demo-width", 320, "--benchmark-turn"] if turn else [passes()]
    window = view(*what, "--benchmark", "2")
    assert window.process.wait(timeout=WAIT_S) == 0
    text = window.printed()
    for part in ("updates", "input to picture", "filter", "drawing", "llvmpipe"):
        assert part in text, text
    assert int(re.search(r"updates (\d+)", text)[1]) > 0, text
    assert re.search(r"release to best picture: \d+ ms", text), text


def test_benchmark_counts_views(view):
    window = view(
        *("--demo", "--demo-width", 160, "--demo-height", 160, "--demo-views", 4),
        *("--benchmark", "1", "--benchmark-turn"),
    )
    assert window.process.wait(timeout=WAIT_S) == 0
    text = window.printed()
    assert "picture 160 x 160 px" in text
    assert int(re.search(r"views drawn (\d+)", text)[1]) > 4, text
    assert int(re.search(r"(\d+) means of 4 views", text)[1]) > 0, text
