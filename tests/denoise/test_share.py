# SPDX-License-Identifier: Apache-2.0
"""Views share what they see of the same points before their grain goes out."""

import os
import re
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio
import pytest

SIZE = (96, 160)
PLANE = 5.0  # distance in focus, where views see every point at the same pixel
VEC2 = oiio.TypeDesc(oiio.FLOAT, oiio.VEC2)
PLACES = ((-0.02, -0.02), (0.02, -0.02), (-0.02, 0.02), (0.02, 0.02))
LENS = ("--focus-distance", PLANE, "--lens-radius", 0.04, "--focal-length-px", 160)


def write_view(path, place, colour, depth, albedo=None):
    """A view of a lens's point, with noise-free normals where it has an albedo."""
    planes = [colour, np.broadcast_to(depth, SIZE)[..., None]]
    names = [*"RGBZ"]
    if albedo is not None:
        planes += [albedo, np.broadcast_to([0.0, 0.0, 1.0], (*SIZE, 3))]
        names += [f"Denoising Albedo.{c}" for c in "RGB"]
        names += [f"Denoising Normal.{c}" for c in "XYZ"]
    spec = oiio.ImageSpec(SIZE[1], SIZE[0], len(names), "float")
    spec.channelnames = tuple(names)
    spec.attribute("rackfocus:lensOffset", VEC2, place)
    spec.attribute("rackfocus:shearDistance", PLANE)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(np.ascontiguousarray(np.dstack(planes), np.float32))
    out.close()
    return path


@pytest.fixture
def merged(clean, tmp_path):
    """Merges views of (colour, depth, albedo); the picture and how many shared."""

    def run(parts):
        views = [
            write_view(tmp_path / f"v{i}.exr", place, *part)
            for i, (place, part) in enumerate(zip(PLACES, parts, strict=True))
        ]
        out = tmp_path / "out.exr"
        words = ["filter", *views, "-o", out, "--type", "float", "--denoise", *LENS]
        said = clean(*words).stdout
        picture = oiio.ImageInput.open(str(out)).read_image(0, 0, 0, 3, "float")
        found = re.search(r"grain: ([\d.]+) of 4 views share a pixel", said)
        return np.array(picture).reshape(*SIZE, 3), float(found[1])

    return run


def noise(seed, sigma):
    return np.random.default_rng(seed).normal(0, sigma, (*SIZE, 3))


def test_what_looks_the_same_is_shared(merged):
    """All of four views show it; a mirror's half looks different from every place."""
    half = np.arange(SIZE[1])[None, :, None] < SIZE[1] // 2
    same = [(0.5 + noise(i, 0.1), PLANE) for i in range(4)]
    picture, shared = merged(same)
    assert shared > 3.3 and abs(picture.mean() - 0.5) < 0.01
    mirror = [
        (np.where(half, 0.5, 0.2 + 0.2 * i) + noise(i, 0.02), PLANE) for i in range(4)
    ]
    picture, shared = merged(mirror)
    assert 2.2 < shared < 2.6
    assert abs(picture[:, SIZE[1] // 2 + 8 :].mean() - 0.5) < 0.01


def test_what_is_no_grain_comes_back(merged):
    """A texture that looks like grain, but is the same in all views."""
    texture = 0.5 + noise(1, 0.1)
    picture, _ = merged([(texture, PLANE)] * 4)
    off = np.sqrt(np.mean((picture - texture)[4:-4, 4:-4] ** 2))
    assert off < 0.05, off  # of 0.1 where all of it is taken for grain


def test_what_the_denoiser_left_comes_from_all_views(merged):
    # Small things that no albedo shows, in the grain of a path tracer, which is skewed.
    # Denoised by itself each view loses them: 0.034.
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    dots = np.where((x % 16 < 3) & (y % 16 < 3), 0.5, 0.2)[..., None]
    grain = [np.random.default_rng(i).gamma(4, 0.25, (*SIZE, 1)) for i in range(4)]
    grey = np.full((*SIZE, 3), 0.5)
    views = [(np.repeat(dots * each, 3, 2), PLANE, grey) for each in grain]
    picture, shared = merged(views)
    assert shared > 3
    off = np.sqrt(np.mean((picture - dots)[8:-8, 8:-8] ** 2))
    assert off < 0.028, off


def test_few_views_that_agree_count_little(merged):
    # Two and two look alike; what two of four know has grain, 0.017 where it counts as all.
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    waves = np.repeat(0.5 + 0.1 * np.sin(1.6 * x + 0.4 * y)[..., None], 3, 2)
    grey = np.full((*SIZE, 3), 0.5)
    views = [(waves + 0.15 * (i > 1) + noise(i, 0.06), PLANE, grey) for i in range(4)]
    picture, shared = merged(views)
    assert shared < 2.5
    off = np.sqrt(np.mean((picture - waves - 0.075)[8:-8, 8:-8] ** 2))
    assert off < 0.0162, off


def test_grain_of_the_albedo_is_no_texture(merged):
    grey = np.full((*SIZE, 3), 0.5)
    views = [(grey + noise(i, 0.1), PLANE, grey + noise(i + 9, 0.2)) for i in range(4)]
    picture, _ = merged(views)
    off = np.sqrt(np.mean((picture - 0.5)[8:-8, 8:-8] ** 2))
    assert off < 0.009, off  # 0.014 by albedos that are shared and not cleaned


def test_what_hides_it_is_not_shared(merged):
    """The same grey nearer by, in two views of four: these two show the same."""
    depths = [PLANE, PLANE, PLANE / 2, PLANE / 2]
    _, shared = merged([(np.full((*SIZE, 3), 0.5), d) for d in depths])
    assert 1.8 < shared <= 2


def test_points_before_the_plane_are_found_where_they_moved_to(merged):
    """A texture at half the distance, as each view shows it: 3.2 px apart."""
    x, y = np.meshgrid(np.arange(SIZE[1]), np.arange(SIZE[0]))
    parts = []
    for u, v in PLACES:
        shift = 160 * (1 / PLANE - 2 / PLANE)
        at_x, at_y = x - u * shift, y + v * shift
        tone = 0.5 + 0.4 * np.sin(at_x / 4) * np.sin(at_y / 5)
        parts.append((np.repeat(tone[..., None], 3, -1), PLANE / 2))
    _, shared = merged(parts)
    assert shared > 3.8


def test_lights_keep_their_pixels(merged):
    """A band of lamps, the same in all views: nobody shares it."""
    lamp = np.full((*SIZE, 3), 0.2)
    lamp[40:56, ::4] = 50
    _, near = merged([(lamp, PLANE)] * 4)
    _, far = merged([(np.full((*SIZE, 3), 0.2), PLANE)] * 4)
    assert far == 4 and near < far


PYTHON = """
import sys
import warnings
import numpy as np
import rackfocus
folder, library = sys.argv[1:]
found = np.load(f"{folder}/views.npz")
colours, depths = found["colours"], found["depths"]
albedo, places = found["albedo"], [tuple(place) for place in found["places"]]
height, width = depths[0].shape
LENS = {"focus_distance": 5, "lens_radius": 0.04, "focal_length_px": 160}
made = rackfocus.Filter(width, height, **LENS)
views = [(c, d, place, 5) for c, d, place in zip(colours, depths, places)]
outs = [np.empty_like(colour) for colour in colours]
told = []
shared = made.denoise_views(views, outs, progress=told.append, library=library)
assert told == [0.25, 0.5, 0.75, 1], told
alone = [np.empty_like(colour) for colour in colours]
for view, out in zip(views, alone):
    made.denoise_views([view], [out], library=library)
picture = np.empty((height, width, 3), "f")
bare = [(np.ascontiguousarray(c[..., :3]), d, place, 5) for c, d, place, _ in views]
clean = [np.empty_like(view[0]) for view in bare]
made.denoise_views(bare, clean, library=library)
merger = rackfocus.Filter(width, height, method="views", **LENS)
merger.merge_denoised(bare, clean, picture)
np.savez(
    f"{folder}/made.npz", outs=outs, alone=alone, shared=shared, picture=picture
)
guided = [np.empty_like(colour) for colour in colours]
made.denoise_views(views, guided, [(albedo, None)] * 4, library=library)
assert not np.array_equal(guided, outs)
assert np.array_equal(np.stack(guided)[..., 3], colours[..., 3])
dark, WHITE = {**LENS, "white": 1 / 128}, np.float32(1 / 128)
low = [(c * WHITE, d, place, 5) for c, d, place, _ in bare]
low_clean = [np.empty_like(view[0]) for view in low]
assert made.denoise_views(bare, clean, library=library) == rackfocus.Filter(
    width, height, **dark
).denoise_views(low, low_clean, library=library)
assert np.array_equal(low_clean, np.multiply(clean, WHITE))
low_picture = np.empty_like(picture)
merger = rackfocus.Filter(width, height, method="views", **dark)
merger.merge_denoised(low, low_clean, low_picture)
assert np.array_equal(low_picture, picture * WHITE)
in_place = [colour.copy() for colour in colours]
again = [(c, d, place, 5) for c, d, place in zip(in_place, depths, places)]
made.denoise_views(again, in_place, library=library)
assert np.array_equal(in_place, outs)


def fails(kind, text, *arguments, **about):
    try:
        made.denoise_views(*arguments, **{"library": library, **about})
    except kind as problem:
        assert text in str(problem), problem
    else:
        raise AssertionError(text)


fails(ValueError, "for each view", views, outs[1:])
fails(ValueError, "for each view", views, outs, [(None, None)])
fails(ValueError, "out of view 1", views, [outs[0], outs[1][1:], *outs[2:]])
fails(ValueError, "albedo of view 0", views, outs, [(albedo[1:], None)] * 4)
fails(TypeError, "(albedo, normal)", views, outs, [albedo] * 4)
fails(ValueError, "threads", views, outs, threads=-1)
fails(ValueError, "quality", views, outs, quality="medium")
facing = np.broadcast_to(np.float32([0, 0, 1]), albedo.shape).copy()
by_quality = []
for quality in ("high", "balanced", "fast"):
    other = [np.empty_like(colour) for colour in colours]
    guides = [(albedo, facing)] * 4
    made.denoise_views(views, other, guides, library=library, quality=quality)
    by_quality.append(other)
for a, b in ((0, 1), (1, 2)):
    assert 0 < np.abs(np.subtract(by_quality[a], by_quality[b])).mean() < 0.01
small = [(c[1:], d[1:], place, 5) for c, d, place in zip(colours, depths, places)]
fails(rackfocus.Error, "160", small, [out[1:] for out in outs])
fails(rackfocus.CancelledError, "cancelled", views, outs, None, lambda _: False)
fails(rackfocus.Error, "Open Image Denoise", views, outs, library="/nowhere")
wide = rackfocus.Filter(width, height, **{**LENS, "lens_radius": 0.3})
far = np.full_like(depths[0], 20)
for other, n in ((0, 1), (1, 0)):
    two = [(colours[0], far, (-0.2, 0), 5), (colours[other], far, (0.2, 0), 5)]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        wide.denoise_views(two, outs[:2], library=library)
    assert sum("a seed of its own" in str(w.message) for w in caught) == n
"""


def test_python_shares_as_the_command_does(merged, oidn, package, tmp_path):
    """As many views share a pixel, and the grain goes out of each of them."""
    colours = np.stack([0.5 + noise(i, 0.1) for i in range(4)]).astype(np.float32)
    by_command, shared = merged([(colour, PLANE) for colour in colours])
    alpha = np.full((4, *SIZE, 1), 0.75, np.float32)
    np.savez(
        tmp_path / "views.npz",
        colours=np.concatenate([colours, alpha], -1),
        depths=np.full((4, *SIZE), PLANE, np.float32),
        albedo=np.full((*SIZE, 3), 0.5, np.float32),
        places=PLACES,
    )
    environment = {k: v for k, v in os.environ.items() if k != "RACKFOCUS_OIDN"}
    environment["PYTHONPATH"] = str(package)
    command = [sys.executable, "-c", PYTHON, tmp_path, oidn]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    made = np.load(tmp_path / "made.npz")
    assert made["shared"] == pytest.approx(shared, abs=0.05)
    left, alone = (
        np.sqrt(np.mean((made[name][..., :3] - 0.5) ** 2)) for name in ("outs", "alone")
    )
    assert left < 0.01 and left < 0.95 * alone, (left, alone)  # of 0.1
    assert np.abs(made["picture"] - by_command).max() < 1e-4
