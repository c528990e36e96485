# SPDX-License-Identifier: Apache-2.0
"""Tables and a plot of what bench.py measured."""

import math

BEGIN, END = "<!-- bench: begin -->", "<!-- bench: end -->"
FULL_HD = (1920, 1080)
#: In the order of the plot's legend.
COLOURS = [
    *("#1f4e9c", "#c23b22", "#3a8f3a", "#8a5fb0", "#c98a1b", "#3aa0a8", "#b0578d"),
    *("#6b6b6b", "#7a4b2a", "#222222", "#9aa71e", "#4878d0"),
]


class Table:
    """Rows of text, for Markdown; the first column to the left, the rest right."""

    def __init__(self, *heads):
        self.rows = [heads]

    def add(self, *cells):
        """One row; None is shown as a dash."""
        self.rows.append(["–" if c is None else str(c) for c in cells])

    def __str__(self):
        widths = [max(len(r[i]) for r in self.rows) for i in range(len(self.rows[0]))]
        rule = ["-" * widths[0], *("-" * (w - 1) + ":" for w in widths[1:])]
        lines = [self.rows[0], rule, *self.rows[1:]]
        return "\n".join(
            "| "
            + " | ".join(
                cell.ljust(w) if i == 0 else cell.rjust(w)
                for i, (cell, w) in enumerate(zip(line, widths, strict=True))
            )
            + " |"
            for line in lines
        )


def number(value, digits=2):
    """A number with so many significant digits, never in powers of ten."""
    if value is None:
        return None
    if value == 0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{places}f}"


def ratio(a, b):
    """a / b, or None where one is missing."""
    return a / b if a is not None and b else None


class Cases:
    """Finds rows by what was measured."""

    def __init__(self, data):
        self.rows = data["cases"]

    def sizes(self):
        """Sizes in the order of the run."""
        return list(dict.fromkeys((r["width"], r["height"]) for r in self.rows))

    def methods(self, size):
        """Methods of one view measured at this size."""
        return list(
            dict.fromkeys(
                r["name"]
                for r in self.rows
                if (r["width"], r["height"]) == size and r.get("views") == 1
            )
        )

    def radii(self, size):
        """Radii measured at this size."""
        return sorted(
            {
                r["radius"]
                for r in self.rows
                if "radius" in r and (r["width"], r["height"]) == size
            }
        )

    def get(self, size, name, radius=None, threads=2, key="cpu_s", views=1):
        """One time in seconds, or None where it was not measured."""
        for r in self.rows:
            if (
                (r["width"], r["height"], r["name"]) == (*size, name)
                and r["threads"] == threads
                and (name == "copy" or (r["radius"], r["views"]) == (radius, views))
            ):
                return r.get(key)
        return None


def mean_quality(data, name):
    """Mean tPSNR of a method over the scenes all were measured on."""
    scores = data["quality"].get(name)
    return sum(scores.values()) / len(scores) if scores else None


def size_table(data, cases, size):
    """All methods and radii at one size."""
    pixels = size[0] * size[1]
    table = Table(
        *("method", "radius px", "wall ms", "CPU ms", "copies (wall)"),
        *("copies (CPU)", "CPU ns/px", "1 to 2 threads", "tPSNR dB"),
    )
    copy = cases.get(size, "copy"), cases.get(size, "copy", key="wall_s")
    for name in cases.methods(size):
        for radius in cases.radii(size):
            cpu = cases.get(size, name, radius)
            wall = cases.get(size, name, radius, key="wall_s")
            one = cases.get(size, name, radius, threads=1, key="wall_s")
            table.add(
                *(name, f"{radius:g}"),
                number(wall and wall * 1e3, 3),
                number(cpu and cpu * 1e3, 3),
                number(ratio(wall, copy[1])),
                number(ratio(cpu, copy[0])),
                number(cpu and cpu * 1e9 / pixels),
                number(ratio(one, wall)),
                number(mean_quality(data, name), 3),
            )
    return (
        f"{size[0]} x {size[1]}, 2 threads. A cold copy of the buffers: "
        f"{number(copy[1] * 1e3)} ms, {number(copy[0] * 1e3)} ms of CPU.\n\n{table}"
    )


def race_table(data):
    """The other programs, and our own methods in the same turns."""
    table = Table(
        *("program", "size", "radius px", "wall s", "CPU s", "times `layered` (CPU)"),
        "tPSNR dB",
    )
    for r in data["race"]:
        key = (r["width"], r["height"], r["radius"])
        ours = [
            q["cpu_s"]
            for q in data["race"]
            if q["name"] == "layered" and (q["width"], q["height"], q["radius"]) == key
        ]
        table.add(
            *(r["name"], f"{r['width']} x {r['height']}", f"{r['radius']:g}"),
            *(number(r["wall_s"], 3), number(r["cpu_s"], 3)),
            number(ratio(r["cpu_s"], ours[0] if ours else None)),
            number(quality_of(data, r["name"]), 3),
        )
    return str(table)


def quality_of(data, name):
    """Mean over the scenes that every one of the race has, so that means compare."""
    name = name.removesuffix(", next picture")
    raced = {r["name"] for r in data["race"]} & set(data["quality"])
    if name not in raced:
        return None
    shared = set.intersection(*(set(data["quality"][n]) for n in raced))
    scores = [data["quality"][name][s] for s in shared]
    return sum(scores) / len(scores) if scores else None


def quality_table(data):
    """tPSNR per scene."""
    scenes = list(dict.fromkeys(s for row in data["quality"].values() for s in row))
    table = Table("tPSNR dB", *scenes)
    for name, row in data["quality"].items():
        table.add(name, *(f"{row[s]:.2f}" if s in row else None for s in scenes))
    return str(table)


def ratios_table(data, cases):
    """What the figures come to."""
    table = Table("1920 x 1080, ratios of CPU time unless said", "measured")
    if FULL_HD not in cases.sizes():
        return ""

    def get(name, radius, **more):
        return cases.get(FULL_HD, name, radius, **more)

    copy = get("copy", None)
    for radius in (32, 128):
        table.add(
            f"`layered`, {radius} px, in copies",
            number(ratio(get("layered", radius), copy)),
        )
    table.add(
        "`layered`, 128 px to 32 px",
        number(ratio(get("layered", 128), get("layered", 32))),
    )
    table.add(
        "`layered`, 32 px, wall time with 1 thread to 2",
        number(
            ratio(
                get("layered", 32, threads=1, key="wall_s"),
                get("layered", 32, key="wall_s"),
            )
        ),
    )
    for name in cases.methods(FULL_HD):
        if name not in ("layered", "scatter"):
            cpu, wall = get(name, 32), get(name, 32, key="wall_s")
            table.add(
                f"`{name}`, 32 px, frames a second on this machine"
                " / by CPU time over 2",
                f"{number(ratio(1, wall))} / {number(ratio(2, cpu))}",
            )
    for r in data["cases"]:
        if r.get("views", 1) > 1 and r["threads"] == 2:
            one = get("layered", r["radius"])
            table.add(
                f"{r['views']} views to one, {r['radius']:g} px",
                number(ratio(r.get("cpu_s"), one)),
            )
    return str(table)


def text(data):
    """All tables."""
    cases = Cases(data)
    parts = [
        "On {processor}, {processors} processors that other work shared (load "
        "{load:.1f}), commit {commit}.".format(**data["about"])
    ]
    parts.append(ratios_table(data, cases))
    parts += [size_table(data, cases, size) for size in cases.sizes()]
    if data["race"]:
        parts.append("Against other programs, in turns:\n\n" + race_table(data))
    if data["quality"]:
        parts.append(quality_table(data))
    return "\n\n".join(part for part in parts if part)


# ---- the plot --------------------------------------------------------------------

WIDTH, HEIGHT = 760, 430
LEFT, RIGHT, TOP, BOTTOM = 64, 190, 34, 48


def curves(data, cases):
    """{name: [(radius, copies)]} at 1920 x 1080."""
    copy = cases.get(FULL_HD, "copy")
    out = {}
    for name in cases.methods(FULL_HD):
        points = [
            (radius, ratio(cases.get(FULL_HD, name, radius), copy))
            for radius in cases.radii(FULL_HD)
            if radius > 0
        ]
        out[name] = [(r, v) for r, v in points if v]
    for r in data["race"]:
        if (r["width"], r["height"]) == FULL_HD and r["name"] not in out:
            others = [q for q in data["race"] if q["name"] == r["name"]]
            out[r["name"]] = [
                (q["radius"], q["cpu_s"] / copy)
                for q in others
                if (q["width"], q["height"]) == FULL_HD
            ]
    return {name: points for name, points in out.items() if points}


def axis(low, high, start, end):
    """Maps a logarithmic range to the picture."""
    scale = (end - start) / (math.log10(high) - math.log10(low))
    return lambda v: start + (math.log10(v) - math.log10(low)) * scale


def plot(data):
    """An SVG: CPU time in cold copies over the radius, both logarithmic."""
    cases = Cases(data)
    lines = curves(data, cases)
    values = [v for points in lines.values() for _, v in points]
    low = 10 ** math.floor(math.log10(min(values)))
    high = 10 ** math.ceil(math.log10(max(values)))
    x = axis(2, 128, LEFT, WIDTH - RIGHT)
    y = axis(low, high, HEIGHT - BOTTOM, TOP)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
        f'<text x="{LEFT}" y="18" font-size="13">CPU time at 1920 x 1080, '
        "in cold copies of the buffers</text>",
    ]
    decade = low
    while decade <= high:
        out.append(
            f'<path d="M{LEFT} {y(decade):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
            f'<text x="{LEFT - 6}" y="{y(decade) + 4:.1f}" text-anchor="end">'
            f"{decade:g}</text>"
        )
        decade *= 10
    for radius in (2, 8, 32, 128):
        out.append(
            f'<path d="M{x(radius):.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#eee"/>'
            f'<text x="{x(radius):.1f}" y="{HEIGHT - BOTTOM + 18}" '
            f'text-anchor="middle">{radius}</text>'
        )
    out.append(
        f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 10}" '
        'text-anchor="middle">largest radius, px</text>'
    )
    places = spread_labels([y(points[-1][1]) for points in lines.values()])
    for (name, points), colour, place in zip(
        lines.items(), COLOURS, places, strict=False
    ):
        path = "L".join(f"{x(r):.1f} {y(v):.1f}" for r, v in points)
        wide = 3 if name == "layered" else 1.5
        out.append(
            f'<path d="M{path}" fill="none" stroke="{colour}" '
            f'stroke-width="{wide}"/>'
        )
        out += [
            f'<circle cx="{x(r):.1f}" cy="{y(v):.1f}" r="3" fill="{colour}"/>'
            for r, v in points
        ]
        end_x, end_y = x(points[-1][0]) + 5, y(points[-1][1])
        out.append(
            f'<path d="M{end_x:.1f} {end_y:.1f}L{WIDTH - RIGHT + 14} {place:.1f}" '
            f'stroke="{colour}" stroke-width="0.5"/>'
            f'<text x="{WIDTH - RIGHT + 17}" y="{place + 4:.1f}" fill="{colour}">'
            f"{name}</text>"
        )
    return "\n".join([*out, "</svg>\n"])


def spread_labels(places, gap=15):
    """Moves places apart so that texts do not overlap; keeps their order."""
    order = sorted(range(len(places)), key=lambda i: places[i])
    out = list(places)
    for a, b in zip(order, order[1:], strict=False):
        out[b] = max(out[b], out[a] + gap)
    limit = HEIGHT - BOTTOM
    for i in reversed(order):
        out[i] = min(out[i], limit)
        limit = out[i] - gap
    return out


def write_docs(data, docs):
    """Replaces the figures of docs/performance.md and its plot."""
    page = docs / "performance.md"
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END)[1]
    body = f"{BEGIN}\n{text(data)}\n{END}"
    page.write_text(before + body + after, encoding="utf-8")
    (docs / "images" / "performance.svg").write_text(plot(data), encoding="utf-8")
