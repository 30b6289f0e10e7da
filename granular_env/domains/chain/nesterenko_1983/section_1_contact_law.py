"""Section 1: Hertz's law, the constants, and how far they may be trusted; and the time of a collision from section 3."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .. import measurement
from .cases import DENSITY, MASS, POISSON, RADIUS, SPEED, YOUNG, chain_document

_PRESSURE = "peak pressure / pressure at first yield"
_RADIUS = "contact radius / grain radius"
# "Much less than 1".
_SMALL = 0.1
_TIME = "collision time / grain's oscillation time (tau/T)"


def compute(context: Context) -> Findings:
    """Compute A from the steel's constants, the limits of the static law, and two colliding grains."""
    overlap, time = _collision(context)
    return Findings(
        [_stiffness(), _collision_time(context, time, overlap), _limits(context)], [_figure(context, time, overlap)]
    )


def _stiffness() -> Item:
    ours = theory.contact_constant(YOUNG, POISSON, DENSITY, RADIUS)
    return Item(
        "A of steel grains of 3 mm", "(2.1), sections 3.1 and 3.5",
        [Value("", "5.6e12", ours, "N/(m^1.5 kg)")],
        remark="Both are kept: sections 3.1 to 3.4 use the printed A, section 3.5 the printed E, ν and ρ.",
        reason=f"E = 2e11 Pa, ν = 0.29 and ρ = 7800 kg/m³, which the paper gives in 3.5, make {ours:.4g}; the printed A "
        f"would want E = {YOUNG * 5.6e12 / ours:.3g} Pa. Only the unit of time depends on it.",
    )  # fmt: skip


def _collision(context: Context) -> tuple[np.ndarray, np.ndarray]:
    """Overlap over time of two grains that meet at 5 m/s."""
    document = chain_document(context, "nesterenko-1983/collision", grains=2, duration=6e-5, velocity={0: SPEED}, units=0.05)
    history = measurement.history(context.run(document))
    return history.overlap[:, 1], history.time


def _collision_time(context: Context, time: np.ndarray, overlap: np.ndarray) -> Item:
    open_again = int(np.argmax(overlap[1:] < 0.0)) + 1
    before, after = overlap[open_again - 1], overlap[open_again]
    touched = time[open_again - 1] + (time[1] - time[0]) * before / (before - after)
    coefficient = touched / ((5.0 / (8.0 * context.constants["A"])) ** 0.4 * SPEED**-0.2)
    return Item(
        "Time of a collision, T1 = C (5/8A)^(2/5) / v0^(1/5)", "section 3",
        [Value("C", "2.94", float(coefficient)), Value("T1 at 5 m/s", None, float(touched * 1e6), "µs", digits=5)],
        remark=f"Exactly 2 √π Γ(7/5)/Γ(9/10) = {theory.COLLISION_COEFFICIENT:.5f}.",
    )  # fmt: skip


def _limits(context: Context) -> Item:
    document = chain_document(context, "nesterenko-1983/limits", grains=100, duration=2e-4, velocity={0: SPEED, 1: SPEED})
    report = context.run(document).metadata["report"]
    pressure, radius, time = (float(report[name]) for name in (_PRESSURE, _RADIUS, _TIME))
    # The pressure goes as v^(2/5).
    yielding = SPEED * pressure**-2.5
    return Item(
        "The static law’s limits, at the paper’s own 5 m/s", "section 1",
        [
            Value("pressure / yield pressure", "below 1", pressure, paper=1.0, at_most=True, digits=4),
            Value("contact radius / R", "much less than 1", radius, at_most=True, loose=_SMALL, digits=4),
            Value("T / collision time", "much less than 1", 1.0 / time, at_most=True, loose=_SMALL, digits=4),
        ],
        remark="In 3.1 with two moving grains. Every run reports these three figures.",
        reason="The paper does not say how much “much less” is; a tenth is our reading. At 5 m/s the contact pressure is "
        f"{pressure:.2g} times that of first yield, which is reached at {yielding:.2g} m/s: real steel grains would deform "
        "plastically. The equations are integrated as the paper did it.",
    )  # fmt: skip


def _figure(context: Context, time: np.ndarray, overlap: np.ndarray) -> Figure:
    force = context.constants["A"] * MASS * np.maximum(overlap, 0.0) ** 1.5
    printed = 2.94 * (5.0 / (8.0 * context.constants["A"])) ** 0.4 * SPEED**-0.2
    return Figure(
        "figure-collision", "Two grains meet at 5 m/s",
        "The force of Hertz’s law while they touch. The paper chooses its time step far below this time, T1.",
        Axis("time, µs"), Axis("force, N"), [Curve("force between the grains", time * 1e6, force)],
        [Mark("T1", x=printed * 1e6)],
    )  # fmt: skip


ENTRY = Entry(
    "1-model",
    "1",
    "The law of contact and its limits",
    "Neighbouring grains repel with F = k δ^(3/2), δ being the approach of their centres, and never attract (Hertz’s static "
    "law). The paper names three conditions under which the static law describes a collision.",
    compute,
    weight=0.2,
    runs=2,
)
