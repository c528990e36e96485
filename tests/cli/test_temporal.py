# SPDX-License-Identifier: Apache-2.0
"""--temporal: what a frame hides is taken from those beside it.

A camera moves past thin blurred posts before a pattern in focus, so every frame's true
picture is a mean over the lens that can be computed.
"""

import os

import numpy
import plainexr
import pytest

SIZE = WIDTH, HEIGHT = 96, 48
FOCAL_PX, RADIUS, FOCUS, NEAR = 100, 0.2, 8.0, 2.0
STEP_PX = 3  # that the pattern moves from frame to frame, and the posts 4 times as far
CAMERA = STEP_PX * FOCUS / FOCAL_PX  # scene units, from frame to frame
N_FRAMES = 7
POSTS = [-40.0, -15.0, 10.0, 35.0, 60.0, 85.0, 110.0, 135.0]
LENS = ["--lens-radius", RADIUS, "--focal-length-px", FOCAL_PX]
LENS += ["--focus-distance", FOCUS]

PATTERN = numpy.random.default_rng(5).uniform(0.1, 0.9, (HEIGHT, 8 * WIDTH))


def is_post(x, frame):
    """Does a post cover x, px, of a frame? 5 px wide."""
    x = x + frame * STEP_PX * FOCUS / NEAR
    return numpy.any([abs(x - 72 - post) < 2.5 for post in POSTS], axis=0)


def pattern(frame):
    left = 2 * WIDTH + frame * STEP_PX
    return PATTERN[:, left : left + WIDTH]


def pinhole(frame):
    x = numpy.arange(WIDTH) + 0.5
    post = numpy.broadcast_to(is_post(x, frame), (HEIGHT, WIDTH))
    return numpy.where(post, 0.3, pattern(frame)), post


def truth(frame):
    x = numpy.arange(WIDTH) + 0.5
    reach = FOCAL_PX * RADIUS * (1 / NEAR - 1 / FOCUS)
    u = numpy.linspace(-1, 1, 129)[1:-1]
    share = numpy.sqrt(1 - u**2)
    covered = sum(w * is_post(x + reach * a, frame) for a, w in zip(u, share))
    covered = covered / share.sum()
    return covered * 0.3 + (1 - covered) * pattern(frame)


def matrix(frame, up=1, ahead=-1):
    """worldToCamera of a camera at x = frame CAMERA, turned and scaled arbitrarily by
    the world's own axes."""
    camera = numpy.diag([1.0, up, ahead, 1.0])
    place = numpy.eye(4)
    place[3, 0] = -frame * CAMERA
    angle = 0.7
    turn = numpy.eye(4)
    turn[0, 0] = turn[1, 1] = numpy.cos(angle)
    turn[0, 1] = numpy.sin(angle)
    turn[1, 0] = -turn[0, 1]
    return tuple((turn @ place @ camera).ravel())


def vectors(frame, names):
    """How far what is seen moves, by the names of the channels; px, y is up."""
    _, post = pinhole(frame)
    px = numpy.where(post, STEP_PX * FOCUS / NEAR, STEP_PX).astype(numpy.float32)
    zero = numpy.zeros_like(px)
    if names == "blender":  # to before, and from after to here
        of = {"X": px, "Y": zero, "Z": px, "W": zero}
        return {f"View.Vector.{name}": value for name, value in of.items()}
    return {
        "forward.u": -px,
        "forward.v": zero,
        "backward.u": px,
        "backward.v": zero,
    }


@pytest.fixture
def shot(tmp_path):
    def make(attributes=None, channels=None, numbers=range(1, N_FRAMES + 1)):
        for i in numbers:
            grey, post = pinhole(i)
            all_channels = {name: grey.astype(numpy.float32) for name in "RGB"}
            all_channels["Z"] = numpy.where(post, NEAR, FOCUS).astype(numpy.float32)
            all_channels.update(channels(i) if channels else {})
            path = tmp_path / f"shot.{i:04d}.exr"
            plainexr.write(path, all_channels, attributes(i) if attributes else None)
        return tmp_path / "shot.####.exr"

    return make


@pytest.fixture
def run(rackfocus, tmp_path):
    def filter_shot(pattern, *arguments, name="out", code=0):
        return rackfocus(
            "filter",
            pattern,
            "-o",
            tmp_path / f"{name}.####.exr",
            "--type",
            "float",
            *LENS,
            *arguments,
            code=code,
        )

    filter_shot.rackfocus = rackfocus
    return filter_shot


def with_camera(frame, **axes):
    return {"worldToCamera": matrix(frame, **axes)}


def error_of(tmp_path, frame, name="out", of=None, light=1):
    """Root mean square, away from the border."""
    import OpenImageIO

    file = OpenImageIO.ImageInput.open(str(tmp_path / f"{name}.{frame:04d}.exr"))
    got = file.read_image(format="float")[..., 1]
    file.close()
    inner = numpy.s_[8:-8, 16:-16]
    return numpy.sqrt(((got - light * truth(of or frame))[inner] ** 2).mean())


@pytest.mark.parametrize(
    "axes",
    [{"up": 1, "ahead": -1}, {"up": 1, "ahead": 1}, {"up": -1, "ahead": 1}],
    ids=["back", "ahead", "down"],
)
def test_cameras_say_what_is_hidden(run, shot, tmp_path, axes):
    pattern = shot(lambda i: with_camera(i, **axes))
    run(pattern, name="alone")
    run(pattern, "--temporal", 2)
    for i in (3, 4, 5):
        alone, together = error_of(tmp_path, i, "alone"), error_of(tmp_path, i)
        assert together < alone / 3, f"frame {i}: {alone:.4f}, {together:.4f}"


def test_what_most_frames_show_counts(run, shot, tmp_path):
    """A bird that one frame alone shows does not hide what the others see there."""

    def with_bird(i):
        if i != 5:
            return {}
        grey, post = pinhole(i)
        bird = numpy.zeros_like(post)
        bird[:, 51:55] = True  # behind the post at 59 in frame 4
        assert not (bird & post).any()
        colour = numpy.where(bird, 1.5, grey).astype(numpy.float32)
        depth = numpy.where(bird, 4.0, numpy.where(post, NEAR, FOCUS))
        return {"R": colour, "G": colour, "B": colour, "Z": depth.astype("float32")}

    run(shot(with_camera, with_bird), "--temporal", 2, "--frames", "4")
    with_it = error_of(tmp_path, 4)
    run(shot(with_camera), "--temporal", 2, "--frames", "4", name="without")
    assert with_it < 1.5 * error_of(tmp_path, 4, "without")


def test_lamps_beyond_the_border_shine(run, shot, tmp_path):
    """A lamp that has just left the picture keeps a part of its disc in it."""

    def with_lamp(brightness):
        def channels(i):
            grey = numpy.full((HEIGHT, WIDTH), 0.2, numpy.float32)
            if i == 5:
                grey[24, 0] = brightness  # 0.6 px farther left in frame 6
            depth = numpy.full_like(grey, 40)  # of radius 2 px
            return {"R": grey, "G": grey, "B": grey, "Z": depth}

        return channels

    lit = []
    for brightness in (0.2, 200):
        shot(with_camera, with_lamp(brightness))
        run(tmp_path / "shot.####.exr", "--temporal", 1, "--frames", "6", "--anew")
        lit.append(plainexr.read(tmp_path / "out.0006.exr")[0]["G"].sum())
    # Six tenths of it are beyond; of a disc whose middle is 0.5 px outside, 0.34 shows.
    assert 0.6 * 200 * 0.25 < lit[1] - lit[0] < 0.6 * 200 * 0.45


def wall(frame):
    """Columns of a striped wall as near as the posts."""
    left = 2 * WIDTH + int(frame * STEP_PX * FOCUS / NEAR)
    return PATTERN[0], left


def blurred_wall(frame):
    stripes, left = wall(frame)
    x = left + numpy.arange(WIDTH)
    reach = FOCAL_PX * RADIUS * (1 / NEAR - 1 / FOCUS)
    u = numpy.linspace(-1, 1, 513)[1:-1]
    share = numpy.sqrt(1 - u**2)
    seen = [stripes[numpy.floor(x + 0.5 + reach * a).astype(int)] for a in u]
    return numpy.average(seen, axis=0, weights=share)


@pytest.mark.parametrize("says", ["matrices", "vectors"])
def test_what_lies_beyond_the_border_is_known(run, shot, tmp_path, says):
    """The frame before shows what lies beyond one side, the next beyond the other; what
    neither shows makes nothing darker."""

    def channels(i):
        stripes, left = wall(i)
        grey = numpy.tile(stripes[left : left + WIDTH], (HEIGHT, 1))
        grey = grey.astype(numpy.float32)
        if i != 4:
            grey[:12] = numpy.nan
        of = {name: grey for name in "RGB"} | {"Z": numpy.full_like(grey, NEAR)}
        if says == "vectors":
            px = numpy.full_like(grey, STEP_PX * FOCUS / NEAR)
            zero = numpy.zeros_like(grey)
            names = ("Vector.X", "Vector.Y", "Vector.Z", "Vector.W")
            of |= {f"View.{n}": v for n, v in zip(names, (px, zero, px, zero))}
        return of

    pattern = shot(with_camera if says == "matrices" else None, channels)
    run(pattern, "--temporal", 1, "--frames", "4")
    run(pattern, "--frames", "4", name="alone")
    sides = numpy.r_[0:6, WIDTH - 6 : WIDTH]
    known, alone = (
        plainexr.read(tmp_path / f"{name}.0004.exr")[0]["G"][:, sides]
        for name in ("out", "alone")
    )
    true = blurred_wall(4)[sides]
    errors = [((got - true)[22:-4] ** 2).mean() for got in (known, alone)]
    assert errors[0] < 0.05 * errors[1]
    assert known[:4].mean() == pytest.approx(alone[:4].mean(), rel=0.05)


@pytest.mark.parametrize("name", ["right.{0}.{1}", "{0}.right.{1}"])
def test_an_eye_has_its_own_vectors(run, shot, tmp_path, name):
    """Those of the other one, which stand first, lead elsewhere."""
    frames = ("--temporal", 1, "--frames", "4")
    run(shot(channels=lambda i: vectors(i, "nuke")), *frames, name="want")

    def both(i):
        grey, post = pinhole(i)
        own = {f"right.{c}": grey.astype(numpy.float32) for c in "RGB"}
        own["right.Z"] = numpy.where(post, NEAR, FOCUS).astype(numpy.float32)
        for channel, px in vectors(i, "nuke").items():
            own |= {channel: -3 * px, name.format(*channel.split(".")): px}
        return own

    pattern = shot(lambda i: {"multiView": ["left", "right"]}, both)
    run(pattern, *frames, "--layer", "right")
    got, want = (plainexr.read(tmp_path / f"{n}.0004.exr")[0] for n in ("out", "want"))
    assert (got["G"] == want["G"]).all()


def test_too_many_lights_are_told(run, shot, tmp_path):
    """A bright wall behind posts is no lamp."""

    def bright(i):
        grey, post = pinhole(i)
        grey = numpy.where(post, grey, 20 * grey + 3).astype(numpy.float32)
        return {name: grey for name in "RGB"}

    frames = ["--temporal", 1, "--frames", "4"]
    done = run(shot(with_camera, bright), *frames, "--white", 1)
    assert "some are left out" in done.stderr and "shot.0004.exr" in done.stderr
    assert (tmp_path / "out.0004.exr").exists()
    for options in (["--white", 1, "--no-exact-highlights"], []):
        told = run(tmp_path / "shot.####.exr", *frames, "--anew", *options)
        assert "left out" not in told.stderr


@pytest.mark.parametrize("says", ["matrices", "vectors"])
def test_a_spoilt_frame_spoils_no_other(run, shot, tmp_path, says):
    """Pixels that are no number show nothing; the frame that has them is named."""

    def spoilt(i):
        grey, _ = pinhole(i)
        grey = grey.astype(numpy.float32)
        if i == 4:
            grey[11:14] = numpy.nan
        return {name: grey for name in "RGB"}

    if says == "matrices":
        pattern = shot(with_camera, spoilt)
    else:
        pattern = shot(channels=lambda i: spoilt(i) | vectors(i, "blender"))
    done = run(pattern, "--temporal", 1, code=1)
    assert "6 filtered, 0 skipped, 1 failed" in done.stdout
    assert "shot.0004.exr: 864 colour values are NaN" in done.stderr
    run(pattern, "--frames", "3,5", name="alone")
    for i in (3, 5):
        assert error_of(tmp_path, i) < error_of(tmp_path, i, "alone")


@pytest.mark.parametrize("names", ["blender", "nuke"])
def test_vectors_say_it_too(run, shot, tmp_path, names):
    pattern = shot(channels=lambda i: vectors(i, names))
    run(pattern, name="alone")
    run(pattern, "--temporal", 1)
    for i in (3, 4, 5):
        alone, together = error_of(tmp_path, i, "alone"), error_of(tmp_path, i)
        assert together < alone / 3, f"frame {i}: {alone:.4f}, {together:.4f}"


def test_a_frame_does_not_depend_on_which_are_made(run, shot, tmp_path):
    pattern = shot(with_camera)
    run(pattern, "--temporal", 2)
    run(pattern, "--temporal", 2, "--frames", "4", "-j", 1, name="one")
    whole = (tmp_path / "out.0004.exr").read_bytes()
    assert (tmp_path / "one.0004.exr").read_bytes() == whole


def test_a_shot_takes_three_on_each_side(run, shot, tmp_path, rackfocus):
    """--preset shot is --temporal 3; what is typed wins; one picture is no shot."""
    pattern = shot(with_camera)
    run(pattern, "--preset", "shot")
    assert "7 skipped" in run(pattern, "--temporal", 3).stdout
    assert "7 filtered" in run(pattern, "--preset", "shot", "--temporal", 1).stdout
    assert "7 filtered" in run(pattern, "--preset", "still").stdout
    assert "7 skipped" in run(pattern).stdout
    one = tmp_path / "shot.0004.exr"
    done = rackfocus("filter", one, "-o", tmp_path / "one.exr", "--preset", "shot",
                     code=2)  # fmt: skip
    assert "--preset shot: is for sequences" in done.stderr


def test_frames_beside_are_inputs(run, shot, tmp_path):
    """A frame is made again when one beside it has changed, and only then."""
    pattern = shot(with_camera)
    run(pattern, "--temporal", 1)
    assert "7 skipped" in run(pattern, "--temporal", 1).stdout
    os.utime(tmp_path / "shot.0004.exr", (1, 1))
    assert "3 filtered, 4 skipped" in run(pattern, "--temporal", 1).stdout
    assert "7 filtered" in run(pattern, "--temporal", 2).stdout


def test_frames_beside_have_their_own_lens(run, shot, tmp_path):
    """Their focal length says where they lie; a table gives it for each frame."""
    pattern = shot(with_camera)
    wrong = [w for w in LENS if w not in ("--focal-length-px", FOCAL_PX)]
    table = tmp_path / "lens.csv"
    rows = [f"{i},{FOCAL_PX if i != 4 else FOCAL_PX + 0.001}" for i in range(1, 8)]
    table.write_text("frame,focal-length-px\n" + "\n".join(rows) + "\n")
    run(pattern, "--temporal", 2, name="typed")
    from_table = ["filter", pattern, "-o", tmp_path / "out.####.exr", *wrong]
    run.rackfocus(
        *from_table, "--temporal", 2, "--frame-parameters", table, "--type", "float"
    )
    assert error_of(tmp_path, 4) < 1.1 * error_of(tmp_path, 4, "typed")


def test_ends_have_one_side(run, shot, tmp_path):
    done = run(shot(with_camera), "--temporal", 2, "--frames", "1,7")
    assert done.stderr == ""
    assert error_of(tmp_path, 7) < 0.1


def test_numbers_below_zero_are_frames_beside(run, shot, tmp_path):
    pattern = shot(with_camera)
    run(pattern, "--temporal", 2, "--frames", "3", name="above")
    for i in range(1, N_FRAMES + 1):
        os.rename(tmp_path / f"shot.{i:04d}.exr", tmp_path / f"shot.{i - 3:04d}.exr")
    run(pattern, "--temporal", 2, "--frames", "0", name="below")
    assert error_of(tmp_path, 0, "below", of=3) == error_of(tmp_path, 3, "above")


@pytest.mark.parametrize("says", ["camera", "blender"])
def test_nothing_comes_from_behind_a_cut(run, shot, tmp_path, says):
    """Another shot with things at the same distances, three times as dark."""

    def channels(i):
        grey, _ = pinhole(i)
        darker = {name: (0.3 * grey).astype(numpy.float32) for name in "RGB"}
        moves = {} if says == "camera" else vectors(i, says)
        return (darker if i > 4 else {}) | moves

    pattern = shot(with_camera if says == "camera" else None, channels)
    done = run(pattern, "--temporal", 2, "--frames", "4-5")
    assert done.stderr == ""
    run(pattern, "--frames", "4-5", name="alone")
    for frame, light in ((4, 1), (5, 0.3)):
        errors = [
            error_of(tmp_path, frame, name, light=light) for name in ("out", "alone")
        ]
        assert errors[0] < 0.6 * errors[1]


def test_a_frame_alone_is_told(run, shot, tmp_path):
    done = run(shot(with_camera, numbers=[4]), "--temporal", 2)
    assert "there is no frame beside it" in done.stderr
    run(tmp_path / "shot.####.exr", name="alone")
    same = (tmp_path / "alone.0004.exr").read_bytes()
    assert (tmp_path / "out.0004.exr").read_bytes() == same


def test_frames_without_a_camera_are_told(run, shot, tmp_path):
    done = run(shot(), "--temporal", 1, "--frames", "4")
    assert "neither worldToCamera" in done.stderr
    run(tmp_path / "shot.####.exr", "--temporal", 1, "--strict", name="no", code=1)
    assert not list(tmp_path.glob("no.0*"))


def test_wrong_cameras_are_told(run, shot):
    """Matrices by which hardly anything lies where it is seen are not believed."""
    pattern = shot(lambda i: {"worldToCamera": matrix(i * i * 90)})
    assert "fits" in run(pattern, "--temporal", 1, "--frames", "4").stderr


def test_damaged_frames_beside_fail(run, shot, tmp_path):
    pattern = shot(with_camera)
    data = (tmp_path / "shot.0005.exr").read_bytes()
    (tmp_path / "shot.0005.exr").write_bytes(data[: len(data) // 2])
    done = run(pattern, "--temporal", 1, "--frames", "4", code=1)
    assert "frame 4: " in done.stderr and "shot.0005.exr" in done.stderr
    assert not (tmp_path / "out.0004.exr").exists()


def test_what_would_not_read_it_is_told(run, shot):
    pattern = shot(with_camera, numbers=[1, 2])
    for option in (["--method", "box"], ["--quality", "preview"], ["--no-fill-hidden"]):
        assert (
            "--temporal: has no effect" in run(pattern, "--temporal", 1, *option).stderr
        )


def test_no_sequence_no_neighbours(rackfocus, shot, tmp_path):
    shot(with_camera, numbers=[1])
    done = rackfocus(
        "filter",
        tmp_path / "shot.0001.exr",
        "-o",
        tmp_path / "x.exr",
        *LENS,
        "--temporal",
        1,
        code=2,
    )
    assert "--temporal: is for sequences" in done.stderr
