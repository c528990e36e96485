#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What ./dev check and the commit-msg hook look at.

    habits.py words             no file has a word of words.txt
    habits.py format            the sources are as ./dev format leaves them
    habits.py messages          of the commits that origin/main does not have
    habits.py message FILE      one commit message, as the hook sees it
    habits.py tidy [FILE...]    clang-tidy, without what exceptions.txt excepts

Each prints what is wrong, one a line, and ends with 1 if there is anything.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(__file__).parent))

SUBJECT_MOST = 72
MADE_BY_GIT = re.compile(r"(Merge|Revert|fixup!|squash!|amend!) ?")


def output(*command, **options):
    words = [str(word) for word in command]
    done = subprocess.run(
        words, cwd=ROOT, capture_output=True, text=True, check=False, **options
    )
    return done.stdout + done.stderr


def tracked(pattern):
    """Files in git whose path matches, which are there."""
    names = output("git", "ls-files").splitlines()
    return [n for n in names if re.search(pattern, n) and (ROOT / n).is_file()]


# ---- words ---------------------------------------------------------------------------


def read_words():
    for line in Path(__file__).with_name("words.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            pattern, files, instead = line.split(" | ")
            yield re.compile(pattern), re.compile(files), instead


def words():
    """Lines that have a word which is not to be used."""
    rules = list(read_words())
    for name in tracked(r"\.(c|h|py|build|md)$"):
        if "/notebook/" in name or name.startswith("tests/checks/"):
            continue
        mine = [rule for rule in rules if rule[1].search(name)]
        if not mine:
            continue
        lines = (ROOT / name).read_text(errors="replace").splitlines()
        for number, line in enumerate(lines, 1):
            for pattern, _, instead in mine:
                found = pattern.search(line)
                if found:
                    word = found.group(0).strip()
                    yield f"{name}:{number}: '{word[-40:]}': write instead: {instead}"


# ---- form ----------------------------------------------------------------------------


def form():
    """Files that ./dev format would change."""
    sources = tracked(r"\.[ch]$")
    text = output("clang-format", "--dry-run", *sources)
    for line in sorted(set(re.findall(r"^(\S+:\d+):\d+: warning", text, re.M))):
        yield f"{line}: not as clang-format writes it; run ./dev format"
    if shutil.which("black"):
        text = output("black", "-l", "88", "--check", *tracked(r"\.py$"))
        for name in re.findall(r"^would reformat (.*)$", text, re.M):
            yield f"{name}: not as black writes it; run ./dev format"


# ---- commits -------------------------------------------------------------------------


def faults_of_message(text):
    """What is wrong with a commit message."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    while lines and not lines[0].strip():
        lines.pop(0)
    if not lines:
        yield "the message is empty"
        return
    subject, rest = lines[0], lines[1:]
    if MADE_BY_GIT.match(subject):
        return
    if len(subject) > SUBJECT_MOST:
        yield f"the subject has {len(subject)} characters; at most {SUBJECT_MOST}"
    if not re.match(r"[a-z_.]+(, [a-z_.]+)*: \S", subject):
        yield "the subject is not 'area: what it does', such as 'exr: read tiles'"
    if subject.endswith("."):
        yield "the subject ends with a full stop"
    if rest and rest[0].strip():
        yield "the line after the subject is not blank"
    if not any(line.strip() for line in rest):
        yield "there is no body: say why, with figures where it is about them"


def message(path):
    return faults_of_message(Path(path).read_text())


def messages():
    """Commits of this branch that the others do not have yet."""
    base = output("git", "merge-base", "HEAD", "origin/main").strip()
    if not re.fullmatch(r"[0-9a-f]{40}", base):
        base = "HEAD~1"
    for commit in output("git", "rev-list", f"{base}..HEAD").split():
        if not re.fullmatch(r"[0-9a-f]{40}", commit):
            return
        text = output("git", "log", "-1", "--format=%B", commit)
        for fault in faults_of_message(text):
            yield f"{commit[:9]} {text.splitlines()[0][:50]}: {fault}"


# ---- clang-tidy ----------------------------------------------------------------------


def changed():
    """C files that differ from what origin/main has."""
    base = output("git", "merge-base", "HEAD", "origin/main").strip()
    names = output("git", "diff", "--name-only", base or "HEAD").splitlines()
    return [n for n in names if n.endswith(".c") and (ROOT / n).is_file()]


def tidy(*names):
    """Warnings of clang-tidy in files of the build, by default those changed."""
    from checks import ANALYSED, TIDY, is_like
    from results_table import read_table

    build = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
    excepted = [e for e in read_table("exceptions.txt") if e[0] == "clang-tidy"]
    for name in names or changed():
        # The analyser reads the headers of this system only.
        if Path(name).parts[0] not in ANALYSED or "windows" in Path(name).parts:
            continue
        text = output("clang-tidy", "--quiet", f"--checks={TIDY}", "-p", build, name)
        for line in re.findall(r"^.*: (?:warning|error): .*$", text, re.M):
            if not any(is_like(line, e[1]) for e in excepted):
                yield line


# ---- all -----------------------------------------------------------------------------

CHECKS = {
    "words": words,
    "format": form,
    "messages": messages,
    "message": message,
    "tidy": tidy,
}


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in CHECKS:
        print(__doc__)
        return 2
    found = list(CHECKS[sys.argv[1]](*sys.argv[2:]))
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
