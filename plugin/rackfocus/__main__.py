# SPDX-License-Identifier: Apache-2.0
"""python -m rackfocus: the rackfocus command that was built with this package."""

import os
import shutil
import sys
from pathlib import Path


def find_command():
    """Path of the command: in the package, else on PATH; None where there is none."""
    bundled = Path(__file__).with_name("rackfocus-command")
    if bundled.exists():
        return str(bundled)
    return shutil.which("rackfocus")


def main():
    """Replaces this process with the command."""
    command = find_command()
    if command is None:
        sys.exit("rackfocus: this package was built without the command")
    os.execv(command, ["rackfocus", *sys.argv[1:]])


if __name__ == "__main__":
    main()
