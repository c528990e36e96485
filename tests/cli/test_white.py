# SPDX-License-Identifier: Apache-2.0
"""Pictures that are much darker or brighter than a display: lamps are told all the same."""

import re

import numpy
import plainexr
import pytest

LENS = ("--focus-distance", 3, "--lens-radius", 0.3, "--focal-length-px", 60)


@pytest.fixture
def lamps(tmp_path):
    """Makes a file whose lamps stand out, `by` times as bright."""

    def make(by=1.0, base=0.4, attributes=None, size=(80, 96)):
        y, x = numpy.mgrid[: size[0], : size[1]]
        near = abs(x - size[1] // 2) < 8
        light = numpy.where(near, base, base * (0.2 + 0.1 * ((x // 5 + y // 5) % 2)))
        light[(x % 31 == 7) & (y % 23 == 11)] = 300
        colours = {c: (light * k * by) for c, k in zip("RGB", (1, 0.9, 0.7))}
        channels = {**colours, "Z": numpy.where(near, 3, 12)}
        path = tmp_path / f"lamps_{by:g}_{base:g}.exr"
        floats = {k: v.astype(numpy.float32) for k, v in channels.items()}
        return plainexr.write(path, floats, attributes)

    return make


@pytest.fixture
def filtered(rackfocus, tmp_path):
    """(pixels, white that was taken or None) of what filter makes."""

    def run(passes, *options):
        out = tmp_path / "out.exr"
        words = ("-o", out, "--type", "float", *LENS, *options)
        said = rackfocus("filter", passes, *words).stdout
        found = re.search(r", white ([\d.e+-]+)", said)
        channels, _ = plainexr.read(out)
        pixels = numpy.stack([channels[c] for c in "RGB"])
        return pixels, float(found[1]) if found else None

    return run


@pytest.mark.parametrize("by, base", [(1 / 128, 0.4), (1 / 32, 0.4), (32, 1), (256, 1)])
def test_brightness_changes_nothing_else(lamps, filtered, by, base):
    plain, white = filtered(lamps(base=base))
    assert white is None
    made, white = filtered(lamps(by, base))
    assert white == by
    assert numpy.array_equal(made, plain * numpy.float32(by))
    # With the white of a display lamps are no lamps, or everything is.
    assert not numpy.array_equal(filtered(lamps(by, base), "--white", 1)[0], made)


def test_windows_take_the_same_white(lamps, filtered):
    passes = lamps(1 / 128, size=(1600, 700))
    whole, white = filtered(passes, "--sub-apertures", 1)
    parts, also = filtered(passes, "--sub-apertures", 1, "--max-memory", 200)
    assert white == also == 1 / 128
    assert numpy.array_equal(whole, parts)


def test_what_the_header_and_the_user_say_counts(lamps, filtered):
    assert filtered(lamps(1 / 128, attributes={"rackfocus:white": 0.25}))[1] == 0.25
    passes = lamps(attributes={"rackfocus:white": 0.25})
    assert filtered(passes, "--white", 4)[1] == 4
    assert filtered(passes, "--white", 1)[1] is None


def test_pictures_that_can_be_meant_are_left_alone(lamps, filtered):
    """Half a display's white at the brightest, or half of it shown as white."""
    assert filtered(lamps(base=0.15))[1] is None
    assert filtered(lamps(base=10))[1] is None


@pytest.mark.parametrize("options", [(), ("--max-memory", 200)])
def test_lamps_on_black_are_lamps(tmp_path, filtered, options):
    """All that has light would be white: in a few pixels these are lamps, with the discs of
    a display's white (they were soft patches); more is a bright thing in another unit.
    """
    size = (1600, 700) if options else (120, 130)  # that windows have work
    light = numpy.zeros(size, numpy.float32)
    light[20::40, 20::40] = 300
    far = numpy.full_like(light, 12)

    def white(name):
        path = plainexr.write(
            tmp_path / name, {**dict.fromkeys("RGB", light), "Z": far}
        )
        words = ("--sub-apertures", 1, *options)
        return filtered(path, *words), filtered(path, *words, "--white", 1)[0]

    (made, found), of_display = white("lamps.exr")
    assert found is None and numpy.array_equal(made, of_display)
    lamp = made[1][10:31, 10:31]  # a disc of 4.5 px
    assert (lamp > 0.9 * 270 / (numpy.pi * 4.5**2)).sum() > 0.7 * numpy.pi * 4.5**2
    light[30:40] = 300
    if not options:
        assert white("thing.exr")[0][1] == 1024


def test_no_light_is_no_white(scene, filtered):
    def darken(channels):
        for c in "RGB":
            channels[c][:] = 0

    pixels, white = filtered(scene(change=darken))
    assert white is None and (pixels == 0).all()


def test_a_white_without_sense_is_refused(lamps, rackfocus, tmp_path):
    out = tmp_path / "out.exr"
    done = rackfocus("filter", lamps(), "-o", out, *LENS, "--white", 0, code=2)
    assert "--white" in done.stderr and not out.exists()
