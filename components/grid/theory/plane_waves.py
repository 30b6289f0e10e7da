"""Plane waves: the Rayleigh-wave ellipse, and dispersion on a square mesh."""

from __future__ import annotations

import math

from ...materials.elastic import Material, rayleigh_speed


def rayleigh_ellipse(material: Material) -> float:
    """Return the ratio of the vertical to the horizontal axis of the ellipse that a surface point describes in a Rayleigh wave.

    It is sqrt(q / s) with q = sqrt(1 - (c / c_p)^2), s = sqrt(1 - (c / c_s)^2), (1 + s^2)^2 = 4 q s, at any frequency.
    Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), section 5.11.
    """
    speed = rayleigh_speed(material)
    q, s = (math.sqrt(1.0 - (speed / body) ** 2) for body in (material.longitudinal_speed, material.shear_speed))
    return math.sqrt(q / s)


def mesh_frequencies(
    wave_vector: tuple[float, float], cell_size: float, material: Material, *, step_size: float = 0.0, hourglass: float = 1.0
) -> tuple[float, float]:
    """Return the angular frequencies of P and S waves with a given wave vector on the grid [rad/s].

    With a = k_x h / 2, b = k_y h / 2 the cell gradient has the symbol D = (2 / h)(sin a cos b, cos a sin b), and hourglass
    forces add 16 kappa (lambda + 3 mu) / 12 sin^2 a sin^2 b / h^2. Thus rho w^2 = (lambda + 2 mu) |D|^2 + hourglass for motion
    along D, and mu |D|^2 + hourglass across it. Leapfrog changes w to Omega, with sin(Omega dt / 2) = w dt / 2.

    Args:
        wave_vector: k_x and k_y [rad/m].
        cell_size: side h of the cells [m].
        material: of all cells.
        step_size: internal step [s]; 0 for exact time integration.
        hourglass: the parameter of the grid.

    Raises:
        ValueError: the step is too large for this wave.
    """
    a, b = (0.5 * k * cell_size for k in wave_vector)
    symbol = (math.sin(a) * math.cos(b)) ** 2 + (math.cos(a) * math.sin(b)) ** 2
    first, shear = material.first_lame, material.shear_modulus
    twist = 16.0 * hourglass * (first + 3.0 * shear) / 12.0 * (math.sin(a) * math.sin(b)) ** 2
    squares = [(4.0 * modulus * symbol + twist) / (material.density * cell_size**2) for modulus in (first + 2.0 * shear, shear)]
    exact = math.sqrt(squares[0]), math.sqrt(squares[1])
    if step_size == 0.0:
        return exact
    if max(exact) * step_size > 2.0:
        raise ValueError(f"step_size: got {step_size:g} s, expected at most {2.0 / max(exact):g} s for this wave")
    return 2.0 * math.asin(0.5 * exact[0] * step_size) / step_size, 2.0 * math.asin(0.5 * exact[1] * step_size) / step_size
