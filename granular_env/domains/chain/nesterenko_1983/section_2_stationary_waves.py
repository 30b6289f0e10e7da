"""Section 2: the continuum (2.4), its potential W(y), and its stationary waves; figure 1."""

from __future__ import annotations

import math

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .cases import SATISFACTORY

_SMALL = 1e-12
_IDENTITY = "an identity"
# Compressions r = xi_m/xi_0 at which the chain itself is compared, from weak to strong.
_RATIOS = (1.1, 1.563, 7.93, 30.0, 185.8)


def compute(context: Context) -> Findings:
    """Figure 1, the limits of C3, the wave (2.7) and what it says about shocks, and the chain's own waves beside it."""
    items = [_limit(), _sound(), _length(), _largest(), _overshoot(), _misprints(), _lattice()]
    return Findings(items, [_figure_1(), _figure_speed()])


def _limit() -> Item:
    # Extremes of W are where s^2 - s^3 = 4 C3/5, s = y^(2/5): the largest C3 is where the left side is highest.
    hill = np.polynomial.Polynomial([0.0, 0.0, 1.25, -1.25])
    root = float(hill.deriv().roots().real.max())
    return Item(
        "W(y) has two extremes up to this C3", "section 2",
        [
            Value("C3", "5/27", float(hill(root)), paper=5 / 27, tolerance=1e-12, source=_IDENTITY),
            Value("y1 there", "(2/3)^(5/2)", root**2.5, paper=(2 / 3) ** 2.5, tolerance=1e-12, source=_IDENTITY),
        ],
        remark="In the scan C3 = (5/4) C2 goes unsaid.",
    )  # fmt: skip


def _sound() -> Item:
    """V/c0 at the largest C3, from the printed V = c xi0^(1/4) y1^(-1/5), c0 = c xi0^(1/4) (3/2)^(1/2)."""
    speeds = [theory.extremes(c3).y1 ** -0.2 / 1.5**0.5 for c3 in (0.1, 4 / 27, theory.LARGEST_C3 * (1.0 - 1e-12))]
    closed = [theory.speed_ratio(theory.ratio_of_c3(c3)) for c3 in (0.1, 4 / 27)]
    worst = max(abs(a / b - 1.0) for a, b in zip(speeds[:2], closed, strict=True))
    return Item(
        "The solitary wave is faster than sound, V > c0, for C3 < 5/27", "section 2",
        [
            Value("V/c0 at 5/27", "1", speeds[2], paper=1.0, tolerance=1e-5, source=_IDENTITY),
            Value("V/c0 at 4/27", None, speeds[1]),
            Value("V/c0 at 0.1", None, speeds[0]),
        ],
        remark=f"The closed form V/c0 = √((4/15)(3 + 2 r^2.5 − 5 r))/(r − 1), r = ξm/ξ0, agrees to {worst:.0e}.",
    )  # fmt: skip


def _length() -> Item:
    period = theory.periodic_wave(0.0, 1.0).period
    return Item(
        "Length of the wave (2.7), L = (5a/√10) π", "section 2",
        [Value("L/a", "5", period)], remark="By quadrature of W. Its width at half height is "
        f"{theory.HALF_WIDTH:.4f} a; that of the chain’s own wave {theory.lattice_wave(0.0).width:.4f} a.",
    )  # fmt: skip


def _largest() -> Item:
    """xi_m of a wave at a vanishing C3, in (V/c)^4; the paper's (5/4)^2."""
    strain = theory.solitary_wave(_SMALL).strain.max()
    return Item(
        "Strain at the crest, in units of V⁴/c⁴", "section 2, from (2.7)",
        [Value("ξm c⁴/V⁴", "(5/4)^2", float(strain), paper=1.5625, tolerance=1e-5, source=_IDENTITY)],
        remark="The power in ξm = (5V²/4c²)² is misprinted, see below.",
    )  # fmt: skip


def _overshoot() -> Item:
    ratio = theory.ratio_of_c3(_SMALL) / theory.shock_ratio(_SMALL)
    return Item(
        "Front of a weakly dissipative shock over the state behind it", "section 2",
        [
            Value("ξm/ξc", "1.56", ratio), Value("pm/pc", "1.95", ratio**1.5),
            Value("the chain’s own ξm/ξc", None, theory.LATTICE_STRAIN_OVERSHOOT),
            Value("the chain’s own pm/pc", None, theory.LATTICE_PRESSURE_OVERSHOOT),
        ],
        remark="These are the continuum’s. A solitary wave of the discrete chain that is as fast as the shock is a little "
        "lower.",
    )  # fmt: skip


def _residual(power: float, stretch: float = 0.0) -> float:
    """Return the residual of (2.7) in V^2 u_xx = (2.4), V = c/2, over the largest term; lengths times (V/c)^stretch."""
    speed = 0.5
    scale = speed**stretch
    x, rate = np.linspace(-0.8, 0.8, 33) * scale, math.sqrt(10.0) / 5.0 / scale
    height, angle = (1.25 * speed**2) ** power, rate * x
    cos, sin = np.cos(angle), np.sin(angle)
    slope = -height * cos**4
    curvature = 4.0 * height * rate * cos**3 * sin
    third = 4.0 * height * rate**2 * (cos**4 - 3.0 * cos**2 * sin**2)
    fourth = 4.0 * height * rate**3 * (6.0 * cos * sin**3 - 10.0 * cos**3 * sin)
    right = theory.nesterenko_acceleration(np.array([slope, curvature, third, fourth]), 1.0, 1.0)
    left = speed**2 * curvature
    return float(np.abs(left - right).max() / np.abs(left).max())


def _misprints() -> Item:
    powers = {"1/5": 0.2, "2/5": 0.4, "1": 1.0, "2": 2.0}
    left = {name: _residual(power) for name, power in powers.items()}
    best = min(left, key=lambda name: left[name])
    stretched = {"-5/2": _residual(2.0, -2.5), "0": _residual(2.0)}
    scale = 5.0 * math.pi / theory.periodic_wave(0.0, 1.0).period
    return Item(
        "Misprints of section 2", "equations (2.6), (2.7), text",
        [
            Value("power of 5V²/4c² in (2.7)", "2/5", best),
            Value("the same in ξm", "1/5", best),
            Value("aη/x in (2.6)", "10^(1/4)", "√10" if abs(scale - 10.0**0.5) < 1e-9 else f"{scale:.4f}"),
            Value("power of V/c in x of (2.6)", "-5/2", min(stretched, key=lambda name: stretched[name])),
            Value("minimum of W, behind a shock", "y1", _minimum()),
        ],
        reason=f"Misprints. Put into (2.4), (2.7) leaves {left['2/5']:.2g} times the largest term with the printed power and "
        f"{left[best]:.0e} with {best}; the paper’s own 1.56 and L = 5a need {best} and √10. Its length does not depend on V: "
        f"with the printed factor (V/c)^(−5/2) in x, {stretched['-5/2']:.2g} of the largest term is left. W is highest at "
        "y1 and lowest at y2, which is the state behind a shock. Also misprinted: dx/dt in (1.2), (V²/c²) ξx in (2.5).",
    )  # fmt: skip


def _minimum() -> str:
    """Return the extreme of W, of the paper's two, that is a minimum."""
    low, high = theory.extremes(0.1)
    around = {name: theory.W(np.array([place - 1e-3, place, place + 1e-3]), 0.1) for name, place in (("y1", low), ("y2", high))}
    (lowest,) = [name for name, values in around.items() if values[1] < min(values[0], values[2])]
    return lowest


def _lattice() -> Item:
    worst = {r: theory.speed_ratio(r) / _discrete(r) - 1.0 for r in _RATIOS}
    largest = 100.0 * max(map(abs, worst.values()))
    listed = ", ".join(f"{100.0 * error:+.2f} % at r = {r:g}" for r, error in worst.items())
    return Item(
        "The continuum against the chain itself", "section 2, and 3.1",
        [Value("V/c0, largest difference", "satisfactory", largest, "%", paper=0.0, loose=SATISFACTORY, digits=3)],
        remark=f"The continuum’s wave is slower than the chain’s: {listed}, r = ξm/ξ0.",
        reason=f"The paper’s “satisfactory” has no number; here and in figure 3 it is read as {SATISFACTORY:g} %.",
    )  # fmt: skip


def _discrete(ratio: float) -> float:
    return theory.lattice_wave(1.0 / (ratio - 1.0)).speed_ratio


def _figure_1() -> Figure:
    y = np.linspace(0.0, 1.25, 251)
    low, high = theory.extremes(0.1)
    places = np.array([low, high])
    return Figure(
        "figure-1", "Figure 1: the potential W(y)",
        "A stationary wave moves as a particle in W. A solitary wave leaves the maximum y1, rolls through the minimum y2, "
        "and comes back; with losses it comes to rest in y2, behind a shock. The extremes are those of C3 = 0.1, as in the "
        "paper.",
        Axis("y"), Axis("W"),
        [
            Curve("C3 = 4/27 (curve 1)", y, theory.W(y, 4 / 27), "line", 0),
            Curve("C3 = 0.1 (curve 2)", y, theory.W(y, 0.1), "line", 1),
            Curve("y1 and y2", places, theory.W(places, 0.1), "points", 1),
        ],
    )  # fmt: skip


def _figure_speed() -> Figure:
    # Over log10 r: compressions of four powers of ten.
    powers = np.linspace(0.01, 2.4, 120)
    rise = 10.0 ** np.linspace(0.01, 1.0, 60)
    found = [_discrete(r) for r in _RATIOS]
    names = [(math.log10(r), f"{r:g}") for r in (1, 2, 5, 10, 20, 50, 100, 200)]
    return Figure(
        "figure-speed", "Speed of the solitary wave over that of sound",
        "Against the largest strain over that at rest. The paper’s continuum holds from weak waves, where it meets the "
        "Korteweg-de Vries equation, to an almost uncompressed chain.",
        Axis("ξm / ξ0", names=names), Axis("V / c0", low=0.95),
        [
            Curve("continuum (2.4)", powers, theory.speed_ratio(10.0**powers), "line", 0),
            Curve("Korteweg-de Vries", np.log10(rise), theory.korteweg_de_vries_speed_ratio(rise - 1.0), "dashed", 5),
            Curve("the chain itself", np.log10(_RATIOS), found, "points", 1),
        ],
    )  # fmt: skip


ENTRY = Entry(
    "2-continuum",
    "2",
    "The long-wave equation and its stationary waves",
    "For waves long against a grain the chain becomes the equation (2.4). Its stationary waves move like a particle in a "
    "potential W(y). Without precompression sound has no speed here, and yet there is a solitary wave, of a fixed length of "
    "five grains.",
    compute,
    weight=0.1,
    runs=0,
)
