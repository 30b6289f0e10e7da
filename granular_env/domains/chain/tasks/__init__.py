"""Tasks on a chain, one a file: what is rewarded. Each is registered by its line in `ENVIRONMENTS`."""

from __future__ import annotations

from granular_env.domains import Environment


def _environment(task: str, reward_threshold: float) -> Environment:
    """Return what is registered of the task in the module `task`, whose factory is called ``make_<task>``."""
    return Environment(f"{__name__}.{task}:make_{task}", reward_threshold)


# The thresholds are what theory returns, rounded down; of Piston-v1, which has no theory, what a push of 2.4 m/s for 18 us
# returns.
ENVIRONMENTS = {
    "granular_env/Piston-v1": _environment("piston", 0.769),
    "granular_env/PulseForming-v1": _environment("pulse_forming", -1e-3),
    "granular_env/Protection-v1": _environment("protection", 0.79),
    "granular_env/Absorption-v1": _environment("absorption", 0.99),
    "granular_env/EnergyDelivery-v1": _environment("energy_delivery", 0.809),
    "granular_env/SolitonTrain-v1": _environment("soliton_train", -2e-3),
}
