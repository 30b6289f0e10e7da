"""Small gas-filled tubes for tests."""

from __future__ import annotations

import math
from typing import Any

import granular_env as ge

# A thick and narrow tube, which needs few nodes around its circumference.
RADIUS, WALL = 0.003, 8e-4
# Half of a circular cross-section, because the shell is a half tube.
AREA = 1.4137167e-5
BODY = {"name": "tube", "length": 0.006, "inner_radius": RADIUS, "wall": WALL, "along": 7, "around": 7, "half": True}
HOT = {"x": [0.0, 0.004], "pressure": 1.2e6, "temperature": 3500.0}
GAS = {"length": 0.03, "cells": 60, "cross_section": AREA, "regions": [HOT], "right": "open"}


def small_tube(**changes: Any) -> Any:
    """Return a gas that burns from the left end, with a shell after the first half of its length."""
    shell = {"body": BODY, "boundaries": {"start": "clamped", "end": "symmetry"}}
    return ge.make("tube", **{"gas": GAS, "shell": shell, "position": 0.0152, **changes})


def cracking_tube(**changes: Any) -> Any:
    """Return a small tube with a notch and a brittle wall that breaks."""
    notch = {"length": 0.003, "depth": 0.0004, "width": 0.0004, "around": 0.5 * math.pi, "columns": 1}
    shell = {
        "body": {**BODY, "along": 13, "around": 13, "notch": notch}, "boundaries": {"start": "clamped", "end": "clamped"},
        "fracture": {"name": "principal_stress", "stress": 2.2e7},
    }  # fmt: skip
    return small_tube(**{"shell": shell, "coupling": "two_way", **changes})


def gas_ring(coupling: Any, young: float, pressure: float) -> Any:
    """Return an air-filled ring in equilibrium with the surrounding air, uniform along its axis."""
    air = {
        "length": 0.002, "cells": 3, "cross_section": AREA, "gas": "air", "initial_pressure": pressure,
        "initial_temperature": 300.0, "ignition_zone": [0.0, 0.001],
    }  # fmt: skip
    body = {**BODY, "length": 0.002, "along": 3, "around": 13}
    shell = {
        "body": body, "material": {"name": "elastic", "young": young, "poisson": 0.0, "density": 2719.0},
        "boundaries": {"start": "symmetry", "end": "symmetry"},
    }  # fmt: skip
    return ge.make("tube", gas=air, shell=shell, position=0.0, coupling=coupling)
