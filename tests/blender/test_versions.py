# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that another version of Blender wrote: see inside/versions.py."""

import re

import pytest
from conftest import get_blender

# 5.0 replaces the outputs of older files, and 4.5 adds one to those of 5.0.
PAIRS = (("3.4", "4.2"), ("4.2", "5.0"), ("5.0", "4.5"), ("4.2", "newest"))
# 4.5 loses the links to nodes whose inputs 5.0 calls otherwise, and its scenes cannot get
# a group of 5.0 back in the place of their nodes.
LOST = {("5.0", "4.5"): {"two_layers", "nodes_off"}}


def expect(log, lost=()):
    """Each file was written or read, but those that Blender itself cannot."""
    found = dict(re.findall(r"^VERSIONS (\w+) (.*)", log, re.M))
    assert len(found) == 4, log[-3000:]
    problems = {name for name, problem in found.items() if problem != "ok"}
    assert problems == set(lost), log[-6000:]


@pytest.mark.parametrize("pair", PAIRS, ids="to".join)
def test_a_file_of_another_version(pair, dist):
    """Its picture is filtered as it was there."""
    writer, reader = map(get_blender, pair)
    folder = writer.out / f"for_{reader.version}"
    folder.mkdir(exist_ok=True)
    expect(writer.run("versions.py", dist, writer.out, "write", folder))
    log = reader.run("versions.py", dist, reader.out, "read", folder)
    expect(log, LOST.get(pair, ()))
