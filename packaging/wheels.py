# SPDX-License-Identifier: Apache-2.0
"""Wheels of the Python package rackfocus, with the command inside where it was built.

The same sources give the same bytes: fixed times, order and compression.
"""

import base64
import hashlib
import re
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "plugin" / "rackfocus"
# By platform: the wheel's tag (for Linux the floor of glibc that the build asked for).
TAGS = {
    "linux-x64": "manylinux_2_28_x86_64",
    "linux-arm64": "manylinux_2_28_aarch64",
    "macos-x64": "macosx_11_0_x86_64",
    "macos-arm64": "macosx_11_0_arm64",
    "windows-x64": "win_amd64",
}
# Names of the module in the package, and as it is built. Python 3.10 looks for its own
# first; on Linux and macOS it takes the one of all.
MODULE_310 = "_core.cp310-win_amd64.pyd"
MODULES = {
    "_core.pyd": "_core.pyd",
    "_core.abi3.so": "_core.abi3.so",
    MODULE_310: "_core310.pyd",
}
PYTHON_TAGS = {"3.11": "cp311-abi3", "3.10": "cp310-cp310"}
# Licences of what is linked into the command, where it brings its own libraries.
PARTS = {
    "OpenEXR": ROOT / "subprojects" / "openexr" / "LICENSE.md",
    "libpng": ROOT / "subprojects" / "libpng" / "LICENSE",
    "zlib": ROOT / "subprojects" / "zlib" / "LICENSE",
}
# And into the window.
WINDOW_PARTS = {
    "FreeType": ROOT / "subprojects" / "freetype2" / "docs" / "FTL.TXT",
    "SDL": ROOT / "subprojects" / "sdl2" / "LICENSE.txt",
}
CLASSIFIERS = (
    "Development Status :: 4 - Beta",
    "Intended Audience :: End Users/Desktop",
    "Intended Audience :: Developers",
    "Operating System :: MacOS",
    "Operating System :: Microsoft :: Windows",
    "Operating System :: POSIX :: Linux",
    "Programming Language :: C",
    "Programming Language :: Python :: 3",
    "Topic :: Multimedia :: Graphics :: 3D Rendering",
    "Typing :: Typed",
)


def version():
    """Version of the project, from meson.build."""
    text = (ROOT / "meson.build").read_text()
    return re.search(r"^\s*version: '([^']+)'", text, re.M)[1]


def write_zip(path, files, programs=()):
    """Writes {name in the zip: bytes} with fixed times and order; `programs` are names
    of files that may be run, names that end with / are folders."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3  # modes are those of Unix
            info.external_attr = (0o100755 if name in programs else 0o100644) << 16
            if name.endswith("/"):
                info.compress_type = zipfile.ZIP_STORED
                info.external_attr = 0o40755 << 16 | 0x10
            archive.writestr(info, files[name])


def package_files(build):
    """{name: bytes} of the package with the extension of a build."""
    kinds = (".py", ".pyi", ".typed")
    files = {
        f"rackfocus/{path.name}": path.read_bytes()
        for path in SOURCES.iterdir()
        if path.suffix in kinds
    }
    for name, made in MODULES.items():
        path = build / "plugin" / made
        if path.exists():
            files[f"rackfocus/{name}"] = path.read_bytes()
    return files


def files_for(python, files):
    """Those of `files` that a Python takes, "3.10" or "3.11" for that and later ones."""
    specific = f"rackfocus/{MODULE_310}"
    if specific not in files:
        return files
    left_out = "rackfocus/_core.pyd" if python == "3.10" else specific
    return {name: data for name, data in files.items() if name != left_out}


def command_files(build):
    """{name: bytes} of the command of a build, of its window where there is one, and the
    licences of what is in them."""
    parts, files = dict(PARTS), {}
    for name, ending in (("rackfocus", ""), ("rackfocus.exe", ".exe")):
        path = build / "cli" / name
        if path.exists():
            files[f"rackfocus/rackfocus-command{ending}"] = path.read_bytes()
    if not files:
        raise FileNotFoundError(f"{build}: the command was not built")
    window = build / "view" / "rackfocus-view.exe"
    if window.exists():
        files["rackfocus/rackfocus-view.exe"] = window.read_bytes()
        parts.update(WINDOW_PARTS)
    for part, text in parts.items():
        files[f"rackfocus/licences/{part}.txt"] = text.read_bytes()
    return files


def metadata(python):
    """What the wheel for that Python says of itself."""
    # The page of an index shows no picture that only the repository has.
    text = (ROOT / "README.md").read_text()
    text = re.sub(r"!\[[^]]*\]\([^)]*\)\n", "", text)
    lines = [
        "Metadata-Version: 2.1",
        "Name: rackfocus",
        f"Version: {version()}",
        "Summary: Depth of field after the render",
        "License: Apache-2.0",
        "License-File: Apache-2.0.txt",
        "Keywords: depth of field,bokeh,rendering,OpenEXR,Blender,POV-Ray",
        *(f"Classifier: {name}" for name in CLASSIFIERS),
        f"Requires-Python: >={python}",
        "Provides-Extra: numpy",
        'Requires-Dist: numpy; extra == "numpy"',
        "Description-Content-Type: text/markdown",
    ]
    return "\n".join(lines) + "\n\n" + text


def make_wheel(folder, files, tag, python="3.11"):
    """Writes the wheel into `folder`; returns its name. `tag` is one of TAGS' values, or
    like them, `python` one of PYTHON_TAGS."""
    tag = f"{PYTHON_TAGS[python]}-{tag}"
    files = files_for(python, files)
    info = f"rackfocus-{version()}.dist-info"
    files = dict(files)
    licence = ROOT / "LICENSES" / "Apache-2.0.txt"
    files[f"{info}/licenses/Apache-2.0.txt"] = licence.read_bytes()
    files[f"{info}/METADATA"] = metadata(python).encode()
    files[
        f"{info}/entry_points.txt"
    ] = b"[console_scripts]\nrackfocus = rackfocus.__main__:main\n"
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
    programs = [name for name in files if name.startswith("rackfocus/rackfocus-")]
    write_zip(folder / name, files, programs)
    return name
