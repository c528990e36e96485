# SPDX-License-Identifier: Apache-2.0
"""Lens looks against Cycles' rays through the same lens: references/looks.

One view with a look has to be as near to its reference as one of the plain disc is to
its own, less SLACK_DB: what a look adds is right then, whatever one view lacks anyway.
The references' own noise, which differs with the light of a look's discs, is taken off
first: noise and errors are independent, so their squares add up.
"""

import json
import math
import os
import pathlib
import subprocess

import pytest

LOOKS = pathlib.Path(__file__).parent / "references/looks"
MANIFEST = json.loads((LOOKS / "manifest.json").read_text())
COMMAND = os.environ["RACKFOCUS"]
SLACK_DB = 0.5


#: Where one view is still worse than that, dB, and why. Rims and rings have detail that
#: the coarse levels of a far wall soften: finer ones gain 0.2 dB for twice the time. A
#: split diopter lacks the background behind what its second focus blurs by 30 px, and
#: 0.4 dB for the steps of its soft border.
SHORT_DB = {"spherical": 0.3, "image": 1.2, "split_diopter": 2.1}


def run(*arguments):
    done = subprocess.run(
        [COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def options(look):
    """The filter's options of a look of the manifest."""
    for key, value in MANIFEST[look]["parameters"].items():
        if key == "picture":
            yield from ("--aperture-image", LOOKS / value)
        else:
            yield from (f"--{key.replace('_', '-')}", value)


def tpsnr(folder, look, with_look=True, views=(LOOKS / "pinhole.exr",)):
    """tPSNR of one view, or of several, against the reference of a look, dB."""
    out = folder / "out.exr"
    extra = list(options(look)) if with_look else []
    run("filter", *views, "-o", out, "--type", "float", *extra)
    word, value, unit = (
        run("compare", out, LOOKS / f"{look}.exr").splitlines()[-1].split()
    )
    assert (word, unit) == ("tPSNR", "dB")
    return float(value)


def true_db(score, look):
    """The tPSNR against a reference without noise."""
    noise = 10 ** (-MANIFEST[look]["noise_floor_db"] / 10)
    return -10 * math.log10(max(10 ** (-score / 10) - noise, 1e-6))


def score(folder, look, **what):
    return true_db(tpsnr(folder, look, **what), look)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return score(tmp_path_factory.mktemp("plain"), "plain")


@pytest.mark.parametrize("look", sorted(set(MANIFEST) - {"plain"}))
def test_a_look_is_as_good_as_the_disc(look, plain, tmp_path):
    ours, without = score(tmp_path, look), score(tmp_path, look, with_look=False)
    print(f"{look} {ours:.2f}, plain {plain:.2f}, without {without:.2f}")
    assert ours >= plain - SLACK_DB - SHORT_DB.get(look, 0)
    assert ours > without + 3, "the reference does not show the look"


#: What eight views gain over one, dB: with the plain disc, and with what bends the
#: surface in focus, as much or more. With cat's eyes one view is better by 1.6 to 1.9 dB,
#: and eight miss that by LESS_DB: what is left lies at lamps and at thin posts near the
#: border (docs/notebook/views.md).
LESS_DB = {"cat_eye": 1.2, "cat_eye_tilt": 1.6}


def test_several_views_gain_as_much_as_with_the_disc(tmp_path):
    gains = {}
    for look in ("plain", "tilt", "field_curvature", "cat_eye", "cat_eye_tilt"):
        views = sorted(LOOKS.glob("view*.exr"))
        several = score(tmp_path, look, views=views)
        gains[look] = several - score(tmp_path, look)
        print(f"{look}: 8 views {several:.2f}, {gains[look]:+.2f}")
    for look, gain in gains.items():
        assert gain >= gains["plain"] - LESS_DB.get(look, 0)
