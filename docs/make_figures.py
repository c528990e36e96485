# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of the README, of views.md and of methods.md: `docs/make_figures.py` with
RACKFOCUS set.

posts.png: the pinhole render, Rack Focus from it, Cycles' own depth of field with the
same number of samples, Cycles' with 6144. views.png: one view, 8 views, Cycles with
6144 samples, of a part of posts, magnified twice.
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


def rackfocus(inputs, out, *options):
    """The panel of what the filter makes of the inputs."""
    command = [os.environ["RACKFOCUS"], "filter", *inputs, "-o", out, "-q", *options]
    subprocess.run(command, check=True)
    return panel(out)


def write(picture, name):
    """Write a picture of display values to docs/images."""
    height, width, _ = picture.shape
    buffer = oiio.ImageBuf(oiio.ImageSpec(width, height, 3, oiio.UINT8))
    buffer.set_pixels(
        oiio.ROI(0, width, 0, height, 0, 1, 0, 3),
        np.ascontiguousarray(picture, dtype=np.float32),
    )
    buffer.write(str(ROOT / "docs" / "images" / name))


def make_posts(out):
    """Write posts.png."""
    pinhole = REFERENCES / "posts_pinhole.exr"
    panels = [
        panel(pinhole),
        rackfocus([pinhole], out),
        panel(REFERENCES / "posts_dof64.exr"),
        panel(REFERENCES / "posts_reference.exr"),
    ]
    write(np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])]), "posts.png")


def make_views(out):
    """Write views.png: a part of 150 x 90 pixels."""
    one = [REFERENCES / "posts_pinhole.exr"]
    eight = sorted(REFERENCES.glob("posts_view0?.exr"))
    panels = [
        rackfocus(one, out, "--sub-apertures", "4"),
        rackfocus(eight, out, "--sub-apertures", "4"),
        panel(REFERENCES / "posts_reference.exr"),
    ]
    cut = np.hstack([p[150:240, 90:240] for p in panels])
    write(cut.repeat(2, 0).repeat(2, 1), "views.png")


def make_stages(out):
    """Write methods_stages.png: the picture and three stages of the previews."""
    pinhole = REFERENCES / "posts_pinhole.exr"
    stages = [
        ("mipmap", "--stage", "levels"),
        ("box", "--blend", "region", "--leak-control", "hint", "--stage", "alpha"),
        ("box", "--blend", "slices", "--slices", "4", "--stage", "slices"),
    ]
    panels = [  # a file each: pictures of one name are read once
        rackfocus([pinhole], out.with_stem(words[-1]), "--method", *words)
        for words in stages
    ]
    panels.insert(0, panel(pinhole))
    write(
        np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])]), "methods_stages.png"
    )


def main():
    """Write the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.exr"
        make_posts(out)
        make_views(out)
        make_stages(out)


if __name__ == "__main__":
    main()
