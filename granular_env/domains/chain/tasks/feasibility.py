"""Feasibility: wanted waves that a chain can hold, clear of each other and of its ends; deadlines that can be met."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.errors import ParameterError, StepError, caution
from granular_env.components.support.float_arrays import FloatArray
from granular_env.envs.factory_options import refuse_early

from .driven_end import DrivenEnd
from .target_waves import AMPLITUDE, DENSITY, PLACE, POINTS, REACH, SHAPES, SPEED, TABLES

# Part of a wanted wave's energy that may be in the chain when the episode begins; that may hang over one of its ends, or reach
# beyond the middle between two waves, when they are due.
_PART = 1e-3
# An arrival is looked for during this many control steps, or up to the deadline.
_LONGEST = 10_000

Arrived = Callable[[Chain], float]


def refuse_early_waves(shapes: FloatArray, waves: FloatArray, duration: float, steps: int, name: str = "deadline") -> None:
    """Refuse waves that would have to be in the chain before anybody could have sent them.

    Args:
        shapes: of the waves, see `target_waves`.
        waves: rows (amplitude [m/s], place, speed [grains/s]).
        duration: of a control step [s].
        steps: control steps until they are due.
        name: of the argument at fault.

    Raises:
        ParameterError: more than a thousandth of a wave's energy is in the chain at the start.
    """
    for row, wave in enumerate(waves):
        if wave[AMPLITUDE] <= 0.0 or _part_inside(shapes, row, wave, duration * steps) <= _PART:
            continue
        arrival = f"a wave of {wave[AMPLITUDE]:g} m/s needs them from the left end to grain {wave[PLACE]:g}"
        refuse_early(steps, _least_steps(shapes, row, wave, duration), duration, arrival, name)


def arrived_by(
    driven: Chain, inputs: Mapping[str, float], duration: float, steps: int, arrived: Arrived, wanted: float
) -> float:
    """Return the most that a constant input from the first control step on brings to its place by the deadline.

    Args:
        driven: a chain at its start; it is stepped.
        inputs: name -> value [N or m/s].
        duration: of a control step [s].
        steps: control steps until the deadline.
        arrived: called after each control step; how much has arrived by then.
        wanted: how much has to arrive.

    Raises:
        ParameterError: less than a thousandth of it arrives by the deadline.
    """
    most, step = 0.0, 0
    for step in range(1, max(steps, _LONGEST) + 1):
        try:
            driven.step(duration, **inputs)
        except StepError:  # more than the physics allows: what arrives is not for lack of time
            return wanted
        most = max(most, arrived(driven))
        if most >= wanted or (step >= steps and most > _PART * wanted):
            break
    drive = " and ".join(f"{name} = {value:g}" for name, value in inputs.items())
    reason = f"{drive} from the first one on brings nothing earlier" if drive else "the fastest wave comes no earlier"
    refuse_early(steps, step, duration, reason)
    return most


def caution_late(chain: Chain, end: DrivenEnd, wanted: float, unit: str, arrived: Arrived) -> None:
    """Warn where even the full drive, from the first moment on, does not bring enough to its place by the deadline.

    Args:
        chain: what is driven, at its start; it stays as it is.
        end: where, with what and for how long.
        wanted: how much has to arrive.
        unit: of it.
        arrived: called after each control step; how much has arrived by then.

    Raises:
        ParameterError: nothing arrives by the deadline, see `arrived_by`.
    """
    most = arrived_by(copy.deepcopy(chain), end.actions, end.duration, end.steps, arrived, wanted)
    if most >= wanted:
        return
    name, value = next(iter(end.actions.items()))
    caution(
        f"deadline: {end.steps} control steps of {end.duration:g} s are too few: with {name} = {value:g} from the first on, "
        f"{most:.3g} {unit} of the wanted {wanted:g} {unit} arrive; give a later deadline, or a larger action_scale"
    )


def refuse_crowded(shapes: FloatArray, waves: FloatArray, grains: int, name: str = "place") -> None:
    """Refuse waves that lie over each other, or hang over an end of the chain: no state of it is the sum of these.

    Args:
        shapes: of the waves, see `target_waves`.
        waves: rows (amplitude [m/s], place, speed [grains/s]), in any order.
        grains: of the chain.
        name: of the argument at fault.

    Raises:
        ParameterError: more than a thousandth of a wave's energy is beyond an end, or two waves are closer than their width.
    """
    kept = [(wave[PLACE], half_width(shapes, row)) for row, wave in enumerate(waves) if wave[AMPLITUDE] > 0.0]
    for place, half in kept:
        low, high = half - 0.5, grains - 0.5 - half
        if not low <= place <= high:
            raise ParameterError(
                f"a wave at grain {place:g} hangs over the end of the chain",
                expected=f"{low:g} to {high:g}",
                hint="give another place, or more grains",
                at=name,
            )
    kept.sort()
    for (place, half), (other, other_half) in zip(kept, kept[1:], strict=False):
        if other - place < half + other_half:
            raise ParameterError(
                f"waves at grains {place:g} and {other:g} lie over each other",
                expected=f"{half + other_half:g} grains between them or more",
                at=name,
            )


def half_width(shapes: FloatArray, row: int) -> float:
    """Return how far from its crest a wave reaches to either side, but for a thousandth of its kinetic energy [grains]."""
    squares = _squares(shapes, row)
    place = (np.arange(len(squares)) - 1.0) / float(shapes[DENSITY]) - shapes[REACH]
    return float(-place[np.searchsorted(np.cumsum(squares), _PART * squares.sum())])


def _squares(shapes: FloatArray, row: int) -> FloatArray:
    """Return the squares of a wave's velocities, as its table has them."""
    count = int(shapes[POINTS])
    table = TABLES + 2 * count * min(row, int(shapes[SHAPES]) - 1)
    return shapes[table : table + count] ** 2


def _least_steps(shapes: FloatArray, row: int, wave: FloatArray, duration: float) -> int:
    low, high = 0, 1
    while _part_inside(shapes, row, wave, duration * high) > _PART:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _part_inside(shapes, row, wave, duration * middle) <= _PART else (middle, high)
    return high


def _part_inside(shapes: FloatArray, row: int, wave: FloatArray, left: float) -> float:
    """Part of a wave's kinetic energy that is right of the first grain's left side, `left` seconds before it is due."""
    squares = _squares(shapes, row)
    place = (np.arange(len(squares)) - 1.0) / float(shapes[DENSITY]) - shapes[REACH] + wave[PLACE] - wave[SPEED] * left
    return float(squares[place >= -0.5].sum() / squares.sum())
