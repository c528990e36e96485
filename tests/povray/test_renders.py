# SPDX-License-Identifier: Apache-2.0
"""All renders of a picture are of the same scene: its time."""

import numpy
from conftest import SIZE, read_exr

#: The ball is somewhere else at each thousandth of a second.
MOVING = """#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 0, -5> look_at 0 aperture 0.2 focal_point 0 }
#declare R = seed(mod(now, 1) * 86400000);
sphere { <3 * rand(R) - 1.5, 2 * rand(R) - 1, 0>, 0.4 pigment { rgb 1 } finish { ambient 1 } }
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


def test_views_of_several_runs_and_the_time(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(MOVING)
    views = ["povray", "s.pov", "-o", "o.exr", "--views", "3", "--keep", "kept"]
    done = rackfocus(*views, "--", *SIZE, cwd=tmp_path)
    assert "time" not in done.stderr
    done = rackfocus(*views, "--anew", "--only-views", "0", "--", *SIZE, cwd=tmp_path)
    assert "reads the time (now)" in done.stderr
