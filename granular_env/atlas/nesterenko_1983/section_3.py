"""Section 3, its beginning: how exact the computation is, and that velocities scale."""

from __future__ import annotations

import numpy as np

from granular_env import measurement
from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, CurveStyle, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory
from granular_env.recording.reader import Log

from .cases import MASS, SPEED, case_document, chain_document, length

# The paper's own accuracy, of velocities and of energy.
_PERCENT = 0.01
# Of the paper's integrators [s].
_STEP = 2e-7
_SPEEDS = (0.05, 5.0, 500.0)
_TAU = 60.0


def compute(context: Context) -> Findings:
    """The gap chain, the paper's two integrators, and (3.1)."""
    scaled = {speed: _profile(context, speed) for speed in _SPEEDS}
    return Findings([_gaps(context), *_integrators(context), _scaling(scaled)], [_figure(scaled)])


def _gaps(context: Context) -> Item:
    log = context.run(case_document(context, "gap-chain"))
    last = float(measurement.history(log).velocity[-1, -1]) / SPEED
    return Item(
        "Grains with gaps hand one velocity on: v_N/v0", "section 3",
        [Value("", "1", last, paper=1.0, tolerance=1e-4)],
        remark=f"Exactly 1; ours differs by {abs(1.0 - last):.0e}. The paper’s error is 0.01 %.",
    )  # fmt: skip


def _energy_error(log: Log) -> float:
    """Largest residual of the energy, in percent of what there was at the start."""
    start = float(log.series("kinetic_energy")[1][0])
    return 100.0 * float(np.abs(log.series("energy_residual")[1]).max()) / start


def _momentum_error(log: Log) -> float:
    start = float(log.series("momentum")[1][0])
    return 100.0 * float(np.abs(log.series("momentum_residual")[1]).max()) / start


def _integrators(context: Context) -> list[Item]:
    """3.1 with the paper's integrators, against the reference."""
    reference = measurement.history(context.run(case_document(context, "3.1-two-grains")))
    names = {"rk4": "Runge-Kutta", "hamming": "Hamming"}
    momentum, energy, velocity = [], [], []
    for integrator, name in names.items():
        log = context.run(
            case_document(context, "3.1-two-grains", component__integrator=integrator, component__step_size=_STEP)
        )
        difference = np.abs(measurement.history(log).velocity - reference.velocity).max() / SPEED
        momentum.append(Value(name, "at most 1e-5", _momentum_error(log), "%", paper=1e-5, tolerance=0.0, at_most=True))
        energy.append(Value(name, "at most 0.01", _energy_error(log), "%", paper=_PERCENT, tolerance=0.0, at_most=True))
        velocity.append(Value(name, "about 0.01", 100.0 * float(difference), "%", paper=_PERCENT, tolerance=0.0, at_most=True))
    remark = f"In 3.1, at steps of {_STEP * 1e6:g} µs; the paper’s own are not known."
    return [
        Item("Momentum is kept", "section 3", momentum, remark),
        Item("Energy is kept", "section 3", energy, remark),
        Item(
            "Error of the velocities",
            "section 3",
            velocity,
            f"{remark} The largest difference of any grain at any time, in v0.",
        ),
    ]


def _profile(context: Context, speed: float) -> np.ndarray:
    """Velocities over v0 of the piston's chain after 60 units of time."""
    stiffness = context.constants["A"] * MASS
    unit = theory.time_scale(MASS, stiffness, speed)
    document = chain_document(
        context, f"nesterenko-1983/3.4-at-{speed:g}", grains=length(context, 100), duration=1.0, velocity={0: speed},
        left="piston", step_size=0.1 * unit, overlap_limit=1.9, velocity_scale=2.0 * speed,
    ) | {"duration": round(_TAU / 0.1) * (0.1 * unit), "input": {"left_velocity": speed}}  # fmt: skip
    document["record"]["every"] = 10 * (0.1 * unit)
    return measurement.history(context.run(document)).velocity[-1] / speed


def _scaling(scaled: dict[float, np.ndarray]) -> Item:
    profiles = list(scaled.values())
    worst = max(float(np.abs(profile - profiles[1]).max()) for profile in profiles)
    return Item(
        "w = v/v0 depends on τ = t (A² v0)^(1/5) alone", "equation (3.1)",
        [Value("largest |Δw|, v0 = 0.05, 5, 500 m/s", "none", worst, paper=0.0, tolerance=1e-6)],
        remark=f"The piston’s chain at τ = {_TAU:g}. At 500 m/s Hertz’s law has long ceased to hold; this tests the equations.",
    )  # fmt: skip


def _figure(scaled: dict[float, np.ndarray]) -> Figure:
    styles: tuple[CurveStyle, ...] = ("line", "dashed", "points")
    curves = [
        Curve(f"v0 = {speed:g} m/s", np.arange(1, len(profile) + 1), profile, style, colour)
        for (speed, profile), style, colour in zip(scaled.items(), styles, (0, 1, 3), strict=True)
    ]
    return Figure(
        "figure-scaling", f"The piston’s profile at τ = {_TAU:g} for three velocities",
        "The same in units of the piston’s velocity: ten thousand times the velocity changes nothing but the unit of time.",
        Axis("grain", low=0.0), Axis("v / v0"), curves,
    )  # fmt: skip


ENTRY = Entry(
    "3-checks",
    "3",
    "How exact the computation is",
    "The paper integrates with Runge-Kutta’s and Hamming’s methods, watches momentum and energy, compares with a case that "
    "has an exact solution, and uses that all velocities scale with the first one.",
    compute,
    weight=3.0,
)
