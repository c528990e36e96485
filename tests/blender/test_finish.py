# SPDX-License-Identifier: GPL-3.0-or-later
"""Finish and Supersample: see inside/finish_checks.py."""

import pytest
from checked import Checked, names_of
from conftest import only_in

SCRIPT = "finish_checks.py"
pytestmark = only_in("3.4", "5.0")
CHECKED = Checked(SCRIPT, "finish_results.json")
OWN_DENOISER = ("4.2", "5.0")  # the bpy of PyPI; Debian's Blenders have none


@pytest.mark.parametrize("name", names_of(SCRIPT))
def test_check(blender, dist, oidn, name):
    """One check in one Blender, with its own denoiser where it has one."""
    has_own = blender.version in OWN_DENOISER
    more = {} if has_own else {"RACKFOCUS_OIDN": str(oidn)}
    CHECKED.expect(blender, dist, name, **more)
