"""Section 3.4: speeds of the front and of solitary waves, and pressures, against those of a stationary shock."""

from __future__ import annotations

import math

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .. import measurement
from ..measurement import History
from .cases import DENSITY, DIAMETER, ERROR, ERROR_SOURCE, RADIUS, SPEED, UNCHANGED, case, chain_document, grain
from .section_34_piston import piston

_FRONT = 0.5 * SPEED
_RADII = (1e-3, 3e-3, 5e-3)
# "The first tens" of grains.
_FIRST_TENS = 50.0


def compute(context: Context) -> Findings:
    """Compute V and D1, what follows from them, and the pressure in the first maximum."""
    single, driven = case(context, "3.1-one-grain"), piston(context)
    coefficient = _coefficient(context, single)
    shock = theory.shock_speed(context.constants["A"], DIAMETER, SPEED)
    fronts = _front_speeds(context, driven)
    items = [
        _speed(coefficient), _shock(fronts, shock, coefficient), _settling(fronts), _radius(context),
        _pressure(context, driven),
    ]  # fmt: skip
    return Findings(items, [_figure(fronts, shock)])


def _coefficient(context: Context, chain: History) -> float:
    """Return C of V = C c^(4/5) v_m^(1/5), from the arrivals of a single wave at two grains."""
    first, last = (measurement.waves_at(chain, grain(context, number), 0.1 * SPEED)[0] for number in (30, 80))
    speed = (last.grain - first.grain) * DIAMETER / (last.time - first.time)
    unit = theory.contact_speed(context.constants["A"], DIAMETER) ** 0.8
    return speed / (unit * last.amplitude**0.2)


def _speed(coefficient: float) -> Item:
    continuum = theory.CONTINUUM_SOLITARY_SPEED
    return Item(
        "C of V = C (2E/((1−ν²)πρ))^(2/5) v_m^(1/5)", "section 3.4",
        [Value("C", "0.915", coefficient, digits=6), Value("the continuum’s (16/25)^(1/5)", None, continuum, digits=6)],
        remark="From the arrivals of the single wave of 3.1 at grains 30 and 80; the theory of the discrete wave gives "
        f"{theory.SOLITARY_SPEED:.6f}.",
        reason=f"The printed 0.915 is the continuum’s (16/25)^(1/5) = {continuum:.4f}, from (2.7); the chain’s own waves are "
        f"{100.0 * (continuum / coefficient - 1.0):.1f} % slower.",
    )  # fmt: skip


def _front_speeds(context: Context, chain: History) -> dict[int, float]:
    """Speed of the front between a grain ten before and one ten after, by the paper's number of the middle."""
    seen = measurement.arrivals(chain, _FRONT)
    found = {}
    for number in range(6, 191, 4):
        half = min(5, number - 2)
        first, last = grain(context, number - half), grain(context, number + half)
        found[number] = float((last - first) * DIAMETER / (seen[last] - seen[first]))
    return found


def _shock(fronts: dict[int, float], shock: float, coefficient: float) -> Item:
    final = fronts[max(fronts)]
    return Item(
        "The front against a stationary shock, D1", "section 3.4",
        [
            Value("V/D1", "1.05", final / shock),
            Value("V/D1 − 1", "about 5", 100.0 * (final / shock - 1.0), "%", digits=3),
            Value("v_m1/v0", "1.56", theory.front_velocity_ratio(coefficient)),
            Value("V", None, final, "m/s"), Value("D1", None, shock, "m/s"),
        ],
        remark="V is the speed with which 0.5 v0 arrives at the last grains. v_m1 is the height of a solitary wave as fast "
        "as D1.",
        reason=f"Both follow from C, as 2^(1/5) C and C^(−5): the printed 1.05 and 1.56 from the continuum’s 0.915, ours from "
        f"{coefficient:.5f}.",
    )  # fmt: skip


def _settling(fronts: dict[int, float]) -> Item:
    numbers, speeds = np.array(list(fronts)), np.array(list(fronts.values()))
    off = np.abs(speeds / speeds[-1] - 1.0)
    # The first from which on all stay within 1 %.
    outside = np.flatnonzero(off > 0.01)
    since = int(numbers[outside[-1] + 1]) if len(outside) and outside[-1] + 1 < len(numbers) else int(numbers[0])
    at_20 = 100.0 * float(np.interp(20, numbers, off))
    return Item(
        "The front’s speed is that of the settled wave within 1 %", "section 3.4",
        [
            Value("within 1 % from grain", "the first tens", since, at_most=True, loose=_FIRST_TENS),
            Value("difference at grain 20", "practically none", at_20, "%", paper=0.0, loose=UNCHANGED, digits=3),
        ],
        reason=f"The words have no number; grain {_FIRST_TENS:.0f} and {UNCHANGED:g} % are our reading.",
    )  # fmt: skip


def _radius(context: Context) -> Item:
    """Fronts in chains of steel grains of three radii; the paper's constant A is scaled with the radius as in (2.1)."""
    speeds, shocks = {}, {}
    for radius in _RADII:
        mass = DENSITY * 4.0 / 3.0 * math.pi * radius**3
        # A as in the atlas, scaled to the radius as (2.1) does: R^(1/2) / R^3.
        constant = context.constants["A"] * (radius / RADIUS) ** -2.5
        document = chain_document(
            context, f"nesterenko-1983/3.4-radius-{radius * 1e3:g}mm", grains=40, duration=2.6e-4 * radius / RADIUS,
            velocity={0: SPEED}, units=radius / RADIUS, left="piston", radius=radius, contact_stiffness=constant * mass,
        ) | {"input": {"left_velocity": SPEED}}  # fmt: skip
        chain = measurement.history(context.run(document))
        speeds[radius] = measurement.front_speed(chain, _FRONT, 20, 35)
        shocks[radius] = theory.shock_speed(constant, 2.0 * radius, SPEED)
    listed = ", ".join(f"{speed:.2f} m/s at {radius * 1e3:g} mm" for radius, speed in speeds.items())
    return Item(
        "V and D1 do not depend on the grains’ radius", "section 3.4",
        [
            Value(
                name, "none", 100.0 * (max(found.values()) / min(found.values()) - 1.0), "%", paper=0.0,
                tolerance=100.0 * ERROR, source=ERROR_SOURCE, resolution=1e-6,
            )
            for name, found in (("spread of V", speeds), ("spread of D1", shocks))
        ],
        remark=f"R = 1, 3 and 5 mm. V between grains 21 and 36: {listed}.",
    )  # fmt: skip


def _pressure(context: Context, chain: History) -> Item:
    place = grain(context, 50)
    found = measurement.pressure_ratio(chain, place)
    swing = [_at_that_instant(chain, place, near) for near in (1, 2, 3)]
    return Item(
        "Pressure in the first maximum over that near the piston", "section 3.4",
        [
            Value("pm/pc, pc the mean from then on", "2.24", found.ratio),
            *(
                Value(f"pc at that instant, {name} contact", None, ratio, digits=4)
                for name, ratio in zip(("first", "second", "third"), swing, strict=True)
            ),
        ],
        remark="The front at grain 50, p the contact force. A stationary shock has at most 1.95.",
        reason="The paper does not say where and when it takes pc, and near the piston the pressure still swings: at the "
        f"instant of the first maximum the ratio is {min(swing):.4g} to {max(swing):.4g} with the first three contacts, and "
        "the printed 2.24 lies between.",
    )  # fmt: skip


def _at_that_instant(chain: History, contact: int, near: int) -> float:
    """Return the first maximum of the force in a contact over the force in one near the piston at that time."""
    force, around = chain.contact_force, 4e-6
    first = measurement.crests(chain.time, force[:, contact], 0.5 * float(force[:, contact].max()))[0]
    own = slice(*np.searchsorted(chain.time, (first.time - around, first.time + around)))
    curve = np.polynomial.Polynomial.fit(chain.time[own], force[own, near], 4)
    return first.height / float(curve(first.time))


def _figure(fronts: dict[int, float], shock: float) -> Figure:
    return Figure(
        "figure-front-speed", "Speed of the front along the chain",
        "Within 1 % of its final value after the first tens of grains, although the motion behind it never becomes steady. A "
        f"stationary shock with the same piston would be {100.0 * (1.0 - shock / fronts[max(fronts)]):.1f} % slower.",
        Axis("grain", low=0.0), Axis("V / D1"),
        [Curve("V / D1", list(fronts), [speed / shock for speed in fronts.values()])],
        [Mark("1.05", y=1.05), Mark("D1", y=1.0)],
    )  # fmt: skip


ENTRY = Entry(
    "3.4-speeds",
    "3.4",
    "Speeds and pressures of the front",
    "How fast a solitary wave is for its height, how fast the piston’s front, and how a stationary shock with losses would "
    "compare.",
    compute,
    weight=0.4,
    runs=5,
)
