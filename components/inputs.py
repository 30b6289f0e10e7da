"""Inputs of components: numbers, arrays and profiles of time, which apply during a step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import Location, ParameterError, location_text
from .number_arrays import number_array
from .profiles import CompiledProfile, Profile
from .support.validation import finite_number
from .variables import Variable

# A number for a scalar input, a read-only array of its shape for an array input, or a profile of the input's shape.
Held = float | npt.NDArray[np.float64] | CompiledProfile


def hold_input(variable: Variable, value: Any, step_size: float) -> Held:
    """Check a given value of an input, and return it in the form that the component stores.

    Args:
        variable: the input.
        value: a number (for an array input: for all elements), an array of the input's shape, or a profile. Profiles are not
            checked against the bounds of the input.
        step_size: internal step of the component [s].

    Raises:
        ParameterError: it is none of these, it is out of bounds, or it is a profile with another step size or shape.
    """
    at, shape, unit = ("input", variable.name), variable.shape, variable.unit
    minimum, maximum = variable.minimum, variable.maximum
    if isinstance(value, (Profile, CompiledProfile)):
        return _hold_profile(at, value, shape, step_size)
    if shape == () or not (isinstance(value, (list, tuple)) or getattr(value, "ndim", 0)):
        number = _input_number(at, value, shape)
        if not minimum <= number <= maximum:
            raise ParameterError(f"got {number:g} {unit}", expected=f"{minimum:g} to {maximum:g}", at=at)
        return number if shape == () else make_read_only(np.full(shape, number))
    array = number_array(at, value, f"a number, an array of shape {shape} or a Profile", (shape,))
    outside = ~((minimum <= array) & (array <= maximum))
    if outside.any():
        where = tuple(int(index) for index in np.argwhere(outside)[0])
        raise ParameterError(f"got {array[where]:g} {unit}", expected=f"{minimum:g} to {maximum:g}", at=(*at, *where))
    return make_read_only(array)


def make_read_only(array: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Make an array read-only, and return it."""
    array.setflags(write=False)
    return array


def input_value(held_input: Held, tick: int) -> Any:
    """Return the value of an input at a tick: a number, or an array."""
    return held_input.value(tick) if isinstance(held_input, CompiledProfile) else held_input


def input_mean(held_input: Held, tick: int, part: int = 0, parts: int = 1) -> Any:
    """Return the mean of an input over a tick, or over one of its equal parts: a number, or an array."""
    return held_input.mean(tick, part, parts) if isinstance(held_input, CompiledProfile) else held_input


def _hold_profile(at: Location, value: Profile | CompiledProfile, shape: tuple[int, ...], step_size: float) -> CompiledProfile:
    if isinstance(value, Profile):
        value = value.compile(step_size, location_text(at))
    elif value.step_size != step_size:
        raise ParameterError(
            f"got a profile compiled for steps of {value.step_size:g} s", expected=f"one for steps of {step_size:g} s", at=at
        )
    try:
        return value.broadcast(shape)
    except ParameterError as error:
        raise error.with_outer_location(*at) from None


def _input_number(at: Location, value: Any, shape: tuple[int, ...]) -> float:
    if type(value) is float and math.isfinite(value):
        return value
    expected = "a number or a Profile" if shape == () else f"a number, an array of shape {shape} or a Profile"
    hint = "sample a function with Profile.table(times, values)" if callable(value) else ""
    return finite_number(at, value, expected, hint)
