# SPDX-License-Identifier: Apache-2.0
"""A window under Xvfb, with someone who clicks, drags, types and looks."""

import json
import os
import pathlib
import shlex
import subprocess
import sys
import time

import numpy
import OpenImageIO as oiio
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "cli"))
import plainexr  # noqa: E402

WAIT_S = int(
    os.environ.get("RACKFOCUS_WAIT", 90)
)  # for what takes a second on an idle machine


class Display:
    """An X server without a screen, and no window manager."""

    def __init__(self, size=(1280, 900), options=()):
        out, to = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(to), "-noreset", "-nolisten", "tcp"]
            + ["-screen", "0", f"{size[0]}x{size[1]}x24", *options],
            pass_fds=[to],
            stderr=subprocess.DEVNULL,
        )
        os.close(to)
        with os.fdopen(out) as pipe:
            self.name = ":" + pipe.readline().strip()
        assert self.name != ":", "Xvfb did not start"

    def environment(self):
        about = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"}
        return {
            **about,
            "DISPLAY": self.name,
            "SDL_VIDEODRIVER": "x11",
            "LIBGL_ALWAYS_SOFTWARE": "1",
        }

    def close(self):
        self.server.terminate()
        self.server.wait(timeout=30)


@pytest.fixture(scope="session")
def display():
    shown = Display()
    yield shown
    shown.close()


class Window:
    """A running `rackfocus view`; its trace says what it shows."""

    def __init__(self, binary, display, folder, *arguments):
        self.display, self.folder = display, pathlib.Path(folder)
        self.trace = self.folder / "trace.json"
        self.trace.unlink(missing_ok=True)
        self.out = open(self.folder / "out.txt", "w+")
        command = [binary, "view", "--trace", str(self.trace), *map(str, arguments)]
        self.process = subprocess.Popen(
            command,
            stdout=self.out,
            stderr=subprocess.STDOUT,
            # What it remembers is for the windows of this folder alone.
            env={**display.environment(), "XDG_STATE_HOME": str(self.folder / "state")},
            cwd=self.folder,
        )
        self.known, self.n_bytes = [], 0  # what of the trace was read
        self.n_read = 0  # events that were waited for
        self.x = self.y = 0  # where the window lies on the display

    # ---- what it says ----------------------------------------------------------------

    def events(self):
        if self.trace.exists():
            with self.trace.open("rb") as trace:
                trace.seek(self.n_bytes)
                for line in trace:
                    if line.endswith(b"\n"):  # else it is being written
                        self.known.append(json.loads(line))
                        self.n_bytes += len(line)
        return list(self.known)

    def printed(self):
        self.out.flush()
        return (self.folder / "out.txt").read_text()

    def wait(self, test, what="an event"):
        """The first event from here on that passes the test."""
        end = time.monotonic() + WAIT_S
        while time.monotonic() < end:
            events = self.events()
            for i in range(self.n_read, len(events)):
                if test(events[i]):
                    self.n_read = i + 1
                    return events[i]
            if self.process.poll() is not None and events == self.events():
                break
            time.sleep(0.02)
        seen = "\n".join(str(e)[:300] for e in self.events()[-12:])
        raise AssertionError(
            f"{what} did not come; rc {self.process.poll()}\n{seen}\n{self.printed()}"
        )

    def wait_text(self, event, part=""):
        return self.wait(
            lambda e: e["event"] == event and part in e["text"], f"{event} {part}"
        )["text"]

    def wait_shown(self, **values):
        """Until something is shown whose facts are these."""

        def test(e):
            return e["event"] == "shown" and all(
                e.get(k) == pytest.approx(v) if isinstance(v, float) else e.get(k) == v
                for k, v in values.items()
            )

        return self.wait(test, f"a picture with {values}")

    def wait_best(self, **values):
        return self.wait_shown(quality="best", is_newest=True, **values)

    def drag(self, places):
        """Presses the button at the first place, then waits for a picture at each.

        It is let go when the last one's best picture is there. A machine that is fast
        enough shows no preview before it: only the counter tells a place's picture from
        the second one of the place before.
        """
        self.press(*places[0])
        last = max(e["id"] for e in self.events() if e["event"] == "shown")
        for x, y in places[1:]:
            self.move(x, y)
            last = self.wait(
                lambda e, last=last: e["event"] == "shown" and e["id"] > last,
                f"a picture newer than {last}",
            )["id"]
        self.n_read -= 1  # it may be the best one already
        self.wait_best()
        self.release()

    def wait_open(self):
        """Until the first best picture is there; finds out where the window lies."""
        shown = self.wait_best()
        self.place()
        return shown

    def layout(self):
        return [e for e in self.events() if e["event"] == "layout"][-1]

    # ---- what is done to it ----------------------------------------------------------

    def tool(self, *words):
        done = subprocess.run(
            ["xdotool", *map(str, words)],
            env=self.display.environment(),
            capture_output=True,
            text=True,
            timeout=WAIT_S,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def id(self):
        return self.tool("search", "--onlyvisible", "--name", "Rack Focus").split()[-1]

    def place(self):
        text = self.tool("getwindowgeometry", "--shell", self.id())
        found = dict(line.split("=") for line in text.split())
        self.x, self.y = int(found["X"]), int(found["Y"])

    def move(self, x, y):
        self.tool("mousemove", self.x + round(x), self.y + round(y))

    def click(self, x, y, button=1):
        self.move(x, y)
        self.tool("click", button)

    def press(self, x, y, button=1):
        self.move(x, y)
        self.tool("mousedown", button)

    def release(self, button=1):
        self.tool("mouseup", button)

    def box(self, label):
        controls = self.layout()["controls"]
        found = [box for name, box in controls.items() if name.startswith(label)]
        assert found, f"{label} is not among {list(controls)}"
        return found[0]

    def control(self, label):
        """The middle of a control, which is scrolled into sight first."""
        end = time.monotonic() + WAIT_S
        while time.monotonic() < end:
            x, y, width, height = self.box(label)
            left, top, wide, tall = self.layout()["panel"]
            if top <= y and y + height <= top + tall:
                return x + width / 2, y + height / 2
            self.click(left + 4, top + tall / 2, button=4 if y < top else 5)
            time.sleep(0.1)
        raise AssertionError(f"{label} cannot be scrolled to")

    def open_section(self, name):
        """Unfolds or folds a section; waits until the controls have changed."""
        before = list(self.layout()["controls"])
        self.click_control(f"Section {name}")
        self.wait_until(lambda: list(self.layout()["controls"]) != before, name)

    def choose(self, label, index):
        """Opens the list of a choice and takes an item; -1 is the last one."""
        self.click_control(label)
        self.wait_until(lambda: self.layout()["list"][3] > 0, f"the list of {label}")
        x, y, width, _ = self.layout()["list"]
        row = self.box(label)[3]
        if index < 0:
            index += round(self.layout()["list"][3] / row)
        self.click(x + width / 2, y + (index + 0.5) * row)

    def wait_until(self, test, what="it"):
        end = time.monotonic() + WAIT_S
        while not test():
            assert time.monotonic() < end, f"{what} did not come\n{self.printed()}"
            time.sleep(0.02)

    def double_click(self, label):
        self.move(*self.control(label))
        self.tool("click", "--repeat", 2, "--delay", 60, 1)

    def click_control(self, label):
        self.click(*self.control(label))

    def key(self, *keys):
        self.tool("key", "--delay", 30, *keys)

    def type(self, text):
        self.tool("type", "--delay", 30, "--", text)

    def set_number(self, label, text):
        self.click_control(label)
        self.type(text)
        self.key("Return")

    def on_picture(self, x, y):
        """The window's place of a px of the picture."""
        at = self.layout()
        return at["x"] + (x + 0.5) * at["scale"], at["y"] + (y + 0.5) * at["scale"]

    def drop(self, *paths):
        """Drops files on the window, as a file manager does."""
        script = pathlib.Path(__file__).with_name("drop.py")
        done = subprocess.run(
            [sys.executable, script, self.id(), *map(str, paths)],
            env=self.display.environment(),
            capture_output=True,
            text=True,
            timeout=WAIT_S,
        )
        assert done.returncode == 0, done.stderr

    def resize(self, width, height):
        self.tool("windowsize", self.id(), width, height)

    # ---- what is seen ----------------------------------------------------------------

    def look(self, name="shot"):
        """The window as it is on the display, uint8 RGB."""
        self.tool("mousemove", 2, 2)  # away from the controls
        time.sleep(0.2)
        return self.look_still(name)

    def look_still(self, name="shot"):
        """The same with the mouse where it is."""
        path = self.folder / f"{name}.png"
        subprocess.run(
            ["import", "-window", self.id(), f"png:{path}"],
            env=self.display.environment(),
            check=True,
            timeout=WAIT_S,
        )
        shots = os.environ.get("RACKFOCUS_SHOTS")
        if shots:
            target = pathlib.Path(shots) / f"{name}.png"
            target.write_bytes(path.read_bytes())
        return read_png(path)

    def look_at_picture(self, width, height, name="shot"):
        """The part of the window that shows the picture, at one px a px."""
        if self.layout()["scale"] > 1:
            self.tool("mousemove", self.x + 20, self.y + 20)
            self.key("1")
            self.wait_until(lambda: self.layout()["scale"] == 1, "one to one")
        at = self.layout()
        assert at["scale"] == 1, at
        seen = self.look(name)
        x, y = round(at["x"]), round(at["y"])
        assert x >= 0 and y >= 0, at
        return seen[y : y + height, x : x + width]

    def look_until(self, test, look=None):
        """What is seen as soon as it passes the test; else what is seen at the end.

        look: takes the screenshot, without it the whole window. A display may take its
        time to follow.
        """
        end = time.monotonic() + WAIT_S
        while True:
            seen = (look or self.look)()
            if test(seen) or time.monotonic() > end:
                return seen

    def sees(self, want, name="shot"):
        """Does the window show exactly this, at last?"""
        height, width = want.shape[:2]
        seen = self.look_until(
            lambda seen: numpy.array_equal(seen, want),
            lambda: self.look_at_picture(width, height, name),
        )
        return numpy.array_equal(seen, want)

    def copied(self):
        """The command line that the window copies, as words.

        It is that of all that was done before: input is worked off in its order.
        """
        self.key("ctrl+c")
        self.wait_text("said", "copied")
        return shlex.split(self.printed().strip().splitlines()[-1])

    # ---- the end ---------------------------------------------------------------------

    def quit(self, code=0):
        self.move(20, 20)
        self.key("ctrl+q")
        assert self.process.wait(timeout=WAIT_S) == code, self.printed()

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.out.close()


@pytest.fixture
def view(binary, display, tmp_path):
    """Opens windows; those that are left over are ended."""
    windows = []

    def open_window(*arguments, on=display):
        windows.append(Window(binary, on, tmp_path, *arguments))
        return windows[-1]

    yield open_window
    for window in windows:
        window.close()


# ---- files ---------------------------------------------------------------------------


def read_pixels(path, kind):
    """Straight from the file: an ImageBuf remembers files that were read before."""
    file = oiio.ImageInput.open(str(path))
    assert file, oiio.geterror()
    pixels = file.read_image(kind)
    file.close()
    return pixels.reshape(pixels.shape[0], pixels.shape[1], -1)


def read_png(path):
    pixels = read_pixels(path, oiio.UINT8)
    return pixels[..., :3] if pixels.shape[-1] > 2 else pixels[..., [0, 0, 0]]


def read_exr(path):
    return read_pixels(path, oiio.FLOAT)


WIDTH, HEIGHT, NEAR, FAR = 320, 200, 3.0, 12.0
DISC, WALL = (160, 100), (40, 40)  # a px of either

CAMERA = {
    "rackfocus:focusDistance": FAR,
    "rackfocus:fStop": 2.0,
    "rackfocus:focalLength": 50.0,
    "rackfocus:sensorWidth": 36.0,
    "rackfocus:unitScale": 10.0,
}


@pytest.fixture
def passes(tmp_path):
    """Makes an EXR of a near disc before a far striped wall; is_soft: its depth is
    averaged over three pixels, as a pixel filter does."""

    def make(name="passes.exr", shift=0.0, attributes=None, is_soft=False):
        y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(numpy.float32)
        near = (x - DISC[0] + 4 * shift) ** 2 + (y - DISC[1]) ** 2 < 45**2
        stripes = (((x + shift) // 7 + y // 11) % 2).astype(numpy.float32)
        channels = {
            "R": numpy.where(near, 0.8, 0.2 + 0.5 * stripes).astype(numpy.float32),
            "G": numpy.where(near, 0.4 * y / HEIGHT, 0.6 * stripes),
            "B": numpy.where(near, 0.1, 0.9 - 0.5 * stripes).astype(numpy.float32),
            "Z": numpy.where(near, NEAR, FAR).astype(numpy.float32),
        }
        if is_soft:
            sides = [numpy.roll(channels["Z"], by, 1) for by in (-1, 0, 1)]
            channels["Z"] = numpy.mean(sides, axis=0)
        channels = {k: v.astype(numpy.float32) for k, v in channels.items()}
        return plainexr.write(
            tmp_path / name, channels, {**CAMERA, **(attributes or {})}
        )

    return make


@pytest.fixture
def command_picture(rackfocus, tmp_path):
    """What the command line makes, as the screen would show it."""

    def make(path, *options):
        out = tmp_path / "command.png"
        rackfocus("filter", path, "-o", out, *options)
        return read_png(out)

    return make
