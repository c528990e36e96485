# SPDX-License-Identifier: Apache-2.0
"""All renders of a picture are of the same scene: time, header and kept light."""

import re
import subprocess

import numpy
import pytest
from conftest import SCENE, SIZE, read_exr

#: The ball is somewhere else at each thousandth of a second.
MOVING = """#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 0, -5> look_at 0 aperture 0.2 focal_point 0 }
#declare R = seed(mod(now, 1) * 86400000);
sphere { <3 * rand(R) - 1.5, 2 * rand(R) - 1, 0>, 0.4 pigment { rgb 1 } finish { ambient 1 } }
"""
#: Items of a header; a scene with fog has its depth by more renders.
CAMERA = "camera { location <0, 1, -5> look_at <0, 1, 0> aperture 0.4 focal_point y }\n"
REST = """#version 3.7;
global_settings { assumed_gamma 1.0 }
sphere { <0, 1, 0>, 1 pigment { checker rgb 1 rgb 0.2 scale 0.2 } }
plane { y, 0 pigment { checker rgb 0.9 rgb 0.3 } }
light_source { <3, 9, -7> rgb 1 }
"""
FOG = "fog { fog_type 1 distance 12 color rgb <0.4, 0.5, 0.6> }\n"
LIT = """#version 3.7;
global_settings { assumed_gamma 1.0 radiosity { count 20 error_bound 0.8 } }
camera { location <0, 1.5, -6> look_at <0, 1, 0> aperture 0.4 focal_point <0, 1, 0> }
sky_sphere { pigment { rgb 1 } }
sphere { <0, 1, 0>, 1 pigment { rgb <0.8, 0.3, 0.2> } }
plane { y, 0 pigment { rgb 0.7 } }
"""


def test_a_scene_that_reads_the_time(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(MOVING)
    rackfocus("povray", "s.pov", "-o", "o.exr", "--keep", "kept", "--", *SIZE,
              cwd=tmp_path)  # fmt: skip
    kept = read_exr(tmp_path / "kept" / "passes.exr")
    is_ball = kept["R"] > 0.9
    assert is_ball.sum() > 200
    assert numpy.isfinite(kept["Z"][is_ball]).all()
    assert not numpy.isfinite(kept["Z"][kept["R"] == 0]).any()


@pytest.mark.parametrize("name", ["s.pov", "two words.inc"])
def test_a_scene_that_asks_for_its_own_name(rackfocus, tmp_path, name):
    """Includes show what they are for where they are rendered themselves."""
    ball = "sphere { <0, 1, 0>, 1 pigment { rgb 1 } finish { ambient 1 } }\n"
    asked = f'#if (strcmp(input_file_name, "{name}") = 0)\n{ball}#end\n'
    (tmp_path / "asks.inc").write_text(asked)
    for inside in (asked, '#include "asks.inc"\n'):
        (tmp_path / name).write_text("#version 3.7;\n" + CAMERA + inside)
        rackfocus("povray", name, "-o", "o.exr", "--", *SIZE, cwd=tmp_path)
        assert read_exr(tmp_path / "o.exr")["G"].max() > 0.9


def test_views_of_several_runs_and_the_time(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(MOVING)
    views = ["povray", "s.pov", "-o", "o.exr", "--views", "3", "--keep", "kept"]
    done = rackfocus(*views, "--", *SIZE, cwd=tmp_path)
    assert "time" not in done.stderr
    done = rackfocus(*views, "--anew", "--only-views", "0", "--", *SIZE, cwd=tmp_path)
    assert "reads the time (now)" in done.stderr


def test_a_header_before_the_scene(rackfocus, tmp_path):
    """As if its lines stood in the scene: its camera is found, and its fog."""
    (tmp_path / "whole.pov").write_text(REST + CAMERA + FOG)
    (tmp_path / "rest.pov").write_text(REST)
    (tmp_path / "the head.inc").write_text(CAMERA + FOG)
    rackfocus("povray", "whole.pov", "-o", "whole.exr", "--", *SIZE, cwd=tmp_path)
    rackfocus("povray", "rest.pov", "-o", "rest.exr", "--", *SIZE,
              'Include_Header="the head.inc"', cwd=tmp_path)  # fmt: skip
    whole, rest = (read_exr(tmp_path / f"{name}.exr") for name in ("whole", "rest"))
    assert all(numpy.abs(whole[c] - rest[c]).max() < 2e-3 for c in "RGB")


def keep_light(folder, name):
    return ["Radiosity_To_File=on", "Radiosity_From_File=on",
            f"Radiosity_File_Name={folder / name}"]  # fmt: skip


def test_the_kept_light_of_radiosity(rackfocus, tmp_path):
    """It is the colour's, whole, and what is rendered with it is lit as without."""
    (tmp_path / "s.pov").write_text(LIT)
    picture = ["povray", "s.pov", "-o", "o.exr"]
    options = keep_light(tmp_path, "light.rad")
    rackfocus(*picture, "--", *SIZE, cwd=tmp_path)
    plain = read_exr(tmp_path / "o.exr")
    for _ in range(2):
        rackfocus(*picture, "--", *SIZE, *options, cwd=tmp_path)
        lit = read_exr(tmp_path / "o.exr")
        assert all(numpy.abs(plain[c] - lit[c]).mean() < 0.02 for c in "RGB")
    kept = (tmp_path / "light.rad").read_bytes()
    assert kept.endswith(b"\n") and len(kept) > 4096
    subprocess.run(
        ["povray", "+Is.pov", "+Opov.exr", "+FE", "-D", *SIZE, *options[1:]],
        cwd=tmp_path, check=True, capture_output=True
    )  # fmt: skip
    itself = read_exr(tmp_path / "pov.exr")
    assert all(abs(plain[c].mean() - itself[c].mean()) < 0.02 for c in "RGB")


def test_views_do_not_write_the_light_at_once(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(LIT)
    command = ["povray", "s.pov", "-o", "o.exr", "--views", "2", "--", *SIZE]
    options = keep_light(tmp_path, "light.rad")[::2]
    done = rackfocus(*command, *options, cwd=tmp_path)
    assert not (tmp_path / "light.rad").exists()
    assert "several views write no file; render one view" in done.stderr
    assert "write no file" not in rackfocus(*command, cwd=tmp_path).stderr


STARS = """#version 3.7;
#include "textures.inc"
global_settings { assumed_gamma 1.0 }
camera { location <0, 1, -5> look_at <0, 1, 0> angle 40 aperture 0.4 focal_point y }
light_source { <3, 9, -7> rgb 1 }
plane { z, 55 texture { Starfield } }
"""
CHECKS = """plane { y, 0 pigment { checker rgb 1 rgb 0 } }
sphere { <0, 1, 0>, 1 pigment { rgb 0 } finish { reflection 0.4 specular 1 } }
"""
IS_LOST = "anti-aliasing takes"


def test_stars_that_anti_aliasing_takes(rackfocus, tmp_path):
    """Told, and kept by what the warning says."""
    (tmp_path / "s.pov").write_text(STARS)
    mean = {}
    for name, options in (("many", []), ("one", ["-A"])):
        done = rackfocus("povray", "s.pov", "-o", "o.exr", "--reference", "60",
                         "--reference-output", "r.exr", "--", *SIZE, *options,
                         cwd=tmp_path)  # fmt: skip
        assert (IS_LOST in done.stderr and "-A after --" in done.stderr) == (
            name == "many"
        )
        picture, lens = (read_exr(tmp_path / f"{n}.exr")["G"] for n in "or")
        mean[name] = picture.mean() / lens.mean()
    assert mean["many"] < 0.8 and abs(mean["one"] - 1) < 0.03


def test_stars_are_told_once_of_views_and_frames(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(STARS)
    for more in (["--views", "2"], ["--frames", "1-2"]):
        done = rackfocus("povray", "s.pov", "-o", "o.exr", *more, "--", *SIZE,
                         cwd=tmp_path)  # fmt: skip
        assert done.stderr.count(IS_LOST) == 1


@pytest.mark.parametrize("gamma", ["2.2", "srgb"])
def test_edges_on_black_lose_no_light(rackfocus, tmp_path, gamma):
    """POV-Ray averages their rays in its own space, which is darker outside it."""
    stars = STARS.split("plane { z")[0].replace(
        "assumed_gamma 1.0", f"assumed_gamma {gamma}"
    )
    wire = "cylinder { <-3,I/8,0>, <3,I/8,0>, 0.006 pigment { rgb 1 } finish { ambient 1 } }"
    wires = f"#declare I=-16; #while (I<32) {wire} #declare I=I+1; #end\n"
    (tmp_path / "s.pov").write_text(stars + wires)
    done = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *SIZE, cwd=tmp_path)
    assert IS_LOST not in done.stderr


def test_checks_and_reflections_lose_no_light(rackfocus, tmp_path):
    stars, rest = STARS.split("plane { z")[0], CHECKS
    (tmp_path / "s.pov").write_text(stars + rest)
    done = rackfocus("povray", "s.pov", "-o", "o.exr", "--", *SIZE, cwd=tmp_path)
    assert IS_LOST not in done.stderr


@pytest.mark.parametrize(
    "head, aspect",
    [
        ("#declare image_width = 1920;\n#declare image_height=1080;", 16 / 9),
        ('#include "size.inc"', 16 / 9),
        ("#ifndef (image_width) #declare image_width = 3; #end", 4 / 3),
        ("#if (!defined(image_height)) #error \"none\" #end", 4 / 3),
        ("#declare W = image_width;\n#declare image_width = W;", 4 / 3),
    ],
)  # fmt: skip
def test_a_scene_may_have_an_image_width_of_its_own(rackfocus, tmp_path, head, aspect):
    """The words of its size that POV-Ray lets a scene declare anew, or ask for."""
    (tmp_path / "size.inc").write_text(
        "#declare image_width = 1920; #declare image_height = 1080;\n"
    )
    (tmp_path / "s.pov").write_text(SCENE.replace("camera {", f"{head}\ncamera {{"))
    said = rackfocus("povray", "s.pov", "--camera", "--", *SIZE, cwd=tmp_path).stdout
    right = re.search(r"right (\S+)", said).group(1)
    assert float(right) == pytest.approx(aspect, rel=1e-5)
    rackfocus("povray", "s.pov", "-o", "o.exr", "--supersample", "2", "--", *SIZE,
              cwd=tmp_path)  # fmt: skip
    assert read_exr(tmp_path / "o.exr")["R"].shape == (120, 160)
