# SPDX-License-Identifier: Apache-2.0
"""What ./dev package makes: names, contents, the same bytes twice, and an index that
agrees with its zips."""

import base64
import csv
import hashlib
import io
import json
import sys
import zipfile

import pytest
from systems import BUILD, ROOT, build, run

import cross
import wheels

PLATFORMS = tuple(wheels.TAGS)


def make(folder):
    """The wheels and zips of all platforms, and the index."""
    for platform in PLATFORMS:
        built = build(platform)
        run(sys.executable, ROOT / "blender_addon/package.py", built, folder, platform)
    run(sys.executable, ROOT / "packaging/repository.py", folder)


@pytest.fixture(scope="module")
def dist(tmp_path_factory):
    """A folder with all of them."""
    folder = tmp_path_factory.mktemp("dist")
    make(folder)
    return folder


def wheel_of(dist, platform, python):
    """One Python's wheel, opened."""
    tag = f"{wheels.PYTHON_TAGS[python]}-{wheels.TAGS[platform]}"
    return zipfile.ZipFile(next(dist.glob(f"rackfocus-*-{tag}.whl")))


@pytest.mark.parametrize("python", wheels.PYTHON_TAGS)
@pytest.mark.parametrize("platform", PLATFORMS)
def test_wheel(dist, platform, python):
    """Extension, command, stubs, licences and metadata; RECORD has the sums of all."""
    archive = wheel_of(dist, platform, python)
    names = archive.namelist()
    ending = ".exe" if platform == "windows-x64" else ""
    command = f"rackfocus/rackfocus-command{ending}"
    wanted = {command, "rackfocus/py.typed", "rackfocus/_core.pyi"}
    wanted |= {f"rackfocus/licences/{part}.txt" for part in wheels.PARTS}
    assert wanted <= set(names)
    assert len([name for name in names if "/_core." in name and "pyi" not in name]) == 1
    mode = archive.getinfo(command).external_attr >> 16
    assert mode & 0o111 == 0o111
    info = f"rackfocus-{wheels.version()}.dist-info"
    metadata = archive.read(f"{info}/METADATA").decode()
    head, text = metadata.split("\n\n", 1)
    assert f"Requires-Python: >={python}" in head and "Typing :: Typed" in head
    assert "Depth of field after the render" in text
    assert b"rackfocus.__main__:main" in archive.read(f"{info}/entry_points.txt")
    record = archive.read(f"{info}/RECORD").decode()
    rows = {row[0]: row[1] for row in csv.reader(io.StringIO(record)) if row}
    assert set(rows) == set(names)
    for name, digest in rows.items():
        if digest:
            found = hashlib.sha256(archive.read(name)).digest()
            wanted = base64.urlsafe_b64encode(found).decode().rstrip("=")
            assert digest == f"sha256={wanted}", name


def test_wheel_of_linux_is_what_its_tag_says(dist, tmp_path):
    """By auditwheel: no library that manylinux does not have, no newer symbol."""
    folder = BUILD / "auditwheel"
    pip = [sys.executable, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    if not (folder / "auditwheel").exists():
        run(*pip, "--target", folder, "auditwheel==6.4.2")
    for platform in ("linux-x64", "linux-arm64"):
        path = next(dist.glob(f"*-{wheels.TAGS[platform]}.whl"))
        code = f"import sys; sys.path.insert(0, {str(folder)!r}); "
        code += "from auditwheel.main import main; sys.exit(main())"
        said = run(sys.executable, "-c", code, "show", path).replace("\n", " ")
        assert "manylinux_2_2" in said.split("consistent with")[1], said


@pytest.mark.parametrize("platform", PLATFORMS)
def test_extension(dist, platform):
    path = next(dist.glob(f"rack_focus-*-{platform}-extension.zip"))
    archive = zipfile.ZipFile(path)
    manifest = archive.read("blender_manifest.toml").decode()
    assert f'platforms = ["{platform}"]' in manifest
    made = [name for name in archive.namelist() if name.endswith(".whl")]
    assert len(made) == 1 and made[0] in manifest
    assert wheels.TAGS[platform] in made[0]


def test_index_agrees_with_the_zips(dist):
    index = json.loads((dist / "index.json").read_text())
    assert index["version"] == "v1"
    assert sorted(e["platforms"][0] for e in index["data"]) == sorted(PLATFORMS)
    for entry in index["data"]:
        data = (dist / entry["archive_url"]).read_bytes()
        assert entry["archive_size"] == len(data)
        assert entry["archive_hash"] == f"sha256:{hashlib.sha256(data).hexdigest()}"
        assert entry["id"] == "rack_focus" and entry["type"] == "add-on"


def test_the_same_bytes_twice(dist, tmp_path):
    make(tmp_path)
    names = sorted(path.name for path in dist.iterdir())
    assert len(names) == 2 * 5 + 5 + 2 + 1
    for name in names:
        assert (dist / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_files_of_builds_are_replaced_whole(tmp_path):
    """One that says the same stays, or meson would configure anew; a new one takes its
    place in one step, for another build may run it."""
    program = tmp_path / "cc"
    cross.write_if_new(program, "exit 3\n", 0o755)
    first = program.stat()
    cross.write_if_new(program, "exit 3\n", 0o755)
    assert (program.stat().st_ino, program.stat().st_mtime_ns) == (
        first.st_ino,
        first.st_mtime_ns,
    )
    with program.open() as running:
        cross.write_if_new(program, "exit 4\n", 0o755)
        assert running.read() == "exit 3\n"
    assert program.read_text() == "exit 4\n" and program.stat().st_mode & 0o111
    assert list(tmp_path.iterdir()) == [program]
