# SPDX-License-Identifier: Apache-2.0
"""The window on Windows x64 under wine: it opens from the command, shows what the command
of Linux makes, follows the mouse and saves."""

import importlib.util
import json
import re
import subprocess

import pytest
from systems import BUILD, LIBRARIES, ROOT, WINE, WINESERVER, run

# The window under Xvfb, with someone who clicks and looks.
HERE = ROOT / "tests" / "view" / "conftest.py"
spec = importlib.util.spec_from_file_location("view_window", HERE)
view_window = importlib.util.module_from_spec(spec)
spec.loader.exec_module(view_window)

PASSES = ROOT / "tests" / "quality" / "references" / "posts_pinhole.exr"
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
# What Windows has of the window's needs.
SYSTEM = {
    f"{name}.dll" for name in "gdi32 imm32 ole32 oleaut32 opengl32 shell32".split()
}
SYSTEM |= {f"{name}.dll" for name in "setupapi user32 version winmm ws2_32".split()}


@pytest.fixture
def window(windows, wine_environment, tmp_path):
    """Opens the window through the command of Windows."""
    # What was started without a display makes no windows: its services begin anew.
    subprocess.run([WINESERVER, "-k"], env=wine_environment, check=False)
    program = tmp_path / "rackfocus"
    words = ["unset SDL_VIDEODRIVER"]  # x11 means nothing to Windows
    words += [
        f"export {k}='{wine_environment[k]}'" for k in ("WINEPREFIX", "WINEDEBUG")
    ]
    words.append(f"exec {WINE} '{windows / 'cli' / 'rackfocus.exe'}' \"$@\"")
    program.write_text("#!/bin/sh\n" + "\n".join(words) + "\n")
    program.chmod(0o755)
    display = view_window.Display()
    opened = []

    def open_window(*arguments):
        opened.append(view_window.Window(program, display, tmp_path, *arguments))
        return opened[-1]

    yield open_window
    for one in opened:
        one.close()
    subprocess.run([WINESERVER, "-k"], env=wine_environment, check=False)
    display.close()


def test_needs_only_windows(windows):
    said = run("objdump", "-p", windows / "view" / "rackfocus-view.exe")
    found = {name.lower() for name in re.findall(r"DLL Name: (\S+)", said)}
    assert "opengl32.dll" in found
    assert found <= LIBRARIES | SYSTEM


def test_shows_follows_and_saves(window, tmp_path):
    """The best picture is the command's; a click focuses; Ctrl+S saves these bits."""
    linux = BUILD / "cli" / "rackfocus"
    shown = window(PASSES, "--font", FONT, "-o", "saved.exr")
    shown.wait_open()
    run(linux, "filter", "-q", PASSES, "-o", tmp_path / "want.png")
    assert shown.sees(view_window.read_png(tmp_path / "want.png"))
    shown.click(*shown.on_picture(100, 60))
    focus = shown.wait_best()["focus"]
    assert focus > 1.5  # 1 in the file
    shown.key("ctrl+s")
    shown.wait_text("said", "saved.exr")
    lens = ("--focus-distance", repr(focus))
    run(linux, "filter", "-q", PASSES, "-o", tmp_path / "want.exr", *lens)
    said = run(
        linux, "compare", "--json", tmp_path / "saved.exr", tmp_path / "want.exr"
    )
    assert json.loads(said)["psnr"] is None or json.loads(said)["psnr"] > 60, said
    shown.quit()
