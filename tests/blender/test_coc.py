# SPDX-License-Identifier: GPL-3.0-or-later
"""The radius of the blur equals Cycles' own; inside/coc.py measures it."""

import json
import re

import pytest
from conftest import INSIDE, only_in

CASES = re.findall(r"^@case\ndef (\w+)", (INSIDE / "coc.py").read_text(), re.M)
LIMIT = 0.02
pytestmark = only_in("3.4", "newest")
_tables = {}


def table_of(blender, dist):
    """{case: line} of one run in one Blender."""
    if blender.version not in _tables:
        blender.run("coc.py", dist, blender.out)
        lines = json.loads((blender.out / "coc.json").read_text())
        _tables[blender.version] = {line["case"]: line for line in lines}
        print_table(blender.version, lines)
    return _tables[blender.version]


def print_table(version, lines):
    """All lines of one Blender, px."""
    print(f"\nBlender {version}: half-axes x and y in px")
    print(f"{'case':28} {'predicted':>15} {'Cycles':>15} {'Rack Focus':>15}")
    for line in lines:
        columns = [line[key] for key in ("predicted", "cycles", "filtered")]
        texts = [f"{x:7.2f} {y:7.2f}" for x, y in columns]
        print(f"{line['case']:28} {' '.join(texts)}")


@pytest.mark.parametrize("case", CASES)
def test_radius(blender, dist, case):
    """Predicted and filtered within 2 % of Cycles, in both directions."""
    line = table_of(blender, dist)[case]
    for key in ("predicted", "filtered"):
        for ours, physical in zip(line[key], line["cycles"], strict=True):
            assert ours == pytest.approx(physical, rel=LIMIT), line
