# SPDX-License-Identifier: GPL-3.0-or-later
"""Real Blenders: Debian's 3.4, PyPI's bpy 4.2, 4.5 and 5.0, and the newest from sid.

What is missing is installed into RACKFOCUS_BUILD/blender and kept there.
"""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests"))
from machine import mirror  # noqa: E402

BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build")).resolve()
WORK = BUILD / "blender"
INSIDE = Path(__file__).parent / "inside"
VERSIONS = ("3.4", "4.2", "4.5", "5.0", "newest")
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")
SID_PACKAGES = (
    "blender libegl1 libgl1-mesa-dri libegl-mesa0 libgl1 python3-numpy "
    "python3-requests python3-cattr"
)


def call(*command, timeout=1500, **about):
    """Runs a command; its output belongs to the failure.

    timeout: seconds, many times what an idle machine needs; after it nothing that it
    started goes on, and the failure says what was printed until then.
    """
    process = subprocess.Popen(
        [str(part) for part in command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        **about,
    )
    try:
        printed, _ = process.communicate(timeout=timeout)
    except BaseException as error:
        os.killpg(process.pid, signal.SIGKILL)
        printed, _ = process.communicate()
        if not isinstance(error, subprocess.TimeoutExpired):
            raise
        raise AssertionError(
            f"{command}\n{printed[-4000:]}\nnot over after {timeout} s"
        ) from None
    assert process.returncode == 0, f"{command}\n{printed[-4000:]}"
    return printed


# ---- installing -------------------------------------------------------------------


def install_bpy(version):
    """Python of an environment with the `bpy` of a version; skips where pip fails."""
    folder = WORK / f"bpy-{version}"
    python = folder / "bin" / "python"
    if (folder / "done").exists():
        return python
    call(sys.executable, "-m", "venv", "--clear", "--without-pip", folder)
    # What Blender imports is compiled when it is imported.
    install = [*PIP, "--python", python, "install", "-q", "--no-compile"]
    try:
        call(*install, f"bpy=={version}.*")
    except AssertionError as error:
        pytest.skip(f"bpy {version} cannot be installed: {error}")
    (folder / "done").touch()
    return python


# Blender's packages with all that they need, unpacked: nothing there has to be set up
# but where libraries lie, and a whole Debian takes three times as long.
SID_SCRIPT = f"""
    set -e -o pipefail
    rm -rf "$1"
    mkdir -p "$1/etc" "$1/lists/partial" "$1/archives/partial"
    : >"$1/etc/nothing"
    key=/usr/share/keyrings/debian-archive-keyring.gpg
    echo "deb [signed-by=$key] $2 sid main" >"$1/etc/sources.list"
    apt() {{
        folder=$1
        shift
        apt-get -q -y -o Dir::State::lists="$folder/lists" \
            -o Dir::State::status="$folder/etc/nothing" \
            -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= \
            -o Dir::Cache::archives="$folder/archives" \
            -o Dir::Etc::sourcelist="$folder/etc/sources.list" \
            -o Dir::Etc::sourceparts=- -o Dir::Etc::preferencesparts=- \
            -o APT::Sandbox::User=root -o Acquire::Languages=none "$@"
    }}
    apt "$1" update
    apt "$1" install --download-only --no-install-recommends {SID_PACKAGES}
    for name in bin lib lib64 sbin; do
        mkdir -p "$1/usr/$name"
        ln -s "usr/$name" "$1/$name"
    done
    for package in "$1"/archives/*.deb; do
        dpkg-deb --fsys-tarfile "$package" >"$1/part.tar" # so that it can fail
        tar -xf "$1/part.tar" -C "$1" --keep-directory-symlink \
            --exclude=./usr/share/doc --exclude=./usr/share/man \
            --exclude=./usr/share/locale
    done
    rm -rf "$1/lists" "$1/archives"
    mkdir -p "$1/dev" "$1/proc" "$1/tmp"
    cd "$1/usr"
    ls -d lib/*-linux-gnu lib/*-linux-gnu/blas lib/*-linux-gnu/lapack |
        sed s,^,/usr/, >"$1/etc/ld.so.conf"
    ldconfig -r "$1"
"""


def install_sid():
    """Folder with the Blender of Debian sid; skips where it cannot be had."""
    folder = Path(os.environ.get("RACKFOCUS_SID", WORK / "sid"))
    if os.getuid() != 0 or subprocess.run(["unshare", "-m", "true"]).returncode:
        pytest.skip("a folder with Debian sid needs root and mounts of its own")
    if (folder / "usr/bin/blender").exists():
        return folder
    if not shutil.which("apt-get"):
        pytest.skip("a folder with Debian sid needs Debian's apt")
    part = folder.with_name(f"{folder.name}.part")
    try:
        call("bash", "-c", SID_SCRIPT, "bash", part, mirror())
    except AssertionError as error:
        shutil.rmtree(part, ignore_errors=True)
        pytest.skip(f"Debian sid cannot be had: {error}")
    part.rename(folder)
    return folder


def sid_command(folder, command, paths):
    """A command inside sid's folder, with `paths` at their own places.

    The mounts end with the command: nothing of the machine can be deleted through them.
    """
    mounts = "".join(
        f"mkdir -p {folder}{path}; mount --bind {path} {folder}{path}; "
        for path in ("/proc", "/dev", *paths)
    )
    script = (
        f'{mounts} mount -t tmpfs tmpfs {folder}/dev/shm; exec chroot {folder} "$@"'
    )
    return ["unshare", "-m", "sh", "-c", script, "sh", *command]


# ---- running ----------------------------------------------------------------------


class Blender:
    """One Blender with a folder of its own for settings and results."""

    def __init__(self, version):
        self.version = version
        self.out = WORK / f"out-{version}"
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir(parents=True)
        self.is_module = version in ("4.2", "4.5", "5.0")
        if self.is_module:
            self.python = install_bpy(version)
        elif version == "newest":
            self.sid = install_sid()

    def environment(self):
        """Variables that keep the user's own settings out."""
        home = self.out / "home"
        home.mkdir(exist_ok=True)
        variables = {
            **os.environ,
            "HOME": str(home),
            "BLENDER_USER_RESOURCES": str(home / "r"),
            "BLENDER_USER_CONFIG": str(home / "r/config"),
            "BLENDER_USER_SCRIPTS": str(home / "r/scripts"),
        }
        # Each start would compile Blender's own modules anew.
        variables.pop("PYTHONDONTWRITEBYTECODE", None)
        return variables

    def command(self, *args):
        """The command line of Blender as a program."""
        command = ["blender", *args]
        if self.version != "newest":
            return command
        paths = (str(ROOT), str(BUILD), "/tmp")
        return sid_command(self.sid, command, dict.fromkeys(paths))

    def run(self, script, *args, has_display=False, **more):
        """Runs a script of inside/ in the background; returns what it printed.

        has_display: under Xvfb; more: variables of its environment.
        """
        if self.is_module:
            command = [self.python, INSIDE / script, "--", *args]
        else:
            command = self.command(
                "-b", "--factory-startup", "-P", str(INSIDE / script), "--", *args
            )
        if has_display:
            command = ["xvfb-run", "-a", "-s", "-screen 0 640x480x24", *command]
            more["LIBGL_ALWAYS_SOFTWARE"] = "1"
        log = call(*command, env={**self.environment(), **more}, cwd=self.out)
        (self.out / f"{script}.log").write_text(log)
        return log


_blenders = {}


def get_blender(version):
    """The Blender of a version, made once per session."""
    if version not in _blenders:
        try:
            _blenders[version] = Blender(version)
        except pytest.skip.Exception as reason:
            _blenders[version] = reason
    found = _blenders[version]
    if isinstance(found, BaseException):
        raise found
    return found


@pytest.fixture(params=VERSIONS, scope="session")
def blender(request):
    """Each of the Blenders."""
    return get_blender(request.param)


def only_in(*versions):
    """Runs the tests of a module in some of the Blenders: what is ours and slow.

    Where the add-on asks for a version (compat.py), 4.2 and 4.5 go the way of 3.4 or that
    of 5.0: they have test_addon.py, which is whole, and test_versions.py. 5.0 and the
    newest go one way but where nodes are unknown (test_files.py): where a module has one
    of them, 5.0 has what was found in it (cameras, few samples, its denoiser).
    """
    return pytest.mark.parametrize("blender", versions, indirect=True, scope="session")


@pytest.fixture(scope="session")
def dist():
    """Folder with the two zips, freshly built."""
    if not (BUILD / "build.ninja").exists():
        call("meson", "setup", BUILD, ROOT)
    if not (BUILD / "plugin/_core.abi3.so").exists():
        call("meson", "configure", BUILD, "-Dpython=enabled")
    call("ninja", "-C", BUILD, "plugin/_core.abi3.so")
    folder = WORK / "dist"
    shutil.rmtree(folder, ignore_errors=True)
    call(sys.executable, ROOT / "blender_addon/package.py", BUILD, folder)
    return folder


@pytest.fixture(scope="session")
def oidn():
    """Folder of Open Image Denoise, for Blenders that have none of their own."""
    folder = BUILD / "oidn"
    library = folder / "pyoidn/oidn/lib"
    if not library.exists():
        options = ("-q", "--no-compile", "--no-deps", "--target", folder)
        call(*PIP, "install", *options, "pyoidn>=2.5")
    return library


@pytest.fixture(scope="session")
def command():
    """Path of the rackfocus command."""
    call("ninja", "-C", BUILD, "cli/rackfocus")
    return BUILD / "cli" / "rackfocus"
