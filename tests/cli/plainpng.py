# SPDX-License-Identifier: Apache-2.0
"""PNG files read byte by byte, independent of every library."""

import struct
import zlib

import numpy


def read(path):
    """8 bit RGB or RGBA of whatever filters."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind = data[at + 4 : at + 8]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack_from(">IIBB", data, at + 8)
            assert bits == 8
            n = {2: 3, 6: 4}[colour]
        if kind == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += 12 + length
    raw = numpy.frombuffer(zlib.decompress(packed), numpy.uint8)
    raw = raw.reshape(height, 1 + n * width).astype(int)
    out = numpy.zeros((height, width, n), int)
    for y in range(height):
        for x in range(width):
            left = out[y, x - 1] if x else numpy.zeros(n, int)
            up = out[y - 1, x] if y else numpy.zeros(n, int)
            corner = out[y - 1, x - 1] if x and y else numpy.zeros(n, int)
            guess = left + up - corner
            d = [abs(guess - left), abs(guess - up), abs(guess - corner)]
            paeth = numpy.where(
                (d[0] <= d[1]) & (d[0] <= d[2]),
                left,
                numpy.where(d[1] <= d[2], up, corner),
            )
            add = [0 * left, left, up, (left + up) // 2, paeth][raw[y, 0]]
            out[y, x] = (raw[y, 1 + n * x : 1 + n * (x + 1)] + add) % 256
    return out
