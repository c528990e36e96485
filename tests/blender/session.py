# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender with a window under Xvfb, for which someone presses keys and looks."""

import json
import os
import shlex

import OpenImageIO as oiio
from conftest import INSIDE, call

# The script inside asks by a line in a pipe: for what xdotool should do, and for
# screenshots. It is answered when the file of that name is gone.
# Where a window goes while import looks, import may write no picture and exit with 0:
# a screenshot counts when its file ends as a PNG does.
SERVED = """
exec 3<>{out}/asked
(while read -r name <&3; do
    case $name in
    hands) until xdotool $(cat {out}/hands); do sleep 0.02; done ;;
    *)
        until import -window root -quality 10 png:{out}/part &&
            tail -c 12 {out}/part | grep -aq IEND; do sleep 0.02; done
        mv {out}/part {out}/${{name%.shot}}.png
        ;;
    esac
    rm {out}/$name
done) &
served=$!
trap 'kill $served' EXIT
{blender} 3<&-
"""


def run(blender, script, dist, out, size):
    """Runs a script of inside/ with a window; returns what it found, {what: value}.

    out: folder of its files; size: of the display in px.
    """
    out.mkdir(exist_ok=True)
    found = out / "found.json"
    found.unlink(missing_ok=True)
    (out / "asked").unlink(missing_ok=True)
    os.mkfifo(out / "asked")
    arguments = map(str, ("-P", INSIDE / script, "--", dist, out))
    geometry = ("-p", "0", "0", *map(str, size))
    command = blender.command("--factory-startup", *geometry, *arguments)
    served = SERVED.format(out=out, blender=shlex.join(command))
    screen = f"-screen 0 {size[0]}x{size[1]}x24"
    about = {**blender.environment(), "LIBGL_ALWAYS_SOFTWARE": "1"}
    log = call("xvfb-run", "-a", "-s", screen, "sh", "-c", served, env=about)
    (out / f"{script}.log").write_text(log)
    assert "Traceback" not in log, log[-3000:]
    found = json.loads(found.read_text())
    assert found.get("done"), found
    return found


def shot(folder, name):
    """(height, width, 3) of a screenshot."""
    image = oiio.ImageBuf(str(folder / f"{name}.png"))
    assert image.read(force=True), image.geterror()
    return image.get_pixels(oiio.FLOAT)[..., :3]
