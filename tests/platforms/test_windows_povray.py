# SPDX-License-Identifier: Apache-2.0
"""`rackfocus povray` of Windows under wine. A stand-in for POV-Ray for Windows hands its
arguments to this machine's POV-Ray: passes and picture are those of Linux, to the bit."""

import json

import pytest
from systems import BUILD, ROOT, run

SCENE = """camera { location <0,1,-5> look_at <0,1,0> angle 40 aperture 0.4
  focal_point <0,1,0> blur_samples 50 }
light_source { <5,8,-6> rgb 1 }
plane { y, 0 pigment { checker rgb 0.2 rgb 0.9 } }
sphere { <0,1,0>, 0.7 pigment { rgb <1,0.5,0.2> } }
sphere { <1.5,1,5>, 1 pigment { rgb <0.2,0.5,1> } }
"""
# Names of Windows become those of this machine; what was asked for is written down.
SCRIPT = r"""#!/bin/sh
done=$1
shift
echo "$@" >> "$(dirname "$0")/asked"
for word in "$@"; do
    shift
    [ "$word" != /EXIT ] || continue
    set -- "$@" "$(printf %s "$word" | sed -e 's#\\#/#g' -e 's#[Zz]:/#/#g' \
        -e "s#[Cc]:/#$WINEPREFIX/drive_c/#g")"
done
povray "$@" > /dev/null 2>&1
echo $? > "$done.part"
mv "$done.part" "$done"
"""


@pytest.fixture
def pvengine(tmp_path):
    """A pvengine64.exe, with the script that it starts beside it."""
    folder = tmp_path / "POV-Ray v3.7"
    folder.mkdir()
    program, script = folder / "pvengine64.exe", folder / "povray.sh"
    source = ROOT / "tests" / "platforms" / "povray_unix.c"
    run("x86_64-w64-mingw32-gcc-posix", "-O1", "-static", "-o", program, source)
    script.write_text(SCRIPT)
    return program


def test_povray_has_the_bits_of_linux(windows, wine, pvengine, tmp_path):
    (tmp_path / "scene.pov").write_text(SCENE)
    words = ("povray", "scene.pov", "--keep", "{0}.exr", "-o", "{0}_out.exr")
    size = ("--", "+W160", "+H120")

    def make(name):
        return [word.format(name) for word in words]

    named = ("--povray", str(pvengine).replace("/", "\\"))
    command = windows / "cli" / "rackfocus.exe"
    wine(command, *make("windows"), *named, *size, cwd=tmp_path)
    asked = (pvengine.parent / "asked").read_text()
    assert all(line.endswith("/EXIT") for line in asked.splitlines()), asked
    native = BUILD / "cli" / "rackfocus"
    run(native, *make("linux"), *size, cwd=tmp_path)
    for name in ("{}.exr", "{}_out.exr"):
        both = [tmp_path / name.format(system) for system in ("windows", "linux")]
        said = run(native, "compare", "--json", *both)
        assert json.loads(said)["identical"], said
