# SPDX-License-Identifier: GPL-3.0-or-later
"""EXR files of scan lines without compression: read in place, and written.

Every channel of such a file is a regular pattern of bytes that NumPy can view. Blender's
files of passes are read, of one part or of several; what is written are 32-bit floats.
"""

import mmap
import os
import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np

MAGIC, VERSION = 20000630, 2
LONG_NAMES_FLAG, MULTIPART_FLAG = 0x400, 0x1000
FLOAT = 2
SAMPLE_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), FLOAT: np.dtype("<f4")}
CAN_MAP = os.name == "posix"  # Windows removes no file that is mapped


class ExrError(Exception):
    """A file cannot be read; the message is for the user."""


class Part(NamedTuple):
    """Header of one part of an EXR file."""

    name: str
    channels: list  # of (name, dtype), in the order of the file
    width: int
    height: int
    attributes: dict  # name: bytes


# ---- reading ----------------------------------------------------------------------


class _Cursor:
    """Reads numbers and texts from bytes or a mapped file."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def unpack(self, pattern):
        values = struct.unpack_from(pattern, self.data, self.at)
        self.at += struct.calcsize(pattern)
        return values[0] if len(values) == 1 else values

    def text(self):
        end = self.data.find(b"\0", self.at)
        if end < 0:
            raise ExrError("the file of the render's passes is damaged")
        found = bytes(self.data[self.at : end]).decode()
        self.at = end + 1
        return found


def _read_channels(data):
    """(name, dtype) of every channel of a chlist attribute."""
    cursor, found = _Cursor(data), []
    while data[cursor.at]:
        name = cursor.text()
        kind, _, x_step, y_step = cursor.unpack("<i4s2i")
        if (x_step, y_step) != (1, 1):
            raise ExrError("the render has subsampled passes")
        found.append((name, SAMPLE_TYPES[kind]))
    return found


def _read_header(cursor):
    """One header up to its end mark."""
    attributes = {}
    while True:
        name = cursor.text()
        if not name:
            break
        cursor.text()  # the type
        size = cursor.unpack("<i")
        attributes[name] = bytes(cursor.data[cursor.at : cursor.at + size])
        cursor.at += size
    if attributes["compression"] != b"\0":
        raise ExrError("the render's passes came compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    name = attributes.get("name", b"").decode().rstrip("\0")
    channels = _read_channels(attributes["channels"])
    return Part(name, channels, x1 - x0 + 1, y1 - y0 + 1, attributes)


def _view_part(data, part, offsets, n_head_bytes):
    """{channel name: (height, width) view} of a part whose lines lie at `offsets`."""
    steps = np.diff(offsets.astype(np.int64))
    n_line_bytes = n_head_bytes + part.width * sum(t.itemsize for _, t in part.channels)
    step = int(steps[0]) if len(steps) else n_line_bytes
    if np.any(steps != step) or abs(step) < n_line_bytes:
        raise ExrError("the lines of the render's passes are out of order")
    views = {}
    at = int(offsets[0]) + n_head_bytes
    for name, dtype in part.channels:
        # The buffer starts at the lowest byte; negative steps run up to it.
        views[name] = np.ndarray(
            (part.height, part.width), dtype, data, at, (step, dtype.itemsize)
        )
        at += part.width * dtype.itemsize
    return views


def read_exr(path):
    """The channels of read_file()."""
    return read_file(path)[0]


def read_file(path):
    """({full channel name: (height, width) array}, {attribute: bytes}) of an EXR.

    It must be uncompressed and of scan lines. The attributes are of its first part.
    Rows from the top. The arrays are views of the mapped file. In files of several
    parts the part's name stands before channel names that lack it.
    """
    with open(path, "rb") as file:
        if CAN_MAP:
            mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        else:
            mapped = file.read()
    data = np.frombuffer(mapped, np.uint8)
    cursor = _Cursor(mapped)
    magic, version = cursor.unpack("<2i")
    if magic != MAGIC:
        raise ExrError("Blender did not write an EXR file")
    is_multipart = bool(version & MULTIPART_FLAG)
    parts = [_read_header(cursor)]
    while is_multipart and cursor.data[cursor.at]:
        parts.append(_read_header(cursor))
    cursor.at += is_multipart
    found = {}
    for part in parts:
        offsets = np.frombuffer(data, "<u8", part.height, cursor.at)
        cursor.at += 8 * part.height
        views = _view_part(data, part, offsets, 12 if is_multipart else 8)
        for name, view in views.items():
            has_layer = name.count(".") >= 2 or not part.name
            found[name if has_layer else f"{part.name}.{name}"] = view
    return found, parts[0].attributes


# ---- writing ----------------------------------------------------------------------


def attribute(name, kind, data):
    head = f"{name}\0{kind}\0".encode()
    return head + struct.pack("<i", len(data)) + data


def text(name, text):
    return attribute(name, "string", text.encode())


def write_exr(path, channels, attributes=b""):
    """Writes {name: (height, width) float32} beside `path` and renames."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    about = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3x2i", FLOAT, 0, 1, 1) for name in names
    )
    header = struct.pack("<2i", MAGIC, VERSION | LONG_NAMES_FLAG)
    header += attribute("channels", "chlist", about + b"\0")
    header += attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", window)
    header += attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    header += attributes + b"\0"
    lines = np.empty((height, 2 + len(names) * width), "<f4")
    lines[:, 0] = np.arange(height, dtype="<i4").view("<f4")
    lines[:, 1] = np.array([4 * width * len(names)], "<i4").view("<f4")
    for index, name in enumerate(names):
        lines[:, 2 + index * width : 2 + (index + 1) * width] = channels[name]
    start = len(header) + 8 * height
    offsets = start + lines.strides[0] * np.arange(height, dtype="<u8")
    beside = f"{path}.part"
    try:
        with open(beside, "wb") as file:
            file.write(header)
            file.write(offsets.tobytes())
            file.write(lines.data)
        os.replace(beside, path)
    finally:
        Path(beside).unlink(missing_ok=True)
