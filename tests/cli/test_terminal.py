# SPDX-License-Identifier: Apache-2.0
"""The progress bar, and what Ctrl-C leaves behind."""

import os
import pty
import re
import select
import signal
import subprocess
import time

import pytest

BIG = ["--focus-distance", "6", "--lens-radius", "1", "--focal-length-px", "600"]
# Work for many seconds, so that what is sent while it goes on cannot come too late.
SLOW = ["--focus-distance", "6", "--lens-radius", "9", "--focal-length-px", "600",
        "--method", "scatter"]  # fmt: skip


@pytest.fixture(autouse=True)
def is_a_terminal(monkeypatch):
    """Where a farm runs the tests, TERM may be missing."""
    monkeypatch.setenv("TERM", "xterm")


@pytest.fixture
def big_scene(scene):
    return scene(size=(1400, 900))


class Terminal:
    """A command whose stderr is a terminal."""

    def __init__(self, command):
        self.master, slave = pty.openpty()
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=slave)
        os.close(slave)
        self.text = b""

    def read_until(self, word, limit_s=60):
        """Reads until the word or the end; says whether the word came."""
        end = time.monotonic() + limit_s
        while word not in self.text and time.monotonic() < end:
            ready, _, _ = select.select([self.master], [], [], 0.2)
            if not ready:
                continue
            try:
                data = os.read(self.master, 4096)
            except OSError:
                break
            if not data:
                break
            self.text += data
        return word in self.text

    def finish(self):
        self.read_until(b"\0never")
        os.close(self.master)
        return self.process.wait(timeout=60)


def test_bar_on_a_terminal(binary, scene, tmp_path):
    out = tmp_path / "out.exr"
    path = scene(size=(700, 450))
    terminal = Terminal([binary, "filter", path, "-o", str(out), *BIG])
    assert terminal.finish() == 0
    text = terminal.text.decode()
    assert "filtering [" in text and "%" in text and "#" in text
    assert re.search(r"\r +\r$", text), "the bar is wiped at the end"
    assert "\x1b" not in text
    assert out.exists()


def test_time_left_on_a_terminal(binary, big_scene, tmp_path):
    out = str(tmp_path / "out.exr")
    terminal = Terminal([binary, "filter", big_scene, "-o", out, *SLOW])
    assert terminal.read_until(b" s left")
    terminal.process.send_signal(signal.SIGINT)
    assert terminal.finish() == 130


def test_quiet_on_a_terminal(binary, scene, tmp_path):
    command = [binary, "filter", scene(), "-o", str(tmp_path / "out.exr"), "-q"]
    terminal = Terminal(command)
    assert terminal.finish() == 0 and terminal.text == b""


def test_no_bar_in_a_pipe(rackfocus, scene, tmp_path):
    lens = ["--focus-distance", "6", "--lens-radius", "0.1"]
    done = rackfocus("filter", scene(), "-o", tmp_path / "out.exr", *lens)
    assert done.stderr == "" and done.stdout.count("\n") == 1


@pytest.mark.parametrize("kind", ["dumb", "", None])
def test_no_escapes_where_nobody_obeys_them(binary, scene, tmp_path, kind, monkeypatch):
    if kind is None:
        monkeypatch.delenv("TERM", raising=False)
    else:
        monkeypatch.setenv("TERM", kind)
    lens = ["--focus-distance", "6", "--lens-radius", "0.1"]
    terminal = Terminal(
        [binary, "filter", scene(), "-o", str(tmp_path / "o.exr"), *lens]
    )
    assert terminal.finish() == 0
    assert b"\033" not in terminal.text and b"%" not in terminal.text


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_interruption(binary, big_scene, tmp_path, number, code):
    before = sorted(os.listdir(tmp_path))
    out, radii = str(tmp_path / "out.exr"), str(tmp_path / "coc.exr")
    command = [binary, "filter", big_scene, "-o", out, "--output-coc", radii, *SLOW]
    terminal = Terminal(command)
    assert terminal.read_until(b"%")
    terminal.process.send_signal(number)
    assert terminal.finish() == code
    assert sorted(os.listdir(tmp_path)) == before


def test_old_output_survives_an_interruption(binary, big_scene, tmp_path):
    out = tmp_path / "out.exr"
    out.write_bytes(b"old")
    terminal = Terminal([binary, "filter", big_scene, "-o", str(out), *SLOW])
    assert terminal.read_until(b"%")
    terminal.process.send_signal(signal.SIGINT)
    assert terminal.finish() == 130
    assert out.read_bytes() == b"old"
