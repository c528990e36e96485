# SPDX-License-Identifier: Apache-2.0
"""What a farm costs: 1,000 frames of 480 x 270 by Slurm against one machine's loop.

    RACKFOCUS=build/cli/rackfocus python3 tests/farm/measure_overhead.py [FRAMES] [ROUNDS]

Both have two workers of one thread. The loop is two processes, each with half of the
frames. Slurm's time runs from the submission to the last frame (and to the end of the
check). Rounds alternate, so that other load on the machine meets both. Until the last
frame is there only the folder is looked at: a squeue ten times a second would take a
tenth of the two processors that the tasks have.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli")]
import conftest  # noqa: E402
import slurm  # noqa: E402

BINARY = os.path.abspath(os.environ["RACKFOCUS"])
WORDS = ["filter", "shot.####.exr", "-o", "out.####.exr", *conftest.LENS]


def clear(folder):
    for path in folder.glob("out.*"):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def loop(folder, n):
    start = time.time()
    halves = [f"1-{n // 2}", f"{n // 2 + 1}-{n}"]
    running = [
        subprocess.Popen([BINARY, *WORDS, "-q", "-j1", "--frames", half], cwd=folder)
        for half in halves
    ]
    assert [one.wait() for one in running] == [0, 0]
    return time.time() - start


def wait_for_frames(folder, n, seconds=1200):
    end = time.monotonic() + seconds
    while sum(1 for _ in folder.glob("out.[0-9]*.exr")) < n:
        assert time.monotonic() < end, "frames are missing"
        time.sleep(0.25)


def by_slurm(farm, folder, n):
    start = time.time()
    done = subprocess.run(
        [BINARY, "submit", "--to", "slurm", "--", *WORDS],
        cwd=folder,
        env=farm.env,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    wait_for_frames(folder, n)
    farm.wait_for_jobs(1200)
    end = time.time()
    times = [p.stat().st_mtime for p in folder.glob("out.[0-9]*.exr")]
    assert len(times) == n, done.stdout
    return max(times) - start, end - start, done.stdout.splitlines()[0]


def main():
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    folder = pathlib.Path(tempfile.mkdtemp(prefix="rf-overhead-"))
    farm = slurm.Slurm()
    try:
        for i in range(1, 21):
            conftest.make_frame(folder / f"shot.{i:04d}.exr", i, (480, 270))
        for i in range(21, n + 1):
            source = folder / f"shot.{(i - 1) % 20 + 1:04d}.exr"
            os.link(source, folder / f"shot.{i:04d}.exr")
        for _ in range(rounds):
            one = loop(folder, n)
            clear(folder)
            last, end, how = by_slurm(farm, folder, n)
            clear(folder)
            print(
                f"loop {one:.1f} s; Slurm {last:.1f} s to the last frame "
                f"({100 * (last / one - 1):+.0f} %), {end:.1f} s with the check; {how}; "
                f"load {os.getloadavg()[0]:.1f}",
                flush=True,
            )
    finally:
        farm.stop()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
