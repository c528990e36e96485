# SPDX-License-Identifier: Apache-2.0
"""Builds for other systems and what runs their programs, once per session."""

import os
import shutil
import subprocess
import sys

import pytest
from systems import (
    BEHAVIOUR,
    BUILD,
    OS_PROGRAMS,
    ROOT,
    WINE,
    build,
    programs_for_tests,
    run,
)

import cross


@pytest.fixture(scope="session")
def windows():
    """The build for Windows: extension, command and the tests of the library."""
    ours = [f"tests/os/test_{name}.exe" for name in OS_PROGRAMS]
    targets = [
        *ours,
        *cross.programs_of("windows-x64"),
        *programs_for_tests(BEHAVIOUR, ".exe"),
    ]
    return build("windows-x64", targets)


@pytest.fixture(scope="session")
def wine_environment():
    """What wine wants, with a system of its own in the folder of the build.

    Wine's services share the output of the program that starts them, and hold its pipe open
    until they end: 4 s for each program that takes 0.1 s. One that waits, and prints nothing,
    keeps them alive.
    """
    environment = dict(
        os.environ, WINEPREFIX=str(BUILD / "wine"), WINEDEBUG="-all", HOME=str(BUILD)
    )
    if not (BUILD / "wine" / "system.reg").exists():
        run(WINE, "wineboot", "-i", env=environment)
        run(WINE, "winecfg", "-v", "win10", env=environment)
    nowhere = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    words = [WINE, "cmd", "/c", "pause"]
    about = {"env": environment, **nowhere}
    with subprocess.Popen(words, stdin=subprocess.PIPE, **about) as waiting:
        subprocess.run([WINE, "cmd", "/c", "exit"], check=True, **about)
        yield environment
        waiting.stdin.close()


@pytest.fixture(scope="session")
def wine(wine_environment):
    """Runs a program of Windows and gives what it prints. What wine says of its own
    services, which share the output, is left out: the program itself ended well."""

    def run_there(*command, **options):
        said = run(WINE, *command, env=wine_environment, timeout=300, **options)
        lines = said.splitlines(keepends=True)
        return "".join(line for line in lines if not line.startswith("wine: "))

    return run_there


@pytest.fixture(scope="session")
def native(tmp_path_factory):
    """What this machine's own package prints."""
    package = tmp_path_factory.mktemp("native") / "rackfocus"
    shutil.copytree(ROOT / "plugin" / "rackfocus", package)
    script = ROOT / "tests" / "platforms" / "use_wheel.py"
    shutil.copy(BUILD / "plugin" / "_core.abi3.so", package)
    return run(sys.executable, script, package.parent).split()
