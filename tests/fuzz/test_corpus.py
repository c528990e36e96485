# SPDX-License-Identifier: Apache-2.0
"""The corpus of the fuzz targets, with the sanitizers: no finding. New ones are looked
for with tests/fuzz/fuzz run SECONDS.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

FUZZ = Path(__file__).parent / "fuzz"


@pytest.mark.skipif(not shutil.which("clang"), reason="clang is not installed")
def test_corpus_has_no_finding():
    done = subprocess.run(
        [FUZZ, "replay"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert done.returncode == 0, done.stdout
    counts = dict(re.findall(r"^(\w+): (\d+) files$", done.stdout, re.M))
    assert set(counts) == {"exr", "params", "camera", "filter"}
    assert all(int(n) >= 4 for n in counts.values())
