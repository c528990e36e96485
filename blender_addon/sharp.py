# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that stay sharp, whatever their distance: a property of the object.

Cryptomatte says how much of each pixel an object covers, with the edges of the render.
The scene's view layers get that pass when a render begins, for as long as an object of
the scene wants it. The CoC is multiplied by what the objects leave of the pixel.

    id of a name   MurmurHash3 of its bytes, with an exponent that makes it a number
    coverage       sum of the coverages whose id is one of those (ranks 00 to 02, two in
                   each)

Cryptomatte specification 1.2.0, Friedman and Jones 2015.
"""

import numpy as np

from . import sets
from .borrowed import Switch

NAME = "CryptoObject"
SWITCH = Switch("mattes", lambda layer: layer, "use_pass_cryptomatte_object")


def _rotated(value, bits):
    return (value << bits | value >> (32 - bits)) & 0xFFFFFFFF


def _mixed(block):
    return _rotated(block * 0xCC9E2D51 & 0xFFFFFFFF, 15) * 0x1B873593 & 0xFFFFFFFF


def murmur3(data):
    """MurmurHash3_x86_32 of bytes, with the seed 0."""
    found, whole = 0, len(data) & ~3
    for at in range(0, whole, 4):
        found ^= _mixed(int.from_bytes(data[at : at + 4], "little"))
        found = (_rotated(found, 13) * 5 + 0xE6546B64) & 0xFFFFFFFF
    if len(data) > whole:
        found ^= _mixed(int.from_bytes(data[whole:], "little"))
    found ^= len(data)
    for factor, bits in ((0x85EBCA6B, 16), (0xC2B2AE35, 13), (1, 16)):
        found = (found ^ found >> bits) * factor & 0xFFFFFFFF
    return found


def id_of(name):
    """Bits of the number that stands for an object in the pass."""
    found = murmur3(name.encode())
    exponent = min(max(found >> 23 & 0xFF, 1), 254)
    return found & 0x807FFFFF | exponent << 23


def names_of(scene):
    """Names of the objects of a scene that stay sharp.

    The renderer names instances by their object: one that shows a collection keeps the
    objects of that sharp, wherever they are shown.
    """
    found, seen = {}, set()
    _add_names(sets.objects_of(scene), False, found, seen)
    return list(found)


def _add_names(objects, is_whole, found, seen):
    """Adds names to `found`, {name: True}; is_whole: of all the objects."""
    for item in objects:
        is_kept = is_whole or item.rack_focus_keep_sharp
        is_instancer = item.instance_type == "COLLECTION"
        shown = item.instance_collection if is_instancer else None
        if is_kept:
            found[item.name] = True
        if shown is not None and (shown, is_kept) not in seen:
            seen.add((shown, is_kept))
            _add_names(shown.all_objects, is_kept, found, seen)


# ---- the pass ---------------------------------------------------------------------


def need_pass(scene):
    """Switches the pass on where it is wanted, and off where only we wanted it."""
    SWITCH.need(scene, bool(names_of(scene)))


# ---- the mattes -------------------------------------------------------------------


def mattes_of(channels, layer, tail=""):
    """((ids, coverage), ...) of a view layer among the channels of exr.read_exr().

    tail: what follows the pass in the names, ".view" in stereo.
    """
    by_name = {name.lower(): plane for name, plane in channels.items()}
    found = []
    for rank in range(3):
        stem = f"{layer}.{NAME}{rank:02d}{tail}.".lower()
        for ids, coverage in ("rg", "ba"):
            if stem + ids in by_name and stem + coverage in by_name:
                found.append((by_name[stem + ids], by_name[stem + coverage]))
    return tuple(found)


def coverage(mattes, names):
    """(height, width) of how much of each pixel objects cover, 0 to 1; or None.

    mattes: of mattes_of(); one whose ids are None counts as it is.
    """
    if not mattes or not names:
        return None
    wanted = np.array([id_of(name) for name in names], np.uint32)
    found = np.zeros(mattes[0][1].shape, np.float32)
    for ids, part in mattes:
        if ids is None:
            found += part
        else:
            bits = np.ascontiguousarray(ids, np.float32).view(np.uint32)
            found += np.where(np.isin(bits, wanted), part, 0)
    return np.minimum(found, 1)
