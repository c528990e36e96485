# SPDX-License-Identifier: Apache-2.0
"""Lays libraries out as subprojects of meson, for systems without packages of them.

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
PACKAGES = {
    "zlib": "zlib",
    "libpng1.6": "libpng",
    "freetype": "freetype2",
    "libsdl2": "sdl2",
}
# Files of ours in the folders; FreeType has a meson.build.
OWN = {
    "zlib": {"meson.build": "zlib.build"},
    "libpng": {"meson.build": "libpng.build"},
    "freetype2": {
        "modules.cfg": "modules.cfg",
        "include/freetype/config/ftmodule.h": "ftmodule.h",
    },
    "sdl2": {
        "meson.build": "sdl2.build",
        "include/SDL_config.h": "SDL_config.h",
        "src/dynapi/SDL_dynapi.h": "SDL_dynapi.h",
    },
}
# Not needed to build them.
LEFT_OUT = shutil.ignore_patterns(
    "debian", "ft2demos", "ft2docs", "test", "Xcode*", "android-*"
)
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


def take_arguments(path):
    """Has FreeType's own meson.build take the arguments that ours take."""
    taken = (
        "\nadd_project_arguments(\n"
        "  meson.get_external_property('library_c_args', []), language: 'c')\n"
    )
    head, rest = path.read_text().split("\n)\n", 1)  # the end of project()
    if not rest.startswith(taken):
        path.write_text(f"{head}\n)\n{taken}{rest}")


def main():
    """Lays out what is not there, and our files beside it."""
    if not all((SUBPROJECTS / name / "done").exists() for name in OWN):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            fetch(folder)
            for package, name in PACKAGES.items():
                found = next(p for p in folder.glob(f"{package}-*") if p.is_dir())
                shutil.rmtree(SUBPROJECTS / name, ignore_errors=True)
                shutil.copytree(
                    found, SUBPROJECTS / name, symlinks=True, ignore=LEFT_OUT
                )
                (SUBPROJECTS / name / "done").touch()
    for name, files in OWN.items():
        for path, ours in files.items():
            own, there = (HERE / ours).read_bytes(), SUBPROJECTS / name / path
            if not there.exists() or there.read_bytes() != own:
                there.write_bytes(own)
    take_arguments(SUBPROJECTS / "freetype2" / "meson.build")


main()
