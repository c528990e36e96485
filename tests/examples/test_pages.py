# SPDX-License-Identifier: Apache-2.0
"""The examples of the users' pages work when they are pasted.

A code block that opens with ```sh run, ```python run or ```c run is an example. The
blocks of a page run one after the other in one empty folder that has a link to tests/,
as in the folder of the sources; a shell block stops at the first command that fails, C
is compiled with pkg-config and run.
"""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(sh|python|c) run\n(.*?)^```$", flags=re.M | re.S)
PAGES = sorted(
    page
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    if BLOCK.search(page.read_text())
)
USERS_PAGES = {
    "README.md",
    "cli.md",
    "files.md",
    "install.md",
    "live.md",
    "methods.md",
    "performance.md",
    "python.md",
    "reliability.md",
    "views.md",
}


def command_for(kind, text, folder):
    """What runs a block, and the text that goes to its standard input."""
    if kind == "sh":
        return ["bash", "-euo", "pipefail", "-c", text]
    if kind == "python":
        return ["/usr/bin/python3", "-c", text]
    (folder / "example.c").write_text(text)
    flags = "$(pkg-config --cflags --libs rackfocus)"
    line = f"cc -Wall -Wextra -Werror example.c -o example {flags} -lm && ./example"
    return ["bash", "-euo", "pipefail", "-c", line]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_examples_of_pages(page, environment, tmp_path):
    (tmp_path / "tests").symlink_to(ROOT / "tests")
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for kind, text in BLOCK.findall(page.read_text()):
        done = subprocess.run(
            command_for(kind, text, tmp_path),
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"


def other_commands(page):
    """Command lines of a page that are in no example."""
    text = BLOCK.sub("", page.read_text())
    lines = re.findall(r"^(?:    )?(rackfocus \S+ (?:.*\\\n)*.*)$", text, flags=re.M)
    return [re.sub(r"\\\n\s*", "", line) for line in lines if "[options]" not in line]


def test_other_command_lines_are_understood(environment, tmp_path):
    """Without the files that they name the command misses these, and nothing else."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    lines = {line: page.name for page in pages for line in other_commands(page)}
    assert len(lines) > 40
    blind = {k: v for k, v in environment.items() if "DISPLAY" not in k}
    lacks = r"no such file|no such frames|there is no file|there is no display"
    for line, page in lines.items():
        done = subprocess.run(
            ["bash", "-c", line],
            cwd=tmp_path,
            env=blind,
            capture_output=True,
            text=True,
        )
        said = done.stderr.strip()
        assert done.returncode in (1, 2), (page, line, said)
        assert re.search(lacks, said, flags=re.I), (page, line, said)
        assert "\n" not in said or "display" in said, (page, line, said)
    assert not list(tmp_path.iterdir())


def test_users_pages_have_examples():
    assert USERS_PAGES <= {page.name for page in PAGES}


def test_methods_have_their_section(run):
    """A new method, shape of the blend or choice of leak control is on the page."""
    page = (ROOT / "docs/methods.md").read_text()
    names = re.findall(r"^(\S+)$", run("rackfocus", "methods"), flags=re.M)
    assert len(names) > 8
    for name in names:
        assert f"`{name}`" in page, name


def test_figures_of_methods_are_the_programs(run):
    """Those of the three that the page compares in words; a better filter has better ones."""
    page = (ROOT / "docs/methods.md").read_text().split("## Side by side")[1]
    references = ROOT / "tests/quality/references"
    shown = {"layered": {}, "scatter": {}, "box": {"--blend": "coc"}}
    for method, words in shown.items():
        row = re.search(rf"^\| {method}(?: coc)? \| (.*) \|$", page, flags=re.M).group(
            1
        )
        for scene, figure in zip(
            ("posts", "plane"), row.split(" | ")[::2], strict=True
        ):
            options = [word for pair in words.items() for word in pair]
            source = references / f"{scene}_pinhole.exr"
            run(
                "rackfocus",
                "filter",
                "-q",
                source,
                "-o",
                "o.exr",
                "--method",
                method,
                *options,
            )
            said = run(
                "rackfocus", "compare", "o.exr", references / f"{scene}_reference.exr"
            )
            assert (
                abs(float(said.split()[-2]) - float(figure)) < 0.1
            ), f"{method}, {scene}"


def links(page):
    """Links of a page to files and to sections, without those to the web."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not re.match(r"https?:|mailto:", target):
            yield target


def anchors(page):
    """What the headings of a page are called in links."""
    for title in re.findall(r"^#+ (.*)$", page.read_text(), flags=re.M):
        name = re.sub(r"[^\w\- ]", "", title.lower())
        yield name.replace(" ", "-")


DEVELOPERS_PAGES = ["ARCHITECTURE", "algorithm", "extending", "glossary"]


@pytest.mark.parametrize("name", DEVELOPERS_PAGES)
def test_files_that_pages_name_are_there(name):
    """Files move; the pages for developers must follow them."""
    text = (ROOT / "docs" / f"{name}.md").read_text()
    text = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
    folders = {path.name for path in ROOT.iterdir() if path.is_dir()}
    files = [
        found
        for found in re.findall(r"`([\w./-]+)`", text)
        if found.split("/")[0] in folders and "/" in found and "NAME" not in found
    ]
    missing = [file for file in files if not (ROOT / file).exists()]
    assert not missing, f"docs/{name}.md names {missing}"


ALL_PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]


@pytest.mark.parametrize("page", ALL_PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    for target in links(page):
        name, _, anchor = target.partition("#")
        other = (page.parent / name).resolve() if name else page
        assert other.exists(), f"{page.name}: {target}"
        if anchor:
            assert anchor in set(anchors(other)), f"{page.name}: {target}"


def test_every_option_of_filter_stands_on_its_page(environment):
    """docs/cli.md has a table of them, which a new option is easily left out of."""
    done = subprocess.run(
        ["rackfocus", "filter", "--help"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    row = r"^ +(?:-\w, )?--(?:\[no-\])?([a-z-]+)"
    options = re.findall(row, done.stdout, flags=re.M)
    page = (ROOT / "docs/cli.md").read_text()
    table = page.split("## Every option of `filter`")[1].split("\n## ")[0]
    words = set(re.findall(r"--(?:no-)?([a-z-]+)", table))
    assert len(options) > 100 and set(options) - words == set()
