# SPDX-License-Identifier: Apache-2.0
"""Draws the four graphs of docs/methods.md: the circle of confusion of Yu 2004.

    PYTHONPATH=build/plugin/stage python3 docs/make_yu_graphs.py

Every value comes from the library (rackfocus.Filter(...).lens), which the Python module
of the build has. The lens is that of `rackfocus view --demo`.
"""

import math
import pathlib

import rackfocus

IMAGE = pathlib.Path(__file__).parent / "images/yu_graphs.svg"
PICTURE = (960, 540)
APERTURE, FOCAL, SENSOR, FOCUS, DISTANCE = 85 / 1.4, 85.0, 36.0, 3.0, 6.0  # mm, m
SCREEN = FOCAL * FOCUS / (FOCUS - FOCAL / 1000)  # mm
STEPS = 120

PANEL, HEIGHT, LEFT, TOP, BOTTOM, RIGHT = 360, 210, 44, 30, 40, 14


def diameter(a=APERTURE, s=SCREEN, f=FOCAL, d=DISTANCE):
    """Diameter in px; a, s, f in mm, d in scene units (metres)."""
    if a == 0:
        return 0.0
    lens = rackfocus.Filter(
        *PICTURE, optics="yu", lens_radius=a / 2000, screen_position=s / 1000,
        focal_length=f, sensor_width=SENSOR, sensor_fit="horizontal", max_radius=16384,
    ).lens  # fmt: skip
    return 2 * abs(lens.radius_px(d))


# Name, label of the axis, range, what is set, what would be sharp.
GRAPHS = [
    ("a", "aperture a, mm", (0, 2 * APERTURE), APERTURE, None),
    ("s", "screen position s, mm", (85.01, 89), SCREEN, FOCAL * 6 / (6 - 0.085)),
    ("f", "focal length f, mm", (81, 87.4), FOCAL, 1 / (1 / SCREEN + 1 / 6000)),
    ("d", "distance d, m", (1.5, 18), DISTANCE, FOCUS),
]


def ticks(low, high, most=6):
    rough = (high - low) / (most - 1)
    power = 10 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough * (1 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    return [(first + i) * step for i in range(most) if (first + i) * step <= high]


def panel(name, label, span, now, sharp):
    """One graph at the origin, as lines of SVG."""
    low, high = span
    at = [low + (high - low) * i / STEPS for i in range(STEPS + 1)]
    values = [diameter(**{name: x}) for x in at]
    top = max(values)
    width, height = PANEL - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def x_of(value):
        return LEFT + (value - low) / (high - low) * width

    def y_of(value):
        return TOP + (1 - value / top) * height

    out = [f'<text x="{LEFT}" y="18">c, px, over {label}</text>']
    for tick in ticks(0, top):
        out.append(
            f'<path d="M{LEFT} {y_of(tick):.1f}h{width}" stroke="#ddd"/><text '
            f'x="{LEFT - 5}" y="{y_of(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>'
        )
    for tick in ticks(low, high):
        out.append(
            f'<path d="M{x_of(tick):.1f} {TOP}v{height}" stroke="#eee"/><text '
            f'x="{x_of(tick):.1f}" y="{TOP + height + 15}" text-anchor="middle">'
            f"{tick:g}</text>"
        )
    marks = [(now, "#d97700")] + ([(sharp, "#2a8a4a")] if sharp else [])
    out += [
        f'<path d="M{x_of(value):.1f} {TOP}v{height}" stroke="{colour}"/>'
        for value, colour in marks
    ]
    points = "L".join(f"{x_of(x):.1f} {y_of(v):.1f}" for x, v in zip(at, values))
    out.append(f'<path d="M{points}" fill="none" stroke="#2563b0" stroke-width="2"/>')
    out.append(
        f'<circle cx="{x_of(now):.1f}" cy="{y_of(diameter(**{name: now})):.1f}" r="4" '
        'fill="#d97700"/>'
    )
    return out


def main():
    width, height = 2 * PANEL, 2 * HEIGHT
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    for i, graph in enumerate(GRAPHS):
        out.append(f'<g transform="translate({i % 2 * PANEL} {i // 2 * HEIGHT})">')
        out += [*panel(*graph), "</g>"]
    IMAGE.write_text("\n".join([*out, "</svg>", ""]), encoding="utf-8")
    print(f"{IMAGE.name}: c = {diameter():.2f} px")


if __name__ == "__main__":
    main()
