# SPDX-License-Identifier: Apache-2.0
"""Sequences through real schedulers that lose tasks: the frames are those of one machine."""

import json
import os
import random
import re
import subprocess
import time

import pytest
from conftest import LENS, frames_of

WORDS = ["filter", "shot.####.exr", "-o", "out.####.exr", *LENS]


@pytest.fixture
def submit(binary):
    def run(folder, *arguments, env=None, code=0, words=WORDS):
        done = subprocess.run(
            [binary, "submit", *arguments, "--", *words],
            cwd=folder,
            env=env,
            capture_output=True,
            text=True,
        )
        assert done.returncode == code, done.stdout + done.stderr
        return done

    return run


def same(folder, want):
    made = frames_of(folder)
    assert sorted(made) == sorted(want)
    return all(made[i] == want[i] for i in want)


# ---- Slurm ---------------------------------------------------------------------------


def wrap(folder, binary):
    """rackfocus on a disk that is full while the file `full` is there, and slow enough
    that a task can be hit."""
    program = folder / "rack focus"
    program.write_text(
        "#!/bin/sh\n"
        f"[ ! -e '{folder.parent}/full' ] || {{ trap '' XFSZ; ulimit -f 4; }}\n"
        f"sleep 0.6\nexec '{binary}' \"$@\"\n"
    )
    program.chmod(0o755)
    return program


def hurt(farm, folder, seed):
    """Kills tasks, takes the machine away and gives it back, while a job runs."""
    dice, n_killed = random.Random(seed), 0
    full = folder.parent / "full"
    for step in range(12):
        time.sleep(0.3)
        if step == 3:
            full.touch()
        elif step == 5:
            full.unlink()
        if step == 8:
            farm.kill("slurmd")
            time.sleep(1)
            farm.start_node()
        running = farm.tasks()
        if running:
            farm.ask("scancel", "--full", "--signal=KILL", dice.choice(running))
            n_killed += 1
    full.unlink(missing_ok=True)
    return n_killed


def test_slurm_with_losses(farm, submit, binary, shot, alone):
    folder = shot(200)
    want = alone(folder)
    assert len(want) == 200
    damaged = folder / "shot.0017.exr"
    data = damaged.read_bytes()
    time_ns = damaged.stat().st_mtime_ns
    damaged.write_bytes(data[: len(data) // 2])
    program = ["--program", wrap(folder, binary)]
    submit(folder, "--to", "slurm", "--chunk", "5", *program, env=farm.env)
    n_killed = hurt(farm, folder, 1)
    farm.wait_for_jobs()
    assert n_killed >= 4
    first = frames_of(folder)
    assert 100 < len(first) < 200 and 17 not in first
    checks = sorted((folder / "out.####.exr.slurm.sh.logs").glob("*_check.log"))
    text = checks[-1].read_text()
    assert "frame 17: missing" in text and "to make them: rackfocus filter" in text
    made = {p: p.stat().st_mtime_ns for p in folder.glob("out.0*.exr")}

    damaged.write_bytes(data)
    os.utime(damaged, ns=(time_ns, time_ns))
    done = submit(folder, "--to", "slurm", "--chunk", "5", *program, env=farm.env)
    n_finished = int(done.stdout.split()[0])
    # What was renamed before its line was written is made again, of each kill one.
    assert len(first) - 2 * n_killed <= n_finished <= len(first)
    farm.wait_for_jobs()
    assert same(folder, want)
    again = sum(p.stat().st_mtime_ns != t for p, t in made.items())
    assert again == len(first) - n_finished
    done = submit(folder, "--to", "slurm", env=farm.env)
    assert done.stdout == "200 of 200 frames are finished\n"
    # The last check has joined the journals of all tasks.
    assert [p.name for p in folder.glob("out.*.frames*")] == ["out.####.exr.frames"]
    print(f"{n_killed} tasks killed; {200 - n_finished} frames resubmitted")


def test_slurm_requeues(farm, submit, shot, alone):
    """A task that the scheduler starts again goes on where it was."""
    folder = shot(12)
    want = alone(folder)
    submit(folder, "--to", "slurm", "--chunk", "6", "-j", "1", env=farm.env)
    time.sleep(0.5)
    for task in farm.tasks("RUNNING,COMPLETING"):
        farm.ask("scontrol", "requeue", task)
    farm.wait_for_jobs()
    assert same(folder, want)


def test_where_there_is_no_slurm(submit, shot, tmp_path):
    folder = shot(2)
    for name in ("sh", "dirname", "basename", "cat", "sed"):
        (tmp_path / name).symlink_to(
            f"/bin/{name}" if name == "sh" else f"/usr/bin/{name}"
        )
    env = {**os.environ, "PATH": str(tmp_path)}
    done = submit(folder, "--to", "slurm", env=env, code=1)
    assert "sbatch: not found; submit where Slurm is: sh " in done.stderr
    assert (folder / "out.####.exr.slurm.sh").exists()


# ---- Open Job Description ------------------------------------------------------------


def test_openjd(submit, shot, alone, openjd_env):
    folder = shot(40)
    want = alone(folder)
    damaged = folder / "shot.0017.exr"
    data, time_ns = damaged.read_bytes(), damaged.stat().st_mtime_ns
    damaged.write_bytes(data[:300])
    chunk = ["--to", "openjd", "--chunk", "10"]
    done = submit(folder, *chunk, env=openjd_env, code=1)
    assert "openjd_fail: frames 11-20: failed: frame 17: " in done.stdout
    assert 10 < len(frames_of(folder)) < 40
    damaged.write_bytes(data)
    os.utime(damaged, ns=(time_ns, time_ns))
    done = submit(folder, *chunk, env=openjd_env)
    assert same(folder, want)
    assert (
        "openjd_progress: 50" in done.stdout and "openjd_progress: 100" in done.stdout
    )
    assert "40 frames: 40 finished" in done.stdout


def test_openjd_template(submit, shot, openjd_env):
    folder = shot(12)
    file = folder / "job.json"
    submit(folder, "--to", "openjd", "--dry-run", "--job", file, "--chunk", "5")
    job = json.loads(file.read_text())
    assert job["specificationVersion"] == "jobtemplate-2023-09"
    tasks = job["steps"][0]["parameterSpace"]["taskParameterDefinitions"]
    assert tasks[0]["range"] == ["1-5", "6-10", "11-12"]
    checked = subprocess.run(["openjd", "check", file], env=openjd_env)
    assert checked.returncode == 0
    assert frames_of(folder) == {}


# ---- scripts -------------------------------------------------------------------------


def test_script(submit, shot, alone, tmp_path):
    """With GNU parallel, and without."""
    folder = shot(20)
    want = alone(folder)
    done = submit(folder, "--to", "script", "--chunk", "3", "--html", "r.html")
    assert same(folder, want) and "20 frames: 20 finished" in done.stdout
    assert (folder / "r.html").read_text().count("<img") == 20
    for i in (3, 4, 11):
        (folder / f"out.{i:04d}.exr").unlink()
    bare = tmp_path / "bin"
    bare.mkdir()
    for name in ("sh", "dirname", "basename", "cat", "xargs", "getconf", "grep"):
        (bare / name).symlink_to(f"/usr/bin/{name}")
    done = submit(
        folder, "--to", "script", "--chunk", "1", env={**os.environ, "PATH": str(bare)}
    )
    assert "17 of 20 frames are finished" in done.stdout
    assert "3 tasks of 1 frame" in done.stdout
    assert same(folder, want)


def test_accumulate(rackfocus, submit, shot):
    folder = shot(8)
    words = ["accumulate", "shot.####.exr", "shot.0001.exr", "-o", "out.####.exr"]
    done = rackfocus(*words, "-q", "--frames", "2-8", cwd=folder)
    want = frames_of(folder)
    assert sorted(want) == list(range(2, 9)) and done.stdout == ""
    rackfocus(*words[:2], words[2], "-o", "one.exr", cwd=folder, code=2)
    one = ["accumulate", "shot.0004.exr", "shot.0001.exr", "-o", "one.exr"]
    rackfocus(*one, cwd=folder)
    assert (folder / "one.exr").read_bytes() == want[4]
    (folder / "out.0003.exr").unlink()
    (folder / "out.0005.exr").write_bytes(b"damaged")
    done = submit(folder, "--to", "script", "--chunk", "1", words=words)
    assert "5 of 8 frames are finished" in done.stdout
    assert "8 frames: 8 finished" in done.stdout
    made = frames_of(folder)
    assert {i: made[i] for i in want} == want
    (folder / "shot.0006.exr").unlink()
    done = rackfocus(*words, "--anew", "--frames", "5-7", cwd=folder, code=1)
    assert "3 frames: 2 averaged, 0 skipped, 1 failed, 0 left" in done.stdout
    assert "failed: frame 6" in done.stderr
    done = rackfocus(*one, "--frames", "1", cwd=folder, code=2)
    assert "is no sequence" in done.stderr


SCENE = """
camera { location <0, 1, -5> look_at <0, 1, 0> aperture 0.4 focal_point <0, 1, 0> }
light_source { <5, 9, -9> rgb 1 }
plane { y, 0 pigment { checker rgb 1 rgb 0.2 } }
sphere { <clock - 0.5, 1, 2 * clock>, 0.7 pigment { rgb <1, 0.3, 0.1> } }
"""


def test_povray(rackfocus, submit, tmp_path):
    """Tasks know the whole animation: the clock of a frame is that of one run."""
    (tmp_path / "scene.pov").write_text(SCENE)
    words = ["povray", "scene.pov", "--frames", "1-4", "--supersample", "1", "-q"]
    size = ["--", "+W48", "+H32"]
    rackfocus(*words, "-o", "alone.####.exr", *size, cwd=tmp_path)
    want = frames_of(tmp_path, "alone")
    assert len(set(want.values())) == 4
    words = [*words, "-o", "out.####.exr", *size]
    done = submit(tmp_path, "--to", "script", "--chunk", "3", words=words)
    assert "2 tasks of 3 frames" in done.stdout
    assert "4 frames: 4 finished" in done.stdout
    assert same(tmp_path, want)


def test_a_scene_that_is_not_there_is_not_submitted(submit, tmp_path):
    words = ["povray", "scene.pov", "--frames", "1-4", "-o", "out.####.exr"]
    done = submit(tmp_path, "--to", "slurm", "--dry-run", words=words, code=2)
    assert "scene.pov: there is no such file" in done.stderr
    assert not list(tmp_path.iterdir())


def test_povray_makes_nothing_twice(rackfocus, submit, tmp_path):
    """Its frames have a journal: what is finished stays, what it was made of counts."""
    scene, include = tmp_path / "scene.pov", tmp_path / "colour.inc"
    include.write_text("#declare Colour = rgb <1, 0.3, 0.1>;\n")
    scene.write_text('#include "colour.inc"\n' + SCENE)
    options = ["--supersample", "1", "-o", "out.####.exr"]
    words = ["povray", "scene.pov", *options, "--frames", "1-4"]
    size = ["--", "+W48", "+H32"]

    def run():
        done = rackfocus(*words, *size, cwd=tmp_path)
        return done.stdout.count(" is there\n"), done.stdout.count("focus distance")

    assert run() == (0, 4)
    assert run() == (4, 0)
    want = frames_of(tmp_path)
    (tmp_path / "out.0003.exr").write_bytes(b"damaged")
    done = rackfocus("frames", "--", *words, *size, cwd=tmp_path, code=1)
    assert "frame 3: damaged" in done.stderr
    done = submit(tmp_path, "--to", "script", "--chunk", "2", words=[*words, *size])
    assert "3 of 4 frames are finished" in done.stdout
    assert "1 task of" in done.stdout and "4 frames: 4 finished" in done.stdout
    assert same(tmp_path, want)
    include.write_text("#declare Colour = rgb <0.1, 0.3, 1>;\n")
    done = rackfocus("frames", "--", *words, *size, cwd=tmp_path, code=1)
    assert "frame 1: other" in done.stderr
    assert run() == (0, 4)
    words[-1] = "1,3"
    assert run() == (0, 2)  # another animation: its clock is another
    words += ["--anew"]
    assert run() == (0, 2)


VIEW_WORDS = ["povray", "scene.pov", "--frames", "1-2", "--views", "3", "-q"]
VIEW_WORDS += ["--keep", "passes", "-o", "out.####.exr", "--", "+W48", "+H32"]


@pytest.fixture
def views_alone(rackfocus, tmp_path):
    """The frames of one machine."""
    (tmp_path / "scene.pov").write_text(SCENE)
    words = [word.replace("out", "alone") for word in VIEW_WORDS]
    words[words.index("passes")] = "alone_passes"
    rackfocus(*words, cwd=tmp_path)
    return frames_of(tmp_path, "alone")


def rendered_views(folder):
    """Views that a journal says were rendered, in order: frame 64 + view."""
    numbers = []
    for path in folder.glob("passes/views.frames*"):
        lines = path.read_text().split("\n")
        numbers += [int(line.split()[0]) for line in lines if line[:1].isdigit()]
    return sorted(numbers)


ALL_VIEWS = [64 * frame + view for frame in (1, 2) for view in range(3)]


def test_views_are_tasks(submit, views_alone, tmp_path):
    each = ["--chunk", "1", "--views-per-task", "2"]
    submit(tmp_path, "--to", "script", *each, words=VIEW_WORDS)
    assert same(tmp_path, views_alone)
    assert rendered_views(tmp_path) == ALL_VIEWS  # each once


def test_views_are_tasks_of_slurm(farm, submit, views_alone, tmp_path):
    each = ["--chunk", "1", "--views-per-task", "2"]
    done = submit(tmp_path, "--to", "slurm", *each, words=VIEW_WORDS, env=farm.env)
    assert re.search("views: job [0-9]+, 4 tasks", done.stdout)
    assert re.search("frames: job [0-9]+, 2 tasks", done.stdout)
    farm.wait_for_jobs(120)
    assert same(tmp_path, views_alone)
    assert rendered_views(tmp_path) == ALL_VIEWS


def test_views_are_a_step_of_openjd(submit, views_alone, openjd_env, tmp_path):
    each = ["--chunk", "1", "--views-per-task", "2"]
    submit(tmp_path, "--to", "openjd", *each, words=VIEW_WORDS, env=openjd_env)
    job = json.loads((tmp_path / "out.####.exr.openjd.json").read_text())
    assert [step["name"] for step in job["steps"]] == ["Views", "Frames", "Check"]
    assert same(tmp_path, views_alone)
    assert rendered_views(tmp_path) == ALL_VIEWS


def test_killed_between_views(rackfocus, views_alone, tmp_path):
    """What was rendered stays; the picture is that of one run."""
    words = [word for word in VIEW_WORDS if word != "-q"]
    some = [*words[:-3], "--only-views", "1", *words[-3:]]
    rackfocus(*some, cwd=tmp_path)
    assert frames_of(tmp_path) == {}
    assert rendered_views(tmp_path) == [65, 129]
    (tmp_path / "passes/passes0002_v01.exr").write_bytes(b"damaged")
    rackfocus(*words, cwd=tmp_path)
    assert same(tmp_path, views_alone)
    assert rendered_views(tmp_path).count(65) == 1
    assert rendered_views(tmp_path).count(129) == 2
    (tmp_path / "out.0001.exr").unlink()
    rackfocus(*words, cwd=tmp_path)  # merged of what is there
    assert same(tmp_path, views_alone)
    assert rendered_views(tmp_path).count(64) == 1


@pytest.mark.parametrize(
    "options, reason",
    [
        (["--views", "3", "--only-views", "0"], "needs --views, and --keep"),
        (["--keep", "k", "--only-views", "0"], "needs --views, and --keep"),
        (["--views", "3", "--keep", "k.exr", "--only-views", "0"], "with a folder"),
        (["--views", "3", "--keep", "k", "--only-views", "3"], "the last of"),
        (["--views", "3", "--keep", "k", "--only-views", "x"], "is no list of views"),
    ],
)
def test_wrong_views(rackfocus, tmp_path, options, reason):
    (tmp_path / "scene.pov").write_text(SCENE)
    done = rackfocus(
        "povray", "scene.pov", "-o", "o.exr", *options, cwd=tmp_path, code=2
    )
    assert reason in done.stderr


def test_povray_frames_of_computed_names_are_told(rackfocus, tmp_path):
    computed = '#declare Name = concat("a", str(1, 0, 0));\n'
    (tmp_path / "scene.pov").write_text(computed + SCENE)
    words = ["povray", "scene.pov", "--supersample", "1", "-o", "out.####.exr"]
    words += ["--frames", "1-2", "--", "+W48", "+H32"]
    assert "concat" not in rackfocus(*words, cwd=tmp_path).stderr
    assert rackfocus(*words, cwd=tmp_path).stderr.count("concat") == 1


def test_a_failure_is_not_lost(submit, shot):
    folder = shot(4)
    (folder / "shot.0002.exr").write_bytes(b"no picture")
    done = submit(folder, "--to", "script", "--chunk", "2", code=1)
    assert "frame 2: missing" in done.stderr
    assert sorted(frames_of(folder)) == [1, 3, 4]


def test_chunks(submit, shot):
    folder = shot(40)

    def tasks(*arguments, words=WORDS):
        done = submit(folder, "--to", "script", "--dry-run", *arguments, words=words)
        return done.stdout.splitlines()[-1].split(": ", 1)[1]

    assert tasks("--chunk", "7") == "6 tasks of 7 frames"
    assert tasks("--chunk", "1000") == "1 task of 1000 frames"
    assert "guessed by their size" in tasks()
    some = [*WORDS, "--frames", "1-9x2,20-24"]
    text = tasks("--chunk", "4", "--job", folder / "j.sh", words=some)
    assert text == "3 tasks of 4 frames"
    job = (folder / "j.sh").read_text()
    assert "\n1,3,5,7\n9,20-22\n23-24\n" in job
    assert frames_of(folder) == {}
    assert "one was made now" in tasks("--measure")
    assert sorted(frames_of(folder)) == [1]
    assert "as those that are there took" in tasks()


def test_the_line_needs_no_dashes(binary, submit, shot):
    folder = shot(3)
    words = ["--to", "script", "--dry-run", "--chunk", "2", "--job", "job.sh"]
    submit(folder, *words)
    with_dashes = (folder / "job.sh").read_text()
    (folder / "job.sh").unlink()
    subprocess.run([binary, "submit", *words, *WORDS], cwd=folder, check=True)
    assert (folder / "job.sh").read_text() == with_dashes


def test_tasks_are_even(submit, shot):
    """Where nobody says how many frames a task has; the last is no stub."""
    folder = shot(1)
    words = [*WORDS, "--frames", "1-10000"]
    job = folder / "j.sh"
    submit(folder, "--to", "script", "--dry-run", "--job", job, words=words)
    lines = re.findall(r"^(\d+)-(\d+)$", job.read_text(), re.M)
    sizes = [int(end) - int(begin) + 1 for begin, end in lines]
    assert sum(sizes) == 10000 and len(sizes) > 2
    assert max(sizes) - min(sizes) < len(sizes)


def test_too_many_tasks(submit, shot):
    folder = shot(1)
    words = [*WORDS, "--frames", "1-2500"]
    done = submit(folder, "--to", "openjd", "--dry-run", "--chunk", "1", words=words)
    assert "834 tasks of 3 frames, so that there are 1000 tasks at most" in done.stdout


@pytest.mark.parametrize(
    "arguments, words, reason",
    [
        ([], WORDS, "submit needs --to"),
        (["--to", "slurm"], [], "needs a command line after --"),
        (["--to", "slurm", "x"], WORDS, "makes no sequence"),
        (["--to", "slurm"], ["info", "x"], "makes no sequence"),
        (["--to", "slurm"], ["filter", "s.#.exr"], "has no output"),
        (["--to", "slurm"], ["filter", "s.#.exr", "-o", "o.exr"], "has no ####"),
        (["--to", "slurm"], ["filter", "s.#.exr", "-oo.#.exr"], "no such frames"),
        (["--to", "openjd"], ["filter", "{{s}}.#.exr", "-oo.#.exr"], "{{, which"),
        (["--to", "lsf"], WORDS, "is none of slurm|openjd|script"),
        (["--to", "slurm", "--views-per-task", "2"], WORDS, "is for povray"),
        (["--to", "script", "--measure", "--chunk=2"], WORDS, "leave one out"),
        (["--to", "script"], ["povray", "s.pov", "-oo.#.png"], "give --frames A-B"),
    ],
)
def test_wrong_usage(submit, tmp_path, arguments, words, reason):
    done = submit(tmp_path, *arguments, words=words, code=2)
    assert reason in done.stderr
