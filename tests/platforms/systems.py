# SPDX-License-Identifier: Apache-2.0
"""What the tests of other systems share."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
WINE = "/usr/lib/wine/wine64"  # Debian's package wine64 has it there
# Of tests/os, for Windows, and which of their tests: wine makes no links.
OS_PROGRAMS = {"thread": "", "process_windows": "", "folder": "only_folders"}
LEVELS = ("generic", "sse4", "avx2", "avx512")

sys.path.insert(0, str(ROOT / "packaging"))


def run(*command, **options):
    """What the program prints; it must end well."""
    done = subprocess.run(
        [str(word) for word in command],
        text=True,
        encoding="utf-8",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        **options,
    )
    assert done.returncode == 0, f"{command}: {done.returncode}\n{done.stdout[-3000:]}"
    return done.stdout


def names(suite):
    """Programs of a suite, by their sources."""
    return sorted(path.stem for path in (ROOT / "tests" / suite).glob("test_*.c"))


def programs_for_tests(ending=""):
    """Programs of the library's suites."""
    found = [
        f"tests/{suite}/{name}"
        for suite in ("unit", "kernels")
        for name in names(suite)
    ]
    return [f"{name}{ending}" for name in [*found, "tests/behaviour/scene_hash"]]


def has_level(name):
    """Does this processor have it?"""
    flags = set(Path("/proc/cpuinfo").read_text().split())
    needs = {"sse4": {"sse4_1"}, "avx2": {"avx2"}, "avx512": {"avx512f", "avx512vl"}}
    return needs.get(name, set()) <= flags


def unpack(archive, folder):
    """All of a zip."""
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder)
