# SPDX-License-Identifier: Apache-2.0
"""What is seen in mirrors and through glass by its own depth: where light and depth
come from, and what is said where they do not."""

import os
import subprocess
from pathlib import Path

import numpy
import plainexr
import pytest
from mirror_room import HEIGHT, MIRROR, ROOM, WALL, WIDTH, room

LENS = ["--focus-distance", "100", "--lens-radius", "1.6", "--focal-length-px", "1000"]
BLENDER = ("GlossDir", "GlossInd", "GlossCol")


def channels(moved=0.0, names=BLENDER, word="Gloss"):
    """A view whose camera stands `moved` lens radii to the right."""
    mirror, light = room(moved)
    made = {"Z": numpy.where(mirror, MIRROR, WALL)}
    for i, c in enumerate("RGB"):
        made[c] = light + numpy.where(mirror, 0.05, 0.2 + 0.1 * i)
        if names is BLENDER:
            made[f"ViewLayer.{word}Dir.{c}"] = 0.25 * light / 0.5
            made[f"ViewLayer.{word}Ind.{c}"] = 0.75 * light / 0.5
            made[f"ViewLayer.{word}Col.{c}"] = numpy.full_like(light, 0.5)
        for name in names if names is not BLENDER else ():
            made[f"{name}.{c}"] = light
    return made


def pictures(tmp_path, **options):
    """The picture and a second view, 0.9 lens radii to the right."""
    place = {"rackfocus:lensOffset": (1.44, 0.0), "rackfocus:shearDistance": 100.0}
    first = plainexr.write(tmp_path / "passes.exr", channels(**options))
    second = plainexr.write(tmp_path / "second.exr", channels(0.9, **options), place)
    return first, second


@pytest.fixture
def run(rackfocus, tmp_path):
    def run_filter(*arguments, code=0, name="out.exr"):
        words = ("filter", *arguments, "-o", tmp_path / name, *LENS, "--type", "float")
        return rackfocus(*words, code=code)

    return run_filter


def contrast(path):
    """How much of the pattern is left in the middle of the mirror."""
    return plainexr.read(path)[0]["G"][24:40, 34:62].std()


def test_a_second_view_gives_the_depth(run, tmp_path):
    first, second = pictures(tmp_path)
    run(first, name="plain.exr")
    done = run(first, "--reflections-from", second)
    assert ", reflections: 50.0 % of the picture by its own depth" in done.stdout
    assert "through glass" not in done.stdout
    plain, own = contrast(tmp_path / "plain.exr"), contrast(tmp_path / "out.exr")
    assert plain > 0.1 and own < plain / 4


@pytest.mark.parametrize("name", ["reflection", "specular", "ViewLayer.Specular"])
def test_layers_of_other_renderers(run, tmp_path, name):
    first, second = pictures(tmp_path, names=(name,))
    done = run(first, "--reflections-from", second)
    assert "reflections: 50.0 %" in done.stdout


def test_glass_is_told_by_its_layers(run, tmp_path):
    first, second = pictures(tmp_path, word="Trans")
    done = run(first, "--reflections-from", second)
    assert "through glass: 50.0 %" in done.stdout
    assert "reflections:" not in done.stdout


def test_layers_may_be_named_and_add_up(run, tmp_path):
    first, second = pictures(tmp_path, names=("coat", "sheen"))
    one = run(first, "--reflections-from", second, "--reflection-layers", "coat")
    assert "reflections: 50.0 %" in one.stdout
    run(
        *(first, "--reflections-from", second, "--reflection-layers", "coat,sheen"),
        name="both.exr",
    )
    a, b = (plainexr.read(tmp_path / n)[0]["G"] for n in ("out.exr", "both.exr"))
    assert not numpy.array_equal(a, b)


def test_the_place_may_be_said(run, tmp_path):
    first, second = pictures(tmp_path)
    run(first, "--reflections-from", second, name="header.exr")
    bare = tmp_path / "bare.exr"
    plainexr.write(bare, channels(0.9))
    done = run(first, "--reflections-from", bare, code=1)
    assert "rackfocus:lensOffset" in done.stderr
    assert "--reflections-at X,Y" in done.stderr
    for text in ("0.1", "0.1,", "a,b", "nan,0", "0.1,0 0"):
        done = run(
            *(first, "--reflections-from", bare, "--reflections-at", text), code=2
        )
        assert "two numbers for each view" in done.stderr
    done = run(first, "--reflections-at", "1,0", code=2)
    assert "--reflections-from" in done.stderr
    # Sheared views: the same place, said of a camera that was sheared like the first.
    shear = {"rackfocus:lensOffset": (0.0, 0.0), "rackfocus:shearDistance": 100.0}
    first = plainexr.write(tmp_path / "sheared.exr", channels(), shear)
    run(first, "--reflections-from", bare, "--reflections-at", "1.44,0")
    a, b = (plainexr.read(tmp_path / n)[0]["G"] for n in ("header.exr", "out.exr"))
    assert numpy.allclose(a, b, atol=1e-3)  # 1.44 is a float there, a double here


def test_several_views(run, tmp_path):
    first, second = pictures(tmp_path)
    place = {"rackfocus:lensOffset": (-1.44, 0.0), "rackfocus:shearDistance": 100.0}
    third = plainexr.write(tmp_path / "third.exr", channels(-0.9), place)
    done = run(first, "--reflections-from", f"{second},{third}")
    assert "reflections: 50.0 %" in done.stdout


MOVED = (-0.75, -0.25, 0.25, 0.75)  # views from left to right on the lens


def place(moved, view=""):
    """What the header says of a view."""
    return {
        f"rackfocus:lensOffset{view}": (1.6 * moved, 0.0),
        f"rackfocus:shearDistance{view}": 100.0,
    }


def view_channels(moved):
    """Those of a view that also knows how far away the room is."""
    made = channels(moved)
    made["seen.Z"] = numpy.where(made["Z"] == MIRROR, ROOM, 0)
    way = numpy.where(made["Z"] == MIRROR, ROOM, made["Z"])
    return made | {"ViewLayer.Denoising Depth.Z": way}


def views_of(tmp_path):
    """A file for each view."""
    return [
        plainexr.write(tmp_path / f"view{i}.exr", view_channels(moved), place(moved))
        for i, moved in enumerate(MOVED)
    ]


def shared(tmp_path):
    """The views in one part of a file: "LAYER.VIEW.C", and of the first "LAYER.C"."""
    names = [f"v{i}" for i in range(len(MOVED))]
    made, attributes = {}, {"multiView": names}
    for name, moved in zip(names, MOVED, strict=True):
        for channel, samples in view_channels(moved).items():
            *words, letter = channel.split(".")
            words += [name] if name != names[0] else []
            made[".".join([*words, letter])] = samples
        attributes |= place(moved, f".{name}")
    return plainexr.write(tmp_path / "shared.exr", made, attributes)


@pytest.mark.parametrize(
    "asked", ["--reflections-from views", "--reflection-depth seen.Z"]
)
def test_views_tell_each_others_reflections(run, tmp_path, asked):
    """Beyond the room's own radius no view shows a copy of the pattern any more."""
    paths = views_of(tmp_path)
    run(*paths, name="plain.exr")
    done = run(*paths, *asked.split())
    share = float(done.stdout.split("reflections: ")[1].split()[0])
    assert 45 < share < 55
    run(paths[0], "--reflection-depth", "seen.Z", name="one.exr")
    plain, own, one = (
        contrast(tmp_path / name) for name in ("plain.exr", "out.exr", "one.exr")
    )
    assert own < plain / 2
    assert abs(own - one) < 0.02


@pytest.mark.parametrize(
    "asked", ["--reflections-from views", "--reflection-depth denoising"]
)
def test_views_in_one_file_have_lights_of_their_own(run, tmp_path, asked):
    path = shared(tmp_path)
    done = run(path, *asked.split())
    run(*views_of(tmp_path), *asked.split(), name="apart.exr")
    assert 45 < float(done.stdout.split("reflections: ")[1].split()[0]) < 55
    a, b = (plainexr.read(tmp_path / name)[0] for name in ("out.exr", "apart.exr"))
    assert all(numpy.array_equal(a[c], b[c]) for c in "RGB")
    done = run(path, "--reflection-depth", "seen.Z", code=2)
    assert "holds several views" in done.stderr


def test_views_are_asked_as_views(run, tmp_path):
    first, second = pictures(tmp_path)
    paths = views_of(tmp_path)
    for words, code, text in (
        ((first, "--reflections-from", "views"), 2, "passes.exr is one view"),
        ((*paths, "--reflections-from", second), 2, "give --reflections-from views"),
        (
            (*paths, "--reflections-from", "views", "--reflections-at", "1,0"),
            2,
            "leave it out",
        ),
        (
            (*paths, "--reflection-depth", second),
            2,
            "every view needs a channel of its own",
        ),
    ):
        done = run(*words, code=code)
        assert text in done.stderr
        assert not (tmp_path / "out.exr").exists()
    bare = {n: a for n, a in channels(0.75).items() if "Gloss" not in n}
    paths[3] = plainexr.write(tmp_path / "bare.exr", bare, place(0.75))
    done = run(*paths, "--reflections-from", "views", code=1)
    assert "bare.exr: has no layers of what is seen in mirrors" in done.stderr


@pytest.mark.parametrize("is_file", [False, True])
def test_a_depth_of_what_is_seen(run, tmp_path, is_file):
    made = channels()
    seen = numpy.where(made["Z"] == MIRROR, ROOM, 0)
    if is_file:
        name = plainexr.write(tmp_path / "seen.exr", {"Z": seen})
    else:
        name = "seen.Z"
        made[name] = seen
    path = plainexr.write(tmp_path / "passes.exr", made)
    run(path, name="plain.exr")
    done = run(path, "--reflection-depth", name)
    assert "reflections: 50.0 %" in done.stdout
    assert contrast(tmp_path / "out.exr") < contrast(tmp_path / "plain.exr") / 4


@pytest.mark.parametrize("clip, scale", [(0, 1), (0, 10), (20, 1), (100, 1)])
def test_the_way_of_the_rays(run, tmp_path, clip, scale):
    """Cycles' Denoising Depth: along the ray, from the near clip on, anti-aliased."""
    made = channels()
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    ray = numpy.hypot(numpy.hypot(x - WIDTH / 2, y - HEIGHT / 2) / 1000, 1)
    made["ViewLayer.Denoising Depth.Z"] = (
        (numpy.where(made["Z"] == MIRROR, ROOM, made["Z"] * 1.001) - clip) * ray / scale
    )
    seen = numpy.where(made["Z"] == MIRROR, ROOM, 0) / scale
    made["Z"] = made["Z"] / scale
    path = plainexr.write(tmp_path / "passes.exr", made)
    unit = ("--depth-scale", scale)
    done = run(path, "--reflection-depth", "denoising", *unit)
    assert "reflections: 50.0 %" in done.stdout
    name = plainexr.write(tmp_path / "seen.exr", {"Z": seen})
    run(path, "--reflection-depth", name, *unit, name="planar.exr")
    a, b = (plainexr.read(tmp_path / n)[0]["G"] for n in ("out.exr", "planar.exr"))
    assert numpy.allclose(a, b, atol=1e-4)
    del made["ViewLayer.Denoising Depth.Z"]
    path = plainexr.write(tmp_path / "bare.exr", made)
    done = run(path, "--reflection-depth", "denoising", code=1)
    assert "Passes > Data > Denoising Data" in done.stderr


def bytes_read(command):
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
    try:
        facts = Path(f"/proc/{child.pid}/io").read_text()
    except OSError:
        facts = ""
    assert child.wait() == 0
    if not facts:
        pytest.skip("this system does not say how much a process has read")
    return int(facts.split("rchar: ")[1].split()[0])


def test_lights_are_decoded_once(run, binary, tmp_path):
    """Each chunk holds all layers: nine times the file, where each layer was read by
    itself, and each light by the other, too, 19 times. Taller than what is read at once.
    """
    made = channels() | channels(word="Trans")
    for c in "RGB":
        made[f"ViewLayer.TransDir.{c}"] *= 0.1
        made[f"ViewLayer.TransInd.{c}"] *= 0.1
    for c in "XYZ":
        made[f"ViewLayer.Denoising Normal.{c}"] = numpy.full_like(made["Z"], 0.6)
    tall = {name: numpy.tile(a, (9, 1)) for name, a in made.items()}
    mirror = tall["Z"] == MIRROR
    y, x = numpy.mgrid[0 : 9 * HEIGHT, 0:WIDTH] + 0.5
    ray = numpy.hypot(numpy.hypot(x - WIDTH / 2, y - 4.5 * HEIGHT) / 1000, 1)
    tall["ViewLayer.Denoising Depth.Z"] = ray * numpy.where(mirror, ROOM, tall["Z"])
    path = plainexr.write(tmp_path / "passes.exr", tall)
    run(path, name="plain.exr")
    ways = ("--reflection-depth", "denoising", "--transmission-depth", "denoising")
    command = [binary, "filter", path, "-o", tmp_path / "out.exr", *LENS, *ways]
    assert bytes_read(command) < 12 * os.path.getsize(path)
    for k in (0, 5, 8):
        own, plain = (
            plainexr.read(tmp_path / n)[0]["G"][k * HEIGHT :][24:40, 34:62].std()
            for n in ("out.exr", "plain.exr")
        )
        assert plain > 0.1 and own < plain / 4


def test_sky_in_a_mirror_is_far(run, tmp_path):
    """Cycles counts nothing for rays that hit nothing; they give no normal."""
    made = channels()
    mirror = made["Z"] == MIRROR
    made["ViewLayer.Denoising Depth.Z"] = made["Z"] * 1.0
    sky = plainexr.write(tmp_path / "sky.exr", {"Z": numpy.where(mirror, 1e10, 0)})
    for length in (0, 1):  # a rough mirror has one
        for c, part in zip("XYZ", (0.6, 0, -0.8), strict=True):
            normal = numpy.where(mirror, length * part, part)
            made[f"ViewLayer.Denoising Normal.{c}"] = normal
        path = plainexr.write(tmp_path / "passes.exr", made)
        plain = run(path, name="plain.exr")
        done = run(path, "--reflection-depth", "denoising")
        if length == 1:
            assert "nothing seen in mirrors" in done.stderr
            assert "mirrors" not in plain.stderr
            continue
        assert "reflections: 50.0 %" in done.stdout
        assert "50 % of the picture is seen in flat mirrors" in plain.stderr
        assert ", and blurred by the distance of these; --reflect" in plain.stderr
        assert "mirrors" not in done.stderr
        run(path, "--reflection-depth", sky, name="far.exr")
        a, b = (plainexr.read(tmp_path / n)[0]["G"] for n in ("out.exr", "far.exr"))
        assert numpy.allclose(a, b, atol=1e-4)


@pytest.mark.parametrize("has_light", [False, True])
def test_mirrors_that_nobody_asked_for_are_told(run, tmp_path, has_light):
    made = {n: a for n, a in channels().items() if has_light or "Gloss" not in n}
    flat = numpy.full_like(made["Z"], WALL)
    made["ViewLayer.Denoising Depth.Z"] = numpy.where(
        made["Z"] == MIRROR, ROOM, made["Z"]
    )
    path = plainexr.write(tmp_path / "passes.exr", made)
    said = run(path, "--reflection-depth", "denoising").stderr if has_light else ""
    assert "blurred by the distance" not in said
    said = run(path).stderr
    assert "50 % of the picture is seen in flat mirrors" in said
    assert ("save Passes > Light > Glossy" in said) != has_light
    made |= {"Z": flat, "ViewLayer.Denoising Depth.Z": flat}
    path = plainexr.write(tmp_path / "passes.exr", made)
    assert "flat mirrors" not in run(path).stderr


def test_a_frame_of_sky_alone(run, tmp_path):
    made = channels()
    made["Z"] = numpy.full_like(made["Z"], 1e10)
    made["ViewLayer.Denoising Depth.Z"] = numpy.zeros_like(made["Z"])
    path = plainexr.write(tmp_path / "passes.exr", made)
    assert "mirrors" not in run(path).stderr
    done = run(path, "--reflection-depth", "denoising")
    assert "nothing seen in mirrors" in done.stderr


def test_a_way_is_that_of_the_stronger_light(run, tmp_path):
    made = channels()
    made["ViewLayer.Denoising Depth.Z"] = numpy.where(
        made["Z"] == MIRROR, ROOM, made["Z"]
    )
    for c in "RGB":
        made[f"ViewLayer.TransInd.{c}"] = made[f"ViewLayer.GlossInd.{c}"] / 10
        made[f"ViewLayer.TransDir.{c}"] = made[f"ViewLayer.GlossDir.{c}"] / 10
        made[f"ViewLayer.TransCol.{c}"] = made[f"ViewLayer.GlossCol.{c}"]
    path = plainexr.write(tmp_path / "passes.exr", made)
    both = ("--reflection-depth", "denoising", "--transmission-depth", "denoising")
    done = run(path, *both)
    assert "reflections: 50.0 %" in done.stdout
    assert "through glass: 0.0 %" in done.stdout


def test_a_layer_that_is_missing_is_named(run, tmp_path):
    first, second = pictures(tmp_path)
    bare = {n: a for n, a in channels().items() if "Gloss" not in n}
    path = plainexr.write(tmp_path / "bare.exr", bare)
    done = run(path, "--reflections-from", second, code=1)
    assert "has no light of mirrors or glass" in done.stderr
    assert "Glossy and Transmission: Direct, Indirect, Color" in done.stderr
    assert "--reflection-layers" in done.stderr
    place = {"rackfocus:lensOffset": (1.44, 0.0)}
    path = plainexr.write(tmp_path / "second_bare.exr", bare, place)
    done = run(first, "--reflections-from", path, code=1)
    assert "second_bare.exr: has no layers of what is seen in mirrors" in done.stderr
    done = run(
        *(first, "--reflections-from", second, "--reflection-layers", "spec"), code=1
    )
    assert "no channels spec.R, .G and .B" in done.stderr
    done = run(first, "--reflection-depth", "seen.Z", code=1)
    assert "seen.Z" in done.stderr
    done = run(first, "--reflection-layers", "GlossInd", code=2)
    assert "--reflections-from VIEW.exr" in done.stderr


def test_views_must_be_alike(run, tmp_path):
    first, _ = pictures(tmp_path)
    small = {n: a[:32] for n, a in channels(0.9).items()}
    place = {"rackfocus:lensOffset": (1.44, 0.0)}
    path = plainexr.write(tmp_path / "small.exr", small, place)
    done = run(first, "--reflections-from", path, code=1)
    assert "is 96 x 32" in done.stderr and "96 x 64" in done.stderr
    place = {"rackfocus:lensOffset": (0.0, 0.0)}
    path = plainexr.write(tmp_path / "same.exr", channels(), place)
    done = run(first, "--reflections-from", path, code=1)
    assert "one point of the lens" in done.stderr


def test_nothing_found_is_said(run, tmp_path):
    place = {"rackfocus:lensOffset": (1.44, 0.0), "rackfocus:shearDistance": 100.0}
    even = [{n: numpy.minimum(a, 0.3) if "Z" not in n else a for n, a in c.items()}
            for c in (channels(), channels(0.9))]  # fmt: skip
    for made in even:
        for name, samples in made.items():
            if "GlossDir" in name or "GlossInd" in name:
                samples[samples > 0] = 0.3
    first = plainexr.write(tmp_path / "even.exr", even[0])
    second = plainexr.write(tmp_path / "even_second.exr", even[1], place)
    run(first, name="plain.exr")
    done = run(first, "--reflections-from", second)
    assert "nothing seen in mirrors has a depth of its own" in done.stderr
    assert (tmp_path / "plain.exr").read_bytes()[-1000:] == (
        tmp_path / "out.exr"
    ).read_bytes()[-1000:]


@pytest.mark.parametrize(
    "arguments", [["--over"], ["--stereo"], ["--temporal", "1"], ["--preset", "shot"]]
)
def test_what_it_does_not_go_together_with(rackfocus, tmp_path, arguments):
    first, second = pictures(tmp_path)
    out = tmp_path / ("out_%V.exr" if "--stereo" in arguments else "out.exr")
    inputs = [first] if arguments[0] in ("--temporal", "--preset") else [first, second]
    if len(inputs) == 1:
        plainexr.write(tmp_path / "shot.0001.exr", channels())
        inputs, out = [tmp_path / "shot.####.exr"], tmp_path / "made.####.exr"
    done = rackfocus(
        *(
            "filter",
            *inputs,
            "-o",
            out,
            *arguments,
            "--reflections-from",
            second,
            *LENS,
        ),
        code=2,
    )
    assert "reflection" in done.stderr


def test_a_sequence_takes_a_second_view_per_frame(rackfocus, tmp_path):
    for frame in (1, 2):
        first, second = pictures(tmp_path)
        Path(first).rename(tmp_path / f"shot.000{frame}.exr")
        Path(second).rename(tmp_path / f"second.000{frame}.exr")
    words = ("filter", tmp_path / "shot.####.exr", "-o", tmp_path / "out.####.exr")
    words += ("--reflections-from", tmp_path / "second.####.exr", *LENS)
    rackfocus(*words)
    frames = [plainexr.read(tmp_path / f"out.000{i}.exr")[0]["G"] for i in (1, 2)]
    assert numpy.array_equal(*frames)
    # Another second view is another result; the same is none.
    times = [(tmp_path / f"out.000{i}.exr").stat().st_mtime_ns for i in (1, 2)]
    place = {"rackfocus:lensOffset": (1.44, 0.0), "rackfocus:shearDistance": 100.0}
    plainexr.write(tmp_path / "second.0002.exr", channels(0.9, names=BLENDER), place)
    made = channels(0.9)
    made["more"] = made["R"]
    plainexr.write(tmp_path / "second.0002.exr", made, place)
    rackfocus(*words)
    again = [(tmp_path / f"out.000{i}.exr").stat().st_mtime_ns for i in (1, 2)]
    assert again[0] == times[0] and again[1] != times[1]
