# ruff: noqa: F401
"""Closed forms and quadratures for the chain; no step calls them. Numbers in brackets are Nesterenko's (1983) equations.

SI units, or dimensionless if the module says so.

Arguments annotated `Number` are numbers or arrays, arguments annotated `float` single numbers. Each docstring states the range
in which its formula holds. Ranges are not checked: a wrong sign may vanish in a square.
"""

from __future__ import annotations

from .collisions import (
    COLLISION_COEFFICIENT,
    KUWABARA_KONO_COEFFICIENT,
    VISCOUS_COEFFICIENT,
    collision_duration,
    collision_overlap,
    duration_from_overlap,
    kuwabara_kono_loss,
    tapered_ratio,
    tapered_velocities,
    viscous_loss,
    viscous_loss_without_tension,
)
from .continuum import (
    CONTINUUM_SOLITARY_SPEED,
    HALF_WIDTH,
    LARGEST_C3,
    PERIOD,
    PRESSURE_OVERSHOOT,
    STRAIN_OVERSHOOT,
    Extremes,
    W,
    c3_from_ratio,
    extreme_roots,
    extremes,
    front_velocity_ratio,
    largest_strain,
    ratio_from_c3,
    shock_ratio,
    shock_speed,
    shock_speed_ratio,
    shock_strain,
    solitary_strain,
    speed_ratio,
    strain_wave,
)
from .dispersion import (
    BandEdges,
    diatomic_band_edges,
    diatomic_frequencies,
    monatomic_cutoff_frequency,
    monatomic_frequency,
    tangent_stiffness,
)
from .lattice_wave import (
    FREE_END_VELOCITY,
    LATTICE_PRESSURE_OVERSHOOT,
    LATTICE_STRAIN_OVERSHOOT,
    SOLITARY_ENERGY,
    SOLITARY_MOMENTUM,
    SOLITARY_SPEED,
    LatticeWave,
    lattice_wave,
)
from .long_waves import (
    anharmonic_acceleration,
    contact_constant,
    contact_speed,
    korteweg_de_vries_shape,
    korteweg_de_vries_speed_ratio,
    lattice_acceleration,
    long_wave_acceleration,
    nesterenko_acceleration,
    nesterenko_speed,
    sound_speed,
    time_scale,
)
from .stationary_waves import StationaryWave, solitary_wave
