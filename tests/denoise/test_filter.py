# SPDX-License-Identifier: Apache-2.0
"""filter --denoise: grain out before the lens, and of several views after it as well."""

import os
import subprocess

import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import BUILD, REFERENCES, read, write

POSTS = REFERENCES / "posts_pinhole.exr"


def views(scene):
    return sorted(REFERENCES.glob(f"{scene}_view*.exr"))


def grainy(path, tmp_path, seed=1):
    """A file with noise of 0.2 on its colours."""
    pixels, names = read(path)
    colours = [names.index(c) for c in "RGB"]
    noise = np.random.default_rng(seed).normal(0, 0.2, (*pixels.shape[:2], 3))
    pixels[..., colours] = np.maximum(pixels[..., colours] + noise, 0)
    return write(tmp_path / "grainy.exr", pixels, names, path)


def test_one_view_loses_its_grain(clean, score, tmp_path):
    noisy = grainy(POSTS, tmp_path)
    out = tmp_path / "out.exr"
    scores = []
    for options in ([], ["--denoise"]):
        clean("filter", noisy, "-o", out, "--type", "float", *options)
        scores.append(score(out, "posts"))
    assert scores[1] > scores[0] + 2, scores


def test_views_gain_on_the_real_scene(clean, score, tmp_path):
    out = tmp_path / "out.exr"
    for scene, least in (("posts", 38.4), ("portrait", 39.75)):
        clean("filter", *views(scene), "-o", out, "--type", "float", "--denoise")
        assert score(out, scene) > least


def test_quality_is_that_of_the_denoisers_filters(clean, score, tmp_path):
    """High is the default; fast is another picture, and not much worse."""
    noisy, out = grainy(POSTS, tmp_path), tmp_path / "out.exr"
    made, scores = {}, {}
    for quality in ("", "high", "fast"):
        more = ["--denoise-quality", quality] if quality else []
        clean("filter", noisy, "-o", out, "--type", "float", "--denoise", *more)
        made[quality], scores[quality] = read(out)[0], score(out, "posts")
    assert np.array_equal(made[""], made["high"])
    assert not np.array_equal(made["high"], made["fast"])
    assert min(scores.values()) > max(scores.values()) - 1, scores
    done = clean("filter", noisy, "-o", out, "--denoise-quality", "fast", code=2)
    assert "--denoise-quality goes with --denoise" in done.stderr


def test_alpha_and_grey_stay(clean, tmp_path):
    pixels, names = read(POSTS)
    alpha = np.linspace(0, 1, pixels.shape[1])[None, :, None]
    alpha = np.broadcast_to(alpha, (*pixels.shape[:2], 1))
    rgb = pixels[..., [names.index(c) for c in "RGB"]] * alpha
    depth = np.full((*pixels.shape[:2], 1), 1.0)  # in focus: nothing moves
    film = np.concatenate([rgb, alpha, depth], -1)
    source = write(tmp_path / "film.exr", film, "RGBAZ", POSTS)
    clean("filter", source, "-o", tmp_path / "out.exr", "--type", "float", "--denoise")
    got, got_names = read(tmp_path / "out.exr")
    assert np.allclose(got[..., got_names.index("A")], alpha[..., 0], atol=1e-6)
    grey = np.concatenate([rgb[..., :1], depth], -1)
    source = write(tmp_path / "grey.exr", grey, "YZ", POSTS)
    clean("filter", source, "-o", tmp_path / "out.exr", "--type", "float", "--denoise")
    assert read(tmp_path / "out.exr")[1] == ("Y",)


def test_guides_beside_the_colour_are_used(clean, tmp_path):
    """A texture that the grain hides comes back where the albedo shows it."""
    height, width = 96, 160
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    albedo = np.repeat((0.25 + 0.5 * ((x // 2 + y // 2) % 2))[..., None], 3, -1)
    noise = np.random.default_rng(2).normal(0, 0.3, albedo.shape)
    depth = np.full((height, width, 1), 10.0)
    normal = np.broadcast_to([0.0, 0.0, 1.0], albedo.shape)
    errors = {}
    for kind in ("none", "blender", "arnold"):
        parts, names = [np.maximum(albedo + noise, 0), depth], ["R", "G", "B", "Z"]
        if kind == "blender":
            names += [f"ViewLayer.Denoising Albedo.{c}" for c in "RGB"]
            names += [f"ViewLayer.Denoising Normal.{c}" for c in "XYZ"]
        elif kind == "arnold":
            names += [f"denoise_albedo.{c}" for c in "RGB"]
            names += [f"N.{c}" for c in "XYZ"]
        if kind != "none":
            parts += [albedo, normal]
        source = write(tmp_path / "in.exr", np.concatenate(parts, -1), names)
        options = ["--focus-distance", 10, "--f-stop", 2, "--denoise"]
        clean("filter", source, "-o", tmp_path / "out.exr", *options)
        got = read(tmp_path / "out.exr")[0][..., :3]
        errors[kind] = float(np.sqrt(np.mean((got - albedo) ** 2)))
    assert errors["blender"] < 0.6 * errors["none"], errors
    assert errors["arnold"] < 0.6 * errors["none"], errors


def smeared(v):
    """What a pixel filter makes of it that spreads samples over their neighbours."""
    for axis in (0, 1):
        v = (np.roll(v, 1, axis) + 4 * v + np.roll(v, -1, axis)) / 6
    return v


def write_with(path, pixels, names, facts):
    """Writes channels of floats with some attributes, of two numbers or one."""
    spec = oiio.ImageSpec(*pixels.shape[1::-1], len(names), "float")
    spec.channelnames = tuple(names)
    for name, value in facts.items():
        if isinstance(value, tuple):
            spec.attribute(name, oiio.TypeDesc(oiio.FLOAT, oiio.VEC2), value)
        else:
            spec.attribute(name, value)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(np.ascontiguousarray(pixels, np.float32)) and out.close()
    return path


def make_smeared(tmp_path, spread, height=99, width=160):
    """A textured wall, in focus, with much grain: without it, and the file."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    albedo = np.repeat((0.3 + 0.4 * ((x // 32 + y // 32) % 2))[..., None], 3, -1)
    noise = np.random.default_rng(2).normal(0, 0.12, albedo.shape)
    noisy = np.maximum(spread(albedo + noise), 0)
    planes = [noisy, np.full((height, width, 1), 10.0), spread(albedo)]
    planes.append(np.broadcast_to([0.0, 0.0, 1.0], albedo.shape))
    names = [*"RGBZ", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ")]
    path = tmp_path / "noisy.exr"
    return spread(albedo), write(path, np.concatenate(planes, -1), names)


def test_grain_that_a_pixel_filter_smeared(clean, tmp_path):
    """The denoiser would take it for texture; nearly all of it goes."""
    truth, path = make_smeared(tmp_path, smeared)
    out = tmp_path / "out.exr"
    lens = ["--focus-distance", "10", "--lens-radius", "0", "--focal-length-px", "100"]
    errors = []
    for options in ([], ["--denoise"]):
        clean("filter", path, "-o", out, "--type", "float", *lens, *options)
        errors.append(
            np.square(read(out)[0][4:-4, 4:-4, :3] - truth[4:-4, 4:-4]).mean()
        )
    assert errors[1] < 0.1 * errors[0], errors
    clean("finish", path, "-o", out, "--type", "float")
    own = np.square(read(out)[0][4:-4, 4:-4, :3] - truth[4:-4, 4:-4]).mean()
    assert own < 0.1 * errors[0], (own, errors)


def test_views_of_one_seed_are_told(clean, tmp_path):
    """A wall that two views see 8 px apart, with grain that stays or differs."""
    height, width = 80, 120
    x = np.arange(width)
    normal, albedo = np.zeros((height, width, 3)), np.full((height, width, 3), 0.5)
    names = [*"RGBZ", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ")]
    lens = ["--focus-distance", "10", "--lens-radius", "1", "--focal-length-px", "80"]
    rng = np.random.default_rng(5)
    grain = rng.normal(0, 0.1, albedo.shape)

    def view(i, noise):
        path = tmp_path / f"view{i}.exr"
        wall = 0.5 + 0.2 * np.sin((x - 8 * i) / 3)[None, :, None] + noise
        pixels = np.concatenate(
            [wall, np.full((height, width, 1), 20.0), albedo, normal], -1
        )
        facts = {
            "rackfocus:lensOffset": (2.0 * i - 1, 0.0),
            "rackfocus:shearDistance": 10.0,
        }
        return write_with(path, pixels, names, facts)

    def said(*others):
        paths = [view(i, noise) for i, noise in enumerate((grain, *others))]
        done = clean("filter", *paths, "-o", tmp_path / "o.exr", *lens, "--denoise")
        return done.stderr

    alone = "render each view with a seed of its own"
    assert alone in said(grain)
    assert alone in said(np.roll(grain, 1, 1))
    assert alone not in said(rng.normal(0, 0.1, albedo.shape))
    assert alone not in said(np.roll(grain, 4, 1))


@pytest.mark.parametrize("n", (1, 2))
def test_black_stays_black_around_things(clean, tmp_path, n):
    """A lit square in focus, in grain, before nothing.

    The denoiser draws some of its light one pixel beyond it, which the lens would spread.
    """
    height, width, rng = 90, 120, np.random.default_rng(3)
    thing = np.zeros((height, width, 1), bool)
    thing[30:60, 40:80] = True
    far = np.ones(thing.shape, bool)
    far[28:62, 38:82] = False
    names = [*"RGBAZ", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ")]
    lens = ["--focus-distance", "10", "--lens-radius", "1", "--focal-length-px", "80"]
    paths = []
    for i in range(n):
        light = np.where(thing, rng.exponential(0.5, (height, width, 3)), 0)
        planes = [light, thing, np.where(thing, 10.0, 1e10)]
        planes += [np.where(thing, [0.7, 0.6, 0.5], 0), np.where(thing, [0, 0, 1.0], 0)]
        facts = {"rackfocus:lensOffset": (i - (n - 1) / 2, 0.0)}
        facts["rackfocus:shearDistance"] = 10.0
        path = tmp_path / f"view{i}.exr"
        pixels = np.concatenate(planes, -1)
        paths.append(write_with(path, pixels, names, facts if n > 1 else {}))
    out = tmp_path / "out.exr"
    clean("filter", *paths, "-o", out, "--type", "float", "--denoise", *lens)
    got = read(out)[0][..., :3]
    assert 0.4 < got[35:55, 45:75].mean() < 0.6
    assert got[far[..., 0]].max() == 0


def test_guides_in_files_of_their_own(clean, tmp_path):
    """The same bits as beside the colour: one picture, a sequence, the own lens."""
    _, path = make_smeared(tmp_path, lambda v: v)
    pixels, names = read(path)
    at = {name: i for i, name in enumerate(names)}
    for part, wanted in (
        ("colour", "RGBZ"),
        ("albedo", [f"albedo.{c}" for c in "RGB"]),
        ("normal", [f"normal.{c}" for c in "XYZ"]),
    ):
        plain = [name.split(".")[-1] for name in wanted]
        write(
            tmp_path / f"{part}.0001.exr", pixels[..., [at[n] for n in wanted]], plain
        )
    lens = [
        "--focus-distance",
        "10",
        "--lens-radius",
        "0.1",
        "--focal-length-px",
        "100",
    ]
    files = [
        f"--{part}-file={tmp_path}/{part}.####.exr" for part in ("albedo", "normal")
    ]
    one = [word.replace("####", "0001") for word in files]
    colour = tmp_path / "colour.0001.exr"

    def made(command, source, *more):
        out = tmp_path / "out.exr"
        clean(command, source, "-o", out, "--type", "float", *more)
        return read(out)[0][..., :3]

    want = made("filter", path, *lens, "--denoise")
    got = made("filter", colour, *lens, "--denoise", *one)
    assert np.array_equal(want, got)
    assert not np.array_equal(want, made("filter", colour, *lens, "--denoise"))
    clean("filter", tmp_path / "colour.####.exr", "-o", tmp_path / "s.####.exr",
          "--frames", "1", "--type", "float", *lens, "--denoise", *files)  # fmt: skip
    assert np.array_equal(want, read(tmp_path / "s.0001.exr")[0][..., :3])
    assert np.array_equal(made("finish", path), made("finish", colour, *one))


def test_guides_in_files_that_do_not_fit(clean, tmp_path):
    out = tmp_path / "out.exr"
    pixels = np.zeros((20, 30, 3))
    small = write(tmp_path / "small.exr", pixels, "RGB")
    other = write(tmp_path / "other.exr", pixels[..., :2], ["U", "V"])
    words = ["-o", out, "--denoise"]
    for code, text, more in (
        (1, "small.exr is 30 x 20 px", [POSTS, f"--albedo-file={small}"]),
        (1, "neither R G B nor X Y Z", [POSTS, f"--albedo-file={other}"]),
        (2, "--normal-file goes with --albedo", [POSTS, f"--normal-file={small}"]),
        (2, "every view needs", [*views("posts"), f"--albedo-file={small}"]),
    ):
        assert text in clean("filter", *more, *words, code=code).stderr
        assert not out.exists()
    done = clean("filter", POSTS, "-o", out, f"--albedo-file={small}", code=2)
    assert "go with --denoise" in done.stderr


def test_what_is_not_finite_is_still_refused(clean, tmp_path):
    pixels, names = read(POSTS)
    pixels[3, 4, names.index("G")] = np.nan
    source = write(tmp_path / "nan.exr", pixels, names, POSTS)
    done = clean("filter", source, "-o", tmp_path / "out.exr", "--denoise", code=1)
    assert "nan.exr" in done.stderr and not (tmp_path / "out.exr").exists()


def test_deep_files_are_refused(clean, tmp_path):
    deep = REFERENCES.parents[1] / "deep/files/deep-zips.exr"
    done = clean("filter", deep, "-o", tmp_path / "out.exr", "--denoise", code=2)
    assert "--denoise" in done.stderr and "deep" in done.stderr


def test_without_the_library_it_says_what_to_do(rackfocus, tmp_path):
    out = tmp_path / "out.exr"
    for place in (tmp_path / "nowhere", tmp_path):
        environment = {**os.environ, "RACKFOCUS_OIDN": str(place)}
        done = rackfocus(
            "filter", POSTS, "-o", out, "--denoise", code=1, env=environment
        )
        assert "RACKFOCUS_OIDN" in done.stderr and str(place) in done.stderr
        assert not out.exists()


def test_a_sequence_is_made_anew_with_it(clean, tmp_path):
    (tmp_path / "in.0001.exr").write_bytes(POSTS.read_bytes())
    names = [tmp_path / "in.####.exr", "-o", tmp_path / "out.####.exr"]
    clean("filter", *names)
    first = (tmp_path / "out.0001.exr").read_bytes()
    clean("filter", *names, "--denoise")
    assert (tmp_path / "out.0001.exr").read_bytes() != first


def test_more_of_the_lens_is_told_apart(clean, tmp_path):
    """16 sub-apertures beside the denoiser, unless something else is asked for."""
    out, made = tmp_path / "out.exr", {}
    for n in (None, 16, 4):
        more = ["--sub-apertures", n] if n else []
        clean("filter", POSTS, "-o", out, "--type", "float", "--denoise", *more)
        made[n] = read(out)[0]
    assert np.array_equal(made[None], made[16])
    assert not np.array_equal(made[None], made[4])


def test_a_denoiser_without_memory_names_the_way_out(binary, oidn, tmp_path):
    """Six allocations fail, one in each run: the library's own for the most part, which
    may abort where it makes its threads.
    """
    pixels, names = read(POSTS)
    source = write(tmp_path / "in.exr", pixels[::10, ::10], names, POSTS)
    out, count = tmp_path / "out.exr", tmp_path / "count"
    words = [
        "filter",
        source,
        "-o",
        out,
        "--denoise",
        "--denoise-quality",
        "fast",
        "-j1",
    ]
    failing = str(BUILD / "tests/faults/libfailing.so")

    def run(**faults):
        environment = {**os.environ, "RACKFOCUS_OIDN": str(oidn), "LD_PRELOAD": failing}
        environment.update(faults)
        return subprocess.run(
            [binary, *words], env=environment, capture_output=True, text=True
        )

    assert run(FAIL_COUNT=str(count)).returncode == 0
    n = int(count.read_text().split()[0])
    out.write_bytes(b"old")
    said = [run(FAIL_ALLOCATION=str(n * i // 12)).stderr for i in range(4, 10)]
    way = "in.exr: Open Image Denoise failed: out of memory; free some memory, or"
    assert sum(way in text for text in said) >= 2, said
    assert out.read_bytes() == b"old" or "" in said


@pytest.mark.parametrize(
    "layer", ["{view}denoise_albedo.{c}", "denoise_albedo.{mid}{c}"]
)
def test_each_eye_has_its_own_guides(clean, tmp_path, layer):
    """What left has under the same name is a texture that lies elsewhere."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:48, :64]
    planes, names, files = [], [], {}
    for k, view in enumerate(("left", "right")):
        albedo = (0.25 + 0.5 * ((x // 3 + y // 3 + k) % 2))[..., None].repeat(3, -1)
        noisy = np.maximum(albedo + rng.normal(0, 0.3, albedo.shape), 0)
        mine = [noisy, np.full((48, 64, 1), 10.0), albedo]
        alone = [*"RGBZ", *(f"denoise_albedo.{c}" for c in "RGB")]
        files[view] = write(tmp_path / f"{view}.exr", np.concatenate(mine, -1), alone)
        start, mid = ("right.", "right.") if k else ("", "")
        planes += mine
        names += [f"{start}{c}" for c in "RGBZ"]
        names += [layer.format(view=start, mid=mid, c=c) for c in "RGB"]
    pixels = np.ascontiguousarray(np.concatenate(planes, -1), np.float32)
    spec = oiio.ImageSpec(64, 48, pixels.shape[-1], "float")
    spec.channelnames = tuple(names)
    spec.attribute("multiView", oiio.TypeDesc("string[2]"), ("left", "right"))
    both = oiio.ImageOutput.create(str(tmp_path / "both.exr"))
    assert both.open(str(tmp_path / "both.exr"), spec) and both.write_image(pixels)
    both.close()
    lens = ["--focus-distance", "10", "--denoise", "--type", "float", "-q"]
    lens += ["--denoise-quality", "fast"]
    clean(
        "filter", tmp_path / "both.exr", "--stereo", "-o", tmp_path / "o_%V.exr", *lens
    )
    for view, path in files.items():
        clean("filter", path, "-o", tmp_path / "alone.exr", *lens)
        got, want = read(tmp_path / f"o_{view}.exr")[0], read(tmp_path / "alone.exr")[0]
        assert np.array_equal(got, want), view
