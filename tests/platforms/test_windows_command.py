# SPDX-License-Identifier: Apache-2.0
"""The command on Windows x64 under wine: it does what the one of Linux does, to the bit,
and takes the names and line ends that Windows has."""

import json
import os
import shutil
import signal
import subprocess
import time

import pytest
from systems import BUILD, OS_PROGRAMS, ROOT, WINE, run

REFERENCES = ROOT / "tests" / "quality" / "references"
LINUX = BUILD / "cli" / "rackfocus"
ODD = "Größe 日本 'x' (1)"  # blanks, quotes, letters of several scripts


@pytest.fixture(scope="module")
def command(windows, wine):
    """Runs the command of Windows with these arguments; gives what it prints."""
    program = windows / "cli" / "rackfocus.exe"
    return lambda *words, **options: wine(program, *words, **options)


def native(*words, **options):
    return run(LINUX, *words, **options)


def on_windows(path):
    """The name that wine gives it."""
    return "Z:" + str(path).replace("/", "\\")


@pytest.fixture
def scene(tmp_path):
    """A pinhole picture with depth, with an odd name in a folder of one."""
    folder = tmp_path / ODD
    folder.mkdir()
    path = folder / "passes ä.exr"
    shutil.copy(REFERENCES / "portrait_pinhole.exr", path)
    return path


def same_bits(one, other):
    """The pictures have the same samples, whatever their compression."""
    return json.loads(native("compare", "--json", one, other))["identical"]


@pytest.mark.parametrize("name", OS_PROGRAMS)
def test_os(name, windows, wine):
    """Threads, processes and folders as the command uses them."""
    said = wine(windows / "tests" / "os" / f"test_{name}.exe", OS_PROGRAMS[name])
    assert "ok 1" in said and "not ok" not in said, said


LENS = ("--focus-distance", 3, "--lens-radius", 0.02)


def test_filter_has_the_bits_of_linux(command, scene, tmp_path):
    ours, theirs = scene.parent / "out ß.exr", tmp_path / "linux.exr"
    command("filter", "-q", on_windows(scene), "-o", on_windows(ours), *LENS)
    native("filter", "-q", scene, "-o", theirs, *LENS)
    assert same_bits(ours, theirs)
    left = sorted(path.name for path in scene.parent.iterdir())
    assert left == sorted([scene.name, ours.name]), "nothing else stays"


def test_info_says_the_same(command, scene):
    assert command("info", "--all", scene) == native("info", "--all", scene)


def test_an_old_file_is_replaced_and_a_folder_is_not(command, scene):
    out = scene.parent / "out.exr"
    out.write_text("old")
    command("filter", "-q", scene, "-o", out, *LENS)
    assert out.read_bytes()[:4] == b"v/1\x01"
    folder = scene.parent / "folder.exr"
    folder.mkdir()
    with pytest.raises(AssertionError, match="is a folder"):
        command("filter", "-q", scene, "-o", folder, *LENS)


def test_long_paths(command, scene, tmp_path):
    folder = tmp_path
    for i in range(6):
        folder = folder / f"{i}{'n' * 60}"
    folder.mkdir(parents=True)
    assert len(str(folder)) > 300
    shutil.copy(scene, folder / "in.exr")
    command(
        "filter",
        "-q",
        on_windows(folder / "in.exr"),
        "-o",
        on_windows(folder / "out.exr"),
        *LENS,
    )
    assert sorted(path.name for path in folder.iterdir()) == ["in.exr", "out.exr"]


def test_names_relative_to_a_folder(command, scene):
    command("filter", "-q", scene.name, "-o", "near.png", *LENS, cwd=scene.parent)
    assert (scene.parent / "near.png").read_bytes()[1:4] == b"PNG"


def test_settings_with_the_line_ends_of_windows(command, scene, tmp_path):
    settings = tmp_path / "lens.txt"
    settings.write_bytes(b"focus-distance 3\r\nlens-radius 0.02\r\n")
    command("filter", "-q", scene, "-o", tmp_path / "a.exr", "--params", settings)
    native("filter", "-q", scene, "-o", tmp_path / "b.exr", *LENS)
    assert same_bits(tmp_path / "a.exr", tmp_path / "b.exr")


def test_a_sequence(command, scene, tmp_path):
    for i in (7, 8):
        shutil.copy(scene, tmp_path / f"frame_{i:04}.exr")
    pattern = on_windows(tmp_path) + "\\"
    command(
        "filter",
        "-q",
        pattern + "frame_####.exr",
        "-o",
        pattern + "out_####.exr",
        *LENS,
    )
    native("filter", "-q", scene, "-o", tmp_path / "one.exr", *LENS)
    for i in (7, 8):
        assert same_bits(tmp_path / f"out_{i:04}.exr", tmp_path / "one.exr")


def test_bytes_pass_through_pipes(windows, wine_environment, scene, tmp_path):
    """Of the command: wine gives it the pipes as they are."""
    program = windows / "cli" / "rackfocus.exe"
    words = [WINE, program, "filter", "-q", "-", "-o", "-", *map(str, LENS)]
    done = subprocess.run(
        words,
        input=scene.read_bytes(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=wine_environment,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr.decode()
    (tmp_path / "piped.exr").write_bytes(done.stdout)
    native("filter", "-q", scene, "-o", tmp_path / "linux.exr", *LENS)
    assert same_bits(tmp_path / "piped.exr", tmp_path / "linux.exr")


def test_errors_name_the_file(windows, wine_environment, tmp_path):
    program = windows / "cli" / "rackfocus.exe"
    missing = on_windows(tmp_path / "日本.exr")
    done = subprocess.run(
        [WINE, program, "info", missing],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env=wine_environment,
    )
    assert done.returncode == 1
    assert missing in done.stderr and "No such file" in done.stderr


def test_a_file_that_is_open_elsewhere_stays(
    windows, wine_environment, scene, tmp_path
):
    """The command says what holds it up, and leaves nothing beside."""
    old = tmp_path / "out.exr"
    old.write_bytes(b"old")
    holder = windows / "tests" / "os" / "test_process_windows.exe"
    words = [WINE, holder, "hold", on_windows(old), on_windows(tmp_path / "end")]
    with subprocess.Popen(words, stdout=subprocess.PIPE, env=wine_environment) as held:
        assert held.stdout.readline().strip() == b"open"
        program = windows / "cli" / "rackfocus.exe"
        words = [WINE, program, "filter", "-q", scene, "-o", old, *map(str, LENS)]
        done = subprocess.run(
            words, capture_output=True, text=True, env=wine_environment, timeout=300
        )
        assert old.read_bytes() == b"old"
        (tmp_path / "end").write_text("")
        assert held.wait(timeout=200) == 0
    assert done.returncode == 1
    assert "another program has it open" in done.stderr, done.stderr
    assert not list(tmp_path.glob("*.part*"))
    done = subprocess.run(words, capture_output=True, env=wine_environment, timeout=300)
    assert done.returncode == 0 and old.read_bytes()[:4] == b"v/1\x01"


def test_ctrl_c_leaves_nothing(windows, wine_environment, scene, tmp_path):
    """wine makes a CTRL_C_EVENT of SIGINT."""
    for i in range(300):
        os.link(scene, tmp_path / f"in_{i:04}.exr")
    program = windows / "cli" / "rackfocus.exe"
    pattern = [tmp_path / "in_####.exr", "-o", tmp_path / "out_####.exr"]
    words = [WINE, program, "filter", "-q", *pattern, "-j1", *map(str, LENS)]
    with subprocess.Popen(words, env=wine_environment) as process:
        while not (tmp_path / "out_0001.exr").exists():
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=100) == 130
    made = list(tmp_path.glob("out_*"))
    assert 1 <= len(made) < 300
    assert not list(tmp_path.glob("*.part*"))
