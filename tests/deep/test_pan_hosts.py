# SPDX-License-Identifier: Apache-2.0
"""The pan against Cycles' own lens with 256 samples, rendered by measure_hosts.py."""

import measure_hosts
import measure_pan
import numpy as np
import pytest
import test_pan

INNER = np.s_[..., measure_pan.BORDER : -measure_pan.BORDER, :]


@pytest.fixture(autouse=True)
def command(monkeypatch, binary):
    monkeypatch.setenv("RACKFOCUS", binary)


def flicker(frames):
    return test_pan.flicker(np.stack(frames)[INNER])


def test_a_plane_of_64_samples_flickers_less(tmp_path):
    """Cycles' pinhole, a quarter of the samples: 0.28 of the flicker."""
    pinholes = measure_hosts.kept("pan_wall_pinhole_64.exr")
    depth = np.full((*pinholes.shape[1:3], 1), 14.0)

    def make(path, i):
        test_pan.write(path, np.concatenate([pinholes[i], depth], -1).astype("f4"))

    ours = flicker(measure_pan.filtered(make))
    theirs = flicker(measure_hosts.kept("pan_wall_cycles_256.exr"))
    print("ratio", ours / theirs)
    assert ours < 0.35 * theirs


def test_eight_views_flicker_less():
    """A post before the wall, from views of exact pixels: 0.4 of the flicker."""
    ours = flicker(measure_pan.merged(8, True))
    theirs = flicker(measure_hosts.kept("pan_post_cycles_256.exr"))
    print("ratio", ours / theirs)
    assert ours < 0.5 * theirs
