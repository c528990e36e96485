# SPDX-License-Identifier: Apache-2.0
"""The command, the library and the Python package, as a user has them installed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """Folder in which everything was installed; the files lie under its prefix."""
    # Other suites use the build meanwhile: ./dev test has configured it.
    if not (BUILD / "plugin" / "_core.abi3.so").exists():
        subprocess.run(["meson", "configure", BUILD, "-Dpython=enabled"], check=True)
    subprocess.run(["ninja", "-C", BUILD], check=True, capture_output=True)
    folder = tmp_path_factory.mktemp("installed")
    command = ["meson", "install", "-C", BUILD, "--no-rebuild", "--destdir", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder


def only(folder, pattern):
    found = sorted(folder.rglob(pattern))
    assert len(found) == 1, f"{pattern} in {folder}: {found}"
    return found[0]


@pytest.fixture(scope="session")
def environment(installed, tmp_path_factory):
    """Environment variables that make what was installed be found."""
    library = only(installed, "pkgconfig/rackfocus.pc").parents[1]
    return {
        **os.environ,
        "XDG_CONFIG_HOME": str(tmp_path_factory.mktemp("config")),
        "PATH": f"{only(installed, 'bin/rackfocus').parent}:{os.environ['PATH']}",
        "PKG_CONFIG_PATH": str(library / "pkgconfig"),
        "PKG_CONFIG_SYSROOT_DIR": str(installed),
        "LD_LIBRARY_PATH": str(library),
        "PYTHONPATH": str(only(installed, "rackfocus/__init__.py").parents[1]),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHON": sys.executable,
    }


@pytest.fixture
def run(environment, tmp_path):
    """Runs a command in the test's folder, which must succeed; returns its output."""

    def call(*command, **options):
        done = subprocess.run(
            [*map(str, command)],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=environment,
            **options,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    return call


@pytest.fixture
def root():
    """Root of the repository."""
    return ROOT
