"""The state of an environment within an episode, from which the episode can be continued in any process."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..components.snapshot import Snapshot

# Indices in an environment's memory: elapsed control steps, whether the episode is running, seed of the noise; then follow
# the actuator's commands.
ELAPSED, RUNNING, SEED, COMMANDS = range(4)

Drawn = Mapping[str, Any]
"""Component parameters sampled for an episode: name -> number, or a distribution with its seed."""

Origin = tuple[str, Mapping[str, Any], Drawn]
"""Start of an episode: name of the task, state of the environment's random generator, and the sampled parameters."""


class EnvState(NamedTuple):
    """The state that `ComponentEnv.save` returns and `restore` accepts; it is immutable and can be pickled.

    Attributes:
        snapshot: the component's state.
        memory: memory of the environment, as bytes of float64.
        counters: counters of the task.
        origin: what defines the start of the episode (sampled parameters and random generator).
    """

    snapshot: Snapshot
    memory: bytes
    counters: Mapping[str, float]
    origin: Origin
