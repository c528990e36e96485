# SPDX-License-Identifier: Apache-2.0
"""The plan around core/ (docs/ARCHITECTURE.md): only os/ knows the operating system,
only main() ends the program, and no file needs, by any way round, one that needs it."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
FOLDERS = "app cli view exr povray_glue plugin core".split()
# Each of its folders needs only itself and those before it.
ORDER = {
    "core": "base kernels lens input surfaces compose methods api".split(),
    "app": "common measure sources denoise filter sequence povray".split(),
    "cli": "console pages commands".split(),
    "view": "model pixels filtering controls demo".split(),
}
# What C itself does not have, or has other meanings of elsewhere.
SYSTEM = re.compile(
    r"sys/.*|linux/.*|unistd|pthread|dirent|signal|semaphore|fcntl|dlfcn|termios|ftw|"
    r"glob|fnmatch|poll|spawn|sched|pwd|grp|regex|libgen|langinfo|net.*|arpa/.*|"
    r"windows|io|direct|process|winsock2"
)
PROGRAM = ("app", "cli", "view", "exr", "povray_glue", "os")
# The library's own seam: memory pages, locale, threads.
MAY = "core/base/"


def sources(*folders):
    found = [
        path
        for folder in folders
        for pattern in ("*.c", "*.h")
        for path in (ROOT / folder).rglob(pattern)
    ]
    assert len(found) > 10 * len(folders), "the sources were not found"
    return sorted(found)


def code_of(path):
    """Without comments and texts, line for line."""
    text = path.read_text()
    pattern = r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"'
    return re.sub(pattern, lambda m: "\n" * m.group(0).count("\n"), text, flags=re.S)


def test_only_os_knows_the_system():
    wrong = []
    for path in sources(*FOLDERS):
        name = str(path.relative_to(ROOT))
        for header in re.findall(r"^#\s*include <([^>]+)\.h>", path.read_text(), re.M):
            if SYSTEM.fullmatch(header) and not name.startswith(MAY):
                wrong.append(f"{name} includes <{header}.h>")
    assert not wrong, "say it by a function of os/: " + "; ".join(wrong)


def test_headers_of_os_are_plain_c():
    for path in sorted((ROOT / "os").glob("*.h")):
        for header in re.findall(r"^#\s*include <([^>]+)\.h>", path.read_text(), re.M):
            assert not SYSTEM.fullmatch(header), f"{path.name} includes <{header}.h>"


def test_only_main_ends_the_program():
    """A library that exits takes Blender with it, or a half-written file."""
    ends = re.compile(r"\b(_?exit|_Exit|abort|quick_exit|raise)\s*\(")
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in sources(*FOLDERS)
        for number, line in enumerate(code_of(path).splitlines(), 1)
        if ends.search(line) and not line.startswith("#")
    ]
    assert not wrong, "return an error: " + "; ".join(wrong)


def object_files(*folders):
    """Object files, which say what each file really needs: headers do not, where one
    has functions of several files."""
    for folder in folders:
        found = list((BUILD / folder).glob("*.p/*.c.o"))
        assert found, f"nothing of {folder} in {BUILD}"
        for path in found:
            yield f"{folder}/{path.name[:-2]}", path


def needs_of_files(*folders):
    defined, wanted = {}, {}
    for name, path in object_files(*folders):
        lines = subprocess.run(
            ["nm", path], capture_output=True, text=True, check=True
        ).stdout.splitlines()
        symbols = [line.split()[-2:] for line in lines]
        wanted[name] = {symbol for kind, symbol in symbols if kind == "U"}
        defined.update({s: name for kind, s in symbols if kind in "TDBRC"})
    return {
        name: {defined[s] for s in symbols if s in defined} - {name}
        for name, symbols in wanted.items()
    }


def circle_in(needs):
    """What is left when all is taken away that needs nothing, or that nobody needs."""
    while True:
        needed = set().union(*needs.values())
        free = {n for n in needs if n not in needed or not needs[n] & set(needs)}
        if not free:
            return {name: sorted(on & set(needs)) for name, on in needs.items()}
        needs = {name: on for name, on in needs.items() if name not in free}


def test_a_circle_would_be_found():
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set()}) == {
        "b": ["c"],
        "c": ["b"],
    }
    assert not circle_in({"a": {"b", "d"}, "b": {"c"}, "c": {"d"}, "d": set()})


def test_no_circle_of_files():
    for folders in PROGRAM, ["core"]:
        needs = needs_of_files(*folders)
        assert len(needs) > 100
        circle = circle_in(needs)
        assert not circle, f"these files need each other in a circle: {circle}"


@pytest.mark.parametrize("folder", ORDER)
def test_folders_need_only_those_before_them(folder):
    """Meson names the object of filter/windows.c filter_windows.c.o. What lies in no
    folder, as main.c, may need all of them."""
    order = ORDER[folder]

    def place(name):
        path = name.split("/")[1]
        if path.startswith("meson-generated"):
            return -1
        first = path.split("_")[0]
        return order.index(first) if first in order else len(order)

    on_disk = {path.name for path in (ROOT / folder).iterdir() if path.is_dir()}
    assert on_disk - {"include"} == set(order)
    needs = needs_of_files(folder)
    assert len(needs) > 30
    wrong = [
        f"{name} needs {other}"
        for name, others in needs.items()
        for other in others
        if place(other) > place(name)
    ]
    assert not wrong, f"the order is {', '.join(order)}: " + "; ".join(wrong)
