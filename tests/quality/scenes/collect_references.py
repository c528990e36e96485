# SPDX-License-Identifier: Apache-2.0
"""Turns a folder of renders by cycles_scenes.py into the committed references.

    collect_references.py WORKDIR OUTDIR [SCENE ...] [--prototype DIR] [--no-views]

Writes small EXR files (half-float colour, lossless) with the camera facts in their
headers, keeps the best f-stop of the Defocus node, averages the seeds of the reference,
and brings OUTDIR/manifest.json up to date with the camera, the sample counts and all
scores. Of the scenes of mirrors (LIGHT_SCENES, rendered with --light-passes) the pinhole
and one view get the light of mirrors and glass beside their colour, and the manifest
nothing. Needs OpenImageIO and numpy (Debian: python3-openimageio).
"""

import argparse
import json
import math
import re
import subprocess
import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

VIEW_SCENES = ("posts", "portrait")
SMALL_SCENES = ("plane", "macro", "foliage", "ortho")
LIGHT_SCENES = {"mirrors": 7}  # and the view that is kept
# For rivals.py.
LONE_REFERENCES = (
    "bar", "street", "fur", "snow", "cards", "grass", "night", "branches",
)  # fmt: skip
LIGHTS = {"reflection": "Gloss", "transmission": "Trans"}
VEC2 = oiio.TypeDesc(oiio.FLOAT, oiio.VEC2)


def read_exr(path):
    """Colour and depth of an EXR, H x W x 4 floats (depth 1 where there is none)."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        sys.exit(f"{path}: {oiio.geterror()}")
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")
    pixels = pixels.reshape(spec.height, spec.width, -1)
    by_name = {}
    for index, name in enumerate(spec.channelnames):
        if "Denoising" not in name:
            by_name.setdefault(name.split(".")[-1], pixels[..., index])
    by_name.setdefault("Z", np.ones_like(by_name["R"]))
    return np.stack([by_name[name] for name in "RGBZ"], -1)


def read_lights(path):
    """Light of mirrors and glass of an EXR with light passes, H x W x 6 floats."""
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")
    pixels = pixels.reshape(spec.height, spec.width, -1)
    at = {name.split(".", 1)[1]: i for i, name in enumerate(spec.channelnames)}

    def part(name):
        return np.stack([pixels[..., at[f"{name}.{c}"]] for c in "RGB"], -1)

    lights = [
        (part(word + "Dir") + part(word + "Ind")) * part(word + "Col")
        for word in LIGHTS.values()
    ]
    return np.concatenate(lights, -1)


def write_exr(path, pixels, compression, facts=None):
    """Writes half-float R, G, B and, with a fourth channel, float Z; then lights."""
    height, width, n_channels = pixels.shape
    spec = oiio.ImageSpec(width, height, n_channels, oiio.HALF)
    names = [*"RGBZ", *(f"{light}.{c}" for light in LIGHTS for c in "RGB")]
    spec.channelnames = tuple(names[:n_channels])
    if n_channels >= 4:
        spec.channelformats = tuple(
            oiio.TypeDesc("float" if name == "Z" else "half")
            for name in names[:n_channels]
        )
    spec.attribute("compression", compression)
    spec.attribute("DateTime", "1980:01:01 00:00:00")  # same renders, same bytes
    for name, value in (facts or {}).items():
        if isinstance(value, tuple):
            spec.attribute(name, VEC2, value)
        else:
            spec.attribute(name, value)
    out = oiio.ImageOutput.create(str(path))
    if not out.open(str(path), spec) or not out.write_image(pixels.astype(np.float32)):
        sys.exit(f"{path}: {out.geterror()}")
    out.close()


def to_display(colour):
    """What tPSNR compares: clipped to [0, 1] and gamma 2.2."""
    return np.clip(colour[..., :3], 0.0, 1.0) ** (1 / 2.2)


def tpsnr(a, b):
    """tPSNR in dB of two linear pictures."""
    error = np.mean((to_display(a).astype(np.float64) - to_display(b)) ** 2)
    return round(float(-10 * np.log10(error)), 2)


def camera_header(camera):
    """The camera facts under the names that Rack Focus reads from a header."""
    facts = {
        "rackfocus:focusDistance": float(camera["focus"]),
        "rackfocus:lensRadius": float(camera["lens_radius"]),
        "rackfocus:projection": "perspective",
        "rackfocus:depth": "planar",
        "rackfocus:blades": int(camera["blades"]),
        "rackfocus:bladeRotation": float(camera["rotation_deg"]),
        "rackfocus:apertureRatio": float(camera["ratio"]),
    }
    if camera["ortho_scale"]:
        facts["rackfocus:projection"] = "orthographic"
        facts["rackfocus:orthoScale"] = float(camera["ortho_scale"])
    else:
        facts["rackfocus:focalLengthPx"] = float(camera["focal_px"])
    return facts


def round_depth(depth):
    """Depth with 16 significant bits, so that it compresses well."""
    bits = np.ascontiguousarray(depth, np.float32).view(np.uint32)
    return ((bits + 0x80) & np.uint32(0xFFFFFF00)).view(np.float32)


class Collector:
    """Collects one scene: reads from `work`, writes to `out`, fills `entry`."""

    def __init__(self, work, out, name):
        self.work, self.out, self.name = work, out, name
        self.about = self.read_json("pinhole")
        self.camera = self.about["camera"]
        self.entry = {"camera": self.camera, "blender": self.about["blender"]}
        self.entry["samples"] = {"pinhole": self.about["samples"]}
        self.entry["tpsnr_db"] = {}
        self.reference = None

    def read_json(self, render_pass):
        """The facts that cycles_scenes.py wrote beside a pass."""
        return json.loads((self.work / f"{self.name}_{render_pass}.json").read_text())

    def rendered(self, suffix):
        """Path of a render."""
        return self.work / f"{self.name}_{suffix}.exr"

    def target(self, suffix):
        """Path of a committed file."""
        return self.out / f"{self.name}_{suffix}.exr"

    def score(self, label, picture):
        """Notes the tPSNR of a picture against the reference."""
        self.entry["tpsnr_db"][label] = tpsnr(picture, self.reference)

    def collect_pinhole(self):
        """Colour and depth with the camera facts; returns the pixels."""
        pinhole = read_exr(self.rendered("pinhole"))
        write_exr(self.target("pinhole"), pinhole, "zip", camera_header(self.camera))
        return pinhole

    def collect_reference(self):
        """The mean over the seeds; the seeds against each other are the noise."""
        seeds = seeds_of(self.work, self.name)
        if len(seeds) < 2:
            return False
        pairs = [10 ** (-tpsnr(a, b) / 10) for a, b in combinations(seeds, 2)]
        between = -10 * math.log10(np.mean(pairs))
        self.reference = np.mean(seeds, axis=0)
        self.entry["samples"]["reference"] = self.read_json("reference")["samples"]
        self.entry["samples"]["reference_seeds"] = len(seeds)
        self.entry["noise_floor_db"] = {
            "between_two_seeds": round(between, 2),
            "one_seed_estimated": round(between + 10 * math.log10(2), 2),
            "reference_estimated": round(between + 10 * math.log10(2 * len(seeds)), 2),
        }
        write_exr(self.target("reference"), self.reference, "piz")
        return True

    def collect_own_dof(self):
        """Cycles' own depth of field at the samples of the pinhole picture."""
        if not self.rendered("dof").exists():
            return
        picture = read_exr(self.rendered("dof"))[..., :3]
        self.entry["samples"]["dof"] = self.read_json("dof")["samples"]
        self.score("own_dof_64", picture)
        if self.name not in SMALL_SCENES:
            write_exr(self.target("dof64"), picture, "piz")

    def collect_defocus(self):
        """The Defocus node at the f-stop with the highest tPSNR of the scan."""
        scan = {}
        for path in self.work.glob(f"{self.name}_defocus_*.exr"):
            fstop = float(re.search(r"_defocus_([\d.]+)\.exr$", path.name)[1])
            scan[fstop] = (tpsnr(read_exr(path), self.reference), path)
        if not scan:
            return
        best = max(scan, key=lambda fstop: scan[fstop][0])
        self.score("defocus_node_best", read_exr(scan[best][1]))
        self.entry["defocus_node_fstop"] = best
        self.entry["defocus_node_scan_db"] = {
            f"{fstop:.3f}": scan[fstop][0] for fstop in sorted(scan)
        }
        if self.name not in SMALL_SCENES:
            write_exr(self.target("defocus"), read_exr(scan[best][1])[..., :3], "piz")

    def collect_views(self):
        """The pinhole views with their place on the lens."""
        about = self.read_json("views")
        self.entry["samples"]["view"] = about["samples"]
        self.entry["view_offsets"] = about["view_offsets"]
        for index, offset in enumerate(about["view_offsets"]):
            facts = camera_header(self.camera)
            facts["rackfocus:lensOffset"] = tuple(offset)
            facts["rackfocus:shearDistance"] = float(self.camera["focus"])
            pixels = read_exr(self.rendered(f"view{index:02d}"))
            pixels[..., 3] = round_depth(pixels[..., 3])
            write_exr(self.target(f"view{index:02d}"), pixels, "zip", facts)

    def run_prototype(self, folder, label, extra):
        """Scores the brute-force prototype by its own report."""
        camera = self.camera
        command = ["/usr/bin/python3", str(folder / "run.py")]
        command += [str(self.rendered("pinhole")), str(self.target("reference"))]
        keys = {"lens": "lens_mm", "fstop": "fstop", "focus": "focus"}
        keys |= {"sensor": "sensor_mm", "blades": "blades"}
        keys |= {"rotation": "rotation_deg", "ratio": "ratio", "ortho": "ortho_scale"}
        for option, key in keys.items():
            command += [f"--{option}", str(camera[key])]
        report = subprocess.run(
            command + extra, check=True, capture_output=True, text=True
        ).stdout
        figure = re.search(r"views? .*?all ([-\d.]+)", report)
        self.entry["tpsnr_db"][label] = float(figure[1])


def collect(work, out, name, options):
    """Collects one scene; returns its entry of the manifest."""
    one = Collector(work, out, name)
    pinhole = one.collect_pinhole()
    has_views = name in VIEW_SCENES and one.rendered("view00").exists()
    if has_views and not options.no_views:
        one.collect_views()
    if not one.collect_reference():
        print(f"{name}: fewer than two seeds of the reference, no scores")
        return one.entry
    one.score("pinhole", pinhole)
    one.collect_own_dof()
    one.collect_defocus()
    if options.prototype:
        for k in (1, 4):
            extra = ["--k", str(k), "--png", str(work / f"{name}_one_k{k}.png")]
            one.run_prototype(options.prototype, f"prototype_one_view_k{k}", extra)
        if has_views:
            views = ["--views", str(work / f"{name}_view"), "8", "--k", "4"]
            views += ["--png", str(work / f"{name}_views_k4.png")]
            one.run_prototype(options.prototype, "prototype_8_views_k4", views)
    return one.entry


def seeds_of(work, name):
    """The colours of a scene's references, a picture for each seed."""
    paths = sorted(work.glob(f"{name}_reference_seed*.exr"))
    return [read_exr(path)[..., :3] for path in paths]


def collect_mean(work, out, name):
    """Collects a scene of which the reference alone is kept."""
    seeds = seeds_of(work, name)
    write_exr(out / f"{name}_reference.exr", np.mean(seeds, axis=0), "piz")
    between = tpsnr(seeds[0], seeds[1])
    print(f"{name}: {len(seeds)} seeds, two of them {between} dB apart")


def collect_lights(work, out, name):
    """Collects a scene of mirrors: pinhole, one view, reference; no scores."""
    one = Collector(work, out, name)
    about = one.read_json("views")
    facts = camera_header(one.camera)
    index = LIGHT_SCENES[name]
    place = {
        "rackfocus:lensOffset": tuple(about["view_offsets"][index]),
        "rackfocus:shearDistance": float(one.camera["focus"]),
    }
    for suffix, more in (("pinhole", {}), (f"view{index:02d}", place)):
        pixels = read_exr(one.rendered(suffix))
        pixels[..., 3] = round_depth(pixels[..., 3])
        pixels = np.concatenate([pixels, read_lights(one.rendered(suffix))], -1)
        write_exr(one.target(suffix), pixels, "zip", facts | more)
    if not one.collect_reference():
        print(f"{name}: fewer than two seeds of the reference")


def keep_prototype_scores(old, entry):
    """Takes over the prototype's scores where this run has not made them anew."""
    for label, figure in old.get("tpsnr_db", {}).items():
        if label.startswith("prototype_"):
            entry["tpsnr_db"].setdefault(label, figure)


def main():
    """Collects the scenes named on the command line, or all that were rendered."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workdir", type=Path)
    parser.add_argument("outdir", type=Path)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--prototype", type=Path, help="writable copy, to score it")
    parser.add_argument("--no-views", action="store_true", help="do not write views")
    options = parser.parse_args()
    options.outdir.mkdir(parents=True, exist_ok=True)
    manifest_path = options.outdir / "manifest.json"
    manifest = json.loads(manifest_path.read_text()) if manifest_path.exists() else {}
    names = options.scenes or [
        name
        for name in (*VIEW_SCENES, *SMALL_SCENES, *LIGHT_SCENES)
        if (options.workdir / f"{name}_pinhole.exr").exists()
    ]
    for name in LONE_REFERENCES:
        is_wanted = name in options.scenes or not options.scenes
        if is_wanted and len(seeds_of(options.workdir, name)) > 1:
            collect_mean(options.workdir, options.outdir, name)
    for name in names:
        if name in LONE_REFERENCES:
            continue
        if name in LIGHT_SCENES:
            collect_lights(options.workdir, options.outdir, name)
            continue
        entry = collect(options.workdir, options.outdir, name, options)
        keep_prototype_scores(manifest.get(name, {}), entry)
        manifest[name] = entry
        print(name, json.dumps(entry["tpsnr_db"]))
        manifest_path.write_text(json.dumps(manifest, indent=1) + "\n")


if __name__ == "__main__":
    main()
