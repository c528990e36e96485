# SPDX-License-Identifier: Apache-2.0
"""The types of the package: as the table of parameters, and as the extension is."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from conftest import BUILD

WRONG = """
import rackfocus

rackfocus.apply(b"", b"", focus_distance=2.0, blads=3)
rackfocus.Filter(3, 4, method="layred")
rackfocus.Lens(3, 4, blades="6")
rackfocus.Context(thread=3)
"""
RIGHT = """
import rackfocus

context = rackfocus.Context(threads=2, log=print)
rackfocus.apply(b"", b"", focus_distance=2, depth="radial", context=context)
rackfocus.Filter(3, 4, method="layered", blades=6, distribution_image=b"")
rackfocus.Filter(3, 4).process_views([rackfocus.View(b"", b"")], b"")
"""


def test_the_types_are_those_of_the_table(root):
    made = subprocess.run(
        [sys.executable, root / "plugin" / "make_types.py"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    kept = (root / "plugin" / "rackfocus" / "_params.py").read_text()
    assert made.stdout == kept, "run plugin/make_types.py > plugin/rackfocus/_params.py"


@pytest.fixture(scope="module")
def mypy(tmp_path_factory):
    """Python of an environment with mypy; Debian's is too old for typed keywords."""
    folder = tmp_path_factory.mktemp("mypy")
    made = subprocess.run(
        f"'{sys.executable}' -m venv '{folder}' && '{folder}/bin/pip' install -q 'mypy>=1.8'",
        shell=True, capture_output=True, text=True,
    )  # fmt: skip
    if made.returncode:
        pytest.skip(f"mypy cannot be installed: {made.stderr[-200:]}")
    return folder / "bin" / "python"


@pytest.fixture
def package(root, build, tmp_path):
    folder = tmp_path / "rackfocus"
    folder.mkdir()
    sources = root / "plugin" / "rackfocus"
    for name in [*sources.glob("*.py"), *sources.glob("*.pyi"), sources / "py.typed"]:
        shutil.copy(name, folder)
    shutil.copy(build / "plugin" / "_core.abi3.so", folder)
    return tmp_path


def run(mypy, package, *arguments):
    return subprocess.run(
        [mypy, "-m", *arguments],
        cwd=package,
        env={**os.environ, "PYTHONPATH": str(package), "MYPYPATH": str(package)},
        capture_output=True,
        text=True,
    )


def test_the_stubs_are_as_the_extension(mypy, package):
    done = run(mypy, package, "mypy.stubtest", "--concise", "rackfocus")
    assert done.returncode == 0, done.stdout + done.stderr


def test_misspelt_keywords_are_found_before_the_program_runs(mypy, package):
    (package / "wrong.py").write_text(WRONG)
    done = run(mypy, package, "mypy", "--strict", "wrong.py")
    for line in (4, 5, 6, 7):
        assert f"wrong.py:{line}: error" in done.stdout, done.stdout
    (package / "right.py").write_text(RIGHT)
    done = run(mypy, package, "mypy", "--strict", "right.py")
    assert done.returncode == 0, done.stdout


def test_windows_has_what_is_called(root):
    """The import library for Windows is made of a list of names: all are in it."""
    said = subprocess.run(
        [
            "nm",
            "-D",
            "--undefined-only",
            pathlib.Path(BUILD, "plugin", "_core.abi3.so"),
        ],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    called = set(re.findall(r" (_?Py\w+)", said))
    text = (root / "packaging/python/windows/python3.def").read_text()
    listed = set(re.findall(r"^    (_?Py\w+)", text, re.M))
    assert called, "nothing was found"
    assert listed == called, listed ^ called
