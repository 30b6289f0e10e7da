"""Time of first uses that compile, in a separate process with an empty cache [s of one core]."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from tempfile import TemporaryDirectory

from .figures import Figure

_FIRST_USES = """
import json, time
begin, spent = time.process_time(), []
def note():
    global begin
    spent.append(time.process_time() - begin)
    begin = time.process_time()
import numpy as np
import granular_env as ge
chain = ge.Chain(grains=100, precompression=100.0, right="plane")
chain.step(1e-5, left_force=1.0)
chain.balances()
note()
from granular_env.domains.chain.control import total, value_and_grad, velocity
value_and_grad(total(chain, velocity(-1).at_end()), chain, np.zeros((20, 2)), ticks=3)
note()
import gymnasium
import granular_env.envs
env = gymnasium.make("granular_env/Protection-v1")
env.reset(seed=0)
env.step([0.1])
note()
print(json.dumps(spent))
"""
_USES = {"the first run of a chain": 7.0, "the first gradient of a chain": 8.0, "the first environment of a chain": None}


# First run of each other medium, in one process per medium.
_BODY = '{"name": "tube", "length": 0.004, "inner_radius": 0.003, "wall": 8e-4, "along": 5, "around": 7, "half": True}'
_MEDIA = {
    "the first run of a grid": """
mesh = {"name": "rectangle", "columns": 20, "rows": 10, "cell_size": 0.01}
medium = ge.make("grid", mesh=mesh, boundaries={"left": "velocity"})
medium.step(1e-5, left_velocity=[0.1, 0.0])
""",
    "the first run of automata that crack": """
shape, criterion = {"name": "rectangle", "width": 0.04, "height": 0.01}, {"name": "strain", "tensile": 1e-3}
medium = ge.make("automata", shape=shape, diameter=2.5e-3, packing="square", material="glass", criterion=criterion,
                 boundaries={"left": "fixed", "right": "velocity"})
medium.step(5e-5, right_velocity=[2.0, 0.0])
assert medium.events()
""",
    "the first run of a coupled body": """
medium = ge.make("coupled", grid={"mesh": {"name": "rectangle", "columns": 10, "rows": 8, "cell_size": 5e-3}},
                 automata={"shape": {"name": "rectangle", "width": 0.05, "height": 0.04}, "diameter": 5e-3, "packing": "square",
                           "boundaries": {"right": "fixed"}}, origin=[0.05, 0.0])
medium.step(1e-5)
""",
    "the first run of a coupled body that cracks": """
mesh = {"name": "rectangle", "columns": 10, "rows": 8, "cell_size": 5e-3}
shape, criterion = {"name": "rectangle", "width": 0.05, "height": 0.04}, {"name": "strain", "tensile": 1e-3}
medium = ge.make("coupled", grid={"mesh": mesh, "boundaries": {"left": "velocity"}},
                 automata={"shape": shape, "diameter": 2.5e-3, "packing": "square", "criterion": criterion,
                           "boundaries": {"right": "fixed"}}, origin=[0.05, 0.0])
medium.step(1e-5, grid_left_velocity=[-20.0, 0.0])
assert medium.events()
""",
    "the first run of the gas": """
medium = ge.make("detonation", length=0.05, cells=50)
medium.step(1e-6)
""",
    "the first run of a solid that cracks": f"""
medium = ge.make("shell", body={_BODY}, material="thermoviscoplastic", step_size=2e-8,
                 fracture={{"name": "principal_stress", "factor": 1.0}})
medium.step(1e-6, pressure=4e8)
assert medium.events()
""",
    "the first run of a tube": f"""
gas = {{"length": 0.048, "cells": 24, "cross_section": 1.4137e-5, "ignition_zone": [0.0, 0.01]}}
medium = ge.make("tube", gas=gas, shell={{"body": {_BODY}, "material": "thermoviscoplastic"}}, position=0.0021, step_size=5e-8)
medium.step(1e-5, gas_ignition_power=3e6)
""",
}
_FIRST_RUN = """
import json, time
import granular_env as ge
{run}
medium.balances()
print(json.dumps([time.process_time()]))
"""
# Largest CPU time for the first run of each medium, in the order of `_MEDIA` [s].
_AT_MOST = (7.0, 12.0, 12.0, 25.0, 7.0, 15.0, 15.0)


def measure(repeats: int = 2) -> Iterator[Figure]:
    """Measure the minimum over `repeats` processes, because other load only adds time."""
    tries = [_seconds(_FIRST_USES) for _ in range(repeats)]
    for place, (what, at_most) in enumerate(_USES.items()):
        found = min(seconds[place] for seconds in tries)
        yield Figure(f"{what}, nothing compiled before", found, "s", at_most=at_most, note="imports included")
    for (what, run), at_most in zip(_MEDIA.items(), _AT_MOST, strict=True):
        found = min(_seconds(_FIRST_RUN.format(run=run))[0] for _ in range(repeats))
        yield Figure(f"{what}, nothing compiled before", found, "s", at_most=at_most, note="imports included")


def _seconds(code: str) -> list[float]:
    """Run code in a process with an empty cache; return the times that it prints [s]."""
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "GRANULAR_ENV_CACHE": folder, "GRANULAR_ENV_QUIET": "1"}
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    return json.loads(done.stdout)
