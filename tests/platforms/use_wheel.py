# SPDX-License-Identifier: Apache-2.0
"""Filters a picture with the package that is installed; prints level and hash.

    use_wheel.py [FOLDER...]    FOLDERs are looked into first
"""

import hashlib
import sys

sys.path[:0] = sys.argv[1:]
import numpy  # noqa: E402
import rackfocus  # noqa: E402

values = numpy.arange(48 * 64 * 3, dtype=numpy.uint32) * numpy.uint32(2654435761)
colour = (values % numpy.uint32(1009)).astype(numpy.float32).reshape(48, 64, 3)
depth = numpy.tile(numpy.linspace(2, 20, 64, dtype=numpy.float32), (48, 1))
picture = rackfocus.apply(colour, depth, focus_distance=5, f_stop=1.4, focal_length=50)
assert not numpy.array_equal(picture, colour), "nothing was blurred"
digest = hashlib.sha256(numpy.ascontiguousarray(picture).tobytes()).hexdigest()
print(rackfocus.cpu_level(), digest)
