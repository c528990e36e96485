# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/reliability.md and its notes: what the checks found, and what no
test reaches.

checks.py writes one JSON file per check; table() makes the rows of them.
"""

import json
import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OUT = Path(os.environ.get("RACKFOCUS_CHECKS", ROOT / "build-checks"))


def read_table(name):
    """Lines of cells parted by " | "; # begins a comment."""
    for line in Path(__file__).with_name(name).read_text().splitlines():
        if line and not line.startswith("#"):
            yield [cell.strip() for cell in line.split(" | ")]


def load(name):
    path = OUT / f"{name}.json"
    return json.loads(path.read_text()) if path.exists() else None


def how_many(tests, *names):
    """Failed ones among the tests whose name begins so."""
    found = [v for k, v in tests.items() if k.startswith(names)]
    n_failed = sum(v != "passed" for v in found)
    return f"{n_failed} of {len(found)} tests failed"


def fault_rows(one):
    tests, damaged = one["tests"], one["damaged"]
    yield "fuzz corpus replayed", f"{one['corpus']} inputs", "0 findings"
    yield (
        "files cut off or with flipped bits",
        f"{damaged['files']}: {damaged['refused']} refused, the others read",
        f"{damaged['crashed']} crashes",
    )
    yield (
        "k-th allocation fails, command",
        f"{one['allocations']} runs",
        how_many(tests, "test_every_allocation"),
    )
    yield (
        "k-th allocation fails, EXR and PNG",
        f"{one['exr_allocations']} runs",
        f"{one['exr_failed']} of 1 tests failed",
    )
    yield (
        "kill -9 before each file call of a sequence",
        f"{one['killed']} kills",
        how_many(tests, "test_killed"),
    )
    yield "all tests of faults", f"{len(tests)} tests", how_many(tests, "test_")


def coverage_rows(one):
    for part, (hit, total) in sorted(one["parts"].items()):
        percent = 100 * hit / total
        yield f"lines covered: {part}", f"{hit} of {total}", f"{percent:.1f} %"


def static_rows(one):
    for tool, (n, left) in one["counts"].items():
        yield tool, f"{one['files']} files", f"{left} warnings, {n - left} excepted"


def fuzz_rows(one):
    for target, seconds, n, findings in one["targets"]:
        yield f"fuzzing: {target}", f"{n} inputs in {seconds} s", f"{findings} findings"


def thread_rows(one):
    yield "ThreadSanitizer", f"{one['tests']} tests", f"{one['reports']} races"


def valgrind_rows(one):
    programs = f"{one['tests']} tests in {one['programs']} programs"
    yield "valgrind over the unit suite", programs, f"{one['errors']} errors"


def mutant_rows(one):
    n = len(one["mutants"])
    yield "wrong operators put in", f"{n} mutants", f"{one['caught']} caught"


def openexr_rows(one, version="3.1"):
    yield (
        f"test files of OpenEXR {version}",
        f"{one['files']}: {one['refused']} refused, the others read",
        f"{one['crashed']} crashes, {one['findings']} findings",
    )


def openexr_pypi_rows(one):
    return openexr_rows(one, "3.5.3")


# What makes the rows of a check, and how they begin.
ROWS = {
    "fuzz": (fuzz_rows, "fuzzing:"),
    "faults": (fault_rows, ("fuzz corpus", "files cut", "k-th", "kill", "all tests")),
    "openexr": (
        openexr_rows,
        ("test files of OpenEXR 3.1 ", "test files of OpenEXR's"),
    ),
    "openexr_pypi": (openexr_pypi_rows, "test files of OpenEXR 3.5.3 "),
    "threads": (thread_rows, "ThreadSanitizer"),
    "valgrind": (valgrind_rows, "valgrind"),
    "static": (static_rows, ("clang-tidy", "gcc", "cppcheck")),
    "mutate": (mutant_rows, "wrong operators"),
    "coverage": (coverage_rows, "lines covered"),
}


def rows(before):
    """Rows of the results; a check without any keeps those that it had, as lines."""
    for name, (make, begins) in ROWS.items():
        kept = [line for line in before if line.removeprefix("| ").startswith(begins)]
        if one := load(name):
            made = [[*row, one["commit"]] for row in make(one)]
            titles = tuple(f"| {row[0]} |" for row in made)
            yield from ("| " + " | ".join(row) + " |" for row in made)
            if name in ("coverage", "fuzz"):  # perhaps some parts only
                yield from (line for line in kept if not line.startswith(titles))
        else:
            yield from kept or [f"| {name} | | not run | |"]


def uncovered():
    """Files with lines that no test reaches, and why."""
    one = load("coverage") or {"files": []}
    reasons = dict(read_table("uncovered.txt"))
    for file, hit, total in one["files"]:
        yield f"`{file}`", total - hit, reasons.get(file, "")


def marks(name):
    return f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"


def replace_between(text, name, lines):
    begin, end = marks(name)
    head, rest = text.split(begin)
    return head + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def table():
    path = ROOT / "docs/reliability.md"
    text = path.read_text()
    begin, end = marks("table")
    before = text.split(begin)[1].split(end)[0].splitlines()
    lines = ["| check | how much | result | commit |", "| --- | --- | --- | --- |"]
    lines += rows(before)
    text = replace_between(text, "table", lines)
    path.write_text(text)
    if load("coverage"):
        notes = ROOT / "docs/notebook/reliability.md"
        left = ["| file | lines | what they are |", "| --- | --- | --- |"]
        left += [f"| {file} | {n} | {why} |" for file, n, why in uncovered()]
        notes.write_text(replace_between(notes.read_text(), "uncovered", left))
    print(text.split(begin)[1].split(end)[0])
