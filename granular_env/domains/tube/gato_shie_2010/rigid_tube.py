"""The gas alone in a rigid tube, the paper's first computation: the experiment, and the speed of its front."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.experiments import load_experiment
from granular_env.recording.log import Log

from .cases import LENGTH

_FRONT_EVERY = 1e-5


def gas_tube(pressure: float, *, cells: int = 710, length: float = LENGTH, reaction: str = "pressure_burn") -> dict[str, Any]:
    """Return the shipped detonation tube with another filling [Pa], mesh, length [m] or reaction."""
    found = load_experiment("gato-shie-2010/detonation-tube").to_dict()
    component = found["component"]
    component |= {"cells": cells, "length": length, "initial_pressure": pressure, "reaction": reaction}
    component["gauges"] = [place for place in component["gauges"] if place < length]
    found["input"]["ignition_power"]["peak"] *= pressure / 1e5
    if length < LENGTH:
        component["right"], found["duration"] = "closed", 5.5e-4
    found["record"] = {"every": 2e-6, "variables": ["gauge_pressure", "right_front", "cj_ratio"]}
    return found


def front_speed(log: Log) -> float:
    """Return the speed of the front over the second half of its way before the end of the log or of the tube [m/s]."""
    times, place = log.series("right_front")
    running = (place > 0.5 * place.max()) & (place < 0.95 * place.max())
    return float(np.polyfit(times[running], place[running], 1)[0])


def front_ratio(log: Log) -> float:
    """Return the speed of the front over that of Chapman and Jouguet."""
    tube: Any = log.rebuilt()
    return front_speed(log) / float(tube.front.speed)
