"""Measurements on chains, from a log or a running chain: waves, fronts, energies.

    history = measurement.history(ge.open_log("run.mcap"))           # or
    history = measurement.observe(chain, duration=8e-4, every=1e-6)
    measurement.waves_at(history, grain=60, above=0.1)

Measurements are functions of a `History`. Grains are counted from 0. Speeds and positions refer to the undeformed chain.
"""

from granular_env.crests_and_crossings import Crest, crests

from .chain_history import History
from .energy_and_momentum import (
    EnergyRatio,
    detached_grains,
    energy_ratio,
    kinetic_energy,
    momentum,
    momentum_carried_off,
    potential_energy,
)
from .fronts import PressureRatio, arrivals, front_position, front_speed, pressure_ratio
from .history_sources import history
from .observer import Watch, observe
from .spatial_waves import WaveInChain, waves_along
from .waves import Shift, Wave, energy_of, momentum_of, overlap_of, phase_shifts, waves_at

__all__ = [
    "Crest",
    "EnergyRatio",
    "History",
    "PressureRatio",
    "Shift",
    "Watch",
    "Wave",
    "WaveInChain",
    "arrivals",
    "crests",
    "detached_grains",
    "energy_of",
    "energy_ratio",
    "front_position",
    "front_speed",
    "history",
    "kinetic_energy",
    "momentum",
    "momentum_carried_off",
    "momentum_of",
    "observe",
    "overlap_of",
    "phase_shifts",
    "potential_energy",
    "pressure_ratio",
    "waves_along",
    "waves_at",
]
