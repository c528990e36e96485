# SPDX-License-Identifier: Apache-2.0
"""Stores a window rendered at another focus as a reference.

    collect_refocused.py WORKDIR SCENE FOCUS X Y OUTDIR

WORKDIR/SCENE_reference_seed1.exr is what `cycles_scenes.py --focus FOCUS --window X Y
WIDTH HEIGHT` rendered; OUTDIR/SCENE_focus_FOCUS.exr receives it as half floats, whose
data window says where in the picture it lies.
"""

import json
import sys
from pathlib import Path

import OpenImageIO
from collect_references import read_exr


def main():
    work, scene, focus, x, y, out = sys.argv[1:]
    facts = json.loads((Path(work) / f"{scene}_reference.json").read_text())["camera"]
    assert facts["focus"] == float(focus)
    pixels = read_exr(Path(work) / f"{scene}_reference_seed1.exr")[..., :3]
    height, width = pixels.shape[:2]
    spec = OpenImageIO.ImageSpec(width, height, 3, OpenImageIO.HALF)
    spec.x, spec.y = int(x), int(y)
    spec.full_width, spec.full_height = facts["width"], facts["height"]
    spec.attribute("compression", "piz")
    image = OpenImageIO.ImageBuf(spec)
    image.set_pixels(spec.roi, pixels.copy())
    path = Path(out) / f"{scene}_focus_{focus}.exr"
    assert image.write(str(path)), image.geterror()


if __name__ == "__main__":
    main()
