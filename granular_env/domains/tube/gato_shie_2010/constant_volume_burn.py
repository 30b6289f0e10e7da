"""The constant-volume burn that the paper names, taken at its word: its detonation is too fast on any mesh.

By how much depends on the step over the cell length, not on the mesh: the front locks to a simple number of cells in a step.
"""

from __future__ import annotations

from typing import Any

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.recording.log import Log

from .rigid_tube import front_ratio, gas_tube

_LENGTH = 1.52
_CELLS = (380, 760)
# Step over cell length [s/m]: the front of Chapman and Jouguet then crosses 0.12, 0.24 and 0.30 cells in a step.
_STEP_RATIOS = (5e-5, 1e-4, 1.25e-4)
# "Correct": as we read it, within so much of the speed of Chapman and Jouguet.
_CORRECT = 0.01
# The component itself states what the burn that conserves energy may be off.
_LAWS = (("constant_volume", "pressure is overwritten"), ("pressure_burn", "energy is conserved"))


def compute(context: Context) -> Findings:
    """Run both burns on two meshes, at three steps that are the same part of what the front takes to cross a cell."""
    values: list[Value] = []
    for law, words in _LAWS:
        for ratio in _STEP_RATIOS:
            for cells in _CELLS:
                content = gas_tube(1e5, cells=cells, length=_LENGTH, reaction=law)
                content["component"]["step_size"] = ratio * _LENGTH / cells
                log = context.run(content)
                values.append(Value(
                    f"{words}, cells of {1e3 * _LENGTH / cells:.0f} mm, D h / dx = {_crossed_cells(log):.2f}", "correct",
                    front_ratio(log), paper=1.0, loose=_CORRECT, digits=3,
                ))  # fmt: skip
    return Findings([
        Item(
            "The constant-volume burn “guarantees a correct prediction of the speed of propagation and of the state of "
            "chemical "
            "equilibrium at all resolutions of the mesh”", "section Results", values,
            remark="Speed of the front, over that of Chapman and Jouguet, in a closed tube of 1.52 m, 100 kPa; within "
            f"{100 * _CORRECT:g} % is our reading of correct. D h / dx are the cells that a front of that speed D crosses in a "
            "step h.",
            reason="The recipe writes the pressure over that of the flow, which does not conserve energy. Its front advances "
            "by one cell in six steps, two in seven, or one in three. So its speed depends on D h / dx and not on the "
            "mesh, and no finer mesh brings it nearer to that of Chapman and Jouguet. The other entries of this page "
            "use a burn that starts where the pressure has risen, and conserves energy: the last six rows, in which "
            "the step changes the speed by 0.2 %.",
        )
    ])  # fmt: skip


def _crossed_cells(log: Log) -> float:
    """Return how many cells the front of Chapman and Jouguet crosses in a step."""
    tube: Any = log.rebuilt()
    return float(tube.front.speed * tube.step_size / tube.cell_size)


ENTRY = Entry(
    "recipe",
    "Results",
    "The constant-volume burn",
    "The paper does not follow the reaction: its gas burns by the recipe of C. L. Mader, as it is compressed.",
    compute,
    weight=6.0,
    runs=12,
)
