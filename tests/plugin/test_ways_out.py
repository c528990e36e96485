# SPDX-License-Identifier: Apache-2.0
"""Errors of the Python extension name what to do instead."""

import numpy as np
import pytest
import rackfocus

COLOUR = np.full((4, 6, 3), 0.5, np.float32)
DEPTH = np.ones((4, 6), np.float32)


@pytest.mark.parametrize(
    ("name", "meant"),
    [("fstop", "f_stop"), ("focus", "focus_distance"), ("fStop", "f_stop")],
)
def test_a_misspelt_keyword_names_what_was_meant(name, meant):
    with pytest.raises(rackfocus.ParameterError) as caught:
        rackfocus.apply(COLOUR, DEPTH, **{name: object()})
    assert caught.value.field == name
    assert (
        caught.value.message == f"there is no parameter {name}; did you mean {meant}?"
    )


def test_a_keyword_like_no_other_names_the_list():
    with pytest.raises(rackfocus.ParameterError, match=r"parameters\(\) lists them"):
        rackfocus.lens_points(4, xyzzy="plugh")


def test_channels_first_are_told_from_too_many_channels():
    """As PyTorch has them."""
    first = np.ascontiguousarray(COLOUR.transpose(2, 0, 1))
    with pytest.raises(rackfocus.ParameterError, match=r"colour\.transpose\(1, 2, 0\)"):
        rackfocus.apply(first, DEPTH)
    with pytest.raises(rackfocus.ParameterError) as caught:
        rackfocus.apply(np.zeros((6, 4, 5), np.float32), DEPTH)
    assert "transpose" not in caught.value.message


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.int32, ">u2"])
def test_whole_numbers_are_to_become_light_or_distances(kind):
    with pytest.raises(TypeError, match=r"give colour\.astype\(numpy\.float32\)"):
        rackfocus.apply(COLOUR.astype(kind), DEPTH)
    with pytest.raises(TypeError, match=r"give depth\.astype\(numpy\.float32\)"):
        rackfocus.apply(COLOUR, DEPTH.astype(kind))


def test_an_answer_that_is_neither_true_nor_false_ends_it():
    """An array of two is neither: its own error comes out, not Python's complaint of ours."""
    with pytest.raises(ValueError, match="ambiguous"):
        rackfocus.apply(COLOUR, DEPTH, progress=lambda done: np.zeros(2))
