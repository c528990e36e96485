# SPDX-License-Identifier: Apache-2.0
"""What tests ask the machine that they run on."""

import subprocess
import sys


def mirror():
    """The mirror that this Debian has its packages from."""
    targets = ("--format", "$(SITE)", "Identifier: Packages")
    command = ["apt-get", "indextargets", *targets]
    sites = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return next(site for site in sites.split() if "security" not in site)


def peak_of(command, *arguments):
    """(peak memory in MiB, exit code, what it said on stderr) of a command.

    A process begins with the peak of the one that starts it, so a small one does.
    """
    script = (
        "import resource, subprocess, sys\n"
        "done = subprocess.run(sys.argv[1:], capture_output=True, text=True)\n"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024)\n"
        "print(done.returncode, done.stderr)\n"
    )
    measured = [sys.executable, "-c", script, command, *map(str, arguments)]
    done = subprocess.run(measured, capture_output=True, text=True, timeout=120)
    first, rest = done.stdout.split("\n", 1)
    code, said = rest.split(" ", 1)
    return int(first), int(code), said
