# SPDX-License-Identifier: Apache-2.0
"""What a flat mirror and a pane show, by its own depth, against Cycles' own lens."""

import os
import pathlib
import subprocess

import pytest

REFERENCES = pathlib.Path(__file__).parent / "references"
PINHOLE, VIEW = REFERENCES / "mirrors_pinhole.exr", REFERENCES / "mirrors_view07.exr"


def run(*arguments):
    """Run the command and return what it printed."""
    done = subprocess.run(
        [os.environ["RACKFOCUS"], *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def score(tmp_path_factory):
    """tPSNR in dB of what options make of the mirrors."""
    out = tmp_path_factory.mktemp("reflections") / "out.exr"

    def of(*options):
        run("filter", PINHOLE, "-o", out, "--type", "float", *options)
        words = run("compare", out, REFERENCES / "mirrors_reference.exr").split()
        assert words[-1] == "dB"
        print("mirrors", *(o for o in options if "exr" not in str(o)), words[-2])
        return float(words[-2])

    return of


def test_a_second_view_tells_what_is_seen(score):
    # 23.2 dB by the depth of the surfaces; a second view of 8 samples: 38.0.
    plain, own = score(), score("--reflections-from", VIEW)
    assert own >= plain + 14
    assert own >= 37.7


def test_a_preview_gains_as_well(score):
    preview = ("--quality", "preview")
    assert score(*preview, "--reflections-from", VIEW) >= score(*preview) + 10
