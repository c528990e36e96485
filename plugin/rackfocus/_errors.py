# SPDX-License-Identifier: Apache-2.0
"""Errors with their field, as the extension raises them."""

from ._core import ParameterError


def parameter_error(field, message):
    """A ParameterError that names the argument at fault."""
    error = ParameterError(f"{field}: {message}")
    error.field, error.message = field, message
    return error
