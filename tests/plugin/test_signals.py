# SPDX-License-Identifier: Apache-2.0
"""Signals during the work of the Python extension: Ctrl-C ends it."""

import signal
import threading

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


@pytest.fixture
def stop_again():
    """A signal every fiftieth of a second, whose handler raises when it is called for the
    third time. Those that come before any is handled count as one.
    """
    called = []

    def stop(number, frame):
        called.append(number)
        if len(called) == 3:
            signal.setitimer(signal.ITIMER_REAL, 0)
            raise Stopped

    before = signal.signal(signal.SIGALRM, stop)
    yield lambda: signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


def speckled():
    """Colours, and a depth that lacks each third pixel, of which filling takes seconds."""
    rng = np.random.default_rng(2)
    colour = rng.random((1600, 2400, 3), np.float32)
    depth = np.ones((1600, 2400), np.float32)
    depth[rng.random(depth.shape) < 0.3] = 0
    return colour, depth


def test_signals_end_a_comparison(stop_again):
    """It has no progress to report: it works beside the thread that handles them."""
    colour, _ = speckled()
    stop_again()
    with pytest.raises(Stopped):
        rackfocus.compare(colour, colour[::-1])


def test_signals_end_the_filling_of_a_depth(stop_again):
    colour, depth = speckled()
    stop_again()
    with pytest.raises(Stopped):
        rackfocus.fill_depth(depth, colour, always=True)
    assert (depth == 0).any()  # the last rows are as they were


def test_depth_is_filled_by_bands_as_at_once():
    """Rows are filled some at a time, with what they look at above and below."""
    colour, depth = (plane[:200, :300].copy() for plane in speckled())
    whole = depth.copy()
    n, share = rackfocus.fill_depth(whole, colour, always=True)
    assert n == (whole != depth).sum() > 10000 and 0.2 < share < 0.7
    for y in (32, 64, 160):  # borders of bands
        part = depth[y - 10 : y + 10].copy()
        rackfocus.fill_depth(part, colour[y - 10 : y + 10], always=True)
        assert (part[5:15] == whole[y - 5 : y + 5]).all()


def test_other_threads_compare_and_fill():
    """Signals are handled on the main thread alone; others wait for their own work."""
    colour, depth = (plane[:60, :80].copy() for plane in speckled())
    found = []

    def work():
        found.append(rackfocus.compare(colour, colour)["identical"])
        found.append(rackfocus.fill_depth(depth, colour, always=True)[0] > 0)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [True, True]
