# SPDX-License-Identifier: Apache-2.0
"""Looks of lenses: files of parameters under a name (looks/ of the sources).

Those that come with the program are in the extension; the artist's own are files in
rackfocus/looks of the folder for settings, which `rackfocus looks --save` writes.
"""

import os
from pathlib import Path

from . import _core
from ._errors import parameter_error

PLACES = (("XDG_CONFIG_HOME", ""), ("APPDATA", ""), ("HOME", ".config"))


def folder():
    """Of the artist's own looks, as a Path; None where nothing says where it is."""
    for variable, below in PLACES:
        home = os.environ.get(variable, "")
        if os.path.isabs(home):  # as the XDG specification says
            return Path(home, below, "rackfocus", "looks")
    return None


def sources():
    """{name: the text of a look, or the Path of an own one's}; theirs win."""
    found = dict(_core.looks())
    home = folder()
    for path in sorted(home.glob("*.params")) if home else ():
        found[path.stem] = path
    return found


def text_of(source):
    """Of a file without a byte-order mark, as Notepad writes it."""
    if isinstance(source, str):
        return source
    path = source
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise parameter_error("name", f"{path}: cannot be read: {error}") from error


def about(text):
    """The comment that the text of a look begins with."""
    return text.split("\n", 1)[0].lstrip("# ")


def parameters(name, text, table):
    """{field: value} of a look's text. The error names the line that is wrong."""
    by_key = {p.key: p for p in table} | {p.field: p for p in table}
    found = {}
    for number, line in enumerate(text.splitlines(), 1):
        key, *value = line.split("#")[0].split() or [""]
        if not key:
            continue
        if key not in by_key or len(value) != 1:
            raise parameter_error(
                "name",
                f"look {name}, line {number}: {key!r} is not a parameter and its "
                "value, such as 'swirl 0.3'",
            )
        try:
            found[by_key[key].field] = _value(by_key[key], *value)
        except ValueError:
            raise parameter_error(
                "name", f"look {name}, line {number}: {value[0]!r} is no number"
            ) from None
    return found


def _value(parameter, text):
    if parameter.type == "enum":
        return text
    if parameter.type == "bool":
        return text.lower() in ("1", "true", "yes", "on")
    return int(text) if parameter.type == "int" else float(text)
