# SPDX-License-Identifier: Apache-2.0
"""compare-methods and accumulate, from files to files."""

import json
import pathlib
import sys

import numpy
import OpenImageIO as oiio
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "cli"))
import plainexr  # noqa: E402

REFERENCES = pathlib.Path(__file__).parents[1] / "quality/references"
POSTS = REFERENCES / "posts_pinhole.exr"
TRUTH = REFERENCES / "posts_reference.exr"


def views(tmp_path, count=5, size=(24, 17)):
    random = numpy.random.default_rng(1)
    pictures, paths = [], []
    tmp_path.mkdir(exist_ok=True)
    for i in range(count):
        picture = random.random((size[1], size[0], 3)).astype(numpy.float32)
        picture[3, 4] = 10.0**i
        channels = {c: picture[..., k] for k, c in enumerate("RGB")}
        paths.append(plainexr.write(tmp_path / f"v{i}.exr", channels))
        pictures.append(picture.astype(float))
    return pictures, paths


def test_accumulate_is_the_mean(rackfocus, tmp_path):
    pictures, paths = views(tmp_path)
    rackfocus("accumulate", *paths, "-o", tmp_path / "mean.exr", "-q")
    # Another order gives the same within the rounding to float.
    rackfocus("accumulate", *paths[::-1], "-o", tmp_path / "again.exr", "-q")
    rackfocus("accumulate", paths[0], "-o", tmp_path / "one.exr", "-q")
    want = sum(pictures) / len(pictures)
    for name, expected in (("mean", want), ("again", want), ("one", pictures[0])):
        text = rackfocus(
            "compare", tmp_path / f"{name}.exr", write(tmp_path, expected), "--json"
        ).stdout
        assert json.loads(text)["max_error"] <= 1e-7 * expected.max()


def write(tmp_path, picture):
    channels = {c: picture[..., k].astype(numpy.float32) for k, c in enumerate("RGB")}
    return plainexr.write(tmp_path / "want.exr", channels)


def test_accumulate_of_a_bright_view_keeps_the_others(rackfocus, tmp_path):
    """1e8 in one view: a sum in half or in 8 bit would lose the rest."""
    black = numpy.full((4, 4, 3), 0.25, numpy.float32)
    lamp = black.copy()
    lamp[1, 1] = 1e8
    paths = []
    for i, picture in enumerate([lamp, black, black, black]):
        channels = {c: picture[..., k] for k, c in enumerate("RGB")}
        paths.append(plainexr.write(tmp_path / f"p{i}.exr", channels))
    rackfocus("accumulate", *paths, "-o", tmp_path / "mean.exr", "-q")
    want = black.copy()
    want[1, 1] = (1e8 + 0.75) / 4
    text = rackfocus("compare", tmp_path / "mean.exr", write(tmp_path, want), "--json")
    assert json.loads(text.stdout)["max_error"] <= 2


def test_accumulate_says_what_is_wrong(rackfocus, tmp_path):
    _, paths = views(tmp_path, 2)
    _, other = views(tmp_path / "other", 1, size=(8, 8))
    out = tmp_path / "out.exr"
    assert "needs views" in rackfocus("accumulate", "-o", out, code=2).stderr
    assert "needs an output" in rackfocus("accumulate", paths[0], code=2).stderr
    done = rackfocus("accumulate", *paths, *other, "-o", out, code=1)
    assert "8 x 8" in done.stderr and "24 x 17" in done.stderr
    assert not out.exists()
    done = rackfocus("accumulate", "none.exr", "-o", out, code=1)
    assert "none.exr" in done.stderr


def test_compare_methods_lists_all_of_them(rackfocus, tmp_path):
    sheet = tmp_path / "sheet.png"
    done = rackfocus(
        "compare-methods", POSTS, "--reference", TRUTH, "--json", "--sheet", sheet,
        "--repeats", 1, "-q",
    )  # fmt: skip
    rows = json.loads(done.stdout)
    methods = json.loads(rackfocus("methods", "--json").stdout)
    names = {row.get("method") for row in rows}
    of_views = {"views", "accumulate"}
    assert names == {None} | {method["name"] for method in methods} - of_views
    by_name = {row["name"]: row for row in rows}
    assert len(by_name) == len(rows) >= 1 + 1 + 1 + 6 * 3
    assert by_name["layered"]["tpsnr"] == max(row["tpsnr"] for row in rows)
    for row in rows[1:]:
        assert row["tpsnr"] > by_name["pinhole"]["tpsnr"]
        assert row["time_s"] > 0
    assert sheet.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def pixels(path):
    """Encoded 8 bit RGB of a PNG, as whole numbers with a sign."""
    file = oiio.ImageInput.open(str(path))
    read = file.read_image(oiio.UINT8)
    file.close()
    return read.astype(numpy.int16)[..., :3]


def find(sheet, picture):
    """Where the picture lies in the sheet, (x, y); it must be there once."""
    height, width = picture.shape[:2]
    room = [sheet.shape[i] - picture.shape[i] + 1 for i in (0, 1)]
    is_like = numpy.ones(room, bool)
    for y, x in ((0, 0), (height // 2, 7), (height - 1, width - 1), (33, width // 3)):
        part = sheet[y : y + room[0], x : x + room[1]]
        is_like &= (abs(part - picture[y, x]) <= 1).all(axis=-1)
    found = [
        (x, y)
        for y, x in zip(*numpy.nonzero(is_like), strict=True)
        if abs(sheet[y : y + height, x : x + width] - picture).max() <= 1
    ]
    assert len(found) == 1
    return found[0]


def test_the_sheet_has_a_row_per_generator_and_a_column_per_blend(rackfocus, tmp_path):
    """Every picture of the page is found on the sheet, in its row and column."""
    sheet = tmp_path / "sheet.png"
    rackfocus("compare-methods", POSTS, "--reference", TRUTH, "--repeats", 1, "-q",
              "--sheet", sheet, "--html", tmp_path / "page.html")  # fmt: skip
    drawn, made = pixels(sheet), tmp_path / "page_pictures"
    blends = ("coc", "region", "slices")
    generators = ("box", "lowres", "mipmap", "offset")
    place = {
        name: find(drawn, pixels(made / f"{name}.png"))
        for name in ["pinhole", "layered", "scatter"]
        + [f"{generator}_{blend}" for generator in generators for blend in blends]
    }
    left = [place[f"box_{blend}"][0] for blend in blends]
    assert left == sorted(left) and left[0] == place["pinhole"][0]
    top = [place["pinhole"][1], place["layered"][1]]
    for generator in generators:
        cells = [place[f"{generator}_{blend}"] for blend in blends]
        assert [x for x, _ in cells] == left
        assert len({y for _, y in cells}) == 1
        top.append(cells[0][1])
    assert top == sorted(set(top)) and place["scatter"] == (left[1], top[1])
    # The figures over a picture: letters, and others over another one.
    over = [
        drawn[y - 48 : y, x : x + 400]
        for x, y in (place["box_coc"], place["box_region"])
    ]
    assert all((text > 150).sum() > 1000 for text in over)
    assert (over[0] != over[1]).any()


def test_a_page_says_where_it_cannot_be(rackfocus, tmp_path):
    done = rackfocus("compare-methods", POSTS, "--reference", TRUTH, "--html",
                     tmp_path / "page.png", code=2)  # fmt: skip
    assert "does not end in .html" in done.stderr
    (tmp_path / "page_pictures").write_text("a file")
    done = rackfocus("compare-methods", POSTS, "--reference", TRUTH, "--html",
                     tmp_path / "page.html", "-q", code=1)  # fmt: skip
    assert "page_pictures: cannot make the folder" in done.stderr
    assert not (tmp_path / "page.html").exists()


def test_compare_methods_agrees_with_filter_and_compare(rackfocus, tmp_path):
    out = tmp_path / "out.exr"
    how = ["--method", "box", "--blend", "region", "--blur-radius", "7"]
    rackfocus("filter", POSTS, "-o", out, "--type", "float", "-q", *how)
    single = json.loads(rackfocus("compare", out, TRUTH, "--json").stdout)
    done = rackfocus("compare-methods", POSTS, "--reference", TRUTH, "--json", *how)
    row = json.loads(done.stdout)[1]
    assert row["name"] == "box region"
    assert len(json.loads(done.stdout)) == 2
    for key in ("tpsnr", "ssim", "energy_ratio"):
        assert row[key] == pytest.approx(single[key], abs=1e-9)


def test_compare_methods_takes_views_and_keeps_results(rackfocus, tmp_path):
    """Views go through the methods of several; each file is what its row measured."""
    paths = [REFERENCES / f"posts_view{i:02}.exr" for i in range(3)]
    kept = tmp_path / "kept"
    done = rackfocus("compare-methods", POSTS, *paths, "--reference", TRUTH, "--json",
                     "--repeats", 1, "--results", kept, "--blend", "coc",
                     "--sub-apertures", 1)  # fmt: skip
    rows = {row["name"]: row for row in json.loads(done.stdout)}
    assert {"pinhole", "layered", "views", "accumulate", "box coc"} <= set(rows)
    for name in ("pinhole", "views", "box coc"):
        path = kept / f"{name.replace(' ', '_')}.exr"
        text = rackfocus("compare", path, TRUTH, "--json").stdout
        assert json.loads(text)["tpsnr"] == pytest.approx(rows[name]["tpsnr"], abs=1e-9)
    rackfocus("accumulate", *paths, "-o", tmp_path / "mean.exr")
    text = rackfocus("compare", tmp_path / "mean.exr", TRUTH, "--json").stdout
    assert json.loads(text)["tpsnr"] == pytest.approx(
        rows["accumulate"]["tpsnr"], abs=1e-4
    )
    done = rackfocus("compare-methods", POSTS, paths[0], POSTS, "--reference", TRUTH,
                     code=1)  # fmt: skip
    assert "is no view" in done.stderr


def test_compare_methods_says_what_is_wrong(rackfocus, tmp_path):
    _, paths = views(tmp_path, 1)
    assert "--reference" in rackfocus("compare-methods", POSTS, code=2).stderr
    done = rackfocus("compare-methods", POSTS, "--reference", paths[0], code=1)
    assert "24 x 17" in done.stderr and "480 x 270" in done.stderr
    done = rackfocus("compare-methods", paths[0], "--reference", paths[0], code=1)
    assert "there is no depth" in done.stderr
    done = rackfocus(
        "compare-methods", POSTS, "--reference", TRUTH, "--sheet", "a.exr", code=2
    )
    assert "does not end in .png" in done.stderr


# ---- a picture as the distribution ---------------------------------------------------


def lamp(tmp_path, z, size=41):
    """One bright pixel at distance z; the radius is 16 px at 20, -16 px at 4."""
    light = numpy.zeros((size, size), numpy.float32)
    light[size // 2, size // 2] = 1000
    depth = numpy.full((size, size), 1e10, numpy.float32)
    depth[size // 2, size // 2] = z
    facts = {"rackfocus:lensRadius": 1.0, "rackfocus:focusDistance": 20 / 3}
    facts["rackfocus:focalLengthPx"] = 160.0
    channels = dict.fromkeys("RGB", light) | {"Z": depth}
    return plainexr.write(tmp_path / "lamp.exr", channels, facts)


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_a_file_gives_the_bokeh(rackfocus, tmp_path, suffix):
    """An L of light: its picture behind the focus, turned by 180 degrees before it."""
    picture = numpy.zeros((32, 32), numpy.float32)
    picture[4:28, 6:12] = picture[22:28, 6:26] = 1
    exr = plainexr.write(tmp_path / "l.exr", dict.fromkeys("RGB", picture * 7))
    image = exr
    if suffix == "png":
        # The smallest blur there is makes a PNG of the picture.
        passes = plainexr.write(
            tmp_path / "flat.exr",
            dict.fromkeys("RGB", picture) | {"Z": picture + 1},
        )
        image = tmp_path / "l.png"
        rackfocus("filter", passes, "-o", image, "--lens-radius", 1e-9)
    for z, turn in ((20, 1), (4, -1)):
        out = tmp_path / "out.exr"
        rackfocus("filter", lamp(tmp_path, z), "-o", out, "--type", "float",
                  "--method", "scatter", "--distribution-image", image)  # fmt: skip
        got = plainexr.read(out)[0]["G"].astype(float)
        assert got.sum() == pytest.approx(1000, rel=1e-5)
        # 32 squares over 32 px; the lamp is a pixel's centre, so half a pixel off.
        want = numpy.zeros((41, 41))
        inside = picture[::turn, ::turn]
        for dy in (0, 1):
            for dx in (0, 1):
                want[4 + dy : 36 + dy, 4 + dx : 36 + dx] += inside / 4
        assert got / 1000 == pytest.approx(want / want.sum(), abs=1e-5)


@pytest.mark.parametrize(
    "options, text, code",
    [
        (["--distribution-image", "l.exr"], "--method scatter", 2),
        (["--method", "scatter", "--distribution", "image"], "--distribution-image", 2),
        (["--method", "scatter", "--distribution", "ring", "--distribution-image",
          "l.exr"], "--distribution image", 2),
        (["--method", "scatter", "--distribution-image", "none.exr"], "none.exr", 1),
        (["--method", "scatter", "--distribution-image", "black.exr"], "black.exr", 1),
        (["--aperture-image", "black.exr"], "the picture of the aperture is black", 1),
    ],
)  # fmt: skip
def test_a_wrong_file_for_the_bokeh(rackfocus, tmp_path, options, text, code):
    for name, value in (("l", 1), ("black", 0)):
        plain = numpy.full((4, 4), value, numpy.float32)
        plainexr.write(tmp_path / f"{name}.exr", dict.fromkeys("RGB", plain))
    options = [tmp_path / o if o.endswith("exr") else o for o in options]
    out = tmp_path / "out.exr"
    done = rackfocus("filter", lamp(tmp_path, 20), "-o", out, *options, code=code)
    assert text in done.stderr
    assert not out.exists()
