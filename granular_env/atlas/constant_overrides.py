"""Overrides of a paper's constants (`atlas --set N=50`), checked, and the paper's own values of the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from granular_env.components.errors import ParameterError, nearest, one_line

from .model import Constant, Paper


def constant_values(paper: Paper, changed: Mapping[str, Any]) -> dict[str, float]:
    """Every constant's value; `ParameterError` for a name that the paper does not have, or a value out of its range."""
    values = {name: constant.value for name, constant in paper.constants.items()}
    for name, value in changed.items():
        if name not in values:
            raise ParameterError(f"{paper.name} has none of that name", hint=nearest(name, values), at=("constants", name))
        values[name] = _validate(name, value, paper.constants[name])
    return values


def _validate(name: str, value: Any, constant: Constant) -> float:
    expected = (
        f"a {'whole ' if constant.whole else ''}number from {constant.low:g} to {constant.high:g} {constant.unit}".rstrip()
    )
    hint = f"it is {constant.description}"
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or not constant.low <= value <= constant.high:
        raise ParameterError(f"got {one_line(value)}", expected=expected, hint=hint, at=("constants", name))
    if constant.whole and value != int(value):
        raise ParameterError(f"got {value:g}", expected=expected, hint=hint, at=("constants", name))
    return int(value) if constant.whole else float(value)
