# SPDX-License-Identifier: Apache-2.0
"""Single-part EXR files, written and read byte by byte: uncompressed and ZIP.

Independent of every library, and able to say things that libraries refuse to write.
"""

import struct
import zlib

import numpy

HALF, FLOAT = 1, 2


def _attribute(name, kind, data):
    return (
        name.encode()
        + b"\0"
        + kind.encode()
        + b"\0"
        + struct.pack("<i", len(data))
        + data
    )


def _value(name, value):
    if isinstance(value, str):
        return _attribute(name, "string", value.encode())
    if isinstance(value, int):
        return _attribute(name, "int", struct.pack("<i", value))
    if isinstance(value, float):
        return _attribute(name, "float", struct.pack("<f", value))
    if isinstance(value, list):
        texts = [text.encode() for text in value]
        packed = b"".join(struct.pack("<i", len(text)) + text for text in texts)
        return _attribute(name, "stringvector", packed)
    if isinstance(value[0], str):  # a type and its bytes
        return _attribute(name, *value)
    if len(value) == 16:
        return _attribute(name, "m44f", struct.pack("<16f", *value))
    return _attribute(name, "v2f", struct.pack("<2f", *value))


def write(
    path, channels, attributes=None, data=None, display=None, aspect=1.0, steps=None
):
    """Writes a dict of 2-D arrays; float16 arrays become half, others float. `steps`
    has the sampling of channels that are stored at every n-th pixel and row only.
    """
    names = sorted(channels)
    steps = {name: (steps or {}).get(name, 1) for name in names}
    full = [name for name in names if steps[name] == 1]
    height, width = channels[full[0]].shape
    data = data or (0, 0, width - 1, height - 1)
    display = display or data
    arrays = [
        a if a.dtype == numpy.float16 else a.astype(numpy.float32)
        for a in (numpy.asarray(channels[n]) for n in names)
    ]
    chlist = b""
    for name, array in zip(names, arrays, strict=True):
        kind = HALF if array.dtype == numpy.float16 else FLOAT
        chlist += (
            name.encode()
            + b"\0"
            + struct.pack("<iIii", kind, 0, steps[name], steps[name])
        )
    header = struct.pack(
        "<II", 20000630, 2 | (0x400 if _is_long(names, attributes) else 0)
    )
    header += _attribute("channels", "chlist", chlist + b"\0")
    header += _attribute("compression", "compression", b"\0")
    header += _attribute("dataWindow", "box2i", struct.pack("<4i", *data))
    header += _attribute("displayWindow", "box2i", struct.pack("<4i", *display))
    header += _attribute("lineOrder", "lineOrder", b"\0")
    header += _attribute("pixelAspectRatio", "float", struct.pack("<f", aspect))
    header += _attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += _attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    for name, value in (attributes or {}).items():
        header += _value(name, value)
    header += b"\0"
    rows = []
    for y in range(height):
        pixels = b"".join(
            a[y // steps[n]].tobytes()
            for n, a in zip(names, arrays, strict=True)
            if y % steps[n] == 0
        )
        rows.append(struct.pack("<ii", data[1] + y, len(pixels)) + pixels)
    offset = len(header) + 8 * height
    table = b""
    for row in rows:
        table += struct.pack("<Q", offset)
        offset += len(row)
    with open(path, "wb") as file:
        file.write(header + table + b"".join(rows))
    return str(path)


def _is_long(names, attributes):
    return any(len(n) > 31 for n in list(names) + list(attributes or {}))


def _read_text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


_DECODERS = {
    "string": lambda d: d.decode(),
    "float": lambda d: struct.unpack("<f", d)[0],
    "int": lambda d: struct.unpack("<i", d)[0],
    "v2f": lambda d: struct.unpack("<2f", d),
    "box2i": lambda d: struct.unpack("<4i", d),
    "compression": lambda d: d[0],
}


def read_header(data):
    """Attributes of the (only) part, the channels, and where the header ends."""
    attributes, channels, at = {}, [], 8
    while data[at]:
        name, at = _read_text(data, at)
        kind, at = _read_text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        value = data[at + 4 : at + 4 + size]
        at += 4 + size
        if kind == "chlist":
            k = 0
            while value[k]:
                channel, k = _read_text(value, k)
                channels.append((channel, struct.unpack_from("<i", value, k)[0]))
                k += 16
        else:
            attributes[name] = _DECODERS.get(kind, bytes)(value)
    return attributes, channels, at + 1


def _unzip(data):
    """Undoes the predictor and the interleaving of ZIP and ZIPS."""
    raw = numpy.frombuffer(zlib.decompress(data), numpy.uint8).astype(int)
    raw[1:] -= 128
    raw = (numpy.cumsum(raw) % 256).astype(numpy.uint8)
    out = numpy.empty_like(raw)
    half = (len(raw) + 1) // 2
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return out.tobytes()


def read(path):
    """Returns the channels as a dict of arrays, and the attributes."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, channels, at = read_header(data)
    n_rows = {0: 1, 2: 1, 3: 16}[attributes["compression"]]
    min_x, min_y, max_x, max_y = attributes["dataWindow"]
    width, height = max_x - min_x + 1, max_y - min_y + 1
    types = [numpy.float16 if kind == HALF else numpy.float32 for _, kind in channels]
    out = {
        n: numpy.empty((height, width), t)
        for (n, _), t in zip(channels, types, strict=True)
    }
    row_bytes = width * sum(numpy.dtype(t).itemsize for t in types)
    for block in range(-(-height // n_rows)):
        (start,) = struct.unpack_from("<Q", data, at + 8 * block)
        y, size = struct.unpack_from("<ii", data, start)
        pixels = data[start + 8 : start + 8 + size]
        n = min(n_rows, height - (y - min_y))
        if size < n * row_bytes:
            pixels = _unzip(pixels)
        place = 0
        for row in range(y - min_y, y - min_y + n):
            for (name, _), kind in zip(channels, types, strict=True):
                out[name][row] = numpy.frombuffer(pixels, kind, width, place)
                place += width * numpy.dtype(kind).itemsize
    return out, attributes
