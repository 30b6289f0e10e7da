"""Chains of the paper, run once in a process, and the rule by which waves are counted.

The shipped experiments ``nesterenko-1983/...`` are taken with short steps. Grains are counted from 1, as in the paper: its
grain n is column n - 1 of a history.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import warnings
from collections.abc import Sequence
from typing import Any

import granular_env as ge
from granular_env.domains.chain import measurement
from granular_env.domains.chain.measurement import History, Wave

# The paper's A [N/(m^1.5 kg)], and its steel grains: radius [m], mass [kg]; velocity of the blow or the piston [m/s].
A, RADIUS, SPEED = 5.6e12, 3e-3, 5.0
DIAMETER = 2.0 * RADIUS
DENSITY, YOUNG, POISSON = 7800.0, 2e11, 0.29
MASS = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
# Internal step [s].
STEP = 5e-8
STEEL: dict[str, Any] = {
    "radius": RADIUS,
    "material": "steel",
    "contact_stiffness": A * MASS,
    "integrator": "pefrl",
    "step_size": STEP,
}
# Time between two frames [s]: amplitudes are then known to 1e-5 of the velocity.
EVERY = 1e-6
# Least heights of a wave, as parts of the tallest one's at the same grain.
CLEAR, FAINT = 0.05, 0.02
COUNTED = (
    "A wave is a maximum of the grain's velocity. The paper gives no rule for counting waves, so those above 5 % and above 2 % "
    "of the tallest one are counted."
)
# The paper's error of velocities (section 3), and how we read its words "unchanged" and "satisfactory" [%].
ERROR, UNCHANGED, SATISFACTORY = 1e-4, 5.0, 10.0

warnings.simplefilter("ignore", ge.GranularWarning)


@functools.cache
def run(name: str, duration: float | None = None, every: float = EVERY, **component: Any) -> History:
    """Return the motion in a shipped experiment.

    Args:
        name: of the experiment, without "nesterenko-1983/".
        duration: of the run, if another one [s].
        every: time between two frames [s].
        component: parameters of the chain that differ.
    """
    overrides = {f"component.{key}": value for key, value in ({"integrator": "pefrl", "step_size": STEP} | component).items()}
    if duration is not None:
        overrides["duration"] = duration
    watch = measurement.Watch(every)
    ge.run(f"nesterenko-1983/{name}", overrides=overrides, observers=[watch])
    return watch.history


@functools.cache
def strike(moving: Sequence[int], duration: float = 8e-4, every: float = EVERY, speed: float = SPEED, **chain: Any) -> History:
    """Return the motion of a chain whose grains `moving` start with a speed [m/s]; `chain` has its parameters."""
    parameters: dict[str, Any] = {"grains": 100} | STEEL | chain
    component = ge.Chain(**parameters)
    component.reset(velocity={number - 1: speed for number in moving})
    return measurement.observe(component, duration, every)


def piston(grains: int = 200) -> History:
    """Return the motion of a chain before a piston until the last grain has left (section 3.4)."""
    return run("3.4-piston", duration=1.2e-3 if grains == 200 else 6e-6 * grains + 1e-4, grains=grains)


def waves(chain: History, grain: int, above: float = FAINT, direction: Any = "right") -> list[Wave]:
    """Return the waves that pass the paper's grain, in the order of arrival.

    Args:
        chain: the motion.
        grain: the paper's number.
        above: least height, as a part of the tallest wave's there.
        direction: the waves' direction of travel.
    """
    sign = 1.0 if direction == "right" else -1.0
    largest = float((sign * chain.velocity[:, grain - 1]).max())
    found = measurement.waves_at(chain, grain - 1, 0.5 * above * largest, direction=direction)
    tallest = max((wave.amplitude for wave in found), default=0.0)
    return [wave for wave in found if wave.amplitude > above * tallest]


def count(chain: History, grain: int) -> dict[str, int]:
    """Return the number of waves at the paper's grain by both thresholds."""
    return {f"above {100 * above:.0f} %": len(waves(chain, grain, above)) for above in (CLEAR, FAINT)}


def heights(found: Sequence[Wave], scale: float = SPEED, digits: int = 4) -> str:
    """Return the heights of waves in units of `scale`, as words."""
    return ", ".join(f"{wave.amplitude / scale:.{digits}g}" for wave in found)


def before_return(chain: History, grain: int) -> History:
    """Return the part of a history in which nothing has come back to the paper's grain from the right end."""
    arrived = measurement.arrivals(chain, FAINT * float(chain.velocity[:, grain - 1].max()))[grain - 1]
    last = chain.frame(min(float(arrived) * 0.95 * (2 * chain.grains - grain + 1) / (grain - 1), float(chain.time[-1]))) + 1
    assert chain.displacement is not None
    parts = {name: getattr(chain, name)[:last] for name in ("time", "velocity", "displacement")}
    return dataclasses.replace(chain, **parts)
