# SPDX-License-Identifier: Apache-2.0
"""Averaged and negative depth of other kinds than distances: z-buffers, normalised."""

import numpy
import plainexr
import pytest
import test_depth_kinds
from test_depth_kinds import LENS, PLAIN, SIZE, difference, mix, smooth_disc

filtered = test_depth_kinds.filtered


KINDS = {  # of a depth z between 0.1 and 1000, as the file has it
    "normalised": lambda z: (z - 0.1) / 999.9,
    "normalised --depth-scale -1 --depth-offset 1": lambda z: (1000 - z) / 999.9,
    "buffer": lambda z: 1000 * (z - 0.1) / (999.9 * z),
    "buffer-reversed": lambda z: 0.1 * (1000 - z) / (999.9 * z),
    "buffer-infinite": lambda z: 1 - 0.1 / z,
    "buffer-reversed-infinite": lambda z: 0.1 / z,
    "inverse": lambda z: 1 / z,
}


@pytest.mark.parametrize("kind", KINDS)
def test_anti_aliased_in_the_kind_of_the_file(filtered, kind):
    """A z-buffer has 0.967 at 3 and 0.992 at 12: no ratio there tells a step."""
    ends = ["--depth-near", "0.1", "--depth-far", "1000"]
    options = ["--depth", *kind.split()]
    options += ends[: 0 if kind == "inverse" else 2 if "infinite" in kind else 4]

    def averaged(channels):
        share = smooth_disc(channels, 18, 2)
        near, far = (KINDS[kind](numpy.float64(z)) for z in (3, 12))
        mix(share, 12, channels)
        channels["Z"] = (share * near + (1 - share) * far).astype("f4")

    def one_sample(channels):
        mix(smooth_disc(channels, 18, 2), 12, channels)
        share = smooth_disc(channels, 18, 2)
        channels["Z"] = KINDS[kind](numpy.where(share < 0.5, 12, 3)).astype("f4")

    want, said = filtered(one_sample, *options)
    assert said == ""
    got, said = filtered(averaged, *options)
    assert "was anti-aliased" in said
    as_it_is, said = filtered(averaged, *options, "--depth-repair", "off")
    assert said == ""
    error = {n: abs(got[n] - want[n]).mean() for n in got}
    before = {n: abs(as_it_is[n] - want[n]).mean() for n in got}
    assert all(error[n] < 0.3 * before[n] for n in got)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ends", [(0.1, 1000), (2.9, 40)])
def test_thin_things_before_the_far_end(rackfocus, scene, tmp_path, kind, ends):
    """What takes part of a pixel before nothing becomes itself or nothing."""
    near, far = ends

    def change(channels):
        height, width = channels["Z"].shape
        y, x = numpy.mgrid[0:height, 0:width]
        share = smooth_disc(channels, 14, 2)
        for at_x, at_y in ((6, 8.4), (40.3, 4), (90.5, 30.2), (3, 55.7)):
            lamp = numpy.clip(1.2 - numpy.hypot(x - at_x, y - at_y) + 0.5, 0, 1)
            share = share + lamp
        deep = numpy.float64(far)
        values = {  # at the thing and where nothing is
            "normalised": ((3 - near) / (deep - near), 1),
            "normalised --depth-scale -1 --depth-offset 1": (
                (deep - 3) / (deep - near), 0
            ),
            "buffer": (deep * (3 - near) / ((deep - near) * 3), 1),
            "buffer-reversed": (near * (deep - 3) / ((deep - near) * 3), 0),
            "buffer-infinite": (1 - near / 3, 1),
            "buffer-reversed-infinite": (near / 3, 0),
            "inverse": (1 / 3, 0),
        }[kind]  # fmt: skip
        channels["Z"] = (share * values[0] + (1 - share) * values[1]).astype("f4")
        for name in "RGB":
            channels[name] = share.astype("f4")

    options = ["--depth", *kind.split()]
    for name, end in (("near", near), ("far", far)):
        if kind != "inverse" and not (name == "far" and "infinite" in kind):
            options += [f"--depth-{name}", str(end)]
    coc = tmp_path / "coc.exr"
    done = rackfocus(
        "filter", scene(size=SIZE, change=change), "-o", tmp_path / "o.exr", *LENS,
        "--output-coc", coc, *PLAIN, *options,
    )  # fmt: skip
    assert "was anti-aliased" in done.stderr
    radii = plainexr.read(coc)[0]["Y"]
    thing, nothing = (10 * (1 / 6 - 1 / z) for z in (3, numpy.inf))
    is_thing, is_nothing = abs(radii - thing) < 0.05, abs(radii - nothing) < 0.05
    assert radii.min() > thing - 0.05
    assert (is_thing | is_nothing).mean() > 0.98
    assert 0.8 < is_thing.sum() / (numpy.pi * 14**2) < 1.2


def test_normalised_depth_below_0_is_no_distance(filtered):
    """0 to -1: --depth-scale -1 makes it positive, and no distance of it."""
    ends = ["--depth", "normalised", "--depth-near", "0", "--depth-far", "20"]

    def normalise(channels, sign=1, offset=0):
        z = channels["Z"]
        z[:] = sign * numpy.where(z > 10, 1, z / 20) + offset

    want, said = filtered(normalise, *ends)
    assert said == ""
    for options in ([], ends):  # of the kind, nothing was said so far
        _, said = filtered(lambda c: normalise(c, -1), *options, code=1)
        assert "is negative everywhere" in said and "say --depth-scale -1" in said
    turn = ["--depth-scale", "-1"]
    _, said = filtered(lambda c: normalise(c, -1), *turn, code=1)
    assert "like normalised depth" in said and "--depth planar if they are" in said
    assert "--depth-scale 1 --depth-offset 1 in place of --depth-scale -1" in said
    got, said = filtered(lambda c: normalise(c, -1), *turn, *ends)
    assert said == "" and all((got[name] == want[name]).all() for name in got)
    # Near is -1, far is 0: 1 + value.
    white_near = [*ends, "--depth-scale", "1", "--depth-offset", "1"]
    got, said = filtered(lambda c: normalise(c, 1, -1), *white_near)
    assert said == "" and difference(got, want) < 1e-4
    _, said = filtered(lambda c: normalise(c, -1), *turn, "--depth", "planar")
    assert "look like" not in said
