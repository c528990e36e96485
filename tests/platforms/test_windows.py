# SPDX-License-Identifier: Apache-2.0
"""Windows x64: built by mingw-w64, run under wine. The programs of the unit, kernel and
behaviour suites pass, the pictures have the bits of Linux at every CPU level, and the wheel serves
a Windows Python. Wine is not Windows: what it shows is that the code is right.
"""

import re
import sys

import pytest
from systems import (
    BEHAVIOUR,
    BEHAVIOUR_BY_WINE,
    BUILD,
    LEVELS,
    LIBRARIES,
    PROGRAMS,
    PYTHONS,
    ROOT,
    get_python,
    has_level,
    make_python3,
    program_path,
    run,
    unpack,
)

import wheels

HERE = ROOT / "tests" / "platforms"


@pytest.mark.parametrize("name", [*PROGRAMS, *sorted(BEHAVIOUR)])
def test_program_passes(name, windows, wine):
    for tests in BEHAVIOUR_BY_WINE.get(name, ("",)):
        said = wine(windows / f"{program_path(name)}.exe", tests)
        assert re.search(r"^ok ", said, re.M), said
        assert not re.search(r"^not ok ", said, re.M), said


@pytest.mark.parametrize("level", LEVELS)
def test_same_bits_as_linux(level, windows, wine):
    if not has_level(level):
        pytest.skip(f"this processor has no {level}")
    native = run(BUILD / "tests" / "behaviour" / "scene_hash", 2, level)
    said = wine(windows / "tests" / "behaviour" / "scene_hash.exe", 2, level)
    assert len(native.splitlines()) >= 70
    assert said.splitlines() == native.splitlines()


def test_extension_needs_only_windows_and_python(windows):
    said = run("objdump", "-p", windows / "plugin" / "_core.pyd")
    found = {name.lower() for name in re.findall(r"DLL Name: (\S+)", said)}
    assert "python3.dll" in found
    assert found - {"python3.dll"} <= LIBRARIES


@pytest.fixture(scope="session")
def dist(windows, tmp_path_factory):
    """The packages for Windows."""
    folder = tmp_path_factory.mktemp("dist")
    package = ROOT / "blender_addon/package.py"
    run(sys.executable, package, windows, folder, "windows-x64")
    return folder


@pytest.fixture(scope="session", params=PYTHONS)
def python(request):
    """(version, folder of python.exe) of a Python of Windows with NumPy."""
    home = get_python(request.param, "windows-x86_64", "win_amd64")
    if request.param == "3.11":
        make_python3(home)
    return request.param, home


def test_packages_in_a_windows_python(python, dist, native, wine, tmp_path):
    """The wheel that pip takes for that Python, and the add-on's zip, which has the
    modules of both."""
    version, home = python
    tag = wheels.PYTHON_TAGS[version]
    unpack(next(dist.glob(f"rackfocus-*-{tag}-win_amd64.whl")), tmp_path / "wheel")
    unpack(next(dist.glob("*-addon.zip")), tmp_path / "zip")
    for folder in (tmp_path / "wheel", tmp_path / "zip" / "rack_focus" / "bundled"):
        where = (folder, home / "packages")
        said = wine(home / "python.exe", HERE / "use_wheel.py", *where)
        assert said.split() == native
    assert native[0] != "generic" or not has_level("sse4")
