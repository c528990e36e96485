# SPDX-License-Identifier: Apache-2.0
"""Other programs that blur by depth, for bench.py: Blender's Defocus node, OpenDefocus.

Each rival times the frame that bench.c dumps (int32 width, height; float largest
radius; RGBA floats; signed radii) and filters the scenes of tests/quality.
"""

import abc
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

HERE = pathlib.Path(__file__).parent
#: The lens of bench.c: r = LENS_K (1/FOCUS - 1/z) px.
LENS_K, FOCUS = 40000.0, 100.0


def read_raw(path):
    """Largest radius, RGBA (h, w, 4) and signed radii (h, w) of a dumped frame."""
    words = np.fromfile(path, dtype="<f4")
    width, height = words[:2].view("<i4")
    pixels = words[3:].reshape(-1)
    n = int(width) * int(height)
    colour = pixels[: 4 * n].reshape(height, width, 4)
    return float(words[2]), colour, pixels[4 * n :].reshape(height, width)


def write_raw(path, colour, radius):
    """The inverse of read_raw()."""
    height, width = radius.shape
    with open(path, "wb") as file:
        file.write(np.array([width, height], "<i4").tobytes())
        file.write(np.array([np.abs(radius).max()], "<f4").tobytes())
        file.write(colour.astype("<f4").tobytes())
        file.write(radius.astype("<f4").tobytes())


def read_exr(path, names):
    """The named channels of an EXR, (h, w, n)."""
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(str(path))
    pixels = source.read_image("float")
    order = list(source.spec().channelnames)
    source.close()
    return pixels[..., [order.index(name) for name in names]]


def write_exr(path, pixels, names):
    """Float, uncompressed."""
    import OpenImageIO as oiio

    height, width, n = pixels.shape
    spec = oiio.ImageSpec(width, height, n, "float")
    spec.channelnames = names
    spec.attribute("compression", "none")
    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), spec)
    out.write_image(np.ascontiguousarray(pixels, dtype=np.float32))
    out.close()


class Rival(abc.ABC):
    """One program at one quality."""

    name = ""

    def __init__(self):
        self.cpu_s = {}

    def remember(self, size, radius, cpu_s):
        """Keeps what a frame took."""
        self.cpu_s[size, radius] = cpu_s

    def gave_up(self, size, radius, limit_s):
        """Would this take longer than the limit, going by smaller radii?"""
        return any(
            s == size and r < radius and cpu * (radius / r) ** 2 > limit_s
            for (s, r), cpu in self.cpu_s.items()
        )

    @abc.abstractmethod
    def time(self, raw, folder, threads):
        """Wall and CPU seconds of one frame."""

    @abc.abstractmethod
    def filter_scene(self, references, scene, folder, threads):
        """Its picture of a scene, or None where it has none."""


class Defocus(Rival):
    """Blender's Defocus node, of the Blender that is installed."""

    name = "Defocus node"

    def time(self, raw, folder, threads):
        radius, colour, radii = read_raw(raw)
        picture = folder / "defocus_in.exr"
        depth = LENS_K / (LENS_K / FOCUS - radii)
        write_exr(
            picture,
            np.concatenate([colour, depth[..., None]], axis=-1),
            ["R", "G", "B", "A", "Z"],
        )
        return self._run(picture, folder / "defocus.exr", max(radius, 1), threads)

    @staticmethod
    def _run(picture, out, radius, threads):
        done = subprocess.run(
            [
                *("blender", "-b", "--factory-startup", "-P"),
                *(HERE / "defocus_node.py", "--", picture, out),
                *map(str, (LENS_K, FOCUS, radius, 1, threads)),
            ],
            capture_output=True,
            text=True,
            check=False,
        )
        for line in done.stdout.splitlines():
            if line.startswith("defocus "):
                wall, cpu, base_wall, base_cpu = map(float, line.split()[1:])
                return wall - base_wall, cpu - base_cpu
        sys.exit(f"bench: Blender failed: {done.stdout[-800:]}{done.stderr[-800:]}")

    def filter_scene(self, references, scene, folder, threads):
        """The stored picture: its best f-stop of a scan against the reference."""
        stored = references / f"{scene}_defocus.exr"
        return stored if stored.exists() else None


class OpenDefocus(Rival):
    """The crate, in one version and quality."""

    def __init__(self, program, version, quality, command):
        super().__init__()
        self.program, self.version, self.quality = program, version, quality
        self.command = command
        self.name = f"OpenDefocus {version} {quality}"

    def _run(self, raw, out, threads):
        # The first run of 0.2 also compiles its shaders.
        runs = 2 if self.version == "0.2" else 1
        words = [self.program, self.version, self.quality, raw, out, runs]
        counts = {"RAYON_NUM_THREADS": str(threads), "LP_NUM_THREADS": str(threads)}
        done = subprocess.run(
            [str(w) for w in words],
            capture_output=True,
            text=True,
            env={**os.environ, **counts},
            check=False,
        )
        if done.returncode != 0:
            sys.exit(f"bench: {self.name} failed: {done.stderr[-800:]}")
        return tuple(float(t) for t in done.stdout.splitlines()[-1].split())

    def time(self, raw, folder, threads):
        return self._run(raw, folder / "opendefocus.raw", threads)

    def filter_scene(self, references, scene, folder, threads):
        pinhole = references / f"{scene}_pinhole.exr"
        coc, raw = folder / "coc.exr", folder / "scene.raw"
        words = [self.command, "filter", "-q", pinhole, "-o", folder / "scene.exr"]
        subprocess.run(
            [str(w) for w in [*words, "--output-coc", coc, "--method", "box"]],
            check=True,
        )
        colour = read_exr(pinhole, ["R", "G", "B"])
        alpha = np.ones_like(colour[..., :1])
        write_raw(
            raw,
            np.concatenate([colour, alpha], axis=-1),
            read_exr(coc, ["Y"])[..., 0],
        )
        self._run(raw, folder / "opendefocus.raw", threads)
        out = np.fromfile(folder / "opendefocus.raw", "<f4").reshape(
            *colour.shape[:2], 4
        )
        write_exr(folder / "opendefocus.exr", out[..., :3], ["R", "G", "B"])
        return folder / "opendefocus.exr"


def build_opendefocus(build, say):
    """Builds the wrapper with cargo in the build folder; its path."""
    if not shutil.which("cargo"):
        sys.exit(
            "bench: OpenDefocus is built with cargo of Rust 1.85 or later, which "
            "was not found; install it, or leave opendefocus out of --against"
        )
    folder = build / "opendefocus"
    (folder / "src").mkdir(parents=True, exist_ok=True)
    for name in ("Cargo.toml", "src/main.rs"):
        source, copy = HERE / "opendefocus" / name, folder / name
        if not copy.exists() or copy.read_bytes() != source.read_bytes():
            shutil.copyfile(source, copy)
    say("cargo builds OpenDefocus (minutes, the first time)")
    done = subprocess.run(
        ["cargo", "build", "--release", "-q", "--manifest-path", folder / "Cargo.toml"],
        check=False,
    )
    if done.returncode != 0:
        sys.exit("bench: cargo could not build OpenDefocus")
    return folder / "target/release/opendefocus-bench"


def start(names, build, say):
    """The rivals of these names, built where they need it."""
    rivals = []
    for name in names:
        if name == "defocus":
            if not shutil.which("blender"):
                sys.exit("bench: blender was not found; ./dev bench installs it")
            rivals.append(Defocus())
        elif name == "opendefocus":
            program = build_opendefocus(build, say)
            command = build / "cli/rackfocus"
            for version, quality in (
                ("0.1", "low"),
                ("0.2", "fast"),
                ("0.2", "accurate"),
            ):
                rivals.append(OpenDefocus(program, version, quality, command))
        else:
            sys.exit(f"bench: there is no competitor '{name}': defocus, opendefocus")
    return rivals
