"""A load on a half-space compared with the exact solution of Cagniard and de Hoop, then the same rock with a hole.

Run it with `python examples/lamb_problem.py`.
"""

import numpy as np

import granular_env as ge
from granular_env.components.grid.theory import LineLoad, rayleigh_speed

ROCK = ge.Material(density=2700.0, young=6e10, poisson=0.25)
CELL = 5e-3  # m
# The load lasts 30 us, in which an S wave travels 0.09 m (18 cells).
DURATION, PEAK = 3e-5, 1e4  # s, N on a slab one metre thick
RECEIVERS = [[0.2, -0.01], [0.12, -0.12]]  # near the surface (Rayleigh wave), and inside
POWERS = np.array([0, 0, 0, 64, -192, 192, -64]) / DURATION ** np.arange(7)


def load_force(time: np.ndarray) -> np.ndarray:
    """Return 64 (t/T)^3 (1 - t/T)^3 times the peak, downwards [N]."""
    part = np.clip(time / DURATION, 0.0, 1.0)
    return 64.0 * PEAK * part**3 * (1.0 - part) ** 3


def seismograms(holes: list[dict], duration: float = 1.1e-4) -> tuple[np.ndarray, np.ndarray]:
    """Return times, and displacements of the receivers along x and downwards, shape (times, receivers, 2)."""
    grid = ge.make(
        "grid",
        mesh={"name": "rectangle", "columns": 200, "rows": 90, "cell_size": CELL, "centre": [0.0, -0.225], "holes": holes},
        material=ROCK,
        boundaries=dict.fromkeys(("left", "right", "bottom"), "absorbing"),
        forced_nodes=[[0.0, 0.0]],
        receivers=RECEIVERS,
    )
    signal = ge.Profile.piecewise([0.0, DURATION], [PEAK * POWERS, [0.0]]) * [[0.0, -1.0]]
    grid.step(2 * grid.step_size, force=signal)
    times, seen = [], []
    while grid.time < duration:
        grid.step(2 * grid.step_size)
        times.append(grid.time)
        seen.append(grid.get("receiver_displacement") * [1.0, -1.0])
    return np.array(times), np.array(seen)


def main() -> dict[str, float]:
    """Run the comparison; return the printed numbers."""
    times, seen = seismograms([])
    exact = LineLoad(ROCK, load_force, DURATION)
    numbers = {"Rayleigh speed / S speed": rayleigh_speed(ROCK) / ROCK.shear_speed}
    for place, (x, y) in enumerate(RECEIVERS):
        reference = exact.displacement(x, -y, times)
        error = np.sqrt(((seen[:, place] - reference) ** 2).sum() / (reference**2).sum())
        numbers[f"misfit at x = {x:g} m, depth {-y:g} m"] = float(error)
    hole = {"name": "disc", "centre": [0.1, -0.03], "radius": 0.025}
    _, behind = seismograms([hole])
    numbers["peak behind a hole / without it"] = float(np.abs(behind[:, 0]).max() / np.abs(seen[:, 0]).max())
    for name, number in numbers.items():
        print(f"{name:45s} {number:.4f}")
    return numbers


if __name__ == "__main__":
    main()
