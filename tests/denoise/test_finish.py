# SPDX-License-Identifier: Apache-2.0
"""finish: the renderer's own lens, cleaned with our picture."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import BUILD, REFERENCES, ROOT, read, write

SCENES = ("posts", "portrait")


def own(scene):
    """Cycles' own depth of field, 64 samples."""
    return REFERENCES / f"{scene}_dof64.exr"


def views(scene):
    return sorted(REFERENCES.glob(f"{scene}_view*.exr"))


@pytest.fixture
def finished(clean, score, tmp_path):
    """tPSNR of what finish makes of guides."""

    def run(scene, *guides):
        out = tmp_path / f"{scene}.exr"
        clean("finish", own(scene), *guides, "-o", out, "--type", "float")
        return score(out, scene)

    return run


@pytest.mark.parametrize("scene", SCENES)
def test_beats_the_denoised_lens(finished, scene):
    """With 64 samples of its own on top of passes: + 1.9 to 2.9 dB when written."""
    rival = finished(scene)
    assert finished(scene, *views(scene)) > rival + 1.5
    assert finished(scene, REFERENCES / f"{scene}_pinhole.exr") > rival + 1.2


def test_a_filtered_picture_is_a_guide_as_passes_are(clean, finished, score, tmp_path):
    ours = tmp_path / "ours.exr"
    pinhole = REFERENCES / "posts_pinhole.exr"
    clean("filter", pinhole, "-o", ours, "--type", "float", "--denoise")
    assert finished("posts", ours) == pytest.approx(
        finished("posts", pinhole), abs=0.02
    )
    out = tmp_path / "named.exr"
    clean("finish", own("posts"), "--guide", ours, "-o", out, "--type", "float")
    assert score(out, "posts") == pytest.approx(finished("posts", ours), abs=0.02)


def test_a_guide_whose_depth_is_not_found_is_said(clean, tmp_path):
    """Passes that are taken for a picture with its lens would bring the pinhole back."""
    pixels, names = read(REFERENCES / "posts_pinhole.exr")
    renamed = ["far.W" if name == "Z" else name for name in names]
    ours, out = tmp_path / "ours.exr", tmp_path / "out.exr"
    write(tmp_path / "passes.exr", pixels, renamed)
    done = clean("finish", own("posts"), tmp_path / "passes.exr", "-o", out)
    assert "no depth that is known" in done.stderr and "--depth-channel" in done.stderr
    clean("filter", REFERENCES / "posts_pinhole.exr", "-o", ours)
    assert clean("finish", own("posts"), ours, "-o", out).stderr == ""


def test_a_guide_of_another_lens_is_told(clean, tmp_path):
    """Focus 1.1 for 1: 38.6 dB with the right one, 32.0 so, 34.6 without any; silent."""
    guide, out = tmp_path / "guide.exr", tmp_path / "out.exr"
    lens = ["--focal-length-px", 666.667, "--type", "float"]
    for focus, radius in ((1, 0.03125), (1.1, 0.03125), (1, 0.022)):
        blur = ["--focus-distance", focus, "--lens-radius", radius]
        clean("filter", REFERENCES / "posts_pinhole.exr", "-o", guide, *lens, *blur)
        fast = ["--denoise-quality", "fast", "-o", out]
        said = clean("finish", own("posts"), guide, *fast).stderr
        assert ("blurred in another way" in said) == ((focus, radius) != (1, 0.03125))


def test_headers_with_another_lens_are_told(clean, tmp_path):
    pixels, names = read(own("posts"))
    guide, like = tmp_path / "guide.exr", tmp_path / "like.exr"
    pinhole, out = REFERENCES / "posts_pinhole.exr", tmp_path / "out.exr"
    clean("filter", pinhole, "-o", guide)
    for lens, text in (
        ([], ""),
        (["--focus-distance", 1.5], "focus distance 1.5, and the guide has 1 ("),
        (["--lens-radius", 0.02], "lens radius 0.02, and the guide has 0.03125"),
    ):
        clean("filter", pinhole, "-o", like, *lens)
        lens = write(tmp_path / "own.exr", pixels, names, like)
        fast = ["--denoise-quality", "fast", "-o", out]
        said = clean("finish", lens, guide, *fast).stderr
        assert text in said and bool(text) == bool(said)
    # 10 is the default, which a list of what was changed does not name.
    clean("filter", pinhole, "-o", guide, "--focus-distance", 10, "-q")
    lens = write(tmp_path / "own.exr", pixels, names, pinhole)
    said = clean("finish", lens, guide, "--denoise-quality", "fast", "-o", out).stderr
    assert "focus distance 1, and the guide has 10 (" in said


def test_the_own_samples_decide(clean, tmp_path):
    """What the guide does not know comes back; the estimate knows where."""
    height, width = 120, 160
    noise = np.random.default_rng(3).normal(0, 0.1, (height, width, 3))
    noise[:, : width // 2] /= 5
    truth = np.full((height, width, 3), 0.3)
    truth[40:80, 90:130] = [0.7, 0.2, 0.1]  # a reflection that the guide lacks
    lens = write(tmp_path / "own.exr", np.maximum(truth + noise, 0), "RGB")
    guide = write(tmp_path / "guide.exr", np.full_like(truth, 0.3), "RGB")
    out, error = tmp_path / "out.exr", tmp_path / "error.exr"
    options = ["--output-error", error, "--type", "float"]
    clean("finish", lens, guide, "-o", out, *options)
    got, names = read(out)
    got = got[..., [names.index(c) for c in "RGB"]]
    assert np.abs(got[48:72, 98:122] - truth[48:72, 98:122]).mean() < 0.03
    assert np.abs(got[:30] - truth[:30]).mean() < 0.005
    estimate = read(error)[0][..., 0]
    assert estimate.min() >= 0
    # Five times the grain; what the guide says of calm tones does not grow with it.
    assert estimate[:30, 90:].mean() > 2 * estimate[:30, :70].mean()
    wrong = np.abs(got.clip(0) ** (1 / 2.2) - truth ** (1 / 2.2)).max(axis=-1)
    for calm in (np.s_[:30, :70], np.s_[:30, 90:], np.s_[48:72, 98:122]):
        ratio = np.sqrt((estimate[calm] ** 2).mean() / (wrong[calm] ** 2).mean())
        assert 0.4 < ratio < 4  # 1.5, 3.2 and 0.54 when written


def test_a_guide_of_another_exposure_is_told(clean, tmp_path):
    """posts of 33.5 dB for 38.7, and 34.6 without any; grain and mirrors are none."""
    random = np.random.default_rng(3)
    light = np.repeat(random.uniform(0.02, 2, (96, 128, 1)), 3, 2)
    light[:16] = 0  # black tells nothing
    lens = write(tmp_path / "own.exr", light * random.gamma(1, 1, light.shape), "RGB")

    def said(name, guide):
        path = write(tmp_path / name, guide, "RGB")
        out = tmp_path / "out.exr"
        return clean("finish", lens, "--guide", path, "-o", out).stderr

    twice = re.search(
        r"is (\S+) times as bright as the guide", said("a.exr", 2 * light)
    )
    assert float(twice[1]) == pytest.approx(0.5, abs=0.02)
    assert "as bright as the guide" in said("b.exr", light.clip(0, 1) ** (1 / 2.2))
    light[:, :40] *= 4  # what mirrors show
    assert "as bright" not in said("c.exr", light)


def test_passes_are_filtered_in_the_temporary_folder(clean, tmp_path, monkeypatch):
    """Not in the user's: where the temporary one is gone, nothing can be made."""
    temporary, here = tmp_path / "temporary", tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    monkeypatch.setenv("TMPDIR", str(temporary))
    words = ["finish", own("posts"), REFERENCES / "posts_pinhole.exr", "-o", "out.exr"]
    assert "TMPDIR" in clean(*words, code=1).stderr
    assert not list(here.iterdir())
    temporary.mkdir()
    said = clean(*words).stdout
    assert "posts_pinhole.exr: focus 1" in said and str(temporary) not in said
    assert [p.name for p in here.iterdir()] == ["out.exr"]
    assert not list(temporary.iterdir())


def test_names_what_is_wrong(clean, tmp_path):
    small = write(tmp_path / "small.exr", np.ones((20, 30, 3)), "RGB")
    out = tmp_path / "out.exr"
    done = clean("finish", own("posts"), small, "-o", out, code=1)
    assert "small.exr" in done.stderr and "30 x 20" in done.stderr
    done = clean("finish", own("posts"), "-o", out, "--output-error", "e.exr", code=2)
    assert "--output-error" in done.stderr
    done = clean("finish", own("posts"), tmp_path / "none.exr", "-o", out, code=1)
    assert "none.exr" in done.stderr
    pixels = np.ones((20, 30, 3))
    pixels[2, 5, 0] = np.inf
    bad = write(tmp_path / "bad.exr", pixels, "RGB")
    done = clean("finish", bad, "-o", out, code=1)
    assert "bad.exr" in done.stderr and "(5, 2)" in done.stderr
    assert clean("finish", code=2).stderr
    assert not out.exists()


def test_passes_of_another_size_are_not_filtered_first(rackfocus, tmp_path):
    """It is said before a denoiser is looked for."""
    small = tmp_path / "small.exr"
    pixels, names = read(REFERENCES / "posts_pinhole.exr")
    write(small, pixels[:20, :30], names, REFERENCES / "posts_pinhole.exr")
    environment = {**os.environ, "RACKFOCUS_OIDN": "/nowhere"}
    words = ("finish", own("posts"), small, "-o", tmp_path / "out.exr")
    done = rackfocus(*words, code=1, env=environment)
    assert "30 x 20 px" in done.stderr and "render both in one size" in done.stderr


def test_passes_of_supersampled_pixels(clean, tmp_path):
    """They are a guide as filter makes it of them; another size is answered with N."""
    header, lens = REFERENCES / "posts_pinhole.exr", tmp_path / "own.exr"
    pixels, names = read(header)
    part = pixels[60:180, 100:280]
    twice = np.repeat(np.repeat(part, 2, 0), 2, 1)
    write(lens, read(own("posts"))[0][60:180, 100:280], "RGB")
    passes = write(tmp_path / "passes.exr", twice, names, header)
    fast = ("--denoise-quality", "fast", "--type", "float")
    optics = ("--focal-length-px", 2 * 666.667)
    filtered, by_passes, by_filter = (tmp_path / f"{n}.exr" for n in "abc")
    scale = ("--supersample", 2)
    clean("filter", passes, "-o", filtered, *fast, *optics, *scale, "--denoise")
    clean("finish", lens, passes, "-o", by_passes, *fast, *optics, *scale)
    clean("finish", lens, filtered, "-o", by_filter, *fast)
    assert np.array_equal(read(by_passes)[0], read(by_filter)[0])
    said = clean("finish", lens, filtered, "-o", by_filter, *fast, *scale).stderr
    assert "--supersample: has no effect" in said
    for words, text in (
        ((passes,), "is 2 times as large as"),
        ((passes, "--supersample", 3), "give --supersample 2"),
        ((header, *scale), "takes passes of 360 x 240"),
        ((lens, "--supersample", 1), ""),
    ):
        code = 1 if text else 0
        done = clean("finish", lens, *words, "-o", by_filter, *fast, code=code)
        assert text in done.stderr, words
    done = clean("finish", lens, *scale, "-o", by_filter, code=2)
    assert "--supersample is of passes" in done.stderr


def test_pictures_of_another_place(rackfocus, tmp_path):
    """Of one size: each pixel would be cleaned by another, without a word."""
    rng = np.random.default_rng(5)
    noise = [rng.uniform(0, 1, (20, 30, 4)) for _ in range(2)]
    here = write(tmp_path / "here.exr", noise[0], "RGBZ")
    moved = write(tmp_path / "moved.exr", noise[1], "RGBZ", place=(-4, 2))
    bare = write(tmp_path / "bare.exr", noise[1][..., :3], "RGB", place=(-4, 2))
    out = tmp_path / "out.exr"
    environment = {**os.environ, "RACKFOCUS_OIDN": "/nowhere"}
    for words in (
        [moved],
        ["--guide", bare],
        [bare],
        ["--half", bare],
        ["--albedo-file", bare],
        ["--albedo-file", here, "--normal-file", bare],
    ):
        done = rackfocus("finish", here, *words, "-o", out, code=1, env=environment)
        assert "(-4, 2) to (25, 21)" in done.stderr, words
        assert "(0, 0) to (29, 19)" in done.stderr
        assert "--origin +0+0" in done.stderr


def test_halves_tell_what_is_grain(clean, tmp_path):
    """What both halves show is no grain, however fine: it stays, and is certain."""
    rng = np.random.default_rng(8)
    y, x = np.mgrid[:96, :128]
    blob = 0.06 * np.exp(-((x - 64) ** 2 + (y - 48) ** 2) / (2 * 8**2))
    both = (0.3 + blob + rng.normal(0, 0.2, blob.shape))[..., None].repeat(3, 2)
    apart = rng.normal(0, 1e-4, both.shape)
    paths = [tmp_path / f"{n}.exr" for n in ("mean", "a", "b", "ours")]
    flat = np.full(both.shape, 0.3)
    for path, rgb in zip(paths, (both, both + apart, both - apart, flat), strict=True):
        write(path, rgb.astype(np.float32), ["R", "G", "B"])
    mean, a, b, ours = paths
    shown, errors = [], []
    for words in ([mean], [a, "--half", b]):
        out, error = tmp_path / "out.exr", tmp_path / "error.exr"
        clean("finish", *words, "--guide", ours, "-o", out, "--output-error", error)
        shown.append(read(out)[0][44:53, 60:69].mean() - 0.3)
        errors.append(read(error)[0].mean())
    assert shown[1] > 2 * shown[0]  # 0.020 and 0.006 when written
    assert errors[1] < 0.5 * errors[0]


def test_names_what_is_wrong_with_a_half(clean, tmp_path):
    rng = np.random.default_rng(9)
    a, b, small, wild = (
        write(tmp_path / f"{n}.exr", rng.uniform(0, 1, (h, 30, 3)), "RGB")
        for n, h in (("a", 20), ("b", 20), ("small", 10), ("wild", 20))
    )
    pixels = np.ones((20, 30, 3))
    pixels[3, 7, 1] = np.nan
    write(wild, pixels, "RGB")
    out = tmp_path / "out.exr"
    for half, words in (
        (a, ("a.exr", "seed")),
        (small, ("small.exr", "30 x 10", "30 x 20")),
        (wild, ("wild.exr", "(7, 3)")),
        (tmp_path / "none.exr", ("none.exr",)),
    ):
        done = clean("finish", a, "--half", half, "-o", out, code=1)
        assert all(word in done.stderr for word in words)
        assert not out.exists()
    clean("finish", a, "--half", b, "-o", out)
    assert out.exists()


PYTHON = """
import sys
import numpy as np
import rackfocus
folder, library = sys.argv[1:]
own, ours = (np.load(f"{folder}/{name}.npy") for name in ("own", "ours"))
error = np.empty(own.shape[:2], np.float32)
made = rackfocus.finish(own, ours, error=error, library=library)
np.save(f"{folder}/made.npy", made)
np.save(f"{folder}/error.npy", error)
padded = np.dstack([own, np.full(own.shape[:2], 0.5, np.float32)])
again = rackfocus.finish(padded, ours, library=library)
WHITE = np.float32(1 / 128)
dark = rackfocus.finish(own * WHITE, ours * WHITE, library=library, white=1 / 128)
assert np.array_equal(dark, made * WHITE)
assert np.array_equal(again[..., :3], made) and (again[..., 3] == 0.5).all()


def fails(kind, text, *pictures, **about):
    try:
        rackfocus.finish(*pictures, **{"library": library, **about})
    except kind as problem:
        assert text in str(problem), problem
    else:
        raise AssertionError(text)


fails(ValueError, "as large as own", own, ours[1:])
fails(ValueError, "3 or 4 channels", own, ours[..., :2])
fails(ValueError, "NaN", own, np.where(ours > 0.5, np.nan, ours))
fails(rackfocus.Error, "Open Image Denoise", own, ours, library="/nowhere")
fails(ValueError, "white", own, ours, white=0)
fails(ValueError, "samples", own, ours, samples=-1)
few = rackfocus.finish(own, ours, samples=2, library=library)
assert np.abs(few - ours).mean() < 0.9 * np.abs(made - ours).mean()
"""


def test_python_does_what_the_command_does(clean, oidn, package, tmp_path):
    """rackfocus.finish(): the same bits, picture and estimate; what it refuses."""
    guide, out, error = (tmp_path / f"{n}.exr" for n in ("guide", "out", "error"))
    passes = REFERENCES / "posts_pinhole.exr"
    clean("filter", passes, "-o", guide, "--type", "float", "--denoise")
    to_float = ("-o", out, "--type", "float", "--output-error", error)
    clean("finish", own("posts"), "--guide", guide, *to_float)

    def rgb(path):
        pixels, names = read(path)
        return np.ascontiguousarray(pixels[..., [names.index(c) for c in "RGB"]])

    np.save(tmp_path / "own.npy", rgb(own("posts")))
    np.save(tmp_path / "ours.npy", rgb(guide))
    # The library is named in the call: the environment's place would be taken first.
    environment = {k: v for k, v in os.environ.items() if k != "RACKFOCUS_OIDN"}
    environment["PYTHONPATH"] = str(package)
    command = [sys.executable, "-c", PYTHON, tmp_path, oidn]
    subprocess.run(command, check=True, env=environment)
    assert np.array_equal(np.load(tmp_path / "made.npy"), rgb(out))
    assert np.array_equal(np.load(tmp_path / "error.npy"), read(error)[0][..., 0])


def test_grain_of_albedo_and_normals_is_no_texture(clean, tmp_path):
    """The lens's grain is in the guides, too; they are cleaned first, as Cycles does."""
    rng = np.random.default_rng(3)
    height, width = 128, 192
    x = np.linspace(0, 1, width, dtype=np.float32)
    truth = np.broadcast_to((0.3 + 0.3 * x)[None, :, None], (height, width, 3))
    shape = (height, width, 3)
    colour = truth * rng.exponential(1, shape) ** 0.7
    albedo = np.clip(0.5 + 0.25 * rng.standard_normal(shape), 0, 1)
    normal = np.stack([0 * truth[..., 0], 0 * truth[..., 0], 1 + 0 * truth[..., 0]], -1)
    normal = normal + 0.5 * rng.standard_normal(shape)
    names = ["R", "G", "B"]
    names += [f"Denoising Albedo.{c}" for c in "RGB"]
    names += [f"Denoising Normal.{c}" for c in "XYZ"]
    pixels = np.concatenate([colour, albedo, normal], -1).astype(np.float32)
    own, out = tmp_path / "own.exr", tmp_path / "out.exr"
    write(own, pixels, names)
    clean("finish", own, "-o", out, "-q")
    made, found = read(out)
    made = made[..., [found.index(c) for c in "RGB"]]
    mean = colour.mean((0, 1)) / truth.mean((0, 1))
    error = np.sqrt(np.mean((made / mean - truth) ** 2))
    assert error < 0.03  # 0.020 when written, 0.048 by guides as they are


def write_own(path, colour, albedo=None):
    """An own render, its normals towards the eye."""
    height, width, _ = colour.shape
    names, planes = ["R", "G", "B"], [colour]
    if albedo is not None:
        names += [f"Denoising Albedo.{c}" for c in "RGB"]
        names += [f"Denoising Normal.{c}" for c in "XYZ"]
        planes += [albedo, np.broadcast_to((0.0, 0.0, 1.0), colour.shape)]
    write(path, np.concatenate(planes, -1).astype(np.float32), names)


def error_of(path, truth):
    """Root of the mean square, scene-linear."""
    made, found = read(path)
    made = made[..., [found.index(c) for c in "RGB"]]
    return np.sqrt(np.mean((made - truth) ** 2))


def test_grain_that_is_dark_on_average_on_a_display_does_not_darken(clean, tmp_path):
    """Rare bright samples: gamma of their mean is more than the mean of their gamma."""
    rng = np.random.default_rng(4)
    truth = np.full((96, 128, 3), 0.3)
    own, ours, out = (tmp_path / f"{n}.exr" for n in ("own", "ours", "out"))
    write_own(own, truth * rng.gamma(0.25, 4, truth.shape[:2])[..., None])
    write(ours, truth.astype(np.float32), ["R", "G", "B"])
    clean("finish", own, "--guide", ours, "-o", out, "--type", "float", "-q")
    assert error_of(out, truth) < 0.006  # 0.0027 when written, 0.0107 compared by gamma


def test_few_samples_are_no_proof(clean, tmp_path):
    """Where no bright sample fell, our light is kept: samples by option or by header."""
    rng = np.random.default_rng(11)
    truth = np.full((96, 128, 3), 0.2)
    hits = rng.uniform(size=truth.shape[:2]) < 1 / 200
    own, ours, out = (tmp_path / f"{n}.exr" for n in ("own", "ours", "out"))
    write(ours, truth.astype(np.float32), ["R", "G", "B"])
    line = ("finish", own, "--guide", ours, "-o", out, "--type", "float", "-q")
    pixels = np.where(hits[..., None], 30, 0.05).repeat(3, -1).astype(np.float32)
    errors = {}
    for samples, header in ((0, ""), (1, ""), (0, "1"), (10, "1"), (0, "64")):
        about = {"cycles.View.Layer.samples": header} if header else {}
        write(own, pixels, ["R", "G", "B"], **about)
        clean(*line, *(("--samples", samples) if samples else ()))
        errors[samples, header] = error_of(out, truth)
    assert errors[1, ""] == errors[0, "1"] < 0.02  # 0.0012 and 0.078 when written
    assert errors[0, ""] == errors[10, "1"] == errors[0, "64"] > 3 * errors[1, ""]


def test_the_own_albedo_brings_textures_back(clean, tmp_path):
    """Which our picture does not know."""
    rng = np.random.default_rng(5)
    texture = rng.uniform(0.2, 0.8, (48, 64, 1)).repeat(2, 0).repeat(2, 1)
    truth = np.broadcast_to(0.5 * texture, (96, 128, 3))
    grain = rng.gamma(9, 1 / 9, truth.shape[:2])[..., None]
    ours = tmp_path / "ours.exr"
    write(ours, np.full(truth.shape, 0.25, np.float32), ["R", "G", "B"])
    errors = []
    for albedo in (None, np.broadcast_to(texture, truth.shape)):
        own, out = tmp_path / "own.exr", tmp_path / "out.exr"
        write_own(own, truth * grain, albedo)
        clean("finish", own, "--guide", ours, "-o", out, "--type", "float", "-q")
        errors.append(error_of(out, truth))
    assert errors[1] < 0.92 * errors[0]  # 0.050 and 0.058 when written


WITH_HALVES = """
import sys
import numpy as np
import rackfocus

folder, library = sys.argv[1:]
a, b, ours = np.load(f"{folder}/given.npy")
more = {"library": library, "threads": 1}
np.save(f"{folder}/made.npy", rackfocus.finish(a, ours, half=b, **more))
for half, why in ((a, "another seed"), (b[:9], "as large as own"), (a / 0, "NaN")):
    try:
        rackfocus.finish(a, ours, half=half, **more)
    except ValueError as error:
        assert "half" in str(error) and why in str(error), error
    else:
        sys.exit(f"no error: {why}")
"""


def test_python_takes_a_half_as_the_command_does(clean, oidn, package, tmp_path):
    rng = np.random.default_rng(10)
    given = rng.uniform(0.2, 0.8, (3, 48, 64, 3)).astype(np.float32)
    a, b, ours, out = (tmp_path / f"{n}.exr" for n in ("a", "b", "ours", "out"))
    for path, rgb in zip((a, b, ours), given, strict=True):
        write(path, rgb, ["R", "G", "B"])
    more = ("--type", "float", "--threads", 1)
    clean("finish", a, "--half", b, "--guide", ours, "-o", out, *more)
    np.save(tmp_path / "given.npy", given)
    environment = {k: v for k, v in os.environ.items() if k != "RACKFOCUS_OIDN"}
    environment["PYTHONPATH"] = str(package)
    line = [sys.executable, "-c", WITH_HALVES, tmp_path, oidn]
    subprocess.run(line, check=True, env=environment)
    made, names = read(out)
    made = made[..., [names.index(c) for c in "RGB"]]
    assert np.array_equal(np.load(tmp_path / "made.npy"), made)


WITH_GUIDES = """
import sys
import numpy as np
import rackfocus

folder, library = sys.argv[1:]
own, ours, albedo, normal = np.load(f"{folder}/given.npy")
made = rackfocus.finish(
    own, ours, albedo=albedo, normal=normal, library=library, threads=1
)
np.save(f"{folder}/made.npy", made)
"""


def test_python_takes_the_albedo_too(clean, oidn, package, tmp_path):
    """The same bits as the command, which finds it in the file."""
    rng = np.random.default_rng(6)
    shape = (48, 64, 3)
    ours = rng.uniform(0.2, 0.4, shape).astype(np.float32)
    albedo = rng.uniform(0, 1, shape).astype(np.float32)
    colour = (0.5 * albedo * rng.gamma(2, 0.5, shape)).astype(np.float32)
    normal = np.broadcast_to(np.float32([0, 0, 1]), shape)
    own, guide, out = (tmp_path / f"{n}.exr" for n in ("own", "guide", "out"))
    write_own(own, colour, albedo)
    write(guide, ours, ["R", "G", "B"])
    command = ("--type", "float", "--threads", 1)
    clean("finish", own, "--guide", guide, "-o", out, *command)
    np.save(tmp_path / "given.npy", np.stack([colour, ours, albedo, normal]))
    environment = {k: v for k, v in os.environ.items() if k != "RACKFOCUS_OIDN"}
    environment["PYTHONPATH"] = str(package)
    line = [sys.executable, "-c", WITH_GUIDES, tmp_path, oidn]
    subprocess.run(line, check=True, env=environment)
    made, names = read(out)
    made = made[..., [names.index(c) for c in "RGB"]]
    assert np.array_equal(np.load(tmp_path / "made.npy"), made)


def test_no_guide_is_spoken_of_first(rackfocus, tmp_path):
    """Before a denoiser is asked for, which may not be there."""
    path = tmp_path / "own.exr"
    write(path, np.full((8, 8, 3), 0.5, np.float32), "RGB")
    done = rackfocus(
        "finish", path, "-o", tmp_path / "out.exr", code=1,
        env=os.environ | {"RACKFOCUS_OIDN": str(tmp_path)},
    )  # fmt: skip
    first, *rest = done.stderr.splitlines()
    assert "own.exr: has no albedo and no guide is given" in first
    assert "Open Image Denoise" in rest[0]


SIGNALS = """
import signal
import sys
import numpy as np
import rackfocus

called = []


class Stopped(Exception):
    pass


def stop(number, frame):
    called.append(number)
    if len(called) == 3:
        signal.setitimer(signal.ITIMER_REAL, 0)
        raise Stopped


own = np.random.default_rng(1).random((800, 1200, 3), np.float32)
ours = np.full_like(own, 0.5)
out = np.full_like(own, np.nan)
signal.signal(signal.SIGALRM, stop)
signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
try:
    rackfocus.finish(own, ours, out, library=sys.argv[1])
except Stopped:
    assert np.isnan(out).all()
else:
    raise AssertionError(f"{len(called)} signals were handled")
"""


def test_signals_end_it_in_python(oidn, package):
    """Handlers run while it works: more than once, where one comes each 20 ms."""
    environment = {k: v for k, v in os.environ.items() if k != "RACKFOCUS_OIDN"}
    environment["PYTHONPATH"] = str(package)
    line = [sys.executable, "-c", SIGNALS, oidn]
    subprocess.run(line, check=True, env=environment)
