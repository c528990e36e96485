# SPDX-License-Identifier: Apache-2.0
"""Makes the seed corpus of the fuzz targets: small files, one per feature.

python3 tests/fuzz/make_seeds.py tests/fuzz/corpus
"""

import random
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

COMPRESSIONS = "none rle zips zip piz pxr24 b44 b44a dwaa dwab".split()
SIZE = 9


def spec_of(names, kind=oiio.HALF, tile=0, **attributes):
    spec = oiio.ImageSpec(SIZE, SIZE, len(names), kind)
    spec.channelnames = tuple(names)
    if tile:
        spec.tile_width = spec.tile_height = tile
    for name, value in attributes.items():
        spec[name.replace("__", ":")] = value
    return spec


def write(path, specs, pixels):
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(specs)), output.geterror()
    for i, spec in enumerate(specs):
        if i:
            assert output.open(str(path), spec, "AppendSubimage"), output.geterror()
        assert output.write_image(pixels[:, :, : spec.nchannels]), output.geterror()
    output.close()


def write_deep(path, tile=0, compression="zips"):
    spec = spec_of("RGBAZ", oiio.FLOAT, tile, compression=compression)
    spec.channelnames = ("R", "G", "B", "A", "Z", "ZBack")
    spec.nchannels = 6
    spec.deep = True
    data = oiio.DeepData()
    data.init(spec)
    for pixel in range(SIZE * SIZE):
        n = pixel % 4
        data.set_samples(pixel, n)
        for s in range(n):
            for c in range(4):
                data.set_deep_value(pixel, c, s, 0.25 * (s + 1))
            data.set_deep_value(pixel, 4, s, 2.0 * s + 1)
            data.set_deep_value(pixel, 5, s, 2.0 * s + 1 + s % 2)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_deep_image(data), output.geterror()
    output.close()


def make_exr(folder):
    rng = np.random.default_rng(1)
    pixels = rng.random((SIZE, SIZE, 5)).astype("f4")
    for name in COMPRESSIONS:
        write(folder / f"{name}.exr", [spec_of("RGBAZ", compression=name)], pixels)
        tiled = spec_of("RGBAZ", tile=4, compression=name)
        write(folder / f"{name}_tiled.exr", [tiled], pixels)
    camera = {"rackfocus__focusDistance": 5.0, "rackfocus__filtered": "yes"}
    write(folder / "float.exr", [spec_of("RGBAZ", oiio.FLOAT, **camera)], pixels)
    parts = [spec_of("RGB", name="rgba"), spec_of("Z", oiio.FLOAT, name="depth")]
    write(folder / "parts.exr", parts, pixels)
    layers = ["ViewLayer.Combined." + c for c in "RGB"] + ["ViewLayer.Depth.Z"]
    write(folder / "blender.exr", [spec_of(layers)], pixels)
    write(folder / "grey.exr", [spec_of("YZ")], pixels)
    for compression in ("none", "rle", "zips"):
        write_deep(folder / f"deep_{compression}.exr", 0, compression)
    write_deep(folder / "deep_tiled.exr", 4)


def make_camera(folder, scenes):
    for path in sorted(scenes.iterdir()):
        if path.suffix in (".pov", ".inc") and path.stat().st_size < 1500:
            (folder / path.name.replace(" ", "_")).write_bytes(path.read_bytes())
    (folder / "records").write_text(
        "@rf~camera~3.1~Far;@rf~type~perspective;@rf~location~0,1,-5;@rf~angle~40;"
        "@rf~transform~1,0,0,0,1,0,0,0,1,0,0,9;@rf~end~;@rf~camera~3.7;@rf~copy~Far;"
        "@rf~look_at~0,0,0;@rf~aperture~0.4;@rf~focal_point~0,0,0;@rf~blur_samples~9;"
        "@rf~end~;@rf~camera~3.7;@rf~copy~P;@rf~right~1.3,0,0;@rf~end~;@rf~version~3.7;"
    )


def make_params(folder):
    (folder / "lens").write_text("focus-distance=8\nf_stop=1.4\nblades=6\nlens-radius=")
    (folder / "kinds").write_text(
        "depth=radial\nmethod=views\nsplit-edges=off\nx=1e999"
    )
    (folder / "odd").write_text("focus-distance=nan\nf-stop=-0\nblades=3.5\n=\nblur=1")
    (folder / "ends").write_text("depth-infinity=1e300\nmax-radius=16384\nf-stop=0.001")


def make_filter(folder):
    generator = random.Random(4)
    for i in range(12):
        n = generator.choice((40, 200, 1200))
        (folder / f"random{i}").write_bytes(generator.randbytes(n))
    (folder / "zeros").write_bytes(bytes(16))


def main():
    root = Path(sys.argv[1])
    for name in ("exr", "camera", "params", "filter"):
        (root / name).mkdir(parents=True, exist_ok=True)
    make_exr(root / "exr")
    make_camera(root / "camera", Path(__file__).parents[1] / "povray" / "scenes")
    make_params(root / "params")
    make_filter(root / "filter")


main()
