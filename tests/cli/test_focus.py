# SPDX-License-Identifier: Apache-2.0
"""rackfocus focus: distances at pixels, and the pull that filter makes of them."""

import numpy
import pytest

SIZE = (48, 32)
DISC, WALL = (24, 16), (3, 4)  # pixels of the scene's disc and of its wall


@pytest.fixture
def shot(scene, tmp_path):
    """Four frames; what is near comes nearer."""
    for i in range(1, 5):

        def change(c, i=i):
            c["Z"][c["Z"] == 3] = 6 - i

        scene(f"shot.{i:04d}.exr", change=change)
    return tmp_path / "shot.####.exr"


def at(frame, place):
    return f"{frame}@{place[0]},{place[1]}"


def test_a_pull(rackfocus, shot, tmp_path):
    csv = tmp_path / "focus.csv"
    rackfocus("focus", shot, at(4, WALL), at(1, DISC), "-o", csv)
    want = ["frame,focus-distance,easing", "1,5,ease-in-out", "4,12,ease-in-out"]
    assert csv.read_text().splitlines() == want
    lens = ["--lens-radius", "0.1", "--focal-length-px", "100"]
    done = rackfocus(
        "filter",
        shot,
        "-o",
        tmp_path / "out.####.exr",
        *lens,
        "--frame-parameters",
        csv,
    )
    assert "4 frames: 4 filtered" in done.stdout
    for i, distance in ((1, 5), (4, 12)):
        one = tmp_path / "one.exr"
        name = f"shot.{i:04d}.exr"
        focus = ["--focus-distance", repr(distance)]
        rackfocus("filter", tmp_path / name, "-o", one, *lens, *focus)
        assert one.read_bytes() == (tmp_path / f"out.{i:04d}.exr").read_bytes()


def test_easing_and_standard_output(rackfocus, shot):
    done = rackfocus("focus", shot, at(2, DISC), at(3, DISC), "--easing", "linear")
    assert done.stdout.splitlines()[1:] == ["2,4,linear", "3,3,linear"]


def test_one_picture(rackfocus, shot, tmp_path):
    done = rackfocus("focus", tmp_path / "shot.0001.exr", "3,4")
    assert done.stdout == "--focus-distance 12\n"


def test_edges_are_one_side_or_the_other(rackfocus, scene, tmp_path):
    def change(c):
        c["Z"][:] = 2
        c["Z"][:, 20:] = 9
        c["Z"][7, 18] = 100  # a lone pixel

    scene("edge.exr", change=change)
    for x, want in ((18, "2"), (19, "2"), (20, "9")):
        done = rackfocus("focus", tmp_path / "edge.exr", f"{x},7")
        assert done.stdout == f"--focus-distance {want}\n"


def test_places_are_of_the_display_window(rackfocus, scene, tmp_path):
    width, height = SIZE
    data = (-5, -3, width - 6, height - 4)
    scene("over.exr", data=data, display=(0, 0, width - 11, height - 7))
    done = rackfocus("focus", tmp_path / "over.exr", "19,13")
    assert done.stdout == "--focus-distance 3\n"


def test_depth_kinds_count(rackfocus, scene, tmp_path):
    def change(c):
        c["Z"] = 1 / c["Z"]

    scene("inverse.exr", change=change)
    done = rackfocus("focus", tmp_path / "inverse.exr", "3,4", "--depth", "inverse")
    assert float(done.stdout.split()[1]) == pytest.approx(12, rel=1e-6)


@pytest.mark.parametrize(
    "picks, code, reason",
    [
        (["3,4"], 2, "as in 48@500,120"),
        (["x@3,4"], 2, "as in 48@500,120"),
        (["1@3"], 2, "as in 48@500,120"),
        (["1@3,4", "1@5,6"], 2, "two picks"),
        (["1@48,4"], 1, "lies outside of its 48 x 32 px"),
        (["9@3,4"], 1, "shot.0009.exr"),
        ([], 2, "what to pick"),
    ],
)
def test_wrong_picks(rackfocus, shot, tmp_path, picks, code, reason):
    csv = tmp_path / "focus.csv"
    done = rackfocus("focus", shot, *picks, "-o", csv, code=code)
    assert reason in done.stderr
    assert not csv.exists()


def test_nothing_there(rackfocus, scene, tmp_path):
    def change(c):
        c["Z"][:, :10] = 1e12

    scene("sky.exr", change=change)
    done = rackfocus("focus", tmp_path / "sky.exr", "3,4", code=1)
    assert "nothing was hit" in done.stderr


@pytest.mark.parametrize(
    "change, says",
    [
        (lambda z: -z, "--depth-scale -1"),
        (lambda z: z / 12, "say --depth normalised"),
        (lambda z: 1.9 / z * (z < 6) * numpy.linspace(0.5, 2.5, 48), "depth inverse"),
    ],
)
def test_what_filter_refuses(rackfocus, scene, tmp_path, change, says):
    """A distance of such numbers is as wrong as a picture."""

    def make(c):
        c["Z"] = change(c["Z"])

    path = scene("bad.exr", change=make)
    reasons = []
    for command in (
        ["focus", path, "24,16"],
        ["filter", path, "-o", tmp_path / "o.exr"],
    ):
        done = rackfocus(*command, code=1)
        assert says in done.stderr and done.stdout == ""
        reasons.append(done.stderr.splitlines()[-1])
    assert reasons[0] == reasons[1]
    rackfocus("focus", path, "24,16", "--depth", "planar", "--depth-scale", "1",
              code=1 if says == "--depth-scale -1" else 0)  # fmt: skip


def test_what_filter_warns_of(rackfocus, scene, tmp_path):
    def make(c):
        c["Z"] = 0.1 + c["Z"] / 100

    csv = tmp_path / "focus.csv"
    for i in (1, 2):
        scene(f"near.{i:04d}.exr", change=make)
    picks = [at(1, DISC), at(1 + 1, WALL)]
    done = rackfocus("focus", tmp_path / "near.####.exr", *picks, "-o", csv)
    assert done.stderr.count("taken for distances; normalised and inverse") == 2
    path = tmp_path / "near.0001.exr"
    done = rackfocus("focus", path, "24,16")
    assert "warning: " in done.stderr and "--focus-distance 0.1" in done.stdout
    assert rackfocus("focus", path, "24,16", "--depth", "planar").stderr == ""


def test_no_depth(rackfocus, scene):
    def make(c):
        c["far"] = c.pop("Z")

    path = scene("plain.exr", change=make)
    done = rackfocus("focus", path, "24,16", code=1)
    assert "its channels are B, G, R, far" in done.stderr
    assert "--depth-channel, or give the file" in done.stderr
    done = rackfocus("focus", path, "24,16", "--depth-channel", "far")
    assert done.stdout == "--focus-distance 3\n"


def test_depth_that_does_not_cover_the_colour(rackfocus, scene):
    small = scene("small.exr", size=(24, 16))
    done = rackfocus("focus", scene(), "24,16", "--depth-file", small, code=1)
    assert "the depth is 24 x 16" in done.stderr
