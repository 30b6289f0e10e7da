"""Inputs: numbers, arrays and profiles of time that are held over a step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import Location, ParameterError, location_text
from .number_arrays import number_array
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
    at = ("input", name)
    if isinstance(value, (Profile, CompiledProfile)):
        return _hold_profile(at, value, shape, step_size)
    if shape == () or not (isinstance(value, (list, tuple)) or getattr(value, "ndim", 0)):
        number = _number(at, value, shape)
        if not minimum <= number <= maximum:
            raise ParameterError(f"got {number:g} {unit}", expected=f"{minimum:g} to {maximum:g}", at=at)
        return number if shape == () else read_only(np.full(shape, number))
    array = number_array(at, value, f"a number, an array of shape {shape} or a Profile", (shape,))
    bounded = minimum > -math.inf or maximum < math.inf
    if bounded and (outside := ~((minimum <= array) & (array <= maximum))).any():
        where = tuple(int(index) for index in np.argwhere(outside)[0])
        raise ParameterError(f"got {array[where]:g} {unit}", expected=f"{minimum:g} to {maximum:g}", at=(*at, *where))
    return read_only(array)


def read_only(array: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the array, closed to writing."""
    array.setflags(write=False)
    return array


def input_value(held: Held, tick: int) -> Any:
    """Return the value of an input at a tick: a number, or an array."""
    return held.value(tick) if isinstance(held, CompiledProfile) else held


def input_mean(held: Held, tick: int, part: int = 0, parts: int = 1) -> Any:
    """Return the mean of an input over a tick, or over one of its equal parts: a number, or an array."""
    return held.mean(tick, part, parts) if isinstance(held, CompiledProfile) else held


def _hold_profile(at: Location, value: Profile | CompiledProfile, shape: tuple[int, ...], step_size: float) -> CompiledProfile:
    if isinstance(value, Profile):
        value = value.compile(step_size, location_text(at))
    elif value.step_size != step_size:
        raise ParameterError(
            f"got a profile compiled for steps of {value.step_size:g} s", expected=f"one for steps of {step_size:g} s", at=at
        )
    try:
        return value.spread(shape)
    except ParameterError as error:
        raise error.within(*at) from None


def _number(at: Location, value: Any, shape: tuple[int, ...]) -> float:
    if type(value) is float and math.isfinite(value):
        return value
    expected = "a number or a Profile" if shape == () else f"a number, an array of shape {shape} or a Profile"
    hint = "sample a function with Profile.table(times, values)" if callable(value) else ""
    return finite_number(at, value, expected, hint)
