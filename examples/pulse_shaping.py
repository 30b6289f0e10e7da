"""Pulse shaping by gradient: find the force on the first grain that makes the wanted solitary waves, from a zero drive.

One wave, compared with the triangular force of Nesterenko (1983), section 3.3; one wave in a disordered and in a dissipative
chain, compared with the uniform chain's drive; two successive waves. Run it with `python examples/pulse_shaping.py`.
"""

import numpy as np
from scipy.optimize import minimize

import granular_env as ge
from granular_env.components.chain.adjoint import value_and_adjoint
from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming
from granular_env.envs.policies import OpenLoop, play

PAPER = {"contact_stiffness": 4940091615.916878}  # N/m^1.5: the paper's A = 5.6e12 N/(m^1.5 kg)
PEAK, FORCE_ADJOINT = 1764.3184342560278, 1e-5  # N, s: the triangle of the paper's shorter push
SCALE = 2000.0  # N at action 1
UNIT = 20.0  # N: length of the optimiser's first step

Bounds = tuple[float, float]


def improve_drive(env: make_pulse_forming, drive: np.ndarray, way: float, pushed: int, iterations: int) -> np.ndarray:
    """Return a drive from L-BFGS-B; `way` is the weight of the mean distance over all steps relative to the final distance."""
    env.reset(seed=0)
    objective, steps = env.task.objective(env.component, len(drive), way=way), len(drive)

    def cost(scaled: np.ndarray) -> tuple[float, np.ndarray]:
        drive = np.column_stack([UNIT * scaled, np.zeros(steps)])
        adjoints = value_and_adjoint(env.component, drive, env.internal_steps, objective)
        return weight * adjoints.value, weight * UNIT * adjoints.inputs[:, 0]

    weight = 1.0
    weight = 1.0 / max(cost(drive / UNIT)[0], 1e-12)
    limits: list[Bounds] = [(0.0, PEAK / UNIT if step < pushed else 0.0) for step in range(steps)]
    options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 30, "ftol": 1e-15, "gtol": 1e-14}
    return UNIT * minimize(cost, drive / UNIT, jac=True, method="L-BFGS-B", bounds=limits, options=options).x


def shape_drive(env: make_pulse_forming, pushed: int | None = None, iterations: int = 600) -> np.ndarray:
    """Return the best drive found from zeros, 0 to `PEAK`, in the first `pushed` control steps (all of them).

    First minimise the distance over all steps, which has a gradient everywhere, then the final distance.
    """
    drive = np.zeros(int(env.deadline))
    for way, part in ((1.0, 0.5), (0.3, 0.5), (0.0, 1.0)):
        drive = improve_drive(env, drive, way, pushed or int(env.deadline), int(part * iterations))
    return drive


def final_counters(env: make_pulse_forming, drive: np.ndarray) -> dict[str, float]:
    """Return the counters of the environment at the deadline."""
    _, info = play(env, OpenLoop(drive / SCALE), seed=0)
    return {name: float(info[name]) for name in env.task.counter_names}


def crest_passages(env: make_pulse_forming, drive: np.ndarray, grain: int) -> list[tuple[float, float]]:
    """Return times [s] and velocities [m/s] of crests at a grain: maxima above 0.2 m/s, sampled at every internal step."""
    chain, speeds = env.component, []
    chain.reset()
    for force in np.concatenate([drive, np.zeros(40)]):
        for _ in range(env.internal_steps):
            chain.step(chain.step_size, left_force=float(force))
            speeds.append(chain.get("velocity")[grain])
    v, h = np.array(speeds), chain.step_size
    crests = np.flatnonzero((v[1:-1] > v[:-2]) & (v[1:-1] >= v[2:]) & (v[1:-1] > 0.2)) + 1
    found = []
    for i in crests:  # parabola through three samples
        bend, slope = v[i - 1] - 2.0 * v[i] + v[i + 1], 0.5 * (v[i + 1] - v[i - 1])
        found.append(((i + 1 - slope / bend) * h, v[i] - 0.5 * slope * slope / bend))
    return found


def triangle_height() -> float:
    """Return the velocity at grain 60 of the wave from the paper's 10 us triangle [m/s]."""
    chain = ge.Chain(grains=100, step_size=1e-7, **PAPER)
    fastest = 0.0
    for tick in range(4200):
        chain.step(1e-7, left_force=PEAK * max(1.0 - (tick + 0.5) * 1e-7 / FORCE_ADJOINT, 0.0))
        fastest = max(fastest, chain.get("velocity")[60])
    return fastest


def one_wave() -> dict[str, float]:
    """Make one wave of the triangle's height at grain 60 of the paper's chain, with a drive below the triangle's peak."""
    amplitude = triangle_height()
    env = make_pulse_forming(100, place=60, amplitude=amplitude, deadline=264, action_scale=SCALE, chain=PAPER)
    drive = shape_drive(env, pushed=45)
    left = final_counters(env, drive)
    return {
        "triangle: amplitude at grain 60 [m/s]": amplitude,
        "triangle: peak force [N]": PEAK,
        "shaped: amplitude at grain 60, relative error": crest_passages(env, drive, 60)[0][1] / amplitude - 1.0,
        "shaped: energy outside the wave / input": left["energy_outside"],
        "shaped: peak force [N]": float(drive.max()),
    }


def other_chains() -> dict[str, float]:
    """Return the distances from a wave of 5 m/s at grain 60 in other chains, for the best and the uniform chain's drive."""
    setting = {"grains": 100, "place": 60, "deadline": 270, "action_scale": SCALE}
    uniform = shape_drive(make_pulse_forming(**setting), pushed=50)
    numbers = {}
    for name, chain in {
        "radii +-5 %": {"radius": {"low": 2.85e-3, "high": 3.15e-3, "seed": 1}},
        "viscous, 2 N s/m": {"law": {"name": "viscous", "dissipation": 2.0}},
    }.items():
        env = make_pulse_forming(**setting, chain=chain)
        numbers[f"{name}: distance"] = final_counters(env, shape_drive(env))["distance"]
        numbers[f"{name}: with the uniform chain's drive"] = final_counters(env, uniform)["distance"]
    return numbers


def two_waves_environment(first: float = 5.0, second: float = 3.0, grain: int = 30, delay: float = 1e-4) -> make_pulse_forming:
    """Make two successive waves that pass a grain `delay` seconds apart."""
    speeds = make_pulse_forming(amplitude=[first, second], place=[40, 10]).task.present_goal()[:, 2]
    # Position of the second wave when the first is at grain 60.
    behind = grain + speeds[1] * ((60 - grain) / speeds[0] - delay)
    return make_pulse_forming(100, amplitude=[first, second], place=[60.0, float(behind)], deadline=270, action_scale=SCALE)


def two_waves(first: float = 5.0, second: float = 3.0, grain: int = 30, delay: float = 1e-4) -> dict[str, float]:
    """Return the deviations of two waves from the wanted waves."""
    env = two_waves_environment(first, second, grain, delay)
    drive = shape_drive(env, pushed=120)
    (early, high), (late, low) = crest_passages(env, drive, grain)
    return {
        "first wave, relative error": high / first - 1.0,
        "second wave, relative error": low / second - 1.0,
        "delay, relative error": (late - early) / delay - 1.0,
        "energy outside the waves / input": final_counters(env, drive)["energy_outside"],
    }


def main() -> dict[str, float]:
    return {**one_wave(), **other_chains(), **two_waves()}


if __name__ == "__main__":
    for name, value in main().items():
        print(f"{name}: {value:.4g}")
