# SPDX-License-Identifier: Apache-2.0
"""The library from outside: its symbols, its dependencies, and the same bits from every
compiler and optimisation level. Builds of their own lie under the build folder and are
kept between runs.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
LIBRARY = BUILD / "core" / "librackfocus.so"

# Soon compiled, and without the command, which scene_hash does not need.
BARE = ["-Dcommand=false", "-Dview=disabled", "-Dpython=disabled"]
# The ordinary build is that of gcc -O3, the poisoned one that of clang -O0, and
# tests/platforms has that of clang -O3 (zig). What -march=native may change is that
# products and sums become one instruction: -fexpensive-optimizations does that.
NATIVE = "-Dc_args=-march=native -fexpensive-optimizations"
VARIANTS = {"gcc-native": ("gcc", ["-Doptimization=1", NATIVE, *BARE])}


def run(*command, **options):
    return subprocess.run(
        [str(word) for word in command],
        check=True,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        **options,
    ).stdout


def build(name, compiler, options, *targets):
    """The folder of a variant, configured once and brought up to date."""
    if not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")
    folder = BUILD / "variants" / name
    if not (folder / "build.ninja").exists():
        environment = dict(os.environ, CC=compiler)
        level = f"-Dlevel={best_level()}"
        run("meson", "setup", folder, ROOT, level, *options, env=environment)
    run("ninja", "-C", folder, *targets)
    return folder


def best_level():
    """What the ordinary build takes here: the variants have this level alone."""
    flags = set(Path("/proc/cpuinfo").read_text().split())
    for level, flag in (("avx2", "avx2"), ("sse4", "sse4_1")):
        if flag in flags:
            return level
    return "generic"


@pytest.fixture(scope="session")
def hashes():
    """What the ordinary build says."""
    return run(BUILD / "tests" / "behaviour" / "scene_hash")


def test_pictures_differ_from_each_other(hashes):
    values = re.findall(r": ([0-9a-f]{16})$", hashes, re.M)
    assert len(values) >= 14
    assert len(set(values)) > len(values) * 0.7  # scatter knows no blades


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_same_bits_for_any_number_of_threads(hashes, threads):
    assert run(BUILD / "tests" / "behaviour" / "scene_hash", threads) == hashes


@pytest.mark.parametrize("name", VARIANTS)
def test_same_bits_from_every_compiler(hashes, name):
    folder = build(name, *VARIANTS[name], "tests/behaviour/scene_hash")
    assert run(folder / "tests" / "behaviour" / "scene_hash") == hashes


REFERENCES = ROOT / "tests" / "quality" / "references"
# Pictures of the scenes of tests/quality, by files and options.
POISONED = {
    "8 views": ("posts_view0*", []),
    "3 views": ("portrait_view0[0-2]*", ["--sub-apertures", "1"]),
    "macro": ("macro_pinhole*", ["--blades", "5"]),
    "foliage": ("foliage_pinhole*", ["--sub-apertures", "1", "--lens-radius", "0.1"]),
    "preview": ("portrait_pinhole*", ["--quality", "preview"]),
}


@pytest.fixture(scope="session")
def poisoned():
    """A build that fills memory with rubbish, also what served before."""
    targets = ["tests/behaviour/scene_hash", "cli/rackfocus"]
    options = ["-Dc_args=-DRF_POISON", "-Doptimization=0"]
    options += ["-Dopenexr=system", *BARE[1:]]  # not what is asked about here
    return build("poison", "clang", options, *targets)


def test_no_scene_reads_what_was_not_written(hashes, poisoned):
    """Nor has clang -O0 other bits."""
    assert run(poisoned / "tests" / "behaviour" / "scene_hash") == hashes


@pytest.mark.parametrize("name", POISONED)
def test_no_picture_reads_what_was_not_written(poisoned, tmp_path, name):
    files, options = POISONED[name]
    sources = sorted(REFERENCES.glob(files))
    pictures = []
    for folder in BUILD, poisoned:
        out = tmp_path / "out.exr"
        command = [folder / "cli" / "rackfocus", "filter", "-q", *sources, "-o", out]
        # Not packed: the builds may have other versions of OpenEXR.
        run(*command, "--type", "float", "--compression", "none", *options)
        pictures.append(out.read_bytes())
    assert pictures[0] == pictures[1]


# Programs and which of their tests: a picture made colour by colour with each allocation
# failing takes as long as all others together, and fails in the same functions. Pictures
# between fences need no sanitizer, and a split diopter has the same strides.
SANITIZED = {
    "behaviour/test_inputs": "-any_strides_between_fences",
    "behaviour/test_memory": "-every_allocation_of_colours_may_fail",
    "unit/test_params": "",
}


def test_no_undefined_behaviour():
    """Address and undefined-behaviour sanitizers over the tests with odd inputs."""
    options = ["-Db_sanitize=address,undefined", "-Db_ndebug=false"]
    # With more of either they take longer to compile than to run.
    options += ["-Doptimization=0", "-Dc_args=-g1"]
    programs = [f"tests/{name}" for name in SANITIZED]
    folder = build("sanitize", "gcc", [*options, *BARE], *programs)
    environment = dict(
        os.environ,
        ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1",
        UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1",
    )
    for name, tests in SANITIZED.items():
        output = run(folder / "tests" / name, tests, env=environment)
        assert re.search(r"^ok ", output, re.M) and "not ok" not in output


def dynamic_symbols():
    lines = run("nm", "-D", "--defined-only", LIBRARY).splitlines()
    rows = [line.split() for line in lines]
    return {name.split("@")[0] for *_, kind, name in rows if kind != "A"}


def declared_functions():
    header = (ROOT / "core/include/rackfocus/rackfocus.h").read_text()
    return set(re.findall(r"RF_API\s[^;]*?\b(rf_\w+)\(", header))


def test_only_rf_names_are_exported():
    foreign = {name for name in dynamic_symbols() if not name.startswith("rf_")}
    assert not foreign


def test_exactly_what_the_header_declares_is_exported():
    assert len(declared_functions()) > 20
    assert dynamic_symbols() == declared_functions()


def test_every_function_says_its_version():
    """Programs that use a newer one are told so when they start."""
    lines = run("nm", "-D", "--defined-only", LIBRARY).splitlines()
    plain = [line for line in lines if " T " in line and "@@RACKFOCUS_" not in line]
    assert lines and not plain


def test_the_library_needs_nothing_but_libm():
    needed = re.findall(r"NEEDED.*\[(.*?)\]", run("readelf", "-d", LIBRARY))
    allowed = re.compile(r"(libm|libc|libpthread)\.so|ld-linux")
    assert needed and not [name for name in needed if not allowed.match(name)]


def test_a_header_for_c_and_for_cxx(tmp_path):
    """The header stands alone, in strict C11 and in C++."""
    include = ROOT / "core/include"
    for name, compiler, standard in (
        ("a.c", "gcc", "c11"),
        ("a.cpp", "clang", "c++17"),
    ):
        if not shutil.which(compiler):
            pytest.skip(f"{compiler} is not installed")
        source = tmp_path / name
        source.write_text("#include <rackfocus/rackfocus.h>\n")
        run(
            *(compiler, f"-std={standard}", "-Wall", "-Wextra", "-Werror"),
            *("-fsyntax-only", f"-I{include}", source),
        )


PROGRAM = """#include <rackfocus/rackfocus.h>
int main(void) { return rf_param_at(0) && rf_version() ? 0 : 1; }
"""
CMAKE = """cmake_minimum_required(VERSION 3.16)
project(user C)
find_package(rackfocus 0.1 REQUIRED)
add_executable(user user.c)
target_link_libraries(user rackfocus::rackfocus)
add_executable(alone user.c)
target_link_libraries(alone rackfocus::static)
"""


def test_programs_find_the_installed_library(tmp_path):
    """By pkg-config, and by CMake wherever the tree is moved to; also without a library
    beside them.
    """
    tree = tmp_path / "a tree"
    run("meson", "install", "-C", BUILD, "--no-rebuild", "--destdir", tree)
    (pc,) = tree.rglob("rackfocus.pc")
    (config,) = tree.rglob("rackfocus-config.cmake")
    (tmp_path / "user.c").write_text(PROGRAM)
    (tmp_path / "CMakeLists.txt").write_text(CMAKE)
    environment = {**os.environ, "PKG_CONFIG_PATH": str(pc.parent)}
    flags = subprocess.run(
        ["pkg-config", f"--define-variable=prefix={tree}/usr/local"]
        + ["--cflags", "--libs", "rackfocus"],
        **dict(env=environment, capture_output=True, text=True, check=True),
    ).stdout
    assert "-lrackfocus" in flags and "-I" in flags
    line = 'eval "cc user.c -static $(pkg-config --static --cflags --libs rackfocus)"'
    paths = pc.read_text().replace("prefix=/usr/local", f"prefix={tree}/usr/local")
    pc.write_text(paths.replace("a tree", "a\\ tree"))
    subprocess.run(["sh", "-ec", line], cwd=tmp_path, env=environment, check=True)
    subprocess.run([tmp_path / "a.out"], check=True)
    if not shutil.which("cmake"):
        pytest.skip("cmake is not installed")
    run(
        "cmake",
        "-S",
        tmp_path,
        "-B",
        tmp_path / "b",
        f"-Drackfocus_DIR={config.parent}",
    )
    run("cmake", "--build", tmp_path / "b")
    subprocess.run([tmp_path / "b" / "user"], check=True)
    shutil.rmtree(tree)
    subprocess.run([tmp_path / "b" / "alone"], check=True)
