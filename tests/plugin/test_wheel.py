# SPDX-License-Identifier: Apache-2.0
"""pip install: the wheel that meson-python makes, in an environment of its own."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))

pytestmark = pytest.mark.skipif(
    subprocess.run(
        [sys.executable, "-m", "venv", "--help"], capture_output=True
    ).returncode
    != 0,
    reason="python3-venv is missing",
)

USE = """
import rackfocus
colour = memoryview(bytearray(4 * 8 * 8 * 3)).cast("f", (8, 8, 3))
depth = memoryview(bytearray(4 * 8 * 8)).cast("f", (8, 8))
for y in range(8):
    for x in range(8):
        depth[y, x] = 1 + x
rackfocus.apply(colour, depth, colour, method="scatter", focus_distance=3)
print(rackfocus.__version__, len(rackfocus.parameters()))
"""
# What the wheel holds is asked for, not how fast it is: it is compiled as the build was
# where ccache has seen that, and else without optimization.
TOGETHER = """[built-in options]
unity = 'subprojects'
unity_size = 100
"""
QUICKLY = """optimization = '0'

[project options]
level = 'generic'
"""


def is_cached():
    """Did ccache see the build's files, by the names that they have for the wheel?"""
    rules = BUILD / "build.ninja"
    if not rules.exists() or BUILD.resolve().parent != ROOT:
        return False
    return bool(re.search("command = .*ccache", rules.read_text()))


@pytest.fixture(scope="module")
def python(tmp_path_factory, request):
    """Python of an environment with the wheel in it."""
    folder = tmp_path_factory.mktemp("wheel")
    root = request.config.rootpath
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    python = folder / "venv/bin/python"
    install = [python, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    # In a file: an older pip passes on one of several settings of the same name.
    options = folder / "options.ini"
    options.write_text(TOGETHER if is_cached() else TOGETHER + QUICKLY)
    setup = f"--config-settings=setup-args=--native-file={options}"
    subprocess.run([*install, setup, root], check=True)
    return python


def test_the_wheel_works_without_numpy(python):
    """Import, lists, filter."""
    done = subprocess.run(
        [python, "-c", USE], capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[0] == "0.1.0"


def test_it_holds_the_package_and_nothing_else(python):
    """No library, no header; typed."""
    listing = [python, "-m", "pip", "show", "-f", "rackfocus"]
    text = subprocess.run(listing, capture_output=True, text=True, check=True).stdout
    files = [line.strip() for line in text.split("Files:\n")[1].splitlines()]
    assert "rackfocus/_core.abi3.so" in files and "rackfocus/py.typed" in files
    allowed = ("rackfocus/", "rackfocus-", "../../../bin/rackfocus")
    assert all(file.startswith(allowed) for file in files), files


def test_the_module_is_the_command(python):
    """python -m rackfocus and the script run the command."""
    for command in ([python, "-m", "rackfocus"], [python.with_name("rackfocus")]):
        done = subprocess.run([*command, "--version"], capture_output=True, text=True)
        assert done.returncode == 0 and "0.1.0" in done.stdout, done.stderr
