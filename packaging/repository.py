# SPDX-License-Identifier: Apache-2.0
"""Makes the folder of the extension zips a repository that Blender 4.2 and later installs
from, as `blender --command extension server-generate` does.

Usage: repository.py FOLDER

Writes FOLDER/index.json for the zips *-extension.zip in it that name their platform.
"""

import hashlib
import json
import sys
import tomllib
import zipfile
from pathlib import Path

# What an index repeats of a manifest.
FIELDS = (
    "schema_version",
    "id",
    "name",
    "tagline",
    "version",
    "type",
    "maintainer",
    "license",
    "blender_version_min",
    "blender_version_max",
    "website",
    "copyright",
    "permissions",
    "tags",
    "platforms",
    "python_versions",
)


def entry_of(path):
    """What the index says of a zip."""
    with zipfile.ZipFile(path) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    data = path.read_bytes()
    entry = {field: manifest[field] for field in FIELDS if field in manifest}
    entry["archive_url"] = f"./{path.name}"
    entry["archive_size"] = len(data)
    entry["archive_hash"] = f"sha256:{hashlib.sha256(data).hexdigest()}"
    return entry


def main():
    folder = Path(sys.argv[1])
    zips = sorted(folder.glob("*-*-*-*-extension.zip"))
    if not zips:
        sys.exit(f"repository.py: {folder} has no extension that names its platform")
    index = {
        "version": "v1",
        "blocklist": [],
        "data": [entry_of(path) for path in zips],
    }
    (folder / "index.json").write_text(json.dumps(index, indent=2) + "\n")
    print(folder / "index.json")


main()
