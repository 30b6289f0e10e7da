"""Chains of the paper, with cached runs, and the rule for counting waves.

The shipped experiments ``nesterenko-1983/...`` are run with short steps. Grains are counted from 1, as in the paper: grain n
is column n - 1 of a history.
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

# The paper's A [N/(m^1.5 kg)], radius [m] of its steel grains, and velocity of the striker or the piston [m/s].
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
# Time between two frames [s], for which amplitudes are accurate to 1e-5 of the velocity.
EVERY = 1e-6
# Smallest heights of a wave, as fractions of the tallest wave at the same grain.
CLEAR, FAINT = 0.05, 0.02
COUNTED = (
    "A wave is a maximum of the grain's velocity. The paper gives no rule for counting waves, so those above 5 % and above 2 % "
    "of the tallest one are counted."
)
# The paper's error of velocities (section 3), and our reading of "unchanged" and "satisfactory" [%].
ERROR, UNCHANGED, SATISFACTORY = 1e-4, 5.0, 10.0

warnings.simplefilter("ignore", ge.GranularWarning)


@functools.cache
def run_experiment(name: str, duration: float | None = None, every: float = EVERY, **component: Any) -> History:
    """Return the motion of a shipped experiment.

    Args:
        name: name of the experiment, without "nesterenko-1983/".
        duration: duration of the run, if changed [s].
        every: time between two frames [s].
        component: changed parameters of the chain.
    """
    overrides = {f"component.{key}": value for key, value in ({"integrator": "pefrl", "step_size": STEP} | component).items()}
    if duration is not None:
        overrides["duration"] = duration
    watch = measurement.Watch(every)
    ge.run(f"nesterenko-1983/{name}", overrides=overrides, observers=[watch])
    return watch.history


@functools.cache
def run_struck_chain(
    moving: Sequence[int], duration: float = 8e-4, every: float = EVERY, speed: float = SPEED, **chain: Any
) -> History:
    """Return the motion of a chain in which the grains `moving` start at a speed [m/s]; `chain` are its parameters."""
    parameters: dict[str, Any] = {"grains": 100} | STEEL | chain
    component = ge.Chain(**parameters)
    component.reset(velocity={number - 1: speed for number in moving})
    return measurement.observe(component, duration, every)


def run_piston(grains: int = 200) -> History:
    """Return the motion of a piston-driven chain until the last grain has left (section 3.4)."""
    return run_experiment("3.4-piston", duration=1.2e-3 if grains == 200 else 6e-6 * grains + 1e-4, grains=grains)


def waves_at_grain(chain: History, grain: int, above: float = FAINT, direction: Any = "right") -> list[Wave]:
    """Return the waves that pass a grain (counted from 1), in the order of arrival.

    Args:
        chain: the motion.
        grain: the paper's number.
        above: smallest height, as a fraction of the tallest wave there.
        direction: the waves' direction of travel.
    """
    sign = 1.0 if direction == "right" else -1.0
    largest = float((sign * chain.velocity[:, grain - 1]).max())
    found = measurement.waves_at(chain, grain - 1, 0.5 * above * largest, direction=direction)
    tallest = max((wave.amplitude for wave in found), default=0.0)
    return [wave for wave in found if wave.amplitude > above * tallest]


def wave_counts(chain: History, grain: int) -> dict[str, int]:
    """Return the number of waves at a grain (counted from 1) for both thresholds."""
    return {f"above {100 * above:.0f} %": len(waves_at_grain(chain, grain, above)) for above in (CLEAR, FAINT)}


def heights_text(found: Sequence[Wave], scale: float = SPEED, digits: int = 4) -> str:
    """Return the heights of waves in units of `scale`, as text."""
    return ", ".join(f"{wave.amplitude / scale:.{digits}g}" for wave in found)


def cut_before_return(chain: History, grain: int) -> History:
    """Return the part of a history before a reflection from the right end reaches a grain (counted from 1)."""
    arrived = measurement.arrivals(chain, FAINT * float(chain.velocity[:, grain - 1].max()))[grain - 1]
    last = (
        chain.frame_number(min(float(arrived) * 0.95 * (2 * chain.grains - grain + 1) / (grain - 1), float(chain.time[-1]))) + 1
    )
    assert chain.displacement is not None
    parts = {name: getattr(chain, name)[:last] for name in ("time", "velocity", "displacement")}
    return dataclasses.replace(chain, **parts)
