"""Section 2: from the chain to the long-wave equations

Small motions of a compressed chain obey (2.2), and long waves among them (2.3), which leads to the Korteweg-de Vries equation.
For large strains only the long-wave equation (2.4) holds.
"""

import math

import numpy as np

from granular_env.components.chain import theory
from pages import Page, show

# Neighbours for derivatives, in diameters; small parameter of the waves, halved three times.
PLACES = np.arange(-1.0, 2.0)
SMALL = 0.1 / 2.0 ** np.arange(4)


def polynomial_acceleration(*coefficients: float) -> float:
    """Return (2.2) at x = 0 with A = δ0 = R = 1 and c0² = 6 for a polynomial displacement u(x)."""
    return float(theory.anharmonic_acceleration(np.polynomial.Polynomial(coefficients)(2.0 * PLACES), 1.0, 1.0)[0])


def derivatives(size: float, length: float, rest: float) -> np.ndarray:
    """Return u_x to u_xxxx of u = -rest x + size length sin(x/length + 1) at x = 0."""
    phase = np.array([math.cos(1.0), -math.sin(1.0), -math.cos(1.0), math.sin(1.0)])
    return size * phase / length ** np.arange(4.0) - np.array([rest, 0.0, 0.0, 0.0])


def anharmonic_error(small: float) -> float:
    """Return the relative error of (2.2) against (2.1) for an approach of neighbours of `small` times δ0."""
    shape = small * np.array([0.0, 1.0, -0.6])
    return float(
        np.abs(theory.anharmonic_acceleration(shape, 1.0, 1.0) / theory.lattice_acceleration(shape, 1.0, 1.0) - 1.0).max()
    )


def long_wave_error(small: float) -> float:
    """Return the relative error of (2.4) against (2.1) for strains that vary by half over a length of a / small."""
    displacement = -PLACES + 0.5 / small * np.sin(PLACES * small + 1.0)
    ours = theory.nesterenko_acceleration(derivatives(0.5, 1.0 / small, 1.0), 1.0, 1.0)
    return float(np.abs(ours / theory.lattice_acceleration(displacement, 1.0, 0.0)[0] - 1.0).max())


def reduction_error(small: float) -> float:
    """Return the relative error of (2.3) against (2.4) for a strain of small² ξ0 over a length of a / small."""
    weak = derivatives(small**2, 1.0 / small, 0.0)
    whole = theory.nesterenko_acceleration(weak - np.array([1.0, 0.0, 0.0, 0.0]), 1.0, 1.0)
    return float(np.abs(theory.long_wave_acceleration(weak, 1.0, 1.0, 1.0) / whole - 1.0).max())


def main(page: Page) -> None:
    """Compute the printed coefficients, the order of the terms neglected in each equation, and the soliton limit."""
    # The coefficients are identities, up to finite-difference errors.
    size, identity = 1e-3, 1e-6
    up, down = (theory.lattice_acceleration(sign * np.array([0.0, 0.0, size]), 1.0, 1.0)[0] for sign in (1.0, -1.0))
    page.add_heading("Coefficients of (2.2), from the forces of (2.1) by central differences")
    page.compare("α / A δ0^(1/2)", "3/2", (up - down) / (2.0 * size), near=1.5, within=identity)
    page.compare("β / A δ0^(-1/2)", "3/8", -(up + down) / (2.0 * size**2), near=0.375, within=identity)
    page.add_heading("Coefficients of (2.3), from (2.2) on polynomials")
    bulk = polynomial_acceleration(0.0, 0.0, 0.5)
    page.compare("c0² / A δ0^(1/2) R²", "6", bulk, within=identity)
    page.compare(
        "γ / c0 R²", "1/6", polynomial_acceleration(0.0, 0.0, 0.0, 0.0, 1.0 / 24.0) / 12.0, near=1.0 / 6.0, within=identity
    )
    page.compare("ε δ0 / c0² R", "1", (bulk - polynomial_acceleration(0.0, 1.0, 0.5)) / 6.0, within=identity)

    page.add_heading("Order of the neglected terms")
    errors = {}
    for name, error, order in (("(2.2) of (2.1)", anharmonic_error, 2), ("(2.4) of (2.1)", long_wave_error, 4),
                               ("(2.3) of (2.4)", reduction_error, 4)):  # fmt: skip
        errors[name] = np.array([error(small) for small in SMALL])
        slopes = np.log2(errors[name][:-1] / errors[name][1:])
        page.compare(name, str(order), float(2.0 * slopes[2] - slopes[1]), near=order, within=0.05)
    page.text("""Errors are relative to the first term: in (2.2) for an approach of neighbours much smaller than δ0, in (2.4)
        for waves much longer than a grain, and in (2.3) for weak long waves of a compressed chain.""")

    page.add_heading("Near y1 the solitary wave is that of the Korteweg-de Vries equation")
    found = {}
    for rise in (0.1, 0.01, 0.001):
        speed = (theory.korteweg_de_vries_speed_ratio(rise) - 1.0) / (theory.speed_ratio(1.0 + rise) - 1.0) - 1.0
        wave = theory.solitary_wave(theory.c3_from_ratio(1.0 + rise))
        shape = (wave.strain_ratio - 1.0) / rise - theory.korteweg_de_vries_shape(wave.position, rise)
        found[rise] = np.array([abs(float(speed)), float(np.abs(shape).max())])
    falls = (found[0.01] < 0.2 * found[0.1]).all() and (found[0.001] < 0.2 * found[0.01]).all()
    page.compare("as y tends to y1", "coincides", "coincides" if falls else "differs")
    page.add_value("difference of V/c0 - 1 at ξm/ξ0 = 1.01", 100.0 * found[0.01][0], "%", found="0.125")
    page.add_value("difference of the shape at ξm/ξ0 = 1.01", 100.0 * found[0.01][1], "%", found="0.195")

    with page.plot("Errors of the approximations: straight lines of slopes 2, 4 and 4.", "smallness", "relative error") as axes:
        for name, values in errors.items():
            axes.loglog(SMALL, values, "o-", label=name)


if __name__ == "__main__":
    show(main)
