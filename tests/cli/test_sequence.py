# SPDX-License-Identifier: Apache-2.0
"""Sequences: which frames are made, skipped and reported."""

import os
import pathlib

import plainexr
import pytest

LENS = ["--lens-radius", "0.1", "--focal-length-px", "100"]


@pytest.fixture
def shot(scene, tmp_path):
    """Frames 1 to n; returns the pattern."""

    def make(n=4, **options):
        for i in range(1, n + 1):
            attributes = {"rackfocus:focusDistance": float(2 + i)}
            scene(f"shot.{i:04d}.exr", attributes=attributes, **options)
        return tmp_path / "shot.####.exr"

    return make


@pytest.fixture
def run(rackfocus, tmp_path):
    def filter_shot(pattern, *arguments, code=0, name="out.####.exr"):
        return rackfocus(
            "filter", pattern, "-o", tmp_path / name, *LENS, *arguments, code=code
        )

    return filter_shot


def made(tmp_path, name="out"):
    return sorted(int(p.name.split(".")[1]) for p in tmp_path.glob(f"{name}.[0-9]*.*"))


def summary(done):
    return done.stdout.splitlines()[-1].rsplit(";", 1)[0]


def test_all_frames_with_their_own_focus(run, shot, rackfocus, tmp_path):
    done = run(shot())
    assert made(tmp_path) == [1, 2, 3, 4]
    assert summary(done) == "4 frames: 4 filtered, 0 skipped, 0 failed, 0 left"
    for i in (1, 4):
        one = tmp_path / "one.exr"
        rackfocus("filter", tmp_path / f"shot.000{i}.exr", "-o", one, *LENS)
        assert one.read_bytes() == (tmp_path / f"out.000{i}.exr").read_bytes()
    assert (tmp_path / "out.0001.exr").read_bytes() != one.read_bytes()


@pytest.mark.parametrize(
    "frames, want",
    [("2-4", [2, 3, 4]), ("1-4x2", [1, 3]), ("4,1,4", [1, 4]), ("1-2,4", [1, 2, 4])],
)
def test_frames(run, shot, tmp_path, frames, want):
    run(shot(), "--frames", frames)
    assert made(tmp_path) == want


def test_finished_frames_are_skipped(run, shot, tmp_path):
    pattern = shot()
    run(pattern, "--frames", "1-2")
    before = {i: (tmp_path / f"out.000{i}.exr").stat().st_mtime_ns for i in (1, 2)}
    assert "2 filtered, 2 skipped" in summary(run(pattern))
    for i, time in before.items():
        assert (tmp_path / f"out.000{i}.exr").stat().st_mtime_ns == time
    assert "4 skipped" in summary(run(pattern))
    assert "4 filtered, 0 skipped" in summary(run(pattern, "--anew"))


@pytest.mark.parametrize("spelling", ["%04d", "$F4"])
def test_finished_frames_are_known_however_they_are_spelled(
    run, shot, tmp_path, spelling
):
    run(shot(), "--frames", "1-2")
    other = tmp_path / f"shot.{spelling}.exr"
    done = run(other, "--frames", "1-3", name=f"out.{spelling}.exr")
    assert "1 filtered, 2 skipped" in summary(done)
    assert [p.name for p in tmp_path.glob("*.frames")] == ["out.####.exr.frames"]


def test_what_makes_a_frame_unfinished(run, shot, scene, tmp_path):
    """Missing, cut off, other settings, another input: made again, and only that."""
    pattern = shot()
    run(pattern)
    (tmp_path / "out.0001.exr").unlink()
    data = (tmp_path / "out.0002.exr").read_bytes()
    (tmp_path / "out.0002.exr").write_bytes(data[:-9])
    scene("shot.0003.exr", change=lambda c: c["R"].fill(0.25))
    done = run(pattern)
    assert "3 filtered, 1 skipped" in summary(done)
    assert (tmp_path / "out.0002.exr").read_bytes() == data
    assert "4 filtered" in summary(run(pattern, "--type", "float"))
    assert "4 filtered" in summary(run(pattern, "--type", "float", "--blades", "5"))
    assert "4 skipped" in summary(run(pattern, "--type", "float", "--blades", "5"))
    assert "4 filtered" in summary(
        run(pattern, "--output-coc", tmp_path / "c.####.exr")
    )
    (tmp_path / "c.0002.exr").unlink()
    done = run(pattern, "--output-coc", tmp_path / "c.####.exr")
    assert "1 filtered, 3 skipped" in summary(done)


def test_failed_frames_do_not_stop_the_rest(run, shot, tmp_path):
    pattern = shot(5)
    (tmp_path / "shot.0002.exr").unlink()
    data = (tmp_path / "shot.0004.exr").read_bytes()
    (tmp_path / "shot.0004.exr").write_bytes(data[: len(data) // 2])
    done = run(pattern, "--frames", "1-5", code=1)
    assert made(tmp_path) == [1, 3, 5]
    assert summary(done) == "5 frames: 3 filtered, 0 skipped, 2 failed, 0 left"
    failed = [line for line in done.stderr.splitlines() if "failed: frame" in line]
    assert [line.split()[3] for line in failed] == ["2:", "4:"]
    assert "No such file" in failed[0] and "shot.0004.exr" in failed[1]


def test_a_folder_that_is_not_there_is_said_once(run, shot, tmp_path):
    done = run(shot(3), name="nowhere/out.####.exr", code=1)
    assert done.stderr.count("\n") == 1 and done.stdout == ""
    assert "nowhere/out.####.exr: cannot write into its folder: No such" in done.stderr


def test_names_that_are_too_long(run, shot, tmp_path):
    """Each frame was filtered before its file could not be made."""
    done = run(shot(3), name="x" * 260 + ".####.exr", code=1)
    assert done.stderr.count("\n") == 1 and done.stdout == ""
    assert "xxx: the name is too long for its file system" in done.stderr


def test_parameters_per_frame(run, shot, rackfocus, tmp_path):
    pattern, table = shot(), tmp_path / "focus.csv"
    table.write_text(
        "# a pull\nframe, focus-distance, f-stop\n1,3,2\n2, 5,4\n\n4,9,8\n"
    )
    done = run(pattern, "--frame-parameters", table, "--lens-radius", "0", code=1)
    assert "failed: frame 3:" in done.stderr and "has no row for it" in done.stderr
    assert made(tmp_path) == [1, 2, 4]
    text = plainexr.read_header((tmp_path / "out.0002.exr").read_bytes())[0]
    assert "--focus-distance 5" in text["rackfocus:filtered"]
    assert "--f-stop 4" in text["rackfocus:filtered"]
    table.write_text(table.read_text().replace("2, 5,4", "2,6,4") + "3,7,4\n")
    done = run(pattern, "--frame-parameters", table, "--lens-radius", "0")
    assert "2 filtered, 2 skipped" in summary(done)


def test_what_is_typed_wins_over_the_table(run, shot, tmp_path):
    """Over a file of parameters, which is for all frames, the table wins."""
    table, params = tmp_path / "focus.csv", tmp_path / "all.params"
    table.write_text("frame,focus-distance,blades\n1,3,5\n2,4,6\n")
    params.write_text("focus-distance 9\nblades 9\n")
    arguments = [shot(2), "--frame-parameters", table, "--params", params]
    done = run(*arguments, "--blades", "7")
    assert (
        f"--blades: is taken for all frames, and the column 'blades' of {table} is"
        in (done.stderr)
    )
    assert done.stderr.count("--blades") == 1 and "--focus-distance" not in done.stderr
    for i, focus in ((1, "3"), (2, "4")):
        found = focus_of(tmp_path / f"out.{i:04d}.exr")
        assert found == {"focus-distance": focus, "blades": "7"}
    assert run(*arguments).stderr == ""
    run(*arguments, "--blades", "7", "--strict", code=1)


def focus_of(path):
    text = plainexr.read_header(path.read_bytes())[0]["rackfocus:filtered"]
    return {
        k: text.split(f"--{k} ")[1].split()[0] for k in ("focus-distance", "blades")
    }


@pytest.mark.parametrize(
    "easing, low, last, high, want",
    [
        ("hold", 2, 4, 4, 2),
        ("linear", 2, 4, 4, 3),
        ("ease-in", 2, 4, 3, 2.25),
        ("ease-out", 3, 4, 4, 3.75),
        ("ease-in-out", 2, 6, 6, 2.625),
    ],
)
def test_focus_pulls(run, shot, tmp_path, easing, low, last, high, want):
    """Key frames 2 and `last`, in any order; where the focus of frame 3 is then."""
    pattern, table, first = shot(8), tmp_path / "focus.csv", 2
    table.write_text(
        "frame,easing,focus-distance,blades\n"
        f"{last},linear,{high},7\n{first},{easing},{low},5\n"
    )
    run(pattern, "--frame-parameters", table)
    out = {i: focus_of(tmp_path / f"out.{i:04d}.exr") for i in range(1, 9)}
    assert float(out[3]["focus-distance"]) == want
    assert float(out[1]["focus-distance"]) == low  # before the first
    assert float(out[8]["focus-distance"]) == high  # behind the last
    assert (out[3]["blades"], out[last]["blades"]) == ("5", "7")
    assert "8 skipped" in summary(run(pattern, "--frame-parameters", table))


def test_what_0_turns_off_is_not_on_by_degrees(run, shot, tmp_path):
    """Between no diopter and one at 3 is none at 1; from number to number it moves."""
    pattern, table = shot(7), tmp_path / "looks.csv"
    table.write_text(
        "frame,split-diopter,highlight-clamp,cat-eye,easing\n"
        "1,0,500,0,linear\n3,3,0,0.8,linear\n5,5,100,0,linear\n7,0,200,0,linear\n"
    )
    run(pattern, "--frame-parameters", table)
    found = []
    for i in range(1, 8):
        path = tmp_path / f"out.{i:04d}.exr"
        said = plainexr.read_header(path.read_bytes())[0]["rackfocus:filtered"]
        words = f"{said} ".split(" --")[1:]
        found.append(dict(word.split(" ", 1) for word in words))
    for key, want in {
        "split-diopter": [0, 0, 3, 4, 5, 5, 0],
        "highlight-clamp": [500, 500, 0, 0, 100, 150, 200],
        "cat-eye": [0, 0.4, 0.8, 0.4, 0, 0, 0],
    }.items():
        assert [float(frame.get(key, 0)) for frame in found] == want


@pytest.mark.parametrize(
    "text, reason",
    [
        ("frame,look\n1,fast\n", "csv:1: there is no parameter 'look'; --look is of"),
        ("focus-distance\n3\n", "the first line names the columns"),
        ("frame,focus\n1,3\n", "there is no parameter 'focus'"),
        ("frame,f-stop\n1\n", "csv:2: a row is a frame and 1 value"),
        ("frame,f-stop\n1,2,3\n", "csv:2: a row is"),
        ("frame,f-stop\none,2\n", "csv:2: 'one' is no number of a frame; a row"),
        ("frame,f-stop\n1.5,2\n", "csv:2: '1.5' is no number of a frame; a row"),
        ('frame,f-stop\n1,""\n', "csv:2: a row is a frame and 1 value"),
        ("frame,f-stop\n", "has no rows"),
        ("frame,f-stop,f-stop\n1,2,3\n", "csv:1: there are two columns 'f-stop'"),
        ("frame,f-stop,f_stop\n1,2,3\n", "csv:1: there are two columns 'f_stop'"),
        ("# x\nframe,f-stop,f-stop\n1,2,3\n", "csv:2: there are two columns"),
        ("frame;f-stop\n1;2,5\n", "csv:1: there are semicolons (;) between the col"),
        ("frame\tf-stop\n1\t2\n", "csv:1: there are tabs between the columns"),
        ("frame,f-stop\n1;2\n", "csv:2: there are semicolons (;) between the col"),
        ("frame,easing,easing\n1,hold,hold\n", "two columns 'easing'; leave one"),
        ("frame,f-stop\n1,2\n# x\n01,4\n", "csv:4: frame 01 has a row before this"),
        ("frame,f-stop,easing\n1,2,slow\n", "csv:2: 'slow' is no easing; there are"),
    ],
)
def test_bad_tables(run, shot, tmp_path, text, reason):
    table = tmp_path / "focus.csv"
    table.write_text(text)
    done = run(shot(1), "--frame-parameters", table, code=1)
    assert reason in done.stderr
    assert made(tmp_path) == []


def test_a_table_of_a_program(run, shot, tmp_path):
    """Libraries write every cell in quotes, and frames as floats."""
    table = tmp_path / "focus.csv"
    table.write_text('"Frame","f-stop"\n"1.0","2"\n')
    run(shot(1), "--frame-parameters", table)
    text = plainexr.read_header((tmp_path / "out.0001.exr").read_bytes())[0]
    assert "--f-stop 2" in text["rackfocus:filtered"]


@pytest.mark.parametrize("end", [b"\r\n", b"\r"])
def test_a_table_of_excel(run, shot, tmp_path, end):
    """It writes a byte-order mark and CR LF, for Macs CR alone; a remark may be of any
    length."""
    table = tmp_path / "focus.csv"
    remark = b"# " + b"x" * 9999
    lines = [b"\xef\xbb\xbfframe,f-stop", remark, b"1,2", b""]
    table.write_bytes(end.join(lines))
    run(shot(1), "--frame-parameters", table)
    text = plainexr.read_header((tmp_path / "out.0001.exr").read_bytes())[0]
    assert "--f-stop 2" in text["rackfocus:filtered"]


def test_a_bad_value_in_a_table_names_the_frame(run, shot, tmp_path):
    table = tmp_path / "focus.csv"
    table.write_text("frame,f-stop\n1,2\n2,-3\n")
    done = run(shot(2), "--frame-parameters", table, code=1)
    assert "failed: frame 2:" in done.stderr and "range" in done.stderr
    assert made(tmp_path) == [1]


@pytest.mark.parametrize(
    "frames, why",
    [(frames, "is no list") for frames in ["x", "1-", "1-3x0", "1,,2", "1 2"]]
    + [
        ("1-9e9", "is no list"),
        ("5-1x", "ends before it begins"),
        ("5-1", "ends before it begins; write the smaller number first"),
        ("1-1000000000", "no frame can have; they lie in -1000000 to 100000000"),
        ("1-99999999999999999999", "no frame can have"),
        ("1-2000000", "has more than 1000000 frames"),
    ],
)
def test_bad_lists(run, shot, tmp_path, frames, why):
    done = run(shot(1), "--frames", frames, code=2)
    assert f"--frames: '{frames}' " in done.stderr and why in done.stderr
    assert made(tmp_path) == []


def test_wrong_usage(run, shot, rackfocus, tmp_path):
    pattern = shot(3)
    assert "has no #" in run(pattern, name="out.exr", code=2).stderr
    assert "no such frames" in run(tmp_path / "other.##.exr", code=2).stderr
    one = tmp_path / "shot.0001.exr"
    done = rackfocus("filter", one, "-o", "x.exr", "--frames", "1", code=2)
    assert "is for sequences" in done.stderr
    # The command line is wrong for every frame: said once, not 3 times.
    done = run(pattern, "--blades", "2", "--jobs", "1", code=2)
    assert "0 filtered, 0 skipped, 1 failed, 2 left" in summary(done)


def test_other_names(run, shot, rackfocus, tmp_path):
    """Other paddings, PNG, depth in its own sequence, quiet."""
    pattern = shot(2)
    done = run(pattern, name="p_##.png")
    assert summary(done).startswith("2 frames: 2 filtered")
    assert (tmp_path / "p_01.png").exists()
    assert "2 skipped" in summary(run(pattern, name="p_##.png"))
    for i in (1, 2):
        channels, _ = plainexr.read(tmp_path / f"shot.000{i}.exr")
        plainexr.write(tmp_path / f"z{i}.exr", {"Z": channels.pop("Z")})
        plainexr.write(tmp_path / f"c{i}.exr", channels)
    depth = ["--depth-file", tmp_path / "z#.exr", "--focus-distance", "4"]
    done = run(tmp_path / "c#.exr", *depth, "-q", name="d.####.exr")
    assert done.stdout == "" and made(tmp_path, "d") == [1, 2]
    # A file that has this very name is no sequence.
    odd = tmp_path / "take#1.exr"
    os.rename(tmp_path / "shot.0001.exr", odd)
    rackfocus("filter", odd, "-o", tmp_path / "odd.exr", *LENS)


def test_any_number_at_a_time(run, shot, tmp_path):
    pattern = shot(5)
    pictures = []
    for jobs in (1, 3, 16):
        run(pattern, "--anew", "--jobs", jobs, "-j2")
        files = sorted(pathlib.Path(tmp_path).glob("out.[0-9]*.exr"))
        pictures.append([path.read_bytes() for path in files])
    assert pictures[0] == pictures[1] == pictures[2]


def test_holes_in_a_shot_are_said(run, shot, tmp_path):
    pattern = shot(7)
    for i in (3, 5, 6):
        (tmp_path / f"shot.000{i}.exr").unlink()
    done = run(pattern)
    assert (
        f"{pattern}: of frames 1 to 7 there is no 3,5-6; name with --frames"
        in done.stderr
    )
    assert made(tmp_path) == [1, 2, 4, 7]
    assert "there is no" not in run(pattern, "--frames", "1-2,4").stderr
    run(pattern, "--strict", code=1)


@pytest.mark.parametrize("there", [(1, 2, 3), (1, 3, 5, 7), (2, 5), (1, 4, 6)])
def test_steps_and_stills_are_no_holes(run, shot, tmp_path, there):
    pattern = shot(7)
    for i in set(range(1, 8)) - set(there):
        (tmp_path / f"shot.000{i}.exr").unlink()
    assert "there is no" not in run(pattern).stderr
    assert made(tmp_path) == list(there)


def test_frames_of_different_sizes_are_said(run, shot, scene, tmp_path):
    pattern = shot(4)
    assert "sizes" not in run(pattern).stderr
    scene("shot.0003.exr", size=(24, 16))
    said = run(pattern, "--anew").stderr
    assert "frames are of different sizes: 3 is 24 x 16 px, 1 is 48 x 32 px" in said
    (tmp_path / "shot.0002.exr").write_bytes(b"damaged")
    said = run(pattern, "--anew", code=1).stderr
    assert "frames are of different sizes: 3 is 24 x 16 px" in said
    assert "failed: frame 2" in said


@pytest.mark.parametrize(
    "command",
    [
        ["info", "shot.####.exr"],
        ["compare", "shot.0002.exr", "shot.%04d.exr"],
        ["finish", "shot.@@@@.exr", "-o", "out.exr"],
    ],
)
def test_commands_of_one_frame_say_so(rackfocus, shot, tmp_path, command):
    shot(2)
    (tmp_path / "shot.0001.exr").rename(tmp_path / "shot.0007.exr")
    said = rackfocus(*command, code=2, cwd=tmp_path).stderr
    name = next(word for word in command if "exr" in word and "2" not in word)
    assert said == (
        f"rackfocus: {name}: {command[0]} takes pictures of one frame; name the file, "
        "such as shot.0002.exr\n"
    )


def test_a_file_may_be_named_as_a_sequence(rackfocus, shot, tmp_path):
    shot(1)
    (tmp_path / "shot.0001.exr").rename(tmp_path / "shot.####.exr")
    rackfocus("info", "shot.####.exr", cwd=tmp_path)
