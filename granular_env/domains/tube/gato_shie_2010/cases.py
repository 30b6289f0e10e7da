"""The paper's notched tubes, as experiments: the gas of the whole tube, and the piece of the wall around the notch."""

from __future__ import annotations

import math
from typing import Any, TypedDict, Unpack

from granular_env.atlas.context import Context
from granular_env.recording.log import Log

# Nodes of the whole tube, and the factor that cracks are drawn for; the paper's, which had up to twice as many nodes.
NODES, FACTOR = 5000, 1.6
PAPER_NODES, PAPER_FACTOR = 140_000, 3.0
# Inner radius and wall; depth of the notch, and width, which the paper does not print [m].
RADIUS, WALL, DEPTH, WIDTH = 0.01975, 0.89e-3, 0.6e-3, 0.5e-3
INCH = 0.0254
# Detonation tube and specimen [m]; the piece of it that is a shell, with the notch in its middle.
LENGTH, MIDDLE, PIECE = 2.13, 1.825, 0.16
POSITION = MIDDLE - 0.5 * PIECE
PRESSURE = 180e3
# When the front is at the middle of the notch, about [s]. The runs go on for the paper's time after that; cracks are read at
# an early time too.
ARRIVAL = 7.7e-4
EARLY, LATE = 1.5e-4, 4e-4
DURATION = ARRIVAL + LATE
_EVERY = 5e-6
# The runs are short beside the page, and nobody resumes one.
_SNAPSHOT_EVERY = 5e-4
_LAYERS = 3
# A cheaper mesh: its nodes over the page's.
COARSER = 0.64
# Planes along the piece over those around its half.
_ASPECT = 1.4
_CELLS, _SPARK = 710, 1e7
HOURGLASS = 0.05
# Speed of the detonation, about [m/s].
FRONT_SPEED = 2370.0
# Internal steps [s], and the steps that the wall makes in each: stable for up to 280,000 nodes, where by itself it would take
# rounder and much shorter ones. A ligament that nothing parts gets so thin that it takes twice as many.
_INTERNAL_STEP, _SHELL_STEPS = 2e-7, 11
# Plastic strain at which a run with the paper’s factor ends: its ligament is drawn out to 0.4, where aluminium tears.
DRAWN_OUT = 1.0
# Plastic strain at which any other run ends: a component takes 10 at most.
_TORN_OUT = 9.0
# The gas, and all that does not grow with the nodes [s, of one core]; nodes and ticks a second of a shell that breaks: from
# runs of 5000 and 140,000 nodes.
GAS_SECONDS = 12.0
_SPEED = 1.7e6
# Gauges: from the middle of the notch along the tube [m], and the angle from it around the tube [rad].
GAUGES = ((-0.06, 0.0), (-0.06, math.pi), (0.0, math.pi), (0.06, math.pi))
RECORDED = (
    "shell_surface_stress", "shell_surface_displacement", "shell_surface_links", "shell_surface_cells", "shell_pieces",
    "shell_outcome", "shell_crack_along", "shell_crack_around", "shell_gauge_strain", "radial_displacement",
)  # fmt: skip


def counts(nodes: float) -> tuple[int, int]:
    """Return the planes along the piece, and around its half, of a whole tube with so many nodes."""
    around = math.sqrt(0.5 * nodes / (_LAYERS * _ASPECT))
    return round(_ASPECT * around), round(around)


class Changes(TypedDict, total=False):
    """Changes of a case of the page: nodes of the whole tube, hourglass control, initial pressure [Pa], two-way coupling."""

    nodes: float
    hourglass: float
    pressure: float
    two_way: bool


def run_notched_tube(context: Context, inches: int, factor: float, **changes: Unpack[Changes]) -> Log:
    """Return the log of `notched_tube`, by its progress bar too: until the front arrives the wall sleeps and costs nothing."""
    nodes = changes.get("nodes", context.constants["nodes"])
    start = (ARRIVAL - 0.5 * PIECE / FRONT_SPEED) / DURATION, GAS_SECONDS / tube_seconds(nodes)
    return context.run(notched_tube(context, inches, factor, **changes), start=start)


def tube_seconds(nodes: float) -> float:
    """Return about how long a run takes, of a whole tube with so many nodes [s, of one core].

    One with the paper's factor takes less: it makes twice the steps, but ends within the first quarter of the time.
    """
    return GAS_SECONDS + 0.5 * nodes * (LATE / _INTERNAL_STEP) * _SHELL_STEPS / _SPEED


def notched_tube(context: Context, inches: int, factor: float, **changes: Unpack[Changes]) -> dict[str, Any]:
    """Return the experiment of a notch so long.

    Args:
        context: of the atlas.
        inches: length of the notch.
        factor: of the criterion of fracture.
        changes: of the page's case; by default it has the page's nodes, and the gas does not feel the wall.
    """
    pressure, two_way = changes.get("pressure", PRESSURE), changes.get("two_way", False)
    along, around = counts(changes.get("nodes", context.constants["nodes"]))
    notch = {"length": inches * INCH, "depth": DEPTH, "width": WIDTH}
    body = {"name": "tube", "length": PIECE, "along": along, "around": around, "half": True, "notch": notch}
    gas = {
        "length": LENGTH, "cells": _CELLS, "cross_section": 0.5 * math.pi * RADIUS * RADIUS, "initial_pressure": pressure,
        "right": "absorbing", "ignition_zone": [0.0, 0.012],
    }  # fmt: skip
    shell = {
        "body": body, "material": "thermoviscoplastic", "boundaries": {"start": "symmetry", "end": "symmetry"},
        "fracture": {"name": "principal_stress", "factor": factor}, "hourglass": changes.get("hourglass", HOURGLASS),
        "gauges": [[0.5 * PIECE + place, angle] for place, angle in GAUGES],
    }  # fmt: skip
    as_printed = factor >= PAPER_FACTOR
    return {
        "name": f"notch-{inches}-in",
        "duration": DURATION,
        "component": {
            "type": "tube", "position": POSITION, "coupling": "two_way" if two_way else "one_way", "gas": gas, "shell": shell,
            "step_size": _INTERNAL_STEP, "shell_steps": 2 * _SHELL_STEPS if as_printed else _SHELL_STEPS,
        },
        "input": {"gas_ignition_power": {"profile": "half_sine", "peak": _SPARK * pressure / 1e5, "duration": 1e-5}},
        "stop": [{"variable": "shell_plastic_strain", "reduce": "max", "above": DRAWN_OUT if as_printed else _TORN_OUT}],
        "record": {"every": _EVERY, "snapshot_every": _SNAPSHOT_EVERY, "variables": list(RECORDED)},
    }  # fmt: skip
