# SPDX-License-Identifier: Apache-2.0
"""What filters share, named views, deep frames, windows, warnings."""

import os
import signal
import subprocess
import sys
import threading
import warnings

import numpy as np
import pytest
import rackfocus
from test_plugin import LENS, make_frame


def picture(colour, depth, **options):
    out = np.empty_like(colour)
    height, width = depth.shape
    rackfocus.Filter(width, height, **LENS, **options).process(colour, depth, out)
    return out


# ---- contexts ------------------------------------------------------------------------


def test_filters_share_a_context():
    colour, depth = make_frame()
    context = rackfocus.Context(threads=3)
    assert context.threads == 3 and context.cpu == rackfocus.cpu_level()
    alone = picture(colour, depth)
    assert (picture(colour, depth, context=context) == alone).all()
    assert (rackfocus.apply(colour, depth, context=context, **LENS) == alone).all()
    made = rackfocus.Filter(60, 40, context=context, **LENS)
    assert made.threads == 3
    total = rackfocus.accumulate([colour, colour], context=context)
    assert np.allclose(total, colour)
    del context  # the filter holds it
    out = np.empty_like(colour)
    made.process(colour, depth, out)
    assert (out == alone).all()


def test_a_context_serves_several_threads():
    colour, depth = make_frame()
    context, want, found = rackfocus.Context(threads=1), picture(colour, depth), []

    def work():
        found.append(picture(colour, depth, context=context))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 and all((one == want).all() for one in found)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_child_filters():
    """With threads of its own: those of its parent are not there."""
    colour, depth = make_frame(300, 200)
    context = rackfocus.Context(threads=2)
    want = picture(colour, depth, context=context)
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        is_same = (picture(colour, depth, context=context) == want).all()
        os._exit(0 if is_same else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert (picture(colour, depth, context=context) == want).all()


def test_the_bound_of_memory():
    colour, depth = make_frame(400, 600)
    context = rackfocus.Context(max_bytes=1 << 20)
    with pytest.raises(MemoryError):
        picture(colour, depth, context=context)
    picture(colour, depth, context=rackfocus.Context(max_bytes=1 << 30))
    with pytest.raises(MemoryError, match=r": [1-9]\d* bytes were needed"):
        picture(colour, depth, context=rackfocus.Context(max_bytes=1))


def test_the_log_hears_remarks(build):
    """A system that gives fewer threads than were asked for."""
    subprocess.run(["ninja", "-C", build, "tests/faults/libfailing.so"], check=True)
    code = """
import numpy, rackfocus
context = rackfocus.Context(threads=4, log=print)
frame = numpy.full((64, 64, 4), 5, "f")
rackfocus.apply(frame, frame[:, :, 0], context=context)
print(context.threads)
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={
            **os.environ,
            "LD_PRELOAD": str(build / "tests" / "faults" / "libfailing.so"),
            "FAIL_THREAD": "2",
            "OPENBLAS_NUM_THREADS": "1",  # of the NumPy that is installed
            "PYTHONPATH": os.pathsep.join(sys.path),
        },
        capture_output=True,
        text=True,
    )
    assert done.stdout == "warning only 2 of 4 threads can be made here\n2\n", done


@pytest.mark.parametrize(
    "keywords, error",
    [
        ({"cpu": "abacus"}, rackfocus.ParameterError),
        ({"threads": -2}, rackfocus.ParameterError),
        ({"max_bytes": -1}, rackfocus.ParameterError),
        ({"log": 3}, TypeError),
        ({"lenses": 3}, TypeError),
    ],
)
def test_wrong_contexts(keywords, error):
    with pytest.raises(error):
        rackfocus.Context(**keywords)


def test_threads_belong_to_the_context():
    with pytest.raises(TypeError, match="threads: belong to the context"):
        rackfocus.Filter(4, 4, context=rackfocus.Context(), threads=2)
    with pytest.raises(TypeError, match="a rackfocus.Context is needed"):
        rackfocus.Filter(4, 4, context=3)


# ---- views ---------------------------------------------------------------------------


def test_views_have_names():
    colour, depth = make_frame()
    made = rackfocus.Filter(60, 40, method="views", **LENS)
    places = [(0.02, 0.0), (-0.01, 0.02)]
    out, want = np.empty_like(colour), np.empty_like(colour)
    made.process_views(
        [rackfocus.View(colour, depth, place, shear_distance=2.0) for place in places],
        out,
    )
    made.process_views([(colour, depth, place, 2.0) for place in places], want)
    assert (out == want).all()
    assert rackfocus.View(colour, depth).lens_offset == (0, 0)


# ---- the kind of depth ---------------------------------------------------------------


def test_apply_takes_the_kind_of_depth():
    colour, depth = make_frame()
    planar = rackfocus.apply(colour, depth, **LENS)
    radial = rackfocus.apply(colour, depth, depth="radial", **LENS)
    assert not (planar == radial).all()


# ---- deep frames ---------------------------------------------------------------------


def deep_of(colour, depth):
    """The flat picture as one opaque sample per pixel."""
    n = depth.size
    samples = np.empty((n, 7), np.float32)
    samples[:, 0] = samples[:, 1] = depth.ravel()
    samples[:, 2:5] = colour[..., :3].reshape(n, 3)
    samples[:, 5] = samples[:, 6] = 1
    return np.arange(n + 1, dtype=np.uint64), samples


def test_a_deep_frame_flattens_to_the_flat_one():
    colour, depth = make_frame(channels=3)
    first, samples = deep_of(colour, depth)
    made = rackfocus.Filter(60, 40, **LENS)
    flat, far = np.empty_like(colour), np.empty_like(depth)
    made.flatten(first, samples, flat, far)
    assert (flat == colour).all() and (far == depth).all()
    out = np.empty_like(colour)
    made.process_deep(first, samples, out)
    assert np.isfinite(out).all() and not (out == colour).all()
    sharp = rackfocus.Filter(60, 40, **{**LENS, "f_stop": 1e6})
    sharp.process_deep(first, samples, out)
    assert np.allclose(out, colour, atol=1e-5)


@pytest.mark.parametrize("what", ["length", "fall", "end", "columns", "type"])
def test_wrong_deep_frames(what):
    colour, depth = make_frame(channels=3)
    first, samples = deep_of(colour, depth)
    if what == "length":
        first = first[:-1].copy()
    elif what == "fall":
        first[5] = 9
    elif what == "end":
        samples = samples[:-1].copy()
    elif what == "columns":
        samples = samples[:, :6].copy()
    else:
        first = first.astype(np.float64)
    made = rackfocus.Filter(60, 40, **LENS)
    with pytest.raises(ValueError, match="samples" if what == "columns" else "first"):
        made.process_deep(first, samples, np.empty_like(colour))


# ---- windows -------------------------------------------------------------------------


def test_windows_have_the_bits_of_the_whole():
    colour, depth = make_frame(150, 200, channels=3)
    height, width = depth.shape
    made = rackfocus.Filter(width, height, **LENS)
    whole, pieces = np.empty_like(colour), np.empty_like(colour)
    made.process(colour, depth, whole)

    def part(array, window):
        x, y, w, h = window
        return array[y : y + h, x : x + w]

    survey, margin = made.new_survey(), rackfocus.SURVEY_MARGIN
    for y in range(0, height, 75):
        top, end = max(y - margin, 0), min(y + 75 + margin, height)
        given = rackfocus.Window(0, top, width, end - top)
        made.count(
            survey, part(colour, given), part(depth, given), given, (0, y, width, 75)
        )
    for kept in [(0, 0, 90, 150), (90, 0, 110, 70), (90, 70, 110, 80)]:
        given = made.window(survey, kept)
        made.process_window(
            survey,
            *(part(colour, given), part(depth, given)),
            *(given, kept),
            part(pieces, kept),
        )
    assert (pieces == whole).all()


def test_a_survey_that_is_none():
    made = rackfocus.Filter(4, 4, **LENS)
    for survey in (object(), None, 3):
        with pytest.raises(TypeError, match="^survey: what new_survey"):
            made.window(survey, (0, 0, 4, 4))


# ---- warnings ------------------------------------------------------------------------


def test_a_parameter_without_effect_is_warned_of():
    colour, depth = make_frame()
    with pytest.warns(rackfocus.UnreadParameterWarning, match="blades: has no effect"):
        rackfocus.apply(colour, depth, method="scatter", blades=6, **LENS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rackfocus.apply(colour, depth, method="scatter", blades=0, **LENS)
        rackfocus.apply(colour, depth, blades=6, **LENS)
        with pytest.raises(rackfocus.UnreadParameterWarning):
            rackfocus.apply(colour, depth, box_repeats=3, **LENS)


def test_a_picture_that_nothing_reads():
    """Neither the picture nor a keyword that is none goes by in silence."""
    colour, depth = make_frame(channels=3)
    ramp = np.outer(np.arange(1, 9), np.arange(1, 6)).astype(np.float32)
    plain = rackfocus.apply(colour, depth, **LENS)
    told = pytest.warns(
        rackfocus.UnreadParameterWarning, match="distribution_image: has no effect"
    )
    with told:
        image = rackfocus.apply(colour, depth, distribution_image=ramp, **LENS)
    assert (image == plain).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        image = rackfocus.apply(
            colour, depth, distribution_image=ramp, aperture="image", **LENS
        )
    assert np.abs(image - plain).max() > 0.01
    with pytest.raises(rackfocus.ParameterError, match="no parameter aperture_image"):
        rackfocus.apply(colour, depth, aperture_image=ramp, **LENS)
