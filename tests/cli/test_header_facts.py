# SPDX-License-Identifier: Apache-2.0
"""The header of what was made says with which lens, not what the passes said before."""

import json

import plainexr
import pytest

LENS = {
    "rackfocus:focusDistance": 6.0,
    "rackfocus:lensRadius": 0.1,
    "rackfocus:focalLengthPx": 60.0,
}


@pytest.fixture
def told(rackfocus, tmp_path):
    """What info reads from the header alone, by the parameters' names."""

    def read(name):
        text = rackfocus("info", "--all", "--json", tmp_path / name).stdout
        return {n: p["value"] for n, p in json.loads(text)["parameters"].items()}

    return read


@pytest.fixture
def run(rackfocus, tmp_path):
    def run_filter(path, *arguments, name="out.exr"):
        rackfocus("filter", path, "-o", tmp_path / name, "-q", *arguments)
        return plainexr.read(tmp_path / name)[1]

    return run_filter


def own(attributes):
    """Attributes of the lens."""
    return {n: v for n, v in attributes.items() if n.startswith("rackfocus:")}


def test_what_was_not_overruled_stays(run, scene):
    attributes = own(run(scene(attributes=LENS)))
    del attributes["rackfocus:filtered"]
    assert attributes == pytest.approx(LENS)


@pytest.mark.parametrize("more", [(), ("--pass-through",)])
def test_what_was_typed_stands_in_the_header(run, scene, told, more):
    """Also the default's own value, which rackfocus:filtered does not name."""
    path = scene(attributes=LENS)
    attributes = run(path, "--blades", "6", "--focus-distance", "10", *more)
    assert attributes["rackfocus:focusDistance"] == 10
    facts = told("out.exr")
    assert facts["focus-distance"] == 10 and facts["blades"] == 6
    assert facts["lens-radius"] == pytest.approx(0.1)


def test_a_standard_attribute_is_overruled(run, scene, told):
    """Other programs go on reading `focus`, the camera's of the passes."""
    path = scene(attributes={"focus": 6.0, "aperture": 2.0})
    attributes = run(path, "--focus-distance", "4", "--focal-length", "60")
    assert attributes["focus"] == 6
    assert set(own(attributes)) == {
        "rackfocus:filtered",
        "rackfocus:focusDistance",
        "rackfocus:focalLength",
    }
    assert told("out.exr")["focus-distance"] == 4


def test_a_radius_that_follows_from_the_f_stop_is_said(run, scene, told):
    path = scene(attributes={**LENS, "rackfocus:fStop": 4.0})
    run(path, "--f-stop", "2")
    assert told("out.exr")["lens-radius"] == pytest.approx(0.2)
    path = scene(attributes={"rackfocus:lensRadius": 0.1})
    run(path, "--f-stop", "2", "--focal-length", "50", name="b.exr")
    assert told("b.exr")["lens-radius"] == pytest.approx(0.05 / 4)


def test_choices_have_their_names(run, scene):
    path = scene(attributes={**LENS, "rackfocus:optics": "lens"})
    attributes = run(path, "--optics", "camera", "--blades", "5")
    assert attributes["rackfocus:optics"] == "camera"


def test_the_ends_of_ranges_can_be_read_again(run, scene, told):
    """A float has neither 2^31 - 1 nor 1e300."""
    facts = {"rackfocus:lensSeed": 1.0, "rackfocus:depthInfinity": 1e9}
    path = scene(attributes={**LENS, **facts})
    ends = ["--depth-infinity", "1e300", "--lens-seed", str(2**31 - 1)]
    assert run(path, *ends)["rackfocus:lensSeed"] == 2**31 - 1
    found = told("out.exr")
    assert found["lens-seed"] == 2**31 - 1 and found["depth-infinity"] > 1e38


def test_facts_of_a_depth_file_are_taken_over(run, scene, told):
    depth = scene("depth.exr", attributes=LENS)
    run(scene("colour.exr"), "--depth-file", depth)
    facts = told("out.exr")
    assert facts["focus-distance"] == 6
    assert facts["focal-length-px"] == pytest.approx(60)


def test_larger_passes_have_other_pixels(run, scene):
    """What --supersample makes is counted in its own."""
    path = scene(attributes=LENS)
    options = ["--supersample", "2", "--focal-length-px", "90"]
    assert "rackfocus:focalLengthPx" not in run(path, *options)


@pytest.mark.parametrize("shear", [5.0, 0.0])
def test_a_mean_of_views_has_their_focus(rackfocus, scene, tmp_path, shear):
    """By accumulate as by the method; the mean is no view."""
    paths = []
    for i, place in enumerate([(0.05, 0.0), (-0.05, 0.0)]):
        facts = {"rackfocus:lensOffset": place, "rackfocus:shearDistance": shear}
        paths.append(scene(f"v{i}.exr", attributes={**LENS, **facts}))
    by_method = ["filter", "--method", "accumulate", "--focus-distance", "3"]
    for command in (["accumulate"], by_method):
        rackfocus(*command, *paths, "-o", tmp_path / "mean.exr", "-q")
        attributes = plainexr.read(tmp_path / "mean.exr")[1]
        assert attributes["rackfocus:focusDistance"] == (shear or 6)
        assert "rackfocus:lensOffset" not in attributes
        assert "rackfocus:shearDistance" not in attributes
