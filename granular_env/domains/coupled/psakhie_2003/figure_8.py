"""Figure 8: a load beside the interface, and the secondary waves that the interface makes."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value

from .cases import BESIDE, INSTANTS, half_space
from .pictures import Window, difference, shaded, vectors
from .secondary_waves import DEEP, Added, added, largest
from .thresholds import NOT_SEEN_WORDS, SLIGHT_WORDS, absent, slight
from .velocity_field import Motion, motion, shift

_CASES = {"square": "asymmetric", "hexagonal": "hexagonal-asymmetric"}
_WINDOW = Window(left=-0.5, right=0.3, source=-BESIDE)
_CAPTION = (
    "70 µs after a load of 20 µs began to press on the surface, 0.1 m to the left of the interface. Dashed is where theory "
    "puts the fronts of P, S, head (C) and Rayleigh (R) waves. "
)


def compute(context: Context) -> Findings:
    """Draw the square packing; compare both packings with the grid alone, where there is no interface."""
    moving = {packing: motion(context.run(half_space(context, name)), INSTANTS[-1]) for packing, name in _CASES.items()}
    alone = shift(motion(context.run(half_space(context, "grid")), INSTANTS[-1]), -BESIDE)
    found = {packing: added(one, alone, _WINDOW) for packing, one in moving.items()}
    square = moving["square"]
    figures = [
        vectors("figure-8-vectors", "Figure 8, above: velocity vectors", _CAPTION + "Square packing.", square, _WINDOW),
        shaded("figure-8-speed", "Figure 8, below: speed as a shade", _CAPTION + "Square packing.", square, _WINDOW),
    ]
    figures += [_difference(packing, one, alone) for packing, one in moving.items()]
    return Findings([_secondary(found), _pulses(found)], figures)


def _secondary(found: dict[str, Added]) -> Item:
    values: list[Value] = []
    for packing, one in found.items():
        values.append(absent(f"{packing}: in the grid, below {DEEP:g} m", one.back, "no noticeable ones"))
        values.append(absent(f"{packing}: in the grid, near the surface", one.back_near_surface, "no noticeable ones"))
    return Item(
        "“No noticeable secondary (reflected, refracted and conical) waves arose”", "section 3, figure 8", values,
        remark="Largest difference to a half-space that is a grid throughout, over the largest velocity there, on the side of "
        "the load: what the interface sends back.",
        reason=NOT_SEEN_WORDS,
    )  # fmt: skip


def _pulses(found: dict[str, Added]) -> Item:
    values: list[Value] = []
    for packing, one in found.items():
        values.append(slight(f"{packing}: in the automata, below {DEEP:g} m", one.on))
        values.append(slight(f"{packing}: in the automata, near the surface", one.on_near_surface))
    return Item(
        "“Only an insignificant difference in the shape of the pulses”", "section 3, figure 8", values,
        remark="The same difference on the other side: how the waves that went on differ from those of the grid alone.",
        reason=f"{SLIGHT_WORDS} The difference is no wave of the interface, but the automata’s dispersion, which is not that "
        "of the grid; it is largest where the Rayleigh wave has its sharp peak.",
    )  # fmt: skip


def _difference(packing: str, one: Motion, alone: Motion) -> Figure:
    return difference(
        f"figure-8-difference-{packing}", f"What the interface adds, {packing} packing",
        "The motion with automata less that of a grid throughout, in percent of the largest velocity. A reflected wave would "
        "stand to the left of the interface; on its right is how the dispersion of the automata differs from that of the grid.",
        one, alone, _WINDOW, largest(alone),
    )  # fmt: skip


ENTRY = Entry(
    "3-figure-8",
    "3",
    "Figure 8: a load beside the interface",
    "The load stands 0.1 m to the left of the interface, on the grid, so that all waves meet the interface at every angle.",
    compute,
    weight=30.0,
    runs=3,
)
