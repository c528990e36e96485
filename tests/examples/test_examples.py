# SPDX-License-Identifier: Apache-2.0
"""The programs of examples/ build against what is installed, and do what they say."""

import numpy
import pytest


def read_pfm(path):
    """A PFM picture as an array, the upper row first."""
    with open(path, "rb") as file:
        assert file.readline() == b"PF\n"
        width, height = map(int, file.readline().split())
        assert float(file.readline()) == -1
        pixels = numpy.frombuffer(file.read(), "<f4")
    return pixels.reshape(height, width, 3)[::-1]


@pytest.fixture
def build(run, root, tmp_path):
    """Compiles an example as its README says; returns the program."""

    def compile_example(name):
        flags = run("pkg-config", "--cflags", "--libs", "rackfocus").split()
        source = root / "examples" / f"{name}.c"
        warnings = ["-std=c11", "-Wall", "-Wextra", "-Werror"]
        run("cc", *warnings, source, "-o", name, *flags, "-lm")
        return tmp_path / name

    return compile_example


def test_every_example_is_tested(root):
    here = (root / "tests/examples/test_examples.py").read_text()
    names = [p.stem for p in (root / "examples").iterdir() if p.suffix in (".c", ".py")]
    assert len(names) >= 4
    for name in names:
        assert f"def test_{name}" in here


def test_filter_buffer(build, run, tmp_path):
    run(build("filter_buffer"), "out.pfm")
    out = read_pfm(tmp_path / "out.pfm")
    assert out.shape == (200, 320, 3)
    disc, wall = out[80:120, 140:180], out[10:50, 10:50]
    assert numpy.allclose(disc, [0.9, 0.5, 0.2], atol=1e-5)  # in focus: untouched
    steps = numpy.abs(numpy.diff(wall, axis=0))
    assert steps.max() < 0.2  # the checks, 0.1 and 0.8, are blurred
    assert 0.43 < wall.mean() < 0.47


def test_filter_window_has_the_bits_of_the_whole(build, run, tmp_path):
    program = build("filter_window")
    size = ("1200", "800")
    said = run(program, "window.pfm", *size, 500, 300, 90, 70)
    run(program, "whole.pfm", *size, 0, 0, *size)
    window, whole = read_pfm(tmp_path / "window.pfm"), read_pfm(tmp_path / "whole.pfm")
    assert numpy.array_equal(window, whole[300:370, 500:590])
    assert whole.std() > 0.1
    width, height = int(said.split()[0]), int(said.split()[2])
    assert width * height < 1200 * 800 / 2  # only a part was loaded


def test_filter_views_sees_behind(build, run, tmp_path):
    program = build("filter_views")
    run(program, "out.pfm", "8")
    out = read_pfm(tmp_path / "out.pfm")
    wall = out[0:60, 0:60]
    assert {round(float(v), 4) for v in numpy.unique(wall)} == {0.1, 0.8}  # in focus
    # Half way over the rim of the disc the wall shines through with its checks.
    ring = out[95:105, 160 + 30 - 6 : 160 + 30 + 6, 0]
    assert ring.std() > 0.05
    assert numpy.isfinite(out).all()


def test_filter_file(run, root, tmp_path):
    source = root / "tests/quality/references/posts_pinhole.exr"
    program = root / "examples/filter_file.py"
    run("/usr/bin/python3", program, source, "out.exr", 1, 0.03125, 666.6667)
    run("rackfocus", "filter", source, "-o", "command.exr")
    said = run("rackfocus", "compare", "out.exr", "command.exr")
    assert float(said.split()[-2]) > 60
    reference = root / "tests/quality/references/posts_reference.exr"
    assert float(run("rackfocus", "compare", "out.exr", reference).split()[-2]) > 34
