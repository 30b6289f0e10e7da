"""Section 3.1, figure 3: the chain's wave against the continuum's (2.7)."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .. import measurement
from .cases import DIAMETER, SATISFACTORY, case, grain
from .velocity_curves import MICRO
from .wave_count import waves

# The paper judges the agreement by eye, within this time of the crest.
_NEAR = 1e-5


def compute(context: Context) -> Findings:
    """Strain between grains 60 and 61 over time, and (2.7) with the speed that the wave has."""
    chain = case(context, "3.1-two-grains")
    behind = grain(context, 61)
    wave = waves(chain, behind)[0]
    crest = measurement.overlap_of(chain, wave)
    speed = wave.speed / theory.contact_speed(context.constants["A"], DIAMETER)
    time = chain.time - crest.time
    own = np.abs(time) < 3.2e-5
    strain = chain.overlap[own, behind] / DIAMETER
    continuum = theory.strain_wave(time[own] * wave.speed / DIAMETER, speed)
    humps = theory.solitary_strain(time[own] * wave.speed / DIAMETER, speed)
    height = crest.height / DIAMETER
    items = [
        _agreement(time[own], strain, humps, height),
        _crest(height, theory.largest_strain(speed)),
        _width(crest.duration, wave.speed),
    ]
    return Findings(items, [_figure(time[own], strain, continuum)])


def _agreement(time: np.ndarray, strain: np.ndarray, continuum: np.ndarray, height: float) -> Item:
    near = np.abs(time) <= _NEAR
    gap = 100.0 * np.abs(np.maximum(strain, 0.0) - continuum) / height
    return Item(
        "The continuum’s wave agrees with the chain’s for |t| ≤ 10 µs", "section 3.1, figure 3",
        [
            Value(
                "largest difference, |t| ≤ 10 µs", "satisfactory", float(gap[near].max()), "%", paper=0.0, loose=SATISFACTORY,
                digits=2,
            ),
            Value("largest difference, beyond", None, float(gap[~near].max()), "%", digits=2),
        ],
        remark="Of the crest’s strain. Beyond, (2.7) is periodic, which the wave is not; the figure given is against one of "
        "its humps.",
        reason=f"The paper’s “satisfactory” has no number; here and in section 2 it is read as {SATISFACTORY:g} %.",
    )  # fmt: skip


def _crest(ours: float, continuum: float) -> Item:
    return Item(
        "Strain at the crest", "figure 3, (2.7)", [Value("continuum / chain", None, continuum / ours), Value("ξm", None, ours)],
        remark="(2.7) with the speed that the chain’s wave has, as in the paper.",
    )  # fmt: skip


def _width(duration: float, speed: float) -> Item:
    width = duration * speed / DIAMETER
    return Item(
        "Full width at half height", "figure 3, (2.7)",
        [Value("chain", None, width, "a", digits=5), Value("continuum", None, theory.HALF_WIDTH, "a")],
        remark=f"The chain’s wave is {100.0 * (1.0 - width / theory.HALF_WIDTH):.1f} % narrower.",
    )  # fmt: skip


def _figure(time: np.ndarray, strain: np.ndarray, continuum: np.ndarray) -> Figure:
    return Figure(
        "figure-3", "Figure 3: strain δ/2R between grains 60 and 61",
        "The wave of the chain and the continuum’s (2.7) at the same speed.",
        Axis("time from the crest, µs"), Axis("δ / 2R, 10⁻³", low=0.0),
        [
            Curve("chain (curve 1)", time * MICRO, np.maximum(strain, 0.0) * 1e3, "line", 0),
            Curve("(2.7) (curve 2)", time * MICRO, continuum * 1e3, "dashed", 1),
        ],
    )  # fmt: skip


ENTRY = Entry(
    "3.1-figure-3",
    "3.1",
    "The solitary wave against the continuum",
    "The strain between two grains as the taller wave passes, beside the cos⁴ wave of the long-wave equation with the same "
    "speed.",
    compute,
)
