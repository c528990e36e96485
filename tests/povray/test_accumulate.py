# SPDX-License-Identifier: Apache-2.0
"""`rackfocus povray --method accumulate`: views from points of the lens, averaged."""

import os
import re
import signal
import subprocess
import sys
import time

import numpy
import pytest
from conftest import HERE, read_exr

sys.path.insert(0, str(HERE.parent / "cli"))
import plainexr  # noqa: E402

SIZE = ["--", "+W160", "+H120"]
#: Where plane_in_focus.pov shows only its plane, in parts of the picture.
PLANE = (slice(15, 105), slice(26, 70))
#: A sphere that moves by 8 units per unit of the clock, before a camera that may move.
MOVING = """
#version 3.7;
global_settings {{ assumed_gamma 1 }}
camera {{ location <{camera},0,-10> direction z*2 right x*4/3 up y
          aperture {aperture} focal_point <{camera},0,0> blur_samples 20 }}
sphere {{ <{sphere},0,0>,0.15 pigment {{ rgb 1 }} finish {{ ambient 1 diffuse 0 }} }}
"""
#: px per scene unit in the plane of the sphere, at 160 x 120.
SCALE = 120 * 2 / 10


def rgb(path):
    channels = read_exr(path)
    return numpy.stack([channels[name] for name in "RGB"], -1).astype(float)


def encoded(picture):
    return numpy.clip(picture, 0, 1) ** (1 / 2.2)


def rms(a, b):
    return numpy.sqrt(((encoded(a) - encoded(b))[PLANE] ** 2).mean())


def accumulate(rackfocus, scene, out, *options, povray=(), **more):
    rackfocus(
        "povray", scene, "--method", "accumulate", "-o", out, *options, *SIZE, *povray,
        **more,
    )  # fmt: skip
    return rgb(out)


def povray_itself(scene, out, *options, cwd):
    command = ["povray", f"+I{scene}", f"+O{out}", "+FE", "-D", *SIZE[1:], *options]
    subprocess.run(command, cwd=cwd, check=True, capture_output=True)
    return rgb(out)


def test_the_plane_in_focus_is_as_sharp_as_the_pinhole(rackfocus, tmp_path):
    """Shift: no difference at all, where POV-Ray's lens is noisy; look-at blurs it."""
    name = "plane_in_focus.pov"
    pictures = {
        move: accumulate(rackfocus, name, tmp_path / f"{move}.exr", "--views", 16,
                         "--camera-move", move)
        for move in ("shift", "look-at")
    }  # fmt: skip
    scenes = tmp_path / "scenes"
    host = povray_itself(name, tmp_path / "host.exr", cwd=scenes)
    text = (scenes / name).read_text()
    text = re.sub(r"aperture 2 [^}]*", "", text)
    (scenes / "pinhole.pov").write_text(text)
    pinhole = povray_itself(
        "pinhole.pov", tmp_path / "pin.exr", "+A0.1", "+AM1", "+R2", "-J", cwd=scenes
    )
    noise = rms(host, pinhole)
    print("host", noise, {m: rms(p, pinhole) for m, p in pictures.items()})
    assert noise > 0.01
    assert rms(pictures["shift"], pinhole) < 0.1 * noise
    assert rms(pictures["look-at"], pinhole) > noise
    # Where look-at looks, it is as sharp; out of focus the lens is at work in both.
    middle = (slice(56, 64), slice(72, 80))
    for picture in pictures.values():
        assert (
            numpy.abs(encoded(picture)[middle] - encoded(pinhole)[middle]).max() < 0.1
        )
        assert numpy.abs(picture - pinhole).max() > 0.2


def test_more_views_come_closer_to_the_hosts_lens(rackfocus, tmp_path):
    out = tmp_path / "out.exr"
    scores = []
    for n in (4, 32):
        done = rackfocus(
            "povray", "plane_in_focus.pov", "--method", "accumulate", "--subpixel",
            "--views", n, "-o", out, *(["--reference", 400] if n == 32 else []), *SIZE,
        )  # fmt: skip
        picture = rgb(out)
        if n == 4:
            first = picture
        else:
            scores.append(float(re.search(r"tPSNR ([0-9.]+)", done.stdout).group(1)))
    print(scores)
    assert scores[0] > 30
    assert numpy.abs(first - picture).max() > 0.1


@pytest.mark.parametrize("gamma", [1, 2.2])
def test_the_mean_is_that_of_the_kept_views(rackfocus, tmp_path, gamma):
    """In the scene's working space; rackfocus accumulate reads it from the header."""
    text = MOVING.format(camera=0, aperture=3, sphere=1)
    text = text.replace("assumed_gamma 1", f"assumed_gamma {gamma}")
    (tmp_path / "scene.pov").write_text(text)
    mean = accumulate(rackfocus, "scene.pov", tmp_path / "out.exr", "--views", 5,
                      "--keep", tmp_path / "kept", cwd=tmp_path)  # fmt: skip
    paths = sorted((tmp_path / "kept").iterdir())
    assert [path.name for path in paths] == [f"view_{i:04}.exr" for i in range(5)]
    total = sum(rgb(path) ** (1 / gamma) for path in paths)
    assert mean == pytest.approx((total / 5) ** gamma, abs=1e-6)
    rackfocus("accumulate", *paths, "-o", tmp_path / "again.exr")
    assert rgb(tmp_path / "again.exr") == pytest.approx(mean, abs=1e-6)
    rackfocus("accumulate", *paths, "-o", tmp_path / "linear.exr", "--blend-gamma", 1)
    linear = rgb(tmp_path / "linear.exr")
    assert linear == pytest.approx(sum(map(rgb, paths)) / 5, abs=1e-6)


def test_views_stand_where_the_pattern_says(rackfocus, tmp_path):
    """An object behind the focus follows the camera; one corner of a square each."""
    text = MOVING.format(camera=0, aperture=2, sphere=0).replace("0,0>,0.15", "0,30>,1")
    (tmp_path / "scene.pov").write_text(text)
    accumulate(rackfocus, "scene.pov", tmp_path / "out.exr", "--views", 4, "--keep",
               tmp_path / "kept", "--lens-pattern", "circle", cwd=tmp_path)  # fmt: skip
    shift = 0.5 * 120 * 2 * (1 / 10 - 1 / 40)
    for i, path in enumerate(sorted((tmp_path / "kept").iterdir())):
        _, facts = plainexr.read(path)
        u, v = facts["rackfocus:lensOffset"]
        angle = i * numpy.pi / 2
        assert (u, v) == pytest.approx(
            (0.5 * numpy.cos(angle), 0.5 * numpy.sin(angle)), abs=1e-6
        )
        light = rgb(path)[..., 1]
        y, x = numpy.mgrid[0:120, 0:160] + 0.5
        centre = [(light * at).sum() / light.sum() for at in (x, y)]
        want = [80 + shift * numpy.cos(angle), 60 - shift * numpy.sin(angle)]
        assert centre == pytest.approx(want, abs=0.1)


@pytest.mark.parametrize("n", [5, 8])
def test_what_is_far_out_of_focus_shows_as_copies(rackfocus, tmp_path, n):
    """The known artefact: one copy per view, each with an n-th of the light."""
    text = MOVING.format(camera=0, aperture=8, sphere=0).replace("0,0>,0.15", "0,60>,1")
    (tmp_path / "scene.pov").write_text(text)
    mean = accumulate(rackfocus, "scene.pov", tmp_path / "out.exr", "--views", n,
                      "--lens-pattern", "circle", cwd=tmp_path)[..., 1]  # fmt: skip
    lit = {tuple(place) for place in numpy.argwhere(mean > 0.2 / n)}
    n_copies = 0
    while lit:
        n_copies += 1
        front = [lit.pop()]
        while front:
            y, x = front.pop()
            near = {(y + j, x + i) for j in (-1, 0, 1) for i in (-1, 0, 1)} & lit
            lit -= near
            front += near
    assert n_copies == n
    assert mean.max() == pytest.approx(1 / n, rel=0.05)


# ---- time ----------------------------------------------------------------------------


def extent(picture):
    """Where the light of a picture begins, ends and has its middle, px along x."""
    columns = picture[..., 1].sum(axis=0)
    lit = numpy.flatnonzero(columns > 1e-3)
    middle = (columns * (numpy.arange(columns.size) + 0.5)).sum() / columns.sum()
    return lit[0], lit[-1] + 1, middle


@pytest.mark.parametrize(
    "camera, sphere", [("0", "8*clock-4"), ("4-8*clock", "0"), ("8*clock", "8*clock")]
)
def test_the_shutter_spreads_what_moves(rackfocus, tmp_path, camera, sphere):
    """Object or camera; 0.1 of the clock about 0.5 are 0.8 units, both alike none."""
    path = tmp_path / "scene.pov"
    path.write_text(MOVING.format(camera=camera, aperture="1e-6", sphere=sphere))
    out = tmp_path / "out.exr"
    options = ["--views", 8, "--shutter", 0.1]
    moving = accumulate(rackfocus, path.name, out, *options, povray=["+K0.5"],
                        cwd=tmp_path)  # fmt: skip
    still = accumulate(rackfocus, path.name, out, "--views", 2, povray=["+K0.5"],
                       cwd=tmp_path)  # fmt: skip
    begin, end, middle = extent(moving)
    assert extent(still)[2] == pytest.approx(80, abs=0.2)
    assert middle == pytest.approx(80, abs=0.3)
    length = end - begin - (extent(still)[1] - extent(still)[0])
    want = 0 if camera == sphere else 0.8 * SCALE * 7 / 8
    assert length == pytest.approx(want, abs=2)
    assert moving.sum() == pytest.approx(still.sum(), rel=0.03)


def test_the_shutter_of_an_animation_is_in_frames(rackfocus, tmp_path):
    """Frame 3 of 1 to 5, clock 0 to 1: 0.5 of a frame is 0.125 of the clock."""
    path = tmp_path / "scene.pov"
    text = MOVING.format(camera="0", aperture="1e-6", sphere="8*clock-4")
    path.write_text(text + '#if(frame_number!=3|final_frame!=5) #error "" #end\n')
    options = ["--method", "accumulate", "--views", 8, "--frames", "3-3"]
    povray = [*SIZE, "+KFI1", "+KFF5"]
    rackfocus("povray", path.name, *options, "--shutter", 0.5, "-o", "o.exr", *povray,
              cwd=tmp_path)  # fmt: skip
    rackfocus("povray", path.name, *options, "-o", "s.exr", *povray, cwd=tmp_path)
    moving, still = (extent(rgb(tmp_path / f"{n}0003.exr")) for n in "os")
    assert moving[2] == pytest.approx(still[2], abs=0.3)
    length = moving[1] - moving[0] - (still[1] - still[0])
    assert length == pytest.approx(0.125 * 8 * SCALE * 7 / 8, abs=2)


def test_random_points_differ_from_frame_to_frame(rackfocus, tmp_path):
    (tmp_path / "scene.pov").write_text(MOVING.format(camera=0, aperture=4, sphere=0)
                                        .replace("0,0>,0.15", "0,30>,1"))  # fmt: skip
    options = ["--method", "accumulate", "--views", 3, "--frames", "1-2"]
    for name, more in (("fixed", []), ("random", ["--lens-random"])):
        rackfocus("povray", "scene.pov", *options, *more, "-o", f"{name}.exr", *SIZE,
                  cwd=tmp_path)  # fmt: skip
        a, b = (rgb(tmp_path / f"{name}000{i}.exr") for i in (1, 2))
        assert numpy.array_equal(a, b) == (name == "fixed")


# ---- the run -------------------------------------------------------------------------


def watch(binary, scene, n, private):
    """Largest memory of the command in MB, and most pictures in its private folder."""
    command = [binary, "povray", scene, "--method", "accumulate", "--views", str(n),
               "-o", "out.exr", *SIZE[:1], "+W400", "+H300", "-A"]  # fmt: skip
    done = subprocess.Popen(
        command, cwd=scene.parent, env={**os.environ, "TMPDIR": str(private)},
        stdout=subprocess.DEVNULL,
    )  # fmt: skip
    peak = n_files = 0
    while done.poll() is None:
        try:
            with open(f"/proc/{done.pid}/status") as file:
                found = re.search(r"VmHWM:\s+(\d+)", file.read())
        except OSError:
            break
        peak = max(peak, int(found.group(1)) / 1024 if found else 0)
        walked = os.walk(private)  # unlike glob(), bears folders that vanish
        n_exr = sum(f.endswith(".exr") for _, _, files in walked for f in files)
        n_files = max(n_files, n_exr)
        time.sleep(0.02)
    assert done.wait() == 0
    return peak, n_files


def test_neither_memory_nor_disk_grows_with_the_views(binary, tmp_path):
    """A view is 2 MB of floats; half of 12 of them would show. A busy machine misses some
    of the last peak: of 4 views 11.6 MB in place of 16.
    """
    scene = tmp_path / "scene.pov"
    scene.write_text(MOVING.format(camera=0, aperture=1, sphere=0))
    private = tmp_path / "private"
    private.mkdir()
    few, many = (watch(binary, scene, n, private) for n in (4, 16))
    print(few, many)
    assert many[0] < few[0] + 12
    assert many[1] <= 3 and few[1] >= 1


def test_interruption_leaves_nothing(binary, tmp_path):
    scene = tmp_path / "scene.pov"
    scene.write_text(MOVING.format(camera=0, aperture=1, sphere=0))
    private = tmp_path / "private"
    private.mkdir()
    done = subprocess.Popen(
        [binary, "povray", scene, "--method", "accumulate", "--views", "1024", "-o",
         "out.exr", *SIZE],
        cwd=tmp_path, env={**os.environ, "TMPDIR": str(private)},
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while not list(private.glob("*/lens*")) and time.monotonic() < deadline:
        time.sleep(0.05)
    done.send_signal(signal.SIGINT)
    assert done.wait(30) == 130
    assert not list(private.iterdir())
    assert not (tmp_path / "out.exr").exists()


def test_the_result_says_how_it_was_made(rackfocus, tmp_path):
    (tmp_path / "scene.pov").write_text(MOVING.format(camera=0, aperture=1, sphere=0))
    out = tmp_path / "out.exr"
    accumulate(rackfocus, "scene.pov", out, "--views", 2, "--lens-pattern", "grid",
               cwd=tmp_path)  # fmt: skip
    assert b"--method accumulate --lens-pattern grid, 2 views" in out.read_bytes()
    png = tmp_path / "out.png"
    rackfocus("povray", "scene.pov", "--method", "accumulate", "--views", 2, "-o", png,
              *SIZE, cwd=tmp_path)  # fmt: skip
    done = rackfocus("compare", png, out)
    assert float(re.search(r"tPSNR ([0-9.]+)", done.stdout.splitlines()[-1])[1]) > 45


@pytest.mark.parametrize(
    "options, text",
    [
        (["--method", "accumulate", "--views", 1], "takes 2 to 1024"),
        (["--method", "accumulate", "--views", 1025], "1024"),
        (["--views", 65], "views takes 1 to 64"),
        (["--method", "accumulate", "--f-stop", 2, "--optics", "yu"], "--aperture"),
        (["--method", "accumulate", "--keep", "x.exr"], "takes a folder"),
        (["--shutter", 1], "--method accumulate"),
        (["--subpixel"], "--method accumulate"),
        (["--method", "accumulate", "--camera-move", "up"], "look-at"),
    ],
)
def test_wrong_usage(rackfocus, tmp_path, options, text):
    done = rackfocus("povray", "plane_in_focus.pov", "-o", "o.exr", *options, code=2)
    assert text in done.stderr


def test_a_polygon_needs_blades(rackfocus, tmp_path):
    done = rackfocus(
        "povray", "plane_in_focus.pov", "-o", "o.exr", "--method", "accumulate",
        "--lens-pattern", "polygon", code=1,
    )  # fmt: skip
    assert "blades" in done.stderr


TILTED = """
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0,1,-4> look_at <0,0.6,0> right x*4/3 aperture 0.25
         focal_point <0,0,6> blur_samples 20 }
plane { y, 0 pigment { checker rgb 0.9 rgb 0.2 scale 0.35 } finish { ambient 1 diffuse 0 } }
"""


def test_a_tilted_plane_is_in_focus(rackfocus, tmp_path):
    """Its views are as the filter's tilted lens: the floor sharp from near to far."""
    scene = tmp_path / "s.pov"
    scene.write_text(TILTED)
    # 1 below the camera the floor's 1 / z grows by 1 per tangent down, so sin A is f.
    tilt = ("--tilt-y", "-2.87")
    views = ("--views", "64", "--subpixel")
    flat = accumulate(rackfocus, scene, tmp_path / "flat.exr", *views)
    made = accumulate(rackfocus, scene, tmp_path / "tilted.exr", *views, *tilt)
    rackfocus("povray", scene, "-o", tmp_path / "one.exr", *tilt, *SIZE)
    one = rgb(tmp_path / "one.exr")
    off = [((encoded(a) - encoded(one)) ** 2).mean() for a in (made, flat)]
    assert off[0] < 0.1 * off[1], off
    near = made[-20:]  # rows that the plane without a tilt blurs by several px
    assert near.std() > 1.2 * flat[-20:].std()


@pytest.mark.parametrize(
    "words, said, code",
    [
        (["--field-curvature", "0.1"], "take --method views", 2),
        (["--tilt-x", "3", "--camera-move", "look-at"], "look-at has no plane", 2),
        (["--cat-eye", "0.5", "--strict"], "--cat-eye has no effect with", 2),
        (["--supersample", "3", "--strict"], "--supersample has no effect with", 2),
        (["--overscan", "9", "--strict"], "--overscan has no effect with", 2),
        (["--through-glass", "--strict"], "--through-glass has no effect with", 2),
    ],
)
def test_what_views_cannot_have_is_said(rackfocus, tmp_path, words, said, code):
    (tmp_path / "s.pov").write_text(TILTED)
    done = rackfocus("povray", tmp_path / "s.pov", "--method", "accumulate", "-o",
                     tmp_path / "o.exr", *words, *SIZE, code=code)  # fmt: skip
    assert said in done.stderr
