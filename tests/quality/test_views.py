# SPDX-License-Identifier: Apache-2.0
"""Eight views of an eighth of the samples each, against the hosts' own lenses.

`./dev test quality` prints the table of docs/views.md.
"""

import pytest
from test_quality import MANIFEST, REFERENCES, run, tpsnr

SCENES = ("posts", "portrait")
#: How far below the brute-force prototype (k = 4) a score may lie, dB.
SLACK_DB = 0.1
OVER_OWN_DB = 4
#: Over one view of all samples, where hidden background matters little, dB.
OVER_ONE_DB = 0.3


def view_files(scene, n=8):
    return [REFERENCES / f"{scene}_view{i:02}.exr" for i in range(n)]


@pytest.fixture(scope="module")
def scores(tmp_path_factory):
    """tPSNR per scene of the 8 views, and of the one pinhole view."""
    folder = tmp_path_factory.mktemp("views")
    table = {}
    for scene in SCENES:
        row = {}
        for name, inputs in (
            ("one", [REFERENCES / f"{scene}_pinhole.exr"]),
            ("views8", view_files(scene)),
        ):
            out = folder / f"{scene}_{name}.exr"
            run("filter", *inputs, "-o", out, "--sub-apertures", 4, "--type", "float")
            row[name] = tpsnr(out, scene)
        row["own"] = MANIFEST[scene]["tpsnr_db"]["own_dof_64"]
        table[scene] = row
        print(scene, " ".join(f"{key} {value:.2f}" for key, value in row.items()))
    return table


@pytest.mark.parametrize("scene", SCENES)
def test_reaches_the_prototype(scene, scores):
    prototype = MANIFEST[scene]["tpsnr_db"]["prototype_8_views_k4"]
    assert scores[scene]["views8"] >= prototype - SLACK_DB


@pytest.mark.parametrize("scene", SCENES)
def test_beats_cycles_at_equal_samples(scene, scores):
    assert scores[scene]["views8"] >= scores[scene]["own"] + OVER_OWN_DB


@pytest.mark.parametrize("scene", SCENES)
def test_beats_one_view(scene, scores):
    assert scores[scene]["views8"] >= scores[scene]["one"] + OVER_ONE_DB


def test_refocuses(tmp_path):
    focus = MANIFEST["posts"]["camera"]["focus"]
    same, near = tmp_path / "same.exr", tmp_path / "near.exr"
    run("filter", *view_files("posts"), "-o", same)
    run("filter", *view_files("posts"), "-o", near, "--focus-distance", focus * 0.7)
    assert tpsnr(near, "posts") < tpsnr(same, "posts") - 6
