"""Section 3.1, its end: the same disturbance in a chain that is pressed together."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env import measurement
from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.measurement import History

from .cases import MASS, SPEED, case, grain
from .drawn import MICRO, TIME

_WAVES = 0.02 * SPEED
# xi_0 over the largest strain of the uncompressed chain's taller wave.
_WEAK, _STRONG = 0.01, 1.0


def compute(context: Context) -> Findings:
    """Two moving grains without precompression, with a weak one, and with one as strong as the wave."""
    free = case(context, "3.1-two-grains")
    crest = float(np.nanmax(free.overlap[:, grain(context, 60)]))
    chains = {part: _pressed(context, part * crest) for part in (_WEAK, _STRONG)}
    return Findings([_weak(context, free, chains[_WEAK]), _strong(context, chains[_STRONG])], [_figure(context, free, chains)])


def _pressed(context: Context, overlap: float) -> History:
    force = context.constants["A"] * MASS * overlap**1.5
    return case(
        context, "3.1-two-grains", component__precompression=force,
        name=f"nesterenko-1983/3.1-pressed-{force:.3g}N",
    )  # fmt: skip


def _heights(context: Context, chain: History) -> list[float]:
    """Of the waves that pass grain 60 before anything comes back from the ends."""
    return [wave.amplitude / SPEED for wave in measurement.waves_at(_undisturbed(context, chain), grain(context, 60), _WAVES)]


def _undisturbed(context: Context, chain: History) -> History:
    """The part of a history in which nothing has come back to grain 60 from the right end: its way is that much longer."""
    place = grain(context, 60)
    arrived = float(measurement.arrivals(chain, _WAVES)[place])
    last = chain.frame(min(arrived * 0.95 * (2 * chain.grains - place) / place, float(chain.time[-1])))
    own = slice(0, last + 1)
    displacement = None if chain.displacement is None else chain.displacement[own]
    return dataclasses.replace(chain, time=chain.time[own], velocity=chain.velocity[own], displacement=displacement)


def _weak(context: Context, free: History, pressed: History) -> Item:
    before, after = _heights(context, free), _heights(context, pressed)
    listed = ", ".join(f"{height:.3f}" for height in after)
    return Item(
        "A weak precompression, ξ0 ≪ ξm, changes nothing qualitatively", "section 3.1",
        [Value("waves above 0.02 v0", str(len(before)), len(after)), Value("their v_m/v0", None, listed)],
        remark=f"ξ0 = {_WEAK:g} ξm, at grain 60; 2 waves without precompression, as high as "
        f"{', '.join(f'{height:.3f}' for height in before)}.",
    )  # fmt: skip


def _strong(context: Context, pressed: History) -> Item:
    heights = _heights(context, pressed)
    velocity = _undisturbed(context, pressed).velocity[:, grain(context, 60)] / SPEED
    lowest = float(velocity.min())
    changed = len(heights) != 2 or lowest < -0.02
    listed = ", ".join(f"{height:.3f}" for height in heights[:6])
    return Item(
        "A precompression ξ0 ~ ξm changes the solution", "section 3.1",
        [
            Value("two waves and rest behind them", "no longer", "no longer" if changed else "still"),
            Value("maxima above 0.02 v0, v_m/v0", None, listed), Value("lowest v/v0", None, lowest),
        ],
        remark="ξ0 = ξm, at grain 60: an oscillating train follows, and grains move backwards.",
    )  # fmt: skip


def _figure(context: Context, free: History, chains: dict[float, History]) -> Figure:
    number = grain(context, 60)
    curves = [Curve("ξ0 = 0", free.time * MICRO, free.velocity[:, number] / SPEED, "line", 0)]
    for colour, (part, chain) in enumerate(chains.items(), start=1):
        label = "ξ0 = ξm" if part == 1.0 else f"ξ0 = {part:g} ξm"
        chain = _undisturbed(context, chain)
        curves.append(Curve(label, chain.time * MICRO, chain.velocity[:, number] / SPEED, "line", colour))
    return Figure(
        "figure-pressed", "Velocity of grain 60 for three precompressions",
        "With a hundredth of the wave’s strain the two waves stay, a little faster; with as much as the wave’s, sound is as "
        "fast as the wave and an oscillating train takes their place.",
        Axis(TIME), Axis("v / v0"), curves,
    )  # fmt: skip


ENTRY = Entry(
    "3.1-pressed",
    "3.1",
    "The same under precompression",
    "Constant forces at both ends press the chain together before the blow.",
    compute,
)
