# SPDX-License-Identifier: Apache-2.0
"""--params: parameters from a text file."""

import numpy
import plainexr
import pytest


def made(rackfocus, scene, tmp_path, *options):
    out = tmp_path / "out.exr"
    rackfocus("filter", scene(), "-o", out, "--compression", "none", *options)
    return plainexr.read(out)


def is_same(a, b):
    return all(numpy.array_equal(a[0][name], b[0][name]) for name in "RGB")


def test_a_file_is_as_good_as_options(rackfocus, scene, tmp_path):
    params = tmp_path / "lens.params"
    params.write_text(
        "# a lens\n\nfocus-distance 3\nf-stop 9 # too small\nf-stop 0.1\n--blades 5\n"
    )
    options = ["--focus-distance", "3", "--f-stop", "0.1", "--blades", "5"]
    by_file = made(rackfocus, scene, tmp_path, "--params", params)
    assert is_same(by_file, made(rackfocus, scene, tmp_path, *options))
    assert not is_same(by_file, made(rackfocus, scene, tmp_path))


def test_options_win(rackfocus, scene, tmp_path):
    params = tmp_path / "lens.params"
    params.write_text("focus-distance 3\nf-stop 0.1\n")
    options = ["--focus-distance", "12", "--f-stop", "0.1"]
    both = made(rackfocus, scene, tmp_path, "--params", params, options[0], "12")
    assert is_same(both, made(rackfocus, scene, tmp_path, *options))


@pytest.mark.parametrize(
    "line, part",
    [
        ("f-stopp 3", "there is no parameter 'f-stopp' (of another version, or"),
        ("f-stop", "is not a parameter and its value"),
        ("f-stop much", "it is a number from"),
        ("cat-eye 50%", "it is a number from 0 to 4\n"),
        ("max-radius all", "it is a number from 0 to 16384 px\n"),
        ("method fast", "method"),
        ("f-stop -1", "f-stop"),
        ("f-stop=2.8", "a '=' behind the parameter; a space stands"),
        ("f-stop = 2.8", "a '=' behind the parameter; a space stands"),
        ("f-stop; 2.8", "a ';' behind"),
        ("--f-stop 2.8 --blades 5", "more behind f-stop and its value: '--blades'"),
        ("--no-split-edges", "'no-split-edges' is not a parameter and its value"),
        ("f-stop 2.8 blades 5", "more behind f-stop and its value: 'blades'"),
    ],
)
def test_bad_lines_are_named(rackfocus, scene, tmp_path, line, part):
    params = tmp_path / "lens.params"
    params.write_text(f"blades 6\n{line}\n")
    done = rackfocus(
        "filter", scene(), "-o", tmp_path / "out.exr", "--params", params, code=1
    )
    assert f"{params}:2: " in done.stderr and part in done.stderr, done.stderr


def test_long_remarks(rackfocus, scene, tmp_path):
    """A remark of any length is one line; its rest was read as a parameter."""
    params = tmp_path / "lens.params"
    params.write_text(
        f"# {'x' * 300}\n# {'f-stop 9 ' * 9999}\nfocus-distance 3\nbad 1\n"
    )
    done = rackfocus(
        "filter", scene(), "-o", tmp_path / "out.exr", "--params", params, code=1
    )
    assert f"{params}:4: there is no parameter 'bad'" in done.stderr


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_text_of_other_systems(rackfocus, scene, tmp_path, end):
    """Notepad writes a byte-order mark and CR LF. Behind a CR alone, as old Macs and Excel
    for Macs end lines, all was left out without a word."""
    params = tmp_path / "lens.params"
    lines = ["focus-distance 3", "f-stop 0.1", ""]
    params.write_bytes(b"\xef\xbb\xbf" + end.join(lines).encode())
    options = ["--focus-distance", "3", "--f-stop", "0.1"]
    by_file = made(rackfocus, scene, tmp_path, "--params", params)
    assert is_same(by_file, made(rackfocus, scene, tmp_path, *options))
    params.write_bytes(end.join(["# a lens", "", "f-stop 2", "nope 1", ""]).encode())
    options = ["-o", tmp_path / "out.exr", "--params", params]
    done = rackfocus("filter", scene(), *options, code=1)
    assert f"{params}:4: there is no parameter 'nope'" in done.stderr


@pytest.mark.parametrize(
    "content, part",
    [
        (None, "is a folder; give the name of a file"),
        ("f-stop 2".encode("utf-16"), "its text is UTF-16; save it as UTF-8"),
        (b"f-stop 2\n\0\0lens-radius 0.2\n", "is no text file"),
    ],
)
def test_what_is_no_text(rackfocus, scene, tmp_path, content, part):
    """It counted as empty, and the picture was filtered without it."""
    params = tmp_path / "lens.params"
    params.mkdir() if content is None else params.write_bytes(content)
    for option in ("--params", "--frame-parameters"):
        inputs = ["passes.exr", "-o", "o.exr"]
        if option == "--frame-parameters":
            inputs = ["passes.#.exr", "-o", "o.#.exr"]
            scene("passes.1.exr")
        scene()
        done = rackfocus("filter", *inputs, option, "lens.params", cwd=tmp_path, code=1)
        assert f"lens.params: {part}" in done.stderr
        assert not list(tmp_path.glob("o.*exr"))


# ---- given twice -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "words, counts, dropped",
    [
        ("--params a.txt -o out.exr --params=b.txt", "b.txt", "a.txt"),
        ("--look vintage -o out.exr --look mirror", "mirror", "vintage"),
        ("-ofirst.exr --output out.exr", "out.exr", "first.exr"),
    ],
)
def test_texts_that_are_given_twice(rackfocus, scene, tmp_path, words, counts, dropped):
    """Both may be meant; the last one counts, and the command says so."""
    (tmp_path / "a.txt").write_text("blades 6\n")
    (tmp_path / "b.txt").write_text("focus-distance 3\n")

    def said(*more, code=0):
        line = ["filter", scene(), *words.split(), *more]
        return rackfocus(*line, cwd=tmp_path, code=code).stderr

    told = f"is given twice: '{counts}' counts and '{dropped}' does not; leave one"
    assert told in said()
    assert not (tmp_path / "first.exr").exists()
    assert said("-q") == ""
    assert told in said("-q", "--strict", code=2)


def test_numbers_and_the_same_text_may_be_given_twice(rackfocus, scene, tmp_path):
    words = ["--f-stop=2", "--f-stop=3", "-j1", "-j2", "-o", "out.exr", "-oout.exr"]
    done = rackfocus("filter", scene(), *words, cwd=tmp_path)
    assert "twice" not in done.stderr


def test_the_window_says_it_once(rackfocus, tmp_path):
    env = {"PATH": "/usr/bin", "XDG_RUNTIME_DIR": str(tmp_path)}
    words = ["view", "--params", "a.txt", "--params", "b.txt", "passes.exr"]
    for name in "ab":
        (tmp_path / f"{name}.txt").write_text("blades 6\n")
    said = rackfocus(*words, cwd=tmp_path, env=env, code=1).stderr
    assert said.count("is given twice") == 1


@pytest.mark.parametrize("text", ["", " \n\t\n", "# blades 6\n  # f-stop 2\n"])
def test_a_file_without_parameters_is_told(rackfocus, scene, tmp_path, text):
    params, out = tmp_path / "lens.params", tmp_path / "out.exr"
    params.write_text(text)
    told = f"--params {params}: has no effect: no parameter stands in it"
    words = ["filter", scene(), "-o", out, "--params", params]
    assert told in rackfocus(*words).stderr
    assert told in rackfocus(*words, "--strict", code=1).stderr
    look = rackfocus("filter", scene(), "-o", out, "--look", params, code=2).stderr
    assert f"--look {params}: has no effect" in look
    params.write_text("\n  blades 6 # and no more\n")
    assert "has no effect: no" not in rackfocus(*words).stderr
