#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the site: the page to try, the gallery, the lesson, the users' pages.

Usage: build.py RACKFOCUS WASM OUT

RACKFOCUS is the built command, WASM the folder of the built modules, OUT a folder that is made anew.
Everything in it is relative: it works from any folder of any file server.
"""

import html
import json
import pathlib
import re
import shutil
import subprocess
import sys

import markdown

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
REFERENCES = ROOT / "tests" / "quality" / "references"
LINKS = [
    ("index.html", "Try it"),
    ("gallery.html", "Gallery"),
    ("lesson.html", "Lesson"),
    ("docs/index.html", "Documents"),
]
# Users' pages, in the order in which they are listed.
PAGES = """install blender blender-views blender-nodes blender-view3d blender-limits
blender-farm povray cli files live browser views looks denoise methods
python farm reliability performance algorithm glossary extending ARCHITECTURE""".split()
SAMPLES = [
    {
        "id": "posts",
        "label": "Posts and lamps (Cycles)",
        "files": ["posts_pinhole.exr"],
        "reference": "posts_reference.exr",
    },
    {
        "id": "portrait",
        "label": "Portrait, six blades (Cycles)",
        "files": ["portrait_pinhole.exr"],
        "reference": "portrait_reference.exr",
    },
    {
        "id": "foliage",
        "label": "Leaves at all depths (Cycles)",
        "files": ["foliage_pinhole.exr"],
        "reference": "foliage_reference.exr",
    },
    {
        "id": "views",
        "label": "Posts, eight views (Cycles)",
        "files": [f"posts_view{i:02}.exr" for i in range(8)],
        "reference": "posts_reference.exr",
    },
    {
        "id": "povray",
        "label": "focalblur.pov (POV-Ray)",
        "files": ["focalblur_passes.exr"],
        "reference": "focalblur.exr",
    },
]
KINDS = {
    "posts": "Thin things before the focus, lamps behind it",
    "portrait": "A portrait: six blades, leaves before and behind",
    "plane": "A texture through the focus",
    "macro": "Macro: circles of 60 px radius, anamorphic",
    "foliage": "Leaves at all depths",
    "ortho": "An orthographic camera",
}
LOOKS = {
    "vintage": "A portrait lens of the nineteenth century: swirl and curved field",
    "anamorphic": "Anamorphic: oval footprints",
    "fast": "A fast lens wide open: cat's eyes",
    "bubble": "Soap bubbles: rims brighter than the middle",
    "miniature": "A tilted lens: the world as a model",
}


def page(path, title, description, body, head="", at=""):
    """Writes a page into OUT; `at` is the link that is lit."""
    depth = len(pathlib.PurePath(path).parts) - 1
    root = "../" * depth
    links = "\n".join(
        f'<a href="{root}{to}"{" aria-current=page" if to == at else ""}>{name}</a>'
        for to, name in LINKS
    )
    values = {
        "title": html.escape(title),
        "description": html.escape(description),
        "root": root,
        "head": head,
        "links": links,
        "body": body,
        "version": VERSION,
    }
    text = (HERE / "page.html").read_text()
    for name, value in values.items():
        text = text.replace("{" + name + "}", value)
    target = OUT / path
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(text)


def rackfocus(*arguments):
    subprocess.run(
        [RACKFOCUS, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL
    )


def script(name):
    return f'<script type="module" src="{name}"></script>'


# ---- the page to try -----------------------------------------------------------------


def find_scene():
    places = ["/usr/share/doc/povray", "/usr/share/doc/povray-examples"]
    for place in places:
        for path in pathlib.Path(place).rglob("focalblur.pov*"):
            return path
    sys.exit("build.py: camera/focalblur.pov is not there; install povray-examples")


def render_focalblur(target):
    """Colour and depth of POV-Ray's example, of the size of its reference."""
    reference = REFERENCES / "povray" / "focalblur.exr"
    facts = json.loads(
        subprocess.run(
            [RACKFOCUS, "info", "--json", reference], check=True, capture_output=True
        ).stdout
    )
    kept = target.parent / "povray"
    kept.mkdir()
    output = kept / "out.exr"
    size = [f"+W{facts['width']}", f"+H{facts['height']}"]
    rackfocus("povray", find_scene(), "-o", output, "--keep", kept, "--", *size)
    shutil.move(kept / "passes.exr", target)
    shutil.rmtree(kept)


def make_samples():
    folder = OUT / "samples"
    folder.mkdir()
    for sample in SAMPLES:
        for name in sample["files"] + [sample["reference"]]:
            for place in (REFERENCES, REFERENCES / "povray"):
                if (place / name).exists():
                    shutil.copy(place / name, folder)
    render_focalblur(folder / "focalblur_passes.exr")
    (folder / "samples.json").write_text(json.dumps(SAMPLES))


def make_try():
    body = (HERE / "try.html").read_text()
    page(
        "index.html",
        "Rack Focus: pull focus after the render",
        "Depth of field after the render, to try in the browser.",
        body,
        script("try.js"),
        "index.html",
    )
    for name in [
        "try.js",
        "controls.js",
        "stage.js",
        "worker.js",
        "style.css",
        "icon.svg",
    ]:
        shutil.copy(HERE / name, OUT)
    core = OUT / "core"
    core.mkdir()
    for path in (ROOT / "web" / "core").glob("*.js"):
        shutil.copy(path, core)
    for path in WASM.glob("*.wasm"):
        shutil.copy(path, core)


# ---- the gallery ---------------------------------------------------------------------


def pair(name, left, right, caption):
    alt = html.escape(caption)
    return f"""<figure><div class="pair">
<img src="{left[0]}" alt="{alt}: {left[1]}" loading="lazy" width="480" height="270">
<div class="after"><img src="{right[0]}" alt="{alt}: {right[1]}" loading="lazy"></div>
<span class="tag left">{left[1]}</span><span class="tag right">{right[1]}</span>
<input type="range" min="0" max="100" value="50" aria-label="{name}: how much of {left[1]}">
</div><figcaption>{alt}</figcaption></figure>"""


def table_of_readme():
    """The table of how good it is, which compares with the denoised lens."""
    text = (ROOT / "README.md").read_text()
    section = text.partition("## How good is it?")[2].partition("\n## ")[0]
    section = re.sub(
        r"\]\((?!https?:)([^)]+)\)", lambda m: f"]({docs_link(m[1])})", section
    )
    made = markdown.markdown(section, extensions=["tables"])
    return made.replace(' style="text-align: center;"', "")


def docs_link(link):
    if link.startswith("docs/") and ".md" in link:
        return link.replace(".md", ".html")
    return link


def make_gallery():
    folder = OUT / "gallery"
    folder.mkdir()
    figures = []
    for name, caption in KINDS.items():
        pinhole = REFERENCES / f"{name}_pinhole.exr"
        files = {"pinhole": f"gallery/{name}_pinhole.png"}
        rackfocus("accumulate", "-q", pinhole, "-o", OUT / files["pinhole"])
        files["ours"] = f"gallery/{name}_ours.png"
        rackfocus("filter", "-q", pinhole, "-o", OUT / files["ours"])
        files["own"] = f"gallery/{name}_own.png"
        reference = REFERENCES / f"{name}_reference.exr"
        rackfocus("accumulate", "-q", reference, "-o", OUT / files["own"])
        ours = (files["ours"], "Rack Focus")
        figures.append(pair(name, (files["pinhole"], "pinhole"), ours, caption))
        own = (files["own"], "Cycles, thousands of samples")
        figures.append(
            pair(name, ours, own, caption + ", beside the renderer's own lens")
        )
    views = sorted(REFERENCES.glob("posts_view*.exr"))
    rackfocus("filter", "-q", *views, "-o", OUT / "gallery" / "posts_views.png")
    figures.append(
        pair(
            "views",
            ("gallery/posts_ours.png", "one view"),
            ("gallery/posts_views.png", "eight views"),
            "Posts: what one view cannot know, eight see",
        )
    )
    for look, caption in LOOKS.items():
        made = f"gallery/portrait_{look}.png"
        pinhole = REFERENCES / "portrait_pinhole.exr"
        rackfocus("filter", "-q", pinhole, "-o", OUT / made, "--look", look)
        plain = ("gallery/portrait_ours.png", "plain lens")
        figures.append(pair(look, plain, (made, f"--look {look}"), caption))
    body = (
        "<h1>Gallery</h1><p class='lead'>Drag in a picture, or use the arrow keys.</p>"
        f"<div class='pairs'>{''.join(figures)}</div>"
        f"<h2>How good is it?</h2>{table_of_readme()}"
    )
    page(
        "gallery.html",
        "Gallery - Rack Focus",
        "Before and after, beside the renderer's own lens.",
        body,
        script("gallery.js"),
        "gallery.html",
    )
    shutil.copy(HERE / "gallery.js", OUT)


def make_lesson():
    page(
        "lesson.html",
        "Lesson - Rack Focus",
        "The formulas of depth of field, a slider each.",
        (HERE / "lesson.html").read_text(),
        script("lesson.js"),
        "lesson.html",
    )
    shutil.copy(HERE / "lesson.js", OUT)


# ---- the documents -------------------------------------------------------------------


def local_link(match):
    """Links between pages become those between their HTML; to the tree, plain text."""
    attribute, link = match.groups()
    name, _, anchor = link.partition("#")
    if re.match(r"[a-z]+:", link) or not name or name.startswith("images/"):
        return match[0]
    stem = pathlib.PurePath(name).stem
    if name.endswith(".md") and (
        stem in PAGES and (ROOT / "docs" / f"{stem}.md").exists()
    ):
        return f'{attribute}="{stem}.html{"#" + anchor if anchor else ""}"'
    return f'data-source="{html.escape(name)}"'


def sections_of(text):
    """Heading, anchor and plain text of each section of a page's HTML."""
    parts = re.split(r'<h([1-3]) id="([^"]*)">(.*?)</h\1>', text, flags=re.S)
    for i in range(1, len(parts), 4):
        plain = re.sub(r"<[^>]+>", " ", parts[i + 3])
        heading = re.sub(r"<[^>]+>", "", parts[i + 2])
        yield html.unescape(heading), parts[i + 1], " ".join(
            html.unescape(plain).split()
        )


def render_page(name):
    text = (ROOT / "docs" / f"{name}.md").read_text()
    text = re.sub(r"^```(\w+) .*$", r"```\1", text, flags=re.M)  # "sh run"
    made = markdown.markdown(
        text, extensions=["tables", "pymdownx.superfences", "toc", "sane_lists"]
    )
    made = re.sub(r' style="text-align: (\w+);"', r' class="\1"', made)
    made = re.sub(r'(href)="([^"]*)"', local_link, made)
    title = re.search(r"<h1[^>]*>(.*?)</h1>", made, re.S)
    return (re.sub(r"<[^>]+>", "", title[1]) if title else name), made


def make_documents():
    pages = [name for name in PAGES if (ROOT / "docs" / f"{name}.md").exists()]
    rendered = {name: render_page(name) for name in pages}
    items = "".join(
        f'<li><a href="{name}.html">{title}</a></li>'
        for name, (title, _) in rendered.items()
    )
    if (OUT / "api").is_dir():
        items += '<li><a href="../api/index.html">C API</a></li>'
    aside = f"""<aside><p><label>Search <input type="search" id="search"></label></p>
<nav aria-label="Documents"><ul>{items}</ul></nav></aside>"""
    index = []
    for name, (title, made) in rendered.items():
        for heading, anchor, text in sections_of(made):
            index.append([f"{name}.html#{anchor}", title, heading, text])
        write_document(f"docs/{name}.html", title, aside, made)
    first = "<h1>Documents</h1><p>Choose a page, or search in all of them.</p>"
    write_document("docs/index.html", "Documents", aside, first)
    (OUT / "docs" / "search.json").write_text(json.dumps(index))
    shutil.copy(HERE / "search.js", OUT / "docs")
    shutil.copytree(ROOT / "docs" / "images", OUT / "docs" / "images")


def write_document(path, title, aside, made):
    body = (
        f'<div class="document">{aside}<article><div id="results" class="results" '
        f'aria-live="polite"></div><div id="content">{made}</div></article></div>'
    )
    page(
        path,
        f"{title} - Rack Focus",
        title,
        body,
        script("search.js"),
        "docs/index.html",
    )


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    api = ROOT / "build" / "docs"
    if (api / "index.html").exists():
        shutil.copytree(api, OUT / "api")
    make_try()
    make_samples()
    make_gallery()
    make_lesson()
    make_documents()
    (OUT / ".nojekyll").touch()
    total = sum(p.stat().st_size for p in OUT.rglob("*") if p.is_file())
    wasm = (OUT / "core" / "rackfocus.wasm").stat().st_size
    print(f"site: {OUT}, {total / 1e6:.1f} MB, of which the module {wasm / 1e6:.2f} MB")


RACKFOCUS, WASM, OUT = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
VERSION = re.search(r"version: '([^']+)'", (ROOT / "meson.build").read_text())[1]
main()
