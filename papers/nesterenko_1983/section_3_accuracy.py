"""Section 3: accuracy of the computation

The paper integrates with the methods of Runge and Kutta and of Hamming, checks momentum and energy, compares with an exactly
solvable case, and uses the scaling of all velocities with the initial velocity.
"""

import numpy as np

import granular_env as ge
from chains import DIAMETER, ERROR, MASS, SPEED, STEEL, A, run_experiment
from granular_env.components.chain import theory
from granular_env.domains.chain import measurement
from pages import Page, record, show

# Step used here for the paper's integrators [s], and the time of the profiles in units of τ.
STEP, TAU = 2e-7, 60.0
BOUND = "Any correct program satisfies these bounds with short steps: they check this program and are not results of the paper."


def velocity_profile(speed: float, stiffness: float = A * MASS) -> np.ndarray:
    """Return v/v0 of 100 piston-driven grains at τ = 60, for a piston speed [m/s] and a stiffness [N/m^1.5]."""
    tick = 0.02 * theory.time_scale(MASS, stiffness, speed)
    parameters = STEEL | {
        "contact_stiffness": stiffness,
        "step_size": tick,
        "overlap_limit": 100.0,
        "velocity_scale": 2.0 * speed,
    }
    chain = ge.Chain(grains=100, left="piston", **parameters)
    chain.reset(velocity={0: speed})
    chain.step(round(TAU / 0.02) * tick, left_velocity=speed)
    return chain.get("velocity") / speed


def main(page: Page) -> None:
    """Compare the chain with gaps, the paper's integrators, and the scaling (3.1)."""
    last = run_experiment("gap-chain").velocity[-1, -1] / SPEED
    page.add_heading("Grains with gaps pass on the velocity exactly")
    page.compare("|v_N/v0 - 1|", "at most 0.01", 100.0 * abs(last - 1.0), "%", most=0.01)

    page.add_heading(f"Two moving grains of section 3.1, steps of {1e6 * STEP:g} µs")
    reference = run_experiment("3.1-two-grains")
    for name, integrator in (("Runge-Kutta", "rk4"), ("Hamming", "hamming")):
        log = record("nesterenko-1983/3.1-two-grains", **{"component.integrator": integrator, "component.step_size": STEP})
        momentum = np.abs(log.series("momentum_residual")[1]).max() / log.series("momentum")[1][0]
        energy = np.abs(log.series("energy_residual")[1]).max() / log.series("kinetic_energy")[1][0]
        velocity = np.abs(measurement.history(log).velocity - reference.velocity).max() / SPEED
        page.compare(f"{name}: momentum missing", "at most 1e-5", 100.0 * momentum, "%", most=1e-5)
        page.compare(f"{name}: energy missing", "at most 0.01", 100.0 * energy, "%", most=0.01)
        page.compare(f"{name}: error of velocities", "about 0.01", 100.0 * velocity, "%", most=0.01)
    page.text(f"{BOUND} Velocities are compared with those of the symplectic integrator PEFRL with a quarter of the step.")

    page.add_heading(f"Velocities v/v0 before a piston depend on τ = t (A² v0)^(1/5) alone, (3.1): profiles at τ = {TAU:g}")
    speeds = {speed: velocity_profile(speed) for speed in (0.05, 5.0, 500.0)}
    worst = max(float(np.abs(one - speeds[5.0]).max()) for one in speeds.values())
    page.compare("largest |Δw|, v0 = 0.05, 5, 500 m/s", "none", worst, most=ERROR)
    # A solitary wave of height 2 v0 has the speed V = C c^(4/5) (2 v0)^(1/5); c scales as the square root of the stiffness.
    wave = theory.SOLITARY_SPEED * theory.contact_speed(A, DIAMETER) ** 0.8 * (2.0 * SPEED) ** 0.2
    fast, slow = (velocity_profile(SPEED, A * MASS / (wave * ratio / SPEED) ** 2.5) for ratio in (0.95, 5e-3))
    page.compare("largest |Δw|, v0/V = 0.95 and 5e-3 (section 3.4)", "none", float(np.abs(fast - slow).max()), most=ERROR)
    page.text("""At 500 m/s Hertz's law does not hold, and at v0/V = 0.95 centres approach by more than a radius, so these are
        results on the equations only. The differences are rounding errors.""")

    with page.plot("Profiles before the piston at τ = 60: ten thousand times the velocity changes only the unit of time.",
                   "grain", "v / v0") as axes:  # fmt: skip
        for (speed, velocity), style in zip(speeds.items(), ("-", "--", "."), strict=True):
            axes.plot(np.arange(1, 101), velocity, style, label=f"v0 = {speed:g} m/s")


if __name__ == "__main__":
    show(main)
