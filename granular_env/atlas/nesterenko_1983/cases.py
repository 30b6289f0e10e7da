"""The paper's chains: the shipped experiments, with the atlas's constants and the reference integrator.

A is the contact stiffness over a grain's mass; N is the length of the paper's usual chain. Every other length, and every grain
that the paper looks at, keeps its proportion to N; the paper's grain 1 is our grain 0.
"""

from __future__ import annotations

import math
from typing import Any

from granular_env import measurement
from granular_env.atlas.context import Context
from granular_env.experiments import load_experiment
from granular_env.measurement import History

A, N = 5.6e12, 100
RADIUS, DENSITY, YOUNG, POISSON = 3e-3, 7800.0, 2e11, 0.29
DIAMETER = 2.0 * RADIUS
MASS = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
SPEED = 5.0
# Ticks of the reference integrator; within each it chooses its own steps.
_STEP, _EVERY = 5e-7, 1e-6


def length(context: Context, grains: int) -> int:
    """How many grains a chain has that has `grains` in the paper."""
    return max(4, round(grains * context.constants["N"] / N))


def grain(context: Context, number: int) -> int:
    """Our index of the paper's grain `number`."""
    return max(1, round(number * context.constants["N"] / N)) - 1


def longer(context: Context, duration: float) -> float:
    """A duration, so much longer or shorter as waves take for the chain that the constants give; in whole microseconds."""
    scale = max(context.constants["N"] / N, 0.1) * (context.constants["A"] / A) ** -0.4
    return math.ceil(duration * scale / _EVERY - 1e-9) * _EVERY


def case(context: Context, shipped: str, /, least: float = 0.0, **changes: Any) -> History:
    """The motion in a shipped experiment; arguments as for `case_document`."""
    return measurement.history(context.run(case_document(context, shipped, least, **changes)))


def case_document(context: Context, shipped: str, /, least: float = 0.0, **changes: Any) -> dict[str, Any]:
    """The content of a shipped experiment, with the atlas's constants.

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
    component |= {"integrator": "dop853", "step_size": _STEP}
    document["record"] |= {"every": _EVERY, "variables": ["displacement", "velocity"]}
    for key, value in changes.items():
        place, _, field = key.rpartition("__")
        (document.setdefault(place, {}) if place else document)[field] = value
    grains = component["grains"]
    component["grains"] = length(context, grains)
    if "velocity" in document.get("start", {}):
        document["start"] = {"velocity": _placed(document["start"]["velocity"], grains, component["grains"])}
    document["duration"] = max(longer(context, document["duration"]), math.ceil(least / _EVERY - 1e-9) * _EVERY)
    return document


def _placed(velocity: dict[str, float], grains: int, now: int) -> dict[str, float]:
    """Start velocities: of the first half counted from the left end, of the second from the right."""
    return {str(int(i) if int(i) < grains // 2 else now - (grains - int(i))): value for i, value in velocity.items()}


def chain_document(
    context: Context,
    name: str,
    grains: int,
    duration: float,
    velocity: dict[int, float],
    every: float = _EVERY,
    **component: Any,
) -> dict[str, Any]:
    """An experiment with the paper's grains; `component` as the chain's parameters."""
    return {
        "name": name,
        "duration": math.ceil(duration * (context.constants["A"] / A) ** -0.4 / every - 1e-9) * every,
        "component": {
            "type": "chain",
            "grains": grains,
            "radius": RADIUS,
            "material": "steel",
            "contact_stiffness": context.constants["A"] * MASS,
            "integrator": "dop853",
            "step_size": min(every, _STEP),
        }
        | component,
        "start": {"velocity": {str(i): value for i, value in velocity.items()}},
        "record": {"every": every, "variables": ["displacement", "velocity"]},
    }
