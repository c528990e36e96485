# SPDX-License-Identifier: Apache-2.0
"""Memory lacks within the extension: MemoryError, and the host lives on."""

import os
import subprocess
import sys

import pytest

# Runs in a process of its own, in which the k-th allocation fails, for every k.
CHILD = """
import array, ctypes, sys
import rackfocus

failing = ctypes.CDLL({library!r})
width, height = 40, 24

def buffer(*values):
    data = array.array("f", values * (width * height))
    shape = (height, width, len(values)) if len(values) > 1 else (height, width)
    return memoryview(data).cast("B").cast("f", shape)

colour, other, depth = buffer(0.5, 0.2, 0.1), buffer(0.4, 0.2, 0.1), buffer(8.0)
work = {{
    "compare": lambda: rackfocus.compare(colour, other),
    "apply": lambda: rackfocus.apply(
        colour, depth, focus_distance=4, lens_radius=0.2, focal_length_px=40, threads=1
    ),
    "accumulate": lambda: rackfocus.Accumulator(width, height, 3).add(colour),
}}[sys.argv[1]]

expected = work()
failing.fail_allocation_from_now(0)
work()
n = failing.allocations_since()
n_failed = 0
for k in range(1, n + 1):
    failing.fail_allocation_from_now(k)
    try:
        work()
    except MemoryError:
        n_failed += 1
    finally:
        failing.fail_allocation_from_now(0)
assert not isinstance(expected, dict) or work() == expected
print(n, n_failed)
"""


@pytest.mark.parametrize("name", ["compare", "apply", "accumulate"])
def test_every_allocation_may_fail(build, name):
    library = build / "tests" / "faults" / "libfailing.so"
    subprocess.run(["ninja", "-C", build, "tests/faults/libfailing.so"], check=True)
    done = subprocess.run(
        [sys.executable, "-c", CHILD.format(library=str(library)), name],
        env={
            **os.environ,
            "LD_PRELOAD": str(library),
            "PYTHONPATH": os.pathsep.join(sys.path),
        },
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    n, n_failed = map(int, done.stdout.split())
    assert n_failed > 0 and n_failed <= n
