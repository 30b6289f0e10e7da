"""Checks of the formulas' arguments: numbers or arrays of numbers, inside the range in which the formula holds."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np

from ...errors import ParameterError, one_line
from ...support.float_arrays import FloatArray

# A number or an array of numbers; what a formula is given decides what it returns, and arrays broadcast.
Number: TypeAlias = Any


def above(name: str, value: Number, bound: float, unit: str = "") -> Number:
    """Return a number or array of finite numbers > `bound`, as floats."""
    return _inside(name, value, np.nextafter(bound, math.inf), math.inf, f"more than {bound:.6g} {unit}".rstrip())


def at_least(name: str, value: Number, bound: float, unit: str = "") -> Number:
    """Return a number or array of finite numbers >= `bound`, as floats."""
    return _inside(name, value, bound, math.inf, f"at least {bound:.6g} {unit}".rstrip())


def between(name: str, value: Number, low: float, high: float, *, closed_below: bool = False, advice: str = "") -> Number:
    """Return a number or array of numbers in (low, high), or in [low, high), as floats."""
    expected = f"{'at least' if closed_below else 'more than'} {low:.6g} and less than {high:.6g}"
    least = low if closed_below else np.nextafter(low, high)
    return _inside(name, value, least, high, expected + (f"; {advice}" if advice else ""))


def finite(name: str, value: Number) -> Number:
    """Return a number or array of finite numbers, as floats."""
    return _inside(name, value, -np.finfo(np.float64).max, math.inf, "finite numbers")


def sequence(name: str, value: Any, least: int) -> FloatArray:
    """Return a row of at least so many finite numbers, shape (n,)."""
    array = finite(name, value)
    if np.ndim(array) != 1 or np.size(array) < least:
        raise ParameterError(f"got shape {np.shape(array)}", expected=f"a row of at least {least} numbers", at=name)
    return np.asarray(array)


def number(name: str, value: Any) -> float:
    """Return one number, where a formula takes no array."""
    if np.ndim(value):
        raise ParameterError(
            f"got an array of shape {np.shape(value)}", expected="one number", hint="call it for each", at=name
        )
    return float(finite(name, value))


def _inside(name: str, value: Any, least: float, bound: float, expected: str) -> Any:
    """Return numbers in [least, bound), as floats."""
    try:
        array = np.asarray(value)
    except ValueError:  # rows of unlike length
        array = np.asarray(None)
    if array.dtype.kind not in "fiu":
        raise ParameterError(f"got {one_line(value)}", expected=f"a number or an array of numbers, {expected}", at=name)
    array = array.astype(np.float64)
    right = (array >= least) & (array < bound)
    if not right.all():
        raise ParameterError(f"got {array[~right].flat[0]:g}", expected=expected, at=name)
    return array if array.ndim else float(array)
