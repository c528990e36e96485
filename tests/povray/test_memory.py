# SPDX-License-Identifier: Apache-2.0
"""The glue without memory: an error, no crash, no half file, nothing left behind."""

import os
import shutil
import stat
import subprocess

import pytest

SCENE = """#version 3.7;
global_settings { assumed_gamma 1.0 }
#include "more.inc"
#declare Name = "computed.inc";
#include Name
camera { location <0, 1, -5> look_at <0, 1, 0> right x*image_width/image_height
         aperture 0.6 focal_point <0, 1, 0> rotate y*Turn }
sphere { <0, 1, 0>, 1 pigment { checker rgb 1 rgb 0.2 scale 0.2 } }
light_source { <3, 9, -7> rgb 1 }
"""
# In place of POV-Ray: what it wrote when it was first run for a folder of this name.
POVRAY = """#!/bin/sh
for word; do case $word in +O*) folder=${{word#+O}}; folder=${{folder%/*}}; esac; done
kept={kept}/${{folder##*/}}
if [ ! -d "$kept" ]; then
    mkdir "$kept"
    {povray} "$@" "+O$kept/o.exr" >"$kept/log" 2>&1
    echo $? >"$kept.code"
fi
cp -r "$kept/." "$folder"
exit "$(cat "$kept.code")"
"""


@pytest.fixture
def quick_povray(tmp_path):
    """A folder with a program `povray` that renders each picture once."""
    folder, kept = tmp_path / "bin", tmp_path / "kept"
    folder.mkdir()
    kept.mkdir()
    path = folder / "povray"
    path.write_text(POVRAY.format(kept=kept, povray=shutil.which("povray")))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return folder


@pytest.fixture
def run(binary, quick_povray, tmp_path):
    """The command without memory for its k-th allocation; k None counts them."""
    library = os.path.join(os.environ["RACKFOCUS_BUILD"], "tests/faults/libfailing.so")
    count, private = tmp_path / "count", tmp_path / "private"
    private.mkdir()

    def run(*arguments, k=None):
        environment = {
            **os.environ,
            "LD_PRELOAD": library,
            "FAIL_COUNT": str(count),
            "FAIL_ALLOCATION": str(k or 0),
            "FAIL_ALONE": "1",
            "PATH": f"{quick_povray}:{os.environ['PATH']}",
            "TMPDIR": str(private),
        }
        done = subprocess.run(
            [binary, *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert not list(private.iterdir()), (k, done)
        return done, int(count.read_text().split()[0]) if count.exists() else 0

    return run


OUTPUT = ["-o", "out.exr", "-j1", "--", "+W32", "+H24"]
JOBS = {
    "picture": ["s.pov", *OUTPUT],
    "views": ["s.pov", "--views", "2", *OUTPUT],
    "mean": ["s.pov", "--method", "accumulate", "--views", "2", *OUTPUT],
    "ini": ["s.ini", *OUTPUT],
}


@pytest.mark.parametrize("job", JOBS)
def test_any_allocation_may_fail(run, tmp_path, job):
    """RACKFOCUS_ALL_MOMENTS=1 tries each of them, otherwise a few dozen."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "s.ini").write_text("Input_File_Name=s.pov\n+Linc ; folders\n")
    (tmp_path / "more.inc").write_text("#declare Turn = 10 * 2;\n")
    (tmp_path / "computed.inc").write_text("camera { location <0, 0, -9> }\n")
    words = ["povray", *JOBS[job]]
    out = tmp_path / "out.exr"
    done, n = run(*words)
    assert done.returncode == 0 and n > 300, done
    whole = out.read_bytes()
    n_failed = 0
    step = 1 if os.environ.get("RACKFOCUS_ALL_MOMENTS") else n // 41
    for k in range(1, n + 1, step):
        out.unlink(missing_ok=True)
        done, _ = run(*words, k=k)
        where = (job, k, n, done)
        assert done.returncode in (0, 1, 2, 127) and "(null)" not in done.stderr, where
        assert done.returncode == 0 or done.stderr, where
        assert not list(tmp_path.glob("*.part*")), where
        # zlib without memory leaves a chunk as it is: compare what there is of pixels.
        if done.returncode == 0:
            assert abs(out.stat().st_size - len(whole)) < len(whole) // 2, where
        else:
            assert not out.exists(), where
        n_failed += done.returncode != 0
    # Most moments are those of zlib, which goes on without.
    assert n_failed > 2
