"""Curves: scalars in time, thinned so that no peak is lost, and inputs as curves of the elements that act, or of the extremes.

An array that was held is read once, however long it was held, and a profile is a factor in time and one array. The memory is
that of a few curves, whatever the size of the input.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.inputs import Held, input_value
from granular_env.components.profiles import CompiledProfile
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Element, Variable
from granular_env.recording.steps import Stretch

MAXIMUM_CURVE_POINTS = 4_000
# More different curves than this in one figure cannot be followed.
MOST_CURVES = 6
# Elements that share a curve are named up to so many; of more the first, and how many there are.
_MOST_NAMED = 3
# A vector for each of many places has an axis of up to so many components at its end.
MOST_COMPONENTS = 3


@dataclass(frozen=True)
class Curve:
    """A scalar in time.

    Attributes:
        times: shape (samples,) [s].
        ticks: shape (samples,).
        values: shape (samples,), in `unit`.
        cuts: indices of the first samples of later segments: no line leads there from the sample before.
    """

    name: str
    unit: str
    description: str
    times: FloatArray
    ticks: npt.NDArray[np.int64]
    values: FloatArray
    cuts: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))


def pick_with_extremes(values: FloatArray, most: int = MAXIMUM_CURVE_POINTS) -> npt.NDArray[np.int64]:
    """Return indices of at most `most` samples: of each stretch its first, its last, its least and its largest.

    So no peak is lost, and where samples lie closer than can be drawn, what is drawn is the band that they fill.
    """
    if len(values) <= most:
        return np.arange(len(values))
    stretches = np.array_split(np.arange(len(values)), most // 4)
    marks = [(part[0], part[np.argmin(values[part])], part[np.argmax(values[part])], part[-1]) for part in stretches]
    return np.unique(np.array(marks, dtype=np.int64))


@dataclass(frozen=True)
class InputCurves:
    """An input as it acted.

    Attributes:
        variable: the input.
        curves: those of its elements that act, or of the extremes; one that stays 0 where none acts.
        acting: how many elements act.
        is_summary: whether the curves are extremes over many elements.
    """

    variable: Variable
    curves: tuple[Curve, ...]
    acting: int
    is_summary: bool = False

    @property
    def acts(self) -> bool:
        """True where any of it is ever other than 0."""
        return any(curve.values.any() for curve in self.curves)


def load_input(log: Any, name: str) -> InputCurves | None:
    """Return an input of a log as it acted, both sides of its jumps; None where there was no step."""
    variable: Variable = log.input_variables[name]
    held = acting_stretches(log, name)
    if not held:
        return None
    draw = _drawer(log, variable, held)
    if not variable.shape:
        return InputCurves(variable, (draw(name, _element(0)),), 1)
    patterns = list(_patterns(held))
    acting = np.zeros(prod(variable.shape), dtype=bool)
    for pattern in patterns:
        acting |= pattern != 0.0
    count = int(acting.sum())
    if not count:
        return InputCurves(variable, (draw(name, _element(0)),), 0)
    groups = _alike(patterns, acting)
    if groups is None:
        return InputCurves(variable, tuple(_extremes(variable, acting, draw)), count, is_summary=True)
    curves = (draw(_name(variable, members), _element(members[0])) for members in groups)
    return InputCurves(variable, tuple(curves), count)


def load_elements(log: Any, name: str, indices: Iterable[tuple[int, ...]]) -> list[Curve]:
    """Return the curves of some elements of an array input of a log that has steps."""
    variable: Variable = log.input_variables[name]
    draw = _drawer(log, variable, acting_stretches(log, name))
    places = [int(np.ravel_multi_index(index, variable.shape)) for index in indices]
    return [draw(_name(variable, [place]), _element(place)) for place in places]


def acting_stretches(log: Any, name: str) -> list[Stretch]:
    """Return when an input was held at what, without what was held before the first step set it: that acted on nothing."""
    return [one for one in log.input_stretches(name) if one.end > one.begin]


def present_input(variable: Variable, value: Any, time: float, tick: int) -> Iterator[Curve]:
    """Yield what an input has now as curves of one sample: each element of a small array, the extremes of a large one."""
    values = np.ravel(value).astype(np.float64)

    def draw(name: str, choose: Callable[[FloatArray], float]) -> Curve:
        sample = np.array([choose(values)])
        return Curve(name, variable.unit, variable.description, np.array([time]), np.array([tick], dtype=np.int64), sample)

    if values.size <= MOST_CURVES:
        for place in range(values.size):
            yield draw(_name(variable, [place]), _element(place))
    else:
        yield from _extremes(variable, np.ones(values.size, dtype=bool), draw)


def component_names(variable: Variable) -> list[str]:
    """Return what the components of the vectors that a variable has at many places are called; of a plain array its name."""
    count = prod(variable.shape[1:])
    if len(variable.shape) < 2 or count > MOST_COMPONENTS:
        return [variable.name]
    return [f"{variable.name}[:,{','.join(map(str, index))}]" for index in np.ndindex(variable.shape[1:])]


def values_at(held: Sequence[Stretch], ticks: Iterable[int]) -> Iterator[Any]:
    """Yield the values of an input at some ticks of the log, ascending; where it jumps, those after the jump."""
    place = 0
    for tick in ticks:
        while place + 1 < len(held) and held[place + 1].begin + held[place + 1].shift <= tick:
            place += 1
        yield input_value(held[place].value, tick - held[place].shift)


Drawer = Callable[[str, Callable[[FloatArray], float]], Curve]


def _drawer(log: Any, variable: Variable, held: Sequence[Stretch]) -> Drawer:
    """Return what makes the curve of a number that is chosen of the elements, given as one row."""
    samples = [one.sample_ticks() for one in held]
    every = (tick + one.shift for own, one in zip(samples, held, strict=True) for tick in own)
    ticks = np.fromiter(every, dtype=np.int64)
    times = ticks * log.step_size

    def draw(name: str, choose: Callable[[FloatArray], float]) -> Curve:
        known: dict[int, float] = {}
        values: list[float] = []
        for own, one in zip(samples, held, strict=True):
            if isinstance(one.value, float):
                values += [one.value] * len(own)
                continue
            if not isinstance(one.value, CompiledProfile):
                if id(one.value) not in known:
                    known[id(one.value)] = float(choose(_row(one.value)))
                values += [known[id(one.value)]] * len(own)
                continue
            factors = np.array([one.value.factor(tick) for tick in own])
            row = _row(one.value)
            # The largest of an array times a negative number is its least times that number.
            positive, negative = float(choose(row)), -float(choose(-row))
            values += np.where(factors < 0.0, negative * factors, positive * factors).tolist()
        course = np.array(values)
        picked = pick_with_extremes(course)
        return Curve(name, variable.unit, variable.description, times[picked], ticks[picked], course[picked])

    return draw


def _patterns(held: Iterable[Stretch]) -> Iterator[FloatArray]:
    """Yield once each row of elements that others are multiples of over some stretch."""
    known: set[int] = set()
    for one in held:
        if id(one.value) not in known:
            known.add(id(one.value))
            silent = isinstance(one.value, CompiledProfile) and not one.value.coefficients.any()
            yield 0.0 * _row(one.value) if silent else _row(one.value)


def _row(value: Held) -> FloatArray:
    """Return the elements of what was held as one row; of a profile what its factor in time is multiplied by."""
    if isinstance(value, CompiledProfile):
        return np.ones(1) if value.pattern is None else np.ravel(value.pattern)
    return np.ravel(value)


def _alike(patterns: Sequence[FloatArray], acting: npt.NDArray[np.bool_]) -> list[npt.NDArray[np.int64]] | None:
    """Return the elements that act, in groups that always have one value; None where there are too many groups."""
    chosen = np.flatnonzero(acting)
    labels, firsts = np.zeros(len(chosen), np.int64), np.zeros(1, np.int64)
    for pattern in patterns:
        values = pattern[chosen]
        if np.array_equal(values, values[firsts][labels]):
            continue
        _, ranks = np.unique(values, return_inverse=True)
        _, firsts, labels = np.unique(labels * len(chosen) + ranks, return_index=True, return_inverse=True)
        if len(firsts) > MOST_CURVES:
            return None
    return [chosen[labels == labels[first]] for first in sorted(firsts.tolist())]


def _extremes(variable: Variable, acting: npt.NDArray[np.bool_], draw: Drawer) -> Iterator[Curve]:
    """Yield the largest and the least of all elements, of vectors those of each component that acts."""
    names = component_names(variable)
    for column, name in enumerate(names):
        part = slice(column, None, len(names))
        if acting[part].any():
            yield draw(f"{name}, largest", lambda values, part=part: values[part].max())
            yield draw(f"{name}, least", lambda values, part=part: values[part].min())


def _element(place: int) -> Callable[[FloatArray], float]:
    return lambda values: values[place]


def _name(variable: Variable, members: Sequence[int] | npt.NDArray[np.int64]) -> str:
    """Return what a curve is called that all these elements have."""
    size = prod(variable.shape)
    if len(members) == size and size != 1 or not variable.shape:
        return variable.name
    shown = members if len(members) <= _MOST_NAMED else members[:1]
    indices = [tuple(int(part) for part in np.unravel_index(int(place), variable.shape)) for place in shown]
    more = f" and {len(members) - len(shown)} more" if len(members) > len(shown) else ""
    return f"{', '.join(str(Element(variable.name, index)) for index in indices)}{more}"
