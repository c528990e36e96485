# SPDX-License-Identifier: Apache-2.0
"""What goes wrong around the command: memory, threads, disk, signals, other writers. In
every case the old file is whole or the new one is, and what is said names the reason.
"""

import fcntl
import os
import re
import resource
import shutil
import signal
import subprocess

import numpy
import plainexr
import pytest
from machine import peak_of

LENS = ["--focus-distance", "6", "--lens-radius", "0.1", "--focal-length-px", "60"]


def scene(path, size=(24, 16), seed=0, **options):
    rng = numpy.random.default_rng(seed)
    z = numpy.where(rng.random(size[::-1]) < 0.3, 3, 12)
    channels = {name: rng.random(size[::-1]) for name in "RGB"}
    return plainexr.write(path, dict(channels, Z=z), **options)


def run(binary, *arguments, **options):
    options.setdefault("timeout", 120)
    command = [binary, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, **options)


def run_failing(binary, failing, count, *arguments, **faults):
    """Runs with faults injected; returns the result and how many calls there were, of
    memory, threads, files and writes.
    """
    count.unlink(missing_ok=True)
    done = run(binary, *arguments, env=with_faults(failing, count, **faults))
    numbers = [int(n) for n in count.read_text().split()] if count.exists() else None
    return done, numbers


def with_faults(failing, count, **faults):
    environment = dict(os.environ, LD_PRELOAD=failing, FAIL_COUNT=str(count))
    environment.update({name: str(int(k)) for name, k in faults.items()})
    return environment


def moments(binary, failing, count, *arguments):
    """Every file call of a run and a dozen of its writes, as faults."""
    done, (_, _, n_files, n_writes) = run_failing(binary, failing, count, *arguments)
    assert done.returncode == 0 and n_files >= 6
    writes = range(1, n_writes + 1, max(1, n_writes // 12))
    files = range(1, n_files + 1)
    return [{"FAIL_FILE": k} for k in files] + [{"FAIL_WRITE": k} for k in writes]


def leftovers(folder):
    return [p.name for p in folder.iterdir() if ".part" in p.name]


# ---- memory ----------------------------------------------------------------------


COMMANDS = {
    "filter": ["filter", "IN", "-o", "OUT.exr", *LENS, "-j1"],
    "png": ["filter", "IN", "-o", "OUT.png", *LENS, "-j1", "--method", "scatter"],
    "info": ["info", "IN"],
    "compare": ["compare", "IN", "IN", "-j1"],
    "sequence": ["filter", "S.#.exr", "-o", "OUT.#.exr", *LENS, "-j1", "--jobs", "1"],
}


# Out of memory: what a larger picture needs.
WAYS = {
    "filter": "; --max-memory MIB reads, filters and writes it in parts\n",
    "png": "; free some memory, or give a smaller picture\n",
}


def is_same(path, whole):
    """The same bytes, or picture: zlib without memory leaves a chunk as it is."""
    if path.read_bytes() == whole:
        return True
    other = path.with_name("whole.exr")
    other.write_bytes(whole)
    (a, of_a), (b, of_b) = plainexr.read(path), plainexr.read(other)
    other.unlink()
    return of_a == of_b and all((a[name] == b[name]).all() for name in set(a) | set(b))


@pytest.mark.parametrize("kind", COMMANDS)
def test_every_allocation_may_fail(binary, failing, tmp_path, kind):
    """The k-th allocation fails, for every k: no crash, no half file."""
    source = scene(tmp_path / "in.exr")
    scene(tmp_path / "S.1.exr")
    words = {"IN": source, "S.#.exr": tmp_path / "S.#.exr"}
    arguments = [
        words.get(word, tmp_path / word if word.startswith("OUT") else word)
        for word in COMMANDS[kind]
    ]
    outputs = [tmp_path / name for name in ("OUT.exr", "OUT.png", "OUT.1.exr")]
    count = tmp_path / "count"
    done, (n, *_) = run_failing(binary, failing, count, *arguments)
    assert done.returncode == 0 and n > 30
    whole = {p: p.read_bytes() for p in outputs if p.exists()}
    n_failed = n_answers = 0
    # The first ones are the C library's own, before main() is reached.
    for k in range(1, n + 1):
        for path in [*outputs, tmp_path / "OUT.#.exr.frames"]:
            path.unlink(missing_ok=True)
        done, _ = run_failing(binary, failing, count, *arguments, FAIL_ALLOCATION=k)
        where = (kind, k, n, done.returncode, done.stderr[-300:])
        assert done.returncode in (0, 1, 2, 127), where
        assert done.returncode == 0 or done.stderr, where
        assert leftovers(tmp_path) == [], where
        for path in outputs:
            if path.exists():
                assert is_same(path, whole[path]), where
            else:
                assert path not in whole or done.returncode != 0, where
        n_failed += done.returncode != 0
        n_answers += "in.exr: out of memory" in done.stderr and (
            WAYS.get(kind, "-") in done.stderr
        )
    print(f"{kind}: {n} allocations failed, {n_failed} of them ended the command")
    assert n_failed > n // 4
    assert n_answers >= 3 or kind not in WAYS


def test_no_threads(binary, failing, tmp_path):
    """The system gives no threads, or fewer: the same picture with what there is."""
    source, out, count = scene(tmp_path / "in.exr"), tmp_path / "o.exr", tmp_path / "n"
    arguments = ["filter", source, "-o", out, *LENS, "-j5"]
    done, (_, n, *_) = run_failing(binary, failing, count, *arguments)
    assert done.returncode == 0 and n > 4
    want = out.read_bytes()
    for k in range(1, n + 1):
        out.unlink()
        done, _ = run_failing(binary, failing, count, *arguments, FAIL_THREAD=k)
        assert done.returncode == 0, done.stderr
        # The filter's four come last, after those that watch for signals and read.
        assert f"only {max(k - (n - 4), 1)} of 5 threads" in done.stderr
        assert out.read_bytes() == want
    scene(tmp_path / "S.1.exr")
    scene(tmp_path / "S.2.exr")
    arguments = ["filter", tmp_path / "S.#.exr", "-o", tmp_path / "T.#.exr", *LENS]
    done, _ = run_failing(binary, failing, count, *arguments, "-j2", FAIL_THREAD=1)
    assert done.returncode == 0 and (tmp_path / "T.2.exr").exists()


@pytest.mark.parametrize("compression", range(10))
def test_a_header_that_promises_too_much(binary, tmp_path, compression):
    """A few kB that claim 65535 x 65535 px: refused before any memory is taken."""
    path = tmp_path / "bomb.exr"
    scene(path)
    data = bytearray(path.read_bytes())
    for size in (65535, 20000, 9000):
        at = data.index(b"dataWindow\0box2i\0") + 17 + 4
        data[at : at + 16] = numpy.array([0, 0, size - 1, size - 1], "<i4").tobytes()
        at = data.index(b"compression\0compression\0") + 24 + 4
        data[at] = compression
        path.write_bytes(data)
        for command in (["info", path], ["filter", path, "-o", tmp_path / "o.exr"]):
            megabytes, code, said = peak_of(binary, *command)
            assert code == 1 and str(path) in said
            assert megabytes < 120, (size, command)


def test_memory_follows_the_header(binary, tmp_path):
    """A picture needs so many bytes per pixel and not more, whatever is in it."""
    source = scene(tmp_path / "in.exr", (1200, 800))
    small, _, _ = peak_of(binary, "info", scene(tmp_path / "s.exr"))
    arguments = ["filter", source, "-o", tmp_path / "o.exr", "-q", "-j1"]
    large, code, said = peak_of(binary, *arguments, "--lens-radius", "0.001")
    assert code == 0, said
    assert (large - small) * 2**20 < 700 * 1200 * 800


# ---- files -----------------------------------------------------------------------


@pytest.fixture
def disk(tmp_path):
    """A file system of 256 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    options = "size=256k"
    command = ["mount", "-t", "tmpfs", "-o", options, "rf_test", folder]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("mounting needs root")
    yield folder
    subprocess.run(["umount", "-l", folder], check=False)


def test_full_disk_in_a_sequence(binary, disk, tmp_path):
    """Frames are made until the disk is full; those are whole, the others reported."""
    for i in range(1, 7):
        scene(tmp_path / f"s.{i}.exr", (96, 96), i)
    pattern = [tmp_path / "s.#.exr", "-o", disk / "o.#.exr", "--compression", "none"]
    options = ["--type", "float", *LENS]
    done = run(binary, "filter", *pattern, *options)
    assert done.returncode == 1
    assert "no space left on the disk" in done.stderr
    made = sorted(disk.glob("o.?.exr"))
    assert 1 <= len(made) < 6
    for path in made:
        assert plainexr.read(path)[0]["R"].shape == (96, 96)
    assert leftovers(disk) == []
    failed = done.stderr.count("failed: frame")
    assert failed == 6 - len(made)
    kept = {path: path.stat().st_mtime_ns for path in made}
    subprocess.run(["mount", "-o", "remount,size=4m", disk], check=True)
    done = run(binary, "filter", *pattern, *options)
    assert done.returncode == 0, done.stderr
    assert len(list(disk.glob("o.?.exr"))) == 6
    # A full disk may have lost a line of the journal, never a frame.
    assert all(path.exists() for path in kept)


TEMPORARY = "name another folder in TMPDIR"


@pytest.mark.parametrize(
    "words, expected",
    [
        ("IN -o -", [f"DISK: no space left on its disk for temp.*{TEMPORARY}"]),
        ("- -o OUT", [f"standard input: no space left in DISK.*{TEMPORARY}"]),
        (
            "IN IN --stereo -o DISK/o.exr",
            ["DISK: no space left.*free some space there"],
        ),
        ("IN -o DISK/o.exr", ["DISK/o.exr: no space left.*free some space there$"]),
    ],
)
def test_full_disk_of_temporary_files(binary, disk, tmp_path, words, expected):
    """What is said names a folder that is still there, and what to do."""
    source = scene(tmp_path / "in.exr", (200, 150))
    places = {"DISK": str(disk), "IN": str(source), "OUT": str(tmp_path / "o.exr")}
    with open(disk / "fill", "wb") as fill:
        fill.write(bytes(200 << 10))
    for name, place in places.items():
        words = words.replace(name, place)
        expected = [text.replace(name, place) for text in expected]
    with open(source, "rb") as file:
        done = run(binary, "filter", *words.split(), *LENS, stdin=file,
                   env=dict(os.environ, TMPDIR=str(disk)))  # fmt: skip
    assert done.returncode == 1 and not done.stdout
    for text in expected:
        assert re.search(text, done.stderr, re.MULTILINE), done.stderr
    assert os.listdir(disk) == ["fill"] and not (tmp_path / "o.exr").exists()


def test_read_only_folder(binary, disk, tmp_path):
    source, old = scene(tmp_path / "in.exr"), disk / "o.exr"
    old.write_bytes(b"old")
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    done = run(binary, "filter", source, "-o", old, *LENS)
    assert done.returncode == 1 and str(old) in done.stderr
    assert "ead-only" in done.stderr
    assert old.read_bytes() == b"old"
    done = run(binary, "filter", source, "-o", disk / "new.exr", *LENS)
    assert done.returncode == 1 and not (disk / "new.exr").exists()


@pytest.mark.parametrize("kind", ["filter", "png"])
def test_every_file_call_may_fail(binary, failing, tmp_path, kind):
    """The k-th call fails, for every k: the old file stays or the new one is whole."""
    source, count = scene(tmp_path / "in.exr"), tmp_path / "count"
    out = tmp_path / next(word for word in COMMANDS[kind] if word.startswith("OUT"))
    words = {"IN": source, out.name: out}
    arguments = [words.get(word, word) for word in COMMANDS[kind]]
    faults = moments(binary, failing, count, *arguments)
    whole = out.read_bytes()
    n_failed = 0
    for fault in faults:
        out.write_bytes(b"old")
        done, _ = run_failing(binary, failing, count, *arguments, **fault)
        assert done.returncode in (0, 1), (fault, done.returncode, done.stderr)
        assert done.returncode == 0 or str(tmp_path) in done.stderr, fault
        assert out.read_bytes() == (b"old" if done.returncode else whole)
        assert leftovers(tmp_path) == []
        n_failed += done.returncode
    # Reading, creating, writing, syncing, renaming; the folder's sync may fail.
    assert n_failed >= 5


def stopped(command, failing, count, fault):
    """The command, stopped at a moment."""
    environment = with_faults(failing, count, FAIL_SIGNAL=signal.SIGSTOP, **fault)
    process = subprocess.Popen(command, env=environment)
    _, status = os.waitpid(process.pid, os.WUNTRACED)
    assert os.WIFSTOPPED(status), fault
    return process


def test_two_writers(binary, failing, tmp_path):
    """One is stopped before each of its file calls, and another writes the same file
    meanwhile: at any moment the file is the one or the other.
    """
    source, out = scene(tmp_path / "in.exr"), tmp_path / "o.exr"
    commands, whole = [], []
    for blades in ("0", "3"):
        command = [binary, "filter", source, "-o", out, *LENS, "--blades", blades]
        commands.append([str(word) for word in [*command, "-j1"]])
        subprocess.run(commands[-1], check=True)
        whole.append(out.read_bytes())
    assert whole[0] != whole[1]
    count, seen = tmp_path / "count", set()
    for fault in moments(binary, failing, count, *commands[0][1:]):
        out.write_bytes(whole[1])
        process = stopped(commands[0], failing, count, fault)
        before = whole.index(out.read_bytes())
        subprocess.run(commands[1], check=True)
        assert out.read_bytes() == whole[1]
        process.send_signal(signal.SIGCONT)
        assert process.wait(60) == 0
        seen.add((before, whole.index(out.read_bytes())))
        assert leftovers(tmp_path) == []
    # Stopped before its rename it comes last, stopped after it first.
    assert seen == {(1, 0), (0, 1)}


def test_what_is_left_of_dead_writers(binary, tmp_path):
    """Only what has the very name and no living owner goes."""
    source, out = scene(tmp_path / "in.exr"), tmp_path / "o.exr"
    dead = tmp_path / "o.exr.part00c0de"
    kept = ["o.exr.part00c0d", "o.exr.part00c0de1", "o.exr.partXYZabc", "o.exr.part",
            "p.exr.part00c0de", "ao.exr.part00c0de"]  # fmt: skip
    for name in [dead.name, *kept]:
        (tmp_path / name).write_bytes(b"left")
    (tmp_path / "o.exr.part00f01d").mkdir()
    (tmp_path / "o.exr.part0011bc").symlink_to(tmp_path / kept[0])
    living = tmp_path / "o.exr.part00beef"
    with living.open("wb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert run(binary, "filter", source, "-o", out, *LENS).returncode == 0
        assert living.exists() and not dead.exists()
    kept += ["o.exr.part00f01d", "o.exr.part0011bc", living.name]
    assert sorted(leftovers(tmp_path)) == sorted(kept)
    (tmp_path / "o.exr.part00f01d").rmdir()
    assert run(binary, "filter", source, "-o", out, *LENS).returncode == 0
    assert not living.exists()


def test_names_as_long_as_can_be(binary, tmp_path):
    """The one it is written under is no longer; two that begin alike do not meet."""
    source = scene(tmp_path / "in.exr")
    long = ["a" * 251 + ".exr", "a" * 250 + "b.exr", "\u00e4" * 125 + "x.exr"]
    dead = tmp_path / ("\u00e4" * 122 + ".part00c0de")
    dead.write_bytes(b"left")
    for name in long:
        done = run(binary, "filter", source, "-o", tmp_path / name, *LENS)
        assert done.returncode == 0, done.stderr
        assert os.path.getsize(tmp_path / name) > 1000
    assert leftovers(tmp_path) == []
    living = tmp_path / ("a" * 244 + ".part00beef")
    with living.open("wb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert (
            run(binary, "filter", source, "-o", tmp_path / long[0], *LENS).returncode
            == 0
        )
        assert leftovers(tmp_path) == [living.name]


def test_output_is_the_input(binary, tmp_path):
    """It is refused, and stays as it was."""
    path = tmp_path / "in.exr"
    scene(path)
    before = path.read_bytes()
    done = run(binary, "filter", path, "-o", path, *LENS)
    assert done.returncode == 2 and "is also the input" in done.stderr
    assert path.read_bytes() == before
    scene(tmp_path / "s.1.exr")
    pattern = tmp_path / "s.#.exr"
    done = run(binary, "filter", pattern, "-o", pattern, *LENS)
    assert done.returncode == 2 and "is also the input" in done.stderr


# ---- the end ---------------------------------------------------------------------


def frames(folder, n, size=(40, 30)):
    for i in range(1, n + 1):
        scene(folder / f"s.{i}.exr", size, i)
    return ["filter", folder / "s.#.exr", "-o", folder / "o.#.exr", *LENS, "-j1"]


def test_killed_at_any_moment(binary, failing, tmp_path):
    """kill -9 before every file call: what is there is whole, and the next run makes
    the rest, skipping what the journal knows.
    """
    arguments, count = [*frames(tmp_path, 2), "--jobs", "1"], tmp_path / "count"
    faults = moments(binary, failing, count, *arguments)
    want = {p.name: p.read_bytes() for p in tmp_path.glob("o.?.exr")}
    assert len(want) == 2
    n_left = 0
    for fault in faults:
        for path in tmp_path.glob("o.*"):
            path.unlink()
        fault["FAIL_SIGNAL"] = signal.SIGKILL
        done, _ = run_failing(binary, failing, count, *arguments, **fault)
        assert done.returncode == -signal.SIGKILL, fault
        left = leftovers(tmp_path)
        made = {p.name: p.read_bytes() for p in tmp_path.glob("o.?.exr")}
        assert made.items() <= want.items(), fault
        done = run(binary, *arguments)
        assert done.returncode == 0, done.stderr
        n_left = max(n_left, len(left))
        assert leftovers(tmp_path) == []  # those of the killed one are gone
        assert {p.name: p.read_bytes() for p in tmp_path.glob("o.?.exr")} == want
        # A frame that was renamed may have missed the journal: it is made again.
        n_skipped = int(re.search(r"(\d+) skipped", done.stdout)[1])
        assert len(made) - 1 <= n_skipped <= len(made)
    assert n_left == 1
    print(f"killed {len(faults)} times")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_in_a_sequence(binary, failing, tmp_path, number):
    """Before every file call: the frame in work goes, the rest is said to be left."""
    arguments, count = [*frames(tmp_path, 2), "--jobs", "1"], tmp_path / "count"
    faults = moments(binary, failing, count, *arguments)
    want = {p.name: p.read_bytes() for p in tmp_path.glob("o.?.exr")}
    lefts = set()
    for fault in faults:
        for path in tmp_path.glob("o.*"):
            path.unlink()
        fault["FAIL_SIGNAL"] = number
        done, _ = run_failing(binary, failing, count, *arguments, **fault)
        made = {p.name: p.read_bytes() for p in tmp_path.glob("o.?.exr")}
        assert made.items() <= want.items(), fault
        assert leftovers(tmp_path) == []
        if done.returncode == -number:
            assert not made  # before the handler stood
            continue
        assert done.returncode == 128 + number
        left = int(re.search(r"(\d+) left; ", done.stdout)[1])
        assert left == 2 - len(made)
        lefts.add(left)
    assert lefts == {0, 1, 2}


def test_signal_while_filtering(binary, failing, tmp_path):
    """Before every n-th allocation: interrupted without a file, or done with one."""
    source, out, count = scene(tmp_path / "in.exr"), tmp_path / "o.exr", tmp_path / "n"
    arguments = ["filter", source, "-o", out, *LENS, "-j1"]
    done, (n, *_) = run_failing(binary, failing, count, *arguments)
    assert done.returncode == 0
    codes = set()
    for k in range(1, n, max(1, n // 60)):
        out.unlink(missing_ok=True)
        fault = {"FAIL_ALLOCATION": k, "FAIL_SIGNAL": signal.SIGINT}
        done, _ = run_failing(binary, failing, count, *arguments, **fault)
        assert done.returncode in (0, 130, -signal.SIGINT) and done.stderr == ""
        assert out.exists() == (done.returncode == 0)
        assert leftovers(tmp_path) == []
        codes.add(done.returncode)
    assert 130 in codes


PAGES = {
    "compare-methods": (
        ["compare-methods", "in.exr", "--reference", "in.exr", "--method", "box",
         "--blend", "coc", "--repeats", "1", *LENS, "-j1", "-q", "--results", "all",
         "--html", "page.html"],
        "page_pictures",
    ),
    "frames": (["frames", "o.#.exr", "--frames", "1", "--html", "page.html", "-q"],
               "page_frames"),
}  # fmt: skip


@pytest.mark.parametrize("command", PAGES)
def test_signal_before_a_page_is_made(binary, failing, tmp_path, command):
    """Before every file call: no empty folder, and no pictures without their page."""
    arguments, pictures = PAGES[command]
    scene(tmp_path / "in.exr")
    scene(tmp_path / "o.1.exr")
    command_line = [binary, *arguments]
    page, count = tmp_path / "page.html", tmp_path / "count"
    made = [tmp_path / pictures, tmp_path / "all"]
    environment = with_faults(failing, count)
    subprocess.run(command_line, cwd=tmp_path, env=environment, check=True)
    assert page.exists() and any(made[0].iterdir())
    codes = set()
    for k in range(1, int(count.read_text().split()[2]) + 1):
        page.unlink(missing_ok=True)
        for folder in made:
            shutil.rmtree(folder, ignore_errors=True)
        faults = {"FAIL_FILE": k, "FAIL_SIGNAL": signal.SIGINT}
        environment = with_faults(failing, count, **faults)
        codes.add(
            subprocess.run(command_line, cwd=tmp_path, env=environment).returncode
        )
        assert made[0].exists() == page.exists(), k
        assert not made[1].exists() or any(made[1].iterdir()), k
    assert codes >= {130}


def test_a_run_that_fails_leaves_no_folder_it_made(binary, tmp_path):
    scene(tmp_path / "in.exr")
    scene(tmp_path / "large.exr", size=(32, 16))
    (tmp_path / "there").mkdir()
    for results in ("there", "new"):
        done = run(binary, "compare-methods", "in.exr", "--reference", "large.exr",
                   "--results", results, *LENS, cwd=tmp_path)  # fmt: skip
        assert done.returncode == 1 and "large.exr" in done.stderr
    assert (tmp_path / "there").exists() and not (tmp_path / "new").exists()


@pytest.mark.parametrize("command", ["info", "methods", "help", "compare", "filter"])
def test_closed_pipe(binary, tmp_path, command):
    """Nobody reads what is printed: no crash, and the file is made all the same."""
    source, out = scene(tmp_path / "in.exr"), tmp_path / "o.exr"
    arguments = {
        "info": [source],
        "compare": [source, source],
        "filter": [source, "-o", out, *LENS],
    }.get(command, [])
    reader, writer = os.pipe()
    os.close(reader)
    process = subprocess.Popen(
        [binary, command, *map(str, arguments)],
        stdout=writer,
        stderr=writer,
    )
    os.close(writer)
    assert process.wait(60) == 0
    assert command != "filter" or out.exists()


def test_no_descriptors(binary, tmp_path):
    """No file can be opened any more: said, and nothing is left."""
    source, out = scene(tmp_path / "in.exr"), tmp_path / "o.exr"
    outcomes = set()
    for n in range(3, 16):

        def limit(n=n):
            resource.setrlimit(resource.RLIMIT_NOFILE, (n, n))

        done = run(binary, "filter", source, "-o", out, *LENS, preexec_fn=limit)
        assert done.returncode in (0, 1, 127), done.stderr
        assert done.returncode == 0 or done.stderr
        assert out.exists() == (done.returncode == 0)
        assert leftovers(tmp_path) == []
        outcomes.add(done.returncode)
        out.unlink(missing_ok=True)
    assert 0 in outcomes and len(outcomes) > 1


# ---- work that does not ask ------------------------------------------------------


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_work_that_never_asks_is_ended(tmp_path, number):
    """A signal ends it all the same, and nothing stays."""
    program = os.path.join(os.environ["RACKFOCUS_BUILD"], "tests/faults/hang")
    child = subprocess.Popen(
        [program, tmp_path], stdout=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    )  # fmt: skip
    try:
        assert child.stdout.readline() == "ready\n"
        assert len(list(tmp_path.iterdir())) == 2
        child.send_signal(number)
        assert child.wait(60) == 128 + number
    finally:
        child.kill()
        child.stdout.close()
    assert list(tmp_path.iterdir()) == []
