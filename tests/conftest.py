# SPDX-License-Identifier: Apache-2.0
"""What suites that run the command share."""

import os
import subprocess

import pytest


@pytest.fixture(scope="session")
def binary():
    """Path of the built command."""
    path = os.environ.get("RACKFOCUS")
    assert path and os.path.exists(path), "set RACKFOCUS to the built command"
    return os.path.abspath(path)


@pytest.fixture
def rackfocus(binary):
    """Runs the command; checks the exit code; returns the finished process."""

    def run(*arguments, code=0, **options):
        command = [binary, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, **options)
        assert done.returncode == code, f"{command}\n{done.stdout}\n{done.stderr}"
        return done

    return run
