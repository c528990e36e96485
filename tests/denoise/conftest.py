# SPDX-License-Identifier: Apache-2.0
"""Open Image Denoise, and pictures to clean."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
REFERENCES = ROOT / "tests/quality/references"


@pytest.fixture(scope="session")
def oidn():
    """Folder of libOpenImageDenoise, installed into the build folder by pip."""
    folder = BUILD / "oidn"
    library = folder / "pyoidn/oidn/lib"
    if not library.exists():
        command = [sys.executable, "-m", "pip", "install", "-q", "--no-deps"]
        options = ["--disable-pip-version-check", "--target", folder, "pyoidn>=2.5"]
        subprocess.run([*command, *options], check=True)
    return library


@pytest.fixture(scope="session")
def package(tmp_path_factory):
    """Folder with the package `rackfocus`: its sources and the built extension."""
    if not (BUILD / "plugin/_core.abi3.so").exists():
        subprocess.run(["meson", "configure", BUILD, "-Dpython=enabled"], check=True)
    subprocess.run(["ninja", "-C", BUILD, "plugin/_core.abi3.so"], check=True)
    folder = tmp_path_factory.mktemp("package") / "rackfocus"
    shutil.copytree(ROOT / "plugin/rackfocus", folder)
    shutil.copy(BUILD / "plugin/_core.abi3.so", folder)
    return folder.parent


@pytest.fixture
def clean(rackfocus, oidn):
    """Runs the command with the library at hand."""

    def run(*arguments, code=0):
        environment = {**os.environ, "RACKFOCUS_OIDN": str(oidn)}
        return rackfocus(*arguments, code=code, env=environment)

    return run


@pytest.fixture
def score(rackfocus):
    """tPSNR of a picture against the reference of a scene."""

    def measure(picture, scene):
        reference = REFERENCES / f"{scene}_reference.exr"
        return float(rackfocus("compare", picture, reference).stdout.split()[-2])

    return measure


def read(path):
    """All channels of a file, height x width x n, and their names."""
    picture = oiio.ImageInput.open(str(path))
    spec = picture.spec()
    pixels = picture.read_image(0, 0, 0, spec.nchannels, "float")
    return np.array(pixels).reshape(spec.height, spec.width, -1), spec.channelnames


def write(path, pixels, names, like=None, place=(0, 0), **more):
    """Writes channels of floats, with the camera's facts of another file and more."""
    height, width, n = pixels.shape
    spec = oiio.ImageSpec(width, height, n, "float")
    spec.channelnames = tuple(names)
    spec.x, spec.y = place
    facts = oiio.ImageInput.open(str(like)).spec().extra_attribs if like else []
    for fact in facts:
        if fact.name.startswith("rackfocus:"):
            spec.attribute(fact.name, fact.type, fact.value)
    for name, value in more.items():
        spec.attribute(name, value)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec) and out.write_image(
        np.ascontiguousarray(pixels, np.float32)
    )
    out.close()
    return path
