# SPDX-License-Identifier: GPL-3.0-or-later
"""A switch of view layers that we have on while we need it, and give back.

Which layers got it stands in the scene's record, so that a file that was saved meanwhile
gives it back too.
"""

import json
from collections.abc import Callable
from typing import NamedTuple


class Switch(NamedTuple):
    """What is switched, and where that is noted."""

    key: str  # in the scene's record: names of the layers
    owner_of: Callable  # what of a view layer has the switch
    name: str

    def need(self, scene, is_wanted):
        """Switches it on where it is wanted, and off where only we wanted it."""
        record = json.loads(scene.rack_focus.record or "{}")
        if not record:
            return
        before = record.get(self.key, [])
        ours = []
        if is_wanted:
            missing = [la for la in scene.view_layers if not self._is_on(la)]
            self._set(missing, True)
            ours = [*before, *(layer.name for layer in missing)]
        elif before:
            self.drop(scene, record)
        if ours != before:
            record[self.key] = ours
            scene.rack_focus.record = json.dumps(record)

    def drop(self, scene, record):
        """Switches it off where need() switched it on; record: the scene's."""
        names = record.get(self.key, [])
        self._set([la for la in scene.view_layers if la.name in names], False)

    def _is_on(self, layer):
        return getattr(self.owner_of(layer), self.name)

    def _set(self, layers, is_on):
        for layer in layers:
            setattr(self.owner_of(layer), self.name, is_on)
