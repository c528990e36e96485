# SPDX-License-Identifier: Apache-2.0
"""python -m rackfocus: the rackfocus command that was built with this package."""

import os
import shutil
import subprocess
import sys
from pathlib import Path


def find_command():
    """Path of the command: in the package, else on PATH; None where there is none."""
    for name in ("rackfocus-command", "rackfocus-command.exe"):
        bundled = Path(__file__).with_name(name)
        if bundled.exists():
            return str(bundled)
    return shutil.which("rackfocus")


def main():
    """Replaces this process with the command; Windows can only wait for it."""
    command = find_command()
    if command is None:
        sys.exit("rackfocus: this package was built without the command")
    if os.name == "nt":
        sys.exit(subprocess.call([command, *sys.argv[1:]]))
    os.execv(command, ["rackfocus", *sys.argv[1:]])


if __name__ == "__main__":
    main()
