# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the installed add-on, and that uninstalling it leaves nothing.

checks.py DIST OUT [CHECK ...]    writes OUT/results.json
"""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
import checking  # noqa: E402
import common  # noqa: E402
import mirror_checks  # noqa: E402
import node_checks  # noqa: E402
import picture_checks  # noqa: E402
import setup_checks  # noqa: E402


def uninstall(report):
    """No datablock and no file of the add-on is left."""
    bpy.ops.wm.open_mainfile(filepath=str(checking.BASE))
    before = common.counts()
    common.start()
    common.uninstall()
    left = common.user_files()
    after = common.counts()
    is_clean = after == before and not left
    report("uninstall_leaves_nothing", "" if is_clean else f"{before}, {after}, {left}")
    print(common.V)


SCRIPTS = picture_checks, mirror_checks, node_checks, setup_checks
ALL = {name: one for script in SCRIPTS for name, one in script.check.items()}
checking.run(ALL, "results.json", uninstall)
