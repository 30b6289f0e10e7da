"""Section 2.3: smaller automata and their sub-steps. As the paper writes them they are unstable; passed-on impulses are not."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.log import Log

from .noisy_block import noisy_block

_STEP, _TICKS = 2e-7, 2000
_SMALLER = (2, 3)
# What holds an energy: from the physics of such schemes, not the paper.
_HELD = 5.0
_ENERGIES = ("kinetic_energy", "rotational_energy", "elastic_energy", "hourglass_energy")


def compute(context: Context) -> Findings:
    """Run both schemes from one noisy start for automata of a half and a third of a cell, with the same micro-steps.

    Impulses take half the step of the grid: a longer one is refused where automata are a third of a cell.
    """
    logs = {
        (scheme, n): context.run(noisy_block(context, n, scheme, 2 * n // part, _STEP / part, part * _TICKS))
        for n in _SMALLER
        for scheme, part in (("literal", 1), ("force", 2))
    }
    return Findings([_energy(logs), _momentum(logs)], [_figure(logs)])


def growth(log: Log) -> tuple[FloatArray, FloatArray]:
    """Return times [s], and the energy over that at the start."""
    times = log.times("kinetic_energy")
    energy = np.sum([log.series(name)[1] for name in _ENERGIES], axis=0)
    return times, energy / energy[0]


def _energy(logs: dict[tuple[str, int], Log]) -> Item:
    values: list[Value] = []
    for n in _SMALLER:
        energy = float(growth(logs["literal", n])[1][-1])
        values.append(Value(
            f"n = {n}, as written: energy at the end over the start", "1", energy, "times", paper=1.0, loose=0.01 * _HELD,
            digits=2,
        ))  # fmt: skip
    for n in _SMALLER:
        off = np.abs(growth(logs["force", n])[1] - 1.0).max()
        values.append(Value(f"n = {n}, impulses: largest change", None, 100.0 * float(off), "%", digits=1))
    return Item(
        "Sub-steps of smaller automata, steps 2 to 4 of the algorithm: neither loss nor generation of energy",
        "section 2.3; abstract", values,
        remark=f"A small block in noisy motion (5 %) that nothing drives, {_TICKS} steps of the grid, "
        "for impulses twice as many half as long, with the same micro-steps; n automata are as long as a cell.",
        reason="Steps 2 to 4 give the automata the velocities of the previous step and the grid a force that is the mean of "
        "theirs. An old velocity and an old force do work that comes from nowhere, and noise grows without bound. "
        "The paper’s own runs have automata of the size of cells (section 3), where nothing is held. "
        "What works is to pass on impulses: the nodes of the interface move with the automata, step by small step, and the "
        "cells kick them once (r-RESPA). That is scheme = force of an experiment; scheme = literal keeps the paper’s. "
        f"{_HELD:g} % is our reading of “neither”.",
    )  # fmt: skip


def _momentum(logs: dict[tuple[str, int], Log]) -> Item:
    values: list[Value] = []
    for scheme, words in (("literal", "as written"), ("force", "impulses")):
        for n in _SMALLER:
            log = logs[scheme, n]
            missing, momentum = (np.abs(log.series(name)[1]).max() for name in ("momentum_residual", "momentum"))
            printed = "complete" if scheme == "literal" else None
            values.append(Value(
                f"n = {n}, {words}: momentum missing", printed, 100.0 * float(missing / momentum), "%",
                paper=0.0 if printed else None, tolerance=1e-8 if printed else None, source="rounding" if printed else "",
                resolution=1e-8, digits=2,
            ))  # fmt: skip
    return Item(
        "Sub-steps of smaller automata: complete transfer of momentum", "section 2.3; section 3", values,
        remark="Over the largest momentum of the run.",
        reason="What the automata gave to a held velocity is not what the grid gets from a mean force; see above. The impulses "
        "lose nothing.",
    )  # fmt: skip


def _figure(logs: dict[tuple[str, int], Log]) -> Figure:
    curves: list[Curve] = []
    for number, n in enumerate(_SMALLER):
        for scheme, words, style in (("literal", "as written", "line"), ("force", "impulses", "dashed")):
            times, energy = growth(logs[scheme, n])
            curves.append(Curve(f"n = {n}, {words}", times * 1e6, np.log10(energy), style, number))  # type: ignore[arg-type]
    most = int(np.ceil(max(float(np.nanmax(curve.points()[1])) for curve in curves)))
    names = [(float(power), f"{10.0**power:g}") for power in range(most + 1)]
    return Figure(
        "figure-sub-steps", "Energy of a block that nothing drives",
        "Automata of a half and a third of a cell. With the paper’s sub-steps the energy grows without bound; with "
        "impulses it stays.",
        Axis("time, µs"), Axis("energy over that at the start", -0.2, float(most), names), curves,
    )  # fmt: skip


ENTRY = Entry(
    "2.3-sub-steps",
    "2.3",
    "Smaller automata: the sub-steps as written are unstable",
    "Automata may be n times smaller than cells; then they make several steps while the grid makes one. The paper gives them "
    "the velocities of the last step and takes back the mean of their forces.",
    compute,
    weight=5.0,
    runs=4,
)
