"""Collisions of two grains: duration, overlap, loss; and a pulse as a sequence of collisions. SI units.

The numbers in brackets are the equations of Nesterenko (1983). Durations and overlaps are exact for Hertz's static law.

Restitution: without loss the approach speed at overlap d is v sqrt(1 - x^2.5), x = d/d_m, 4k d_m^2.5 = 5 m* v^2. The work of
the dissipative force along this motion, there and back, is the loss m* v^2 (1 - e^2)/2, and 1 - e^2 = 2 (1 - e) to leading
order.

Tapers: binary collisions are exact if there are gaps between the grains. In a touching chain the pulse is five grains wide, and
the law is the limit of small tapers: in runs of the chain the settled ratio of successive peaks differs by -0.03 % at q = 0.02,
-0.35 % at 0.05, -2.5 % at 0.1, -0.05 % at -0.05 (growing grains).
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np

from ...support.float_arrays import FloatArray

# A number or an array of numbers, which broadcast.
Number: TypeAlias = Any

# T1 (paper: 2.94) in units of (5 m* / 4 k)^(2/5) v^(-1/5): 2 sqrt(pi) Gamma(7/5) / Gamma(9/10).
COLLISION_COEFFICIENT = 2.943275184324706


def collision_duration(reduced_mass: Number, stiffness: Number, speed: Number) -> Number:
    """Return the contact time T1 of two spheres that meet at `speed`: 2.943 (5 m*/4k)^(2/5) v^(-1/5) [s].

    Between equal spheres m*/k = 1/(2A), so that it is the paper's T1 = 2.94 (5/8A)^(2/5) / v0^(1/5) (section 3).

    Args:
        reduced_mass: 1/(1/m1 + 1/m2) [kg].
        stiffness: k of F = k d^1.5 [N/m^1.5].
        speed: relative speed at first touch [m/s].
    """
    return COLLISION_COEFFICIENT * (1.25 * reduced_mass / stiffness) ** 0.4 * speed**-0.2


def collision_overlap(reduced_mass: Number, stiffness: Number, speed: Number) -> Number:
    """Return the largest overlap of two spheres that meet at `speed`: (5 m* v^2 / 4k)^(2/5) [m]."""
    return (1.25 * reduced_mass * speed**2 / stiffness) ** 0.4


def duration_from_overlap(reduced_mass: Number, stiffness: Number, overlap: Number) -> Number:
    """Return the contact time T1 [s] of a collision with this largest overlap: the formulas above with v eliminated."""
    # No power function, because the report of a run must be bitwise the same on every machine.
    return COLLISION_COEFFICIENT * np.sqrt(1.25 * reduced_mass / (stiffness * np.sqrt(overlap)))


def duration_times_frequency(exponent: float) -> float:
    """Return the duration of a collision x its largest angular frequency, for F = k d^p: 4.03 for spheres, pi for springs.

    With D the largest overlap, v^2 = 2 k D^(p + 1) / ((p + 1) m*), the duration is (2 D / v) sqrt(pi) Gamma(1 + 1/(p + 1)) /
    Gamma(1/2 + 1/(p + 1)) and the frequency sqrt(p k D^(p - 1) / m*).
    """
    part = 1.0 / (exponent + 1.0)
    duration = 2.0 * math.sqrt(math.pi) * math.gamma(1.0 + part) / math.gamma(0.5 + part)
    return duration * math.sqrt(0.5 * exponent * (exponent + 1.0))


# Factors of the losses below: 0.8 B(3/5, 3/2) (5/4)^(3/5) and 0.8 B(2/5, 3/2) (5/4)^(2/5), B the beta function.
KUWABARA_KONO_COEFFICIENT = 0.8 * math.gamma(0.6) * math.gamma(1.5) / math.gamma(2.1) * 1.25**0.6
VISCOUS_COEFFICIENT = 0.8 * math.gamma(0.4) * math.gamma(1.5) / math.gamma(1.9) * 1.25**0.4


def kuwabara_kono_loss(reduced_mass: Number, stiffness: Number, damping: Number, speed: Number) -> Number:
    """Return the loss 1 - e for F = k d^1.5 + gamma d^0.5 d': 1.1534 (gamma/m*)(m*/k)^(3/5) v^(1/5).

    The work is 2 gamma v d_m^1.5 int x^0.5 sqrt(1 - x^2.5) dx = 0.8 B(3/5, 3/2) gamma v d_m^1.5.
    With gamma = (3/2) A k it becomes 1.15344 (3/2) A (k/m*)^(2/5) v^(1/5) (Kuwabara & Kono 1987; Ramirez et al. 1999). The next
    term is -(3/5)(1 - e)^2, so the relative error is at most 1.2 % for 1 - e up to 0.02.

    Args:
        reduced_mass: m* [kg].
        stiffness: k [N/m^1.5].
        damping: gamma [N s/m^1.5].
        speed: relative speed at first touch [m/s].
    """
    return KUWABARA_KONO_COEFFICIENT * damping / reduced_mass * (reduced_mass / stiffness) ** 0.6 * speed**0.2


def viscous_loss(reduced_mass: Number, stiffness: Number, damping: Number, speed: Number) -> Number:
    """Return the loss 1 - e for F = k d^1.5 + g d': 1.7878 (g/m*)(m*/k)^(2/5) v^(-1/5).

    The work is 2 g v d_m int sqrt(1 - x^2.5) dx = 0.8 B(2/5, 3/2) g v d_m. If the force is clipped at 0 (no tension) the
    contact opens at d_c = (g v/k)^(2/3), and the loss is smaller by (3/5)(g/m* v) d_c: a correction of the relative order
    (1 - e)^(2/3). `viscous_loss_without_tension` includes it.

    Args:
        reduced_mass: m* [kg].
        stiffness: k [N/m^1.5].
        damping: g [N s/m].
        speed: relative speed at first touch [m/s].
    """
    return VISCOUS_COEFFICIENT * damping / reduced_mass * (reduced_mass / stiffness) ** 0.4 * speed**-0.2


def viscous_loss_without_tension(reduced_mass: Number, stiffness: Number, damping: Number, speed: Number) -> Number:
    """Return `viscous_loss` minus (3/5)(g/m* v)(g v/k)^(2/3), the loss that tension would cause at the end."""
    whole = viscous_loss(reduced_mass, stiffness, damping, speed)
    return whole - 0.6 * damping / (reduced_mass * speed) * (damping * speed / stiffness) ** (2.0 / 3.0)


def tapered_ratio(taper: Number) -> Number:
    """Return v_(i+1)/v_i for radii that fall by the factor 1 - q: 2/(1 + (1 - q)^3), -1 < q < 1; for q < 0 they grow."""
    return 2.0 / (1.0 + (1.0 - taper) ** 3)


def tapered_velocities(taper: float, grains: int) -> FloatArray:
    """Return each grain's velocity in units of the first, (2/(1 + (1 - q)^3))^i, shape (grains,)."""
    return tapered_ratio(taper) ** np.arange(float(grains))
