# SPDX-License-Identifier: Apache-2.0
"""Packs the sources as they are in git.

Usage: source.py FOLDER

Writes FOLDER/rackfocus-VERSION.tar.gz: `pip install` takes it, and so does meson. What
is not in git stays out, and times are that of the last commit.
"""

import gzip
import subprocess
import sys
from pathlib import Path

from wheels import ROOT, metadata, version


# Pictures that only the tests read: 20 MB.
LEFT_OUT = ":(exclude)tests/quality/references"


def main():
    stem = f"rackfocus-{version()}"
    path = Path(sys.argv[1], f"{stem}.tar.gz")
    path.parent.mkdir(parents=True, exist_ok=True)
    info = path.parent / "PKG-INFO"
    info.write_text(metadata())
    try:
        archive = ["git", "archive", "--format=tar", f"--prefix={stem}/"]
        mtime = ["git", "log", "-1", "--format=%ct"]
        time = subprocess.run(mtime, cwd=ROOT, check=True, capture_output=True).stdout
        packed = subprocess.run(
            [*archive, f"--add-file={info}", "HEAD", ".", LEFT_OUT],
            cwd=ROOT,
            check=True,
            capture_output=True,
        ).stdout
    finally:
        info.unlink()
    with open(path, "wb") as file:
        with gzip.GzipFile("", "wb", 9, file, mtime=int(time)) as packer:
            packer.write(packed)
    print(path)


main()
