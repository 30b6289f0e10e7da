"""Outputs with the functions that read them, so that an output is declared where it is computed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ..variables import Variable


class Output(NamedTuple):
    """The declaration of an output, and the function that returns its value."""

    variable: Variable
    read: Callable[[], Any]


def make_output(
    name: str, unit: str, shape: tuple[int, ...], text: str, read: Callable[[], Any], *axes: str, **fields: Any
) -> Output:
    """Return an output whose indices count `axes`; `fields` are further fields of its `Variable`."""
    return Output(Variable(name, "output", unit, shape, text, axes=axes, **fields), read)
