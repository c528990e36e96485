# SPDX-License-Identifier: Apache-2.0
"""Lays OpenEXR's sources out as a subproject of meson, for systems without a package.

Usage: get.py [FOLDER]

FOLDER is subprojects/openexr of this tree where it is left out. OpenEXR comes from its
source package on PyPI, by pip, and is checked against the sum below; half.h is that of
Debian's libimath-dev. Does nothing where FOLDER is there and of this version.
"""

import hashlib
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile

VERSION = "3.4.17"
SHA256 = "a05594811a727b0cb874c25d13121869d1b7c105d55b19d2b7ba0ab33949e216"
IMATH = pathlib.Path("/usr/include/Imath")
HERE = pathlib.Path(__file__).resolve().parent
OWN = [p for p in HERE.iterdir() if p.suffix in (".build", ".c", ".h")]


def download(folder):
    """The source package, checked, in `folder`."""
    subprocess.run(
        [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        + ["--disable-pip-version-check", "--no-binary", "openexr"]
        + ["--dest", folder, f"openexr=={VERSION}"],
        check=True,
    )
    path = pathlib.Path(folder, f"openexr-{VERSION}.tar.gz")
    found = hashlib.sha256(path.read_bytes()).hexdigest()
    if found != SHA256:
        sys.exit(
            f"get.py: {path.name} is not the package that is known: its SHA-256 is {found}"
        )
    return path


def lay_out(package, folder):
    """Unpacks the C library and what it needs, and puts our files beside it."""
    wanted = ("src/lib/OpenEXRCore/", "external/deflate/", "LICENSE.md")
    with tarfile.open(package) as archive:
        for member in archive.getmembers():
            name = member.name.partition("/")[2]
            if member.isfile() and name.startswith(wanted):
                target = folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(archive.extractfile(member).read())
    headers = folder / "imath"
    headers.mkdir()
    for path in IMATH.glob("*.h"):
        shutil.copy(path, headers)


def main():
    folder = HERE.parents[1] / "subprojects" / "openexr"
    if len(sys.argv) > 1:
        folder = pathlib.Path(sys.argv[1])
    mark = folder / "version"
    if not mark.exists() or mark.read_text() != VERSION:
        if not (IMATH / "half.h").exists():
            sys.exit(f"get.py: {IMATH}/half.h is not there; install libimath-dev")
        shutil.rmtree(folder, ignore_errors=True)
        with tempfile.TemporaryDirectory() as scratch:
            lay_out(download(scratch), folder)
        mark.write_text(VERSION)
    for path in OWN:
        there = folder / path.name
        if not there.exists() or there.read_bytes() != path.read_bytes():
            shutil.copy(path, there)


main()
