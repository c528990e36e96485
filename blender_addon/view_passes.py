# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes of a frame that was rendered in several views."""

import numpy as np

from . import passes, supersample


class ViewPasses:
    """The kept passes of all views of a frame; view 0 stands for the frame."""

    def __init__(self, files, places, is_look_at, scale, is_noisy=False):
        # per view and part of its pixels: (passes.RenderedPasses, suffix, view)
        self.files = files
        self.places = places
        self.is_look_at = is_look_at
        self.scale = scale
        self.is_noisy = is_noisy  # are they to be denoised, by denoising.clean()?
        self._clean = {}  # name of a view layer: colours of its views without grain

    def is_clean(self, name):
        """Need the views of a view layer no denoiser any more?"""
        return not self.is_noisy or name in self._clean

    def put_clean(self, name, colours):
        """Takes colours without grain, which stand beside those of the views."""
        self._clean[name] = colours

    def guides(self, name, index):
        """What guides a denoiser of a view; see passes.guides_of()."""
        n = self.scale**2
        parts = [
            rendered.guides(name, suffix, view)
            for rendered, suffix, view in self.files[n * index : n * (index + 1)]
        ]
        if n == 1:
            return parts[0]
        return {
            guide: self._together([part[guide] for part in parts]) for guide in parts[0]
        }

    def _rendered(self, name, index):
        """The passes.Layer of a view, put together of its parts."""
        n = self.scale**2
        parts = [
            rendered.layer(name, suffix, view)
            for rendered, suffix, view in self.files[n * index : n * (index + 1)]
        ]
        if n == 1 or any(part.depth is None for part in parts):
            return parts[0]
        planes = (part[:3] for part in parts)  # no mirrors: see mirrors.why_not()
        layer = passes.Layer(*map(self._together, zip(*planes, strict=True)))
        for field in ("rays", "facing"):
            planes = [getattr(part, field) for part in parts]
            if all(plane is not None for plane in planes):
                layer = layer._replace(**{field: self._together(planes)})
        return layer

    def _together(self, parts):
        """One plane, or tuple of planes, of the same of all parts."""
        if isinstance(parts[0], tuple):
            return tuple(map(self._together, zip(*parts, strict=True)))
        return supersample.together(parts, self.scale)

    def _layer(self, name, index):
        found, place = self._rendered(name, index), self.places[index]
        if name in self._clean:
            clean = self._clean[name][index]
            found = found._replace(colour=clean, grainy=found.colour)
        if found.depth is not None and place.depth_factor != 1:
            is_hit = found.depth < passes.NOTHING_HIT
            depth = np.where(is_hit, found.depth * place.depth_factor, found.depth)
            found = found._replace(depth=depth.astype(np.float32))
            if found.rays is not None:
                rays = (found.rays * place.depth_factor).astype(np.float32)
                found = found._replace(rays=rays)
            if found.seen is not None:
                way = (found.seen.way * place.depth_factor).astype(np.float32)
                found = found._replace(seen=found.seen._replace(way=way))
        return found

    def need(self, name, *_):
        """PassesError where a view layer is missing."""
        rendered, suffix, view = self.files[0]
        rendered.need(name, suffix, view)

    def size(self):
        """(width, height) in px."""
        width, height = self.files[0][0].size()
        return width * self.scale, height * self.scale

    def layer(self, name, *_):
        """The passes.Layer of the first view, which is nearest to the middle."""
        return self._layer(name, 0)

    def views(self, name, *_):
        """[(passes.Layer, passes.Place)] of a view layer."""
        return [(self._layer(name, i), place) for i, place in enumerate(self.places)]
