"""What the first uses take that compile: a process of its own with an empty cache, in seconds of one core."""

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
_USES = {"the first run of a chain": 8.0, "its first gradient": 8.0, "the first environment of a chain": None}


def measure(repeats: int = 2) -> Iterator[Figure]:
    """The best of so many processes: what else the machine does only adds to it."""
    tries = [_seconds() for _ in range(repeats)]
    for place, (what, at_most) in enumerate(_USES.items()):
        found = min(seconds[place] for seconds in tries)
        yield Figure(f"{what}, nothing compiled before", found, "s", at_most=at_most, note="imports included")


def _seconds() -> list[float]:
    """Run the first uses in a process with an empty cache; return the seconds of each."""
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "GRANULAR_ENV_CACHE": folder, "GRANULAR_ENV_QUIET": "1"}
        done = subprocess.run([sys.executable, "-c", _FIRST_USES], capture_output=True, text=True, env=environment, check=True)
    return json.loads(done.stdout)
