"""The paper's problems: the shipped experiments, with the atlas's constants and smooth loads.

The paper prints neither sizes nor materials nor loads; those of the shipped experiments are ours. `cells` says how fine all
meshes and packings are: so many cells are as long as the half-space is deep. Loads are smooth where the shipped ones are half
sine waves, whose corners hold waves as short as the cells.
"""

from __future__ import annotations

import math
from typing import Any

from granular_env.atlas.context import Context
from granular_env.components.grid.theory import LineLoad
from granular_env.components.materials.elastic import Material
from granular_env.components.support.float_arrays import FloatArray
from granular_env.experiments import load_experiment

CELLS = 272
MATERIAL = Material(density=2700.0, young=6e10, poisson=0.25)
P_SPEED, S_SPEED = MATERIAL.longitudinal_speed, MATERIAL.shear_speed
# The half-space: how deep, how wide on each side of the interface, and how far the other source is from that [m].
DEPTH, HALF_WIDTH, BESIDE = 0.4, 0.4, 0.1
# The load on it: how long [s], and its peak [N/m]; when it is looked at [s].
LOAD, PEAK = 2e-5, 1e5
INSTANTS = (4e-5, 7e-5)
# Of the largest stable step, c_p step / cell.
_STEP = 0.42
_SAMPLING = 1e-5
_COEFFICIENTS = (0.0, 0.0, 0.0, 64.0, -192.0, 192.0, -64.0)
ROW = 0.5 * math.sqrt(3.0)


def cell(context: Context) -> float:
    """Return the side of the cells of the half-space, which is the diameter of its automata [m]."""
    return DEPTH / context.constants["cells"]


def step(size: float, context: Context, every: float = _SAMPLING) -> float:
    """Return the internal step for cells of this size: a whole part of `every` [s]."""
    return every / (math.ceil(every * P_SPEED / (_STEP * size)) * context.refinement)


def smooth_pulse(peak: float, duration: float, pattern: list[Any]) -> dict[str, Any]:
    """Return the table of an input: peak x 64 (t/T)^3 (1 - t/T)^3, smooth at both ends."""
    powers = [peak * factor / duration**power for power, factor in enumerate(_COEFFICIENTS)]
    return {"profile": "piecewise", "starts": [0.0, duration], "coefficients": [powers, [0.0]], "pattern": pattern}


def half_space(context: Context, name: str) -> dict[str, Any]:
    """Return the document of a shipped Lamb experiment, `psakhie-2003/lamb-NAME`, as fine as the constants say."""
    document = load_experiment(f"psakhie-2003/lamb-{name}").to_dict()
    component, size = document["component"], cell(context)
    grid = component["grid"] if "grid" in component else component
    mesh = grid["mesh"]
    finer = mesh["cell_size"] / size
    mesh |= {"columns": round(mesh["columns"] * finer), "rows": round(mesh["rows"] * finer), "cell_size": size}
    grid["receivers"] = []
    if "automata" in component:
        automata = component["automata"]
        automata["diameter"] = size
        if automata["packing"] == "hexagonal":
            automata["shape"]["height"] = round(DEPTH / (ROW * size)) * ROW * size
    component["step_size"] = step(size, context)
    (load,) = document["input"].values()
    load |= smooth_pulse(PEAK, LOAD, load["pattern"])
    for key in ("peak", "duration"):
        load.pop(key, None)
    prefixes = ("grid_", "automata_") if "automata" in component else ("",)
    document["record"] = {"every": _SAMPLING, "variables": [f"{prefix}velocity" for prefix in prefixes]}
    document["duration"] = INSTANTS[-1]
    return document


def exact() -> LineLoad:
    """Return the exact solution of the half-space, as velocities: the load's slope in time has them for displacements."""
    powers = [PEAK * factor / LOAD**power for power, factor in enumerate(_COEFFICIENTS)]

    def slope(time: FloatArray) -> FloatArray:
        found = 0.0 * time
        for power in range(len(powers) - 1, 0, -1):
            found = found * time + power * powers[power]
        return found

    return LineLoad(MATERIAL, slope, LOAD)
