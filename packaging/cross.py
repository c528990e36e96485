# SPDX-License-Identifier: Apache-2.0
"""Builds for another system, or for an older Linux than this one.

Usage: cross.py PLATFORM [TARGET...]

PLATFORM is one of those below; TARGETs are names of ninja, by default the Python
extension and the command. Builds in build/PLATFORM, or $RACKFOCUS_BUILD/PLATFORM, and
prints that folder last. What is needed is fetched once: zig (a clang that brings the C
libraries of many systems, PyPI's ziglang), the sources of OpenEXR, libpng and zlib.
"""

import contextlib
import fcntl
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
ZIG = "ziglang==0.13.0"
# Target of zig (with the floor of glibc or macOS), system, processor.
BY_ZIG = {
    "linux-x64": ("x86_64-linux-gnu.2.28", "linux", "x86_64"),
    "linux-arm64": ("aarch64-linux-gnu.2.28", "linux", "aarch64"),
    "macos-x64": ("x86_64-macos.11.0", "darwin", "x86_64"),
    "macos-arm64": ("aarch64-macos.11.0", "darwin", "aarch64"),
}
PLATFORMS = [*BY_ZIG, "windows-x64"]


def run(*command, **options):
    """Runs it; shows what it says only where it fails."""
    done = subprocess.run(
        [str(word) for word in command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        **options,
    )
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{done.stdout[-6000:]}")
    return done.stdout


def write_if_new(path, text, mode=0o644):
    """Leaves a file that says so already: meson configures anew where one of its files is
    younger than the build, and a program that runs cannot be written to. So a new one comes
    beside, and takes its place."""
    if path.exists() and path.read_text() == text:
        return
    beside = path.with_name(f"{path.name}.{os.getpid()}")
    beside.write_text(text)
    beside.chmod(mode)
    beside.replace(path)


def zig_program():
    """Path of zig, fetched once."""
    folder = BUILD / "zig"
    program = folder / "ziglang" / "zig"
    if not program.exists():
        shutil.rmtree(folder, ignore_errors=True)
        pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps"]
        run(*pip, "--disable-pip-version-check", "--target", folder, ZIG)
    return program


def write_compiler(platform):
    """A compiler for the platform: zig, saying what meson wants to know of its linker;
    its path."""
    target, system, _ = BY_ZIG[platform]
    path = BUILD / "zig" / f"{platform}-cc"
    if system == "darwin":
        answer = "echo 'ld: unknown option: --version' >&2; exit 1"
    else:
        answer = "echo 'LLD 18.1.6 (compatible with GNU linkers)'; exit"
    zig = zig_program()
    # -bundle is what meson says for a Python module; zig makes no bundles, and Python
    # loads a dynamic library as well.
    write_if_new(
        path,
        f"""#!/bin/sh
case " $* " in
*" -Wl,--version "*) {answer} ;;
*" -Wl,-v "*) echo 'PROJECT:ld64-820.1' >&2; exit ;;
esac
is_first=1
for word in "$@"; do
    [ -z "$is_first" ] || set --
    is_first=
    [ "$word" != -bundle ] || word=-dynamiclib
    set -- "$@" "$word"
done
exec '{zig}' cc -target {target} "$@"
""",
        0o755,
    )
    return path


def write_zig_file(platform):
    """The cross file for zig; its path."""
    _, system, cpu = BY_ZIG[platform]
    zig, compiler = zig_program(), write_compiler(platform)
    path = BUILD / f"{platform}.ini"
    # -g0: zig keeps no debugging in releases, whose paths would differ from place to
    # place. -fno-sanitize: it would stop where C leaves the outcome open.
    flags = ["-g0", "-fno-sanitize=all", f"-ffile-prefix-map={ROOT}=."]
    emulator = ""
    if platform == "linux-arm64":
        emulator = (
            "exe_wrapper = ['qemu-aarch64-static', '-L', '/usr/aarch64-linux-gnu']"
        )
    link = ["-s"] if system == "linux" else []
    write_if_new(
        path,
        f"""[binaries]
c = '{compiler}'
ar = ['{zig}', 'ar']
ranlib = ['{zig}', 'ranlib']
strip = 'true'
pkgconfig = 'false'
{emulator}

[built-in options]
c_args = {flags}
c_link_args = {link}

[properties]
needs_exe_wrapper = true

[host_machine]
system = '{system}'
cpu_family = '{cpu}'
cpu = '{cpu}'
endian = 'little'
""",
    )
    return path


def soon_compiled(platform):
    """Options of meson for a build that tests look at: ours is compiled as it is
    packaged; libraries of others, and what no machine here can run, without optimization.
    Files of a library of others are compiled together: most of their time goes by reading
    headers (for Windows 4 s instead of 25 for libpng, 6 instead of 55 for OpenEXR).
    """
    options = ["-Dunity=subprojects", "-Dunity_size=100"]
    if platform.startswith("macos"):
        return [*options, "-Doptimization=0"]
    path = BUILD / "libraries.ini"
    write_if_new(
        path,
        """[properties]
library_c_args = ['-O0']
""",
    )
    return [*options, "--cross-file", path]


@contextlib.contextmanager
def locked(name):
    """Nobody else is at what has this name, of those who ask so, here or in another
    process."""
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def configure(platform, is_for_tests=False):
    """The folder of the build, ready for ninja; one at a time, since what they fetch is
    for all."""
    with locked("cross"):
        return _configure(platform, is_for_tests)


def _configure(platform, is_for_tests):
    for name in ("openexr", "libraries"):
        run(sys.executable, HERE / name / "get.py")
    folder = BUILD / (f"{platform}-tests" if is_for_tests else platform)
    if platform in BY_ZIG:
        cross = write_zig_file(platform)
    else:
        cross = HERE / "windows-x86_64.ini"
    if not (folder / "build.ninja").exists():
        shutil.rmtree(folder, ignore_errors=True)
        # The window wants a display's libraries, which only Windows brings.
        view = "enabled" if platform == "windows-x64" else "disabled"
        options = ["--buildtype=release", "-Dpython=enabled", f"-Dview={view}"]
        # Not what this machine may have for the other system.
        options.append("-Dforce_fallback_for=zlib,libpng,freetype2,sdl2")
        # Where meson looks at the compiler, zig leaves a file beside.
        options += ["--cross-file", cross]
        if is_for_tests:
            options += soon_compiled(platform)
        run("meson", "setup", folder, ROOT, *options, cwd=BUILD)
    return folder


def programs_of(platform):
    """What a package carries: extension and command, below the folder of the build."""
    if platform == "windows-x64":
        return [
            "plugin/_core.pyd",
            "plugin/_core310.pyd",
            "cli/rackfocus.exe",
            "view/rackfocus-view.exe",
        ]
    return ["plugin/_core.abi3.so", "cli/rackfocus"]


def build(platform, targets=(), is_for_tests=False):
    """Builds, and gives the folder. Two ninjas in one folder would write over each other's
    objects: the second waits, and finds them made."""
    folder = configure(platform, is_for_tests)
    with locked(folder.name):
        run("nice", "ninja", "-C", folder, *(targets or programs_of(platform)))
    return folder


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in PLATFORMS:
        sys.exit(f"{__doc__}\nPlatforms: {' '.join(PLATFORMS)}")
    print(build(sys.argv[1], sys.argv[2:]))


if __name__ == "__main__":
    main()
