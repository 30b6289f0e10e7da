"""Section 2, its beginning: the equations (2.2) to (2.4), held against the chain's own (2.1) and against each other."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

# Neighbours from which the derivatives of a smooth displacement are taken, as multiples of the diameter.
_PLACES = np.arange(-1.0, 2.0)
_IDENTITY = "an identity"
_WHOLE = "an order is a whole number"
# Smallness of the waves for the orders: each half of the one before.
_SMALL = 0.1 / 2.0 ** np.arange(4)

Term = Callable[[np.ndarray], np.ndarray]


def compute(context: Context) -> Findings:
    """Compute the coefficients as printed, what each equation leaves out, and the soliton that all lead to."""
    errors = {"(2.2)": _anharmonic_errors(), "(2.4)": _long_wave_errors(), "(2.3) from (2.4)": _reduction_errors()}
    items = [_coefficients(), _long_wave_coefficients(), *_orders(errors), _korteweg_de_vries()]
    return Findings(items, [_figure(errors)])


# -- coefficients --------------------------------------------------------------------------------------------------------


def _coefficients() -> Item:
    """Compute alpha and beta of (2.2) as derivatives of (2.1), of its linear and of its quadratic part."""
    size = 1e-3
    up, down = (theory.lattice_acceleration(sign * np.array([0.0, 0.0, size]), 1.0, 1.0)[0] for sign in (1.0, -1.0))
    # alpha u - beta u^2 for a displacement u of the right neighbour alone, with cubic terms that the sums leave out.
    return Item(
        "Coefficients of the anharmonic approximation", "(2.2)",
        [
            Value("α / A δ0^(1/2)", "3/2", (up - down) / (2.0 * size), paper=1.5, tolerance=1e-6, source=_IDENTITY),
            Value("β / A δ0^(−1/2)", "3/8", -(up + down) / (2.0 * size**2), paper=0.375, tolerance=1e-6, source=_IDENTITY),
        ],
        remark="From the forces of (2.1), by central differences.",
    )  # fmt: skip


def _long_wave_coefficients() -> Item:
    """c0, gamma and epsilon of (2.3) from (2.2) on polynomials, whose derivatives are known."""
    found = {
        "c0² / A δ0^(1/2) R²": (_on_polynomial([0.0, 0.0, 0.5]), 6.0),
        "γ / c0 R²": (_on_polynomial([0.0, 0.0, 0.0, 0.0, 1.0 / 24.0]) / (2.0 * 6.0), 1.0 / 6.0),
        "ε δ0 / c0² R": ((_on_polynomial([0.0, 0.0, 0.5]) - _on_polynomial([0.0, 1.0, 0.5])) / 6.0, 1.0),
    }
    printed = ("6", "1/6", "1")
    return Item(
        "Coefficients of the long-wave equation", "(2.3)",
        [
            Value(label, said, value, paper=paper, tolerance=1e-6, source=_IDENTITY)
            for (label, (value, paper)), said in zip(found.items(), printed, strict=True)
        ],
        remark="From (2.2), which is (2.1) to second order, on displacements that are polynomials of x.",
    )  # fmt: skip


def _on_polynomial(coefficients: list[float]) -> float:
    """(2.2) at x = 0 with A = delta0 = R = 1 and c0^2 = 6, on a polynomial u(x); grains are 2R apart."""
    displacement = np.polynomial.Polynomial(coefficients)(2.0 * _PLACES)
    return float(theory.anharmonic_acceleration(displacement, 1.0, 1.0)[0])


# -- what is left out ----------------------------------------------------------------------------------------------------


def _anharmonic_errors() -> np.ndarray:
    """(2.2) against (2.1), over the first term, for neighbours that approach by a small part of delta0."""
    shape = np.array([0.0, 1.0, -0.6])
    return np.array([
        _off(theory.anharmonic_acceleration(size * shape, 1.0, 1.0), theory.lattice_acceleration(size * shape, 1.0, 1.0))
        for size in _SMALL
    ])  # fmt: skip


def _derivatives(size: float, length: float, rest: float) -> np.ndarray:
    """u_x ... u_xxxx of u = -rest x + size length sin(x/length + 1) at x = 0."""
    phase = np.array([math.cos(1.0), -math.sin(1.0), -math.cos(1.0), math.sin(1.0)])
    return size * phase / length ** np.arange(4.0) - np.array([rest, 0.0, 0.0, 0.0])


def _long_wave_errors() -> np.ndarray:
    """(2.4) against (2.1) with strains that vary by half, for waves longer and longer than a grain; smallness is a/L."""
    found = []
    for small in _SMALL:
        length = 1.0 / small
        displacement = -_PLACES + 0.5 * length * np.sin(_PLACES / length + 1.0)
        ours = theory.nesterenko_acceleration(_derivatives(0.5, length, 1.0), 1.0, 1.0)
        found.append(_off(ours, theory.lattice_acceleration(displacement, 1.0, 0.0)[0]))
    return np.array(found)


def _reduction_errors() -> np.ndarray:
    """(2.3) against (2.4) for weak long waves: a strain of e^2 times that at rest over a length of a/e."""
    found = []
    for small in _SMALL:
        weak = _derivatives(small**2, 1.0 / small, 0.0)
        whole = weak - np.array([1.0, 0.0, 0.0, 0.0])
        found.append(_off(theory.long_wave_acceleration(weak, 1.0, 1.0, 1.0), theory.nesterenko_acceleration(whole, 1.0, 1.0)))
    return np.array(found)


def _off(ours: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(np.asarray(ours) / np.asarray(exact) - 1.0).max())


def _order(errors: np.ndarray) -> float:
    """Return how fast the error falls: the power of the smallness, extrapolated from the last three to none."""
    slopes = np.log2(errors[:-1] / errors[1:])
    return float(2.0 * slopes[2] - slopes[1])


def _orders(errors: dict[str, np.ndarray]) -> list[Item]:
    said = {
        "(2.2)": (
            "What (2.2) leaves out", "2",
            "Over the first term, for |u_(i−1) − u_i|/δ0 towards 0: (2.2) keeps the linear and the quadratic term.",
        ),
        "(2.4)": (
            "What (2.4) leaves out", "4",
            "Over the first term, for a/L towards 0, with strains that vary by half: no weak wave is needed.",
        ),
        "(2.3) from (2.4)": (
            "(2.4) reduces to (2.3) under precompression", "4",
            "Over the first term, for strains of e² ξ0 over lengths of a/e, e towards 0: both terms beyond the linear wave "
            "equation are of order e², and they agree.",
        ),
    }  # fmt: skip
    return [
        Item(
            name, "section 2, (2.1) to (2.4)",
            [Value("its order", order, _order(errors[which]), paper=float(order), tolerance=0.05, source=_WHOLE, digits=2)],
            remark=remark,
        )
        for which, (name, order, remark) in said.items()
    ]  # fmt: skip


# -- Korteweg and de Vries -------------------------------------------------------------------------------------------------


def _soliton_differences(rise: float) -> tuple[float, float]:
    """Return how (2.4)'s solitary wave differs from the KdV soliton of its rise: in V/c0 - 1 and in shape, both relative."""
    ratio = 1.0 + rise
    speed = (theory.korteweg_de_vries_speed_ratio(rise) - 1.0) / (theory.speed_ratio(ratio) - 1.0) - 1.0
    wave = theory.solitary_wave(theory.c3_of_ratio(ratio))
    shape = (wave.strain_ratio - 1.0) / rise - theory.korteweg_de_vries_shape(wave.position, rise)
    return abs(float(speed)), float(np.abs(shape).max())


def _korteweg_de_vries() -> Item:
    rises = (0.1, 0.01, 0.001)
    found = [_soliton_differences(rise) for rise in rises]
    falls = all(
        later < 0.2 * before for pair in zip(found, found[1:], strict=False) for before, later in zip(*pair, strict=True)
    )
    listed = "; ".join(
        f"{100.0 * speed:.2g} % and {100.0 * shape:.2g} % at {rise:g}"
        for rise, (speed, shape) in zip(rises, found, strict=True)
    )
    return Item(
        "Near y1 the solitary wave is the Korteweg-de Vries equation’s", "section 2",
        [
            Value("as y tends to y1", "coincides", "coincides" if falls else "differs"),
            Value("of V/c0 − 1, at ξm/ξ0 = 1.01", None, 100.0 * found[1][0], "%", digits=3),
            Value("of the shape, at ξm/ξ0 = 1.01", None, 100.0 * found[1][1], "%", digits=3),
        ],
        remark=f"Differences, of V/c0 − 1 and of the shape over its height, for ξm/ξ0 − 1: {listed}. They fall in proportion.",
    )  # fmt: skip


def _figure(errors: dict[str, np.ndarray]) -> Figure:
    steps = np.log10(_SMALL)
    curves = [
        Curve(name, steps, np.log10(found), "line", colour) for colour, (name, found) in enumerate(errors.items())
    ]  # fmt: skip
    return Figure(
        "figure-orders", "What the approximations leave out",
        "Relative errors against the smallness of each: the approach over δ0 for (2.2), a/L for (2.4), and e for (2.3) with "
        "strains of e² over lengths of a/e. Straight lines are powers: 2, 4 and 4.",
        Axis("smallness", names=[(math.log10(0.1 / 2**i), f"{0.1 / 2**i:.3g}") for i in range(4)]),
        Axis("relative error", names=[(-float(i), f"1e−{i}") for i in range(2, 11, 2)]), curves,
    )  # fmt: skip


ENTRY = Entry(
    "2-equations",
    "2",
    "From the chain to the long-wave equations",
    "Small changes of a pressed chain obey (2.2), and long ones among them (2.3), which leads to Korteweg and de Vries. Where "
    "changes are large there is only the long-wave equation (2.4).",
    compute,
    weight=0.1,
    runs=0,
)
