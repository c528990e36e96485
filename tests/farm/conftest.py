# SPDX-License-Identifier: Apache-2.0
"""What the tests of farms share: a shot, one machine's frames of it, schedulers."""

import os
import pathlib
import subprocess
import sys

import numpy
import pytest

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli")]
import plainexr  # noqa: E402
import slurm  # noqa: E402

LENS = ["--lens-radius", "0.4", "--focal-length-px", "200", "--focus-distance", "3"]


def make_frame(path, i, size=(192, 108)):
    width, height = size
    y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
    near = (x - 40 - i / 2) ** 2 + (y - height / 2) ** 2 < (height / 4) ** 2
    stripes = ((x // 3 + y // 5) % 2).astype(numpy.float32)
    channels = {
        "R": numpy.where(near, 0.8, 0.2 + 0.5 * stripes),
        "G": numpy.where(near, 0.4, x / width),
        "B": numpy.where(near, 0.1, y / height),
        "Z": numpy.where(near, 3, 8 + 4 * y / height),
    }
    plainexr.write(path, {k: v.astype(numpy.float32) for k, v in channels.items()})


@pytest.fixture
def shot(tmp_path):
    """Makes frames 1 to n in a folder whose name a shell or sbatch would take apart."""

    def make(n):
        folder = tmp_path / "it's a $HOME of 9%A"
        folder.mkdir()
        for i in range(1, n + 1):
            make_frame(folder / f"shot.{i:04d}.exr", i)
        return folder

    return make


@pytest.fixture
def alone(binary):
    """The frames that one machine makes, by number."""

    def run(folder):
        done = subprocess.run(
            [binary, "filter", "shot.####.exr", "-o", "alone.####.exr", *LENS, "-q"],
            cwd=folder,
        )
        assert done.returncode == 0
        return frames_of(folder, "alone")

    return run


def frames_of(folder, name="out"):
    paths = sorted(folder.glob(f"{name}.[0-9]*.exr"))
    return {int(p.name.split(".")[1]): p.read_bytes() for p in paths}


@pytest.fixture(scope="session")
def farm():
    assert slurm.is_there(), "Slurm is missing: ./dev test farm installs it"
    one = slurm.Slurm()
    yield one
    one.stop()


@pytest.fixture(scope="session")
def openjd_env():
    """An environment in which `openjd` runs."""
    folder = pathlib.Path(os.environ["RACKFOCUS_BUILD"]).resolve() / "openjd"
    if not (folder / "bin/openjd").exists():
        done = subprocess.run(
            [sys.executable, "-m", "pip", "install", "-q", "--target", folder]
            + ["--root-user-action=ignore", "openjd-cli"],
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            pytest.skip(f"pip cannot install openjd-cli: {done.stderr[-300:]}")
    return {
        **os.environ,
        "PYTHONPATH": str(folder),
        "PATH": f"{folder}/bin:{os.environ['PATH']}",
    }
