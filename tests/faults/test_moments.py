# SPDX-License-Identifier: Apache-2.0
"""SIGINT, SIGTERM and SIGHUP at random moments: the command and all that it started end
soon, with the code that says so; no half-written file or temporary folder is left, and
what was there before stays.
"""

import os
import pathlib
import random
import signal
import subprocess
import time

import plainexr
import pytest
from test_faults import LENS, scene

N_MOMENTS = 100  # of each kind
# The command ends what does not ask after 0.6 s (os/interrupt.h); the rest is for a
# machine that has other work.
PATIENCE_S = 10
OLD = b"what was there before"
SCENE = """#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 1, -5> look_at <0, 1, 0> right x*image_width/image_height
         aperture 0.6 focal_point <0, 1, 0> }
sphere { <0, 1, 0>, 1 pigment { checker rgb 1 rgb 0.2 scale 0.2 } }
plane { y, 0 pigment { checker rgb 0.9 rgb 0.3 } }
light_source { <3, 9, -7> rgb 1 }
"""


def prepare(kind, folder):
    """The words of a command that works for some tenths of a second, and its outputs."""
    if kind == "filter":
        # Much of its time it writes.
        source = scene(folder / "in.exr", (700, 490))
        words = ["filter", source, "-o", folder / "out.exr", *LENS]
        return [*words, "--method", "box", "--type", "float"], ["out.exr"]
    if kind == "sequence":
        for i in range(1, 5):
            scene(folder / f"in.{i}.exr", (160, 120), i)
        names = [folder / "in.#.exr", "-o", folder / "out.#.exr"]
        return ["filter", *names, *LENS], [f"out.{i}.exr" for i in range(1, 5)]
    (folder / "s.pov").write_text(SCENE)
    words = ["povray", "s.pov", "-o", "out.exr", "-q", "--", "+W80", "+H60"]
    return words, ["out.exr"]


def processes_of(folder):
    """What still runs with a name of this folder among its words."""
    found = []
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes()
        except OSError:
            continue
        if str(folder).encode() in words and int(path.parent.name) != os.getpid():
            found.append(words)
    return found


def start(binary, words, folder):
    private = folder / "private"
    private.mkdir(exist_ok=True)
    return subprocess.Popen(
        [binary, *map(str, words)], cwd=folder, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, env={**os.environ, "TMPDIR": str(private)},
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    )  # fmt: skip


def is_whole(path):
    return plainexr.read(path)[0]["R"].size > 0


@pytest.mark.parametrize("kind", ["filter", "sequence", "povray"])
def test_ends_at_any_moment(binary, tmp_path, kind):
    words, outputs = prepare(kind, tmp_path)
    begin = time.monotonic()
    assert start(binary, words, tmp_path).wait() == 0
    duration = time.monotonic() - begin
    assert all((tmp_path / name).exists() for name in outputs)
    moments = random.Random(kind)
    codes, slowest = [], 0
    for i in range(N_MOMENTS):
        for path in tmp_path.glob("out.*"):
            path.unlink()
        for name in outputs:
            (tmp_path / name).write_bytes(OLD)
        number = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[i % 3]
        process = start(binary, words, tmp_path)
        time.sleep(moments.uniform(0.02, 1) * duration)
        process.send_signal(number)
        sent = time.monotonic()
        try:
            said = process.communicate(timeout=PATIENCE_S)[1]
        finally:
            process.kill()
        slowest = max(slowest, time.monotonic() - sent)
        # Ended by the signal itself: before its handler stood.
        assert process.returncode in (0, 128 + number, -number), (i, said)
        assert not list((tmp_path / "private").iterdir()), i
        assert not list(tmp_path.glob("*.part*")), i
        made = [name for name in outputs if (tmp_path / name).read_bytes() != OLD]
        assert all(is_whole(tmp_path / name) for name in made), i
        assert process.returncode or len(made) == len(outputs), i
        assert not processes_of(tmp_path), i
        codes.append(process.returncode)
    print(f"{kind}: {duration:.2f} s long; the slowest end took {slowest:.2f} s")
    assert sum(code > 0 for code in codes) > N_MOMENTS // 3
