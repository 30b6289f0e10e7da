"""The plane wave of figure 6: through the interface, back from the rigid side of the automata, and through again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from granular_env.atlas.context import Context
from granular_env.components.drawables import Points
from granular_env.components.support.float_arrays import FloatArray
from granular_env.experiments import load_experiment

from .cases import CELLS, P_SPEED, ROW, smooth_pulse, step

NAMES = {"square": "plane-wave-coupled", "hexagonal": "plane-wave-hexagonal"}
# Length of the grid, and of the pulse, in time [s]; peak velocity [m/s]; end of the runs [s].
GRID_LENGTH, PULSE, PEAK, END = 0.2, 4e-5, 0.1, 1.6e-4
# Places where the velocity is kept, along the way of the wave [m]; those up to the interface are nodes.
PLACES = (0.05, 0.15, 0.2, 0.25, 0.35)
_EVERY, _ACROSS = 1e-6, 8


@dataclass(frozen=True)
class PlaneWave:
    """Velocities along the way of the wave.

    Attributes:
        times: shape (frames,) [s].
        places: shape (places,) [m].
        velocity: shape (frames, places) [m/s].
        end: where the rigid side is [m].
        residuals: what momentum and energy miss, over their largest amounts; and the difference of the interface's works.
    """

    times: FloatArray
    places: FloatArray
    velocity: FloatArray
    end: float
    residuals: dict[str, float]

    def exact(self, place: float) -> FloatArray:
        """Return the velocity of the wave that went, and of the one that came back from the rigid side [m/s]."""
        return pulse(self.times - place / P_SPEED) - pulse(self.times - (2.0 * self.end - place) / P_SPEED)

    def misfit(self, number: int, returned: bool) -> float:
        """Return the relative difference (L2) to the exact solution at a place: on the way there, or back."""
        place = float(self.places[number])
        turn = self.end / P_SPEED + 0.5 * PULSE
        own = (self.times >= turn) == returned
        exact = self.exact(place)[own]
        return float(np.sqrt(((self.velocity[own, number] - exact) ** 2).sum() / (exact**2).sum()))

    def left_behind(self, number: int) -> float:
        """Return the largest velocity at a place after the wave has passed and before it comes back, over its peak."""
        place = float(self.places[number])
        passed, back = place / P_SPEED + PULSE, (2.0 * self.end - place) / P_SPEED
        quiet = (self.times > passed) & (self.times < back)
        return float(np.abs(self.velocity[quiet, number]).max()) / PEAK


def pulse(time: FloatArray) -> FloatArray:
    """Return the velocity of the driven side [m/s]."""
    part = np.clip(time / PULSE, 0.0, 1.0)
    return PEAK * 64.0 * part**3 * (1.0 - part) ** 3


def document(context: Context, packing: str, coarser: int = 1) -> dict[str, Any]:
    """Return the shipped experiment, its cells finer as those of the half-space are, and then so much coarser."""
    found = load_experiment(f"psakhie-2003/{NAMES[packing]}").to_dict()
    component = found["component"]
    grid, automata = component["grid"], component["automata"]
    axis = int(packing == "hexagonal")
    along = 4 * round(20 * context.constants["cells"] / (CELLS * coarser))
    size = GRID_LENGTH / along
    columns, rows = (along, _ACROSS) if axis == 0 else (_ACROSS, along)
    grid["mesh"] |= {"columns": columns, "rows": rows, "cell_size": size}
    middle = 0.5 * _ACROSS * size
    grid["receivers"] = [_place(place, middle, axis) for place in PLACES if place <= GRID_LENGTH]
    width, length = _ACROSS * size, round(GRID_LENGTH / ((ROW if axis else 1.0) * size)) * (ROW if axis else 1.0) * size
    automata["shape"] |= {"width": length, "height": width} if axis == 0 else {"width": width, "height": length}
    automata["diameter"] = size
    component["step_size"] = step(size, context, _EVERY)
    [driven] = found["input"]
    found["input"] = {driven: smooth_pulse(PEAK, PULSE, [1.0, 0.0] if axis == 0 else [0.0, 1.0])}
    variables = ["grid_receiver_velocity", "automata_velocity", "interface_work_on_grid", "interface_work_difference"]
    found["record"] = {"every": _EVERY, "variables": variables}
    found["duration"] = END
    return found


def _place(along: float, across: float, axis: int) -> list[float]:
    return [along, across] if axis == 0 else [across, along]


def plane_wave(context: Context, packing: str, coarser: int = 1) -> PlaneWave:
    """Run it, or read its log."""
    content = document(context, packing, coarser)
    log = context.run(content)
    axis = int(packing == "hexagonal")
    [points] = [one.reference for one in log.drawables if isinstance(one, Points) and one.name == "automata"]
    middle = 0.5 * _ACROSS * content["component"]["automata"]["diameter"]
    found, places = [], []
    times, received = log.series("grid_receiver_velocity")
    for number, place in enumerate(one for one in PLACES if one <= GRID_LENGTH):
        found.append(received[:, number, axis])
        places.append(place)
    velocity = log.series("automata_velocity")[1]
    for place in (one for one in PLACES if one > GRID_LENGTH):
        nearest = int(np.argmin(np.hypot(points[:, axis] - place, points[:, 1 - axis] - middle)))
        found.append(velocity[:, nearest, axis])
        places.append(float(points[nearest, axis]))
    end = float(points[:, axis].max())
    return PlaneWave(times, np.array(places), np.stack(found, axis=1), end, _residuals(log, axis))


def _residuals(log: Any, axis: int) -> dict[str, float]:
    """Return what the balances miss, over the largest amounts."""
    series = {name: log.series(name)[1] for name in (
        "momentum", "momentum_residual", "kinetic_energy", "energy_residual", "interface_work_on_grid",
        "interface_work_difference",
    )}  # fmt: skip

    def part(residual: str, amount: str, columns: Sequence[int] | None = None) -> float:
        values = series[residual] if columns is None else series[residual][:, columns]
        return float(np.abs(values).max() / np.abs(series[amount]).max())

    return {
        "momentum": part("momentum_residual", "momentum", [axis]),
        "energy": part("energy_residual", "kinetic_energy"),
        "work": part("interface_work_difference", "interface_work_on_grid"),
    }
