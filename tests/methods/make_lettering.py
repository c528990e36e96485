#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes cli/pages/lettering_glyphs.c, the letters of the sheets.

    apt-get install fonts-roboto-unhinted python3-pil
    tests/methods/make_lettering.py

Roboto (Apache License 2.0, Debian's fonts-roboto-unhinted) at 32 px, as FreeType draws
it, 16 steps of coverage.
"""

import pathlib

from PIL import Image, ImageDraw, ImageFont

FONT = "/usr/share/fonts/truetype/roboto/unhinted/RobotoTTF/Roboto-Regular.ttf"
OUT = pathlib.Path(__file__).resolve().parents[2] / "cli" / "lettering_glyphs.c"
SIZE_PX = 32
LETTERS = [chr(c) for c in range(0x20, 0x7F)] + list("°±µ×–…")

HEAD = """/* SPDX-License-Identifier: Apache-2.0 */
/* Made by tests/methods/make_lettering.py from Roboto, copyright 2011 Google Inc. */
#include "lettering_glyphs.h"

/* clang-format off */
const struct glyph glyphs[] = {
"""


def glyph(font, letter):
    """The row of the table: the box of the ink, then its coverage from the top."""
    left, top, right, bottom = font.getbbox(letter, anchor="ls")
    picture = Image.new("L", (max(right - left, 1), max(bottom - top, 1)))
    ImageDraw.Draw(picture).text((-left, -top), letter, 255, font, anchor="ls")
    text = "".join(f"{round(v / 17):x}" for v in picture.getdata())
    rows = [text[i : i + 80] for i in range(0, len(text), 80)]
    advance = round(font.getlength(letter))
    return (
        f"    {{0x{ord(letter):x}, {left}, {top}, {picture.width}, {picture.height}, "
        f"{advance},\n" + "\n".join(f'     "{row}"' for row in rows) + "},\n"
    )


def main():
    font = ImageFont.truetype(FONT, SIZE_PX, layout_engine=ImageFont.Layout.BASIC)
    table = "".join(glyph(font, letter) for letter in LETTERS)
    end = "};\n/* clang-format on */\n\nconst int n_glyphs = sizeof glyphs / sizeof *glyphs;\n"
    OUT.write_text(HEAD + table + end)


main()
