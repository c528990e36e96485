# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of the README: `docs/make_figures.py` with RACKFOCUS set.

Four panels of one scene: the pinhole render, Rack Focus from it, Cycles' own depth of
field with the same number of samples, Cycles' with 6144.
"""

import os
import pathlib
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parent.parent
REFERENCES = ROOT / "tests" / "quality" / "references"


def panel(path):
    """Display values of a picture, H x W x 3, sRGB-like gamma."""
    pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[..., :3]
    return np.clip(pixels, 0, 1) ** (1 / 2.2)


def main():
    """Write docs/images/posts.png."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.exr"
        pinhole = REFERENCES / "posts_pinhole.exr"
        subprocess.run(
            [os.environ["RACKFOCUS"], "filter", pinhole, "-o", out, "-q"], check=True
        )
        paths = [
            pinhole,
            out,
            REFERENCES / "posts_dof64.exr",
            REFERENCES / "posts_reference.exr",
        ]
        panels = [panel(path) for path in paths]
    picture = np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])])
    height, width, _ = picture.shape
    buffer = oiio.ImageBuf(oiio.ImageSpec(width, height, 3, oiio.UINT8))
    buffer.set_pixels(
        oiio.ROI(0, width, 0, height, 0, 1, 0, 3),
        np.ascontiguousarray(picture, dtype=np.float32),
    )
    buffer.write(str(ROOT / "docs" / "images" / "posts.png"))


if __name__ == "__main__":
    main()
