# SPDX-License-Identifier: Apache-2.0
"""The command lines of docs/denoise.md do what stands beside them, on small pictures."""

import re
import shlex

import numpy as np
from conftest import REFERENCES, ROOT, read, write


def lay_out(folder):
    """The files that the page names: posts at half their size, twice as large ones as
    they are.
    """
    rng = np.random.default_rng(4)

    def half(name):
        pixels, names = read(REFERENCES / f"{name}.exr")
        pixels = pixels[60:140, 100:228]
        return pixels, pixels[::2, ::2], names

    for name, source in [
        ("passes", "posts_pinhole"),
        *((f"view_{i}", f"posts_view0{2 * i}") for i in range(4)),
    ]:
        large, small, names = half(source)
        header = REFERENCES / f"{source}.exr"
        write(folder / f"{name}.exr", small, names, header)
        write(folder / f"twice_as_large_{name}.exr", large, names, header)
    (folder / "twice_as_large_passes.exr").unlink()
    colour = half("posts_dof64")[1]
    for name in ("own", "own_a", "own_b"):
        grain = rng.normal(1, 0.02, colour.shape)
        write(folder / f"{name}.exr", colour * grain, "RGB")


def test_every_command_line_works(clean, tmp_path, monkeypatch):
    lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/denoise.md").read_text()
    lines = re.findall(r"^    rackfocus (.*)$", page, flags=re.M)
    assert len(lines) >= 6
    for line in lines:
        words = [
            path
            for word in shlex.split(line)
            for path in (
                sorted(map(str, tmp_path.glob(word))) if "*" in word else [word]
            )
        ]
        done = clean(*words, "--denoise-quality", "fast")
        assert done.stderr == "", line
        assert re.match(r"\S+: focus 1, lens radius 0.03125, radii -\d", done.stdout)
        for word in words:
            if word in ("out.exr", "error.exr"):
                pixels = read(tmp_path / word)[0]
                assert np.isfinite(pixels).all() and pixels.std() > 1e-4, line
                (tmp_path / word).unlink()
        if "--denoise" in words and "*" in line:
            assert re.search(r"grain: \d\.\d of 4 views share a pixel$", done.stdout)
