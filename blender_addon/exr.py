# SPDX-License-Identifier: GPL-3.0-or-later
"""EXR files of scan lines without compression: read in place, and written.

Every channel of such a file is a regular pattern of bytes that NumPy can view. Blender's
files of passes are read, of one part or of several. What is written has one part, as its
planes are or packed (ZIP of the OpenEXR library).
"""

import mmap
import os
import struct
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

MAGIC, VERSION = 20000630, 2
LONG_NAMES_FLAG, MULTIPART_FLAG = 0x400, 0x1000
FLOAT = 2
SAMPLE_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), FLOAT: np.dtype("<f4")}
CODECS = {"NONE": (0, 1), "ZIPS": (2, 1), "ZIP": (3, 16)}  # number, lines of a block
ZIP_LEVEL = 4  # of zlib, as the OpenEXR library takes
STRUCTURE = set(  # attributes that say how a file lies, not what it shows
    "channels chunkCount colorInteropID compression dataWindow displayWindow lineOrder "
    "multiView name pixelAspectRatio preview screenWindowCenter screenWindowWidth type "
    "version".split()
)
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
    about: dict  # name: bytes of the whole attribute, those of STRUCTURE aside


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
    attributes, about = {}, {}
    while True:
        name = cursor.text()
        if not name:
            break
        kind, size = cursor.text(), cursor.unpack("<i")
        attributes[name] = bytes(cursor.data[cursor.at : cursor.at + size])
        cursor.at += size
        if name not in STRUCTURE:
            about[name] = attribute(name, kind, attributes[name])
    if attributes["compression"] != b"\0":
        raise ExrError("the render's passes came compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    name = attributes.get("name", b"").decode().rstrip("\0")
    channels = _read_channels(attributes["channels"])
    return Part(name, channels, x1 - x0 + 1, y1 - y0 + 1, attributes, about)


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
    """The channels of read_parts()."""
    return read_parts(path)[0]


def read_file(path):
    """The same with {attribute: bytes} of the first part."""
    found, parts = read_parts(path)
    return found, parts[0].attributes


def read_parts(path):
    """({full channel name: (height, width) array}, [Part]) of an EXR.

    It must be uncompressed and of scan lines.
    Rows from the top. The arrays are views of the mapped file. In files of several
    parts the part's name stands before channel names that lack it.
    """
    try:
        return _read_parts(path)
    except (IndexError, KeyError, TypeError, ValueError, struct.error) as error:
        raise ExrError("the file of the render's passes is damaged") from error


def _read_parts(path):
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
    return found, parts


# ---- writing ----------------------------------------------------------------------


def attribute(name, kind, data):
    head = f"{name}\0{kind}\0".encode()
    return head + struct.pack("<i", len(data)) + data


def text(name, text):
    return attribute(name, "string", text.encode())


def write_exr(path, channels, attributes=b"", codec="NONE"):
    """Writes {name: (height, width) array} beside `path` and renames.

    The arrays are of SAMPLE_TYPES; codec: of CODECS.
    """
    names = sorted(channels)
    height, width = channels[names[0]].shape
    kinds = {dtype: kind for kind, dtype in SAMPLE_TYPES.items()}
    number, n_lines = CODECS[codec]
    about = b"".join(
        name.encode()
        + b"\0"
        + struct.pack("<iB3x2i", kinds[channels[name].dtype], 0, 1, 1)
        for name in names
    )
    header = _header(about, width, height, number) + attributes + b"\0"
    planes = [
        np.ascontiguousarray(channels[name]).view(np.uint8).reshape(height, -1)
        for name in names
    ]
    lines = np.concatenate(planes, 1)
    firsts = range(0, height, n_lines)
    raw = [lines[first : first + n_lines].reshape(-1) for first in firsts]
    with ThreadPoolExecutor() as threads:  # zlib gives others their turn
        packed = raw if codec == "NONE" else list(threads.map(_packed, raw))
    blocks = [
        (struct.pack("<2i", first, len(data)), data)
        for first, data in zip(firsts, packed, strict=True)
    ]
    sizes = [0, *(len(head) + len(data) for head, data in blocks[:-1])]
    offsets = len(header) + 8 * len(blocks) + np.cumsum(sizes, dtype="<u8")
    beside = f"{path}.part"
    try:
        with open(beside, "wb") as file:
            file.write(header)
            file.write(offsets.astype("<u8").tobytes())
            for head, data in blocks:
                file.write(head)
                file.write(data)
        os.replace(beside, path)
    finally:
        Path(beside).unlink(missing_ok=True)


def _header(channels, width, height, codec):
    """What stands before the attributes of a file of one part."""
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    found = struct.pack("<2i", MAGIC, VERSION | LONG_NAMES_FLAG)
    found += attribute("channels", "chlist", channels + b"\0")
    found += attribute("compression", "compression", struct.pack("B", codec))
    found += attribute("dataWindow", "box2i", window)
    found += attribute("displayWindow", "box2i", window)
    found += attribute("lineOrder", "lineOrder", b"\0")
    found += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    found += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    return found + attribute("screenWindowWidth", "float", struct.pack("<f", 1))


def _packed(raw):
    """The bytes of a block as ZIP has them; as they are where that is no shorter."""
    parted = np.concatenate((raw[0::2], raw[1::2]))
    steps = parted.copy()
    steps[1:] -= parted[:-1]
    steps[1:] += 128
    packed = zlib.compress(steps, ZIP_LEVEL)
    return packed if len(packed) < len(raw) else raw
