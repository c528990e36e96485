# SPDX-License-Identifier: Apache-2.0
"""Files of one part, flat and deep scan lines, put together to one of several, which
OpenImageIO refuses to write."""

import struct

DEEP, MULTIPART = 0x800, 0x1000


def attribute(name, kind, value):
    head = name.encode() + b"\0" + kind.encode() + b"\0"
    return head + struct.pack("<i", len(value)) + value


def chunk_bytes(data, at, is_deep):
    """How long the chunk is that begins there."""
    if not is_deep:
        return 8 + struct.unpack_from("<i", data, at + 4)[0]
    n_counts, n_samples = struct.unpack_from("<QQ", data, at + 4)
    return 28 + n_counts + n_samples


def take_apart(path):
    """The attributes of a file as they are stored, its chunks, and whether it is deep."""
    data = path.read_bytes()
    is_deep = bool(struct.unpack_from("<I", data, 4)[0] & DEEP)
    attributes, at = {}, 8
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        start = at + len(name) + len(kind) + 2
        (n,) = struct.unpack_from("<i", data, start)
        attributes[name.decode()] = (kind.decode(), data[start + 4 : start + 4 + n])
        at = start + 4 + n
    (first,) = struct.unpack_from("<Q", data, at + 1)
    places = struct.unpack_from(f"<{(first - at - 1) // 8}Q", data, at + 1)
    chunks = [data[p : p + chunk_bytes(data, p, is_deep)] for p in places]
    return attributes, chunks, is_deep


def join(path, **parts):
    """Writes files of one part each as the parts that they are named by, in order."""
    found = [take_apart(part) for part in parts.values()]
    headers, chunks = b"", []
    for i, name in enumerate(parts):
        attributes, own, is_deep = found[i]
        kind = b"deepscanline" if is_deep else b"scanlineimage"
        more = {
            "name": ("string", name.encode()),
            "type": ("string", kind),
            "chunkCount": ("int", struct.pack("<i", len(own))),
        }
        for key, value in (attributes | more).items():
            headers += attribute(key, *value)
        headers += b"\0"
        chunks += [struct.pack("<i", i) + chunk for chunk in own]
    flags = 2 | MULTIPART | DEEP * any(is_deep for _, _, is_deep in found)
    data = struct.pack("<II", 20000630, flags) + headers + b"\0"
    place, table = len(data) + 8 * len(chunks), b""
    for chunk in chunks:
        table += struct.pack("<Q", place)
        place += len(chunk)
    path.write_bytes(data + table + b"".join(chunks))
    return path
