# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes of the running render: written by Blender to memory, read without a copy.

Blender gives no access to the pixels of the Render Result, but saves it at any moment.
The file goes to a memory-backed folder, uncompressed, so that NumPy can view every
channel in place (exr.py).
"""

import contextlib
import functools
import os
import shutil
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from . import exr, freestyle, main_thread, mirrors, names, printed, sharp, slots
from .compat import MultilayerExr
from .lens import picture_size

try:
    import fcntl
except ImportError:  # Windows
    import msvcrt

    fcntl = None

SHARED_MEMORY = "/dev/shm"
FOLDER, LOCK = "rack_focus_", "lock"
TRIES = 10  # to make a folder
WITHOUT_LOCK_S = 600.0  # a folder without a lock lives for milliseconds
SAVE_S = 20.0  # that the main thread may take until it comes to saving
SAVE_ERROR = b"Error: Image 'Render Result' could not be saved"
LONGEST_CHANNEL = 63  # bytes of its name; 3.4 to 4.5 cut longer ones
NOTHING_HIT = 1e9  # Blender writes 1e10 where no surface was hit
FAR = np.float32(1e8)


class Place(NamedTuple):
    """Where and how a view was taken."""

    offset: tuple  # (u, v) on the lens, scene units right and up
    shear_distance: float  # scene units; 0: the camera was turned, not sheared
    depth_factor: float  # of its depth, to make it planar distance
    time: float  # within the shutter's time, 0 to 1
    spread_px: float = 0.0  # radius of sampling.py's disc; 0: through a pixel filter


MIDDLE = Place((0.0, 0.0), 0.0, 1.0, 0.5)


class PassesError(Exception):
    """The passes cannot be had; the message is for the user."""


class RoomError(PassesError):
    """There is no room for the files of passes; the message is for the user."""


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


# Passes of Cycles, where denoising data is stored: what tells the parts of mixed pixels
# (rackfocus.Filter.mean_depth()), and by what they guide as a denoiser.
RAYS = "Denoising Depth"
GUIDES = {"albedo": ("Denoising Albedo", "RGB"), "normal": ("Denoising Normal", "XYZ")}
FACING = "Denoising Normal", "Z"  # of GUIDES, what points along the camera's axis


def guides_of(channels, layer, tail=""):
    """{name: (height, width, 3)} of GUIDES, as far as they were rendered.

    channels: of exr.read_exr(); tail: what follows the pass in the names.
    """
    found = {}
    for guide, (part, axes) in GUIDES.items():
        names = [f"{layer}.{part}{tail}.{c}" for c in axes]
        if all(name in channels for name in names):
            found[guide] = side_by_side([channels[name] for name in names])
    return found


class Layer(NamedTuple):
    """What the filter needs of one view layer."""

    colour: np.ndarray  # (height, width, 4), scene-linear, premultiplied
    depth: np.ndarray  # (height, width), planar, scene units; None where there is none
    mattes: tuple = ()  # as of sharp.mattes_of(), where objects stay sharp
    seen: mirrors.Seen = None  # what mirrors and panes show, where it was rendered
    grainy: np.ndarray = None  # the colour with its grain, where `colour` has lost it
    lines: np.ndarray = None  # Freestyle's, (height, width, 4), premultiplied
    rays: np.ndarray = None  # mean lengths, scene units; None: not rendered, or no use
    facing: np.ndarray = None  # mean of FACING, 0 where nothing was hit, or None


def with_some_depth(depth):
    """A depth that is empty in this frame lies far away; infinity is an error."""
    return depth if depth.min() < NOTHING_HIT else np.minimum(depth, FAR)


def find_layer(channels, layer, view=""):
    """The Layer of a view layer (and view) among the channels of exr.read_exr()."""
    tail = f".{view}" if view else ""
    names = [f"{layer}.Combined{tail}.{c}" for c in "RGBA"]
    depths = [f"{layer}.{p}{tail}.{c}" for p in ("Depth", "Z") for c in "ZVX"]
    depth = next((channels[name] for name in depths if name in channels), None)
    longest = LONGEST_CHANNEL - len(f".Combined{tail}.R".encode())
    is_there = all(name in channels for name in names)
    if not is_there and len(layer.encode()) > longest:
        raise PassesError(
            f"the name of view layer “{layer}” is too long for this Blender: at most "
            f"{longest} bytes"
        )
    if not is_there:
        raise PassesError(f"view layer “{layer}” was not rendered: press F12")
    mattes = sharp.mattes_of(channels, layer, tail)
    seen = mirrors.seen_of(channels, layer, tail)
    colour = side_by_side([channels[name] for name in names])
    lines = freestyle.lines_of(channels, f"{layer}.{freestyle.NAME}{tail}")
    rays = channels.get(f"{layer}.{RAYS}{tail}.Z")
    facing = channels.get(f"{layer}.{FACING[0]}{tail}.{FACING[1]}")
    return Layer(colour, depth, mattes, seen, None, lines, rays, facing)


def mean_depth(made, layer, place):
    """What rackfocus.Filter.process() takes of a Layer as mean_depth."""
    if layer.rays is None:
        return None
    mean = np.empty(layer.depth.shape, np.float32)
    at = place.offset, place.shear_distance
    return mean if made.mean_depth(layer.rays, layer.depth, mean, *at) else None


# ---- getting them out of Blender --------------------------------------------------


def memory_folder(n_bytes):
    """A folder in memory with room for n_bytes, else Blender's own temporary one."""
    if os.path.isdir(SHARED_MEMORY) and os.access(SHARED_MEMORY, os.W_OK):
        if shutil.disk_usage(SHARED_MEMORY).free > 2 * n_bytes:
            return SHARED_MEMORY
    return bpy.app.tempdir


def _lock(file):
    """Locks an open file for as long as it is open; OSError where another one does."""
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    else:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)


def _locked_folder(parent):
    """(a new folder, what holds it): the open file in it is locked, and both go after.

    Another Blender may take the folder for that of a dead one before the file is locked,
    and remove it: then there is another one.
    """
    for _ in range(TRIES):
        folder = Path(tempfile.mkdtemp(prefix=f"{FOLDER}{os.getpid()}_", dir=parent))
        with contextlib.ExitStack() as held:  # Windows removes no file that is open
            held.callback(shutil.rmtree, folder, ignore_errors=True)
            lock = held.enter_context(open(folder / LOCK, "w"))
            with contextlib.suppress(OSError):
                _lock(lock)
                if (folder / LOCK).exists():
                    return folder, held.pop_all()
    raise OSError(f"{parent}: no file can be locked there")


@contextlib.contextmanager
def own_folder(parent):
    """A folder for a while. Its locked file tells that its Blender is alive."""
    folder, held = _locked_folder(parent)
    with held:
        yield folder


def _parents(n_bytes):
    """Where folders for files of passes may be, the best first."""
    found = [memory_folder(n_bytes), bpy.app.tempdir]
    has_memory = os.path.isdir(SHARED_MEMORY) and os.access(SHARED_MEMORY, os.W_OK)
    return list(dict.fromkeys([*found, *([SHARED_MEMORY] if has_memory else ())]))


def _has_room(parent, n_bytes):
    """Are so many bytes free there? A folder that is gone has none."""
    with contextlib.suppress(OSError):
        return shutil.disk_usage(parent).free >= n_bytes
    return False


@contextlib.contextmanager
def filled_folder(n_bytes, fill):
    """What fill(folder) returns, which writes files there and reads them, for a while.

    n_bytes: of the files, about. Blender writes half of a file where there is no room for
    the whole, without a word: where fill() fails and less than that is free, it is called
    with a folder at another place. RoomError.
    """
    tried = []
    for parent in _parents(n_bytes):
        with contextlib.ExitStack() as held:
            try:
                folder = held.enter_context(own_folder(parent))
                found = fill(folder)
            except Exception:
                if _has_room(parent, n_bytes):
                    raise
                tried.append(parent)
                continue
            yield found
            return
    places = " and ".join(f"“{parent}”" for parent in tried)
    raise RoomError(
        f"there is no room for the passes of the render in {places}: make room, or name "
        "another folder in Preferences > File Paths > Temporary Files"
    )


def _remove_if_dead(folder):
    """Removes a folder whose Blender has ended; not where that cannot be told."""
    try:
        if hasattr(os, "getuid") and folder.stat().st_uid != os.getuid():
            return
        with open(folder / LOCK) as lock:
            _lock(lock)
            # With the lock: who is just making the folder sees that it is gone.
            shutil.rmtree(folder, ignore_errors=True)
    except FileNotFoundError:  # just being made, or of a version without locks
        if time.time() - folder.stat().st_mtime < WITHOUT_LOCK_S:
            return
    except OSError:
        return
    shutil.rmtree(folder, ignore_errors=True)


def clear_dead_folders(parent=SHARED_MEMORY):
    """Removes what Blenders that were killed left in the memory file system."""
    for folder in Path(parent).glob(f"{FOLDER}*"):
        with contextlib.suppress(FileNotFoundError):
            if folder.is_dir() and not folder.is_symlink():
                _remove_if_dead(folder)


class RenderedPasses:
    """The passes of a scene's render."""

    def __init__(self, scene, n_views=1):
        # Of what was rendered before a layer got another name.
        self.old_names = _old_names_of(scene.rack_focus.viewed or scene)
        # A mapped file stays readable without its name.
        with self._filled(scene, n_views) as found:
            self.files = {
                suffix: channels for suffix, (_, channels, _) in found.items()
            }
            self.about = {
                suffix: parts[0].about for suffix, (*_, parts) in found.items()
            }

    @classmethod
    @contextlib.contextmanager
    def saved(cls, scene, n_views=1):
        """{suffix of the view's file, "" without views: its path} for a while."""
        with cls._filled(scene, n_views) as found:
            yield {suffix: path for suffix, (path, *_) in found.items()}

    @classmethod
    def _filled(cls, scene, n_views):
        """{suffix: (path, *exr.read_parts())} for a while."""
        width, height = picture_size(scene.render)

        def fill(folder):
            path = folder / "passes.exr"
            cls._save(scene, path)
            return {
                file.stem[len(path.stem) :]: (file, *exr.read_parts(file))
                for file in folder.glob("*.exr")
            }

        return filled_folder(width * height * 4 * 32 * n_views, fill)

    @classmethod
    def _save(cls, scene, path):
        result = slots.render_result()
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
                with quiet, slots.last_shown():
                    result.save_render(str(path), scene=scene)
            except RuntimeError as error:
                # Blender reports a failure for views that it wrote all the same.
                if not list(path.parent.glob("*.exr")):
                    raise PassesError(
                        "there is no render to filter yet: press F12 first"
                    ) from error

    def layer(self, name, suffix="", view=""):
        """The Layer of a view layer; suffix, view: of a view in stereo, else ""."""
        channels = self.files.get(suffix, self.files.get(""))
        if channels is None:
            raise PassesError(f"the view “{view}” was not rendered: press F12")
        for one, tail in self._asked(name, view):
            with contextlib.suppress(PassesError):
                return find_layer(channels, one, tail)
        return find_layer(channels, name, view)

    def guides(self, name, suffix="", view=""):
        """What guides a denoiser of a view layer; see guides_of()."""
        channels = self.files.get(suffix, self.files.get("", {}))
        found = [
            guides_of(channels, one, tail and f".{tail}")
            for one, tail in self._asked(name, view)
        ]
        return max(found, key=len)

    def drop_guides(self):
        """Lets go of the passes of GUIDES, and of the mapped files that have them.

        FACING stays where rays without an end do not tell what they hit (veils.py).
        """
        parts = tuple(f".{part}." for part, _ in GUIDES.values())
        for suffix, channels in self.files.items():
            dropped = [n for n in channels if any(p in n for p in parts)]
            if _has_endless_rays(channels):
                dropped = [n for n in dropped if not _is_facing(n)]
            kept = [n for n in channels if n not in dropped]
            if len(kept) < len(channels):
                planes = np.stack([channels[name] for name in kept])
                self.files[suffix] = dict(zip(kept, planes, strict=True))

    def _asked(self, name, view):
        """The pairs of a layer's name and a view, by which channels may be found."""
        layers = dict.fromkeys((name, self.old_names.get(name, name)))
        return [(one, tail) for one in layers for tail in dict.fromkeys(("", view))]

    def need(self, name, suffix="", view=""):
        """PassesError where a view layer is missing."""
        self.layer(name, suffix, view)

    def size(self):
        """(width, height) in px."""
        return _size_of(next(iter(self.files.values())))

    def views(self, name, suffix="", view=""):
        """[(Layer, Place)] as of one view from the middle of the lens."""
        return [(self.layer(name, suffix, view), MIDDLE)]


def _has_endless_rays(channels):
    """Are there means of rays some of which hit nothing? Cycles of 5.2 has no other."""
    rays = [plane for name, plane in channels.items() if f".{RAYS}." in name]
    return any(plane.max() >= NOTHING_HIT for plane in rays)


def _is_facing(name):
    """Is that the channel of FACING, of any view?"""
    part, axis = FACING
    return f".{part}." in name and name.endswith(f".{axis}")


def _size_of(channels):
    height, width = next(iter(channels.values())).shape
    return width, height


_kept = names.store()  # RenderedPasses, view_passes.ViewPasses or keep.KeptFiles
_frames = names.store()  # frame of the last render, or of what is kept
_old_names = names.store()  # {name of a view layer: its name in the last render}


def _old_names_of(scene):
    return _old_names.setdefault(scene.name, {})


def rename_layers(scene, new_names):
    """Finds view layers by their new names, too; new_names: {old: new}."""
    known = _old_names_of(scene)
    then = {new: known.get(old, old) for old, new in new_names.items()}
    known.update(then)


def look_for(scene, layer, new_name):
    """Finds a view layer, too, by the name that it got while it was rendered."""
    _old_names_of(scene)[layer] = new_name


def old_name(scene, layer):
    """The name that a view layer had in the last render of its scene."""
    return _old_names_of(scene).get(layer, layer)


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
    for kept in (_kept, _frames, _old_names):
        kept.clear() if scene is None else kept.pop(scene.name, None)


def set_frame(scene, frame):
    """Notes which frame of a scene was rendered, or is kept."""
    _frames[scene.name] = frame


def frame_of(scene):
    """The frame that the passes of a scene are of; None where that is not known."""
    return _frames.get(scene.name)
