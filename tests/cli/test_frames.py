# SPDX-License-Identifier: Apache-2.0
"""The journal of a sequence with many writers, and the check of its frames."""

import json
import os
import re
import shlex
import subprocess
import urllib.parse

import pytest

LENS = ["--lens-radius", "0.1", "--focal-length-px", "100", "--focus-distance", "4"]
N = 6


@pytest.fixture
def shot(scene, tmp_path):
    """A filtered sequence; returns the words that made it."""
    for i in range(1, N + 1):
        scene(f"shot.{i:04d}.exr", change=lambda c, i=i: c["R"].fill(i / N))
    return ["filter", "shot.####.exr", "-o", "out.####.exr", *LENS, "-j1"]


@pytest.fixture
def run(rackfocus, tmp_path):
    def run(*arguments, code=0):
        return rackfocus(*arguments, code=code, cwd=tmp_path)

    return run


def journals(tmp_path):
    return sorted(p.name for p in tmp_path.glob("out.####.exr.frames*"))


def last(done):
    return done.stdout.splitlines()[-1].rsplit(";", 1)[0]


def test_many_writers_lose_nothing(run, binary, shot, tmp_path):
    """Processes side by side, none of which reads what another adds meanwhile."""
    processes = [
        subprocess.Popen(
            [binary, *shot, "--frames", f"{i}-{i + 2}"],
            cwd=tmp_path,
            stdout=subprocess.DEVNULL,
        )
        for i in range(1, N - 1)
    ]
    assert [process.wait() for process in processes] == [0] * len(processes)
    assert f"{N} skipped" in last(run(*shot))
    done = run("frames", "--", *shot)
    assert done.stdout == f"{N} frames: {N} finished\n"
    assert journals(tmp_path) == ["out.####.exr.frames"]
    assert f"{N} skipped" in last(run(*shot))


def test_who_made_it(run, shot, tmp_path):
    run(*shot)
    text = (tmp_path / "out.####.exr.frames").read_text()
    line = r"^3 [0-9a-f]{16} [0-9a-f]{8}:\d+ @ [\w.-]+ \d+ \d{10,} \d+\.\d{3}$"
    assert len(re.findall(line, text, re.M)) == 1
    assert len(re.findall(r"^# 3 made @ .*radii .* px", text, re.M)) == 1


def test_journals_of_the_killed_and_of_old_versions(run, shot, tmp_path):
    run(*shot)
    journal = tmp_path / "out.####.exr.frames"
    killed = tmp_path / "out.####.exr.frames.other.part.net-12-5f"
    journal.rename(killed)
    assert f"{N} skipped" in last(run(*shot))
    # As version 0.1 wrote them.
    text = re.sub(r"^#.*\n| @ .*", "", killed.read_text(), flags=re.M)
    assert "@" not in text and text.count(":") == N
    killed.unlink()
    journal.write_text(text)
    assert f"{N} skipped" in last(run(*shot))


def test_no_cut_line_is_trusted(run, shot, tmp_path):
    """Cut after any byte, a line says less, never something else."""
    run(*shot, "--frames", "1")
    journal, out = tmp_path / "out.####.exr.frames", tmp_path / "out.0001.exr"
    text, data = journal.read_bytes(), out.read_bytes()
    begin = text.index(b"\n1 ")
    for n in range(begin, text.index(b" @ ", begin), 5):
        # What the next process adds begins with the end of the line.
        journal.write_bytes(text[:n] + b"\n")
        assert "1 filtered" in last(run(*shot, "--frames", "1")), text[:n]
        assert out.read_bytes() == data


def test_a_lost_journal_costs_the_work_alone(run, shot, tmp_path):
    run(*shot)
    whole = [p.read_bytes() for p in sorted(tmp_path.glob("out.0*.exr"))]
    (tmp_path / "out.####.exr.frames").unlink()
    done = run("frames", "--", *shot, code=1)
    assert f"{N} frames: 0 finished, {N} unknown" in done.stdout
    assert f"{N} filtered" in last(run(*shot))
    assert [p.read_bytes() for p in sorted(tmp_path.glob("out.0*.exr"))] == whole


def test_verdicts(run, binary, shot, scene, tmp_path):
    run(*shot)
    out = [tmp_path / f"out.{i:04d}.exr" for i in range(N + 1)]
    whole = [path.read_bytes() if path.exists() else b"" for path in out]
    out[1].unlink()
    out[2].write_bytes(whole[2][:-9])
    out[3].write_bytes(bytes([*whole[3][:-9], *([7] * 9)]))
    scene("shot.0004.exr", change=lambda c: c["R"].fill(0.9))
    done = run("frames", "--", *shot, code=1)
    assert "6 frames: 2 finished, 1 missing, 2 damaged, 1 other" in done.stdout
    for i, word in ((1, "missing"), (2, "damaged"), (3, "damaged"), (4, "other")):
        assert f"frame {i}: {word}: out.000{i}.exr" in done.stderr
    # What it says to type makes what is missing, and no more.
    typed = done.stdout.split("to make them: ")[1].strip()
    assert typed.endswith("--frames 1-4")
    again = subprocess.run(
        shlex.split(typed.replace("rackfocus", binary, 1)),
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert last(again) == "4 frames: 4 filtered, 0 skipped, 0 failed, 0 left"
    run("frames", "--", *shot)
    assert [out[i].read_bytes() for i in (1, 2, 3)] == whole[1:4]
    # Other parameters: those frames are not these.
    done = run("frames", "--", *shot, "--blades", "5", code=1)
    assert "0 finished, 6 other" in done.stdout


def test_why_a_frame_is_missing(run, shot, tmp_path):
    data = (tmp_path / "shot.0005.exr").read_bytes()
    (tmp_path / "shot.0005.exr").write_bytes(data[: len(data) // 2])
    run(*shot, code=1)
    done = run("frames", "--", *shot, code=1)
    assert re.search(r"frame 5: missing: .* said: shot\.0005\.exr: ", done.stderr)
    (tmp_path / "shot.0005.exr").unlink()
    done = run("frames", "--", *shot, "--frames", "1-6", code=1)
    assert "5 finished, 1 missing" in done.stdout


def test_a_name_alone(run, shot, tmp_path):
    run(*shot)
    assert "6 frames: 6 finished" in run("frames", "out.####.exr").stdout
    (tmp_path / "out.0004.exr").unlink()
    done = run("frames", "out.####.exr", code=1)
    assert "frame 4: missing" in done.stderr and "5 finished, 1 missing" in done.stdout
    assert "4 frames: 3" in run("frames", "out.####.exr", "--frames=3-6", code=1).stdout
    # No journal knows these: they are read.
    assert "6 frames: 6 finished" in run("frames", "shot.####.exr").stdout
    path = tmp_path / "shot.0002.exr"
    path.write_bytes(path.read_bytes()[:-40])
    done = run("frames", "shot.####.exr", code=1)
    assert "frame 2: damaged: shot.0002.exr" in done.stderr


@pytest.mark.parametrize("maker", ["filter", "accumulate"])
def test_holes_of_the_inputs_are_said(run, shot, tmp_path, maker):
    """5 of 5 is not the shot where its fourth render never came."""
    (tmp_path / "shot.0004.exr").unlink()
    words = [maker, *shot[1:4], *(LENS if maker == "filter" else [])]
    for command in (words, ["frames", "--", *words]):
        done = run(*command)
        assert "shot.####.exr: of frames 1 to 6 there is no 4; name" in done.stderr
    job = run(
        "submit", "--to", "script", "--dry-run", "--", *words, "--blend-gamma", "2"
    )
    assert "there is no 4; name" in job.stderr
    done = run("frames", "--", *words, "--frames", "1-3,5,6")
    assert "there is no" not in done.stderr


def test_reports(run, shot, tmp_path):
    run(*shot, "--f-stop", "2")  # a warning: the radius of the lens is given
    (tmp_path / "out.0002.exr").unlink()
    done = run("frames", "--json", "--html", "r.html", "out.####.exr", code=1)
    found = json.loads(done.stdout)
    assert (found["n_frames"], found["finished"], found["missing"]) == (6, 5, 1)
    one = found["frames"][2]
    assert one["frame"] == 3 and one["verdict"] == "finished"
    assert one["seconds"] > 0 and one["date"] > 1.6e9 and one["host"]
    assert one["radii_px"][0] < one["radii_px"][1] and "focus 4" in one["made"]
    assert one["warnings"] == 1 and "--f-stop" in one["warning"]
    page = (tmp_path / "r.html").read_text()
    assert page.count("<figure") == 6 and page.count("<img") == 5
    assert 'class="missing"' in page and "radii " in page
    small = sorted(os.listdir(tmp_path / "r_frames"))
    assert small == [f"{i}.png" for i in (1, 3, 4, 5, 6)]


@pytest.mark.parametrize(
    "arguments, reason",
    [
        ([], "frames needs the name of a sequence"),
        (["out.exr"], "has no place for the number"),
        (["a.#.exr", "b.#.exr"], "takes one name"),
        (["out.####.exr", "--frames", "x"], "is no list of frames"),
        (["out.####.exr"], "no such frames"),
        (["--frames", "1", "--", "filter"], "give it behind --"),
        (["--", "info", "x.exr"], "makes no sequence"),
        (["--", "filter", "one.exr", "-o", "o.exr"], "is no sequence"),
        (["--", "povray", "s.pov"], "povray needs an output"),
    ],
)
def test_wrong_usage(binary, tmp_path, arguments, reason):
    done = subprocess.run(
        [binary, "frames", *arguments], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode in (1, 2) and reason in done.stderr


def test_what_the_killed_left_is_folded(run, shot, tmp_path):
    """The journal of a process of this machine that is no more, with the next run's."""
    run(*shot, "--frames", "1-3")
    journal = tmp_path / "out.####.exr.frames"
    journal.rename(f"{journal}.{os.uname().nodename}-{2**22 + 5}-1f")
    assert "3 filtered, 3 skipped" in last(run(*shot))
    assert journals(tmp_path) == [journal.name]
    # Who is on another machine may still be at work.
    journal.rename(f"{journal}.elsewhere-{2**22 + 5}-1f")
    run(*shot, "--anew")
    assert len(journals(tmp_path)) == 2


def test_a_sheet_finds_its_pictures_whatever_it_is_called(rackfocus, scene, tmp_path):
    """In an address a # begins a place on the page, and a % two digits."""
    scene("s.1.exr")
    rackfocus("frames", "s.#.exr", "--html", "s.# 50%'.html", cwd=tmp_path)
    page = (tmp_path / "s.# 50%'.html").read_text()
    (address,) = re.findall(r'<img [^>]*src="([^"]*)"', page)
    path = urllib.parse.urlparse(urllib.parse.urljoin("file:///x/p.html", address)).path
    assert (tmp_path / urllib.parse.unquote(path).removeprefix("/x/")).exists()


def test_a_sheet_without_room_for_its_pictures(rackfocus, scene, tmp_path):
    """A disk that is full: no page that looks whole, and the old one stays."""
    for i in (1, 2):
        scene(f"s.{i}.exr")
    rackfocus("frames", "s.#.exr", "--html", "p.html", cwd=tmp_path)
    page = (tmp_path / "p.html").read_bytes()
    assert page.count(b"<img") == 2
    # Nobody may replace a folder by a picture, which fails as a full disk does.
    (tmp_path / "p_frames" / "2.png").unlink()
    (tmp_path / "p_frames" / "2.png").mkdir()
    done = rackfocus("frames", "s.#.exr", "--html", "p.html", cwd=tmp_path, code=1)
    assert "p_frames/2.png: " in done.stderr
    assert (tmp_path / "p.html").read_bytes() == page
    # A frame that cannot be read has a cell without a picture.
    (tmp_path / "p_frames" / "2.png").rmdir()
    (tmp_path / "s.2.exr").write_bytes(b"no picture")
    rackfocus("frames", "s.#.exr", "--html", "p.html", cwd=tmp_path, code=1)
    assert (tmp_path / "p.html").read_bytes().count(b"<img") == 1
