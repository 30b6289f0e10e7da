"""Section 3, its beginning: how exact the computation is, and that velocities scale."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, CurveStyle, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory
from granular_env.recording.log import Log

from .. import measurement
from .cases import DIAMETER, ERROR, MASS, SPEED, case_document, chain_document, length

# Of the paper's integrators, and between two frames of their logs [s].
_STEP, _EVERY = 2e-7, 1e-6
_SPEEDS = (0.05, 5.0, 500.0)
# Of the piston over that of the front (section 3.4).
_RATIOS = {"0.95": 0.95, "5e-3": 5e-3}
_TAU = 60.0
# Overlaps are not to end a run here, however absurd they are for grains.
_NO_LIMIT = 100.0
# Rounding errors, relative to what there is.
_NOISE = 1e-10
# Every correct program keeps them, at steps that are short enough.
_KEPT = "A bound that any correct program keeps if its steps are short enough: a check of ours, no result of the paper’s."


def compute(context: Context) -> Findings:
    """Compute the gap chain, the paper's two integrators, and (3.1)."""
    scaled = {speed: _profile(context, speed) for speed in _SPEEDS}
    near_sound = {name: _profile(context, SPEED, _softness(context, ratio)) for name, ratio in _RATIOS.items()}
    items = [_gaps(context), *_integrators(context), _scaling(scaled), _fast_piston(near_sound)]
    return Findings(items, [_figure(scaled)])


def _gaps(context: Context) -> Item:
    log = context.run(case_document(context, "gap-chain"))
    last = float(measurement.history(log).velocity[-1, -1]) / SPEED
    return Item(
        "Grains with gaps hand one velocity on: v_N/v0", "section 3",
        [Value("|v_N/v0 − 1|", "at most 0.01", 100.0 * abs(last - 1.0), "%", paper=0.01, at_most=True, resolution=1e-6)],
        remark=f"Exactly 1. {_KEPT}",
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
    frames = reference.velocity[:: round(_EVERY / (reference.time[1] - reference.time[0]))]
    names = {"rk4": "Runge-Kutta", "hamming": "Hamming"}
    momentum, energy, velocity = [], [], []
    for integrator, name in names.items():
        log = context.run(
            case_document(
                context, "3.1-two-grains", component__integrator=integrator, component__step_size=_STEP, record__every=_EVERY
            )
        )  # fmt: skip
        difference = 100.0 * float(np.abs(measurement.history(log).velocity - frames).max()) / SPEED
        lost = _momentum_error(log)
        momentum.append(Value(name, "at most 1e-5", lost, "%", paper=1e-5, at_most=True, resolution=_NOISE))
        energy.append(Value(name, "at most 0.01", _energy_error(log), "%", paper=0.01, at_most=True, digits=1))
        velocity.append(Value(name, "about 0.01", difference, "%", paper=0.01, at_most=True, digits=1))
    remark = f"In 3.1, at steps of {_STEP * 1e6:g} µs; the paper’s own are not known. {_KEPT}"
    return [
        Item("Momentum is kept", "section 3", momentum, remark),
        Item("Energy is kept", "section 3", energy, remark),
        Item(
            "Error of the velocities",
            "section 3",
            velocity,
            f"{remark} The largest difference of any grain at any time from the reference integrator, in v0.",
        ),
    ]


def _profile(context: Context, speed: float, softness: float = 1.0) -> np.ndarray:
    """Velocities over v0 of the piston's chain after 60 units of time, its contacts softer by a factor."""
    stiffness = context.constants["A"] * MASS / softness
    tick = 0.1 * theory.time_scale(MASS, stiffness, speed) / context.refinement
    document = chain_document(
        context, f"nesterenko-1983/3.4-at-{speed:g}-{softness:.4g}", grains=length(context, 100), duration=1.0,
        velocity={0: speed}, left="piston", step_size=tick, overlap_limit=_NO_LIMIT, velocity_scale=2.0 * speed,
        contact_stiffness=stiffness,
    ) | {"duration": round(10 * _TAU) * context.refinement * tick, "input": {"left_velocity": speed}}  # fmt: skip
    document["record"]["every"] = 10 * context.refinement * tick
    return measurement.history(context.run(document)).velocity[-1] / speed


def _scaling(scaled: dict[float, np.ndarray]) -> Item:
    profiles = list(scaled.values())
    worst = max(float(np.abs(profile - profiles[1]).max()) for profile in profiles)
    return Item(
        "w = v/v0 depends on τ = t (A² v0)^(1/5) alone", "equation (3.1)",
        [Value("largest |Δw|, v0 = 0.05, 5, 500 m/s", "none", worst, paper=ERROR, at_most=True, resolution=_NOISE)],
        remark=f"The piston’s chain at τ = {_TAU:g}, within the paper’s own error. At 500 m/s Hertz’s law has long ceased to "
        f"hold; this tests the equations. {_KEPT}",
    )  # fmt: skip


def _softness(context: Context, ratio: float) -> float:
    """Return how much softer contacts have to be for v0/V = ratio, V the speed of a solitary wave of height 2 v0."""
    # V = C c^(4/5) v_m^(1/5), and c goes as the square root of the stiffness.
    speed = theory.SOLITARY_SPEED * theory.contact_speed(context.constants["A"], DIAMETER) ** 0.8 * (2.0 * SPEED) ** 0.2
    return (speed * ratio / SPEED) ** 2.5


def _fast_piston(profiles: dict[str, np.ndarray]) -> Item:
    fast, slow = profiles.values()
    worst = float(np.abs(fast - slow).max())
    return Item(
        "Equal profiles for v0/V = 0.95 and 5e-3", "section 3.4",
        [Value("largest |Δw|", "none", worst, paper=ERROR, at_most=True, resolution=_NOISE)],
        remark=f"At τ = {_TAU:g}, within the paper’s own error; V is the speed of the front. The piston goes at {SPEED:g} m/s, "
        "and the contacts are as soft as it takes. At 0.95 centres come nearer than a radius: it is a property of the "
        f"equations. {_KEPT}",
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
    weight=0.5,
    runs=9,
)
