# SPDX-License-Identifier: Apache-2.0
"""The plan of core/: its folders stand in the order in which pixels pass them, and a
file includes only what stands in its own folder or in one before it. No file may need,
by any way round, one that needs it: then each can be read, and tested, with only what
is above it in mind. A .c file says what others may use in a header of its own name."""

import pathlib
import re

CORE = pathlib.Path(__file__).parents[2] / "core"
ORDER = "base kernels lens input surfaces compose methods api".split()
# These define nothing but what rackfocus.h declares, or are pieces of kernels.h.
PUBLIC_ONLY = set(
    """api/accumulator api/context api/deep api/seen_search api/window
    input/depth_repair input/depth_stats lens/lens_points lens/optics kernels/kernels_tmpl""".split()
)


def files():
    found = [
        path.relative_to(CORE)
        for pattern in ("*.c", "*.h")
        for path in CORE.rglob(pattern)
        if path.relative_to(CORE).parts[0] != "include"
    ]
    assert len(found) > 80, "core/ was not found"
    return sorted(found)


def includes(path):
    """Files of core/ that one includes, by their place in core/."""
    text = (CORE / path).read_text()
    names = re.findall(r'^#\s*include "([^"]+)"', text, re.M)
    return [name for name in names if not name.startswith("rackfocus/")]


def test_folders_include_only_those_before_them():
    wrong = []
    for path in files():
        for name in includes(path):
            assert (CORE / name).is_file(), f"{path} includes {name}: say it from core/"
            if ORDER.index(name.split("/")[0]) > ORDER.index(path.parts[0]):
                wrong.append(f"{path} includes {name}")
    assert not wrong, f"the order is {', '.join(ORDER)}: " + "; ".join(wrong)


def test_no_circle_of_files():
    """A .c file and its header count as one."""
    needs = {}
    for path in files():
        own = str(path.with_suffix(""))
        names = {name[: -len(".h")] for name in includes(path)}
        needs.setdefault(own, set()).update(names - {own})
    while True:
        free = {name for name in needs if not needs[name] & set(needs)}
        if not free:
            break
        needs = {name: on for name, on in needs.items() if name not in free}
    circle = {name: sorted(on & set(needs)) for name, on in needs.items()}
    assert not circle, f"these files need each other in a circle: {circle}"


def test_each_file_has_its_header():
    lonely = [
        str(path)
        for path in files()
        if path.suffix == ".c"
        and str(path.with_suffix("")) not in PUBLIC_ONLY
        and f"{path.with_suffix('.h')}" not in includes(path)
    ]
    assert not lonely, f"no header of its own name, or not included: {lonely}"


def test_every_file_is_built():
    text = (CORE / "meson.build").read_text()
    missing = [str(p) for p in files() if p.suffix == ".c" and f"'{p}'" not in text]
    assert not missing, f"not in core/meson.build: {missing}"


def test_loops_run_on_threads_in_one_way():
    """core/ by rf_parallel(), all others by os_parallel(): no compiler's threads."""
    root, found = CORE.parent, []
    folders = "app cli core examples exr os plugin povray_glue tests view".split()
    paths = [path for name in folders for path in (root / name).rglob("*")]
    paths = [root / "meson.build"] + [p for p in paths if p.suffix in (".c", ".h")]
    paths += [path for name in folders for path in (root / name).rglob("meson.build")]
    assert len(paths) > 200
    for path in paths:
        text = path.read_text()
        if re.search(r"^\s*#\s*pragma\s+omp\b|<omp\.h>|openmp", text, re.M | re.I):
            found.append(str(path.relative_to(root)))
    assert not found, f"OpenMP in {found}: docs/ARCHITECTURE.md says how loops run"
