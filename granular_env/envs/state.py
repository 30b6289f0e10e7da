"""An environment in mid-episode, as one small object from which any process can continue."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..components.snapshot import Snapshot

# The memory of an environment: control steps done, whether the episode is running, the seed of its noise, then the actuator's
# commands.
ELAPSED, RUNNING, SEED, COMMANDS = range(4)

Drawn = Mapping[str, Any]
"""Parameters of the component that were drawn for an episode, name -> number, or a distribution with its seed."""

Origin = tuple[str, Mapping[str, Any], Drawn]
"""Name of the task, state of the environment's random numbers, and what was drawn for the episode: of all its states."""


class EnvState(NamedTuple):
    """The state that `ComponentEnv.save` gives and `restore` takes; never changed by what follows, and pickled as it is.

    Attributes:
        snapshot: the component's state.
        memory: the environment's own numbers, as bytes of float64.
        counters: the task's.
        origin: the start of the episode.
    """

    snapshot: Snapshot
    memory: bytes
    counters: Mapping[str, float]
    origin: Origin
