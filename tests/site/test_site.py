# SPDX-License-Identifier: Apache-2.0
"""The pages in a browser: what it shows is what the command makes, to the bit."""

import contextlib
import functools
import http.server
import json
import os
import pathlib
import subprocess
import sys
import tarfile
import threading
import time

import mixed_pixels
import numpy
import OpenImageIO as oiio
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

ROOT = pathlib.Path(__file__).resolve().parents[2]
REFERENCES = ROOT / "tests" / "quality" / "references"
PATIENCE_S = 120


@pytest.fixture(scope="session")
def site():
    subprocess.run([ROOT / "dev", "site"], check=True)
    return pathlib.Path(os.environ["RACKFOCUS_BUILD"]) / "site"


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *arguments):
        pass


class Isolated(Quiet):
    """Pages that may share memory between threads."""

    def end_headers(self):
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        super().end_headers()


@contextlib.contextmanager
def serve(site, kind):
    handler = functools.partial(kind, directory=str(site))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


@pytest.fixture(scope="session")
def address(site):
    with serve(site, Quiet) as address:
        yield address


class Browser:
    """Chromium, what it complained of and what it asked for."""

    def __init__(self, address, downloads):
        options = webdriver.ChromeOptions()
        for argument in [
            "headless=new",
            "no-sandbox",
            "disable-gpu",
            "window-size=1280,900",
        ]:
            options.add_argument("--" + argument)
        options.add_experimental_option(
            "prefs", {"download.default_directory": str(downloads)}
        )
        options.set_capability(
            "goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"}
        )
        # Chromium leaves folders behind: among those of the test.
        service = Service(env={**os.environ, "TMPDIR": str(downloads.parent)})
        self.driver = webdriver.Chrome(options=options, service=service)
        self.address, self.downloads = address, downloads

    def open(self, page="index.html"):
        self.driver.get(self.address + page)

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def find(self, name):
        return self.driver.find_element(By.ID, name)

    def wait(self, is_done, what):
        end = time.monotonic() + PATIENCE_S
        while not (result := is_done()):
            assert time.monotonic() < end, f"{what}: {self.find('status').text}"
            time.sleep(0.05)
        return result

    def wait_for(self, state):
        self.wait(
            lambda: self.script("return document.body.dataset.state") == state, state
        )

    def click_canvas(self, x, y):
        """Clicks on a pixel of the picture, which is fitted."""
        place = self.script(
            """const box = document.getElementById("canvas").getBoundingClientRect();
            const picture = arguments[2], scale = Math.min(box.width / picture[0],
                                                           box.height / picture[1]);
            return [scale * (arguments[0] + .5 - picture[0] / 2),
                    scale * (arguments[1] + .5 - picture[1] / 2)];""",
            x,
            y,
            [480, 270],
        )
        chain = webdriver.ActionChains(self.driver)
        chain.move_to_element_with_offset(self.find("canvas"), *place).click().perform()

    def save(self, button, suffix):
        before = set(self.downloads.iterdir())
        self.find(button).click()

        def new_file():
            new = {p for p in self.downloads.iterdir() if p.suffix == suffix} - before
            return new.pop() if new else None

        return self.wait(new_file, "the download")

    def complaints(self):
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self):
        logs = [
            json.loads(e["message"])["message"]
            for e in self.driver.get_log("performance")
        ]
        sent = [
            m["params"]["request"]
            for m in logs
            if m["method"] == "Network.requestWillBeSent"
        ]
        return [request["url"] for request in sent]


@pytest.fixture
def browser(address, tmp_path):
    downloads = tmp_path / "downloads"
    downloads.mkdir()
    browser = Browser(address, downloads)
    yield browser
    browser.driver.quit()


def pixels(path):
    image = oiio.ImageBuf(str(path))
    return image.get_pixels(oiio.FLOAT)


def same(a, b):
    a, b = pixels(a), pixels(b)
    return a.shape == b.shape and numpy.array_equal(a, b)


def run_command(browser, binary, folder, output):
    """What the page says to type, typed."""
    words = browser.find("command").text.split()
    assert words[:2] == ["rackfocus", "filter"]
    words[words.index("out.png")] = str(output)
    done = subprocess.run(
        [binary, *words[1:]],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr


def test_click_and_save(browser, binary, tmp_path):
    browser.open()
    browser.wait_for("best")
    before = browser.find("command").text
    browser.click_canvas(200, 60)
    browser.wait(lambda: browser.find("command").text != before, "the click")
    browser.wait_for("best")
    assert "--focus-distance" in browser.find("command").text
    output = tmp_path / "native.png"
    run_command(browser, binary, REFERENCES, output)
    assert same(browser.save("save-png", ".png"), output)
    run_command(browser, binary, REFERENCES, output.with_suffix(".exr"))
    saved = pixels(browser.save("save-exr", ".exr"))
    half = pixels(output.with_suffix(".exr")).astype(numpy.float16)
    assert numpy.array_equal(saved, half.astype(numpy.float32))
    assert browser.complaints() == []
    foreign = [
        u for u in browser.requests() if not u.startswith((browser.address, "blob:"))
    ]
    assert [u for u in foreign if not u.startswith(("data:", "chrome"))] == []


def test_canvas_shows_the_picture(browser, binary, tmp_path):
    """The pixels of the canvas at 1:1, not only the file."""
    browser.open()
    browser.wait_for("best")
    output = tmp_path / "native.png"
    run_command(browser, binary, REFERENCES, output)
    browser.find("one").click()
    time.sleep(0.5)
    values = browser.script(
        """const canvas = document.getElementById("canvas");
        const x = Math.round(canvas.width / 2), y = Math.round(canvas.height / 2);
        return [...canvas.getContext("2d").getImageData(x - 50, y - 50, 100, 100).data];"""
    )
    shown = numpy.array(values, dtype=numpy.uint8).reshape(100, 100, 4)[:, :, :3]
    native = numpy.rint(pixels(output)[:, :, :3] * 255).astype(numpy.uint8)
    places = [
        (x, y)
        for y in range(60, 120)
        for x in range(160, 220)
        if numpy.array_equal(native[y : y + 100, x : x + 100], shown)
    ]
    assert len(places) == 1


def test_every_sample(browser, binary, site, tmp_path):
    for sample in json.loads((site / "samples" / "samples.json").read_text()):
        browser.open(f"index.html?sample={sample['id']}")
        browser.wait_for("best")
        output = tmp_path / f"{sample['id']}.png"
        run_command(browser, binary, site / "samples", output)
        assert same(browser.save("save-png", ".png"), output), sample["id"]
    assert browser.complaints() == []


def test_threads(site, binary, tmp_path):
    """Where the page may share memory it has threads, and the same bits."""
    with serve(site, Isolated) as address:
        browser = Browser(address, tmp_path)
        try:
            for sample in ("posts", "views"):
                browser.open(f"index.html?sample={sample}")
                browser.wait_for("best")
                assert browser.script("return crossOriginIsolated")
                assert int(browser.script("return document.body.dataset.threads")) > 1
                output = tmp_path / f"{sample}_native.png"
                run_command(browser, binary, site / "samples", output)
                assert same(browser.save("save-png", ".png"), output)
            assert browser.complaints() == []
        finally:
            browser.driver.quit()


def test_own_file_and_damaged_file(browser, tmp_path):
    browser.open()
    browser.wait_for("best")
    whole = REFERENCES / "macro_pinhole.exr"
    browser.find("files").send_keys(str(whole))
    browser.wait(lambda: "macro_pinhole" in browser.find("command").text, "the file")
    browser.wait_for("best")
    damaged = tmp_path / "damaged.exr"
    damaged.write_bytes(whole.read_bytes()[:40000])
    browser.find("files").send_keys(str(damaged))
    browser.wait_for("failed")
    assert browser.find("status").text.startswith("damaged.exr: damaged")
    no_depth = REFERENCES / "posts_reference.exr"
    browser.find("files").send_keys(str(no_depth))
    browser.wait(lambda: "depth" in browser.find("status").text, "the sentence")
    assert "those of the command rackfocus" in browser.find("status").text
    browser.find("files").send_keys(str(whole))
    browser.wait_for("best")


def test_drop(browser):
    browser.open()
    browser.wait_for("best")
    browser.script(
        """fetch("samples/portrait_pinhole.exr").then((a) => a.blob()).then((blob) => {
          const data = new DataTransfer();
          data.items.add(new File([blob], "dropped.exr"));
          document.getElementById("stage").dispatchEvent(
            new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
        });"""
    )
    browser.wait(lambda: "dropped.exr" in browser.find("command").text, "the drop")
    browser.wait_for("best")


def test_keyboard(browser):
    browser.open()
    browser.wait_for("best")
    canvas = browser.find("canvas")
    canvas.send_keys("\ue014\ue014\ue013")  # right, right, up
    canvas.send_keys("\ue007")
    browser.wait(lambda: "--focus-distance" in browser.find("command").text, "Enter")
    slider = browser.find("slider-blades")
    slider.send_keys("\ue014")
    assert slider.get_attribute("aria-valuetext")


def test_panel_says_what_is_not_read(browser):
    browser.open()
    browser.wait_for("best")
    title = browser.script(
        """return [...document.querySelectorAll(".panel .unused")].map((l) => l.title)"""
    )
    assert any("Without effect:" in t for t in title)


@pytest.mark.parametrize(
    "page", ["index", "gallery", "lesson", "docs/index", "docs/blender"]
)
def test_narrow(browser, page):
    browser.driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 320, "height": 700, "deviceScaleFactor": 2, "mobile": True},
    )
    browser.open(page + ".html")
    time.sleep(0.5)
    assert browser.script("return document.documentElement.scrollWidth") <= 320


def test_documents(browser, site):
    browser.open("docs/index.html")
    browser.find("search").send_keys("lens-radius")
    browser.wait(
        lambda: browser.script("return document.querySelectorAll('#results a').length"),
        "results",
    )
    for path in site.rglob("*.html"):
        if "api" not in path.relative_to(site).parts:
            check_links(path)
            assert "```" not in path.read_text(), path
    assert browser.complaints() == []


def check_links(path):
    import html.parser

    class Links(html.parser.HTMLParser):
        found = []

        def handle_starttag(self, tag, attributes):
            self.found += [v for k, v in attributes if k in ("href", "src")]

    parser = Links()
    parser.found = []
    parser.feed(path.read_text())
    for link in parser.found:
        name = link.partition("#")[0]
        if name and "://" not in name:
            assert (path.parent / name).exists(), f"{path}: {link}"


def test_lesson(browser):
    browser.open("lesson.html")
    before = browser.find("dof").text
    browser.find("letter-N").send_keys("\ue014" * 5)
    assert browser.find("dof").text != before
    browser.wait(
        lambda: "ms on one thread" in browser.find("method-text").text, "the method"
    )
    assert browser.complaints() == []


# ---- the module under Node ------------------------------------------------------------


def run_node(text, folder):
    script = folder / "script.mjs"
    script.write_text(text)
    done = subprocess.run(
        ["node", script], capture_output=True, text=True, timeout=PATIENCE_S, cwd=folder
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def list_methods(binary):
    made = subprocess.run(
        [binary, "methods", "--json"], capture_output=True, check=True
    )
    return [method["name"] for method in json.loads(made.stdout)]


def write_mixed_pixels(path):
    """A file with the mean rays of its pixels, as Blender's has them."""
    channels, ray = mixed_pixels.passes()
    channels["Denoising Depth.Z"] = ray
    height, width = ray.shape
    spec = oiio.ImageSpec(width, height, len(channels), "float")
    spec.channelnames = tuple(channels)
    picture = oiio.ImageOutput.create(str(path))
    assert picture.open(str(path), spec), picture.geterror()
    assert picture.write_image(numpy.dstack(list(channels.values())))
    picture.close()
    return path


def test_every_method_has_the_same_bits(site, binary, tmp_path):
    methods = list_methods(binary)
    lens = {"focusDistance": 1.6, "blades": 5}
    cases = {
        m: (
            m,
            sorted(REFERENCES.glob("posts_view*.exr"))
            if m in ("views", "accumulate")
            else [REFERENCES / "posts_pinhole.exr"],
        )
        for m in methods
    }
    cases["rays"] = "layered", [write_mixed_pixels(tmp_path / "rays_in.exr")]
    given = {case: (m, [str(p) for p in paths]) for case, (m, paths) in cases.items()}
    run_node(
        f"""import {{ Document }} from "{site}/core/document.js";
        import {{ readFileSync, writeFileSync }} from "node:fs";
        for (const [name, [method, paths]] of Object.entries({json.dumps(given)})) {{
          const files = paths.map((path) => ({{ name: path.split("/").pop(),
                                               bytes: new Uint8Array(readFileSync(path)) }}));
          const picture = await Document.open(files);
          picture.set({{ ...{json.dumps(lens)}, method }});
          picture.render();
          writeFileSync(`${{name}}.raw`, picture.pixels().data);
          picture.close();
        }}""",
        tmp_path,
    )
    for name, (method, paths) in cases.items():
        output = tmp_path / f"{name}.exr"
        options = ["--focus-distance", "1.6", "--blades", "5", "--method", method]
        subprocess.run(
            [binary, "filter", "-q", *paths, "-o", output, *options],
            check=True,
        )
        native = pixels(output)
        made = numpy.fromfile(tmp_path / f"{name}.raw", numpy.float32)
        if pixels_are_half(output):
            made = made.astype(numpy.float16).astype(numpy.float32)
        assert numpy.array_equal(made.reshape(native.shape), native), name


def test_lamps_are_told_by_the_white_of_the_picture(site, binary, tmp_path):
    file = oiio.ImageInput.open(str(REFERENCES / "posts_pinhole.exr"))
    values, spec = file.read_image(oiio.FLOAT), file.spec()
    file.close()
    values[..., :3] /= 256
    spec.channelformats, spec.format = (), oiio.TypeFloat
    written = oiio.ImageOutput.create("passes.exr")
    written.open(str(tmp_path / "passes.exr"), spec)
    written.write_image(values)
    written.close()
    run_node(
        f"""import {{ Document }} from "{site}/core/document.js";
        import {{ readFileSync, writeFileSync }} from "node:fs";
        const bytes = new Uint8Array(readFileSync("passes.exr"));
        const picture = await Document.open([{{ name: "passes.exr", bytes }}]);
        writeFileSync("made.exr", picture.exr());""",
        tmp_path,
    )
    made = pixels(tmp_path / "made.exr")
    for options, is_same in ([[], True], [["--white", "1"], False]):
        out = tmp_path / f"{is_same}.exr"
        command = [binary, "filter", "-q", tmp_path / "passes.exr", "-o", out, *options]
        subprocess.run(command, check=True)
        assert numpy.array_equal(made, pixels(out)) == is_same


def test_what_is_doubtful_of_a_file_is_said(site, binary, tmp_path):
    out = tmp_path / "again.exr"
    words = [REFERENCES / "posts_pinhole.exr", "-o", out, "--pass-through"]
    subprocess.run([binary, "filter", "-q", *words], check=True)
    told = run_node(
        f"""import {{ Document }} from "{site}/core/document.js";
        import {{ readFileSync }} from "node:fs";
        for (const path of ["{REFERENCES}/posts_pinhole.exr", "{out}"]) {{
          const bytes = new Uint8Array(readFileSync(path));
          const picture = await Document.open([{{ name: "passes.exr", bytes }}]);
          console.log(JSON.stringify(picture.remark));
        }}""",
        tmp_path,
    )
    nothing, said = map(json.loads, told.splitlines())
    assert nothing == "" and "filtered before" in said


def test_a_depth_that_is_upside_down_is_told(site, tmp_path):
    """As filter warns of it."""
    file = oiio.ImageInput.open(str(REFERENCES / "posts_pinhole.exr"))
    spec, values = file.spec(), file.read_image(oiio.FLOAT)
    file.close()
    values[..., 3] = values[::-1, :, 3].copy()
    spec.channelformats, spec.format = (), oiio.TypeFloat
    written = oiio.ImageOutput.create("passes.exr")
    written.open(str(tmp_path / "passes.exr"), spec)
    written.write_image(values)
    written.close()
    told = run_node(
        f"""import {{ Document }} from "{site}/core/document.js";
        import {{ readFileSync }} from "node:fs";
        const bytes = new Uint8Array(readFileSync("passes.exr"));
        const picture = await Document.open([{{ name: "passes.exr", bytes }}]);
        console.log(picture.remark);""",
        tmp_path,
    )
    assert "lies upside down" in told and "oiiotool passes.exr --flip" in told


def pixels_are_half(path):
    return oiio.ImageInput.open(str(path)).spec().format == oiio.HALF


def test_filter_of_the_package(site, tmp_path):
    told = run_node(
        f"""import {{ Filter, parameters, version }} from "{site}/core/index.js";
        const n = 32 * 16, colour = new Float32Array(3 * n).fill(0.5);
        const depth = new Float32Array(n).map((_, i) => 2 + (i % 7));
        const image = {{ data: colour, width: 32, height: 16, channels: 3 }};
        const out = new Filter({{ focusDistance: 3, fStop: 0.1 }}).apply(image, depth);
        const errors = [];
        for (const make of [() => new Filter({{ fstop: 1 }}), () => new Filter({{ fStop: -1 }}),
                            () => new Filter().apply(image, depth.slice(1))])
          try {{ make(); }} catch (error) {{ errors.push(`${{error.name}}: ${{error.message}}`); }}
        const coc = new Filter({{ focusDistance: 3, fStop: 0.1 }}).coc(depth, 32, 16);
        console.log(JSON.stringify({{ version, n: parameters.length, errors,
          most: Math.max(...out.data), least: Math.min(...out.data), coc: [...coc.slice(0, 3)] }}));""",
        tmp_path,
    )
    found = json.loads(told)
    assert found["n"] > 50
    assert found["least"] == pytest.approx(0.5, abs=1e-5) == found["most"]
    assert found["coc"][0] < 0 == found["coc"][1] < found["coc"][2]
    assert found["errors"][0].startswith("RangeError: fstop")
    assert "range" in found["errors"][1]
    assert "511 floats are not 32 x 16" in found["errors"][2]


def test_sizes(site):
    # One of the two modules is loaded.
    parts = [p for p in (site / "core").iterdir() if p.name != "rackfocus-threads.wasm"]
    core = sum(p.stat().st_size for p in parts)
    page = sum(
        p.stat().st_size for p in site.iterdir() if p.suffix in (".js", ".css", ".svg")
    )
    assert core + page + (site / "index.html").stat().st_size < 1.5e6


def test_package(tmp_path):
    """The npm package as someone who installs it has it, and the same bytes again."""
    wasm = pathlib.Path(os.environ["RACKFOCUS_BUILD"]) / "web" / "web"
    made = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        subprocess.run(
            [sys.executable, ROOT / "web" / "package.py", wasm, folder], check=True
        )
        (path,) = folder.iterdir()
        made.append(path.read_bytes())
    assert made[0] == made[1]
    modules = tmp_path / "node_modules" / "@rackfocus"
    modules.mkdir(parents=True)
    with tarfile.open(path) as archive:
        archive.extractall(modules)
    (modules / "package").rename(modules / "core")
    told = run_node(
        """import { parameters, version } from "@rackfocus/core";
        import { Document } from "@rackfocus/core/document";
        console.log(version, parameters.length, typeof Document.open);""",
        tmp_path,
    )
    assert told.split()[2] == "function"
    types = (modules / "core" / "index.d.ts").read_text()
    assert types.count("?: ") >= int(told.split()[1])
