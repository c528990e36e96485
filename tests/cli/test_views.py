# SPDX-License-Identifier: Apache-2.0
"""Several views of one scene: which inputs are views, and what becomes of them."""

import json

import numpy
import plainexr
import pytest
from machine import peak_of

LENS = {
    "rackfocus:lensRadius": 0.2,
    "rackfocus:focalLengthPx": 50.0,
    "rackfocus:focusDistance": 6.0,
}
PLACES = [(0.05, 0.0), (-0.06, 0.09), (0.0, -0.16)]


@pytest.fixture
def views(scene):
    """Three views; their pixels are those of one, which is good enough here."""

    def make(**options):
        return [
            scene(
                f"v{i:02}.exr",
                attributes=LENS
                | {"rackfocus:lensOffset": place, "rackfocus:shearDistance": 6.0},
                **options,
            )
            for i, place in enumerate(PLACES)
        ]

    return make


def facts(rackfocus, path):
    return json.loads(rackfocus("info", path, "--json").stdout)


def test_views_are_recognised(rackfocus, views, tmp_path):
    paths = views()
    chosen, named = tmp_path / "chosen.exr", tmp_path / "named.exr"
    rackfocus("filter", *paths, "-o", chosen)
    rackfocus("filter", *paths, "-o", named, "--method", "views")
    assert chosen.read_bytes() == named.read_bytes()
    assert b"--method views" in chosen.read_bytes()


def test_views_can_be_averaged(rackfocus, views, tmp_path):
    """The mean that the method accumulate and the command of that name make is one."""
    paths = views()
    rackfocus("filter", *paths, "-o", tmp_path / "a.exr", "--method", "accumulate",
              "--type", "float")  # fmt: skip
    rackfocus("accumulate", *paths, "-o", tmp_path / "b.exr")
    a, b = (plainexr.read(tmp_path / f"{name}.exr")[0] for name in "ab")
    for name in "RGB":
        assert a[name] == pytest.approx(b[name], rel=1e-6)


@pytest.mark.parametrize(
    "option",
    [
        ("focus-distance", 3),
        ("lens-radius", 0.3),
        ("focal-length-px", 70),
        ("pixel-aspect", 2),
        ("coc-limit", 2),
        ("blades", 6),
        ("aperture-ratio", 2),
        ("lens-pattern", "polygon"),
        ("aperture-at", "0.01,0"),
    ],
)
def test_a_mean_has_the_lens_of_its_views(rackfocus, views, tmp_path, option):
    """What is typed of the lens changes nothing, and the user is told."""
    paths, mean = views(), ["--method", "accumulate"]
    typed = [f"--{option[0]}", option[1]]
    plain = rackfocus("filter", *paths, "-o", tmp_path / "a.exr", *mean)
    told = rackfocus("filter", *paths, "-o", tmp_path / "b.exr", *mean, *typed)
    assert plain.stderr == ""
    assert f"--{option[0]}: has no effect: " in told.stderr
    a, b = (plainexr.read(tmp_path / f"{name}.exr")[0] for name in "ab")
    assert all((a[name] == b[name]).all() for name in "RGB")
    rackfocus("filter", *paths, "-o", tmp_path / "c.exr", *mean, *typed, "--strict",
              code=1)  # fmt: skip


@pytest.mark.parametrize("place", ["0.5,0", "0,-0.6", "7,7"])
def test_no_view_near_the_aperture_is_an_error(rackfocus, views, tmp_path, place):
    out = tmp_path / "o.exr"
    arguments = ["filter", *views(), "-o", out, "--lens-radius", "0.01"]
    done = rackfocus(*arguments, f"--aperture-at={place}", code=2)
    assert f"--aperture-at: no view saw the scene from near {place}" in done.stderr
    assert "they lie within 0.137 of -0.00333,-0.0233" in done.stderr
    assert "give a place within 0.147 of that" in done.stderr
    assert not out.exists()


def test_an_aperture_beside_the_views_is_warned_of(rackfocus, views, tmp_path):
    arguments = ["filter", *views(), "-o", tmp_path / "o.exr", "--aperture-at=0.3,0"]
    beside = rackfocus(*arguments, "--lens-radius", "0.01").stderr
    assert "--aperture-at: an aperture of radius 0.01 at 0.3,0 is beside" in beside
    assert rackfocus(*arguments, "--lens-radius", "0.2").stderr == ""
    arguments[-1] = "--aperture-at=0.1,-0.1"
    assert rackfocus(*arguments, "--lens-radius", "0.01").stderr == ""


def test_a_preview_says_whose_view_it_is(rackfocus, views, tmp_path):
    """One view, as it was taken, wherever the aperture is: silent before."""
    words = ["filter", *views(), "-o", tmp_path / "o.exr", "--focus-distance", "1"]
    words.append("--quality")
    said = rackfocus(*words, "preview").stderr
    assert (
        "--quality preview: shows the nearest of the views alone, taken 0.05 b" in said
    )
    said = rackfocus(*words, "preview", "--aperture-at=0.02,0.01").stderr
    assert "taken 0.0316 beside the middle" in said
    right = ["--aperture-at=0.05,0", "--lens-radius", "0.01"]
    assert rackfocus(*words, "preview", *right).stderr == ""
    assert rackfocus(*words, "normal").stderr == ""


def test_a_mean_says_what_it_is(rackfocus, views, tmp_path):
    mean = ["--method", "accumulate"]
    done = rackfocus("filter", *views(), "-o", tmp_path / "o.exr", *mean)
    assert f"{tmp_path / 'o.exr'}: mean of 3 views, method accumulate" in done.stdout


def test_a_means_radii_are_of_the_lens_that_is_typed(rackfocus, views, tmp_path):
    arguments = ["filter", *views(), "-o", tmp_path / "o.exr", "--method", "accumulate"]
    radii = []
    for radius in (0.1, 0.2):
        path = tmp_path / f"coc{radius}.exr"
        done = rackfocus(*arguments, "--output-coc", path, "--lens-radius", radius)
        assert done.stderr == ""
        radii.append(plainexr.read(path)[0])
    assert any((radii[0][name] != radii[1][name]).any() for name in radii[0])


def test_one_view_is_no_lens(rackfocus, views, tmp_path):
    """Its mean is the pinhole picture, which would look like a broken command."""
    path = views()[0]
    out = tmp_path / "one.exr"
    done = rackfocus("accumulate", path, "-o", out)
    assert "nothing is blurred" in done.stderr and "views" in done.stderr
    assert "blurred" not in rackfocus("accumulate", "-q", path, "-o", out).stderr


def test_one_view_is_layered(rackfocus, views, tmp_path):
    first = views()[0]
    for method in ("views", "layered"):
        rackfocus("filter", first, "-o", tmp_path / f"{method}.exr", "--method", method)
    a, b = (
        plainexr.read(tmp_path / f"{method}.exr")[0] for method in ("views", "layered")
    )
    assert all(numpy.array_equal(a[name], b[name]) for name in "RGB")


def test_a_preview_takes_the_view_nearest_to_the_centre(rackfocus, scene, tmp_path):
    def darker(channels):
        channels["R"] *= numpy.float32(0.5)

    paths = [
        scene(
            f"v{i}.exr",
            attributes=LENS | {"rackfocus:lensOffset": place},
            change=darker if i == 1 else None,
        )
        for i, place in enumerate([(0.05, 0.1), (-0.02, 0.01), (0.0, -0.16)])
    ]
    preview = ["--quality", "preview", "--type", "float"]
    rackfocus("filter", *paths, "-o", tmp_path / "all.exr", *preview)
    rackfocus("filter", paths[1], "-o", tmp_path / "one.exr", *preview)
    a, b = (plainexr.read(tmp_path / f"{name}.exr")[0] for name in ("all", "one"))
    assert all(numpy.array_equal(a[name], b[name]) for name in "RGB")


def test_another_focus_gives_another_picture(rackfocus, views, tmp_path):
    paths = views()
    pictures = []
    for focus in (3, 12):
        out = tmp_path / f"{focus}.exr"
        rackfocus("filter", *paths, "-o", out, "--focus-distance", focus)
        pictures.append(plainexr.read(out)[0]["G"].astype(float))
    assert numpy.abs(pictures[0] - pictures[1]).max() > 0.1


def test_threads_do_not_change_a_bit(rackfocus, views, tmp_path):
    paths = views()
    for n in (1, 2):
        rackfocus("filter", *paths, "-o", tmp_path / f"{n}.exr", "-j", n)
    assert (tmp_path / "1.exr").read_bytes() == (tmp_path / "2.exr").read_bytes()


def test_info_shows_the_place(rackfocus, views):
    path = views()[1]
    view = facts(rackfocus, path)["view"]
    assert view["lens_offset"] == pytest.approx([-0.06, 0.09])
    assert view["shear_distance"] == 6
    assert "(-0.06, 0.09) on the lens" in rackfocus("info", path).stdout


def test_the_result_is_no_view(rackfocus, views, tmp_path):
    out = tmp_path / "out.exr"
    rackfocus("filter", *views(), "-o", out)
    found = facts(rackfocus, out)
    assert found["filtered"]
    assert "view" not in found


def test_the_camera_is_that_of_the_first(rackfocus, views, scene, tmp_path):
    paths = views()
    other = scene(
        "other.exr",
        attributes=LENS
        | {"rackfocus:lensOffset": PLACES[1], "rackfocus:focusDistance": 3.0},
    )
    rackfocus("filter", paths[0], other, "-o", tmp_path / "out.exr")
    assert facts(rackfocus, tmp_path / "out.exr")["parameters"]["focus-distance"][
        "value"
    ] == pytest.approx(6)


def test_a_method_of_one_view_is_refused(rackfocus, views, tmp_path):
    done = rackfocus(
        "filter", *views(), "-o", tmp_path / "o.exr", "--method", "layered", code=2
    )
    assert "--method: layered takes one view, and here are 3" in done.stderr


def test_a_file_that_is_no_view_is_named(rackfocus, views, scene, tmp_path):
    plain = scene("plain.exr")
    done = rackfocus("filter", *views(), plain, "-o", tmp_path / "o.exr", code=1)
    assert "plain.exr: is no view" in done.stderr


def test_no_views_at_all(rackfocus, scene, tmp_path):
    plain = scene("plain.exr")
    done = rackfocus("filter", plain, plain, plain, "-o", tmp_path / "o.exr", code=2)
    assert "rackfocus:lensOffset" in done.stderr


def test_depth_of_their_own(rackfocus, views, tmp_path):
    paths = views()
    rackfocus(
        "filter", *paths, "--depth-file", paths[0], "-o", tmp_path / "o.exr", code=2
    )


def test_sizes_must_agree(rackfocus, views, scene, tmp_path):
    small = scene(
        "small.exr", size=(40, 32), attributes={"rackfocus:lensOffset": (0.1, 0.0)}
    )
    done = rackfocus("filter", *views(), small, "-o", tmp_path / "o.exr", code=1)
    assert "small.exr: is 40 x 32" in done.stderr


def test_too_many(rackfocus, views, tmp_path):
    done = rackfocus("filter", *views() * 22, "-o", tmp_path / "o.exr", code=2)
    assert "64 views at most" in done.stderr


def test_the_bad_view_is_named(rackfocus, views, scene, tmp_path):
    def spoil(channels):
        channels["Z"][5, 7] = numpy.nan

    bad = scene(
        "bad.exr", attributes={"rackfocus:lensOffset": (0.1, 0.0)}, change=spoil
    )
    done = rackfocus("filter", *views(), bad, "-o", tmp_path / "o.exr", code=1)
    assert "bad.exr" in done.stderr
    assert "(7, 5)" in done.stderr


NAMES = ["v00", "v01", "v02"]


@pytest.fixture
def shared(views, tmp_path):
    """The views in one file of one part, after OpenEXR's multi-view convention."""

    def make(without=None, is_first_bare=False, **options):
        channels = {}
        attributes = LENS | {"multiView": NAMES}
        for name, path, place in zip(NAMES, views(**options), PLACES, strict=True):
            prefix = "" if is_first_bare and name == NAMES[0] else f"{name}."
            for channel, plane in plainexr.read(path)[0].items():
                channels[prefix + channel] = plane
            if name != without:
                attributes[f"rackfocus:lensOffset.{name}"] = place
                attributes[f"rackfocus:shearDistance.{name}"] = 6.0
        return plainexr.write(tmp_path / "shared.exr", channels, attributes)

    return make


@pytest.mark.parametrize("is_first_bare", [False, True])
def test_one_file_is_the_same_as_three(
    rackfocus, views, shared, tmp_path, is_first_bare
):
    path = shared(is_first_bare=is_first_bare)
    one, three = tmp_path / "one.exr", tmp_path / "three.exr"
    rackfocus("filter", path, "-o", one)
    rackfocus("filter", *views(), "-o", three)
    a, attributes = plainexr.read(one)
    b, _ = plainexr.read(three)
    assert sorted(a) == sorted(b)
    assert all(numpy.array_equal(a[name], b[name]) for name in b)
    assert not [name for name in attributes if "lensOffset" in name]
    assert "multiView" not in attributes


def test_info_lists_the_views(rackfocus, shared):
    path = shared()
    found = facts(rackfocus, path)["views"]
    assert [view["name"] for view in found] == NAMES
    offsets = numpy.array([view["lens_offset"] for view in found])
    assert offsets == pytest.approx(numpy.array(PLACES))
    assert "(-0.06, 0.09) on the lens" in rackfocus("info", path).stdout


def test_layer_names_a_view(rackfocus, views, shared, tmp_path):
    path = shared()
    picked, alone = tmp_path / "picked.exr", tmp_path / "alone.exr"
    rackfocus("filter", path, "--layer", "v01", "-o", picked)
    rackfocus("filter", views()[1], "-o", alone)
    a, b = plainexr.read(picked)[0], plainexr.read(alone)[0]
    assert all(numpy.array_equal(a[name], b[name]) for name in "RGB")
    assert plainexr.read(picked)[1]["view"] == "v01"


def test_a_view_without_its_place_is_named(rackfocus, shared, tmp_path):
    path = shared(without="v01")
    done = rackfocus("filter", path, "-o", tmp_path / "o.exr", code=1)
    assert "no rackfocus:lensOffset for the view v01" in done.stderr


def test_one_file_of_views_cannot_pass_through(rackfocus, shared, tmp_path):
    done = rackfocus(
        "filter", shared(), "--pass-through", "-o", tmp_path / "o.exr", code=2
    )
    assert "--pass-through" in done.stderr


def test_the_bound_on_memory_holds(rackfocus, views, tmp_path):
    out = tmp_path / "o.exr"
    done = rackfocus("filter", *views(), "-o", out, "--max-memory", 1, code=1)
    assert "--max-memory: 1 MiB are too few" in done.stderr
    assert not out.exists()
    rackfocus("filter", *views(), "-o", out, "--max-memory", 1000)
    bounded = out.read_bytes()
    rackfocus("filter", *views(), "-o", out)
    assert bounded == out.read_bytes()


TALL = (250, 4301)
FAST = ("--sub-apertures", 1, "--type", "float")


@pytest.mark.parametrize("is_one_file", [False, True])
def test_views_in_windows_have_the_pixels_of_the_whole(
    rackfocus, views, shared, tmp_path, is_one_file
):
    paths = [shared(size=TALL)] if is_one_file else views(size=TALL)
    whole, windows = tmp_path / "whole.exr", tmp_path / "windows.exr"
    place = ("--aperture-at", "0.01,-0.02", "--lens-radius", 0.15)
    rackfocus("filter", *paths, "-o", whole, *FAST, *place)
    rackfocus("filter", *paths, "-o", windows, *FAST, *place, "--max-memory", 140)
    (a, about), (b, of_whole) = plainexr.read(windows), plainexr.read(whole)
    assert about == of_whole and a.keys() == b.keys()
    assert all(numpy.array_equal(a[name], b[name]) for name in b)
    # A PNG is made of a whole picture, for which that memory is not enough.
    png = tmp_path / "whole.png"
    done = rackfocus("filter", *paths, "-o", png, *FAST, "--max-memory", 140, code=1)
    assert "--max-memory: 140 MiB are too few" in done.stderr


def test_many_views_of_a_large_picture_keep_the_bound(binary, scene, tmp_path):
    paths = []
    for i in range(8):
        place = (0.19 * numpy.cos(i), 0.19 * numpy.sin(i))
        attributes = {"rackfocus:lensOffset": place, "rackfocus:shearDistance": 6.0}
        paths.append(
            scene(f"v{i:02}.exr", size=(300, 3201), attributes=LENS | attributes)
        )
    whole, windows = tmp_path / "whole.exr", tmp_path / "windows.exr"
    command = (binary, "filter", *paths, *FAST, "--threads", 2)
    needed, code, said = peak_of(*command, "-o", whole)
    assert code == 0, said
    used, code, said = peak_of(*command, "-o", windows, "--max-memory", 250)
    assert code == 0, said
    assert used < 250 < 0.5 * needed
    (a, _), (b, _) = plainexr.read(windows), plainexr.read(whole)
    assert all(numpy.array_equal(a[name], b[name]) for name in b)


@pytest.mark.parametrize("text", ["0.1", "a,b", "0.1,0.2,0.3", "inf,0"])
def test_bad_place_of_the_aperture(rackfocus, views, tmp_path, text):
    done = rackfocus(
        "filter", *views(), "-o", tmp_path / "o.exr", "--aperture-at", text, code=2
    )
    assert f"--aperture-at: '{text}' is no place" in done.stderr


def test_one_view_has_no_aperture_to_move(rackfocus, views, tmp_path):
    done = rackfocus(
        "filter", views()[0], "-o", tmp_path / "o.exr", "--aperture-at", "0,0", code=2
    )
    assert "--aperture-at: the input is one view" in done.stderr


def test_a_view_that_is_given_twice_is_said(rackfocus, views, tmp_path):
    """As by a pattern and a name beside it, whatever the name is."""
    paths, out = views(), tmp_path / "o.exr"
    again = tmp_path / "again.exr"
    again.symlink_to(paths[1])
    done = rackfocus("filter", *paths, again, "-o", out)
    assert f"{again}: is given twice, as two views; name each view once" in done.stderr
    assert "twice" not in rackfocus("filter", *paths, "-o", out).stderr


def test_accumulate_says_a_view_that_is_given_twice(rackfocus, scene, tmp_path):
    paths, out = (scene(name="v1.exr"), scene(name="v2.exr")), tmp_path / "o.exr"
    assert rackfocus("accumulate", *paths, "-o", out).stderr == ""
    said = rackfocus("accumulate", *paths, paths[0], "-o", out).stderr
    assert f"{paths[0]}: is given twice, and counts twice" in said
