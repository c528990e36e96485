# SPDX-License-Identifier: Apache-2.0
"""--strict: what would be a warning is an error, and no picture is written."""

import pytest
from conftest import SIZE
from test_run import COUNTING, SCENE

# A lamp that is seen, brighter than a half float can say, in a few pixels.
LAMP = SCENE + "sphere { <-1, 2, 1>, 0.2 pigment { rgb 1 } finish { emission 1e6 } }\n"


@pytest.mark.parametrize(
    "scene, options, expected",
    [
        (COUNTING, [], "s.pov: the scene writes files (#fopen)"),
        (LAMP, [], "px of the colour are brighter than 65504"),
        (LAMP, ["--views", "2"], "px of the colour are brighter than 65504"),
        (LAMP, ["--method", "accumulate", "--views", "2"], "brighter than 65504"),
        (SCENE, ["--box-repeats", "3"], "--box-repeats"),
    ],
    ids=["files", "lamp", "views", "mean", "useless"],
)
def test_a_warning_is_an_error(rackfocus, tmp_path, scene, options, expected):
    (tmp_path / "s.pov").write_text(scene)
    words = ["povray", "s.pov", "-o", "o.exr", *options]
    strict = rackfocus(*words, "--strict", "--", *SIZE, code=1, cwd=tmp_path)
    assert expected in strict.stderr and "warning" not in strict.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["s.pov"]
    plain = rackfocus(*words, "--", *SIZE, cwd=tmp_path)
    assert expected in plain.stderr and (tmp_path / "o.exr").exists()


def test_nothing_to_warn_of(rackfocus, tmp_path):
    (tmp_path / "s.pov").write_text(SCENE)
    words = ["povray", "s.pov", "-o", "o.exr", "--strict", "--", *SIZE]
    assert rackfocus(*words, cwd=tmp_path).stderr == ""
    assert (tmp_path / "o.exr").exists()
