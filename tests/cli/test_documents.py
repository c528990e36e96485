# SPDX-License-Identifier: Apache-2.0
"""Help, manual page and completion say all that the tables hold."""

import pathlib
import re
import shutil
import subprocess

import pytest

TABLE = pathlib.Path(__file__).parents[2] / "core/include/rackfocus/params.def"
COMMANDS = [
    "filter",
    "info",
    "compare",
    "compare-methods",
    "accumulate",
    "methods",
    "povray",
    "view",
]


@pytest.fixture(scope="session")
def keys():
    text = re.sub(r"/\*.*?\*/", "", TABLE.read_text(), flags=re.S)
    found = re.findall(r'^RF_\w+\(\s*"([^"]+)"', text, flags=re.M)
    assert len(found) > 25
    return found


def options_of(help_text):
    return set(
        re.findall(r"^ +(?:-\w, )?--(?:\[no-\])?([a-z-]+)", help_text, flags=re.M)
    )


def test_version(rackfocus):
    assert re.fullmatch(r"rackfocus \d+\.\d+\.\d+\n", rackfocus("--version").stdout)


def test_overview(rackfocus):
    text = rackfocus("--help").stdout
    assert text == rackfocus("help").stdout == rackfocus("-h").stdout
    for command in COMMANDS:
        assert re.search(rf"^  {command} ", text, flags=re.M)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_commands(rackfocus, command):
    text = rackfocus(command, "--help").stdout
    assert text == rackfocus("help", command).stdout == rackfocus(command, "-h").stdout
    assert text.startswith(f"Usage: rackfocus {command} ")
    assert "help" in options_of(text)
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize("command", ["filter", "info", "povray", "view"])
def test_help_lists_every_parameter(rackfocus, keys, command):
    text = rackfocus(command, "--help").stdout
    assert set(keys) <= options_of(text)
    places = [text.index(f"\n{group}:\n") for group in ("Lens", "Aperture", "Depth")]
    assert places == sorted(places)


def test_help_of_nothing(rackfocus):
    assert "did you mean" in rackfocus("help", "filtre", code=2).stderr


def test_methods(rackfocus):
    text = rackfocus("methods").stdout
    assert text.startswith("layered\n") and "\nscatter\n" in text
    assert text.count("Cost: ") == text.count("Source: ") >= 2
    assert "takes no file" in rackfocus("methods", "x", code=2).stderr


def test_man_page(rackfocus, keys):
    text = rackfocus("--generate-man").stdout
    plain = text.replace("\\-", "-")
    for key in keys:
        assert re.search(rf"--(\[no-\])?{key}\b", plain), key
    for command in COMMANDS:
        for option in options_of(rackfocus(command, "--help").stdout):
            assert re.search(rf"--(\[no-\])?{option}\b", plain), option
    for word in ("rackfocus:focusDistance", "EXIT STATUS", "sensorOverallDimensions"):
        assert word in plain


def test_man_page_is_sound(rackfocus, tmp_path):
    page = tmp_path / "rackfocus.1"
    page.write_text(rackfocus("--generate-man").stdout)
    if not shutil.which("groff"):
        pytest.skip("groff is not installed")
    command = ["groff", "-man", "-ww", "-z", "-Tutf8", str(page)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""


@pytest.fixture
def complete(rackfocus, tmp_path):
    """What bash offers for a command line; the last word is being typed."""
    script = tmp_path / "rackfocus.bash"
    script.write_text(rackfocus("--generate-completion").stdout)

    def run(*words, cwd=tmp_path):
        lines = [
            f"source {script}",
            "COMP_WORDS=({})".format(" ".join(f"'{w}'" for w in words)),
            f"COMP_CWORD={len(words) - 1}",
            "_rackfocus",
            'printf "%s\\n" "${COMPREPLY[@]}"',
        ]
        command = ["bash", "--norc", "-c", "\n".join(lines)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
        assert done.stderr == ""
        return done.stdout.split()

    return run


def test_completion_of_commands(complete):
    assert complete("rackfocus", "me") == ["methods"]
    assert set(COMMANDS) <= set(complete("rackfocus", ""))
    assert "compare" in complete("rackfocus", "help", "c")


def test_completion_of_options(complete, keys):
    offered = complete("rackfocus", "filter", "a.exr", "-")
    assert {f"--{key}" for key in keys} <= set(offered)
    assert {"-o", "--output", "--no-split-edges", "--depth-file"} <= set(offered)
    assert complete("rackfocus", "filter", "--focus") == ["--focus-distance"]
    assert "--f-stop" not in complete("rackfocus", "compare", "--")
    assert "--heatmap" in complete("rackfocus", "compare", "--")


def test_completion_of_choices(complete):
    assert complete("rackfocus", "filter", "--method", "la") == ["layered"]
    assert complete("rackfocus", "filter", "--depth", "=", "pl") == ["planar"]
    assert "inverse" in complete("rackfocus", "filter", "--depth", "=")
    assert complete("rackfocus", "filter", "--type", "") == ["half", "float"]


def test_own_options_hide_parameters(rackfocus, complete):
    text = rackfocus("povray", "--help").stdout
    assert "--aperture SIZE" in text and "--aperture KIND" not in text
    assert complete("rackfocus", "povray", "--aperture", "") == []
    assert "disc" in complete("rackfocus", "filter", "--aperture", "")


def test_completion_of_files(complete, tmp_path):
    (tmp_path / "passes.exr").touch()
    assert complete("rackfocus", "filter", "pas") == ["passes.exr"]
    assert complete("rackfocus", "filter", "--depth-file", "pas") == ["passes.exr"]
    assert complete("rackfocus", "filter", "--f-stop", "") == []


def test_completion_is_registered(rackfocus, tmp_path):
    script = tmp_path / "rackfocus.bash"
    script.write_text(rackfocus("--generate-completion").stdout)
    command = ["bash", "--norc", "-c", f"source {script}; complete -p rackfocus"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stdout == "complete -F _rackfocus rackfocus\n"


@pytest.mark.parametrize("shell", ("fish", "zsh"))
def test_completion_of_other_shells(rackfocus, keys, shell, tmp_path):
    """Every command, option and parameter; the shell itself, where it is, reads it."""
    text = rackfocus(f"--generate-{shell}").stdout
    lead = " -l " if shell == "fish" else "'--"
    for name in COMMANDS:
        assert f"-a {name} " in text or f"\n    {name})\n" in text, name
    for key in keys:
        found = re.search(re.escape(f"{lead}{key}") + r"[ =\[]", text)
        assert found, key
    for line in text.splitlines():
        said = re.search(r" -d '(.*)'$|'--[^\[]*\[(.*?)\]", line)
        if said:
            brief = said[1] or said[2]
            assert brief.count("(") == brief.count(")"), line
    assert shell == "zsh" or "Look of a kind of lens: vintage" in text
    assert re.search(r"--?method.*layered", text) or "-l method -x -a '" in text
    if shutil.which(shell):
        path = tmp_path / "completion"
        path.write_text(text)
        done = subprocess.run([shell, "-n", path], capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")
