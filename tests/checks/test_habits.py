# SPDX-License-Identifier: Apache-2.0
"""What ./dev check, hooks and docs promise."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(__file__).parent))
import habits  # noqa: E402

GOOD = "exr: tiles are read\n\nThey were refused: 2 of 37 test files have them.\n"


def run(*command, cwd=ROOT, **options):
    words = [str(word) for word in command]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True, **options)


@pytest.mark.parametrize(
    "text, fault",
    [
        (GOOD, None),
        ("Merge branch 'tiles'\n", None),
        ("fixup! exr: tiles are read\n", None),
        ("# a remark of git\n" + GOOD, None),
        ("core, exr: tiles are read\n\nWhy not.\n", None),
        ("exr: " + 68 * "x" + "\n\nwhy\n", "the subject has 73 characters"),
        ("exr: " + 67 * "x" + "\n\nwhy\n", None),
        ("read tiles\n\nwhy\n", "not 'area: what it does'"),
        ("exr: tiles are read.\n\nwhy\n", "ends with a full stop"),
        ("exr: tiles are read\nwhy\n", "is not blank"),
        ("exr: tiles are read\n", "there is no body"),
        ("exr: tiles are read\n\n# Changes to be committed:\n", "there is no body"),
        ("\n# only remarks\n", "the message is empty"),
    ],
)
def test_messages_of_commits(text, fault):
    found = list(habits.faults_of_message(text))
    if fault is None:
        assert not found
    else:
        assert len(found) == 1 and fault in found[0]


@pytest.fixture
def clone(tmp_path):
    """A repository with ./dev, the hooks and the checks, without anything else."""
    for name in ("dev", ".githooks", "tests/checks"):
        source, target = ROOT / name, tmp_path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if source.is_dir() else shutil.copy
        copy(source, target)
    for words in (["init", "-q"], ["config", "user.name", "A"]):
        run("git", *words, cwd=tmp_path, check=True)
    run("git", "config", "user.email", "a@example.org", cwd=tmp_path, check=True)
    return tmp_path


def commit(clone, text):
    words = ["commit", "-q", "--allow-empty", "-m", text]
    return run("git", *words, cwd=clone)


def test_hook_refuses_what_has_no_reason(clone):
    assert commit(clone, "no area").returncode == 0  # nobody has asked for the hook
    said = run("./dev", "hooks", cwd=clone)
    assert said.returncode == 0 and "core.hooksPath" in said.stdout
    done = commit(clone, "exr: tiles are read")
    assert done.returncode != 0 and "there is no body" in done.stderr
    assert commit(clone, GOOD).returncode == 0


def test_words_are_found(clone, monkeypatch):
    (clone / "core").mkdir()
    (clone / "core/one.c").write_text("/* TO" + "DO: the rest */\nint x;\n")
    (clone / "core/two.c").write_text("/* (recipe" + " step 3) */\n/* a color */\n")
    (clone / "core/good.c").write_text('/* colour */ char *s = "color";\n')
    run("git", "add", "-A", cwd=clone, check=True)
    monkeypatch.setattr(habits, "ROOT", clone)
    found = [line.split(" write")[0] for line in habits.words()]
    assert found == [
        "core/one.c:1: 'TO" + "DO':",
        "core/two.c:1: 'recipe" + " step':",
        "core/two.c:2: '/* a color':",
    ]


def test_no_word_of_the_list_is_used():
    assert list(habits.words()) == []


def test_quick_suites_are_there():
    """A suite that is renamed must not fall out of ./dev test quick."""
    text = (ROOT / "dev").read_text()
    suites = re.search(r"^quick_suites='([^']*)'", text, flags=re.M).group(1).split()
    python = re.search(r"^quick_python='([^']*)'", text, flags=re.M).group(1).split()
    assert len(suites) > 5 and set(python) <= set(suites)
    for suite in suites:
        assert (ROOT / "tests" / suite).is_dir(), suite
    for suite in python:
        assert list((ROOT / "tests" / suite).glob("test_*.py")), suite


def anchors_of(page):
    """What the headings of a page can be linked by, as GitHub names them."""
    heads = re.findall(r"^#+ (.*)", page.read_text(), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_links_of_pages():
    """A link to a file or a heading that is not there leads nowhere, without a word."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")]
    n_headings = 0
    for page in pages:
        for name, heading in re.findall(
            r"\]\((?!\w+:)([^)#\s]*)#?([^)\s]*)\)", page.read_text()
        ):
            target = page.parent / name if name else page
            assert target.exists(), f"{page.name}: {name}"
            if heading and target.suffix == ".md":
                assert heading in anchors_of(target), f"{page.name}: {name}#{heading}"
                n_headings += 1
    assert n_headings > 50


def test_commands_of_dev_have_help():
    text = run("./dev", "--help").stdout
    commands = re.findall(r"^  (\w+) ", text, flags=re.M)
    assert {"build", "test", "check", "hooks", "docs"} <= set(commands)
    for command in commands:
        said = run("./dev", command, "--help")
        assert said.returncode == 0, command
        assert said.stdout.startswith(f"Usage: ./dev {command}"), command


@pytest.mark.skipif(not shutil.which("doxygen"), reason="doxygen is not installed")
def test_pages_of_the_api(tmp_path):
    """Every function and parameter has its page, and Doxygen has nothing to say."""
    environment = dict(os.environ, RACKFOCUS_BUILD=str(tmp_path))
    environment["RACKFOCUS_NO_INSTALL"] = "1"
    done = run("./dev", "docs", env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    page = (tmp_path / "docs/html/rackfocus_8h.html").read_text()
    header = (ROOT / "core/include/rackfocus/rackfocus.h").read_text()
    functions = set(re.findall(r"^RF_API [^(]*?\*?(rf_\w+)\(", header, flags=re.M))
    assert len(functions) > 30
    for function in functions:
        assert f">{function}<" in page or f"{function} " in page, function
    members = (tmp_path / "docs/html/structrf__params.html").read_text()
    table = (ROOT / "core/include/rackfocus/params.def").read_text()
    keys = re.findall(r'^RF_\w+\(\s*"([^"]+)"', table, flags=re.M)
    assert len(keys) > 25
    for key in keys:
        assert f"--{key}." in members, key
