#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The checks that take too long for every ./dev test, and the table of their results.

    tests/checks/checks.py coverage     lines of core, exr, povray_glue, plugin
                                        (report [PART...]: of tests run by hand)
    tests/checks/checks.py mutate       two dozen wrong lines, each of them caught
    tests/checks/checks.py threads      ThreadSanitizer over the threaded paths
    tests/checks/checks.py valgrind     the unit suite under memcheck
    tests/checks/checks.py static       clang-tidy, gcc -fanalyzer, cppcheck
    tests/checks/checks.py fuzz         fuzz targets, two at a time
                                        (fuzz S [TARGET...]: S seconds, not 600)
    tests/checks/checks.py faults       counts of tests/faults and tests/fuzz/corpus
    tests/checks/checks.py openexr      the test files of OpenEXR's source package
                                        (openexr pypi: of its newer one for Python)
    tests/checks/checks.py table        writes the results into docs/reliability.md

Builds and results (one JSON file per check) go to $RACKFOCUS_CHECKS, build-checks by
default. Needs the Debian packages listed in tests/checks/packages.
"""

import concurrent.futures
import datetime
import json
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests"))
from machine import mirror  # noqa: E402
from results_table import OUT, read_table, table  # noqa: E402

PYTHON = "/usr/bin/python3"
PACKAGES = Path(__file__).with_name("packages")


def run(*command, check=True, **options):
    words = [str(word) for word in command]
    print("+", " ".join(words[:8]), flush=True)
    return subprocess.run(words, check=check, text=True, **options)


def captured(*command, **options):
    options = {"check": False, "stderr": subprocess.STDOUT, **options}
    return run(*command, stdout=subprocess.PIPE, **options).stdout


def commit():
    """What is checked: asked before a check begins, for it may take an hour."""
    name = captured("git", "-C", ROOT, "rev-parse", "--short", "HEAD").strip()
    changed = captured("git", "-C", ROOT, "status", "--porcelain", "-uno").strip()
    return name + ("+" if changed else "")


def save(name, **values):
    OUT.mkdir(parents=True, exist_ok=True)
    values["date"] = datetime.date.today().isoformat()
    values["commit"] = COMMIT
    (OUT / f"{name}.json").write_text(json.dumps(values, indent=1))
    print(json.dumps(values, indent=1))


def need(*tools):
    """Ends with the way to install what is missing."""
    missing = [tool for tool in tools if not shutil.which(tool)]
    if missing:
        lines = PACKAGES.read_text().splitlines()
        words = " ".join(line for line in lines if not line.startswith("#"))
        raise SystemExit(f"{', '.join(missing)}: not found; apt-get install {words}")


def pytest(*arguments, environment, **options):
    words = [PYTHON, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    return captured(*words, cwd=ROOT, env=environment, **options)


def configure(name, *options, source=ROOT, compiler="gcc"):
    """A build of `source`; one that another checkout left there is made anew."""
    folder = OUT / name
    made_from = folder / "made_from"
    if not made_from.exists() or made_from.read_text() != str(source):
        shutil.rmtree(folder, ignore_errors=True)
        environment = dict(os.environ, CC=compiler)
        run("meson", "setup", folder, source, *options, env=environment)
        made_from.write_text(str(source))
    return folder


def environment_of(build):
    return dict(
        os.environ,
        RACKFOCUS=str(build / "cli" / "rackfocus"),
        RACKFOCUS_BUILD=str(build),
        EXR_DUMP=str(build / "tests" / "exr" / "exr_dump"),
        PYTHONDONTWRITEBYTECODE="1",
    )


# ---- coverage --------------------------------------------------------------------

COVERED = ["core", "exr", "povray_glue", "plugin"]
COVERAGE_MESON = [
    "unit",
    "kernels",
    "methods",
    "reference",
    "behaviour",
    "exr",
    "faults",
]
# Not faults: where gcov's own memory or writes fail too, or a signal ends it while it
# writes, it leaves counts that do not fit, and spoils those of all tests.
COVERAGE_PYTEST = ["exr", "cli", "deep", "plugin", "methods", "povray"]
NOT_COUNTED = [
    "tests/povray/test_quality.py",  # long, and reach no other lines
    "tests/deep/test_pan.py",
    "tests/deep/test_pan_plane.py",
    "tests/deep/test_pan_hosts.py",
    "tests/povray/test_run.py::test_no_memory_leaves_nothing",
    "tests/povray/test_run.py::test_signals_leave_nothing",
    "tests/povray/test_run.py::test_nohup",
]


def coverage(mode="all", *parts):
    """With `report` only what the tests so far have reached in the build there, of the
    parts named.
    """
    build = OUT / "coverage"
    if mode == "report":
        return report_coverage(build, parts or COVERED)
    build = configure(
        "coverage", "--buildtype", "debug", "-Doptimization=1", "-Db_coverage=true"
    )
    run("ninja", "-C", build)
    for path in build.rglob("*.gcda"):
        path.unlink()
    environment = environment_of(build)
    suites = [word for suite in COVERAGE_MESON for word in ("--suite", suite)]
    run("meson", "test", "-C", build, "--no-rebuild", "-t", "8", *suites, check=False)
    # ThreadSanitizer and others build their own: what is here is for this build only.
    for suite in COVERAGE_PYTEST:
        skipped = [word for name in NOT_COUNTED for word in ("--deselect", name)]
        print(pytest(f"tests/{suite}", *skipped, environment=environment)[-2000:])
    return report_coverage(build, COVERED)


def report_coverage(build, wanted):
    report = json.loads(
        captured(
            "gcovr",
            "--root",
            ROOT,
            "--json-summary",
            "--exclude-unreachable-branches",
            *(word for part in wanted for word in ("--filter", f"{part}/")),
            "--gcov-ignore-parse-errors",
            build,
            stderr=subprocess.DEVNULL,
        )
    )
    parts, files = {}, []
    for one in report["files"]:
        part = one["filename"].split("/")[0]
        total, hit = parts.get(part, (0, 0))
        parts[part] = (total + one["line_total"], hit + one["line_covered"])
        if one["line_covered"] < one["line_total"]:
            files.append((one["filename"], one["line_covered"], one["line_total"]))
    save(
        "coverage",
        parts={p: [h, t] for p, (t, h) in parts.items()},
        files=sorted(files, key=lambda f: f[1] - f[2]),
    )
    return 0 if all(hit >= 0.95 * total for total, hit in parts.values()) else 1


# ---- mutation --------------------------------------------------------------------


def mutants():
    """Wrong versions of lines in optics, depth, surfaces and compositing."""
    for number, cells in enumerate(read_table("mutants.txt"), 1):
        yield number, *cells


# The quick ones first: a mutant that they catch needs no more.
KILLERS = [
    "unit/test_optics",
    "unit/test_depth",
    "unit/test_aperture",
    "unit/test_split",
    "unit/test_sample_lists",
    "unit/test_parallel",
    "reference/test_optics",
    "reference/test_layered",
    "physics/test_identity",
    "physics/test_shape",
    "physics/test_alpha",
    "methods/test_depth_routes",
    "behaviour/test_reads",
    "physics/test_energy",
    "methods/test_artefacts",
]


PYTEST_KILLERS = [
    "deep/test_deep.py",
    "cli/test_nothing_silent.py",
    "exr/test_exr_files.py",
]


def kills(build):
    """The test that notices, or None."""
    programs = [*KILLERS, "exr/exr_dump", "faults/libfailing.so"]
    targets = ["cli/rackfocus", *(f"tests/{name}" for name in programs)]
    built = run("ninja", "-C", build, *targets, check=False, stdout=subprocess.DEVNULL)
    if built.returncode:
        raise SystemExit("a mutant does not compile")
    environment = environment_of(build)
    for name in KILLERS:
        try:
            done = run(
                build / "tests" / name,
                check=False,
                env=environment,
                stdout=subprocess.DEVNULL,
                timeout=600,
            )
        except subprocess.TimeoutExpired:
            return name
        if done.returncode:
            return name
    for name in PYTEST_KILLERS:
        text = pytest("-x", f"tests/{name}", environment=environment)
        if not re.search(r"^\d+ passed", text, re.M):
            return name
    return None


def mutate(*only):
    tree = OUT / "mutants"
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    files = captured("git", "-C", ROOT, "ls-files").split("\n")
    for name in filter(None, files):
        if (ROOT / name).is_file() and not name.startswith(("tests/quality", "docs")):
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            # New times: what an older tree has left in the build folder is made again.
            shutil.copy(ROOT / name, tree / name)
    build = configure(
        "mutation",
        "--buildtype",
        "release",
        "-Dview=disabled",
        "-Dpython=disabled",
        source=tree,
    )
    killer = kills(build)
    if killer:
        raise SystemExit(f"{killer} fails without a mutant: it would catch all of them")
    results = []
    for number, file, old, new in mutants():
        if only and str(number) not in only:
            continue
        path = tree / file
        text = path.read_text()
        if text.count(old) != 1:
            raise SystemExit(
                f"mutants.txt, {number}: '{old}' is {text.count(old)} times "
                f"in {file}"
            )
        path.write_text(text.replace(old, new))
        killer = kills(build)
        path.write_text(text)
        results.append([file, old, new, killer])
        print(f"{number}: {file}: {old} -> {new}: {killer or 'SURVIVED'}", flush=True)
    save("mutate", mutants=results, caught=sum(r[3] is not None for r in results))
    return 0 if all(r[3] for r in results) else 1


# ---- sanitizers and valgrind -------------------------------------------------------


def threads():
    """clang's ThreadSanitizer."""
    build = configure(
        "tsan",
        "--buildtype",
        "debug",
        "-Doptimization=1",
        "-Db_sanitize=thread",
        "-Db_lundef=false",
        "-Dpython=disabled",
        "-Dview=disabled",
        compiler="clang",
    )
    run("ninja", "-C", build)
    environment = environment_of(build)
    log = OUT / "tsan.log"
    options = "ignore_noninstrumented_modules=1 die_after_fork=0"
    environment["TSAN_OPTIONS"] = f"{options} log_path={log}"
    for old in OUT.glob("tsan.log.*"):
        old.unlink()
    n, failed = 0, 0
    for test in (
        "unit/test_parallel",
        "kernels/test_kernels",
        "behaviour/test_threads",
        "behaviour/test_host_threads",
        "behaviour/test_progress",
        "behaviour/test_inputs",
        "methods/test_artefacts",
        "exr/test_exr",
        "exr/test_strips",
    ):
        program = build / "tests" / test
        if not program.exists():
            continue
        text = captured(program, env=environment)
        n += len(re.findall(r"^ok ", text, re.M))
        failed += len(re.findall(r"^not ok ", text, re.M))
    for suite in ("deep", "cli/test_sequence.py"):
        names = "threads or storage or any_number or all_frames"
        text = pytest(f"tests/{suite}", "-k", names, environment=environment)
        n += int((re.findall(r"(\d+) passed", text) or [0])[0])
        failed += int((re.findall(r"(\d+) failed", text) or [0])[0])
    reports = sum(
        path.read_text(errors="replace").count("WARNING: ThreadSanitizer")
        for path in OUT.glob("tsan.log.*")
    )
    save("threads", tests=n, failed=failed, reports=reports)
    return 1 if reports or failed else 0


def valgrind():
    build = configure(
        "valgrind",
        "--buildtype",
        "debug",
        "-Doptimization=1",
        "-Dpython=disabled",
        "-Dview=disabled",
    )
    run("ninja", "-C", build)
    n_tests = n_errors = n_programs = 0
    environment = dict(environment_of(build), RACKFOCUS_CPU="avx2")
    for program in sorted((build / "tests" / "unit").glob("test_*")):
        if not os.access(program, os.X_OK) or program.is_dir():
            continue
        text = captured(
            "valgrind",
            "-q",
            "--error-exitcode=9",
            "--leak-check=full",
            "--errors-for-leak-kinds=definite",
            "--show-leak-kinds=definite",  # not glibc's cache of threads' stacks
            program,
            env=environment,
        )
        n_programs += 1
        n_tests += len(re.findall(r"^ok ", text, re.M))
        n_errors += len(
            re.findall(r"^==\d+== (Invalid|Conditional|Use of|\d.*lost)", text, re.M)
        )
    save("valgrind", programs=n_programs, tests=n_tests, errors=n_errors)
    return 1 if n_errors else 0


# ---- static analysis ---------------------------------------------------------------

ANALYSED = ["os", "core", "exr", "povray_glue", "plugin", "app", "cli"]
TIDY = (
    "-*,bugprone-*,clang-analyzer-*,-bugprone-easily-swappable-parameters,"
    "-bugprone-narrowing-conversions,-bugprone-implicit-widening-of-multiplication-result,"
    "-bugprone-reserved-identifier,-bugprone-macro-parentheses,"
    "-bugprone-multi-level-implicit-pointer-conversion,"
    "-bugprone-branch-clone,-bugprone-assignment-in-if-condition,"
    "-clang-analyzer-security.insecureAPI.DeprecatedOrUnsafeBufferHandling,"
    "-clang-analyzer-security.insecureAPI.strcpy,"
    "-bugprone-signal-handler,-bugprone-suspicious-include"
)


def is_like(line, pieces):
    return all(piece in line for piece in pieces.split(" ... "))


def static():
    build = configure("static", "--buildtype", "debug", "-Dview=disabled")
    listed = captured("ninja", "-C", build, "-t", "compdb", check=True)
    commands = json.loads(listed[listed.index("[") :])
    sources, seen = [], set()
    for one in commands:
        path = (Path(one["directory"]) / one["file"]).resolve()
        if path.suffix != ".c" or path in seen or not path.is_relative_to(ROOT):
            continue
        if path.relative_to(ROOT).parts[0] in ANALYSED and "-o" in one["command"]:
            seen.add(path)
            sources.append((path, one["command"]))
    assert sources, f"{build} compiles nothing of {', '.join(ANALYSED)}"
    (build / "compile_commands.json").write_text(json.dumps(commands))
    run("ninja", "-C", build, stdout=subprocess.DEVNULL)
    found = {"clang-tidy": [], "gcc -fanalyzer": [], "cppcheck": []}
    for path, command in sources:
        text = captured("clang-tidy", "--quiet", f"--checks={TIDY}", "-p", build, path)
        found["clang-tidy"] += re.findall(r"^.*: (?:warning|error): .*$", text, re.M)
        gcc = re.sub(r" -MD| -M[QF] \S+", "", command).split(" -o ")[0]
        gcc = re.sub(r"^(ccache )?\S+", "gcc", gcc)
        gcc = gcc.replace("-fdiagnostics-color=always", "")
        text = captured(
            "sh", "-c", f"{gcc} -fanalyzer -O1 -c {path} -o /dev/null", cwd=build
        )
        text = re.sub("^cc1: ", f"{path.name}: cc1: ", text, flags=re.M)
        found["gcc -fanalyzer"] += re.findall(r"^.*: warning: .*$", text, re.M)
    text = captured(
        "cppcheck",
        "-q",
        "--enable=warning,performance,portability",
        "--std=c11",
        "--inline-suppr",
        "-I",
        ROOT / "core/include",
        "-I",
        ROOT / "core",
        "-I",
        ROOT / "exr",
        "-I",
        ROOT / "povray_glue",
        "-D_GNU_SOURCE",
        "-DRF_LEVEL=generic",
        "-j2",
        *(ROOT / part for part in ANALYSED),
    )
    found["cppcheck"] += re.findall(
        r"^.*: (?:warning|error|performance|portability): .*$", text, re.M
    )
    excepted = list(read_table("exceptions.txt"))
    counts, left = {}, []
    for tool, lines in found.items():
        lines = sorted(set(lines))
        rest = [
            line
            for line in lines
            if not any(e[0] == tool and is_like(line, e[1]) for e in excepted)
        ]
        counts[tool] = [len(lines), len(rest)]
        left += [f"{tool}: {line}" for line in rest]
    save("static", files=len(sources), counts=counts, left=left)
    return 1 if left else 0


# ---- fuzzing and faults --------------------------------------------------------------


def fuzz(seconds="600", *targets):
    targets = targets or ("exr", "params", "camera", "filter")
    build = OUT / "fuzzing"
    build.mkdir(parents=True, exist_ok=True)
    script = ROOT / "tests/fuzz/fuzz"
    environment = dict(os.environ, RACKFOCUS_BUILD=str(build))
    run(script, "build", env=environment)

    def fuzz_one(target):
        return captured(script, "run", seconds, target, env=environment)

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        text = "\n".join(pool.map(fuzz_one, targets))
    rows = re.findall(r"^(\w+): (\d+) s, (\d+) runs, (\d+) findings", text, re.M)
    save("fuzz", targets=[[t, int(s), int(r), int(f)] for t, s, r, f in rows])
    return 1 if any(int(row[3]) for row in rows) or len(rows) < len(targets) else 0


def faults():
    build = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
    environment = environment_of(build)
    OUT.mkdir(parents=True, exist_ok=True)
    report = OUT / "faults.xml"
    text = pytest("-s", f"--junitxml={report}", "tests/faults", environment=environment)
    tests = {}
    for case in xml.etree.ElementTree.parse(report).getroot().iter("testcase"):
        bad = case.find("failure") is not None or case.find("error") is not None
        skipped = case.find("skipped") is not None
        tests[case.get("name")] = (
            "failed" if bad else "skipped" if skipped else "passed"
        )
    memory = captured(
        build / "tests/faults/test_exr_memory", ROOT / "tests/fuzz/corpus/exr"
    )
    replay = captured(ROOT / "tests/fuzz/fuzz", "replay", env=environment, check=True)
    save(
        "faults",
        tests=tests,
        allocations=sum(
            int(n) for n in re.findall(r": (\d+) allocations failed", text)
        ),
        killed=sum(int(n) for n in re.findall(r"killed (\d+) times", text)),
        exr_allocations=sum(
            int(n) for n in re.findall(r"# (\d+) allocations failed", memory)
        ),
        exr_failed=len(re.findall(r"^not ok", memory, re.M)),
        corpus=sum(int(n) for n in re.findall(r"^\w+: (\d+) files$", replay, re.M)),
        damaged=damage(build),
    )
    return 1 if "failed" in tests.values() else 0


def damage(build):
    """The seed files cut off in steps and with flipped bits, filtered."""
    import random

    rng = random.Random(1)
    counts = {"files": 0, "refused": 0, "crashed": 0}
    path = OUT / "damaged.exr"
    for source in sorted((ROOT / "tests/fuzz/corpus/exr").glob("*.exr")):
        data = source.read_bytes()
        for k in range(40):
            bad = bytearray(data)
            if k < 12:
                bad = bad[: len(bad) * (k + 1) // 13]
            else:
                for _ in range(1 + k % 3):
                    bad[rng.randrange(len(bad))] ^= 1 << rng.randrange(8)
            path.write_bytes(bad)
            done = subprocess.run(
                [
                    build / "cli" / "rackfocus",
                    "filter",
                    path,
                    "-q",
                    "-j1",
                    "-o",
                    OUT / "damaged_out.exr",
                ],
                capture_output=True,
                timeout=60,
            )
            counts["files"] += 1
            counts["refused"] += done.returncode == 1
            counts["crashed"] += done.returncode not in (0, 1)
    return counts


DEBIAN_SOURCES = """Types: deb-src
URIs: {mirror}
Suites: stable
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
"""


def unpack_exr(archive, folder):
    run("tar", "-xf", archive, "--wildcards", "*.exr", cwd=folder)
    for path in list(folder.rglob("src/**/*.exr")):
        path.rename(folder / path.name)


def fetch_from_debian(folder):
    """By apt with lists of its own."""
    (folder / "lists" / "partial").mkdir(parents=True, exist_ok=True)
    (folder / "debian.sources").write_text(DEBIAN_SOURCES.format(mirror=mirror()))
    apt = [
        "apt-get",
        "-qq",
        *("-o", "Dir::Etc::SourceList=/dev/null"),
        *("-o", f"Dir::Etc::SourceParts={folder}"),
        *("-o", f"Dir::State::Lists={folder / 'lists'}"),
    ]
    run(*apt, "update", cwd=folder)
    # The tar file alone: all that is wanted, and mirrors may lack the rest.
    run(*apt, "source", "--download-only", "--tar-only", "openexr", cwd=folder)
    unpack_exr(next(folder.glob("openexr_*.orig.tar.*z*")), folder)


def fetch_from_pypi(folder):
    """The package for Python has the whole source; pip builds its metadata, minutes."""
    pip = ["python3", "-m", "pip", "-q", "download", "--no-deps", "--no-binary"]
    run(*pip, "OpenEXR", "OpenEXR==3.5.3", cwd=folder)
    unpack_exr(next(folder.glob("openexr-*.tar.gz")), folder)


OPENEXR_SOURCES = {
    "debian": ("openexr", fetch_from_debian),
    "pypi": ("openexr_pypi", fetch_from_pypi),
}


def openexr_files(source):
    """OpenEXR's own test files, good and damaged."""
    name, fetch = OPENEXR_SOURCES[source]
    folder = OUT / name
    folder.mkdir(parents=True, exist_ok=True)
    if not list(folder.glob("*.exr")):
        fetch(folder)
    return sorted(folder.glob("*.exr"))


def openexr(source="debian"):
    build = Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
    files = openexr_files(source)
    counts = {"files": len(files), "refused": 0, "crashed": 0, "findings": 0}
    for path in files:
        refused, crashed = False, False
        for command in (
            [build / "cli/rackfocus", "info", path],
            [build / "tests/exr/exr_dump", "read", path, "0", OUT / "samples.raw"],
        ):
            done = subprocess.run(command, capture_output=True, timeout=120)
            refused |= done.returncode == 1
            crashed |= done.returncode not in (0, 1)
        counts["refused"] += refused
        counts["crashed"] += crashed
    fuzzing = OUT / "fuzzing"
    fuzzing.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, RACKFOCUS_BUILD=str(fuzzing))
    captured(ROOT / "tests/fuzz/fuzz", "build", env=environment, check=True)
    for path in files:
        done = run(
            fuzzing / "fuzz/fuzz_exr",
            "-rss_limit_mb=2560",
            path,
            check=False,
            capture_output=True,
        )
        counts["findings"] += done.returncode != 0
    save(OPENEXR_SOURCES[source][0], **counts)
    return 1 if counts["crashed"] or counts["findings"] or not files else 0


TOOLS = {
    "coverage": ["gcovr"],
    "threads": ["clang"],
    "valgrind": ["valgrind"],
    "static": ["clang-tidy", "cppcheck"],
    "fuzz": ["clang"],
    "faults": ["clang"],
    "openexr": ["clang", "apt-get"],
}


def main():
    checks = {
        f.__name__: f
        for f in (
            coverage,
            mutate,
            threads,
            valgrind,
            static,
            fuzz,
            faults,
            openexr,
            table,
        )
    }
    if len(sys.argv) < 2 or sys.argv[1] not in checks:
        print(__doc__)
        return 2
    global COMMIT
    COMMIT = commit()
    need(*TOOLS.get(sys.argv[1], []))
    return checks[sys.argv[1]](*sys.argv[2:]) or 0


if __name__ == "__main__":
    sys.exit(main())
