# SPDX-License-Identifier: Apache-2.0
"""The built extension as an importable package."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))


def build_extension():
    """Path of the extension, built if the build folder was set up without it."""
    built = BUILD / "plugin" / "_core.abi3.so"
    if not (BUILD / "build.ninja").exists():
        subprocess.run(["meson", "setup", BUILD, ROOT, "-Dpython=enabled"], check=True)
    elif not built.exists():
        subprocess.run(["meson", "configure", BUILD, "-Dpython=enabled"], check=True)
    subprocess.run(["ninja", "-C", BUILD, "plugin/_core.abi3.so"], check=True)
    return built


def stage_package():
    """Folder with the package `rackfocus`: its sources and the built extension."""
    stage = BUILD / "plugin" / "stage" / "rackfocus"
    stage.mkdir(parents=True, exist_ok=True)
    sources = list((ROOT / "plugin" / "rackfocus").glob("*.py"))
    for source in [*sources, build_extension()]:
        link = stage / source.name
        link.unlink(missing_ok=True)
        link.symlink_to(source)
    return stage.parent


sys.path.insert(0, str(stage_package()))


@pytest.fixture
def root():
    """Root of the repository."""
    return ROOT


@pytest.fixture
def build():
    """The build folder."""
    return BUILD
