# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed add-on in every Blender: see inside/checks.py for what is checked."""

import json
import shutil
import zipfile

import numpy as np
import pytest
from checked import Checked, names_of, read_rgba
from conftest import ROOT, call, get_blender

SCRIPTS = ("picture_checks.py", "mirror_checks.py", "node_checks.py", "setup_checks.py")
NAMES = [name for script in SCRIPTS for name in names_of(script)]
NAMES.append("uninstall_leaves_nothing")
CHECKED = Checked("checks.py", "results.json")


@pytest.mark.parametrize("name", NAMES)
def test_check(blender, dist, name):
    """One check in one Blender."""
    CHECKED.expect(blender, dist, name)


def test_f12_is_the_command_on_the_same_passes(blender, dist, command):
    """Bit for bit, since everything stays float."""
    CHECKED.run(blender, dist)
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
    _, log = CHECKED.run(blender, dist)
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
    """F12 and Refocus save, read and filter the passes once each."""
    CHECKED.run(blender, dist)
    counted = json.loads((blender.out / "costly_steps.json").read_text())
    assert set(counted) == {"f12", "refocus"}
    assert all(n == 1 for calls in counted.values() for n in calls.values()), counted


def test_the_extension_is_valid(dist):
    """blender --command extension validate."""
    path = next(dist.glob("*-extension.zip"))
    newest = get_blender("newest")
    log = call(*newest.command("--command", "extension", "validate", path))
    assert "Success" in log


def test_the_extension_comes_from_a_repository(dist, tmp_path):
    """repo-add, sync and install from a folder with an index, by its file URL."""
    path = next(dist.glob("*-extension.zip"))
    named = path.name.replace("-extension", "-linux-x64-extension")
    shutil.copy(path, tmp_path / named)
    call("python3", ROOT / "packaging/repository.py", tmp_path)
    newest = get_blender("newest")
    home = tmp_path / "home"  # the other tests have the add-on from a file
    environment = {**newest.environment(), "HOME": str(home)}
    for name in ("RESOURCES", "CONFIG", "SCRIPTS", "EXTENSIONS"):
        environment[f"BLENDER_USER_{name}"] = str(home / name.lower())

    def extension(*words):
        words = ("--online-mode", "--command", "extension", *words)
        return call(*newest.command(*words), env=environment)

    url = (tmp_path / "index.json").as_uri()
    extension("repo-add", "--url", url, "--name", "files", "files")
    extension("sync")
    extension("install", "rack_focus", "--enable")
    assert "rack_focus" in extension("list").split("files", 1)[1]
    assert list(home.rglob("rack_focus/blender_manifest.toml"))


def test_the_zips_are_reproducible(dist, tmp_path):
    """The same sources, the same bytes."""
    call("python3", ROOT / "blender_addon/package.py", dist.parents[1], tmp_path)
    for path in dist.glob("*.zip"):
        assert path.read_bytes() == (tmp_path / path.name).read_bytes()
        names = zipfile.ZipFile(path).namelist()
        assert not any("package.py" in name or "__pycache__" in name for name in names)
