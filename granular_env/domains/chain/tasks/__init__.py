"""Tasks on a chain, one per file. `ENVIRONMENTS` registers them."""

from __future__ import annotations

from granular_env.domains import Environment


def _registration(task: str, reward_threshold: float) -> Environment:
    """Return the registration of the task in module `task`, whose environment is made by ``make_<task>``."""
    return Environment(f"{__name__}.{task}:make_{task}", reward_threshold)


# The reward thresholds are returns of the "theory" baselines, rounded down. For Piston-v1, which has none, it is the return
# of a push of 2.4 m/s for 18 us.
ENVIRONMENTS = {
    "granular_env/Piston-v1": _registration("piston", 0.769),
    "granular_env/PulseForming-v1": _registration("pulse_forming", -1e-3),
    "granular_env/Protection-v1": _registration("protection", 0.79),
    "granular_env/Absorption-v1": _registration("absorption", 0.99),
    "granular_env/EnergyDelivery-v1": _registration("energy_delivery", 0.809),
    "granular_env/SolitonTrain-v1": _registration("soliton_train", -2e-3),
}
