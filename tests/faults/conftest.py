# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import sys

import pytest

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "cli"))


@pytest.fixture(scope="session")
def failing():
    """The library that makes calls fail when it is preloaded."""
    return os.path.join(os.environ["RACKFOCUS_BUILD"], "tests/faults/libfailing.so")
