"""Validity of Hertz's static law in a dynamic chain: figures of a run for the assumptions of Nesterenko 1983, section 1.

1. The pressure in the middle of a contact stays below the elastic limit. 2. The contact is small against the grain: a << R.
3. What happens takes much longer than the grain's own oscillation: tau >> T = 2.5 R / c1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .geometry import FloatArray, Geometry
from .laws.law import YIELD_PRESSURE, Law
from .theory.collisions import duration_of_overlap, duration_times_frequency

# Beyond these a run is told so: a/R at which Hertz's parabola is off by about 1 %, and ten oscillations of a grain.
_SMALL_CONTACT = 0.1
_SLOW_CONTACT = 10.0


@dataclass(frozen=True)
class Validity:
    """Figures of a run so far; NaN where nothing has touched.

    Attributes:
        peak_pressure: largest pressure in the middle of a contact, 3F / (2 pi a^2) [Pa].
        pressure_to_yield: the largest ratio of Hertz's pressure to that of the softer side's yield, NaN where that is unknown.
        contact_radius_ratio: largest a/R, a = sqrt(R* d), R the smaller radius.
        time_scale_ratio: smallest tau/T, tau the duration of the collision that gives the peak overlap.
        forces_per_contact: force evaluations in the shortest collision.
    """

    peak_pressure: float
    pressure_to_yield: float
    contact_radius_ratio: float
    time_scale_ratio: float
    forces_per_contact: float
    wanted_forces: float
    plastic: bool = False

    @staticmethod
    def of(chain: Geometry, law: Law, peak: FloatArray, force_rate: float, *, wanted_forces: float) -> Validity:
        """Make it from the largest overlap of each contact, shape (contacts,) [m], and force evaluations per second.

        Only spheres have a pressure and a contact radius; plastic ones no pressure above that at which they yield.
        """
        places = np.flatnonzero(peak > 0.0)
        peak, real = peak[places], np.arange(len(chain.stiffness))[chain.contact_slice][places]
        peak_pressure = pressure_to_yield = contact_radius_ratio = time_scale_ratio = forces = math.nan
        by_law = None
        if len(places):
            duration = _duration(chain.reduced_mass[real], chain.steepest[real], peak, law.exponent)
            forces, time_scale_ratio = float(duration.min() * force_rate), float((duration / _oscillation(chain)[real]).min())
        if len(places) and law.exponent == 1.5:
            stiffness, radius = chain.stiffness[real], chain.reduced_radius[real]
            # 3F / (2 pi a^2) with F = k d^1.5 and a^2 = R* d.
            pressure = 1.5 / math.pi * stiffness * np.sqrt(peak) / radius
            by_law = law.yield_pressures(stiffness, radius, chain.law_constants[real])
            limit = YIELD_PRESSURE * chain.yield_strength[real] if by_law is None else by_law
            peak_pressure = float((pressure if by_law is None else np.minimum(pressure, by_law)).max())
            pressure_to_yield = float((pressure / limit).max())
            contact_radius_ratio = float((np.sqrt(radius * peak) / chain.smaller_radius[real]).max())
        return Validity(
            peak_pressure, pressure_to_yield, contact_radius_ratio, time_scale_ratio, forces, wanted_forces, by_law is not None
        )

    def figures(self) -> dict[str, float]:
        """Name with unit -> value."""
        return {
            "peak contact pressure [Pa]": self.peak_pressure,
            "peak pressure / pressure at first yield": self.pressure_to_yield,
            "contact radius / grain radius": self.contact_radius_ratio,
            "collision time / grain's oscillation time (tau/T)": self.time_scale_ratio,
            "force evaluations in the shortest contact": self.forces_per_contact,
        }

    def cautions(self) -> list[str]:
        """Return a sentence for every assumption that was left."""
        said = []
        if self.pressure_to_yield > 1.0 and not self.plastic:
            said.append(
                f"the contact pressure reached {self.peak_pressure:.3g} Pa, {self.pressure_to_yield:.2g} times that of first "
                "yield: real grains would deform plastically"
            )
        if self.contact_radius_ratio > _SMALL_CONTACT:
            said.append(
                f"contacts grew to {self.contact_radius_ratio:.2g} of the grain's radius "
                f"(Hertz's law wants less than {_SMALL_CONTACT:g})"
            )
        if self.time_scale_ratio < _SLOW_CONTACT:
            said.append(
                f"collisions last {self.time_scale_ratio:.2g} oscillations of a grain "
                f"(a static contact law wants more than {_SLOW_CONTACT:g})"
            )
        if self.forces_per_contact < self.wanted_forces:
            said.append(
                f"a contact got {self.forces_per_contact:.0f} force evaluations ({self.wanted_forces:.0f} are wanted): "
                "take a smaller step_size"
            )
        return said


def _duration(reduced_mass: FloatArray, stiffness: FloatArray, overlap: FloatArray, exponent: float) -> FloatArray:
    """Return how long collisions with these largest overlaps last, the loss left out, shape (contacts,) [s]."""
    if exponent == 1.5:
        return np.asarray(duration_of_overlap(reduced_mass, stiffness, overlap))
    return duration_times_frequency(exponent) / np.sqrt(exponent * stiffness * overlap ** (exponent - 1.0) / reduced_mass)


def _oscillation(chain: Geometry) -> FloatArray:
    """Return T = 2.5 R / c1 of the slower side of each contact; a wall counts as the grain that it touches [s]."""
    periods = np.pad(2.5 * chain.radius / chain.sound_speed, 1, mode="edge")
    return np.maximum(periods[:-1], periods[1:])
