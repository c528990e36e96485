# SPDX-License-Identifier: Apache-2.0
"""--params: parameters from a text file."""

import numpy
import plainexr
import pytest


def made(rackfocus, scene, tmp_path, *options):
    out = tmp_path / "out.exr"
    rackfocus("filter", scene(), "-o", out, "--compression", "none", *options)
    return plainexr.read(out)


def is_same(a, b):
    return all(numpy.array_equal(a[0][name], b[0][name]) for name in "RGB")


def test_a_file_is_as_good_as_options(rackfocus, scene, tmp_path):
    params = tmp_path / "lens.params"
    params.write_text(
        "# a lens\n\nfocus-distance 3\nf-stop 9 # too small\nf-stop 0.1\nblades 5\n"
    )
    options = ["--focus-distance", "3", "--f-stop", "0.1", "--blades", "5"]
    by_file = made(rackfocus, scene, tmp_path, "--params", params)
    assert is_same(by_file, made(rackfocus, scene, tmp_path, *options))
    assert not is_same(by_file, made(rackfocus, scene, tmp_path))


def test_options_win(rackfocus, scene, tmp_path):
    params = tmp_path / "lens.params"
    params.write_text("focus-distance 3\nf-stop 0.1\n")
    options = ["--focus-distance", "12", "--f-stop", "0.1"]
    both = made(rackfocus, scene, tmp_path, "--params", params, options[0], "12")
    assert is_same(both, made(rackfocus, scene, tmp_path, *options))


@pytest.mark.parametrize(
    "line, part",
    [
        ("f-stopp 3", "'f-stopp' is not a parameter"),
        ("f-stop", "is not a parameter and its value"),
        ("f-stop much", "it is a number from"),
        ("method fast", "method"),
        ("f-stop -1", "f-stop"),
    ],
)
def test_bad_lines_are_named(rackfocus, scene, tmp_path, line, part):
    params = tmp_path / "lens.params"
    params.write_text(f"blades 6\n{line}\n")
    done = rackfocus(
        "filter", scene(), "-o", tmp_path / "out.exr", "--params", params, code=1
    )
    assert f"{params}:2: " in done.stderr and part in done.stderr, done.stderr
