"""Inputs: numbers, arrays and profiles of time that are held over a step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import ParameterError, shortened
from .profiles import CompiledProfile, Profile
from .support.validation import finite_number

# A number for an input of shape (); for another one a read-only array of its shape. Or a profile of the input's shape.
Held = float | npt.NDArray[np.float64] | CompiledProfile


def hold_input(
    name: str, value: Any, *, shape: tuple[int, ...], unit: str, minimum: float, maximum: float, step_size: float
) -> Held:
    """Return what a component holds of the value that is given for one of its inputs.

    Args:
        name: of the input, for messages.
        value: a number (for an array input: for all elements), an array of the input's shape, or a profile.
        shape: of the input.
        unit: of the input.
        minimum: the least value that is allowed; profiles are not checked against it.
        maximum: the largest value that is allowed.
        step_size: of the component [s].

    Raises:
        ParameterError: it is neither, it is out of bounds, or a profile of another step size or shape.
    """
    if isinstance(value, (Profile, CompiledProfile)):
        return _hold_profile(name, value, shape, step_size)
    if shape == () or not (isinstance(value, (list, tuple)) or getattr(value, "ndim", 0)):
        number = _number(name, value, shape)
        if not minimum <= number <= maximum:
            raise ParameterError(f"input {name!r}: got {number:g} {unit}, expected {minimum:g} to {maximum:g}")
        return number if shape == () else read_only(np.full(shape, number))
    array = _array(name, value, shape)
    outside = ~((minimum <= array) & (array <= maximum) & np.isfinite(array))
    if outside.any():
        where = tuple(int(index) for index in np.argwhere(outside)[0])
        expected = f"{minimum:g} to {maximum:g}" if np.isfinite(array[where]) else "a finite number"
        raise ParameterError(f"input {name!r}{list(where)}: got {array[where]:g} {unit}, expected {expected}")
    return array


def read_only(array: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the array, closed to writing."""
    array.setflags(write=False)
    return array


def input_value(held: Held, tick: int) -> Any:
    """Return the value of an input at a tick: a number, or an array."""
    return held.value(tick) if isinstance(held, CompiledProfile) else held


def _hold_profile(name: str, value: Profile | CompiledProfile, shape: tuple[int, ...], step_size: float) -> CompiledProfile:
    if isinstance(value, Profile):
        value = value.compile(step_size, name)
    elif value.step_size != step_size:
        raise ParameterError(f"input {name!r} was compiled for steps of {value.step_size:g} s, not of {step_size:g} s")
    try:
        return value.spread(shape)
    except ParameterError as error:
        raise ParameterError(f"input {name!r}: {error}") from None


def _number(name: str, value: Any, shape: tuple[int, ...]) -> float:
    if type(value) is float and math.isfinite(value):
        return value
    hint = "; sample a function with Profile.table(times, values)" if callable(value) else ""
    expected = "a number or a Profile" if shape == () else f"a number, an array of shape {shape} or a Profile"
    return finite_number(f"input {name!r}", value, expected + hint)


def _array(name: str, value: Any, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """Return a read-only copy in the input's shape."""
    try:
        given = np.asarray(value)
    except ValueError as error:  # rows of unlike length
        raise ParameterError(f"input {name!r}: got {shortened(value)}, expected an array of shape {shape}") from error
    if given.dtype.kind not in "fiu":
        raise ParameterError(
            f"input {name!r}: got {shortened(value)}, expected a number, an array of shape {shape} or a Profile"
        )
    if given.shape != shape:
        raise ParameterError(f"input {name!r}: got an array of shape {given.shape}, expected a number or shape {shape}")
    return read_only(np.array(given, dtype=np.float64, order="C"))
