# SPDX-License-Identifier: Apache-2.0
"""One striped plane panned: pixels and lens without noise (measure_pan.py)."""

import measure_pan
import numpy as np
import test_pan
from deepscene import tpsnr


def test_a_plane_flickers_no_more_than_through_the_lens(monkeypatch, binary):
    """In linear light; what is bright beside something dark is spread like the rest."""
    monkeypatch.setenv("RACKFOCUS", binary)
    shifts = [i * measure_pan.STEP for i in range(measure_pan.N_FRAMES)]
    inner = np.s_[:, :, measure_pan.BORDER : -measure_pan.BORDER]
    want = np.stack([measure_pan.lens(shift, False) for shift in shifts])[inner]
    strips = [measure_pan.Strip(shift, 0, False) for shift in shifts]

    def make(path, i):
        test_pan.write(path, measure_pan.flat_pixels(strips[i]))

    got = np.stack(measure_pan.filtered(make))[inner]
    flicker = measure_pan.flicker_linear
    assert flicker(got) < 1.1 * flicker(want)
    assert test_pan.flicker(got) < 1.7 * test_pan.flicker(want)
    assert tpsnr(got, want) > 47
