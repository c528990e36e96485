# SPDX-License-Identifier: Apache-2.0
"""Puts Python's headers beside a pyconfig.h for another system.

    headers.py PYCONFIG STAMP FOLDER
"""

import shutil
import sys
import sysconfig
from pathlib import Path

pyconfig, stamp, folder = (Path(word) for word in sys.argv[1:])
shutil.rmtree(folder, ignore_errors=True)
shutil.copytree(sysconfig.get_path("include"), folder)
shutil.copy(pyconfig, folder / "pyconfig.h")
stamp.write_text("/* The headers of Python are in place. */\n")
