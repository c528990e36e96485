# SPDX-License-Identifier: Apache-2.0
"""Filter.merge_denoised(): views without grain give way where they are wrong."""

import numpy as np
import pytest
import rackfocus

HEIGHT, WIDTH, N = 64, 96, 4
LENS = {"focus_distance": 2, "lens_radius": 0.02, "focal_length_px": 100}
PLACES = ((0.01, 0.01), (-0.01, 0.01), (-0.01, -0.01), (0.01, -0.01))
DEPTH = np.full((HEIGHT, WIDTH), 4, np.float32)  # blurs by half a pixel


def colours(seed, sigma, wrong=0.0):
    """(with grain, without it but off by `wrong`) of views of a grey wall."""
    rng = np.random.default_rng(seed)
    grey = np.full((HEIGHT, WIDTH, 4), 0.5, np.float32)
    grainy, clean = [], []
    for _ in range(N):
        grain = rng.normal(0, sigma, (HEIGHT, WIDTH, 3)).astype(np.float32)
        grainy.append(
            grey + np.concatenate([grain, np.zeros_like(DEPTH)[..., None]], -1)
        )
        clean.append(grey + np.float32([wrong, wrong, wrong, 0]))
    return grainy, clean


def views_of(grainy):
    return [(c, DEPTH, place, 2.0) for c, place in zip(grainy, PLACES, strict=True)]


def merge(grainy, clean, **about):
    out = np.empty((HEIGHT, WIDTH, 4), np.float32)
    made = rackfocus.Filter(WIDTH, HEIGHT, method="views", **LENS, **about)
    made.merge_denoised(views_of(grainy), clean, out)
    return out


def plain(colour):
    out = np.empty((HEIGHT, WIDTH, 4), np.float32)
    made = rackfocus.Filter(WIDTH, HEIGHT, method="views", **LENS)
    made.process_views(views_of(colour), out)
    return out


def error(picture):
    return float(np.sqrt(np.mean((picture[..., :3] - 0.5) ** 2)))


def test_right_views_without_grain_stay():
    """The grain is the larger error: less than a tenth of it comes back."""
    grainy, clean = colours(1, 0.1)
    assert error(merge(grainy, clean)) < 0.1 * error(plain(grainy))


def test_wrong_views_without_grain_give_way():
    """All are off in the same way by several times the grain of the merge."""
    grainy, clean = colours(2, 0.05, wrong=0.1)
    assert error(merge(grainy, clean)) < 0.4 * error(plain(clean))


def test_the_mixture_is_better_than_both():
    """Where both errors are as large, in each half of the picture another one."""
    grainy, clean = colours(3, 0.08, wrong=0.04)
    made, both = error(merge(grainy, clean)), (
        error(plain(grainy)),
        error(plain(clean)),
    )
    assert made < min(both), (made, both)


@pytest.mark.filterwarnings("error::rackfocus.ViewsWarning")
def test_grain_of_dark_things_stays_out():
    """Few bright samples on black: with signs changed they are below 0."""
    rng = np.random.default_rng(10)
    black = np.full((HEIGHT, WIDTH, 4), (0.02, 0.02, 0.02, 1), np.float32)
    clean = [black.copy() for _ in range(N)]
    grainy = [view.copy() for view in clean]
    for view in grainy:
        view[..., :3] *= (rng.random((HEIGHT, WIDTH, 1)) < 0.05) * 20
    off = error(plain(grainy) + 0.48)
    assert error(merge(grainy, clean) + 0.48) < 0.1 * off, off


def test_grain_beside_what_is_wrong_stays_out():
    """A bright square of the clean views is wrong; 12 px from it all is grain."""
    grainy, clean = colours(11, 0.05)
    for view in clean:
        view[20:44, 10:34, :3] += 0.4
    made = merge(grainy, clean)
    assert error(made[24:40, 14:30]) < 0.15  # of 0.4
    assert error(made[:, 46:]) < 0.1 * error(plain(grainy)[:, 46:])


def test_what_is_the_same_is_merged_as_it_is():
    grainy, _ = colours(4, 0.1)
    assert np.array_equal(merge(grainy, grainy), plain(grainy))


def test_alpha_is_kept_and_nan_refused():
    grainy, clean = colours(5, 0.1)
    for view in grainy + clean:
        view[..., 3] = 0.25
    made = merge(grainy, clean)
    assert np.allclose(made[..., 3][20:-20, 20:-20], 0.25, atol=1e-5)
    grainy[1][10, 10] = np.nan
    with pytest.raises(rackfocus.PixelError):
        merge(grainy, clean)


def test_the_same_bits_on_any_number_of_threads():
    grainy, clean = colours(6, 0.1, wrong=0.05)
    assert np.array_equal(
        merge(grainy, clean, threads=1), merge(grainy, clean, threads=3)
    )


def test_one_channel():
    grainy, clean = (
        [view[..., 0].copy() for view in views] for views in colours(7, 0.1, 0.2)
    )
    out = np.empty((HEIGHT, WIDTH), np.float32)
    made = rackfocus.Filter(WIDTH, HEIGHT, method="views", **LENS)
    made.merge_denoised(views_of(grainy), clean, out)
    assert abs(out.mean() - 0.5) < 0.07  # of 0.2


def test_progress_and_cancelling():
    grainy, clean = colours(8, 0.1)
    out = np.empty((HEIGHT, WIDTH, 4), np.float32)
    made = rackfocus.Filter(WIDTH, HEIGHT, method="views", **LENS)
    told = []
    made.merge_denoised(views_of(grainy), clean, out, told.append)
    assert told == sorted(told) and told[-1] == 1 and told[0] <= 1 / 3
    with pytest.raises(rackfocus.CancelledError):
        made.merge_denoised(views_of(grainy), clean, out, lambda _: False)
    with pytest.raises(ZeroDivisionError):
        made.merge_denoised(views_of(grainy), clean, out, lambda _: 1 / 0)


def test_wrong_arguments_are_named():
    grainy, clean = colours(9, 0.1)
    out = np.empty((HEIGHT, WIDTH, 4), np.float32)
    made = rackfocus.Filter(WIDTH, HEIGHT, method="views", **LENS)
    views = views_of(grainy)
    with pytest.raises(ValueError, match="clean: 3 were given; 4 to 4"):
        made.merge_denoised(views, clean[:3], out)
    with pytest.raises(ValueError, match="clean of view 1"):
        made.merge_denoised(views, [clean[0], clean[1][1:], *clean[2:]], out)
    with pytest.raises(ValueError, match="out: must have the shape"):
        made.merge_denoised(views, clean, out[1:])
    small = [(c[1:], d[1:], place, 2.0) for c, d, place, _ in views]
    with pytest.raises(rackfocus.Error, match="96"):
        made.merge_denoised(small, [c[1:] for c in clean], out[1:])
