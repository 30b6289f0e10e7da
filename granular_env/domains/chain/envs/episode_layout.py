"""Layout of an episode's memory: one row of numbers, so that saving it is one copy.

Control steps done, whether the episode goes on, the seed of its noise, the tick at which it began, the inputs applied left and
right; then the task's counters; then the actuator's commands.
"""

from __future__ import annotations

ELAPSED, RUNNING, SEED, START, LEFT, RIGHT, COUNTERS = range(7)
