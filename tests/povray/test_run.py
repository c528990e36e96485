# SPDX-License-Identifier: Apache-2.0
"""The whole command: pictures, passes, names, frames, failures."""

import os
import re
import shutil
import signal
import subprocess
import time

import numpy
import pytest
from conftest import EXAMPLES, SCENE, SIZE, read_exr

SMALL, TINY = ["+W80", "+H60"], ["+W32", "+H24"]


def tpsnr(text):
    return float(re.search(r"tPSNR ([0-9.]+) dB\s*$", text).group(1))


def test_focalblur_beats_the_bar(rackfocus, tmp_path):
    """Against POV-Ray's own focal blur; the stored reference has 600 samples."""
    out = tmp_path / "out.exr"
    found = rackfocus("povray", "focalblur.pov", "-o", out, "--reference", "120", "--",
                      "+W160", "+H120", cwd=EXAMPLES / "camera").stdout  # fmt: skip
    assert "120 samples" in found
    assert re.search(r"times (faster|slower)", found)  # by what else runs here
    assert tpsnr(found) > 36  # the reference itself is grainy at 120 samples


@pytest.mark.parametrize("options", [["--views", "8"], []])
def test_how_much_faster(rackfocus, tmp_path, options):
    """Or slower, where a few samples of POV-Ray's own take less time."""
    (tmp_path / "s.pov").write_text(SCENE)
    found = rackfocus("povray", "s.pov", "-o", "o.exr", "--reference", "4", *options,
                      "--", "+W32", "+H24", cwd=tmp_path).stdout  # fmt: skip
    own_s, times, word = re.search(
        r"rackfocus: ([0-9.]+) s, ([0-9.]+) times (\w+)", found
    ).groups()
    reference_s = float(re.search(r"4 samples: ([0-9.]+) s", found).group(1))
    own_s = float(own_s)
    assert word == ("slower" if own_s > reference_s else "faster")
    ratio = max(own_s, reference_s) / min(own_s, reference_s)
    # The times are printed to 0.01 s.
    assert float(times) == pytest.approx(ratio, rel=0.05, abs=0.1)
    assert word == "slower" or not options


def test_the_reference_is_kept(rackfocus, tmp_path):
    """POV-Ray's own focal blur: what the printed score is about."""
    (tmp_path / "s.pov").write_text(SCENE)
    found = rackfocus("povray", "s.pov", "-o", "o.exr", "--reference", "20",
                      "--reference-output", "lens.exr", "--", *SIZE,
                      cwd=tmp_path).stdout  # fmt: skip
    again = rackfocus("compare", "o.exr", "lens.exr", cwd=tmp_path).stdout
    assert tpsnr(found) == tpsnr(again)


@pytest.mark.parametrize(
    "items, options, is_said",
    [
        ("", [], True),
        ("", ["--focus-distance", "4"], True),
        ("", ["--views", "2"], True),
        ("", ["--method", "accumulate", "--views", "2"], True),
        ("blur_samples 7", [], False),
        ("blur_samples 4, 20", [], False),
        ("", ["--aperture", "0.6"], False),
        ("", ["--lens-radius", "0.15"], False),
        ("", ["--f-stop", "2", "--focal-length", "50", "--sensor-width", "36"], False),
        ("", ["--quiet"], False),
    ],
)
def test_a_lens_that_povray_does_not_draw(rackfocus, tmp_path, items, options, is_said):
    """An aperture is nothing to POV-Ray without blur_samples, and is blurred here."""
    (tmp_path / "s.pov").write_text(
        SCENE.replace("aperture 0.6", f"aperture 0.6 {items}")
    )
    done = rackfocus(
        "povray", "s.pov", "-o", "o.exr", *options, "--", *TINY, cwd=tmp_path
    )
    said = done.stdout + done.stderr
    assert ("no blur_samples: POV-Ray itself draws" in said) == is_said
    assert ("'blur_samples 37'" in said) == is_said


def test_povray_draws_no_blur_without_samples(rackfocus, tmp_path):
    """What is said of POV-Ray holds: its picture is the pinhole's."""
    sharp = SCENE.replace("aperture 0.6 focal_point <0, 1, 0>", "")
    scenes = {"lens": SCENE, "sharp": sharp}
    for name, text in scenes.items():
        (tmp_path / f"{name}.pov").write_text(text)
        subprocess.run(["povray", f"{name}.pov", f"+O{name}.ppm", "+FP", "-D", *SIZE],
                       cwd=tmp_path, check=True, capture_output=True)  # fmt: skip
    # The header has the time.
    lens, sharp = ((tmp_path / f"{name}.ppm").read_bytes() for name in scenes)
    assert lens[-160 * 120 * 3 :] == sharp[-160 * 120 * 3 :]


def test_a_look_is_its_parameters(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(SCENE)
    for name, words in {
        "plain": [],
        "look": ["--look", "mirror", "--cat-eye", "0.5"],
        "typed": ["--obstruction", "0.45", "--cat-eye", "0.5"],
    }.items():
        rackfocus("povray", "s.pov", "-o", f"{name}.exr", *words, "--", *SIZE,
                  cwd=tmp_path)  # fmt: skip
    plain, look, typed = (
        read_exr(tmp_path / f"{name}.exr")["R"] for name in ("plain", "look", "typed")
    )
    assert numpy.array_equal(look, typed)
    assert numpy.abs(look - plain).max() > 0.02


def test_kept_passes_refocus(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(SCENE)
    rackfocus(
        "povray", "s.pov", "-o", "a.exr", "--keep", "kept", "--", *SIZE, cwd=tmp_path
    )
    rackfocus("filter", "kept/passes.exr", "-o", "b.exr", cwd=tmp_path)
    rackfocus("filter", "kept/passes.exr", "-o", "c.exr", "--focus-distance", "8",
              cwd=tmp_path)  # fmt: skip
    a, b, c = (read_exr(tmp_path / f"{name}.exr")["R"] for name in "abc")
    assert numpy.array_equal(a, b)
    assert numpy.abs(a - c).max() > 0.05
    info = rackfocus("info", "kept/passes.exr", cwd=tmp_path).stdout
    assert "rackfocus:lensRadius" in info and "0.15" in info


def test_kept_passes_may_show_what_is_beyond_the_border(rackfocus, tmp_path):
    """Their data window is larger than the picture; what is made of them is the same."""
    (tmp_path / "s.pov").write_text(SCENE)
    for n in (1, 2):
        rackfocus("povray", "s.pov", "-o", "a.exr", "--keep", "kept", "--overscan", 7,
                  "--supersample", n, "--", *SIZE, cwd=tmp_path)  # fmt: skip
        rackfocus("filter", "kept/passes.exr", "-o", "b.exr", cwd=tmp_path)
        a, b = (read_exr(tmp_path / f"{name}.exr")["R"] for name in "ab")
        assert a.shape == (120, 160) and b.shape == (n * 134, n * 174)
        b = b[n * 7 : -n * 7, n * 7 : -n * 7].astype(float)
        mean = b.reshape(120, n, 160, n).mean((1, 3))
        assert a == pytest.approx(mean, abs=1e-3 if n > 1 else 0)


def test_the_lens_can_be_chosen(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(SCENE)
    for options in (["--focus-distance", "5"], ["--focal-point", "0,1,0"],
                    ["--aperture", "0.6"], ["--lens-radius", "0.15"], []):  # fmt: skip
        rackfocus(
            "povray", "s.pov", "-o", "o.exr", *options, "--", *SMALL, cwd=tmp_path
        )
        picture = read_exr(tmp_path / "o.exr")["G"]
        if options == ["--focus-distance", "5"]:
            first = picture
        assert numpy.abs(picture - first).max() < 1e-3, options
    rackfocus(
        "povray", "s.pov", "-o", "o.exr", "--aperture", "2", "--", *SMALL, cwd=tmp_path
    )
    assert numpy.abs(read_exr(tmp_path / "o.exr")["G"] - first).max() > 0.05


def test_frames(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(SCENE)
    rackfocus("povray", "s.pov", "-o", "o_##.png", "--frames", "9-10", "--", *SIZE,
              cwd=tmp_path)  # fmt: skip
    assert sorted(p.name for p in tmp_path.glob("*.png")) == ["o_09.png", "o_10.png"]
    done = rackfocus("povray", "s.pov", "-o", "o.exr", "--frames", "1-2", "--", *SIZE,
                     cwd=tmp_path)  # fmt: skip
    names = sorted(p.name for p in tmp_path.glob("*.exr"))
    assert names == ["o0001.exr", "o0002.exr"]
    # The clock runs from 0 to 1 and moves the camera towards the focus.
    assert "focus distance 5," in done.stdout and "focus distance 4," in done.stdout


@pytest.mark.parametrize(
    "name", ["-dash.pov", "two words.pov", "q'uo\"te.pov", "ünï.pov"]
)
def test_names(rackfocus, tmp_path, name):
    folder = tmp_path / "a 'fol\"der"
    folder.mkdir()
    (folder / name).write_text(SCENE + '#include "part.inc"\n')
    (folder / "part.inc").write_text("sphere { <1, 0.3, -2>, 0.3 pigment { rgb 1 } }")
    # Its includes are found beside the scene, wherever one stands.
    rackfocus(
        "povray", f"{folder.name}/{name}", "-o", "o.png", "--", *SIZE, cwd=tmp_path
    )
    rackfocus("povray", "-o", "o.exr", "--camera", "./" + name, cwd=folder)


def test_the_ending_may_be_missing(rackfocus, tmp_path):
    (tmp_path / "base.pov").write_text(SCENE)
    rackfocus("povray", "base", "-o", "o.exr", "--", *SIZE, cwd=tmp_path)


#: 0.3 px wide, in focus before a far wall.
WIRES = """#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0,0,-10> look_at 0 angle 40 right x*4/3 aperture 0.5 focal_point 0
         blur_samples 300, 300 variance 0 confidence 0.9999 }
#for (I, -12, 12)
    cylinder { <I*0.3-0.5,-4,0.02*I>,<I*0.3+0.5,4,-0.02*I>,0.0068
               pigment { rgb 0 } finish { ambient 0 diffuse 0 } }
#end
plane { -z,-60 pigment { checker rgb <1,0.9,0.7> rgb <0.5,0.7,1> scale 5 }
        finish { ambient 1 diffuse 0 } }
"""


def rgb(path):
    channels = read_exr(path)
    pixels = numpy.stack([channels[name] for name in "RGB"], -1)
    return numpy.clip(pixels.astype(float), 0, 1) ** (1 / 2.2)


def test_thin_things_in_focus_stay(rackfocus, tmp_path):
    """Against POV-Ray's own focal blur of the unmodified scene."""
    (tmp_path / "s.pov").write_text(WIRES)
    subprocess.run(["povray", "+Is.pov", "+Ohost.exr", "+FE", "-D", "-A", *SIZE],
                   cwd=tmp_path, check=True, capture_output=True)  # fmt: skip
    host = rgb(tmp_path / "host.exr")
    scores = {}
    for name, options in {
        "pinhole": ["--aperture", 1e-9, "--focus-distance", 10],
        "one sample": ["--supersample", 1],
        "default": [],
        "two": ["--supersample", 2],
    }.items():
        rackfocus("povray", "s.pov", "-o", "o.exr", *options, "--", *SIZE, cwd=tmp_path)
        difference = rgb(tmp_path / "o.exr") - host
        scores[name] = -10 * numpy.log10((difference**2).mean())
    print(scores)
    assert scores["default"] > max(
        30, scores["pinhole"] + 1.5, scores["one sample"] + 3
    )
    assert scores["default"] > scores["two"] > 30


LAMP_OUTSIDE = """#version 3.7; global_settings { assumed_gamma 1 }
camera { location 0 direction z*2 right x*4/3 up y aperture 1 focal_point <0,0,4> }
sphere { <-14,0,40>,0.5 pigment { rgb 3 } finish { ambient 1 diffuse 0 } }"""


def light_of_lamp_outside(rackfocus, folder, *options):
    (folder / "s.pov").write_text(LAMP_OUTSIDE)
    rackfocus("povray", "s.pov", "-o", "o.exr", *options, "--", *SIZE, cwd=folder)
    return read_exr(folder / "o.exr")["G"].sum()


def test_the_lens_sees_beyond_the_border(rackfocus, tmp_path):
    """A lamp just outside, far out of focus: its light reaches into the picture."""
    assert light_of_lamp_outside(rackfocus, tmp_path, "--overscan", 0) == 0
    assert light_of_lamp_outside(rackfocus, tmp_path) > 1


@pytest.mark.parametrize(
    "look",
    [
        ["--tilt-x", 20],
        ["--field-curvature", -2],
        ["--split-diopter", 0.4, "--split-angle", 180],
    ],
)
def test_a_bent_surface_in_focus_sees_further(rackfocus, tmp_path, look):
    """The plane in focus makes a border of 3 px, and the lamp's blur is wider."""
    look = ["--aperture", 0.1, *look]
    narrow = light_of_lamp_outside(rackfocus, tmp_path, *look, "--overscan", 3)
    assert light_of_lamp_outside(rackfocus, tmp_path, *look) > narrow + 1


@pytest.mark.parametrize("views", [[], ["--views", 2, "--aperture", 0.1]])
def test_a_border_wider_than_the_picture(rackfocus, tmp_path, views):
    """4000 px around one of 160 x 120 took many minutes, of which nothing was seen."""
    (tmp_path / "s.pov").write_text(SCENE)
    words = ["povray", "s.pov", "-o", "o.exr", *views, "--overscan"]
    done = rackfocus(*words, 161, "--", *SIZE, cwd=tmp_path, code=1)
    assert "--overscan: 161 px are more than the picture's longer side" in done.stderr
    assert not (tmp_path / "o.exr").exists()


def test_sizes_that_a_scene_asks_for(rackfocus, tmp_path):
    """image_width is that of the picture, though the passes are larger."""
    (tmp_path / "part.inc").write_text(
        "box { <-image_width/160,-image_height/120,0>,<0,0,0.1> pigment { rgb 1 } "
        "finish { ambient 1 diffuse 0 } }"
    )
    (tmp_path / "s.pov").write_text(
        "#version 3.7; global_settings { assumed_gamma 1 }\n"
        "camera { location -5*z look_at 0 aperture 0.001 focal_point 0 "
        "right x*image_width/image_height }\n"
        '#include "part.inc"\n'
        "box { 0,<image_width/160,image_height/120,0.1> pigment { rgb 1 } "
        "finish { ambient 1 diffuse 0 } }\n"
    )
    pictures = []
    for options in (["--supersample", 1, "--overscan", 0], ["--overscan", 9]):
        rackfocus("povray", "s.pov", "-o", "o.exr", *options, "--", *SIZE, cwd=tmp_path)
        pictures.append(read_exr(tmp_path / "o.exr")["G"])
    assert numpy.abs(pictures[0] - pictures[1]).max() < 0.4


def test_alpha(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(SCENE.replace("plane", "// "))
    rackfocus("povray", "s.pov", "-o", "o.exr", "--", *SIZE, "+UA", cwd=tmp_path)
    alpha = read_exr(tmp_path / "o.exr")["A"]
    assert alpha.min() == 0 and alpha.max() == pytest.approx(1, abs=0.05)
    assert ((alpha > 0.1) & (alpha < 0.9)).any()


@pytest.mark.parametrize(
    "options, n_samples",
    [
        ([], 3),
        (["-A"], 3),
        (["+A0.1", "Antialias=off"], 3),
        (["off.ini"], 3),
        (["on.ini"], 3),
        (["off.ini", "+A"], 1),
        (["Antialias=On"], 1),
        (["Antialias_Threshold=0.1"], 1),
    ],
)
def test_no_antialiasing_is_no_wish_for_few_samples(
    rackfocus, tmp_path, options, n_samples
):
    """What POV-Ray shall not do is done by the samples of the passes."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "off.ini").write_text("Antialias=Off\nAntialias_Threshold=0.3\n")
    (tmp_path / "on.ini").write_text("Antialias=On\nAntialias_Depth=2\nJitter=Off\n")
    words = ["povray", "s.pov", "-o"]
    rackfocus(*words, "a.exr", "--", *SIZE, *options, cwd=tmp_path)
    rackfocus(*words, "b.exr", "--supersample", n_samples, "--", *SIZE, *options,
              cwd=tmp_path)  # fmt: skip
    a, b = (read_exr(tmp_path / f"{name}.exr")["G"] for name in "ab")
    assert numpy.array_equal(a, b)


@pytest.mark.parametrize(
    "arguments, code, words",
    [
        (["missing.pov", "-o", "o.exr"], 1, "missing.pov: No such file"),
        (["no_camera.pov", "-o", "o.exr"], 1, "no camera; give a lens for POV-Ray's"),
        (
            ["no_camera.pov", "-o", "o.exr", "--aperture=0.5"],
            1,
            "with --aperture and --focal-point, or write a camera into the scene",
        ),
        (["macro.pov"], 2, "needs an output"),
        (["macro.pov", "-o", "o.txt"], 2, "end the name in .exr or .png"),
        (["macro.pov", "-o", "o.exr", "--focal-point", "1,2"], 2, "three numbers"),
        (["macro.pov", "-o", "o.exr", "--frames", "5-1"], 2, "--frames: "),
        (
            ["macro.pov", "-o", "o.exr", "--focus-distance=6", "--focal-point=0,1,0"],
            2,
            "both say what is in focus; leave one out",
        ),
        (
            ["macro.pov", "-o", "o.exr", "--aperture=0.5", "--lens-radius=0.3"],
            2,
            "--aperture and --lens-radius both say how wide",
        ),
        (
            ["macro.pov", "-o", "o.exr", "--aperture=0.5", "--f-stop=2"],
            2,
            "--aperture and --f-stop both say how wide",
        ),
        (["macro.pov", "-o", "o.exr", "--aperture=0"], 1, "0 blurs nothing"),
        (["macro.pov", "-o", "o.exr", "--lens-radius=0"], 1, "0 blurs nothing"),
        (["made.pov", "-o", "o.exr"], 1, "--aperture and --focal-point, or, where the"),
        (
            ["made.pov", "-o", "o.exr", "--aperture=0.4", "--focal-point=0,1,-1"],
            1,
            "makes its camera while it is parsed",
        ),
        (["bokeh.pov", "-o", "o.exr"], 1, "bokeh { }, the light over its lens"),
        (
            ["macro.pov", "-o", "o.exr", "--", "+SC10"],
            1,
            "+SC10: a part of the picture",
        ),
        (["macro.pov", "-o", "o.exr", "--", "End_Row=0.5"], 1, "crop the result"),
        (["missing.ini", "-o", "o.exr"], 1, "missing.ini: no such file"),
        (["missing.ini[a]", "-o", "o.exr"], 1, "missing.ini: no such file"),
        (["sections.ini[b]", "-o", "o.exr"], 1, "sections.ini[b]: the file has no"),
        (["macro.pov", "-o", "missing/o.exr"], 1, "missing/o.exr"),
        (
            ["macro.pov", "-o", "o.exr", "--", "+W80", "--aperture", "1"],
            1,
            "--aperture: options of rackfocus go before --",
        ),
    ],
)
def test_bad_usage(rackfocus, arguments, code, words):
    text = rackfocus("povray", *arguments, code=code).stderr
    assert words in text, text


def test_a_scene_that_fails_leaves_no_empty_folder(rackfocus, tmp_path):
    (tmp_path / "bad.pov").write_text("camera { location x aperture 1 ) ")
    rackfocus(
        "povray", "bad.pov", "-o", "o.exr", "--keep", "kept", code=1, cwd=tmp_path
    )
    assert [path.name for path in tmp_path.iterdir()] == ["bad.pov"]


@pytest.mark.parametrize(
    "options, words",
    [
        ("+W80 W160", "'W160' is no option of POV-Ray"),
        ("small w160", "'w160' is no option of POV-Ray"),
        ("lost.ini", "names the initialisation file lost.ini, which is not there"),
        ("macro", "'macro' is no option"),  # a scene has its ending
        ("lost.ini[a]", "names the initialisation file lost.ini, which is not there"),
        ("macro.pov small.ini[a] +Wx", "POV-Ray cannot read one of its options, or"),
        ("+Wx", "POV-Ray cannot read one of its options, or"),
    ],
)
def test_options_that_povray_cannot_read(rackfocus, tmp_path, options, words):
    """POV-Ray repeats its command line, which is ours with private folders."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "small.ini").write_text("+W32 +H24")
    found = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *options.split(),
                      cwd=tmp_path, code=1)  # fmt: skip
    assert f"s.pov: {words}" in found.stderr and "/tmp" not in found.stderr


@pytest.mark.parametrize(
    "options, words",
    [
        ([], "the scene's camera has no aperture; give one with --aperture"),
        (["--aperture=0.5"], "the camera has neither focal_point nor look_at to"),
    ],
)
def test_what_a_camera_lacks(rackfocus, tmp_path, options, words):
    (tmp_path / "s.pov").write_text("camera { location z*-5 } sphere { 0, 1 }")
    found = rackfocus("povray", "s.pov", "-o", "o.exr", *options, cwd=tmp_path, code=1)
    assert words in found.stderr


@pytest.mark.parametrize(
    "options, words",
    [
        ("+W0 +H10", "0x10 px, which is too small; give +W and +H, each from 2"),
        ("+W10 +H0", "10x0 px, which is too small"),
        ("+W-5 +H10", "-5x10 px, which is too small"),
        ("+W1 +H2", "1x2 px, which is too small"),
        ("Width=0.5 Height=9", "0x9 px, which is too small"),
        ("small.ini", "160x0 px, which is too small"),
        ("+W70000 +H70000", "70000x70000 px, which is too large"),
    ],
)
def test_sizes_that_are_none(rackfocus, tmp_path, options, words):
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "small.ini").write_text("Height = 0 ; px\n")
    (tmp_path / "povray.ini").write_text("; nothing, so that POV-Ray's own size counts")
    found = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *options.split(),
                      cwd=tmp_path, code=1)  # fmt: skip
    assert f"s.pov: the picture would be {words}" in found.stderr


@pytest.mark.parametrize("options", ["+W2 +H2", "+W9 +WL0 +H2", "+W0 +W3 +H2"])
def test_the_smallest_pictures(rackfocus, tmp_path, options):
    (tmp_path / "s.pov").write_text(SCENE)
    words = ["povray", "s.pov", "-o", "o.exr", "--", *options.split()]
    rackfocus(*words, cwd=tmp_path)
    size = {"+W2": (2, 2), "+W9": (2, 9), "+W0": (2, 3)}[options.split()[0]]
    assert read_exr(tmp_path / "o.exr")["R"].shape == size


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--reference-output", "lens.exr"], "needs --reference"),
        (["--reference", "9", "--reference-output", "lens.png"], "ends with .exr"),
    ],
)
def test_where_the_reference_cannot_be_kept(rackfocus, tmp_path, options, word):
    (tmp_path / "s.pov").write_text(SCENE)
    found = rackfocus("povray", "s.pov", "-o", "o.exr", *options, cwd=tmp_path, code=2)
    assert word in found.stderr and not (tmp_path / "o.exr").exists()


def test_no_reference_for_orthographic(rackfocus, tmp_path):
    """Said before the render: it came behind the finished picture, after minutes."""
    words = ("povray", "orthographic.pov", "--reference", "10")
    done = rackfocus(*words, "-o", tmp_path / "o.exr", "--", *SIZE, code=1)
    assert "no working focal blur for orthographic" in done.stderr
    assert not (tmp_path / "o.exr").exists() and "POV-Ray's" not in done.stdout
    rackfocus(*words, "--camera", "--", *SIZE)


def test_povray_missing(rackfocus):
    text = rackfocus(
        "povray", "macro.pov", "-o", "o.exr", code=1, PATH="/nowhere"
    ).stderr
    assert "povray was not found; install" in text


def test_another_povray(rackfocus, tmp_path):
    """--povray names the program, which need not be on the PATH."""
    words = ("povray", "macro.pov", "-o", "o.exr", "--povray")
    text = rackfocus(*words, "elsewhere/povray", code=1).stderr
    assert "elsewhere/povray: there is no such program" in text
    program, said = tmp_path / "my povray", tmp_path / "said"
    program.write_text(
        f"#!/bin/sh\ntouch '{said}'\nexec {shutil.which('povray')} \"$@\"\n"
    )
    program.chmod(0o755)
    rackfocus(*words, program, "--", *SIZE, PATH="/usr/bin:/bin")
    assert said.exists()
    program.write_text("#!/bin/sh\nexit 1\n")
    text = rackfocus(*words, program, code=1).stderr
    assert "made no picture and said nothing" in text


@pytest.mark.parametrize("options", [[], ["--", *SIZE]])
def test_a_povray_without_openexr(rackfocus, tmp_path, options):
    """As it is built where the OpenEXR that is there is not the one it looks for."""
    program = tmp_path / "povray"
    program.write_text(
        """#!/bin/sh
case " $* " in *" +FE "*) ;; *) exit 0 ;; esac
printf '\\nProblem with option setting\\n%s\\n' "$0 $*" >&2
echo Failed to parse command-line option >&2
exit 1
"""
    )
    program.chmod(0o755)
    text = rackfocus("povray", "macro.pov", "-o", tmp_path / "o.exr", "--povray",
                     program, *options, code=1).stderr  # fmt: skip
    assert f"if '{program} --version' does not list openexr" in text


def test_interruption_leaves_nothing(binary, tmp_path):
    scene = SCENE.replace(
        "pigment { checker rgb 0.9 rgb 0.3 }",
        "pigment { rgb 1 } normal { bumps 1 } finish { reflection 0.9 }",
    )
    (tmp_path / "s.pov").write_text(scene)
    private = tmp_path / "private"
    private.mkdir()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        job = subprocess.Popen(
            [binary, "povray", "s.pov", "-o", "o.exr", "--", "+W1600", "+H1200",
             "+A0.0", "+R9"],
            cwd=tmp_path, env={**os.environ, "TMPDIR": str(private)},
            # Ignored where these tests run under nohup.
            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
        )  # fmt: skip
        try:
            # POV-Ray, which says what it does in its log, has work for minutes.
            while not list(private.glob("*/*/log")) and job.poll() is None:
                time.sleep(0.02)
            job.send_signal(number)
            assert job.wait(60) == 128 + number
        finally:
            job.kill()
        assert list(private.iterdir()) == []
        assert not (tmp_path / "o.exr").exists()


def run_with_faults(binary, folder, *, is_deaf=False, **faults):
    """A small job with calls that fail (tests/faults/failing.c); the finished process,
    and the numbers of allocations and file calls, of the command.
    """
    library = os.path.join(os.environ["RACKFOCUS_BUILD"], "tests/faults/libfailing.so")
    count, private = folder / "count", folder / "private"
    private.mkdir(exist_ok=True)
    (folder / "s.pov").write_text(SCENE)
    environment = {name: str(int(k)) for name, k in faults.items()}
    command = [binary, *"povray s.pov -o o.exr -q -- +W32 +H24 -A".split()]
    with subprocess.Popen(
        command, cwd=folder, text=True, errors="replace",
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(private), "LD_PRELOAD": library,
             "FAIL_COUNT": str(count), **environment},
        preexec_fn=lambda: signal.signal(
            signal.SIGHUP, signal.SIG_IGN if is_deaf else signal.SIG_DFL),
    ) as process:  # fmt: skip
        try:
            texts = process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            process.terminate()  # as a user does
            assert "FAIL_ALLOCATION" in faults, faults
            texts = process.communicate(timeout=90)
    done = subprocess.CompletedProcess(command, process.returncode, *texts)
    assert list(private.iterdir()) == [], (faults, done.stderr)
    n_allocations, _, n_files, _ = map(int, count.read_text().split())
    return done, n_allocations, n_files


def test_no_memory_leaves_nothing(binary, tmp_path):
    """Allocations fail, in the command and in POV-Ray's processes.

    Without memory for the last of its threads POV-Ray waits for ever: it is ended then. It has
    two or three such places of 26 in its renders, by the order of its threads.
    """
    done, n, _ = run_with_faults(binary, tmp_path)
    assert done.returncode == 0, done.stderr
    codes = []
    for k in range(1, n, n // 25):
        done, *_ = run_with_faults(binary, tmp_path, FAIL_ALLOCATION=k)
        assert done.returncode in (0, 1, 127, 143)
        assert done.returncode in (0, 143) or done.stderr
        codes.append(done.returncode)
    assert codes.count(1) > 10 and codes.count(143) < 6, codes


def test_signals_leave_nothing(binary, tmp_path):
    """Before every file call, in the command and in POV-Ray's processes."""
    _, _, n = run_with_faults(binary, tmp_path)
    codes = set()
    for k in range(1, n + 1, 2):
        (tmp_path / "o.exr").unlink(missing_ok=True)
        done, *_ = run_with_faults(
            binary, tmp_path, FAIL_FILE=k, FAIL_SIGNAL=signal.SIGTERM
        )
        # POV-Ray ended by the signal is a failure that is reported.
        assert done.returncode in (0, 1, 143, -signal.SIGTERM), done.stderr
        assert (tmp_path / "o.exr").exists() == (done.returncode == 0)
        codes.add(done.returncode)
    assert 143 in codes


def test_nohup(binary, tmp_path):
    """A lost terminal ends the work, but not where the caller asked for that."""
    _, _, n = run_with_faults(binary, tmp_path)
    ends = {True: set(), False: set()}
    for k in (n // 4, n // 2, 3 * n // 4):
        for is_deaf, codes in ends.items():
            done, *_ = run_with_faults(
                binary, tmp_path, is_deaf=is_deaf, FAIL_FILE=k, FAIL_SIGNAL=1
            )
            codes.add(done.returncode)
    assert 129 in ends[False] and ends[True] == {0}


#: Counts its own renders, and moves its camera by them; what it wrote it includes.
COUNTING = """#version 3.7;
#declare N = 0;
#if (file_exists("count.txt"))
    #fopen F "count.txt" read
    #while (defined(F)) #read (F, V) #declare N = N + V; #end
#end
#fopen F "count.txt" append
#write (F, "1,\\n")
#fclose F
#fopen G "made.inc" write
#write (G, "sphere { <0.3, 0.8, -2.5>, 0.2 pigment { rgb 1 } }\\n")
#fclose G
#include "made.inc"
#include "strings.inc"
Parse_String("#declare R = 1;")
global_settings { assumed_gamma 1.0 }
camera { location <0, 1, -5 - N> look_at <0, 1, 0> aperture 0.6 focal_point <0, 1, 0> }
sphere { <0, 1, 0>, R pigment { checker rgb 1 rgb 0.2 scale 0.2 } }
light_source { <3, 9, -7> rgb 1 }
"""


@pytest.mark.parametrize(
    "options", [[], ["--views", "3"], ["--method", "accumulate", "--views", "3"]]
)
def test_what_a_scene_writes_is_written_once(rackfocus, tmp_path, options):
    """As by one render of POV-Ray itself; the others see what that one saw."""
    (tmp_path / "s.pov").write_text(COUNTING)
    (tmp_path / "count.txt").write_text("1,\n")
    said = rackfocus("povray", "s.pov", "--camera", cwd=tmp_path).stdout
    focus = re.search(r"focus_distance (\S+)", said).group(1)
    assert (tmp_path / "count.txt").read_text() == "1,\n"
    assert not (tmp_path / "made.inc").exists()
    done = rackfocus("povray", "s.pov", "-o", "o.exr", *options, "--", *SIZE,
                     cwd=tmp_path)  # fmt: skip
    assert (tmp_path / "count.txt").read_text() == "1,\n" * 2
    assert (tmp_path / "made.inc").exists()
    assert done.stderr.count("writes files (#fopen)") == 1
    assert f"focus distance {focus}," in done.stdout


#: A height field that a macro of POV-Ray's includes makes.
FIELD = """#version 3.7;
#include "shapes.inc"
#declare Name = "{0}";
HF_Square(function {{ x * y }}, 0, 0, <4, 4>, 1, {1}, <-1, 0, 0>, <1, 1, 1>)
#if (strlen(Name)) object {{ #include Name pigment {{ rgb 1 }} }} #end
global_settings {{ assumed_gamma 1.0 }}
camera {{ location <0, 1, -5> look_at <0, 1, 0> aperture 0.6 focal_point <0, 1, 0> }}
light_source {{ <3, 9, -7> rgb 1 }}
"""


@pytest.mark.parametrize("name", ["field.inc", ""])
@pytest.mark.parametrize("argument", ['"{0}"', "Name"])
def test_what_a_macro_of_povray_writes(rackfocus, tmp_path, name, argument):
    """Renders side by side would read each other's halves."""
    scene = FIELD.format(name, argument.format(name))
    if not name:
        scene = scene.replace("HF_Square", "object { HF_Square").replace(
            "<1, 1, 1>)", "<1, 1, 1>) pigment { rgb 1 } }"
        )
    (tmp_path / "s.pov").write_text(scene)
    done = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *SIZE, cwd=tmp_path)
    assert done.stderr.count("writes files (#fopen)") == bool(name)
    assert (tmp_path / "field.inc").exists() == bool(name)


def test_large_pictures_leave_no_file_of_povray(rackfocus, tmp_path):
    """POV-Ray keeps large ones in a file, which it cannot remove once it is killed."""
    (tmp_path / "s.pov").write_text(SCENE)
    usual = tmp_path / "usual"
    usual.mkdir()
    rackfocus("povray", "s.pov", "-o", "o.exr", "--views", "2", "--",
              "+W640", "+H480", "Max_Image_Buffer_Memory=1", cwd=tmp_path,
              POV_TEMP_DIR=str(usual))  # fmt: skip
    assert list(usual.iterdir()) == []


def test_folders_of_killed_jobs_are_cleared(rackfocus, binary, tmp_path):
    """Not those of jobs that still run, nor what is not ours."""
    (tmp_path / "s.pov").write_text(SCENE)
    private = tmp_path / "private"
    other = private / "rackfocus-other"
    other.mkdir(parents=True)
    slow = [binary, "povray", "s.pov", "-o", "p.exr", "--", "+W3200", "+H2400", "+A0.0"]
    jobs = []
    for _ in range(2):
        jobs.append(subprocess.Popen([*slow, "+R9"], cwd=tmp_path,
                                     env={**os.environ, "TMPDIR": str(private)}))  # fmt: skip
        while len({log.parent.parent for log in private.glob("*/*/log")}) < len(jobs):
            time.sleep(0.02)
    try:
        jobs[0].kill()
        jobs[0].wait()
        before = set(private.iterdir())
        assert len(before) == 3
        subprocess.run([binary, "povray", "s.pov", "--camera", "--", *SIZE], check=True,
                       cwd=tmp_path, env={**os.environ, "TMPDIR": str(private)},
                       capture_output=True)  # fmt: skip
        left = set(private.iterdir())
        assert len(before - left) == 1 and other in left
        assert jobs[1].poll() is None
    finally:
        jobs[1].terminate()
        jobs[1].wait()
    assert list(private.iterdir()) == [other]


# ---- no room -----------------------------------------------------------------------


@pytest.fixture
def small_disk(tmp_path):
    """A file system whose room the test sets, for POV-Ray's files."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=8k", "tmpfs", str(folder)]
    if not folder.is_relative_to("/tmp") or shutil.which("mount") is None:
        pytest.skip("POV-Ray writes to folders within /tmp alone")
    if subprocess.run(command, capture_output=True).returncode:
        pytest.skip("mounting needs root")
    yield folder
    subprocess.run(["umount", "-l", folder], check=False)


def test_povray_has_no_room(rackfocus, tmp_path, small_disk):
    """POV-Ray says that it cannot access its data, of no file, many times."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "o.exr").write_bytes(b"old")
    for n_kib in (8, 120, 600):  # in the folder, in the probe, in a render
        size = f"remount,size={n_kib}k"
        subprocess.run(["mount", "-o", size, str(small_disk)], check=True)
        done = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *SIZE, cwd=tmp_path,
                         code=1, TMPDIR=str(small_disk))  # fmt: skip
        assert f"{small_disk}" in done.stderr and "rackfocus-" not in done.stderr
        assert "pace" in done.stderr and "free some space there" in done.stderr
        assert "Cannot access" not in done.stderr
        assert (tmp_path / "o.exr").read_bytes() == b"old"
        assert not any(small_disk.iterdir())


def test_what_a_scene_writes_is_whole_or_the_old(rackfocus, tmp_path, small_disk):
    """Data of before, of a page of the disk, which has two: the scene is the other."""
    (small_disk / "s.pov").write_text(COUNTING)
    (small_disk / "count.txt").write_text("0,\n" * 1365)
    done = rackfocus("povray", "s.pov", "-o", tmp_path / "o.exr", "--", *SIZE,
                     cwd=small_disk, code=1)  # fmt: skip
    assert "count.txt: No space left" in done.stderr
    assert "free some space there" in done.stderr
    assert (small_disk / "count.txt").read_text() == "0,\n" * 1365
    assert sorted(os.listdir(small_disk)) == ["count.txt", "s.pov"]
