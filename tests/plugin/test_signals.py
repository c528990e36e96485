# SPDX-License-Identifier: Apache-2.0
"""Signals during the work of the Python extension: Ctrl-C ends it."""

import signal

import numpy as np
import pytest
import rackfocus

HEIGHT, WIDTH = 800, 1200
LENS = dict(focus_distance=2, lens_radius=0.5, focal_length_px=600)


def make_frame():
    """Random colours over a slanted depth."""
    colour = np.random.default_rng(1).random((HEIGHT, WIDTH, 3), np.float32)
    depth = np.linspace(1, 6, HEIGHT * WIDTH, dtype=np.float32)
    return colour, depth.reshape(HEIGHT, WIDTH)


class Stopped(Exception):
    """What the handler raises."""


@pytest.fixture
def stop_soon():
    """A signal's handler that raises, as Ctrl-C's does, a fifth of a second from the call."""

    def stop(number, frame):
        raise Stopped

    before = signal.signal(signal.SIGALRM, stop)
    yield lambda: signal.setitimer(signal.ITIMER_REAL, 0.2)
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


def one_filter(**params):
    """Of one thread, so that the work takes seconds."""
    return rackfocus.Filter(
        WIDTH, HEIGHT, context=rackfocus.Context(threads=1), **LENS, **params
    )


@pytest.mark.parametrize("progress", [None, [].append])
@pytest.mark.parametrize("is_deep", [False, True])
def test_signals_end_it(stop_soon, is_deep, progress):
    """Their handlers run during the work, not after it: the picture is not made."""
    colour, depth = make_frame()
    out = np.full_like(colour, np.nan)
    if is_deep:
        first = np.arange(depth.size + 1, dtype=np.uint64)
        samples = np.ones((depth.size, 7), np.float32)
        samples[:, 0] = samples[:, 1] = depth.ravel()
        given, work = (first, samples), one_filter().process_deep
    else:
        given, work = (colour, depth), one_filter(method="scatter").process
    stop_soon()
    with pytest.raises(Stopped):
        work(*given, out, progress=progress)
    assert np.isnan(out).any()
