# SPDX-License-Identifier: Apache-2.0
"""Lays zlib and libpng out as subprojects of meson, for systems without a package.

Usage: get.py

Their sources are those of Debian's packages, with its fixes of security, fetched by apt
into a folder of its own: neither root nor a change of the system's lists is needed. Does
nothing where subprojects/ has them.
"""

import pathlib
import shutil
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SUBPROJECTS = HERE.parents[1] / "subprojects"
# Package of Debian, folder of the subproject.
PACKAGES = {"zlib": "zlib", "libpng1.6": "libpng"}
SOURCES = (
    "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] "
    "http://deb.debian.org/debian bookworm main\n"
)


def fetch(folder):
    """Debian's sources of all packages, unpacked in `folder`."""
    (folder / "lists" / "partial").mkdir(parents=True)
    (folder / "sources.list").write_text(SOURCES)
    apt = ["apt-get", "-q", "-q"]
    for name, value in {
        "Dir::Etc::SourceList": folder / "sources.list",
        "Dir::Etc::SourceParts": "-",
        "Dir::State::Lists": folder / "lists",
        "APT::Sandbox::User": "",
    }.items():
        apt += ["-o", f"{name}={value}"]
    subprocess.run([*apt, "update"], check=True)
    subprocess.run([*apt, "source", *PACKAGES], check=True, cwd=folder)


def main():
    """Lays out what is not there, and our files beside it."""
    if not all((SUBPROJECTS / name / "README").exists() for name in PACKAGES.values()):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            fetch(folder)
            for package, name in PACKAGES.items():
                found = next(p for p in folder.glob(f"{package}-*") if p.is_dir())
                shutil.rmtree(SUBPROJECTS / name, ignore_errors=True)
                shutil.copytree(found, SUBPROJECTS / name, symlinks=True)
    for name in PACKAGES.values():
        own = (HERE / f"{name}.build").read_bytes()
        there = SUBPROJECTS / name / "meson.build"
        if not there.exists() or there.read_bytes() != own:
            there.write_bytes(own)


main()
