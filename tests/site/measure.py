#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the page and the module: python3 tests/site/measure.py after ./dev site.

Prints, for a picture of 960 x 540 px in Chromium without a GPU: updates a second and the
time from an input to the picture while a slider is dragged, the time of the best picture,
the memory; and how fast the module under Node is against the native command with SSE4.1,
both on one thread, with the same picture and the same filter.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

import numpy
import OpenImageIO as oiio

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import test_site  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RACKFOCUS_BUILD", ROOT / "build"))
DRAG = """
const done = arguments[0], slider = document.getElementById("slider-focusDistance");
const canvas = document.getElementById("canvas"), gaps = [], waits = [];
let asked = 0, n = 0, last = 0;
const seen = new MutationObserver(() => {
  if (document.body.dataset.state === "busy") return;
  const now = performance.now();
  waits.push(now - asked);
  if (last) gaps.push(now - last);
  last = now;
  if (++n === 40) { seen.disconnect(); done({ gaps, waits }); return; }
  next();
});
seen.observe(document.body, { attributes: true, attributeFilter: ["data-state"] });
function next() {
  slider.value = 100 + 20 * (n % 40);
  asked = performance.now();
  slider.dispatchEvent(new Event("input"));
}
next();
"""


def write_540p(path):
    """The posts, each pixel four."""
    image = oiio.ImageBuf(str(test_site.REFERENCES / "posts_pinhole.exr"))
    pixels = image.get_pixels(oiio.FLOAT).repeat(2, axis=0).repeat(2, axis=1)
    spec = image.spec().copy()
    spec.width, spec.height = pixels.shape[1], pixels.shape[0]
    spec.full_width, spec.full_height = spec.width, spec.height
    key = "rackfocus:focalLengthPx"
    spec.attribute(key, 2 * spec.get_float_attribute(key))
    made = oiio.ImageOutput.create(str(path))
    made.open(str(path), spec)
    made.write_image(numpy.ascontiguousarray(pixels))
    made.close()


def measure_page(site, folder, path, kind):
    with test_site.serve(site, kind) as address:
        browser = test_site.Browser(address, folder)
        browser.driver.set_script_timeout(120)
        browser.open()
        browser.wait_for("best")
        browser.find("files").send_keys(str(path))
        browser.wait(lambda: path.name in browser.find("command").text, "the file")
        browser.wait_for("best")
        found = [browser.driver.execute_async_script(DRAG) for _ in range(2)][1]
        browser.wait_for("best")
        best = browser.find("status").text
        threads = browser.script("return document.body.dataset.threads")
        browser.driver.quit()
    waits = sorted(found["waits"])
    print(
        f"{threads} thread(s) for each of two workers: "
        f"{1000 / statistics.median(found['gaps']):.1f} updates a second, input to picture "
        f"{statistics.median(waits):.0f} ms, 95 % within {waits[int(0.95 * len(waits))]:.0f} ms; "
        f"{best}"
    )


NODE = """
import {{ Document }} from "{site}/core/document.js";
import {{ readFileSync }} from "node:fs";
const bytes = new Uint8Array(readFileSync("{path}"));
const picture = await Document.open([{{ name: "a.exr", bytes }}]);
const times = [];
for (let i = 0; i < 8; i++) {{
  const start = performance.now();
  picture.render();
  times.push(performance.now() - start);
}}
console.log(JSON.stringify({{ ms: Math.min(...times), bytes: picture.memoryBytes }}));
"""


def measure_node(site, folder, path):
    told = json.loads(test_site.run_node(NODE.format(site=site, path=path), folder))
    return told["ms"], told["bytes"]


def measure_native(path):
    """Milliseconds of the filter alone, by the Python module."""
    code = f"""
import time, numpy, OpenImageIO as oiio, rackfocus
image = oiio.ImageBuf({str(path)!r}); p = image.get_pixels(oiio.FLOAT)
names = list(image.spec().channelnames)
colour = numpy.ascontiguousarray(p[:, :, [names.index(c) for c in "RGBA" if c in names]])
depth = numpy.ascontiguousarray(p[:, :, names.index("Z")])
spec = image.spec()
get = lambda key: spec.get_float_attribute("rackfocus:" + key)
context = rackfocus.Context(threads=1, cpu="sse4")
times = []
for i in range(8):
    start = time.perf_counter()
    rackfocus.apply(colour, depth, context=context, focus_distance=get("focusDistance"),
                     lens_radius=get("lensRadius"), focal_length_px=get("focalLengthPx"))
    times.append(time.perf_counter() - start)
print(1000 * min(times))
"""
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "plugin" / "stage")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment
    )
    if done.returncode != 0:
        sys.exit(done.stderr)
    return float(done.stdout)


def main():
    site = BUILD / "site"
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        path = folder / "posts_540p.exr"
        write_540p(path)
        for kind in (test_site.Quiet, test_site.Isolated):
            measure_page(site, folder, path, kind)
        pairs = [
            (measure_native(path), *measure_node(site, folder, path)) for _ in range(3)
        ]
        native, module = min(p[0] for p in pairs), min(p[1] for p in pairs)
        print(
            f"one thread: native with SSE4.1 {native:.0f} ms, module under Node "
            f"{module:.0f} ms, {native / module:.2f} of its speed; "
            f"memory {pairs[0][2] / (960 * 540):.0f} bytes per pixel"
        )


main()
