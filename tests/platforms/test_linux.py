# SPDX-License-Identifier: Apache-2.0
"""Linux from glibc 2.28 on, x86-64 and arm64: the programs of the unit and kernel suites
pass, pictures have the bits of this machine's build at every level, and what is packaged
runs with the C library of Debian 11 (glibc 2.31). arm64 is run by qemu."""

import os
import re
import shutil
import sys

import pytest
from systems import (
    BEHAVIOUR_BY_QEMU,
    BUILD,
    LEVELS,
    PROGRAMS,
    PYTHONS,
    ROOT,
    UNIT_BY_QEMU,
    build,
    get_python,
    has_level,
    program_path,
    programs_for_tests,
    run,
    unpack,
)

import cross
import wheels

HERE = ROOT / "tests" / "platforms"
REFERENCES = ROOT / "tests" / "quality" / "references"
QEMU = ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"]
FLOOR = (2, 28)
SYSTEM = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1"}
SYSTEM |= {"ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}
PLATFORMS = ("linux-x64", "linux-arm64")


@pytest.fixture(scope="module")
def x64():
    """The build for older Linux."""
    return build(
        "linux-x64", [*cross.programs_of("linux-x64"), "tests/behaviour/scene_hash"]
    )


@pytest.fixture(scope="module")
def arm64():
    """The build for arm64, with the tests of the library."""
    return build(
        "linux-arm64",
        [*cross.programs_of("linux-arm64"), *programs_for_tests(BEHAVIOUR_BY_QEMU)],
    )


@pytest.mark.parametrize("name", [*PROGRAMS, *BEHAVIOUR_BY_QEMU])
def test_program_passes_on_arm64(name, arm64):
    for tests in {**BEHAVIOUR_BY_QEMU, **UNIT_BY_QEMU}.get(name, ("",)):
        said = run(*QEMU, arm64 / program_path(name), tests)
        assert re.search(r"^ok ", said, re.M), said
        assert not re.search(r"^not ok ", said, re.M), said


def hashes(*command):
    lines = run(*command).splitlines()
    assert len(lines) >= 70
    return lines


def test_same_bits_on_arm64(arm64):
    """With NEON, which every such processor has; that the plain loops there have the same
    bits is what test_kernels says."""
    program = "tests/behaviour/scene_hash"
    native = hashes(BUILD / program, 2, "generic")
    assert hashes(*QEMU, arm64 / program, 2, "neon") == native


@pytest.mark.parametrize("level", LEVELS)
def test_same_bits_by_zig(level, x64):
    if not has_level(level):
        pytest.skip(f"this processor has no {level}")
    native = hashes(BUILD / "tests" / "behaviour" / "scene_hash", 2, "generic")
    assert hashes(x64 / "tests" / "behaviour" / "scene_hash", 2, level) == native


@pytest.mark.parametrize("platform", PLATFORMS)
def test_floor_of_glibc(platform, request):
    """No symbol is newer, and no library but the C library's is asked for."""
    folder = request.getfixturevalue(platform.split("-")[1])
    for name in cross.programs_of(platform):
        said = run("objdump", "-p", folder / name)
        newest = {
            tuple(map(int, found)) for found in re.findall(r"GLIBC_(\d+)\.(\d+)", said)
        }
        assert newest and max(newest) <= FLOOR, name
        assert set(re.findall(r"NEEDED +(\S+)", said)) <= SYSTEM, name


# ---- with the C library of Debian 11 ----------------------------------------------


@pytest.fixture(scope="session")
def old_libc():
    """Folder with Debian 11's C library for both processors, unpacked."""
    folder = BUILD / "debian11"
    if not (folder / "done").exists():
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "lists" / "partial").mkdir(parents=True)
        key = "/usr/share/keyrings/debian-archive-keyring.gpg"
        (folder / "sources.list").write_text(
            f"deb [signed-by={key} arch=amd64,arm64] "
            "http://deb.debian.org/debian bullseye main\n"
        )
        apt = ["apt-get", "-q"]
        for option in (
            f"Dir::Etc::SourceList={folder}/sources.list",
            "Dir::Etc::SourceParts=-",
            f"Dir::State::Lists={folder}/lists",
            "Dir::State::status=/dev/null",
            f"Dir::Cache={folder}",
            "APT::Sandbox::User=",
            "APT::Architectures::=amd64",
            "APT::Architectures::=arm64",
        ):
            apt += ["-o", option]
        run(*apt, "update")
        packages = [
            f"{name}:{processor}"
            for name in ("libc6", "libgcc-s1", "libcrypt1", "zlib1g")
            for processor in ("amd64", "arm64")
        ]
        run(*apt, "download", *packages, cwd=folder)
        for path in folder.glob("*.deb"):
            run("dpkg", "-x", path, folder / path.stem.rsplit("_", 1)[1])
        (folder / "done").touch()
    return folder


def with_old_libc(folder, program, also=""):
    """A command that runs a program of this processor with that C library, and with the
    libraries of another folder."""
    libraries = folder / "amd64" / "lib" / "x86_64-linux-gnu"
    return [libraries / "ld-2.31.so", "--library-path", f"{libraries}:{also}", program]


@pytest.mark.parametrize("platform", PLATFORMS)
def test_command_with_an_old_libc(platform, request, old_libc, tmp_path):
    folder = request.getfixturevalue(platform.split("-")[1])
    program = folder / "cli" / "rackfocus"
    if platform == "linux-x64":
        command = with_old_libc(old_libc, program)
    else:
        command = ["qemu-aarch64-static", "-L", old_libc / "arm64", program]
    lens = ("--focus-distance", 3, "--lens-radius", 0.02)
    source, ours, theirs = REFERENCES / "portrait_pinhole.exr", "ours.exr", "theirs.exr"
    run(*command, "filter", "-q", source, "-o", ours, *lens, cwd=tmp_path)
    native = BUILD / "cli" / "rackfocus"
    run(native, "filter", "-q", source, "-o", theirs, *lens, cwd=tmp_path)
    said = run(native, "compare", "--json", ours, theirs, cwd=tmp_path)
    assert '"identical": true' in said


@pytest.mark.parametrize("version", PYTHONS)
def test_wheel_in_a_python_with_an_old_libc(version, x64, old_libc, native, tmp_path):
    """The module finds the best level there, and gives this machine's bits."""
    home = get_python(version, "linux-x86_64", "manylinux2014_x86_64")
    run(sys.executable, ROOT / "blender_addon/package.py", x64, tmp_path, "linux-x64")
    tag = wheels.PYTHON_TAGS[version]
    unpack(next(tmp_path.glob(f"*-{tag}-manylinux_2_28*")), tmp_path / "packages")
    python = with_old_libc(old_libc, home / "bin" / f"python{version}", home)
    where = (tmp_path / "packages", home / "packages")
    environment = dict(os.environ, PYTHONHOME=str(home))
    said = run(*python, HERE / "use_wheel.py", *where, env=environment)
    assert said.split() == native
    assert native[0] != "generic" or not has_level("sse4")


def test_wheel_in_a_python_on_arm64(arm64, old_libc, native, tmp_path):
    """The module uses NEON, and gives this machine's bits."""
    home = get_python("3.11", "linux-arm64", "manylinux2014_aarch64")
    package = ROOT / "blender_addon/package.py"
    run(sys.executable, package, arm64, tmp_path, "linux-arm64")
    unpack(next(tmp_path.glob("*-cp311-*manylinux_2_28*")), tmp_path / "packages")
    where = (tmp_path / "packages", home / "packages")
    environment = dict(os.environ, PYTHONHOME=str(home), LD_LIBRARY_PATH=str(home))
    said = run(
        *("qemu-aarch64-static", "-L", old_libc / "arm64"),
        *(home / "bin" / "python3.11", HERE / "use_wheel.py", *where),
        env=environment,
    )
    assert said.split() == ["neon", native[1]]
