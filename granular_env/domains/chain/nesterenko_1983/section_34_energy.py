"""Section 3.4: how energy is shared between motion and contacts."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .. import measurement
from ..measurement import History
from .cases import SPEED, UNCHANGED, case, longer
from .section_34_piston import piston
from .velocity_curves import MICRO, TIME
from .wave_count import CLEAR, FAINT

# The paper's window begins where its ratio has settled; what later ones would give is told too.
_SETTLED = 3e-5
_WINDOWS = (_SETTLED, 1e-4, 2e-4, 4e-4)
# The paper's ratio, and the deviations from it that it names.
_RATIO, _DEVIATION = 1.249, 0.008

# While waves run freely: after they have formed, before they meet or leave [s].
_OTHERS = {
    "3.1": ("3.1-two-grains", 1e-4, 5e-4),
    "3.2 A": ("3.2a-head-on", 1e-4, 2.6e-4),
    "3.2 B": ("3.2b-overtaking", 2e-4, 7e-4),
}


def compute(context: Context) -> Findings:
    """Ek/Ep in the piston's chain and in the others."""
    chain = piston(context)
    end = min(longer(context, 1.0e-3), float(chain.time[-1]))
    ratio = _ratio(chain)
    items = [_mean(context, chain, end), _deviation(context, chain, end), _moving(chain), _virial(), _others(context)]
    return Findings(items, [_figure(chain, ratio, end)])


def _ratio(chain: History) -> np.ndarray:
    stored = measurement.potential_energy(chain)
    return np.divide(measurement.kinetic_energy(chain), stored, out=np.full_like(stored, np.nan), where=stored > 0.0)


def _windows(context: Context, chain: History, end: float) -> dict[float, measurement.EnergyRatio]:
    """Return windows from their beginnings, as with the paper's constants, to the end."""
    return {begin: measurement.energy_ratio(chain, longer(context, begin), end) for begin in _WINDOWS}


def _mean(context: Context, chain: History, end: float) -> Item:
    found = _windows(context, chain, end)
    begin = longer(context, _SETTLED)
    settled = measurement.energy_ratio(chain, begin, begin).mean
    without = measurement.energy_ratio(chain, begin, end, piston=False)
    listed = ", ".join(f"{window.mean:.4f} from {begin * MICRO:g} µs" for begin, window in found.items())
    return Item(
        "Ek/Ep in the piston’s chain", "section 3.4",
        [
            Value("mean", "1.249", found[_SETTLED].mean, loose=_DEVIATION * _RATIO),
            Value("at 3e-5 s, where it settles", "1.249", settled, loose=_DEVIATION * _RATIO, digits=4),
            Value("mean, without the piston’s own", None, without.mean),
        ],
        remark="From 30 µs, as in the paper, until the front reaches the end, with the piston’s own energy. Other windows: "
        f"{listed}.",
        reason="It still swings at 30 µs and then falls slowly, so that its mean hangs on the window, whose end the paper does "
        "not give. The mean lies within the 0.8 % by which the paper lets the ratio deviate, the ratio at 30 µs does not.",
    )  # fmt: skip


def _farthest(chain: History, begin: float, end: float, centre: float) -> float:
    """Return the largest deviation of Ek/Ep from a number, as a part of it; between frames, where it is largest."""
    own = chain.window(begin, end)
    ratio = _ratio(chain)[own]
    highest = max(crest.height for crest in measurement.crests(chain.time[own], ratio, 1.0))
    return max(highest - centre, centre - float(ratio.min())) / centre


def _deviation(context: Context, chain: History, end: float) -> Item:
    found = {
        begin: 100.0 * _farthest(chain, longer(context, begin), end, window.mean)
        for begin, window in _windows(context, chain, end).items()
    }
    farthest = _farthest(chain, longer(context, _SETTLED), end, _RATIO)
    listed = ", ".join(f"{found[begin]:.2g} % from {begin * MICRO:g} µs" for begin in _WINDOWS[1:])
    return Item(
        "Largest deviation of Ek/Ep in the piston’s chain", "section 3.4",
        [
            Value("from 1.249", "at most 0.8", 100.0 * farthest, "%", paper=0.8, at_most=True, digits=2),
            Value("from our own mean", None, found[_SETTLED], "%", digits=2),
        ],
        remark=f"From 30 µs on. From the means of later windows: {listed}.",
        reason="The ratio still falls and swings with each grain that the front takes in; no window that begins by "
        f"{max(_WINDOWS) * MICRO:g} µs keeps to 0.8 %. The paper does not say which energies it counts, nor how often it "
        "looked.",
    )  # fmt: skip


def _moving(chain: History) -> Item:
    velocity = chain.velocity[chain.frame(_SETTLED)]
    return Item(
        "Grains that move when the ratio has settled, at 3e-5 s", "section 3.4",
        [
            Value(f"faster than {100.0 * least:.0f} % of v0", "6", int(np.count_nonzero(velocity > least * SPEED)))
            for least in (CLEAR, FAINT)
        ],
        remark="The piston included.",
        reason="The velocities in front of the wave fall very fast and are never zero: one grain more or less hangs on the "
        "least one that counts.",
    )  # fmt: skip


def _virial() -> Item:
    wave = theory.lattice_wave(0.0)
    return Item(
        "Ek/Ep by the virial theorem", "section 3.4",
        [
            Value("mean energies", "1.25", wave.kinetic_energy / wave.potential_energy),
            Value("mean ratio", None, wave.energy_ratio),
        ],
        remark="Of a solitary wave of the chain: exactly 5/4 for the means over time; the mean of the ratio is a little "
        "higher.",
    )  # fmt: skip


def _others(context: Context) -> Item:
    values = []
    for name, (shipped, begin, end) in _OTHERS.items():
        chain = case(context, shipped)
        own = longer(context, begin), longer(context, end)
        ratio = measurement.energy_ratio(chain, *own).mean
        values.append(Value(name, "similar", ratio, paper=_RATIO, loose=0.01 * UNCHANGED * _RATIO, digits=4))
        if name != "3.2 A":
            values.append(Value(f"{name}, of the waves alone", None, _in_waves(chain, *own), digits=4))
    return Item(
        "The same in cases 3.1 and 3.2", "section 3.4", values,
        remark="While solitary waves are under way. What is more belongs to grains that have bounced back and move alone, with "
        "nothing stored.",
        reason=f"“Similar” has no number; {UNCHANGED:g} % is our reading.",
    )  # fmt: skip


def _in_waves(chain: History, begin: float, end: float) -> float:
    """Kinetic over potential energy of the solitary waves that run to the right, in the mean over some twenty moments."""
    kinetic = potential = 0.0
    for time in np.linspace(begin, end, 21):
        for wave in measurement.waves_along(chain, float(time), 0.1 * SPEED):
            kinetic, potential = kinetic + wave.kinetic_energy, potential + wave.potential_energy
    return kinetic / potential


def _figure(chain: History, ratio: np.ndarray, end: float) -> Figure:
    own = (chain.time > 1e-5) & (chain.time <= end)
    return Figure(
        "figure-energy", "Kinetic over potential energy in the piston’s chain",
        "It settles near the virial theorem’s 5/4 while only a few grains move, and swings with every grain that the front "
        "takes in. Dotted: the paper’s mean, and its 0.8 % to either side.",
        Axis(TIME, low=0.0), Axis("Ek / Ep", low=1.2, high=1.32), [Curve("Ek / Ep", chain.time[own] * MICRO, ratio[own])],
        [Mark("1.249", y=1.249), Mark("", y=1.249 * 1.008), Mark("", y=1.249 * 0.992)],
    )  # fmt: skip


ENTRY = Entry(
    "3.4-energy",
    "3.4",
    "How energy is shared",
    "The kinetic energy of all grains over the energy stored in all contacts. The virial theorem gives 5/4 for Hertz’s law, "
    "in the mean over a long time.",
    compute,
    weight=0.2,
    runs=4,
)
