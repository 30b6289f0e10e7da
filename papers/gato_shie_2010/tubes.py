"""The paper's notched tubes: runs, and outcomes read from logs.

The model has the gas of the whole tube and half (by symmetry) of a 160 mm piece of wall around the notch. Runs are cached in a
process.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

import numpy as np
import numpy.typing as npt

import granular_env as ge
from granular_env.components.drawables import Cells, Links, Points
from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic
from granular_env.components.shell.fracture.outcome import OUTCOMES
from granular_env.components.support.float_arrays import FloatArray
from granular_env.experiments import load_experiment
from pages import FULL, record

# Nodes of the whole tube: coarse, or the paper's 140,000 (it had up to 280,000); a coarser mesh for many runs.
NODES = 140_000 if FULL else 5_000
COARSER = 0.64 * NODES
# Multiple of the yield stress at which bonds break in the paper, and the multiple used for our pictures.
PRINTED, FACTOR = 3.0, 1.6
HOURGLASS, PRESSURE = 0.05, 180e3
INCH, RADIUS, WALL = 0.0254, 0.01975, 0.89e-3
# Length of tube and specimen, position of the notch's middle, and length of the shell piece [m].
LENGTH, MIDDLE, PIECE = 2.13, 1.825, 0.16
# Approximate time of the front at the middle of the notch; times of interest after that, the last from the paper [s].
ARRIVAL, VERY_EARLY, EARLY, LATE = 7.7e-4, 3e-5, 1.5e-4, 4e-4
# Plastic strains at which a run with the paper's factor (aluminium tears at 0.4) and any other run end.
DRAWN_OUT, TORN_OUT = 1.0, 9.0
# Gauges: axial distance [m] and angle [rad] from the middle of the notch.
GAUGES = ((-0.06, 0.0), (-0.06, math.pi), (0.0, math.pi), (0.06, math.pi))
RECORDED = (
    "shell_surface_stress", "shell_surface_displacement", "shell_surface_links", "shell_surface_cells", "shell_pieces",
    "shell_outcome", "shell_crack_along", "shell_crack_around", "shell_gauge_strain", "radial_displacement",
)  # fmt: skip


@functools.cache
def saturation() -> float:
    """Return the flow stress at a plastic strain of 1 over the yield stress, for the paper's material."""
    law = Thermoviscoplastic()
    return (1.0 + 1.0 / law.reference_strain) ** law.hardening_exponent


@functools.cache
def burst_log(
    inches: int,
    factor: float = FACTOR,
    nodes: float = NODES,
    hourglass: float = HOURGLASS,
    pressure: float = PRESSURE,
    coupling: str = "one_way",
) -> Any:
    """Return the log of a detonation in a tube with a notch.

    Args:
        inches: length of the notch.
        factor: factor of the fracture criterion.
        nodes: number of nodes of the whole tube.
        hourglass: stabilisation of displacements that alternate between columns.
        pressure: pressure of the gas before the detonation [Pa].
        coupling: "one_way" as in the paper, or "two_way".
    """
    around = math.sqrt(0.5 * nodes / (3 * 1.4))
    notch = {"length": inches * INCH, "depth": 0.6e-3, "width": 0.5e-3}
    body = {
        "name": "tube",
        "length": PIECE,
        "along": round(1.4 * around),
        "around": round(around),
        "half": True,
        "notch": notch,
    }
    gas = {
        "length": LENGTH, "cells": 710, "cross_section": 0.5 * math.pi * RADIUS * RADIUS, "initial_pressure": pressure,
        "right": "absorbing", "ignition_zone": [0.0, 0.012],
    }  # fmt: skip
    shell = {
        "body": body, "material": "thermoviscoplastic", "boundaries": {"start": "symmetry", "end": "symmetry"},
        "fracture": {"name": "principal_stress", "factor": factor}, "hourglass": hourglass,
        "gauges": [[0.5 * PIECE + place, angle] for place, angle in GAUGES],
    }  # fmt: skip
    # Internal steps, and wall steps per internal step; a ligament that does not break becomes thin and needs twice as many.
    tube = {
        "type": "tube", "position": MIDDLE - 0.5 * PIECE, "coupling": coupling, "gas": gas, "shell": shell, "step_size": 2e-7,
        "shell_steps": 22 if factor >= PRINTED else 11,
    }  # fmt: skip
    limit = DRAWN_OUT if factor >= PRINTED else TORN_OUT
    return record({
        "name": f"notch-{inches}-in", "duration": ARRIVAL + LATE, "component": tube,
        "input": {"gas_ignition_power": {"profile": "half_sine", "peak": 1e7 * pressure / 1e5, "duration": 1e-5}},
        "stop": [{"variable": "shell_plastic_strain", "reduce": "max", "above": limit}],
        "record": {"every": 5e-6, "snapshot_every": 5e-4, "variables": list(RECORDED)},
    })  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Outcome:
    """The state of a tube at a time.

    Attributes:
        word: the outcome: whole, bulged, axial crack, hoop crack, severed.
        along: axial extent of the cracks [m].
        around: largest fraction of the circumference that is cracked at one axial position.
        reach: fraction of the circumference reached by cracks from the notch in both directions, at any axial position.
        pieces: number of pieces.
        time: after the front has passed the middle of the notch [s].
        valid_until: time at which a cross-section has grown by more than half, which one-way coupling neglects [s].
        parted: number of points parted by the end of the run.
        ratio: largest ratio of principal stress to limit by the end of the run.
        in_notch: whether this ratio occurred in the notch.
        strain: largest plastic strain at the end of the run.
        x: axial positions of the nodes of the outer surface, from the middle of the notch [m].
        arc: their angle from the notch, 0 to pi [rad].
        stress: equivalent stress at these nodes [Pa].
        pairs: indices of neighbours in the surface, shape (links, 2).
        cut: whether a crack separates the neighbours of each pair.
    """

    word: str
    along: float
    around: float
    reach: float
    pieces: int
    time: float
    valid_until: float
    parted: float
    ratio: float
    in_notch: bool
    strain: float
    x: FloatArray
    arc: FloatArray
    stress: FloatArray
    pairs: npt.NDArray[np.int64]
    cut: npt.NDArray[np.bool_]

    @property
    def valid(self) -> str:
        """The time until which the rigid tube of the gas represents the wall, as text."""
        return "the end" if self.time < self.valid_until else f"{1e3 * self.valid_until:.2g} ms"


def outcome(log: Any, after: float | None = None) -> Outcome:
    """Return the outcome at a time `after` the front has passed the notch [s], by default at the end of the run."""
    [surface] = [one for one in log.drawables if isinstance(one, Cells) and one.name == "surface"]
    [nodes] = [one for one in log.drawables if isinstance(one, Points) and one.name == "nodes"]
    [links] = [one for one in log.drawables if isinstance(one, Links)]
    end = float(log.times("shell_pieces")[-1])
    time = end if after is None else min(ARRIVAL + after, end)
    # Links refer to nodes of the body; the surface has separate numbers.
    number = {tuple(place): k for k, place in enumerate(np.round(surface.nodes, 9).tolist())}
    pairs = np.array([number.get(tuple(place), -1) for place in np.round(nodes.reference, 9).tolist()])[links.pairs]
    arc, cut = np.arctan2(surface.nodes[:, 1], surface.nodes[:, 2]), np.asarray(log.get("shell_surface_links", time)) == 0.0
    report, grown = log.metadata["report"], log.events("cross_section_grown")
    place = float(report.get("shell: along the body, m", 0.0)) - 0.5 * float(np.ptp(surface.nodes[:, 0]))
    notch = log.metadata["parameters"]["shell"]["body"]["notch"]["length"]
    return Outcome(
        word=OUTCOMES[int(log.get("shell_outcome", time))],
        along=float(log.get("shell_crack_along", time)),
        around=float(log.get("shell_crack_around", time)),
        reach=float(crack_reaches(arc, pairs)[cut].max(initial=0.0)),
        pieces=int(log.get("shell_pieces", time)),
        time=time - ARRIVAL,
        valid_until=grown[0].tick * log.step_size - ARRIVAL if grown else math.inf,
        parted=float(report.get("shell: points that have parted", 0.0)),
        ratio=float(report.get("shell: largest fracture ratio so far, above 0.5", 0.0)),
        in_notch=abs(place) <= 0.5 * notch + 0.1 * INCH and abs(float(report.get("shell: angle around, rad", math.nan))) < 0.1,
        strain=float(report["shell: largest plastic strain"]),
        x=surface.nodes[:, 0] - MIDDLE, arc=arc, stress=np.asarray(log.get("shell_surface_stress", time)), pairs=pairs, cut=cut,
    )  # fmt: skip


def crack_reaches(arc: FloatArray, pairs: npt.NDArray[np.int64]) -> FloatArray:
    """Return the distance from the notch reached by a crack between each pair, for half the circumference (by symmetry).

    A crack between two columns of nodes lies halfway between them; a crack across a column passes through its strip.
    """
    places = np.round(arc, 9)
    columns, first = np.unique(places, return_index=True)
    ends = np.append(0.5 * (arc[first][1:] + arc[first][:-1]), arc[first][-1])
    return ends[np.searchsorted(columns, places[pairs].min(axis=1))] / math.pi


def reach_history(log: Any) -> tuple[FloatArray, FloatArray]:
    """Return the times of a log [s], and at each the fraction of the circumference reached by cracks."""
    end = outcome(log)
    times, links = log.series("shell_surface_links")
    return times, np.where(links == 0.0, crack_reaches(end.arc, end.pairs), 0.0).max(axis=1)


# The columns of a table of outcomes.
HEAD = ("outcome", "reach along", "reach around", "at one place", "pieces", "valid until")
REACH = (
    "Reach along: distance between the first and the last crack along the tube. Reach around: fraction of the circumference "
    "over which cracks extend, at any axial position. At one place: the largest cracked fraction at one axial position. Valid "
    "until: time at which a cross-section has grown by more than half, which one-way coupling neglects."
)


def outcome_row(one: Outcome) -> list[str]:
    """Return the columns of a table of outcomes."""
    return [
        one.word,
        f"{1e3 * one.along:.0f} mm",
        f"{100 * one.reach:.0f} %",
        f"{100 * one.around:.0f} %",
        f"{one.pieces}",
        one.valid,
    ]


def gas_tube(pressure: float, *, cells: int = 710, length: float = LENGTH, reaction: str = "pressure_burn") -> dict[str, Any]:
    """Return the shipped detonation tube with another filling [Pa], mesh, length [m] or reaction."""
    found = load_experiment("gato-shie-2010/detonation-tube").to_dict()
    component = found["component"] | {"cells": cells, "length": length, "initial_pressure": pressure, "reaction": reaction}
    component["gauges"] = [place for place in component["gauges"] if place < length]
    found["input"]["ignition_power"]["peak"] *= pressure / 1e5
    if length < LENGTH:
        component["right"], found["duration"] = "closed", 5.5e-4
    record = {"every": 2e-6, "variables": ["gauge_pressure", "right_front", "cj_ratio"]}
    return found | {"component": component, "record": record}


def gas_component(document: dict[str, Any]) -> Any:
    """Return the component of this experiment, which provides its Chapman-Jouguet front."""
    return ge.make("detonation", **{key: value for key, value in document["component"].items() if key != "type"})


def front_speed(log: Any) -> float:
    """Return the speed of the front over the second half of its path [m/s]."""
    times, place = log.series("right_front")
    running = (place > 0.5 * place.max()) & (place < 0.95 * place.max())
    return float(np.polyfit(times[running], place[running], 1)[0])
