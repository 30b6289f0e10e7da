"""Validity of Hertz's static law in a dynamic chain: numbers of a run for the assumptions of Nesterenko 1983, section 1.

1. The pressure in the middle of a contact stays below the elastic limit. 2. The contact radius is small compared with that of
the grain: a << R. 3. Collisions last much longer than the grain's own oscillation: tau >> T = 2.5 R / c1, c1 the sound speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from .geometry import FloatArray, Geometry
from .laws.law import YIELD_PRESSURE, Law
from .theory.collisions import duration_from_overlap, duration_times_frequency

_PRESSURE = "peak contact pressure [Pa]"
_PRESSURE_TO_YIELD = "peak pressure / pressure at first yield"
_CONTACT_RADIUS = "contact radius / grain radius"
_TIME_SCALE = "collision time / grain's oscillation time (tau/T)"
_FORCES = "force evaluations in the shortest contact"
# Limits of the cautions: a/R at which Hertz's parabola is wrong by about 1 %, and ten oscillations of a grain.
_SMALL_CONTACT = 0.1
_SLOW_CONTACT = 10.0


def validity_figures(chain: Geometry, law: Law, peak: FloatArray, force_rate: float) -> dict[str, float]:
    """Return numbers that show the validity of a run: name with unit -> value; NaN if unknown or if no contact has closed.

    Only spheres have a pressure and a contact radius; the pressure of plastic spheres does not exceed the yield pressure.
    `peak` is the largest overlap of each contact, shape (contacts,) [m]; `force_rate` counts force evaluations per second.
    """
    figures: dict[str, float] = dict.fromkeys((_PRESSURE, _PRESSURE_TO_YIELD, _CONTACT_RADIUS, _TIME_SCALE, _FORCES), math.nan)
    real = chain.contact_slice.start + np.flatnonzero(peak > 0.0)
    if not len(real):
        return figures
    peak = peak[peak > 0.0]
    duration = _collision_durations(chain.reduced_mass[real], chain.largest_stiffness[real], peak, law.exponent)
    figures[_TIME_SCALE] = float((duration / _oscillation_periods(chain)[real]).min())
    figures[_FORCES] = float(duration.min() * force_rate)
    if law.exponent == 1.5:
        stiffness, radius = chain.stiffness[real], chain.reduced_radius[real]
        # The pressure in the middle, 3F / (2 pi a^2), with F = k d^1.5 and a^2 = R* d.
        pressure = 1.5 / math.pi * stiffness * np.sqrt(peak) / radius
        by_law = law.yield_pressures(stiffness, radius, chain.law_constants[real])
        limit = YIELD_PRESSURE * chain.yield_strength[real] if by_law is None else by_law
        figures[_PRESSURE] = float((pressure if by_law is None else np.minimum(pressure, by_law)).max())
        figures[_PRESSURE_TO_YIELD] = float((pressure / limit).max())
        figures[_CONTACT_RADIUS] = float((np.sqrt(radius * peak) / chain.smaller_radius[real]).max())
    return figures


def validity_cautions(figures: Mapping[str, float], law: Law, minimum_evaluations: float) -> list[str]:
    """Return a sentence for every assumption that the numbers of `validity_figures` violate."""
    said = []
    if figures[_PRESSURE_TO_YIELD] > 1.0 and type(law).yield_pressures is Law.yield_pressures:
        said.append(
            f"the contact pressure reached {figures[_PRESSURE]:.3g} Pa, {figures[_PRESSURE_TO_YIELD]:.2g} times the pressure "
            "at first yield: real grains would deform plastically"
        )
    if figures[_CONTACT_RADIUS] > _SMALL_CONTACT:
        said.append(
            f"contact radii reached {figures[_CONTACT_RADIUS]:.2g} of the grain radius "
            f"(Hertz's law requires less than {_SMALL_CONTACT:g})"
        )
    if figures[_TIME_SCALE] < _SLOW_CONTACT:
        said.append(
            f"collisions last {figures[_TIME_SCALE]:.2g} oscillations of a grain "
            f"(a static contact law requires more than {_SLOW_CONTACT:g})"
        )
    if figures[_FORCES] < minimum_evaluations:
        said.append(
            f"a contact got {figures[_FORCES]:.0f} force evaluations ({minimum_evaluations:.0f} are required): "
            "take a smaller step_size"
        )
    return said


def _collision_durations(reduced_mass: FloatArray, stiffness: FloatArray, overlap: FloatArray, exponent: float) -> FloatArray:
    """Return the durations of collisions with these largest overlaps, ignoring the loss, shape (contacts,) [s]."""
    if exponent == 1.5:
        return np.asarray(duration_from_overlap(reduced_mass, stiffness, overlap))
    return duration_times_frequency(exponent) / np.sqrt(exponent * stiffness * overlap ** (exponent - 1.0) / reduced_mass)


def _oscillation_periods(chain: Geometry) -> FloatArray:
    """Return T = 2.5 R / c1 of the slower side of each contact; a wall counts as the adjacent grain [s]."""
    periods = np.pad(2.5 * chain.radius / chain.sound_speed, 1, mode="edge")
    return np.maximum(periods[:-1], periods[1:])
