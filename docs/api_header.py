#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes rackfocus.h as Doxygen can read it, to standard output: for ./dev docs.

The header has its parameters and choices by macros (params.def, params_lists.h). Here
they are written out as members and constants, each with its help, unit, range and
default.
"""

import re
from pathlib import Path

HEADERS = Path(__file__).resolve().parents[1] / "core/include/rackfocus"
TYPES = {"RF_FLOAT": "double", "RF_INT": "int32_t"}
STRING = r'"(?:[^"\\]|\\.)*"'


def arguments(text):
    """The arguments of a macro call; neighbouring strings are one."""
    parts = re.findall(rf"(?:{STRING}|[^,\"])+", text)
    for part in parts:
        strings = re.findall(STRING, part)
        yield "".join(s[1:-1] for s in strings) if strings else part.strip()


def calls(text, name):
    """Arguments of every call of a macro whose name matches."""
    call = rf"^ *({name})\(((?:{STRING}|[^()\"]|\([^()]*\))*)\)"
    for found in re.finditer(call, text, flags=re.M):
        yield found.group(1), list(arguments(found.group(2)))


def members():
    """The members of struct rf_params."""
    text = re.sub(r"/\*.*?\*/", "", (HEADERS / "params.def").read_text(), flags=re.S)
    for kind, words in calls(text, r"RF_(?:FLOAT|INT|BOOL|ENUM)"):
        key, member = words[:2]
        about = max(words[3:], key=len)
        if kind in TYPES:
            unit, low, high, default = words[3:7]
            about += (
                f" {unit + ', ' if unit else ''}{low} to {high}, default {default}."
            )
        elif kind == "RF_ENUM":
            about += f" One of enum rf_{words[3][len('RF_LIST_'):].lower()},"
            about += f" default {words[4]}."
        else:
            about += f" 0 or 1, default {words[3]}."
        about = about.replace("@", "").replace("--", "\\--")
        yield f"/** {about} The option \\--{key}. */\n{TYPES.get(kind, 'int32_t')} {member};"


def constants(lists, name):
    """The constants of an enumeration."""
    text = re.search(rf"#define {name}\(X\)((?:.*\\\n)*.*)\n", lists).group(1)
    for _, words in calls(text.replace("\\\n", "\n"), "X"):
        yield f'{words[0]}, /**< {words[2]}: "{words[1]}" */'


def alone(text):
    """Members that share a line and a comment, each with its own copy of it."""

    def split(found):
        space, kind, names, about = found.groups()
        return "\n".join(f"{space}{kind}{n}; {about}" for n in names.split(", "))

    shared = r"^( +)((?:const )?\w+ )(\w+(?:, \w+)+); +(/\*\*<.*\*/)$"
    text = re.sub(shared, split, text, flags=re.M)
    above = r"^( +/\*\*[^<](?:(?!\*/).)*\*/\n)( +\w+ )(\w+), (\w+);$"
    return re.sub(above, r"\1\2\3;\n\1\2\4;", text, flags=re.M | re.S)


def main():
    text = (HEADERS / "rackfocus.h").read_text()
    lists = (HEADERS / "params_lists.h").read_text()
    text = text.replace("/**\n * librackfocus:", "/**\n * @file\n * librackfocus:", 1)
    text = re.sub(
        r"^enum (\w+) \{ (RF_LIST_\w+)\(RF_X_ENUM\) \};",
        lambda found: "\n".join(
            [
                f"/** Choices, by the names that rf_params_set() takes. */",
                f"enum {found.group(1)} {{",
                *constants(lists, found.group(2)),
                "};",
            ]
        ),
        text,
        flags=re.M,
    )
    begin = text.index("#define RF_FLOAT(")
    end = text.index("};", begin)
    text = text[:begin] + "\n".join(members()) + "\n" + text[end:]
    text = alone(text)
    print(re.sub(r"^#(define|undef) RF_X_ENUM.*\n", "", text, flags=re.M), end="")


if __name__ == "__main__":
    main()
