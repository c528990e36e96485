# SPDX-License-Identifier: Apache-2.0
"""macOS: compiled and linked, and what its loader will look at is right. Nothing here can
run it."""

import re

import pytest
from systems import build, run

import cross

PLATFORMS = {"macos-arm64": "ARM64", "macos-x64": "X86_64"}


@pytest.fixture(scope="module", params=PLATFORMS)
def macos(request):
    """A platform and the folder of its build."""
    return request.param, build(request.param)


def test_load_commands(macos):
    """The processor, the kind of file, macOS 11, nothing but the system's library."""
    platform, folder = macos
    for name, kind in zip(cross.programs_of(platform), ("DYLIB", "EXECUTE")):
        said = run("llvm-objdump", "--macho", "--private-headers", folder / name)
        head = re.search(r"^MH_MAGIC_64 .*", said, re.M)[0].split()
        assert head[1] == PLATFORMS[platform] and head[4] == kind, head
        assert re.search(r"^ *minos 11\.0$", said, re.M), name
        loaded = re.findall(r"cmd LC_LOAD_DYLIB\n.*\n +name (\S+)", said)
        assert loaded == ["/usr/lib/libSystem.B.dylib"], name
        if platform == "macos-arm64":  # starts nothing that is not signed
            assert "LC_CODE_SIGNATURE" in said, name


def test_symbols(macos):
    """The module is there; what is missing is Python's or the system's library's."""
    platform, folder = macos
    module = folder / "plugin" / "_core.abi3.so"
    assert "_PyInit__core" in run("llvm-nm", "--defined-only", module)
    missing = run("llvm-nm", "--undefined-only", module).split()
    names = [name for name in missing if name.startswith("_")]
    assert len(names) > 50
    assert not [name for name in names if name.startswith(("_rf_", "_os_", "_GOMP"))]
