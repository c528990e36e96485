# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed add-on in every Blender: see inside/checks.py for what is checked."""

import json
import re
import zipfile

import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import INSIDE, ROOT, call, get_blender

NAMES = re.findall(r"^@check\ndef (\w+)", (INSIDE / "checks.py").read_text(), re.M)
NAMES.append("uninstall_leaves_nothing")
_results = {}


def results_of(blender, dist):
    """{check: "" or problem} of one run in one Blender."""
    if blender.version not in _results:
        log = ""
        try:
            log = blender.run("checks.py", dist, blender.out)
        except Exception as error:  # what was done before the end still counts
            log = str(error)
        path = blender.out / "results.json"
        found = json.loads(path.read_text()) if path.exists() else {}
        _results[blender.version] = found, log
    return _results[blender.version]


@pytest.mark.parametrize("name", NAMES)
def test_check(blender, dist, name):
    """One check in one Blender."""
    found, log = results_of(blender, dist)
    assert name in found, f"Blender ended before this check:\n{log[-3000:]}"
    assert not found[name], found[name]


def read_rgba(path):
    """(height, width, 4) of the picture in an EXR."""
    image = oiio.ImageBuf(str(path))
    pixels = image.get_pixels(oiio.FLOAT)
    names = [name.split(".")[-1] for name in image.spec().channelnames]
    order = [names.index(c) for c in "RGBA"]
    return pixels[..., order]


def test_f12_is_the_command_on_the_same_passes(blender, dist, command):
    """Bit for bit, since everything stays float."""
    results_of(blender, dist)
    lens = json.loads((blender.out / "lens.json").read_text())
    options = []
    for field, value in lens.items():
        options += [f"--{field.replace('_', '-')}", value]
    made = blender.out / "command.exr"
    call(
        command, "filter", blender.out / "passes.exr", "-o", made, "--layer",
        "ViewLayer", "--type", "float", "--quiet", *options,
    )  # fmt: skip
    a, b = read_rgba(made), read_rgba(blender.out / "filtered.exr")
    assert np.array_equal(a, b), np.abs(a - b).max()


def test_the_comparison_prints_the_scores(blender, dist):
    """All six figures, for the filter and for the picture as rendered."""
    _, log = results_of(blender, dist)
    lines = [x for x in log.splitlines() if "against the camera's own depth" in x]
    ours = next(line for line in lines if line.startswith("Rack Focus against"))
    without = next(line for line in lines if line.startswith("No depth of field"))
    scores = json.loads((blender.out / "scores.json").read_text())
    x, y = scores["max_error_pixel"]
    for text in (
        f"tPSNR {scores['tpsnr']:.2f} dB",
        f"PSNR {scores['psnr']:.2f} dB",
        f"SSIM {scores['ssim']:.6f}",
        f"RMSE {scores['rmse']:.6g}",
        f"energy ratio {scores['energy_ratio']:.6f}",
        f"maximum error {scores['max_error']:.6g} at pixel ({x}, {y})",
    ):
        assert text in ours, lines
    assert float(without.split("tPSNR ")[1].split()[0]) < scores["tpsnr"]


def test_the_node_costs_little(blender, dist):
    """Beside the filter's own time; the limit leaves room for a busy machine."""
    results_of(blender, dist)
    seconds = json.loads((blender.out / "overhead.json").read_text())
    print(blender.version, seconds)
    assert max(s["overhead"] for s in seconds.values()) < 0.6, seconds


def test_the_extension_is_valid(dist):
    """blender --command extension validate."""
    path = next(dist.glob("*-extension.zip"))
    newest = get_blender("newest")
    log = call(*newest.command("--command", "extension", "validate", path))
    assert "Success" in log


def test_the_zips_are_reproducible(dist, tmp_path):
    """The same sources, the same bytes."""
    call("python3", ROOT / "blender_addon/package.py", dist.parents[1], tmp_path)
    for path in dist.glob("*.zip"):
        assert path.read_bytes() == (tmp_path / path.name).read_bytes()
        names = zipfile.ZipFile(path).namelist()
        assert not any("package.py" in name or "__pycache__" in name for name in names)
