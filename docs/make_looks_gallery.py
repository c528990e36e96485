# SPDX-License-Identifier: Apache-2.0
"""Makes looks-gallery.md and its pictures: `docs/make_looks_gallery.py` with RACKFOCUS set.

One picture for each look that comes with the program and one of the plain lens, all of
the scene of tests/quality/references/looks. Run it when a file of looks/ changes.
"""

import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE = "tests/quality/references/looks/pinhole.exr"
# Discs of 27 px at the most, and lamps that do not burn out.
LENS = ["--lens-radius", "0.05", "--highlight-gain", "0.2"]
# A tilted lens blurs more by itself.
OF_LOOK = {"miniature": ["--lens-radius", "0.03"]}
HEAD = """# Looks, side by side

One picture for each [look](looks.md#ready-made) that comes with the program: lamps behind the focus and
some before it, 480 x 270 px. Each is one line:

```sh run
rackfocus filter tests/quality/references/looks/pinhole.exr -o vintage.png --look vintage \\
    --lens-radius 0.05 --highlight-gain 0.2
```

(`--highlight-gain` tames the lamps, which would burn out. This page is made by `make_looks_gallery.py`.)
"""


def rackfocus(*arguments):
    """What the command prints."""
    command = [os.environ["RACKFOCUS"], *arguments]
    return subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.PIPE).stdout


def filtered(name, *options):
    """Writes the picture of a look to docs/images."""
    out = f"docs/images/look-{name}.png"
    rackfocus("filter", "-q", SCENE, "-o", out, *LENS, *options)


def main():
    """All pictures, and the page."""
    os.environ["XDG_CONFIG_HOME"] = "/nonexistent"  # the program's own, nobody's else
    filtered("none")
    page = [
        HEAD,
        "## The plain lens\n\n![lamps of round discs](images/look-none.png)\n",
    ]
    for look in json.loads(rackfocus("looks", "--json")):
        name, about = look["name"], look["about"]
        filtered(name, "--look", name, *OF_LOOK.get(name, []))
        page.append(
            f"## {name}\n\n{about[0].upper()}{about[1:]}: `{look['options']}`\n\n"
            f"![{about}](images/look-{name}.png)\n"
        )
    (ROOT / "docs" / "looks-gallery.md").write_text("\n".join(page))


if __name__ == "__main__":
    main()
