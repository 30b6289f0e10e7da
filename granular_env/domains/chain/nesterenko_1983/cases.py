"""The paper's chains: the shipped experiments, with the atlas's constants and the reference integrator.

A is the contact stiffness over a grain's mass; N is the length of the paper's usual chain. Every other length, and every grain
that the paper looks at, keeps its proportion to N; the paper's grain 1 is our grain 0.
"""

from __future__ import annotations

import math
from typing import Any

from granular_env.atlas.context import Context
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory
from granular_env.experiments import load_experiment

from .. import measurement
from ..measurement import History

A, N = 5.6e12, 100
RADIUS, DENSITY, YOUNG, POISSON = 3e-3, 7800.0, 2e11, 0.29
DIAMETER = 2.0 * RADIUS
MASS = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
SPEED = 5.0
# Between two frames of a log [s], for the paper's A; and in units of time, which no other A may exceed: amplitudes are then
# known to 1e-5 v0 (docs/measurement.md).
_EVERY, _MOST_UNITS = 1e-6, 0.2
# The paper puts the error of its velocities at 0.01 % (section 3).
ERROR, ERROR_SOURCE = 1e-4, "the paper’s own error of velocities"
# Words of the paper, as we read them everywhere; what keeps to them holds in part: "unchanged", of a height or a speed that is
# seen in a figure, and "satisfactory", of one curve against another [%].
UNCHANGED, SATISFACTORY = 5.0, 10.0


def change(name: str, printed: str, percent: float, digits: int = 3) -> Value:
    """Return a change in percent that the paper calls none: its own error agrees, what no figure shows agrees in part."""
    return Value(
        name, printed, percent, "%", paper=0.0, tolerance=100.0 * ERROR, source=ERROR_SOURCE, loose=UNCHANGED, digits=digits
    )


def sampling(context: Context) -> float:
    """Return the time between two frames [s]: short enough for the constants, and divided by the refinement."""
    unit = theory.time_scale(MASS, context.constants["A"] * MASS, SPEED)
    halvings = max(0, math.ceil(math.log2(_EVERY / (_MOST_UNITS * unit)) - 1e-9))
    return _EVERY / 2**halvings / context.refinement


def step(context: Context) -> float:
    """Return the length of the reference integrator's ticks [s]; within each it chooses its own steps."""
    return 0.5 * sampling(context)


def length(context: Context, grains: int) -> int:
    """Return the number of grains of a chain that has `grains` in the paper."""
    return max(4, round(grains * context.constants["N"] / N))


def grain(context: Context, number: int) -> int:
    """Our index of the paper's grain `number`."""
    return max(1, round(number * context.constants["N"] / N)) - 1


def longer(context: Context, duration: float) -> float:
    """Scale a duration as the waves' travel time through the chain scales with the constants; in whole microseconds."""
    scale = max(context.constants["N"] / N, 0.1) * (context.constants["A"] / A) ** -0.4
    return math.ceil(duration * scale / _EVERY - 1e-9) * _EVERY


def case(context: Context, shipped: str, /, least: float = 0.0, **changes: Any) -> History:
    """Return the motion in a shipped experiment; arguments as for `case_document`."""
    return measurement.history(context.run(case_document(context, shipped, least, **changes)))


def case_document(context: Context, shipped: str, /, least: float = 0.0, **changes: Any) -> dict[str, Any]:
    """Return the content of a shipped experiment, with the atlas's constants.

    Args:
        context: of the atlas.
        shipped: its name, without the paper's.
        least: the run lasts at least so long [s].
        changes: of the content, ``component.mass`` written ``component__mass``; grains and durations as in the paper.
    """
    document = load_experiment(f"nesterenko-1983/{shipped}").to_dict()
    component = document["component"]
    if "contact_stiffness" in component:
        component["contact_stiffness"] = context.constants["A"] * MASS
    elif isinstance(component["material"], dict):  # the material gives A
        component["material"]["young"] *= context.constants["A"] / A
    component |= {"integrator": "dop853", "step_size": step(context)}
    document["record"] |= {"every": sampling(context), "variables": ["displacement", "velocity"]}
    for key, value in changes.items():
        place, _, field = key.rpartition("__")
        (document.setdefault(place, {}) if place else document)[field] = value
    grains = component["grains"]
    component["grains"] = length(context, grains)
    if "velocity" in document.get("start", {}):
        document["start"] = {"velocity": _place(document["start"]["velocity"], grains, component["grains"])}
    document["duration"] = max(longer(context, document["duration"]), math.ceil(least / _EVERY - 1e-9) * _EVERY)
    return document


def _place(velocity: dict[str, float], grains: int, now: int) -> dict[str, float]:
    """Start velocities: of the first half counted from the left end, of the second from the right."""
    return {str(int(i) if int(i) < grains // 2 else now - (grains - int(i))): value for i, value in velocity.items()}


def chain_document(
    context: Context,
    name: str,
    grains: int,
    duration: float,
    velocity: dict[int, float],
    units: float = 1.0,
    **component: Any,
) -> dict[str, Any]:
    """Return an experiment with the paper's grains.

    Args:
        context: of the atlas.
        name: of the experiment.
        grains: how many, whatever the constants are.
        duration: with the paper's A [s].
        velocity: at the start, by our index [m/s].
        units: the unit of time of this chain, over that of the paper's: it is sampled by it.
        component: the chain's parameters.
    """
    every = units * sampling(context)
    base = every * context.refinement
    return {
        "name": name,
        "duration": math.ceil(duration * (context.constants["A"] / A) ** -0.4 / base - 1e-9) * base,
        "component": {
            "type": "chain",
            "grains": grains,
            "radius": RADIUS,
            "material": "steel",
            "contact_stiffness": context.constants["A"] * MASS,
            "integrator": "dop853",
            "step_size": 0.5 * every,
        }
        | component,
        "start": {"velocity": {str(i): value for i, value in velocity.items()}},
        "record": {"every": every, "variables": ["displacement", "velocity"]},
    }
