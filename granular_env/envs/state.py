"""An environment in mid-episode, as one small object that any process can go on from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from ..components.errors import LogError, one_line
from ..components.snapshot import Snapshot
from ..components.support.serialization import pack, unpack

_KIND = "environment state"
_SOURCE = "state of an environment"

Drawn = Mapping[str, Any]
"""Parameters of the component that were drawn for an episode, name -> number, or a distribution with its seed."""


class EpisodeOrigin:
    """The origin of an episode, which all of its states share, so that one of the present episode is recognised at once.

    Attributes:
        task: name of the task.
        random: state of the environment's random numbers, a mapping that numpy's bit generator gave.
        drawn: parameters of the component that were drawn for this episode; empty where an environment draws none.
    """

    __slots__ = ("drawn", "random", "task")

    def __init__(self, task: str, random: Mapping[str, Any], drawn: Drawn) -> None:
        self.task, self.random, self.drawn = task, random, drawn


class EnvState:
    """The state that `ComponentEnv.save` gives and `restore` takes; never changed by what follows.

    Attributes:
        snapshot: the component's state.
        memory: the environment's own numbers, as bytes of float64.
        counters: the task's, where they are not in the memory.
        origin: the start of the episode.
    """

    __slots__ = ("counters", "memory", "origin", "snapshot")

    def __init__(self, snapshot: Snapshot, memory: bytes, counters: Mapping[str, float], origin: EpisodeOrigin) -> None:
        self.snapshot, self.memory, self.counters, self.origin = snapshot, memory, counters, origin

    def __eq__(self, other: object) -> bool:
        """Return whether both hold the same bits."""
        return self.to_bytes() == other.to_bytes() if isinstance(other, EnvState) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.origin.task, self.snapshot.tick, self.snapshot.data))

    def __repr__(self) -> str:
        end = f", drawn={dict(self.origin.drawn)}" if self.origin.drawn else ""
        return f"EnvState({self.origin.task!r}, tick={self.snapshot.tick}, component={self.snapshot.identity[:12]}...{end})"

    def to_bytes(self) -> bytes:
        """Return a versioned header and plain arrays; see `support.serialization`."""
        header: dict[str, Any] = {
            "kind": _KIND, "task": self.origin.task, "random": _plain(self.origin.random), "drawn": _plain(self.origin.drawn),
            "counters": {name: float(value).hex() for name, value in self.counters.items()},
        }  # fmt: skip
        snapshot = np.frombuffer(self.snapshot.to_bytes(), np.uint8)
        return pack(header, {"snapshot": snapshot, "memory": np.frombuffer(self.memory, np.float64)})

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Read the state that `to_bytes` wrote; `LogError` for anything else."""
        header, arrays = unpack(data)
        try:
            if header["kind"] != _KIND:
                raise LogError(f"these bytes hold a {header['kind']!r}", expected=f"an {_KIND}")
            task, random, drawn, memory = header["task"], header["random"], header["drawn"], arrays["memory"]
            bit_generator(random)
            if not isinstance(task, str) or not _is_drawn(drawn) or memory.dtype != np.float64 or memory.ndim != 1:
                raise LogError("its task, memory or drawn parameters are none", hint="the data is damaged", source=_SOURCE)
            counters = {str(name): float.fromhex(text) for name, text in header["counters"].items()}
            snapshot = Snapshot.from_bytes(arrays["snapshot"].tobytes())
            return cls(snapshot, memory.tobytes(), counters, EpisodeOrigin(task, random, drawn))
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            if isinstance(error, LogError):
                raise
            raise LogError(f"these bytes are none: {error}", hint="the data is damaged", source=_SOURCE) from error


def bit_generator(state: Mapping[str, Any]) -> np.random.PCG64:
    """Return a bit generator in a state that `PCG64.state` of numpy gave: the kind that Gymnasium seeds environments with.

    Numpy itself does not check the states of bit generators, and reads memory wherever they point.

    Raises:
        ValueError: it is the state of another kind, or none.
    """
    if state.get("bit_generator") != "PCG64":
        raise ValueError(f"bit_generator: got {one_line(state.get('bit_generator'))}, expected 'PCG64'")
    words, bound = state.get("state"), {"state": 2**128, "inc": 2**128, "has_uint32": 2, "uinteger": 2**32}
    numbers = {**state, **words} if isinstance(words, Mapping) else {}
    for name, limit in bound.items():
        value = numbers.get(name)
        if type(value) is not int or not 0 <= value < limit:
            raise ValueError(f"{name}: got {one_line(value)}, expected a whole number from 0 to {limit - 1}")
    made: Any = np.random.PCG64(0)
    made.state = dict(state)
    return made


def _is_drawn(drawn: Any) -> bool:
    """Return whether drawn parameters are finite numbers, or mappings of them."""
    numbers = [one for value in drawn.values() for one in (value.values() if isinstance(value, dict) else [value])]
    return all(type(number) in (int, float) and math.isfinite(number) for number in numbers)


def _plain(value: Any) -> Any:
    """Return a bit generator's state or drawn parameters as JSON has them."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value
