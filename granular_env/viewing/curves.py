"""Curves over time: scalars, thinned without losing peaks, and inputs, as curves of their non-zero elements or extremes.

An array input with a profile is a time factor times one array, so its curves need little memory whatever its size.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from operator import itemgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.inputs import Held
from granular_env.components.profiles import CompiledProfile
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Element, Variable
from granular_env.recording.steps import InputInterval, acting_intervals

from .places import element_label, variable_positions, vector_names

MAXIMUM_CURVE_POINTS = 4_000
# Largest number of curves in one figure; more would be unreadable.
MOST_CURVES = 6
# An array counts as an array of vectors if its elements have at most this many components.
MOST_COMPONENTS = 3


@dataclass(frozen=True)
class Curve:
    """The values of a scalar over time.

    Attributes:
        times: shape (samples,) [s].
        ticks: shape (samples,).
        values: shape (samples,), in `unit`.
        cuts: indices of the first samples of later segments, where the line is interrupted.
        label: the name for legends; "" for `name`.
    """

    name: str
    unit: str
    description: str
    times: FloatArray
    ticks: npt.NDArray[np.int64]
    values: FloatArray
    cuts: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    label: str = ""


def pick_with_extremes(values: FloatArray, max_count: int = MAXIMUM_CURVE_POINTS) -> npt.NDArray[np.int64]:
    """Return indices of at most `max_count` samples: the first, last, smallest and largest sample of each interval.

    No peak is lost, and samples that are too dense to be drawn fill a band.
    """
    if len(values) <= max_count:
        return np.arange(len(values))
    stretches = np.array_split(np.arange(len(values)), max_count // 4)
    marks = [(part[0], part[np.argmin(values[part])], part[np.argmax(values[part])], part[-1]) for part in stretches]
    return np.unique(np.array(marks, dtype=np.int64))


@dataclass(frozen=True)
class InputCurves:
    """An input as applied during a run.

    Attributes:
        variable: the input.
        curves: curves of the elements that are not always 0, or of the extremes; one curve if all elements are always equal.
        acting: number of elements that are not always 0.
        is_summary: whether the curves are the largest and smallest of many elements.
    """

    variable: Variable
    curves: tuple[Curve, ...]
    acting: int
    is_summary: bool = False


def load_input_curves(log: Any, name: str) -> InputCurves | None:
    """Return the curves of an input as applied during a log, with both values at a jump; None if the log has no step."""
    variable: Variable = log.input_variables[name]
    held = acting_intervals(log, name)
    if not held:
        return None
    draw = _curve_maker(log, variable, held)
    acting = np.zeros(prod(variable.shape), dtype=bool)
    for one in held:
        if not isinstance(one.value, CompiledProfile) or one.value.coefficients.any():
            acting |= _flat_values(one.value) != 0.0
    count = int(acting.sum())
    if all(np.ptp(_flat_values(one.value)) == 0.0 for one in held):
        return InputCurves(variable, (draw(name, itemgetter(0)),), count)
    if count > MOST_CURVES:
        return InputCurves(variable, tuple(_extreme_curves(variable, acting, draw)), count, is_summary=True)
    positions = variable_positions(log, variable)

    def draw_element(place: int) -> Curve:
        label = element_label(variable, tuple(map(int, np.unravel_index(place, variable.shape))), positions)
        return replace(draw(_element_name(variable, place), itemgetter(place)), label=label)

    return InputCurves(variable, tuple(draw_element(place) for place in np.flatnonzero(acting).tolist()), count)


def present_input_curves(variable: Variable, value: Any, time: float, tick: int) -> Iterator[Curve]:
    """Yield an input's present value as curves of one sample: one per element of a small array, the extremes of a large one."""
    values = np.ravel(value).astype(np.float64)

    def make_curve(name: str, choose: Callable[[FloatArray], float]) -> Curve:
        sample = np.array([choose(values)])
        return Curve(name, variable.unit, variable.description, np.array([time]), np.array([tick], dtype=np.int64), sample)

    if values.size <= MOST_CURVES:
        for place in range(values.size):
            yield make_curve(_element_name(variable, place), itemgetter(place))
    else:
        yield from _extreme_curves(variable, np.ones(values.size, dtype=bool), make_curve)


def component_names(variable: Variable) -> list[str]:
    """Return one name per entry of a variable that is an array of vectors or tensors; for any other variable its name."""
    if names := vector_names(variable.shape[1:], variable.axes[1:]):
        return [f"{variable.name}_{entry}" for entry in names]
    if len(variable.shape) < 2 or prod(variable.shape[1:]) > MOST_COMPONENTS:
        return [variable.name]
    return [f"{variable.name}[:,{','.join(map(str, index))}]" for index in np.ndindex(variable.shape[1:])]


Drawer = Callable[[str, Callable[[FloatArray], float]], Curve]


def _curve_maker(log: Any, variable: Variable, intervals: Sequence[InputInterval]) -> Drawer:
    """Return a function that makes the curve of one number; its argument picks this number from the input's elements (1-D)."""
    samples = [one.sample_ticks() for one in intervals]
    ticks = np.array([tick + one.shift for own, one in zip(samples, intervals, strict=True) for tick in own], np.int64)

    def make_curve(name: str, choose: Callable[[FloatArray], float]) -> Curve:
        values: list[float] = []
        for own, one in zip(samples, intervals, strict=True):
            row = _flat_values(one.value)
            if isinstance(one.value, CompiledProfile):
                # If the time factor is negative, the input's largest element is the factor times the array's smallest one.
                positive, negative = float(choose(row)), -float(choose(-row))
                factors = np.array([one.value.polynomial_value(tick) for tick in own])
                values += np.where(factors < 0.0, negative * factors, positive * factors).tolist()
            else:
                values += [float(choose(row))] * len(own)
        course = np.array(values)
        picked = pick_with_extremes(course)
        return Curve(name, variable.unit, variable.description, ticks[picked] * log.step_size, ticks[picked], course[picked])

    return make_curve


def _flat_values(value: Held) -> FloatArray:
    """Return the elements of an input's value as one row; for a profile, of the array that its time factor multiplies."""
    if isinstance(value, CompiledProfile):
        return np.ones(1) if value.pattern is None else np.ravel(value.pattern)
    return np.ravel(value)


def _extreme_curves(variable: Variable, acting: npt.NDArray[np.bool_], draw: Drawer) -> Iterator[Curve]:
    """Yield the curves of an input's largest and smallest element; for vectors, of each component that is not always 0."""
    names = component_names(variable)
    for column, name in enumerate(names):
        part = slice(column, None, len(names))
        if acting[part].any():
            yield draw(f"{name}, largest", lambda values, part=part: values[part].max())
            yield draw(f"{name}, least", lambda values, part=part: values[part].min())


def _element_name(variable: Variable, place: int) -> str:
    """Return the name of an element by its index in the flat array, such as "force[3,0]"."""
    if prod(variable.shape) == 1:
        return variable.name
    return str(Element(variable.name, tuple(int(index) for index in np.unravel_index(place, variable.shape))))
