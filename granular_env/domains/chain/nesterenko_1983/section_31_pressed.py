"""Section 3.1, its end: the same disturbance in a chain that is pressed together."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value

from .. import measurement
from ..measurement import History
from .cases import MASS, SPEED, case, grain
from .velocity_curves import MICRO, TIME
from .wave_count import CLEAR, FAINT, before_return, counts, heights, waves

# xi_0 over the largest strain of the uncompressed chain's taller wave.
_WEAK, _STRONG = 0.01, 1.0


def compute(context: Context) -> Findings:
    """Two moving grains without precompression, with a weak one, and with one as strong as the wave."""
    free = case(context, "3.1-two-grains")
    crest = measurement.overlap_of(free, waves(free, grain(context, 60))[0]).height
    chains = {part: _compress(context, part * crest) for part in (_WEAK, _STRONG)}
    return Findings([_weak(context, free, chains[_WEAK]), _strong(context, chains[_STRONG])], [_figure(context, free, chains)])


def _compress(context: Context, overlap: float) -> History:
    force = context.constants["A"] * MASS * overlap**1.5
    return case(
        context, "3.1-two-grains", component__precompression=force,
        name=f"nesterenko-1983/3.1-pressed-{force:.3g}N",
    )  # fmt: skip


def _weak(context: Context, free: History, pressed: History) -> Item:
    place = grain(context, 60)
    own = before_return(pressed, place)
    return Item(
        "A weak precompression, ξ0 ≪ ξm, changes nothing qualitatively", "section 3.1",
        [*counts("waves", "2", own, place), Value("their v_m/v0", None, heights(waves(own, place), SPEED))],
        remark=f"ξ0 = {_WEAK:g} ξm, at grain 60; 2 waves without precompression, as high as "
        f"{heights(waves(free, place), SPEED)} v0. Counted by the rule of 3.1.",
    )  # fmt: skip


def _strong(context: Context, pressed: History) -> Item:
    place = grain(context, 60)
    own = before_return(pressed, place)
    found = [len(waves(own, place, above)) for above in (CLEAR, FAINT)]
    lowest = float(own.velocity[:, place].min()) / SPEED
    shown = waves(own, place)[:6]
    changed = 2 not in found and lowest < 0.0
    return Item(
        "A precompression ξ0 ~ ξm changes the solution", "section 3.1",
        [
            Value("two waves and rest behind them", "no longer", "no longer" if changed else "still"),
            *counts("waves", None, own, place),
            Value(f"v_m/v0 of the first {len(shown)} of {found[1]}", None, heights(shown, SPEED, 3)),
            Value("lowest v/v0", None, lowest, digits=3),
        ],
        remark="ξ0 = ξm, at grain 60, before anything comes back from the end: an oscillating train follows, and grains move "
        "backwards.",
    )  # fmt: skip


def _figure(context: Context, free: History, chains: dict[float, History]) -> Figure:
    number = grain(context, 60)
    curves = [Curve("ξ0 = 0", free.time * MICRO, free.velocity[:, number] / SPEED, "line", 0)]
    for colour, (part, chain) in enumerate(chains.items(), start=1):
        label = "ξ0 = ξm" if part == 1.0 else f"ξ0 = {part:g} ξm"
        chain = before_return(chain, number)
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
    weight=0.4,
    runs=3,
)
