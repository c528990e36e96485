# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes of the running render: written by Blender to memory, read without a copy.

Blender gives no access to the pixels of the Render Result, but saves it at any moment.
The file goes to a memory-backed folder, uncompressed, so that every channel is a
regular pattern of bytes that NumPy can view in place.
"""

import contextlib
import fcntl
import functools
import mmap
import os
import shutil
import struct
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from . import main_thread, printed
from .compat import MultilayerExr
from .lens import picture_size

MAGIC = 20000630
MULTIPART_FLAG = 0x1000
SAMPLE_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
SHARED_MEMORY = "/dev/shm"
FOLDER, LOCK = "rack_focus_", "lock"
WITHOUT_LOCK_S = 600.0  # a folder without a lock lives for milliseconds
SAVE_S = 20.0  # that the main thread may take until it comes to saving
SAVE_ERROR = b"Error: Image 'Render Result' could not be saved"
NOTHING_HIT = 1e9  # Blender writes 1e10 where no surface was hit


class Place(NamedTuple):
    """Where and how a view was taken."""

    offset: tuple  # (u, v) on the lens, scene units right and up
    shear_distance: float  # scene units; 0: the camera was turned, not sheared
    depth_factor: float  # of its depth, to make it planar distance
    time: float  # within the shutter's time, 0 to 1


MIDDLE = Place((0.0, 0.0), 0.0, 1.0, 0.5)


class PassesError(Exception):
    """The passes cannot be had; the message is for the user."""


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
            raise PassesError("the file of the render's passes is damaged")
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
            raise PassesError("the render has subsampled passes")
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
        raise PassesError("the render's passes came compressed")
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
        raise PassesError("the lines of the render's passes are out of order")
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
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    data = np.frombuffer(mapped, np.uint8)
    cursor = _Cursor(mapped)
    magic, version = cursor.unpack("<2i")
    if magic != MAGIC:
        raise PassesError("Blender did not write an EXR file")
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


# ---- passes of a layer ------------------------------------------------------------


def side_by_side(planes):
    """(height, width, n) view of n planes at equal distances in memory, else a copy."""
    first = planes[0]
    at = [plane.__array_interface__["data"][0] for plane in planes]
    steps = {b - a for a, b in zip(at[:-1], at[1:], strict=True)}
    is_alike = len({(plane.strides, plane.dtype) for plane in planes}) == 1
    if len(steps) != 1 or not is_alike or first.dtype != np.float32:
        return np.stack(planes, -1).astype(np.float32)
    base = first.base if first.base is not None else first
    start = at[0] - base.__array_interface__["data"][0]
    shape = (*first.shape, len(planes))
    return np.ndarray(shape, np.float32, base, start, (*first.strides, steps.pop()))


class Layer(NamedTuple):
    """What the filter needs of one view layer."""

    colour: np.ndarray  # (height, width, 4), scene-linear, premultiplied
    depth: np.ndarray  # (height, width), planar, scene units; None where there is none


def find_layer(channels, layer, view=""):
    """The Layer of a view layer (and view) among the channels of read_exr()."""
    tail = f".{view}" if view else ""
    names = [f"{layer}.Combined{tail}.{c}" for c in "RGBA"]
    depths = [f"{layer}.{p}{tail}.{c}" for p in ("Depth", "Z") for c in "ZVX"]
    depth = next((channels[name] for name in depths if name in channels), None)
    if any(name not in channels for name in names):
        raise PassesError(f"view layer “{layer}” was not rendered")
    return Layer(side_by_side([channels[name] for name in names]), depth)


# ---- getting them out of Blender --------------------------------------------------


def memory_folder(n_bytes):
    """A folder in memory with room for n_bytes, else Blender's own temporary one."""
    if os.path.isdir(SHARED_MEMORY) and os.access(SHARED_MEMORY, os.W_OK):
        if shutil.disk_usage(SHARED_MEMORY).free > 2 * n_bytes:
            return SHARED_MEMORY
    return bpy.app.tempdir


@contextlib.contextmanager
def own_folder(parent):
    """A folder for a while. Its locked file tells that its Blender is alive."""
    folder = Path(tempfile.mkdtemp(prefix=f"{FOLDER}{os.getpid()}_", dir=parent))
    with open(folder / LOCK, "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def _is_dead(folder):
    """Has the Blender that made a folder ended? False where that cannot be told."""
    try:
        if folder.stat().st_uid != os.getuid():
            return False
        with open(folder / LOCK) as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    except FileNotFoundError:  # just being made, or of a version without locks
        return time.time() - folder.stat().st_mtime > WITHOUT_LOCK_S
    except OSError:
        return False


def clear_dead_folders(parent=SHARED_MEMORY):
    """Removes what Blenders that were killed left in the memory file system."""
    for folder in Path(parent).glob(f"{FOLDER}*"):
        with contextlib.suppress(FileNotFoundError):
            if folder.is_dir() and not folder.is_symlink() and _is_dead(folder):
                shutil.rmtree(folder, ignore_errors=True)


class RenderedPasses:
    """The passes of a scene's render."""

    def __init__(self, scene, n_views=1):
        # A mapped file stays readable without its name.
        with self.saved(scene, n_views) as files:
            # suffix of the view's file, "" without views: channels
            self.files = {suffix: read_exr(path) for suffix, path in files.items()}

    @classmethod
    @contextlib.contextmanager
    def saved(cls, scene, n_views=1):
        """{suffix of the view's file, "" without views: its path} for a while."""
        width, height = picture_size(scene.render)
        n_bytes = width * height * 4 * 32 * n_views
        with own_folder(memory_folder(n_bytes)) as folder:
            path = folder / "passes.exr"
            cls._save(scene, path)
            yield {
                file.stem[len(path.stem) :]: file for file in path.parent.glob("*.exr")
            }

    @classmethod
    def _save(cls, scene, path):
        result = next((i for i in bpy.data.images if i.type == "RENDER_RESULT"), None)
        if result is None:
            raise PassesError("there is no render to filter yet: press F12 first")
        # Saving in another thread while the main one draws the result locks both (5.2).
        task = functools.partial(cls._write_file, scene, result, path)
        main_thread.run_or_here(task, SAVE_S)

    @staticmethod
    def _write_file(scene, result, path):
        has_views = scene.render.use_multiview
        quiet = printed.without(SAVE_ERROR) if has_views else contextlib.nullcontext()
        with MultilayerExr(scene, has_views):
            try:
                with quiet:
                    result.save_render(str(path), scene=scene)
            except RuntimeError as error:
                # Blender reports a failure for views that it wrote all the same.
                if not list(path.parent.glob("*.exr")):
                    raise PassesError(
                        f"there is no render to filter yet: press F12 first ({error})"
                    ) from error

    def layer(self, name, suffix="", view=""):
        """The Layer of a view layer; suffix, view: of a view in stereo, else ""."""
        channels = self.files.get(suffix, self.files.get(""))
        if channels is None:
            raise PassesError(f"the view “{view}” was not rendered")
        try:
            return find_layer(channels, name)
        except PassesError:
            return find_layer(channels, name, view)

    def views(self, name, suffix="", view=""):
        """[(Layer, Place)] as of one view from the middle of the lens."""
        return [(self.layer(name, suffix, view), MIDDLE)]


_kept = {}  # scene name: RenderedPasses, or views.ViewPasses


def rendered(scene):
    """The kept passes of a scene, or those of its Render Result."""
    return _kept.get(scene.name) or RenderedPasses(scene)


def keep(scene):
    """Keeps the passes of a scene's render for more than one use."""
    _kept[scene.name] = rendered(scene)


def put(scene, found):
    """Keeps passes that stand for a scene's render."""
    _kept[scene.name] = found


def forget(scene=None):
    """Lets go of the kept passes of a scene, or of all."""
    if scene is None:
        _kept.clear()
    else:
        _kept.pop(scene.name, None)
