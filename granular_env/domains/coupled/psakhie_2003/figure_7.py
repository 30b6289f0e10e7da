"""Figure 7: a load on the interface itself, and whether grid and automata then move alike."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.recording.log import Log

from .cases import DEPTH, HALF_WIDTH, INSTANTS, half_space
from .pictures import Window, shaded, vectors
from .rayleigh import surface_crest
from .secondary_waves import DEEP
from .thresholds import EXACT_SUM, NOT_SEEN_WORDS, SLIGHT_WORDS, absent, complete, slight
from .velocity_field import Motion, motion

_CASES = {"square": "symmetric", "hexagonal": "hexagonal-symmetric"}
_ROWS = 200
_CAPTION = (
    "70 µs after a load of 20 µs began to press on the surface, on the interface itself. Dashed is where theory puts the "
    "fronts of P, S, head (C) and Rayleigh (R) waves; the load is smooth, so that motion sets in a little behind them. "
)


def compute(context: Context) -> Findings:
    """Draw both packings, and compare the two sides."""
    logs = {packing: context.run(half_space(context, name)) for packing, name in _CASES.items()}
    moving = {packing: motion(log, INSTANTS[-1]) for packing, log in logs.items()}
    window, square, close = Window(), moving["square"], moving["hexagonal"]
    turned = "Close packing; the run has its surface along y, and is turned by a right angle for the picture."
    figures = [
        vectors("figure-7-vectors", "Figure 7, above: velocity vectors", _CAPTION + "Square packing.", square, window),
        shaded("figure-7-speed", "Figure 7, below: speed as a shade", _CAPTION + "Square packing.", square, window),
        vectors("figure-7-hexagonal-vectors", "Figure 7, close packing: velocity vectors", _CAPTION + turned, close, window),
        shaded("figure-7-hexagonal-speed", "Figure 7, close packing: speed as a shade", _CAPTION + turned, close, window),
    ]
    return Findings([*_symmetry(moving), _packing(moving), _momentum(logs), _energy(logs)], figures)


def _symmetry(moving: dict[str, Motion]) -> list[Item]:
    found = {packing: asymmetry(one) for packing, one in moving.items()}
    square = moving["square"]
    lead = surface_crest(square, 1.0, INSTANTS[-1]) - surface_crest(square, -1.0, INSTANTS[-1])
    remark = "Largest difference between the velocity and that of its mirror image, over the largest velocity. "
    body = Item(
        "“Both methods give identical results”: body waves left and right of a load on the interface", "abstract, figure 7",
        [absent(f"{packing}: below {DEEP:g} m", 100.0 * deep, "identical") for packing, (deep, _) in found.items()],
        remark=remark + "The paper looks at “the symmetry of the field of velocities”.",
        reason=f"{NOT_SEEN_WORDS} Waves that are short against the cells run a little slower, in each lattice in its own way.",
    )  # fmt: skip
    surface = Item(
        "“Both methods give identical results”: everywhere, with the Rayleigh wave", "abstract, figure 7",
        [absent(packing, 100.0 * whole, "identical") for packing, (_, whole) in found.items()], remark=remark,
        reason=f"{NOT_SEEN_WORDS} The Rayleigh wave has the sharpest peak there is, right at the surface. In the square "
        f"packing, whose outer rows disperse in a way of their own, it runs {lead_words(lead)} that of the grid; the "
        "difference falls with the square of the size of cells (make the page with more of them).",
    )  # fmt: skip
    return [body, surface]


def _packing(moving: dict[str, Motion]) -> Item:
    y = -np.arange(_ROWS + 1) * DEPTH / _ROWS
    places = np.meshgrid((np.arange(_ROWS) + 0.5) * HALF_WIDTH / _ROWS, y)
    square, hexagonal = (moving[packing].at(*places) for packing in _CASES)
    gap = 100.0 * np.linalg.norm(square - hexagonal, axis=-1) / np.linalg.norm(square, axis=-1).max()
    crests = {packing: surface_crest(one, 1.0, INSTANTS[-1]) for packing, one in moving.items()}
    return Item(
        "“The influence of the packing of the automata showed itself only in a slight change of the pulses’ shape”",
        "section 3; conclusion",
        [
            slight(f"square less hexagonal, below {DEEP:g} m", float(gap[y < -DEEP].max()), "slight change"),
            slight("square less hexagonal, everywhere", float(gap.max()), "slight change"),
        ],
        remark="Largest difference between the velocities in both packings, over the largest velocity.",
        reason=f"{SLIGHT_WORDS} Near the surface it is the Rayleigh wave of the square packing, which runs "
        f"{lead_words(crests['square'] - crests['hexagonal'])} that of the close packing; below, nobody would see a "
        "difference.",
    )  # fmt: skip


def lead_words(lead: float) -> str:
    """Return how far one wave is ahead of another, or behind it, in words.

    Args:
        lead: how much farther it has come [m].
    """
    return f"{1e3 * abs(lead):.2g} mm {'ahead of' if lead > 0.0 else 'behind'}"


def asymmetry(one: Motion) -> tuple[float, float]:
    """Return the largest difference to the mirror image below `DEEP` and everywhere, over the largest velocity."""
    x = (np.arange(2 * _ROWS) + 0.5) * HALF_WIDTH / (2 * _ROWS)
    y = -(np.arange(_ROWS + 1)) * DEPTH / _ROWS
    places = np.meshgrid(x, y)
    right, left = one.at(*places), one.at(-places[0], places[1]) * [-1.0, 1.0]
    gap = np.linalg.norm(right - left, axis=-1) / np.linalg.norm(left, axis=-1).max()
    return float(gap[y < -DEEP].max()), float(gap.max())


def _momentum(logs: dict[str, Log]) -> Item:
    values: list[Value] = []
    for packing, log in logs.items():
        missing, impulse = (np.abs(log.series(name)[1]).max() for name in ("momentum_residual", "impulse"))
        values.append(complete(f"{packing}: momentum unaccounted for", float(missing / impulse)))
    return Item(
        "The interface passes on all momentum, with shear as well", "section 3; conclusion", values,
        remark=f"Both components, over the impulse of the load. The paper claims it without shear. {EXACT_SUM}",
    )  # fmt: skip


def _energy(logs: dict[str, Log]) -> Item:
    values: list[Value] = []
    for packing, log in logs.items():
        missing, work = (np.abs(log.series(name)[1]).max() for name in ("energy_residual", "input_work"))
        values.append(Value(
            f"{packing}: energy unaccounted for", "none", 100.0 * float(missing / work), "%", paper=0.0, tolerance=1e-2,
            source="the load’s work, known to the square of the step", digits=2,
        ))  # fmt: skip
    return Item(
        "“At the interface neither loss nor generation of energy occurs”: load on the interface", "abstract", values,
        remark="Over the work of the load.",
    )  # fmt: skip


ENTRY = Entry(
    "3-figure-7",
    "3",
    "Figure 7: a load on the interface",
    "A short vertical load presses on the surface of a half-space, the left part of which is a grid and the right part "
    "automata. It stands exactly on the line where they meet. Waves of all kinds run to both sides.",
    compute,
    weight=30.0,
    runs=2,
)
