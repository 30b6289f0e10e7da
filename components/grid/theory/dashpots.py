"""Reflection of plane waves from dashpots of the medium's impedance: Lysmer and Kuhlemeyer (1969).

The edge has the tractions sigma_nn = -rho c_p v_n, sigma_nt = -rho c_s v_t. Of a plane wave that comes at an angle to the
normal, a P and an S wave go back, with the same slowness along the edge; past the critical angle of S the P wave clings to the
edge.
"""

from __future__ import annotations

import cmath
import math

import numpy as np

from ...materials.elastic import Material


def dashpot_reflection(material: Material, angle: float, *, shear: bool = False) -> tuple[complex, complex]:
    """Return the amplitudes of the P and the S wave that go back, over that of the plane wave that comes.

    Args:
        material: of the medium.
        angle: between the wave that comes and the normal of the edge [rad].
        shear: whether that is an S wave.
    """
    (coming, *going), _ = _waves(material, angle, shear)
    tractions = np.array([_excess_traction(material, one) for one in going]).T
    amplitudes = np.linalg.solve(tractions, -np.array(_excess_traction(material, coming)))
    return complex(amplitudes[0]), complex(amplitudes[1])


def reflected_energy(material: Material, angle: float, *, shear: bool = False) -> float:
    """Return the part of a plane wave's energy that dashpots send back; arguments as of `dashpot_reflection`."""
    _, cosines = _waves(material, angle, shear)
    coming = cosines[2 if shear else 1] * (material.shear_speed if shear else material.longitudinal_speed)
    speeds = material.longitudinal_speed, material.shear_speed
    parts = dashpot_reflection(material, angle, shear=shear)
    # Past the critical angle the P wave takes no energy away.
    return sum(
        abs(part) ** 2 * speed * cosine.real / coming.real
        for part, speed, cosine in zip(parts, speeds, cosines[1:], strict=True)
    )


def _waves(material: Material, angle: float, shear: bool):  # noqa: ANN202
    """Return (slowness, direction of motion) of the wave that comes and of the P and S waves that go, and their cosines."""
    speeds = {False: material.longitudinal_speed, True: material.shear_speed}
    along = math.sin(angle) / speeds[shear]
    sines = [along * speeds[kind] for kind in (False, True)]
    cosines = [cmath.sqrt(1.0 - sine * sine) for sine in sines]
    p = ((-cosines[0] / speeds[False], along), (-cosines[0], sines[0]))
    s = ((-cosines[1] / speeds[True], along), (sines[1], cosines[1]))
    straight = (math.cos(angle), math.sin(angle))
    motion = (-straight[1], straight[0]) if shear else straight
    coming = ((straight[0] / speeds[shear], along), motion)
    return (coming, p, s), (complex(straight[0]), *cosines)


def _excess_traction(material: Material, wave) -> tuple[complex, complex]:  # noqa: ANN001
    """Return what a wave of unit amplitude has beyond the tractions of the dashpots, per i omega: normal, tangential."""
    (sx, sy), (dx, dy) = wave
    first, shear = material.first_lame, material.shear_modulus
    normal = first * (sx * dx + sy * dy) + 2.0 * shear * sx * dx - material.density * material.longitudinal_speed * dx
    tangential = shear * (sx * dy + sy * dx) - material.density * material.shear_speed * dy
    return normal, tangential
