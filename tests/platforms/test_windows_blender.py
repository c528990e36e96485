# SPDX-License-Identifier: Apache-2.0
"""The extension's zip in Windows' Blender (PyPI's bpy 4.5) under wine: the picture is
that of the command of Linux from the same passes, to the bit."""

import json

import pytest
from systems import BUILD, ROOT, get_python, make_python3, run, unpack

# Fixed: what comes later may need another wine.
PACKAGES = (
    "bpy==4.5.11 cython==3.3.1 requests==2.34.2 zstandard==0.25.0 numpy==1.26.4 "
    "urllib3==2.8.0 idna==3.20 certifi==2026.10.18 charset-normalizer==3.5.2"
).split()


@pytest.fixture(scope="module")
def blender():
    """(python.exe, folder of bpy and what it imports)."""
    home = get_python("3.11", "windows-x86_64", "win_amd64")
    make_python3(home)
    folder = BUILD / "windows-bpy"
    if not (folder / "done").exists():
        wanted = ["--platform", "win_amd64", "--python-version", "3.11", "--no-deps"]
        pip = ["python3", "-m", "pip", "download", "-q", "--only-binary=:all:"]
        run(*pip, *wanted, *PACKAGES, "-d", folder)
        for path in folder.glob("*.whl"):
            unpack(path, folder / "packages")
            path.unlink()
        (folder / "done").touch()
    return home / "python.exe", folder / "packages"


def test_extension_renders_the_bits_of_linux(blender, windows, wine, tmp_path):
    python, packages = blender
    run("python3", ROOT / "blender_addon/package.py", windows, tmp_path, "windows-x64")
    script = ROOT / "tests" / "platforms" / "use_blender.py"
    said = wine(python, script, tmp_path, tmp_path, packages)
    assert "ok 4.5" in said, said
    command = BUILD / "cli" / "rackfocus"
    words = ["--layer", "ViewLayer", "--type", "float", "-q"]
    for field, value in json.loads((tmp_path / "lens.json").read_text()).items():
        words += [f"--{field.replace('_', '-')}", value]
    want = tmp_path / "want.exr"
    run(command, "filter", tmp_path / "passes.exr", "-o", want, *words)
    for made in ("filtered.exr", "again.exr"):
        said = run(command, "compare", "--json", want, tmp_path / made)
        assert json.loads(said)["identical"], said
    said = run(command, "compare", "--json", want, tmp_path / "passes.exr")
    assert not json.loads(said)["identical"], "nothing was blurred"
