# SPDX-License-Identifier: Apache-2.0
"""Scores against the hosts' own lenses: the pictures and bars of references/.

Prints one row per scene; the figures of README.md and docs come from here:
`./dev test quality`.
"""

import json
import os
import pathlib
import subprocess

import pytest

HERE = pathlib.Path(__file__).parent
REFERENCES = HERE / "references"
MANIFEST = json.loads((REFERENCES / "manifest.json").read_text())
COMMAND = os.environ["RACKFOCUS"]
#: How far below the brute-force prototype (k = 4) a score may lie, dB.
SLACK_DB = 0.1


def run(*arguments):
    """Run the command and return what it printed."""
    done = subprocess.run(
        [COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def tpsnr(picture, scene):
    """tPSNR in dB of a picture against the scene's reference."""
    out = run("compare", picture, REFERENCES / f"{scene}_reference.exr")
    word, value, unit = out.splitlines()[-1].split()
    assert (word, unit) == ("tPSNR", "dB")
    return float(value)


@pytest.fixture(scope="module")
def scores(tmp_path_factory):
    """tPSNR per scene of: the pinhole, one view with k = 1 and 4, the host's own."""
    folder = tmp_path_factory.mktemp("quality")
    table = {}
    for scene in MANIFEST:
        pinhole = REFERENCES / f"{scene}_pinhole.exr"
        if not (REFERENCES / f"{scene}_reference.exr").exists():
            continue
        row = {"pinhole": tpsnr(pinhole, scene)}
        for k in (1, 4):
            out = folder / f"{scene}_{k}.exr"
            run("filter", pinhole, "-o", out, "--sub-apertures", k, "--type", "float")
            row[f"k{k}"] = tpsnr(out, scene)
        for quality in ("preview", "normal"):
            out = folder / f"{scene}_{quality}.exr"
            run("filter", pinhole, "-o", out, "--quality", quality, "--type", "float")
            row[quality] = tpsnr(out, scene)
        out = folder / f"{scene}_mipmap.exr"
        run("filter", pinhole, "-o", out, "--method", "mipmap-offset")
        row["mipmap"] = tpsnr(out, scene)
        for name in ("dof64", "defocus"):
            path = REFERENCES / f"{scene}_{name}.exr"
            if path.exists():
                row[name] = tpsnr(path, scene)
        table[scene] = row
        print(scene, " ".join(f"{key} {value:.2f}" for key, value in row.items()))
    return table


@pytest.mark.parametrize("scene", MANIFEST)
def test_reaches_the_prototype(scene, scores):
    prototype = MANIFEST[scene]["tpsnr_db"].get("prototype_one_view_k4")
    assert prototype is not None, "the manifest lacks the prototype's score"
    assert scores[scene]["k4"] >= prototype - SLACK_DB


def test_a_pixel_of_one_surface_keeps_its_depth(scores):
    # Leaves at all depths: 27.6 dB where such a pixel took its neighbours' depth.
    assert scores["foliage"]["k4"] >= 28.3


def test_textures_go_on_beyond_the_border(scores):
    # Where edge pixels are repeated ortho has 41.8 dB, macro 31.4, posts 35.3, plane 40.7.
    assert scores["ortho"]["k4"] >= 42.2
    assert scores["macro"]["k4"] >= 31.6
    assert scores["posts"]["k4"] >= 35.4


def test_slanted_surfaces_cover_what_each_cell_sees(scores):
    # Without slants plane has 45.3 dB, portrait 36.1.
    assert scores["plane"]["k4"] >= 45.6
    assert scores["portrait"]["k4"] >= 36.2


@pytest.mark.parametrize("scene", MANIFEST)
def test_beats_the_pinhole(scene, scores):
    assert scores[scene]["k4"] >= scores[scene]["pinhole"] + 6


@pytest.mark.parametrize("scene", MANIFEST)
def test_more_cells_do_not_hurt(scene, scores):
    assert scores[scene]["k4"] >= scores[scene]["k1"] - 0.02


#: What normal quality loses at the most, dB. It loses as much light of macro as before
#: the border let outlines lean; with less error otherwise that is 0.12 dB, was 0.06.
NORMAL_DB = {"macro": 0.13}


@pytest.mark.parametrize("scene", MANIFEST)
def test_normal_quality_is_nearly_the_best(scene, scores):
    less = NORMAL_DB.get(scene, 0.1)
    assert scores[scene]["normal"] >= scores[scene]["k4"] - less


@pytest.mark.parametrize("scene", MANIFEST)
def test_the_preview_beats_the_real_time_family(scene, scores):
    assert scores[scene]["preview"] >= scores[scene]["mipmap"] + 1


def test_beats_cycles_at_equal_samples(scores):
    assert scores["posts"]["k4"] >= scores["posts"]["dof64"] + 3


@pytest.mark.parametrize("scene", ["posts", "portrait"])
def test_beats_the_defocus_node(scene, scores):
    assert scores[scene]["k4"] >= scores[scene]["defocus"] + 3


@pytest.mark.parametrize("scene", ["macro", "posts"])
def test_what_memory_held_before_does_not_matter(scene, tmp_path, monkeypatch):
    pictures = []
    for fill in ("0", "50", "200"):
        monkeypatch.setenv("MALLOC_PERTURB_", fill)
        out = tmp_path / f"{fill}.exr"
        run("filter", REFERENCES / f"{scene}_pinhole.exr", "-o", out)
        pictures.append(out.read_bytes())
    assert pictures[0] == pictures[1] == pictures[2]
