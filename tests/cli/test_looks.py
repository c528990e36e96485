# SPDX-License-Identifier: Apache-2.0
"""--look and --aperture-image: kinds of lenses, and pictures of the aperture."""

import json
from pathlib import Path

import numpy
import plainexr
import pytest

LENS = ["--focus-distance", "3", "--f-stop", "0.1"]


def made(rackfocus, scene, tmp_path, *options):
    out = tmp_path / "out.exr"
    rackfocus("filter", scene(), "-o", out, "--compression", "none", *LENS, *options)
    return numpy.stack([plainexr.read(out)[0][name] for name in "RGB"])


@pytest.mark.parametrize(
    "name", "vintage anamorphic mirror fast bubble miniature".split()
)
def test_looks_do_something(rackfocus, scene, tmp_path, name):
    plain = made(rackfocus, scene, tmp_path)
    assert not numpy.array_equal(
        plain, made(rackfocus, scene, tmp_path, "--look", name)
    )


def test_a_look_is_its_options_and_typed_ones_win(rackfocus, scene, tmp_path):
    look = made(rackfocus, scene, tmp_path, "--look", "bubble", "--spherical", "0")
    typed = made(rackfocus, scene, tmp_path, "--cat-eye", "0.4")
    assert numpy.array_equal(look, typed)


def test_squeeze_is_pixel_aspect(rackfocus, scene, tmp_path):
    aspect = made(rackfocus, scene, tmp_path, "--pixel-aspect", "2")
    assert not numpy.array_equal(aspect, made(rackfocus, scene, tmp_path))
    lens = tmp_path / "lens.params"
    lens.write_text("squeeze 2\n")
    for options in ("--squeeze", "2"), ("--params", lens):
        assert numpy.array_equal(aspect, made(rackfocus, scene, tmp_path, *options))


def test_a_look_of_ones_own(rackfocus, scene, tmp_path, monkeypatch):
    folder = tmp_path / "config/rackfocus/looks"
    folder.mkdir(parents=True)
    (folder / "mine.params").write_text("blades 5\n")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    own = made(rackfocus, scene, tmp_path, "--look", "mine")
    assert numpy.array_equal(own, made(rackfocus, scene, tmp_path, "--blades", "5"))


def test_a_look_that_cannot_be_read(rackfocus, scene, tmp_path, monkeypatch):
    """It counted as one without parameters."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    (tmp_path / "config" / "rackfocus" / "looks" / "mine.params").mkdir(parents=True)
    done = rackfocus(
        "filter", scene(), "-o", tmp_path / "o.exr", "--look", "mine", code=2
    )
    assert "mine.params: is a folder" in done.stderr
    assert not (tmp_path / "o.exr").exists()


@pytest.mark.parametrize(
    "options, part",
    [
        (["--look", "sharp"], "there are vintage, anamorphic"),
        (["--aperture", "image"], "--aperture-image FILE"),
        (
            ["--aperture-image", "a.exr", "--method", "box"],
            "layered, views and scatter",
        ),
        (
            ["--aperture-image", "a.exr", "--aperture", "disc"],
            "--aperture-image: goes with --aperture image, which can be left out",
        ),
        (
            [*"--aperture-image a.exr --method scatter --distribution ring".split()],
            "--aperture-image: goes with --distribution image, which can be left out",
        ),
    ],
)
def test_what_is_wrong_is_said(rackfocus, scene, tmp_path, options, part):
    out = tmp_path / "out.exr"
    done = rackfocus("filter", scene(), "-o", out, *options, code=2)
    assert part in done.stderr
    assert not out.exists()


def test_the_gallery_has_all_looks(rackfocus):
    """docs/make_looks_gallery.py was run when a look came or changed."""
    docs = Path(__file__).parents[2] / "docs"
    page = (docs / "looks-gallery.md").read_text()
    for look in json.loads(rackfocus("looks", "--json").stdout):
        picture = docs / "images" / f"look-{look['name']}.png"
        assert f"(images/{picture.name})" in page and f"`{look['options']}`" in page
        assert 10_000 < picture.stat().st_size < 150_000


def test_accumulate_changes_highlights_in_each_view(rackfocus, scene, tmp_path):
    """Before the mean: a lamp that half of the views see has half of its gain."""
    bright, dark = scene(), tmp_path / "dark.exr"
    done = rackfocus("accumulate", bright, bright, "-o", tmp_path / "same.exr")
    assert done.stdout == f"{tmp_path / 'same.exr'}: mean of 2 views\n"
    light, _ = plainexr.read(tmp_path / "same.exr")
    black = ("--highlight-threshold", "0", "--highlight-gain", "0")
    rackfocus("accumulate", bright, bright, "-o", dark, *black)
    assert not plainexr.read(dark)[0]["G"].any()
    views = (bright, dark, "-o", tmp_path / "out.exr", "--highlight-threshold", "0")
    rackfocus("accumulate", *views, "--highlight-gain", "3")
    found = plainexr.read(tmp_path / "out.exr")[0]
    assert numpy.allclose(found["G"], 1.5 * light["G"], rtol=2e-3)


def test_a_look_may_be_a_file(rackfocus, scene, tmp_path, monkeypatch):
    """By its path, anywhere, for all commands; what is typed wins over it, too."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "none"))
    file, by_look, typed = (tmp_path / name for name in ("a.params", "l.exr", "t.exr"))
    file.write_text("cat-eye 0.5\nhighlight-gain 3\n")
    words = ("filter", scene(), "-o")
    rackfocus(*words, by_look, "--look", file, "--highlight-gain", "2")
    rackfocus(*words, typed, "--cat-eye", "0.5", "--highlight-gain", "2")
    light = [plainexr.read(path)[0]["G"] for path in (by_look, typed)]
    assert numpy.array_equal(*light)
    rackfocus(*words, by_look, "--look", "a.params", cwd=tmp_path)
    rackfocus("accumulate", typed, typed, "-o", by_look, "--look", file)
    rackfocus("aperture", "-o", tmp_path / "a.png", "--look", file, "--width", "200")
    file.write_text("aperture-image heart.png\n")
    bad = rackfocus(*words, by_look, "--look", file, code=2).stderr
    assert "a.params:1: a picture is no parameter; type it beside the file" in bad
    missing = rackfocus(*words, by_look, "--look", tmp_path / "b.params", code=2)
    assert "--look: there is no file" in missing.stderr
    bad = rackfocus(*words, by_look, "--look", "b", code=2).stderr
    assert "your own: rackfocus looks --save b --cat-eye 0.5 keeps one" in bad
    rackfocus("looks", "--save", "mine", "--cat-eye", "1")
    bad = rackfocus(*words, by_look, "--look", "b", code=2).stderr
    assert bad.endswith("miniature, and your own: mine\n")


def test_povray_knows_looks(rackfocus, tmp_path):
    """A name that there is none of, before anything is rendered."""
    out = tmp_path / "out.exr"
    done = rackfocus("povray", "a.pov", "-o", out, "--look", "sharp", code=2)
    assert "there are vintage, anamorphic, mirror" in done.stderr


def test_the_list_and_ones_own(rackfocus, scene, tmp_path, monkeypatch):
    """Saved, listed with its parameters, used; wins over one of the program's."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "new" / "config"))
    given = json.loads(rackfocus("looks", "--json").stdout)
    assert [look["name"] for look in given][:2] == ["vintage", "anamorphic"]
    assert "--swirl 0.35" in given[0]["options"]
    files = Path(__file__).parents[2].glob("looks/*.params")
    assert {file.stem for file in files} == {look["name"] for look in given}
    done = rackfocus("looks", "--save", "mine", "--blades", "5", "--swirl", "0.2")
    assert done.stdout == "--look mine has these parameters from now on\n"
    done = rackfocus("looks", "--save", "fast", "--blades", "7")
    assert "in place of the look of that name that comes with the program; remove" in (
        done.stdout
    )
    assert "new/config/rackfocus/looks/fast.params" in done.stdout
    looks = {x["name"]: x for x in json.loads(rackfocus("looks", "--json").stdout)}
    assert len(looks) == len(given) + 1
    assert "--blades 5" in looks["mine"]["options"]
    assert looks["fast"]["about"] == "your own" and "7" in looks["fast"]["options"]
    assert "mine: your own\n    " in rackfocus("looks").stdout
    own = made(rackfocus, scene, tmp_path, "--look", "mine")
    typed = made(rackfocus, scene, tmp_path, "--blades", "5", "--swirl", "0.2")
    assert numpy.array_equal(own, typed)


def test_a_folder_that_is_no_full_path_is_left_out(rackfocus, tmp_path, monkeypatch):
    """As the XDG specification says: a look was kept below the current folder."""
    monkeypatch.setenv("XDG_CONFIG_HOME", "config")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    rackfocus("looks", "--save", "mine", "--blades", "5", cwd=tmp_path)
    assert (tmp_path / "home/.config/rackfocus/looks/mine.params").exists()
    assert not (tmp_path / "config").exists()


@pytest.mark.parametrize(
    "options, part, code",
    [
        (["--save", "mine"], "nothing is to be kept; add parameters", 2),
        (["--save", "a/b", "--blades", "5"], "'a/b' is no name of a look", 1),
        (["--save", "Con", "--blades", "5"], "such as my-Con", 1),
        (["--save", "lpt1", "--blades", "5"], "a device on Windows", 1),
        (["--blades", "5"], "are kept with --save NAME", 2),
        (["in.exr"], "looks takes no file", 2),
    ],
)
def test_looks_that_cannot_be_kept(rackfocus, options, part, code):
    assert part in rackfocus("looks", *options, code=code).stderr


def halves(path):
    """Light behind the focus and before it."""
    channels = plainexr.read(path)[0]
    light = channels["G"]
    return light[: len(light) // 2], light[len(light) // 2 :]


def test_aperture_draws_lamps(rackfocus, tmp_path):
    """Discs of the radius asked for; cat's eyes cut those at the border, on another
    side before the focus than behind it; a look is its options."""
    out = tmp_path / "lamps.exr"
    words = ("aperture", "-o", out, "--width", "480", "--radius", "20")
    rackfocus(*words)
    for half in halves(out):
        height, width = half.shape
        assert (width, height) == (480, 270)
        lamp = half[
            height // 2 - 30 : height // 2 + 30, width // 2 - 30 : width // 2 + 30
        ]
        assert abs((lamp > 0.25).sum() / (numpy.pi * 20**2) - 1) < 0.02
        assert abs(lamp.sum() / (0.5 * numpy.pi * 20**2) - 1) < 0.01
        plain = (half > 0.25).sum()
    rackfocus(*words, "--cat-eye", "0.8")
    behind, before = halves(out)
    assert (behind > 0.25).sum() < 0.95 * plain
    areas = [(half > 0.25).sum() for half in (behind, before)]
    assert 0.8 < areas[0] / areas[1] < 1.25  # q is that of each pixel
    assert not numpy.array_equal(behind, before), "cut on the other side"
    rackfocus(*words, "--look", "vintage")
    look = halves(out)
    rackfocus(*words, "--cat-eye", "0.6", "--swirl", "0.35", "--astigmatism", "-0.15")
    assert numpy.array_equal(look, halves(out))
    rackfocus("aperture", "-o", tmp_path / "lamps.png")
    assert (tmp_path / "lamps.png").read_bytes()[:4] == b"\x89PNG"


def test_aperture_draws_a_tilted_lens(rackfocus, tmp_path):
    """The radius changes by sin A / (2 N) px for each px, as in a picture of a 50 mm lens.

    Silent before: the lens that --radius makes of a focus at 10 m was one of f/0.07, and
    the light of a lamp lay over half of the sheet. What the filter makes of a lone lamp
    is the same.
    """
    out, size = tmp_path / "lamps.exr", (480, 270)
    words = ("aperture", "-o", out, "--width", size[0], "--radius", "20")
    rackfocus(*words, "--look", "miniature")
    light = halves(out)[0]
    x = size[0] // 2
    places = [int((i + 0.5) * 270 / 3) for i in range(3)]
    areas = [(light[y - 40 : y + 40, x - 30 : x + 30] > 0.2).sum() for y in places]
    radii = numpy.sqrt(numpy.array(areas) / numpy.pi)
    slope = numpy.sin(numpy.radians(8)) / 5.6
    assert numpy.allclose(radii, 20 + slope * (135 - numpy.array(places)), atol=0.3)
    rackfocus(*words, "--look", "miniature", "--f-stop", "1.4")
    assert (halves(out)[0] > 0.2).sum() != (light > 0.2).sum()
    # K / s = 40 px with K = f^2 / (2 N) in px
    focus = 0.05 / 5.6 * size[0] * 50 / 36 / 40
    scene = {c: numpy.zeros(size[::-1], numpy.float32) for c in "RGB"}
    for c in scene.values():
        c[places[0], x] = 0.5 * numpy.pi * 20**2
    scene["Z"] = numpy.full(size[::-1], 2 * focus, numpy.float32)
    path = plainexr.write(tmp_path / "in.exr", scene)
    lens = ("--f-stop", 2.8, "--focus-distance", repr(focus), "--look", "miniature")
    rackfocus("filter", path, "-o", tmp_path / "o.exr", *lens)
    lamp = numpy.s_[: places[0] + 40, x - 30 : x + 30]
    made = plainexr.read(tmp_path / "o.exr")[0]["G"][lamp]
    assert abs(made - light[lamp]).max() < 0.002 and made.max() > 0.3


def test_aperture_of_orthographic_cameras(rackfocus, tmp_path):
    """Refused before, as a depth of nothing; a radius that is cut was not told."""
    out = tmp_path / "lamps.exr"
    words = ("aperture", "-o", out, "--width", "480", "--radius", "20")
    rackfocus(*words)
    want = halves(out)
    rackfocus(*words, "--projection", "orthographic")
    for half, plain in zip(halves(out), want):
        assert abs(half - plain).max() < 0.01
    said = rackfocus(*words[:-3], "100", "--radius", "60").stderr
    assert "--radius 60: the blur is cut at 50 px" in said and "--width 240" in said
    assert rackfocus(*words[:-3], "240", "--radius", "60").stderr == ""


def test_aperture_draws_with_a_picture_of_it(rackfocus, tmp_path):
    """Its right half lets light through: the right half of lamps behind the focus, the
    left one of those before it."""
    out, picture = tmp_path / "lamps.exr", tmp_path / "half.exr"
    light = numpy.zeros((64, 64), numpy.float32)
    light[:, 32:] = 1
    plainexr.write(picture, dict.fromkeys("RGB", light))
    words = ("aperture", "-o", out, "--width", "480", "--radius", "20")
    rackfocus(*words, "--aperture-image", picture)
    for half, side in zip(halves(out), (1, -1)):
        height, width = half.shape
        lamp = half[
            height // 2 - 21 : height // 2 + 21, width // 2 - 21 : width // 2 + 22
        ]
        columns = lamp.sum(0)[::side]
        assert columns[:21].sum() < 0.01 * columns.sum()
    light[:] = 0
    plainexr.write(picture, dict.fromkeys("RGB", light))
    refused = rackfocus(*words, "--aperture-image", picture, code=1).stderr
    assert "half.exr: the picture of the aperture is black" in refused


@pytest.mark.parametrize(
    "options, part",
    [
        ([], "aperture needs an output"),
        (["-o", "x.png", "--aperture", "image"], "--aperture-image FILE"),
        (
            ["-o", "x.png", "--aperture-image", "a.exr", "--aperture", "disc"],
            "--aperture-image: goes with --aperture image, which can be left out",
        ),
        (["-o", "x.jpg"], "x.jpg"),
        (["-o", "x.png", "in.exr"], "takes no file"),
        (["-o", "x.png", "--f-stop", "2"], "--f-stop has no place here: --radius"),
        (["-o", "x.png", "--look", "none"], "there is no such look"),
        (["-o", "x.png", "--radius", "0.5"], "--radius"),
    ],
)
def test_aperture_refuses(rackfocus, options, part):
    assert part in rackfocus("aperture", *options, code=2).stderr


def test_aperture_says_what_it_does_not_read(rackfocus, tmp_path):
    """Silent before; a kind of depth made another picture of the lamps' own depth."""
    plain, out = tmp_path / "a.png", tmp_path / "b.png"
    words = ("aperture", "--width", "200", "-o")
    assert rackfocus(*words, plain, "--blades", "5").stderr == ""
    useless = ("--depth", "inverse", "--focal-length", "90", "--lens-seed", "3")
    said = rackfocus(*words, out, "--blades", "5", *useless).stderr
    assert said.count("has no effect") == 3
    assert out.read_bytes() == plain.read_bytes()
    tilt = ("--tilt-x", "9", "--focal-length", "90", "--shift-x", "0.1")
    assert rackfocus(*words, out, *tilt).stderr == ""


def test_accumulate_says_a_threshold_without_a_gain(rackfocus, scene, tmp_path):
    words = ("accumulate", scene(), scene(), "-o", tmp_path / "o.exr")
    words += ("--highlight-threshold", "3")
    assert "--highlight-threshold: has no effect" in rackfocus(*words).stderr
    assert "no effect" not in rackfocus(*words, "--highlight-gain", "2").stderr


def test_accumulate_takes_of_a_look_what_a_mean_can_have(
    rackfocus, scene, tmp_path, monkeypatch
):
    """The rest is said; a look of which nothing is left is refused, with the way out."""
    folder = tmp_path / "config/rackfocus/looks"
    folder.mkdir(parents=True)
    (folder / "mine.params").write_text(
        "blades 5\nhighlight-threshold 0\nhighlight-gain 3\n"
    )
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    view, by_look, typed = scene(), tmp_path / "look.exr", tmp_path / "typed.exr"
    told = rackfocus("accumulate", view, view, "-o", by_look, "--look", "mine").stderr
    assert "no effect on views that are rendered: blades" in told
    gain = ("--highlight-threshold", "0", "--highlight-gain", "3")
    rackfocus("accumulate", view, view, "-o", typed, *gain)
    made = plainexr.read(by_look)[0]["G"]
    assert numpy.array_equal(made, plainexr.read(typed)[0]["G"])
    rackfocus("accumulate", view, view, "-o", typed)
    assert not numpy.array_equal(made, plainexr.read(typed)[0]["G"])
    won = ("--look", "mine", "--highlight-gain", "1")
    rackfocus("accumulate", view, view, "-o", by_look, *won)
    plain = plainexr.read(typed)[0]["G"]
    assert numpy.allclose(plainexr.read(by_look)[0]["G"], plain, rtol=2e-3)
    rackfocus("accumulate", view, view, "-o", by_look, "--look", "mine", "-q")
    out = tmp_path / "out.exr"
    done = rackfocus("accumulate", view, "-o", out, "--look", "vintage", code=2)
    assert "swirl" in done.stderr and "rackfocus filter" in done.stderr
    assert not out.exists()


@pytest.mark.parametrize(
    "options, key, why",
    [
        (
            "--focus-distance 10 --split-diopter 10",
            "split-diopter",
            "is the focus-dist",
        ),
        ("--split-diopter 3 --split-offset 1.2", "split-offset", "beyond the picture"),
        ("--split-diopter 3 --split-offset 0.5", None, ""),
        ("--highlight-gain 3 --highlight-threshold 1e4", "highlight-gain", "brightest"),
        (
            "--highlight-saturation 0 --highlight-threshold 1e4",
            "highlight-satur",
            "none",
        ),
        ("--highlight-gain 3 --highlight-threshold 0.01", None, ""),
    ],
)
def test_looks_that_change_nothing_here_are_told(
    rackfocus, scene, tmp_path, options, key, why
):
    """Values that are read, and of which this picture has nothing."""
    out, plain = tmp_path / "o.exr", tmp_path / "p.exr"
    lens = "--lens-radius 0.3 --focal-length-px 400 --focus-distance 10".split()
    said = rackfocus("filter", scene(), "-o", out, *lens, *options.split()).stderr
    rackfocus("filter", scene(), "-o", plain, *lens)
    is_same = numpy.array_equal(
        plainexr.read(out)[0]["G"], plainexr.read(plain)[0]["G"]
    )
    assert is_same == (key is not None)
    assert (f"--{key}" in said and why in said) if key else "no effect" not in said


@pytest.mark.parametrize("has_alpha", (False, True))
@pytest.mark.parametrize(
    "option, value",
    (("axial-chroma", 2), ("lateral-chroma", 0.05), ("highlight-saturation", 0)),
)
def test_grey_has_no_colours_to_part(rackfocus, tmp_path, has_alpha, option, value):
    """With alpha the light was that of red alone, 17 dB from the picture."""
    view, out, plain = (tmp_path / f"{name}.exr" for name in ("in", "out", "plain"))
    grey = numpy.full((40, 60), 0.3, numpy.float32)
    grey[::4], grey[20, 30] = 0.6, 50
    alpha = {"A": numpy.ones_like(grey)} if has_alpha else {}
    plainexr.write(view, {"Y": grey, "Z": numpy.full_like(grey, 9), **alpha})
    said = rackfocus("filter", view, "-o", out, *LENS, f"--{option}", str(value)).stderr
    rackfocus("filter", view, "-o", plain, *LENS)
    a, b = plainexr.read(out)[0], plainexr.read(plain)[0]
    assert all(numpy.array_equal(a[name], b[name]) for name in b)
    assert f"--{option}: has no effect: the picture is grey" in said


def test_grey_is_spread_by_all_colours_of_an_aperture(rackfocus, tmp_path):
    """With alpha as without it."""
    aperture, light = tmp_path / "aperture.exr", numpy.zeros((8, 8), numpy.float32)
    light[:, :4] = 1
    plainexr.write(aperture, {"R": light, "G": 1 - light, "B": light * 0 + 1})
    grey = numpy.full((40, 60), 0.3, numpy.float32)
    grey[20, 30] = 50
    made = []
    for alpha in ({}, {"A": numpy.ones_like(grey)}):
        view, out = tmp_path / "in.exr", tmp_path / "out.exr"
        plainexr.write(view, {"Y": grey, "Z": numpy.full_like(grey, 9), **alpha})
        rackfocus("filter", view, "-o", out, *LENS, "--aperture-image", aperture)
        made.append(plainexr.read(out)[0]["Y"].astype(numpy.float32))
    assert numpy.abs(made[0] - made[1]).max() < 0.01 * made[0].max()
