#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints rackfocus/_params.py: the keywords of the parameters for type checkers, out of
the core's table, so that a misspelt one is an error before the program runs.

    PYTHONPATH=... plugin/make_types.py > plugin/rackfocus/_params.py
"""

import sys

sys.path.pop(0)  # the sources beside this file have no extension
import rackfocus  # noqa: E402

HEAD = '''\
# SPDX-License-Identifier: Apache-2.0
# Made by plugin/make_types.py of core/include/rackfocus/params.def; not by hand.
"""The keywords of the parameters, for type checkers."""

from typing import Any, Literal, TypedDict


class Parameters(TypedDict, total=False):
'''
TAIL = """

class FilterParameters(Parameters, total=False):
    distribution_image: Any
"""


def type_of(parameter):
    if not parameter.choices:
        return {"float": "float", "int": "int", "bool": "bool"}[parameter.type]
    names = [f'"{choice.name}"' for choice in parameter.choices]
    line = f"Literal[{', '.join(names)}]"
    if len(line) + len(parameter.field) + 6 <= 88:
        return line
    return "Literal[\n        " + ",\n        ".join(names) + ",\n    ]"


def text():
    rows = [f"    {p.field}: {type_of(p)}\n" for p in rackfocus.parameters()]
    return HEAD + "".join(rows) + TAIL


if __name__ == "__main__":
    print(text(), end="")
