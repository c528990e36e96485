# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators that wait for a click have in common."""


def main_region(area):
    """The region of an area that is neither header nor sidebar."""
    return next(region for region in area.regions if region.type == "WINDOW")


class WaitsForClick:
    """An operator with properties x and y that a click sets before it executes.

    place(region, x, y) turns px of the region into the values of the properties.
    """

    def wait(self, context):
        """Starts to wait; what invoke() returns."""
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set("Click what should be sharp; Esc to cancel")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Left click picks, Esc and right click cancel; the view can be moved."""
        if event.type in ("ESC", "RIGHTMOUSE"):
            self._end(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        region = main_region(context.area)
        self.x, self.y = self.place(
            region, event.mouse_x - region.x, event.mouse_y - region.y
        )
        self._end(context)
        return self.execute(context)

    @staticmethod
    def _end(context):
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
