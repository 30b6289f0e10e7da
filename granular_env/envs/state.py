"""An environment in mid-episode, as one small object from which any process can continue."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.random import PCG64, Generator

from ..components.errors import LogError
from ..components.snapshot import Snapshot
from ..components.support.serialization import pack, unpack

# The memory of an environment: control steps done, whether the episode is running, the seed of its noise, then the actuator's
# commands.
ELAPSED, RUNNING, SEED, COMMANDS = range(4)

_KIND = "environment state"

Drawn = Mapping[str, Any]
"""Parameters of the component that were drawn for an episode, name -> number, or a distribution with its seed."""


class EpisodeOrigin(NamedTuple):
    """The origin of an episode, which all of its states share.

    Attributes:
        task: name of the task.
        random: the environment's random numbers, see `random_state`.
        drawn: parameters of the component that were drawn for this episode; empty where an environment draws none.
    """

    task: str
    random: tuple[int, ...]
    drawn: Drawn


class EnvState(NamedTuple):
    """The state that `ComponentEnv.save` gives and `restore` takes; never changed by what follows.

    Attributes:
        snapshot: the component's state.
        memory: the environment's own numbers, as bytes of float64.
        counters: the task's.
        origin: the start of the episode.
    """

    snapshot: Snapshot
    memory: bytes
    counters: Mapping[str, float]
    origin: EpisodeOrigin

    def to_bytes(self) -> bytes:
        """Return a versioned header and plain arrays; see `support.serialization`."""
        header: dict[str, Any] = {
            "kind": _KIND, **self.origin._asdict(), "counters": {name: value.hex() for name, value in self.counters.items()},
        }  # fmt: skip
        snapshot = np.frombuffer(self.snapshot.to_bytes(), np.uint8)
        return pack(header, {"snapshot": snapshot, "memory": np.frombuffer(self.memory)})

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Read the state that `to_bytes` wrote; `LogError` for anything else."""
        header, arrays = unpack(data)
        try:
            if header["kind"] != _KIND:
                raise LogError(f"these bytes hold a {header['kind']!r}", expected=f"an {_KIND}")
            memory, random = arrays["memory"], tuple(map(int, header["random"]))
            if memory.dtype != np.float64 or not np.isfinite(memory).all() or len(random) != 4:
                raise ValueError("its numbers are none")
            counters = {name: float.fromhex(text) for name, text in header["counters"].items()}
            origin = EpisodeOrigin(header["task"], random, dict(header["drawn"]))
            return cls(Snapshot.from_bytes(arrays["snapshot"].tobytes()), memory.tobytes(), counters, origin)
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            if isinstance(error, LogError):
                raise
            came = f"these bytes are none: {error}"
            raise LogError(came, hint="the data is damaged", source="state of an environment") from error


def random_state(random: Generator) -> tuple[int, ...]:
    """Return the state of a generator of the kind PCG64, with which Gymnasium seeds environments, as four whole numbers."""
    state: Mapping[str, Any] = random.bit_generator.state
    return state["state"]["state"], state["state"]["inc"], state["has_uint32"], state["uinteger"]


def make_generator(numbers: tuple[int, ...]) -> Generator:
    """Return the generator in the state of `random_state`; numbers out of range are reduced, because numpy does not check."""
    state, increment, has_half, half = numbers
    made: Any = PCG64(0)
    words = {"state": state % 2**128, "inc": increment % 2**128}
    made.state = {"bit_generator": "PCG64", "state": words, "has_uint32": has_half % 2, "uinteger": half % 2**32}
    return Generator(made)
