# SPDX-License-Identifier: Apache-2.0
"""Initialisation files: the scene, its frames and its size, as POV-Ray reads them."""

import re

import numpy
import pytest
from conftest import SCENE, read_exr

INI = """; an animation
Input_File_Name=s.pov
Width = 40
Height=30
+KFF4 Initial_Frame=1
[late]
Subset_Start_Frame=3
"""


def frames_of(rackfocus, folder, *arguments, **more):
    """Names of the pictures made, and their pixels."""
    out = folder / "frames"
    out.mkdir()
    rackfocus("povray", *arguments, cwd=folder, **more)
    pictures = {p.name: read_exr(p)["G"] for p in sorted(out.glob("*.exr"))}
    for path in out.iterdir():
        path.unlink()
    out.rmdir()
    return pictures


def test_initialisation_files(rackfocus, tmp_path):
    """They name the scene and the frames, as for POV-Ray, wherever they are given."""
    ini = INI.replace("+KFF4 Initial_Frame=1", "+KFF4\nInitial_Frame=1")
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "anim.ini").write_text(ini)
    to = ["-o", "frames/o.exr"]
    alone = frames_of(rackfocus, tmp_path, "anim.ini", *to)
    assert list(alone) == [f"o000{i}.exr" for i in (1, 2, 3, 4)]
    frames = ["--frames", "1-4", "--", "+W40", "+H30"]
    for arguments in (["s.pov", *to, "--", "anim.ini"], ["s.pov", *to, *frames]):
        found = frames_of(rackfocus, tmp_path, *arguments)
        assert list(found) == list(alone)
        assert all(numpy.array_equal(found[n], alone[n]) for n in alone)
    late = frames_of(rackfocus, tmp_path, "s.pov", *to, "--", "anim.ini[late]")
    assert list(late) == ["o0003.exr", "o0004.exr"]
    assert all(numpy.array_equal(late[n], alone[n]) for n in late)
    named = frames_of(rackfocus, tmp_path, "anim.ini[Late]", *to)
    assert list(named) == list(late)
    assert all(numpy.array_equal(late[n], named[n]) for n in late)
    # One of the standard name in the folder is read without being named.
    (tmp_path / "anim.ini").rename(tmp_path / "povray.ini")
    found = frames_of(rackfocus, tmp_path, "s", *to, "--", "+SF2", "+EF2")
    assert list(found) == ["o0002.exr"]
    assert numpy.array_equal(found["o0002.exr"], alone["o0002.exr"])


@pytest.mark.parametrize(
    "options, frames",
    [  # What POV-Ray 3.7.0.10 renders of each
        ("+KFF10 Frame_Step=3", "1,4,7,10"),
        ("+KFF10 +SF3 +STP2", "3,5,7,9"),
        ("+KFF10 +STP0", "1-10"),
        ("+KFF10 +STP20", "1"),
        ("+KFF10 +SF0.3 +EF0.8", "3-8"),
        ("+KFI0 +KFF9 +EF0.5", "0-5"),
        ("+KFI11 +KFF20 +SF0.5", "11-20"),
        ("+KFF10 +SF9 +EF12", "9-12"),
        ("+KFF10 +SF12 +EF13", "12-13"),
        ("+KFI5 +KFF10 +SF3 +EF12", "5-12"),
        ("+KFI0 +KFF0", None),
        ("+KFF0", None),
    ],
)
def test_parts_of_an_animation(rackfocus, tmp_path, options, frames):
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "a.ini").write_text("+Is.pov\n" + options.replace(" ", "\n"))
    asked = ["frames", "--", "povray", "a.ini", "-o", "o.exr"]
    done = rackfocus(*asked, cwd=tmp_path, code=1 if frames else 2)
    found = re.search("--frames ([-0-9,]+)$", done.stdout, re.M)
    assert (found and found.group(1)) == frames


@pytest.mark.parametrize(
    "line, scene",
    [  # What POV-Ray 3.7.0.10 renders of each
        ("# was +KFF3", None),
        ("# it's as in old.ini", None),
        ("# see old.ini for more", None),
        ("  #Final_Frame=3", None),
        ("+A0.3 # no more +KFF3", None),
        ("Jitter=off ; see old.ini", None),
        ("Input_File_Name=s.pov#1", "s.pov"),
        ('+I"s#1.pov" # "+KFF3"', "s#1.pov"),
        ("Input_File_Name='s;1.pov' ; +KFF3", "s;1.pov"),
    ],
)
def test_comments(rackfocus, tmp_path, line, scene):
    """A # began none: its options made an animation, its words missing files."""
    for name in ("s.pov", "s#1.pov", "s;1.pov"):
        (tmp_path / name).write_text(SCENE)
    named = "" if scene else "+Is.pov\n"
    (tmp_path / "a.ini").write_text(f"{named}{line}\n")
    asked = ["povray", "a.ini", "-o", "o.exr", "--", "+W40", "+H30"]
    assert f"{scene or 's.pov'}: " in rackfocus(*asked, cwd=tmp_path).stdout
    assert [path.name for path in tmp_path.glob("*.exr")] == ["o.exr"]


@pytest.mark.parametrize(
    "line, name",
    [
        ('Include_Ini="a b.ini"', "a b.ini"),
        ("Include_INI = part", "part.ini"),
        ("Include_Ini=part.ini[more]", "part.ini"),
        ('"a b.ini"', "a b.ini"),
    ],
)
def test_an_initialisation_file_names_another(rackfocus, tmp_path, line, name):
    """As POV-Ray reads them: the frames were a still, and no scene was named."""
    (tmp_path / "two words.pov").write_text(SCENE)
    (tmp_path / "a.ini").write_text(line + "\n")
    (tmp_path / name).write_text('"two words.pov" +W32\n[more]\nFinal_Frame=3\n')
    if "more" in line:
        (tmp_path / "a.ini").write_text(line + '\n"two words.pov"\n')
    else:
        (tmp_path / name).write_text('Final_Frame=3\n"two words.pov" +W32\n')
    asked = ["frames", "--", "povray", "a.ini", "-o", "o.exr"]
    assert "--frames 1-3\n" in rackfocus(*asked, cwd=tmp_path, code=1).stdout


@pytest.mark.parametrize(
    "encoding, words",
    [("utf-16", "is in UTF-16"), ("utf-8-sig", "begins with a byte order mark")],
)
def test_an_initialisation_file_that_povray_cannot_read(
    rackfocus, tmp_path, encoding, words
):
    """As Windows' Notepad saves them; POV-Ray itself names no reason."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "a.ini").write_text("[one]\nInput_File_Name=s.pov\n", encoding)
    done = rackfocus("povray", "a.ini[one]", "-o", "o.exr", cwd=tmp_path, code=1)
    assert f"a.ini: {words}" in done.stderr and "save it as plain text" in done.stderr


@pytest.mark.parametrize("line", ["Include_Ini=part.ini", "sub/part.ini"])
def test_an_initialisation_file_that_is_missing(rackfocus, tmp_path, line):
    """POV-Ray looks in the current folder, not beside the file that names it."""
    (tmp_path / "s.pov").write_text(SCENE)
    (tmp_path / "a.ini").write_text(f"Input_File_Name=s.pov\n{line}\n")
    done = rackfocus("povray", "a.ini", "-o", "o.exr", cwd=tmp_path, code=1)
    name = line.split("=")[-1]
    assert f"a.ini: names the initialisation file {name}, which is not" in done.stderr


def test_an_initialisation_file_without_a_scene(rackfocus, tmp_path):
    (tmp_path / "a.ini").write_text("Width=80\n")
    text = rackfocus("povray", "a.ini", "-o", "o.exr", cwd=tmp_path, code=1).stderr
    assert "names no scene" in text and "Input_File_Name" in text


def test_a_scene_of_an_initialisation_file_elsewhere(rackfocus, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "s.pov").write_text(SCENE)
    (tmp_path / "there" / "a.ini").write_text("Input_File_Name=s\n+W80 +H60\n")
    rackfocus("povray", "there/a.ini", "-o", "o.exr", cwd=tmp_path)
    assert read_exr(tmp_path / "o.exr")["G"].shape == (60, 80)


@pytest.mark.parametrize("writes", ["", '#fopen F "note.txt" write #fclose F\n'])
def test_blanks_in_names(rackfocus, tmp_path, writes):
    """POV-Ray ends names of files, sections and folders at blanks, but in quotes.

    A scene that writes files is rendered in another folder."""
    place = tmp_path / "my scenes"
    place.mkdir()
    (place / "size.inc").write_text("#declare Size = 1;\n")
    (place / "s.pov").write_text(writes + '#include "size.inc"\n' + SCENE)
    (place / "my anim.ini").write_text("+W20 +H20\n[Low quality, 1]\n+W40 +H30\n")
    ini = "my scenes/my anim.ini[low quality, 1]"
    for library in ("+Lmy scenes", "Library_Path=my scenes", '+L"my scenes"'):
        rackfocus("povray", ini, "-o", "o.exr", "--", "+Imy scenes/s.pov", library,
                  "+Omy own.png", cwd=tmp_path)  # fmt: skip
        assert read_exr(tmp_path / "o.exr")["G"].shape == (30, 40)
    rackfocus("povray", "my scenes/s", "-o", "o.exr", "--", ini, cwd=tmp_path)
    assert read_exr(tmp_path / "o.exr")["G"].shape == (30, 40)


@pytest.mark.parametrize("options", [["+KFF10", "+SF12"], ["+KFF10", "+SF8", "+EF6"]])
def test_a_part_that_ends_before_it_begins(rackfocus, tmp_path, options):
    """POV-Ray renders its first frame; frame 10 was made of the first of these."""
    (tmp_path / "s.pov").write_text(SCENE)
    asked = ["povray", "s.pov", "-o", "o.exr", "--", *options]
    text = rackfocus(*asked, cwd=tmp_path, code=1).stderr
    assert "which are none" in text and "Subset_Start_Frame" in text


def test_frames_beyond_the_last(rackfocus, tmp_path):
    """Their clock goes on as POV-Ray's own: frame 3 of 2 is 2 from the first."""
    (tmp_path / "s.pov").write_text(SCENE.replace("+ clock", "+ (clock - 2)"))
    (tmp_path / "still.pov").write_text(SCENE.replace("+ clock", ""))
    size = ["+W40", "+H30"]
    more = ["+KFF2", "+SF3", "+EF3"]
    rackfocus("povray", "s.pov", "-o", "o.exr", "--", *size, *more, cwd=tmp_path)
    rackfocus("povray", "still.pov", "-o", "still.exr", "--", *size, cwd=tmp_path)
    found, still = (read_exr(tmp_path / n)["G"] for n in ("o0003.exr", "still.exr"))
    assert numpy.array_equal(found, still)
