# SPDX-License-Identifier: Apache-2.0
"""What can be shown: views, folders, POV-Ray scenes."""

import pathlib
import shlex
import subprocess
import sys

import mixed_pixels
import numpy
import plainexr
import pytest
from conftest import HEIGHT, WIDTH, read_exr, read_png

OFFSETS = [(0.0, 0.0), (0.108, 0.0), (-0.108, 0.0)]


def make_views(passes, n=3, is_soft=False):
    """Views whose disc and wall are where parallel cameras would see them."""
    paths = []
    for i, (u, v) in enumerate(OFFSETS[:n]):
        # f_px = 320 * 50 / 36; depth 12 moves by u f_px / 12 px, here rounded.
        paths.append(
            passes(
                f"passes_v{i:02}.exr",
                shift=round(u * 320 * 50 / 36 / 12),
                attributes={"rackfocus:lensOffset": (u, v)},
                is_soft=is_soft,
            )
        )
    return paths


def test_views_are_merged(view, passes, rackfocus, tmp_path):
    """Several views make the picture of the method `views`."""
    paths = make_views(passes)
    window = view(*paths)
    shown = window.wait_open()
    assert shown["method"] == "views"
    out = tmp_path / "want.png"
    rackfocus("filter", *paths, "-o", out)
    assert window.sees(read_png(out))


def test_anti_aliased_depth_of_views(view, passes, rackfocus, tmp_path):
    """Mended in every view as the command mends it, and said."""
    paths = make_views(passes, is_soft=True)
    window = view(*paths)
    assert "anti-aliased" in window.wait_text("said")
    window.wait_open()
    out = tmp_path / "want.png"
    rackfocus("filter", *paths, "-o", out)
    assert window.sees(read_png(out))
    window.quit()


def test_the_eye_moves_among_the_views(view, passes):
    """The right button moves the eye; the view nearest to it is what is seen."""
    window = view(*make_views(passes))
    window.wait_open()
    x, y = window.on_picture(160, 100)
    radius = 0.3 * min(window.layout()["area"][2:])
    window.press(x, y, button=3)
    window.wait_shown(eye=True)
    window.move(x + 0.5 * radius, y)
    right = window.wait_shown(eye=True, eye_view=1)
    assert right["method"] == "eye"
    window.move(x - 0.5 * radius, y)
    window.wait_shown(eye=True, eye_view=2)
    window.release(button=3)
    window.wait_best(eye=False, method="views")


def test_the_eye_sees_relief_in_one_view(view, passes):
    """What is near moves against what is far; at rest the lens's picture is back."""
    window = view(passes())
    window.wait_open()
    window.key("f")
    window.wait_shown(filter=False)
    plain = window.look_at_picture(WIDTH, HEIGHT)
    window.move(20, 20)
    window.key("shift+Right", "shift+Right", "shift+Right", "shift+Right")
    window.wait_shown(eye=True)
    seen = window.look_at_picture(WIDTH, HEIGHT, "relief")
    # The wall is in focus and stays; the disc, before it, moves to the left.
    assert numpy.array_equal(seen[:20], plain[:20])
    row, red = 100, plain[100, 160]
    before = numpy.flatnonzero((plain[row] == red).all(axis=-1))
    after = numpy.flatnonzero((seen[row] == red).all(axis=-1))
    assert len(before) == len(after) and after[0] < before[0]
    window.move(20, 20)
    window.key("Home", "f")
    window.wait_best(eye=False, filter=True, method="layered")


def test_a_folder_is_stepped_through(view, passes, tmp_path, command_picture):
    paths = [passes(f"passes{i:04}.exr", shift=3 * i) for i in (1, 2)]
    first, second = (command_picture(path) for path in paths)
    assert not numpy.array_equal(first, second)
    window = view(tmp_path)
    window.wait_text("loaded", "passes0001.exr")
    window.wait_open()
    assert window.sees(first)
    window.move(20, 20)
    window.key("Next")
    window.wait_text("loaded", "passes0002.exr")
    window.wait_best()
    assert window.sees(second)
    window.move(20, 20)
    window.key("Next")
    window.wait_text("said", "picture 2 of 2")
    window.key("Prior")
    window.wait_text("loaded", "passes0001.exr")
    window.wait_best()
    assert window.sees(first)


def test_holes_in_a_folder_are_told(view, passes, tmp_path):
    for i in (1, 2, 4):
        passes(f"passes{i:04}.exr")
    window = view(tmp_path)
    window.wait_text("said", "of frames 1 to 4 there is no 3")
    window.key("Next")
    window.wait_text("loaded", "passes0002.exr")
    window.quit()
    assert window.printed().count("there is no 3") == 1


SCENE = """
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0, 1, -6> look_at <0, 1, 0> angle 40
         aperture 0.6 focal_point <0, 1, 0> blur_samples 7 }
light_source { <10, 20, -20> rgb 1 }
sphere { <0, 1, 0>, 0.8 pigment { checker rgb 0.9 rgb <0.7, 0.1, 0.1> scale 0.2 } }
sphere { <1.2, 1, 4>, 1 pigment { rgb <0.1, 0.5, 0.2> } }
plane { y, 0 pigment { checker rgb 0.8 rgb 0.3 } }
plane { -z, -12 pigment { rgb <0.3, 0.4, 0.7> } }
"""


def test_a_scene_of_povray(view, tmp_path, binary):
    """Rendered first, with progress; the copied command line makes the same picture."""
    scene = tmp_path / "scene.pov"
    scene.write_text(SCENE)
    window = view(scene, "--", "+W240", "+H160")
    window.wait_text("loaded", "scene.pov")
    window.wait_open()
    x, y = window.on_picture(160, 70)  # the green sphere behind
    window.click(x, y)
    shown = window.wait_best()
    assert 8 < shown["focus"] < 11
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved scene_focus.exr")
    window.key("ctrl+c")
    window.wait_text("said", "copied")
    window.quit()
    saved = read_exr(tmp_path / "scene_focus.exr")
    (tmp_path / "scene_focus.exr").unlink()
    line = window.printed().strip().splitlines()[-1]
    for part in line.split(" && "):
        words = shlex.split(part)
        subprocess.run([binary, *words[1:]], check=True, cwd=tmp_path, timeout=300)
    made = read_exr(tmp_path / "scene_focus.exr")
    assert made.shape == saved.shape
    assert numpy.array_equal(made, saved)


STOP = ["--f-stop", "1.4", "--unit-scale", "10", "--focal-length", "85"]


@pytest.mark.parametrize(
    "own, options",
    [
        (True, [*STOP, "--sensor-width", "36", "--tilt-x", "4"]),
        (True, ["--focal-length", "85", "--sensor-width", "36", "--tilt-x", "4"]),
        (False, [*STOP, "--views", "2"]),
        (False, []),
    ],
)
def test_an_f_stop_of_a_scene(view, tmp_path, binary, own, options):
    """The lens of rackfocus povray, in the picture and in the copied command line."""
    lens = "aperture 0.6 focal_point <0, 1, 0> blur_samples 7"
    (tmp_path / "s.pov").write_text(SCENE if own else SCENE.replace(lens, ""))
    size = ["--", "+W120", "+H80"]
    window = view("s.pov", *options, *size)
    window.wait_open()
    window.key("ctrl+s")
    window.wait_text("saved", "saved s_focus.exr")
    window.key("ctrl+c")
    window.wait_text("said", "copied")
    window.quit()
    saved = read_exr(tmp_path / "s_focus.exr")
    (tmp_path / "s_focus.exr").unlink()
    command = [binary, "povray", "s.pov", "-o", "c.exr", "--supersample", "1",
               "--overscan", "0", *(options or ["--f-stop", "2.8"]), *size]  # fmt: skip
    subprocess.run(command, check=True, cwd=tmp_path, timeout=300)
    line = window.printed().strip().splitlines()[-1]
    for part in line.split(" && "):
        words = part.replace("*.exr", "00.exr passes/passes_v01.exr").split()
        subprocess.run([binary, *words[1:]], check=True, cwd=tmp_path, timeout=300)
    for made in ("c.exr", "s_focus.exr"):
        assert numpy.array_equal(read_exr(tmp_path / made), saved), made


@pytest.mark.parametrize("options", [[*STOP, "--sensor-width", "36"], []])
def test_an_f_stop_that_comes_later(view, tmp_path, binary, options):
    """Of a file of parameters, for a scene that has a lens: as typed at first."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "later.params").write_text("f-stop 4\nunit-scale 10\n")
    size = ["--", "+W120", "+H80"]
    window = view("s.pov", *options, *size)
    window.wait_open()
    window.drop(tmp_path / "later.params")
    window.wait_text("said", "later.params are set")
    window.wait_best()
    window.key("ctrl+s")
    window.wait_text("saved", "saved s_focus.exr")
    window.quit()
    later = [*options, "--f-stop", "4", "--unit-scale", "10"]
    command = [binary, "povray", "s.pov", "-o", "c.exr", "--supersample", "1",
               "--overscan", "0", *later, *size]  # fmt: skip
    subprocess.run(command, check=True, cwd=tmp_path, timeout=300)
    found, wanted = (read_exr(tmp_path / n) for n in ("s_focus.exr", "c.exr"))
    assert numpy.abs(found - wanted).max() < 1e-3


@pytest.mark.parametrize("options", [[], ["--views", "2"]])
def test_what_a_scene_is_warned_of(view, tmp_path, options):
    """What rackfocus povray says as a warning is said at the bottom."""
    scene = tmp_path / "scene.pov"
    lamp = "sphere { <-2, 2, 1>, 0.3 pigment { rgb 1 } finish { emission 1e6 } }\n"
    lens = SCENE.replace(" blur_samples 7", "")
    scene.write_text(lens + lamp + '#fopen F "made.txt" write\n#fclose F\n')
    window = view(scene, *options, "--", "+W120", "+H80")
    said = window.wait_text("said", "writes files (#fopen)")
    assert "brighter than 65504" in said
    assert "no blur_samples" in said
    window.wait_open()
    window.quit()


def test_a_scene_with_an_error(view, tmp_path):
    scene = tmp_path / "broken.pov"
    scene.write_text("camera { location <0, 0, -5> }\nsphere { <0, 0, 0>, }\n")
    window = view(scene)
    assert window.process.wait(timeout=90) == 1
    assert "broken.pov" in window.printed()


def test_mean_rays_are_read_as_the_command_does(view, rackfocus, tmp_path):
    channels, ray = mixed_pixels.passes()
    path = plainexr.write(tmp_path / "in.exr", channels | {"Denoising Depth.Z": ray})
    lens = [*mixed_pixels.LENS, "--focal-length-px", mixed_pixels.FOCAL_PX]
    window = view(path, *lens)
    window.wait_open()
    out = tmp_path / "out.png"
    rackfocus("filter", path, "-o", out, *lens)
    seen = read_png(out)
    assert window.sees(seen)
    plainexr.write(path, channels)
    rackfocus("filter", path, "-o", out, *lens)
    assert (read_png(out) != seen).any()


def test_deep_samples_are_filtered_as_the_command_does(view, rackfocus, tmp_path):
    """The best picture is of the samples; flattened, the file gives another one."""
    sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "deep"))
    import deepscene

    camera = deepscene.Camera(120, 80, 130, 0.22, 6)
    near = deepscene.Layer(
        3,
        lambda x, y: numpy.broadcast_to([0.8, 0.3, 0.1], x.shape + (3,)),
        lambda x, y: 0.6 * (x**2 + y**2 < 0.2),
    )
    far = deepscene.Layer(
        12,
        lambda x, y: numpy.stack([x % 1, y % 1, 0 * x + 0.5], axis=-1),
        lambda x, y: numpy.ones(x.shape),
    )
    path = tmp_path / "deep.exr"
    samples = deepscene.deep_samples(camera, [near, far])
    deepscene.write_deep(str(path), camera, samples)
    lens = ["--focus-distance", 6, "--lens-radius", 0.22, "--focal-length-px", 130]
    window = view(path, *lens)
    window.wait_open()
    out, flat = tmp_path / "out.png", tmp_path / "flat.exr"
    rackfocus("filter", path, "-o", out, "--flattened", flat, *lens)
    assert window.sees(read_png(out))
    rackfocus("filter", flat, "-o", tmp_path / "of_flat.png", *lens)
    assert not numpy.array_equal(read_png(out), read_png(tmp_path / "of_flat.png"))
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved")
    rackfocus("filter", path, "-o", tmp_path / "out.exr", *lens)
    saved = next(tmp_path.glob("deep_focus.exr"))
    assert numpy.array_equal(read_exr(saved), read_exr(tmp_path / "out.exr"))


def make_layer(tmp_path, name, z, colour, is_disc, attributes=()):
    """A disc with alpha, or a whole picture with a slope of colour."""
    y, x = numpy.mgrid[0:120, 0:160].astype(numpy.float32)
    inside = (x - 80) ** 2 + (y - 60) ** 2 < 30**2
    alpha = inside.astype(numpy.float32) if is_disc else numpy.ones_like(x)
    channels = {c: (v * alpha * (0.5 + x / 320)) for c, v in zip("RGB", colour)}
    channels |= {"A": alpha, "Z": numpy.full_like(x, z)}
    channels = {k: v.astype(numpy.float32) for k, v in channels.items()}
    lens = {"focusDistance": 8.0, "lensRadius": 0.1, "focalLengthPx": 200.0}
    about = {f"rackfocus:{k}": v for k, v in lens.items()}
    return plainexr.write(tmp_path / name, channels, about)


def test_layers_are_shown_over_each_other(view, rackfocus, tmp_path):
    """As filter --over makes them, with what is changed in the window."""
    top = make_layer(tmp_path, "top.exr", 3, (0.9, 0.2, 0.1), True)
    low = make_layer(tmp_path, "low.exr", 8, (0.1, 0.5, 0.8), False)
    out = tmp_path / "out.png"
    window = view("--over", top, low)
    window.wait_open()
    rackfocus("filter", top, low, "--over", "-o", out)
    assert window.sees(read_png(out))
    window.set_number("Focus distance", "3")
    window.wait_best(focus=3.0)
    rackfocus("filter", top, low, "--over", "-o", out, "--focus-distance", 3)
    assert window.sees(read_png(out))
    words = window.copied()
    assert "--over" in words and words.index(str(top)) < words.index(str(low))
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved")


def test_dark_layers_have_lamps(view, rackfocus, tmp_path):
    """What is a lamp is told by the white of each layer, as filter --over tells it."""
    top = make_layer(tmp_path, "top.exr", 3, (0.9, 0.2, 0.1), True)
    low = make_layer(tmp_path, "low.exr", 16, (0.001, 0.002, 0.002), False)
    channels, _ = plainexr.read(low)
    y, x = numpy.mgrid[0:120, 0:160]
    for name in "RGB":
        channels[name][(x % 31 == 7) & (y % 23 == 11)] = 1
    low = plainexr.write(tmp_path / "low.exr", channels)
    lens = ["--focus-distance", 8, "--lens-radius", 0.1, "--focal-length-px", 200]
    window = view("--over", top, low, *lens)
    window.wait_open()
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("saved", "saved")
    (saved,) = tmp_path.glob("*_focus.exr")
    made = {}
    for white in ((), ("--white", 1)):
        out = tmp_path / f"white{len(white)}.exr"
        rackfocus("filter", top, low, "--over", "-o", out, *lens, *white)
        made[white] = read_exr(out)
    assert not numpy.array_equal(*made.values())
    assert numpy.array_equal(read_exr(saved), made[()])


def test_both_eyes_of_a_stereo_pair(view, rackfocus, tmp_path):
    """Left, right, red and cyan, side by side: each eye as filter makes it."""
    paths = [
        make_layer(tmp_path, f"{name}.exr", 3 + i, (0.9, 0.5 - 0.3 * i, 0.4), False)
        for i, name in enumerate(("left", "right"))
    ]
    eyes = []
    rackfocus("filter", *paths, "--stereo", "-o", tmp_path / "eye_%V.png")
    for name in ("left", "right"):
        eyes.append(read_png(tmp_path / f"eye_{name}.png"))
    window = view("--stereo", *paths)
    window.wait_open()
    assert window.sees(eyes[0])
    window.choose("Eyes", 1)
    window.move(20, 20)
    assert window.sees(eyes[1])
    window.choose("Eyes", 2)
    window.move(20, 20)
    both = numpy.concatenate([eyes[0][..., :1], eyes[1][..., 1:]], axis=-1)
    assert window.sees(both)
    window.choose("Eyes", 3)
    window.move(20, 20)

    def is_beside(seen):
        left, right = seen[:, :80].astype(int), seen[:, 80:].astype(int)
        halves = [eye[:, ::2].astype(int) for eye in eyes]
        return abs(left - halves[0]).max() < 12 and abs(right - halves[1]).max() < 12

    look = lambda: window.look_at_picture(160, 120)  # noqa: E731
    assert is_beside(window.look_until(is_beside, look))
    window.move(20, 20)
    window.key("ctrl+s")
    window.wait_text("said", "--stereo")
    assert "--stereo" in window.copied()


def test_the_eyes_are_views_left_and_right(view, rackfocus, tmp_path):
    """Of a file whose first view is another one."""
    colours = {
        "center": (0.1, 0.9, 0.1),
        "right": (0.2, 0.3, 0.9),
        "left": (0.9, 0.3, 0.2),
    }
    alone = {
        n: make_layer(tmp_path, f"{n}.exr", 3, c, False) for n, c in colours.items()
    }
    channels = {
        name if view_name == "center" else f"{view_name}.{name}": values
        for view_name, path in alone.items()
        for name, values in plainexr.read(path)[0].items()
    }
    about = plainexr.read(alone["center"])[1] | {"multiView": list(colours)}
    lens = {k: v for k, v in about.items() if k.startswith(("rackfocus", "multi"))}
    three = plainexr.write(tmp_path / "three.exr", channels, lens)
    window = view("--stereo", three)
    window.wait_open()
    for i, name in enumerate(("left", "right")):
        out = tmp_path / f"eye_{name}.png"
        rackfocus("filter", alone[name], "-o", out)
        window.choose("Eyes", i)
        window.move(20, 20)
        assert window.sees(read_png(out)), name
