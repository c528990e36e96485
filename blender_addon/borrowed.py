# SPDX-License-Identifier: GPL-3.0-or-later
"""A switch of view layers that we set while we need it, and give back.

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
    value: bool = True  # what we set it to

    def need(self, scene, is_wanted):
        """Sets it where that is wanted, and gives it back where only we wanted it."""
        record = json.loads(scene.rack_focus.record or "{}")
        if not record:
            return
        before = record.get(self.key, [])
        ours = []
        if is_wanted:
            missing = [la for la in scene.view_layers if not self._is_set(la)]
            self._write(missing, self.value)
            ours = [*before, *(layer.name for layer in missing)]
        elif before:
            self.drop(scene, record)
        if ours != before:
            record[self.key] = ours
            scene.rack_focus.record = json.dumps(record)

    def drop(self, scene, record):
        """Gives it back where need() has set it; record: the scene's."""
        names = record.get(self.key, [])
        self._write(
            [la for la in scene.view_layers if la.name in names], not self.value
        )

    def _is_set(self, layer):
        return getattr(self.owner_of(layer), self.name) == self.value

    def _write(self, layers, value):
        for layer in layers:
            owner = self.owner_of(layer)
            if owner is not None:  # Cycles is an add-on too, and may be off
                setattr(owner, self.name, value)
                layer.update_render_passes()  # Cycles does for the active one alone
