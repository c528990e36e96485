# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the zips of the add-on. Not part of them.

    package.py BUILD_FOLDER DIST_FOLDER [PLATFORM]

rack_focus-VERSION-addon.zip       Blender 3.4 to 4.1, the Python package inside
rack_focus-VERSION-extension.zip   Blender 4.2 and later, the Python package as a wheel

They are for Linux as it is here. With a PLATFORM of packaging/cross.py and the folder of
its build they bear its name, rack_focus-VERSION-PLATFORM-extension.zip, and the wheel,
with the command in it, lies beside them.

The same sources give the same bytes.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ADDON = ROOT / "blender_addon"
LICENCES = [
    ROOT / "LICENSES" / f"{name}.txt" for name in ("GPL-3.0-or-later", "Apache-2.0")
]
sys.path.append(str(ROOT / "packaging"))
import wheels  # noqa: E402
from wheels import version, write_zip  # noqa: E402

# Blender 3.4 for arm64 and for macOS was not tried. blender.org's 3.4 to 4.0 have Python
# 3.10, Debian's 3.4 and 4.1 have 3.11.
WITH_ADDON = ("linux-x64", "windows-x64")


def glibc_tag(files):
    """manylinux tag for the newest glibc symbol that the binaries need."""
    needed = (2, 17)
    for name, data in files.items():
        if ".so" in name:
            for major, minor in re.findall(rb"GLIBC_(\d+)\.(\d+)", data):
                needed = max(needed, (int(major), int(minor)))
    return f"manylinux_{needed[0]}_{needed[1]}_x86_64"


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


def make_addon(path, package):
    """The zip for Blender 3.4.

    With the folder in it Blender removes the installed one first; without, it writes
    into the library that runs, and crashes. Windows forbids both, and half of the
    files are better than none.
    """
    files = {f"rack_focus/{name}": data for name, data in addon_files().items()}
    head = b"# SPDX-License-Identifier: GPL-3.0-or-later\n"
    files["rack_focus/bundled/__init__.py"] = head
    for name, data in package.items():
        if not name.endswith("__main__.py"):  # the add-on does without the command
            files[f"rack_focus/bundled/{name}"] = data
    if not any(name.endswith(".pyd") for name in package):
        files["rack_focus/"] = b""
    write_zip(path, files)
    print(path)


def make_extension(path, made, platform):
    """The zip for Blender 4.2 and later, with the wheel `made`."""
    manifest = (ADDON / "blender_manifest.toml").read_text()
    lists = f'platforms = ["{platform}"]\nwheels = ["./wheels/{made.name}"]\n'
    manifest = manifest.replace("\n[permissions]", f"{lists}\n[permissions]", 1)
    files = addon_files()
    files["blender_manifest.toml"] = manifest.encode()
    files[f"wheels/{made.name}"] = made.read_bytes()
    write_zip(path, files)
    print(path)


def make_here(build, dist):
    """Both zips, for Linux as it is here."""
    package = wheels.package_files(build)
    stem = f"rack_focus-{version()}"
    make_addon(dist / f"{stem}-addon.zip", package)
    made = dist / wheels.make_wheel(dist, package, glibc_tag(package))
    make_extension(dist / f"{stem}-extension.zip", made, "linux-x64")
    made.unlink()


def make_for(platform, build, dist):
    """Wheel and zips for a platform."""
    package = wheels.package_files(build)
    files = {**package, **wheels.command_files(build)}
    tag = wheels.TAGS[platform]
    made, old = (
        dist / wheels.make_wheel(dist, files, tag, p) for p in ("3.11", "3.10")
    )
    print(made, old, sep="\n")
    stem = f"rack_focus-{version()}-{platform}"
    if platform in WITH_ADDON:
        make_addon(dist / f"{stem}-addon.zip", package)
    make_extension(dist / f"{stem}-extension.zip", made, platform)


def main():
    """Builds those of one platform."""
    build, dist = Path(sys.argv[1]), Path(sys.argv[2])
    check_versions()
    dist.mkdir(parents=True, exist_ok=True)
    if len(sys.argv) == 3:
        make_here(build, dist)
    elif sys.argv[3] in wheels.TAGS:
        make_for(sys.argv[3], build, dist)
    else:
        sys.exit(f"package.py: the platforms are {', '.join(wheels.TAGS)}")


if __name__ == "__main__":
    main()
