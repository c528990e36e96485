# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the zips of the add-on. Not part of them.

    package.py BUILD_FOLDER DIST_FOLDER [windows-x64]

rack_focus-VERSION-addon.zip       Blender 3.4 to 4.1, the Python package inside
rack_focus-VERSION-extension.zip   Blender 4.2 and later, the Python package as a wheel

With windows-x64, from a build for Windows:

rackfocus-VERSION-cp311-abi3-win_amd64.whl         for Python 3.11 and later
rack_focus-VERSION-windows-x64-extension.zip       Blender 4.2 and later

The same sources give the same bytes.
"""

import base64
import hashlib
import re
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ADDON = ROOT / "blender_addon"
LICENCES = [
    ROOT / "LICENSES" / f"{name}.txt" for name in ("GPL-3.0-or-later", "Apache-2.0")
]
MACHINE = "x86_64"
LINUX, WINDOWS = "linux-x64", "windows-x64"


def version():
    """Version of the project, from meson.build."""
    text = (ROOT / "meson.build").read_text()
    return re.search(r"^\s*version: '([^']+)'", text, re.M)[1]


def write_zip(path, files):
    """Writes {name in the zip: bytes} with fixed times and order."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, files[name])


# ---- the Python package -----------------------------------------------------------


def package_files(build, platform):
    """{name: bytes} of the package rackfocus with its binaries."""
    sources = ROOT / "plugin" / "rackfocus"
    kinds = (".py", ".pyi", ".typed")
    files = {
        f"rackfocus/{path.name}": path.read_bytes()
        for path in sources.iterdir()
        if path.suffix in kinds and path.name != "__main__.py"
    }
    if platform == WINDOWS:
        files["rackfocus/_core.pyd"] = (build / "plugin" / "_core.pyd").read_bytes()
        return files
    extension = build / "plugin" / "_core.abi3.so"
    files["rackfocus/_core.abi3.so"] = extension.read_bytes()
    return files


def glibc_tag(files):
    """manylinux tag for the newest glibc symbol that the binaries need."""
    needed = (2, 17)
    for name, data in files.items():
        if ".so" in name:
            for major, minor in re.findall(rb"GLIBC_(\d+)\.(\d+)", data):
                needed = max(needed, (int(major), int(minor)))
    return f"manylinux_{needed[0]}_{needed[1]}_{MACHINE}"


def make_wheel(folder, files, platform):
    """Writes the wheel into `folder`; returns its name."""
    tag = f"cp311-abi3-{'win_amd64' if platform == WINDOWS else glibc_tag(files)}"
    info = f"rackfocus-{version()}.dist-info"
    files = dict(files)
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: rackfocus\nVersion: {version()}\n"
        "Summary: Depth of field after the render\nLicense: Apache-2.0\n"
        "Requires-Python: >=3.11\n"
    ).encode()
    files[f"{info}/WHEEL"] = (
        "Wheel-Version: 1.0\nGenerator: rack focus\nRoot-Is-Purelib: false\n"
        f"Tag: {tag}\n"
    ).encode()
    lines = []
    for name in sorted(files):
        digest = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest())
        lines.append(f"{name},sha256={digest.decode().rstrip('=')},{len(files[name])}")
    lines.append(f"{info}/RECORD,,\n")
    files[f"{info}/RECORD"] = "\n".join(lines).encode()
    name = f"rackfocus-{version()}-{tag}.whl"
    write_zip(folder / name, files)
    return name


# ---- the add-on -------------------------------------------------------------------


def addon_files():
    """{name: bytes} of the add-on's own sources and the licences."""
    files = {
        path.name: path.read_bytes()
        for path in ADDON.glob("*.py")
        if path.name != Path(__file__).name
    }
    files.update((f"LICENSES/{path.name}", path.read_bytes()) for path in LICENCES)
    return files


def check_versions():
    """bl_info and manifest carry the project's version."""
    numbers = tuple(int(part) for part in version().split("."))
    info = (ADDON / "__init__.py").read_text()
    manifest = (ADDON / "blender_manifest.toml").read_text()
    if f'"version": {numbers}' not in info:
        sys.exit(f"blender_addon/__init__.py: bl_info is not of version {version()}")
    if f'\nversion = "{version()}"' not in manifest:
        sys.exit(f"blender_manifest.toml: not of version {version()}")


def make_addon(dist, package):
    """The zip for Blender 3.4; returns its path."""
    files = {f"rack_focus/{name}": data for name, data in addon_files().items()}
    head = b"# SPDX-License-Identifier: GPL-3.0-or-later\n"
    files["rack_focus/bundled/__init__.py"] = head
    for name, data in package.items():
        files[f"rack_focus/bundled/{name}"] = data
    path = dist / f"rack_focus-{version()}-addon.zip"
    write_zip(path, files)
    return path


def make_extension(dist, package, platform):
    """The zip for Blender 4.2 and later; returns its path."""
    wheel = make_wheel(dist, package, platform)
    manifest = (ADDON / "blender_manifest.toml").read_text()
    lists = f'platforms = ["{platform}"]\nwheels = ["./wheels/{wheel}"]\n'
    manifest = manifest.replace("\n[permissions]", f"{lists}\n[permissions]", 1)
    files = addon_files()
    files["blender_manifest.toml"] = manifest.encode()
    files[f"wheels/{wheel}"] = (dist / wheel).read_bytes()
    part = "" if platform == LINUX else f"{platform}-"
    path = dist / f"rack_focus-{version()}-{part}extension.zip"
    write_zip(path, files)
    if platform == LINUX:
        (dist / wheel).unlink()
    return path


def main():
    """Builds those of one platform."""
    build, dist = Path(sys.argv[1]), Path(sys.argv[2])
    platform = sys.argv[3] if len(sys.argv) > 3 else LINUX
    if platform not in (LINUX, WINDOWS):
        sys.exit(f"package.py: no platform {platform}; there are {LINUX}, {WINDOWS}")
    check_versions()
    dist.mkdir(parents=True, exist_ok=True)
    package = package_files(build, platform)
    if platform == LINUX:
        print(make_addon(dist, package))
    print(make_extension(dist, package, platform))


if __name__ == "__main__":
    main()
