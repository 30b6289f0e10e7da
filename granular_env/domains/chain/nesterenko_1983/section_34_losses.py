"""Section 3.4: a piston's front with weak losses, of which the paper argues without computing it."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .. import measurement
from ..measurement import History
from .cases import DIAMETER, ERROR, ERROR_SOURCE, MASS, SPEED, UNCHANGED, case, grain, sampling

_GRAINS = 400
_FRONT = 0.5 * SPEED
# Dashpots in every contact, over a grain's mass and the unit of time of (3.1).
_LOSSES = (0.01, 0.02, 0.05, 0.1)


def compute(context: Context) -> Findings:
    """Speed and height of fronts with weaker and weaker losses, and where the height tends."""
    chains = {loss: _chain(context, loss) for loss in _LOSSES}
    shock = theory.shock_speed(context.constants["A"], DIAMETER, SPEED)
    speeds = {loss: _speed(context, chain) / shock for loss, chain in chains.items()}
    heights = {loss: _height(context, chain) for loss, chain in chains.items()}
    limit = _limit(heights)
    return Findings([_item(speeds, heights, limit)], [_figure_height(heights, limit), _figure_front(context, chains)])


def _chain(context: Context, loss: float) -> History:
    unit = theory.time_scale(MASS, context.constants["A"] * MASS, SPEED)
    return case(
        context, "3.4-piston", component__grains=_GRAINS, duration=6.1e-6 * _GRAINS, record__variables=["velocity"],
        component__law={"name": "viscous", "dissipation": loss * MASS / unit}, component__integrator="pefrl",
        component__step_size=0.2 * sampling(context), name=f"nesterenko-1983/3.4-loss-{loss:g}",
    )  # fmt: skip


def _speed(context: Context, chain: History) -> float:
    return measurement.front_speed(chain, _FRONT, grain(context, 340), grain(context, 390))


def _height(context: Context, chain: History) -> float:
    """Return the height of the front's first maximum, over v0, where it has become steady."""
    index = grain(context, 390)
    begin = int(np.argmax(chain.velocity[:, index] > _FRONT))
    own = slice(max(begin - 10, 0), begin + 60)
    return measurement.crests(chain.time[own], chain.velocity[own, index], SPEED)[0].height / SPEED


def _limit(heights: dict[float, float]) -> float:
    """Height without losses: the parabola through the three weakest."""
    losses, found = np.array(list(heights)[:3]), np.array(list(heights.values())[:3])
    return float(np.polynomial.Polynomial.fit(losses, found, 2)(0.0))


def _item(speeds: dict[float, float], heights: dict[float, float], limit: float) -> Item:
    expected = theory.front_velocity_ratio(theory.SOLITARY_SPEED)
    listed = ", ".join(f"{height:.4f} at {loss:g}" for loss, height in heights.items())
    return Item(
        "A front with weak losses", "section 3.4",
        [
            Value(
                "V/D1, weakest losses", "1", speeds[_LOSSES[0]], paper=1.0, relative=ERROR, source=ERROR_SOURCE,
                loose=0.01 * UNCHANGED,
            ),
            Value("v_m1/v0, losses to 0", "1.56", limit, digits=4),
            Value("v_m1/v0 of a solitary wave as fast as D1", None, expected),
        ],
        remark=f"A dashpot in each contact, grains 341 to 391 of {_GRAINS}. Heights for the dashpot’s constant over grain "
        f"mass and unit of time: {listed}.",
        reason="V is D1 but for what the front still changes at these grains. The argument holds, its number does not: 1.56 "
        f"follows from the continuum’s 0.915, the chain’s own waves give {expected:.4f}, to which the computed fronts tend "
        f"within {100.0 * abs(limit / expected - 1.0):.1f} %.",
    )  # fmt: skip


def _figure_height(heights: dict[float, float], limit: float) -> Figure:
    losses, found = [0.0, *heights], [limit, *heights.values()]
    return Figure(
        "figure-losses", "Height of the front against losses",
        "The weaker the losses, the nearer the front is to a solitary wave as fast as the shock. The point at 0 is "
        "extrapolated.",
        Axis("dashpot’s constant, grain mass / unit of time", low=-0.002), Axis("v_m1 / v0", high=1.7),
        [Curve("computed", losses, found, "points"), Curve("", losses, found, "thin")],
        [Mark("1.56", y=1.56)],
    )  # fmt: skip


def _figure_front(context: Context, chains: dict[float, History]) -> Figure:
    curves = []
    for colour, (loss, chain) in enumerate(chains.items()):
        frame = int(np.argmax(chain.velocity[:, grain(context, 390)] > _FRONT))
        curves.append(Curve(f"{loss:g}", np.arange(1, chain.grains + 1), chain.velocity[frame] / SPEED, "line", colour))
    return Figure(
        "figure-losses-front", "Profiles as the front passes grain 390",
        "With losses the motion becomes steady: oscillations die away behind a front that keeps its form.",
        Axis("grain", low=0.75 * chains[_LOSSES[0]].grains), Axis("v / v0"), curves, [Mark("v0", y=1.0)],
    )  # fmt: skip


ENTRY = Entry(
    "3.4-losses",
    "3.4",
    "The front with weak losses",
    "With weak losses the front should be a solitary wave as fast as the stationary shock, D1: the paper’s argument, from "
    "which it finds how high the front is.",
    compute,
    weight=1.6,
    runs=4,
)
