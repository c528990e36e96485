# SPDX-License-Identifier: Apache-2.0
"""Outputs that are each other or an input are refused, and nothing is lost."""

import os
import struct

import pytest

LENS = ["--lens-radius", "0.1", "--focal-length-px", "100", "--focus-distance", "6"]


@pytest.fixture
def folder(scene, tmp_path, monkeypatch):
    """Pictures, depths and two frames, in the folder that commands run in."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    names = ["in.exr", "own.exr", "z.exr", "a.png"]
    names += [f"{name}.{i:04d}.exr" for name in ("s", "t", "sub/z") for i in (1, 2)]
    for name in names:
        scene(name)
    (tmp_path / "pull.csv").write_text("frame,focus-distance\n1,6\n2,7\n")
    (tmp_path / "page.html").write_text("focus-distance 6\n")  # parameters
    os.symlink(".", tmp_path / "link")
    os.symlink("in.exr", tmp_path / "linked.exr")
    return tmp_path


@pytest.fixture
def refused(folder, rackfocus):
    """Exit code 2, a message with these words, and every file as it was."""

    def contents():
        files = (path for path in sorted(folder.rglob("*")) if path.is_file())
        return {path: path.read_bytes() for path in files}

    def check(*command, words):
        before = contents()
        done = rackfocus(*command, code=2)
        assert "is also" in done.stderr and "another name" in done.stderr
        for word in words:
            assert word in done.stderr, done.stderr
        assert contents() == before

    return check


SIDES = [
    ("filter in.exr -o o.exr --output-coc {}", "--output-coc"),
    ("filter in.exr -o o.exr --flattened {}", "--flattened"),
    ("filter in.exr -o o.exr --output-coc c.exr --flattened {}", "--flattened"),
    ("finish own.exr in.exr -o o.exr --output-error {}", "--output-error"),
    ("finish in.exr own.exr -o o.exr --output-error {}", "--output-error"),
    ("finish own.exr --guide in.exr -o o.exr --output-error {}", "--output-error"),
]


@pytest.mark.parametrize("command, option", SIDES)
@pytest.mark.parametrize("name", ["in.exr", "./in.exr", "link/in.exr", "linked.exr"])
def test_a_side_output_is_an_input(refused, command, option, name):
    refused(*command.format(name).split(), words=[option, "the input", f"'{name}'"])


@pytest.mark.parametrize("command, option", SIDES)
@pytest.mark.parametrize("name", ["o.exr", "./o.exr", "link/o.exr", "sub/../o.exr"])
@pytest.mark.parametrize("is_there", [False, True])
def test_a_side_output_is_the_picture(refused, folder, command, option, name, is_there):
    if is_there:
        (folder / "o.exr").write_bytes(b"old")
    refused(*command.format(name).split(), words=[f"{option}: '{name}'", "--output '"])


def test_two_side_outputs(refused):
    command = "filter in.exr -o o.exr --output-coc c.exr --flattened ./c.exr"
    refused(*command.split(), words=["--flattened: './c.exr'", "--output-coc 'c.exr'"])


@pytest.mark.parametrize(
    "option",
    "--depth-file --holdout --aperture-image --distribution-image --reflections-from "
    "--reflection-depth --transmission-depth".split(),
)
def test_inputs_that_options_name(refused, option):
    command = f"filter in.exr {option} z.exr -o o.exr --output-coc ./z.exr"
    refused(*command.split(), words=["--output-coc: './z.exr'", f"{option} 'z.exr'"])


def test_one_of_a_list(refused):
    command = (
        "filter in.exr --reflections-from own.exr,z.exr -o o.exr --output-coc z.exr"
    )
    refused(*command.split(), words=["--output-coc", "--reflections-from 'z.exr'"])


@pytest.mark.parametrize("name", ["in.exr", "./in.exr", "link/in.exr", "linked.exr"])
@pytest.mark.parametrize(
    "command, words",
    [
        ("filter in.exr", ["the input 'in.exr'"]),
        ("filter own.exr in.exr", ["the input 'in.exr'"]),
        ("filter own.exr --depth-file in.exr", ["--depth-file 'in.exr'"]),
        ("filter own.exr --holdout in.exr", ["--holdout 'in.exr'"]),
        ("filter own.exr --aperture-image in.exr", ["--aperture-image 'in.exr'"]),
        ("filter own.exr --reflections-from z.exr,in.exr", ["--reflections-from"]),
        ("filter own.exr in.exr --over", ["the input 'in.exr'"]),
        ("filter own.exr in.exr --stereo", ["the input 'in.exr'"]),
        ("finish in.exr", ["the input 'in.exr'"]),
        ("finish own.exr in.exr", ["the input 'in.exr'"]),
        ("finish own.exr --guide in.exr", ["the input 'in.exr'"]),
        ("finish own.exr --half in.exr z.exr", ["--half 'in.exr'"]),
        ("accumulate in.exr own.exr", ["the input 'in.exr'"]),
        ("accumulate own.exr in.exr", ["the input 'in.exr'"]),
    ],
)
def test_the_picture_is_an_input(refused, command, words, name):
    """Its depth would be lost, and a second run would find none."""
    refused(*command.split(), "-o", name, words=[f"--output: '{name}'", *words])


def test_the_picture_is_the_parameters(refused, folder):
    (folder / "look.exr").write_text("blades 6\n")
    command = "filter in.exr --params look.exr -o ./look.exr"
    refused(*command.split(), words=["--output: './look.exr'", "--params 'look.exr'"])


@pytest.mark.parametrize(
    "command", ["filter in.exr", "finish in.exr", "accumulate in.exr"]
)
def test_the_picture_is_an_input_by_a_hard_link(refused, folder, command):
    os.link(folder / "in.exr", folder / "hard.exr")
    refused(*command.split(), "-o", "hard.exr", words=["--output: 'hard.exr'"])


@pytest.mark.parametrize("output", ["%V.exr", "./%V.exr", "link/%v%V.exr"])
def test_the_picture_of_an_eye_is_an_input(refused, scene, output):
    for name in ("left.exr", "right.exr", "lleft.exr", "rright.exr"):
        scene(name)
    side = "" if "%v" not in output else output[5] and "r"
    inputs = ["in.exr", f"{side}right.exr"]
    words = ["--output: '", f"the input '{inputs[1]}'"]
    refused("filter", *inputs, "--stereo", "-o", output, words=words)


def test_eyes_beside_their_inputs(folder, scene, rackfocus):
    """Names of views that are no inputs are written."""
    scene("a_left.exr")
    scene("a_right.exr")
    command = "filter a_left.exr a_right.exr --stereo -o b_%V.exr"
    rackfocus(*command.split(), *LENS)
    assert (folder / "b_left.exr").exists() and (folder / "b_right.exr").exists()


@pytest.mark.parametrize("name", ["a.png", "link/a.png"])
@pytest.mark.parametrize(
    "options, option",
    [
        ("-o {}", "--output"),
        ("-o o.exr --reference 4 --reference-output {}", "--reference-output"),
        ("-o o.exr --keep {}", "--keep"),
    ],
)
def test_what_a_scene_reads(refused, folder, options, option, name):
    """A picture that the scene or one of its includes names."""
    name = name if option == "--output" else name.replace(".png", ".exr")
    (folder / "map.inc").write_text('#declare Map = "a.png" #declare Sky = "a.exr"')
    (folder / "a.exr").write_bytes((folder / "in.exr").read_bytes())
    (folder / "x.pov").write_text('#include "map.inc"')
    words = [f"{option}: '{name}'", "the input"]
    refused("povray", "x.pov", *options.format(name).split(), words=words)


def test_what_a_scene_reads_of_frames(refused, folder):
    (folder / "x.pov").write_text('#declare Map = "s.0002.exr";')
    command = "povray x.pov --frames 1-3 -o s.####.exr"
    refused(*command.split(), words=["--output: 's.0002.exr'", "the input"])


@pytest.mark.parametrize(
    "name",
    ["s.####.exr", "./s.####.exr", "s.%04d.exr", "link/s.####.exr", "{}/s.$F4.exr"],
)
@pytest.mark.parametrize(
    "command, option",
    [
        ("filter s.####.exr -o", "--output"),
        ("filter s.%04d.exr --frames 2 -o", "--output"),
        ("filter s.####.exr -o o.####.exr --output-coc", "--output-coc"),
        ("accumulate s.####.exr t.####.exr -o", "--output"),
        ("accumulate t.####.exr s.####.exr -o", "--output"),
    ],
)
def test_frames_of_a_sequence(refused, folder, command, option, name):
    name = name.format(folder)
    refused(*command.split(), name, words=[f"{option}: '", "the input"])


def test_a_link_for_a_single_frame(refused, folder):
    os.symlink("s.0002.exr", folder / "o.0002.exr")
    words = ["--output: 'o.0002.exr'", "the input 's.0002.exr'"]
    refused("filter", "s.####.exr", "-o", "o.####.exr", words=words)


@pytest.mark.parametrize("name", ["o.####.exr", "./o.####.exr", "o.%04d.exr"])
def test_results_of_a_sequence(refused, name):
    command = "filter s.####.exr -o o.####.exr --output-coc"
    refused(*command.split(), name, words=["--output-coc: '", "--output 'o."])


@pytest.mark.parametrize("name", ["sub/z.####.exr", "./sub/z.%04d.exr"])
def test_depths_of_a_sequence(refused, name):
    command = "filter s.####.exr --depth-file sub/z.####.exr -o"
    refused(*command.split(), name, words=["--output: '", "--depth-file 'sub/z."])


def test_sequences_beside_each_other(folder, rackfocus):
    command = "filter s.####.exr --depth-file sub/z.####.exr -o sub/s.####.exr"
    done = rackfocus(*command.split(), "--output-coc", "s.####.coc.exr", *LENS)
    assert "2 frames: 2 filtered" in done.stdout
    rackfocus("accumulate", "s.####.exr", "t.####.exr", "-o", "sub/t.####.exr")


@pytest.mark.parametrize("name", ["s.0001.exr", "s.0002.exr", "link/s.0001.exr"])
def test_the_table_of_a_pull(refused, name):
    command = f"focus s.####.exr 1@10,10 -o {name}"
    refused(*command.split(), words=[f"--output: '{name}'", "the input 's.000"])


def test_the_table_of_a_pull_by_other_depths(refused):
    command = "focus s.####.exr 1@10,10 --depth-file sub/z.####.exr -o sub/z.0002.exr"
    refused(*command.split(), words=["--output", "--depth-file 'sub/z.0002.exr'"])


@pytest.mark.parametrize(
    "command, words",
    [
        ("compare a.png in.exr --heatmap ./a.png", ["--heatmap", "the input"]),
        ("compare in.exr a.png --side-by-side a.png", ["--side-by-side", "the input"]),
        (
            "compare in.exr in.exr --heatmap h.png --side-by-side ./h.png",
            ["--side-by-side", "--heatmap"],
        ),
        (
            "compare-methods in.exr --reference a.png --sheet a.png",
            ["--sheet", "--reference"],
        ),
        (
            "povray x.pov -o o.exr --reference 4 --reference-output ./o.exr",
            ["--reference-output", "--output"],
        ),
        ("povray x.pov -o o.exr --keep ./o.exr", ["--keep", "--output"]),
        (
            "aperture --aperture-image a.png -o ./a.png",
            ["--output", "--aperture-image"],
        ),
        (
            "frames --html page.html -- filter s.####.exr -o o.####.exr --params page.html",
            ["--html", "--params"],
        ),
        (
            "submit --to script --dry-run --job s.0002.exr -- filter s.####.exr -o o.#.exr",
            ["--job", "the input"],
        ),
        (
            "submit --to script --dry-run --job=pull.csv -- filter s.####.exr -o o.#.exr"
            " --frame-parameters pull.csv",
            ["--job", "--frame-parameters"],
        ),
        (
            "submit --to script --dry-run --job=p.html --html=./p.html filter s.####.exr"
            " -oo.#.exr",
            ["--html", "--job"],
        ),
    ],
)
def test_other_commands(refused, command, words):
    refused(*command.split(), words=words)


@pytest.mark.parametrize("command", ["frames", "submit --to script --dry-run"])
def test_a_page_is_html(folder, rackfocus, command):
    """Not a frame, nor a scene or a reference by a slip."""
    before = (folder / "s.0001.exr").read_bytes()
    line = "-- filter s.####.exr -o o.####.exr".split()
    done = rackfocus(*command.split(), "--html", "s.0001.exr", *line, code=2)
    assert "--html: 's.0001.exr' does not end in .html" in done.stderr
    assert (folder / "s.0001.exr").read_bytes() == before


ACESCG = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)


def test_a_png_of_other_primaries_is_told(rackfocus, scene, tmp_path):
    """posts in ACEScg: 31.2 for 35.6 dB."""

    def said(name, **attributes):
        path = scene(attributes=attributes)
        lens = ["--focus-distance", "3", "--lens-radius", "0.1"]
        return rackfocus("filter", path, "-o", tmp_path / name, *lens).stderr

    def chromaticities(*values):
        return {"chromaticities": ("chromaticities", struct.pack("<8f", *values))}

    text = said("o.png", **chromaticities(*ACESCG))
    assert "not of Rec. 709, by chromaticities in the header" in text
    assert "by oiio:ColorSpace" in said("o.png", **{"oiio:ColorSpace": "ACEScg"})
    assert "Rec. 709" not in said("o.exr", **chromaticities(*ACESCG))
    for fine in (chromaticities(*REC_709), {"colorInteropID": "lin_rec709_scene"}, {}):
        assert "Rec. 709" not in said("o.png", **fine)
