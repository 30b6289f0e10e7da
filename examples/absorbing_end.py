"""An active end that absorbs an unknown wave using only its sensors, compared with passive ends.

Six unknown waves: one or two grains strike a row of 64 grains at 3, 5 and 8 m/s. The returned energy is the energy in the chain
at 600 us divided by the strikers' energy, minus the fraction that the strikers carry off to the left in a chain twice as long.
Run it with `python examples/absorbing_end.py`.
"""

from collections.abc import Callable

import numpy as np

from granular_env.domains.chain.tasks.absorption import make_absorption
from granular_env.domains.chain.tasks.matched_end import Dashpot, SensorScales

WAVES = [(strikers, speed) for strikers in (1, 2) for speed in (3.0, 5.0, 8.0)]


def residual_energy(env: make_absorption, policy: Callable, strikers: int, speed: float) -> float:
    """Return the final energy in the chain divided by the energy of the strikers."""
    env.reset(seed=0, options={"velocity": dict.fromkeys(range(strikers), speed)})
    policy.reset()
    observation, info = env.observe()
    over = False
    while not over:
        observation, _, terminated, truncated, info = env.step(policy(observation, info))
        over = terminated or truncated
    return info["returned"]


def rebound_energy(strikers: int, speed: float) -> float:
    """Return the energy that the strikers carry off before reaching the end: left of grain 30, after 600 us in a long chain."""
    env = make_absorption(160, deadline=600)
    env.reset(seed=0, options={"velocity": dict.fromkeys(range(strikers), speed)})
    for _ in range(300):
        *_, info = env.step([0.0])
    speeds = info["velocity"][:30]
    return float((speeds**2).sum() / (strikers * speed**2))


def mean_returned_energy(env: make_absorption, policy: Callable) -> float:
    """Return the mean over the six waves."""
    return float(np.mean([residual_energy(env, policy, *wave) - CARRIED[wave] for wave in WAVES]))


CARRIED = {wave: rebound_energy(*wave) for wave in WAVES}


def free_end_energy() -> float:
    """Let the last grain fly off, and return the energy of the other grains."""
    left = []
    env = make_absorption(action="force")
    for strikers, speed in WAVES:
        env.reset(seed=0, options={"velocity": dict.fromkeys(range(strikers), speed)})
        for _ in range(300):
            *_, info = env.step([0.0])
        left.append((info["velocity"][:-1] ** 2).sum() / (strikers * speed**2) - CARRIED[strikers, speed])
    return float(np.mean(left))


def best_dashpot(exponent: float, low: float, high: float, mass: float | None = None) -> tuple[float, float]:
    """Return the optimal dashpot on the end grain (optionally with a given mass): its constant and the returned energy."""
    from scipy.optimize import minimize_scalar

    chain = {} if mass is None else {"mass": {63: mass}}
    env = make_absorption(action="force", chain=chain, internal_steps=2, deadline=600)
    task = env.task
    sensors = SensorScales.from_task(task)

    def cost(logarithm: float) -> float:
        return mean_returned_energy(env, Dashpot(float(np.exp(logarithm)), exponent, env.duration, 1000.0, sensors))

    found = minimize_scalar(cost, bounds=(np.log(low), np.log(high)), method="bounded", options={"xatol": 0.02})
    return float(np.exp(found.x)), float(found.fun)


def main() -> dict[str, float]:
    numbers = {"wall": mean_returned_energy(make_absorption(), make_absorption().task.baselines()["nothing"])}
    numbers["free end, last grain caught"] = free_end_energy()
    constant, numbers["best linear dashpot"] = best_dashpot(1.0, 20.0, 500.0)
    numbers["its damping constant [N s/m]"] = constant
    for action in ("piston", "force"):
        env = make_absorption(action=action)
        numbers[f"matched {action}"] = mean_returned_energy(env, env.task.baselines()["theory"])
    return numbers


if __name__ == "__main__":
    for name, value in main().items():
        print(f"{name}: {value:.3g}")
