# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of a script of checks inside Blender, and the pictures that they leave."""

import json
import re

import OpenImageIO as oiio
from conftest import INSIDE


def names_of(script):
    """The checks that a script of inside/ declares, in its order."""
    return re.findall(r"^@check\ndef (\w+)", (INSIDE / script).read_text(), re.M)


class Checked:
    """A script of checks, run once in each Blender.

    script: in inside/; results: the file of the output folder that it writes;
    has_display: does it need one?
    """

    def __init__(self, script, results, has_display=False):
        self.script, self.results, self.has_display = script, results, has_display
        self.runs = {}  # version: ({check: "" or problem}, what was printed)

    def run(self, blender, dist, **more):
        """({check: "" or problem}, what was printed) of the run in a Blender.

        more: variables of its environment.
        """
        if blender.version not in self.runs:
            log = ""
            try:
                about = self.script, dist, blender.out
                log = blender.run(*about, has_display=self.has_display, **more)
            except Exception as error:  # what was done before the end still counts
                log = str(error)
            path = blender.out / self.results
            found = json.loads(path.read_text()) if path.exists() else {}
            self.runs[blender.version] = found, log
        return self.runs[blender.version]

    def expect(self, blender, dist, name, **more):
        """A check was made and found nothing wrong."""
        found, log = self.run(blender, dist, **more)
        assert name in found, f"Blender ended before this check:\n{log[-3000:]}"
        assert not found[name], found[name]


def read_rgba(path):
    """(height, width, 4) of the picture in an EXR."""
    image = oiio.ImageBuf(str(path))
    pixels = image.get_pixels(oiio.FLOAT)
    names = [name.split(".")[-1] for name in image.spec().channelnames]
    return pixels[..., [names.index(c) for c in "RGBA"]]
