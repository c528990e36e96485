# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the views of a render are rendered one after another, each by a copy of its
own, and not together by native multi-view."""

from . import compat, culling, setup

multiview_works = True  # until a render shows that it does not


def is_so(settings, scene):
    """Are the views of a camera's settings rendered one after another?"""
    is_matte_wrong = compat.MATTES_ADD_VIEWS and setup.has_mattes(scene)
    is_wrong = is_matte_wrong or culling.is_on(scene)
    return not multiview_works or is_wrong or is_spread(settings)


def is_spread(settings):
    """Do the views differ in time?"""
    return settings.method == "accumulate" and settings.shutter_spread
