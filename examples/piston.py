"""Nesterenko's piston, step by step: exit velocity of the last grain, and residuals of the balances.

Run it with `python examples/piston.py`; it takes a second.
"""

import granular_env as ge

PISTON_VELOCITY = 5.0  # m/s


def main() -> dict[str, float]:
    chain = ge.make("chain", grains=100, radius=3e-3, material="steel", left="piston", step_size=1e-7)
    chain.reset(velocity={0: PISTON_VELOCITY})
    while chain.time < 1e-3:
        chain.step(5e-6, left_velocity=PISTON_VELOCITY)  # inputs may change at every step

    balances = chain.balance_values()
    return {
        "last grain / piston velocity": chain.get("velocity")[-1] / PISTON_VELOCITY,
        "energy residual / work of the piston": balances["energy_residual"] / balances["input_work"],
        "momentum residual / impulse": balances["momentum_residual"] / balances["impulse"],
    }


if __name__ == "__main__":
    for name, value in main().items():
        print(f"{name}: {value:.6g}")
