# SPDX-License-Identifier: Apache-2.0
"""finish() warns of a guide of another lens or exposure, before it asks for a denoiser."""

import numpy as np
import pytest
import rackfocus

LENS = dict(lens_radius=0.3, focal_length_px=150)


@pytest.fixture(autouse=True)
def _no_denoiser(monkeypatch):
    """The environment's comes before the one that is asked for."""
    monkeypatch.delenv("RACKFOCUS_OIDN", raising=False)


@pytest.fixture(scope="module")
def passes():
    """A textured slope, colour and depth."""
    colour = np.random.default_rng(4).uniform(0.1, 1, (144, 192, 3)).astype(np.float32)
    depth = np.repeat(np.linspace(6, 14, 192, dtype=np.float32)[None], 144, 0)
    return colour, np.ascontiguousarray(depth)


@pytest.fixture(scope="module")
def own(passes):
    """Rendered with the lens, with grain."""
    lens = rackfocus.apply(*passes, focus_distance=10, **LENS)
    grain = np.random.default_rng(5).gamma(64, 1 / 64, lens.shape)
    return (lens * grain).astype(np.float32)


def finish(own, ours, **more):
    with pytest.raises(rackfocus.Error, match="Open Image Denoise"):
        rackfocus.finish(own, ours, library="/nowhere", **more)


@pytest.mark.parametrize("lens", [{"focus_distance": 8}, {"lens_radius": 0.6}])
def test_a_guide_of_another_lens_is_told(own, passes, lens, recwarn):
    ours = rackfocus.apply(*passes, **{"focus_distance": 10, **LENS, **lens})
    finish(own, ours, check=False)
    assert not recwarn.list
    finish(own, ours)
    (told,) = recwarn.list
    assert told.category is rackfocus.ViewsWarning and told.filename == __file__
    assert "own: is blurred in another way than ours in" in str(told.message)
    assert told.message.about == "lens"


def test_a_guide_of_another_exposure_is_told(own, passes):
    ours = rackfocus.apply(*passes, focus_distance=10, **LENS)
    with pytest.warns(rackfocus.ViewsWarning, match="is 2 times as bright") as told:
        finish(own, ours / 2)
    assert told[0].message.about == "light" and rackfocus.ViewsWarning.about == ""


def test_the_right_guide_is_not(own, passes, recwarn):
    finish(own, rackfocus.apply(*passes, focus_distance=10, **LENS))
    assert not recwarn.list


@pytest.mark.filterwarnings("error::rackfocus.ViewsWarning")
def test_a_warning_that_is_an_error_ends_it(own):
    with pytest.raises(rackfocus.ViewsWarning, match="as bright"):
        rackfocus.finish(own, own / 2, library="/nowhere")
