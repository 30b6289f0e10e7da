"""Arguments of the tasks' factories: numbers, lists and ranges of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ParameterError, one_line


def without_none(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters that are not None; for the others the chain's own defaults hold, or what its arrangement says."""
    return {name: value for name, value in parameters.items() if value is not None}


def numbers(name: str, given: Any) -> npt.NDArray[np.float64]:
    """Return a number, or several, as an array.

    Raises:
        ParameterError: it is neither, there is none, or one is not finite.
    """
    values = list(given) if isinstance(given, (Sequence, np.ndarray)) and not isinstance(given, str) else [given]
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)):
        raise ParameterError(f"got {one_line(given)}", expected="a number or a list of numbers", at=name)
    return array


def between(name: str, given: Any) -> tuple[float, float]:
    """Return a range (low, high), 0 < low <= high.

    Raises:
        ParameterError: it is none.
    """
    pair = numbers(name, given)
    if len(pair) != 2 or not 0.0 < pair[0] <= pair[1]:
        raise ParameterError(f"got {one_line(given)}", expected="(low, high) with 0 < low <= high", at=name)
    return float(pair[0]), float(pair[1])
