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

Drawn = Mapping[str, float | Mapping[str, float]]
"""Parameters of the component that were drawn for an episode, name -> number, or the limits and the seed of a draw."""


class EpisodeOrigin:
    """The origin of an episode, which all of its states share, so that one of the present episode is known at once.

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
        episode: what else changes in an episode: control steps done, whether it goes on, and the task's counters; of an
            environment that a compiled batch can run the bits of its memory.
        origin: what the episode began with.
    """

    __slots__ = ("origin", "episode", "snapshot")

    def __init__(
        self, snapshot: Snapshot, episode: bytes | tuple[int, bool, Mapping[str, float]], origin: EpisodeOrigin
    ) -> None:
        self.snapshot, self.episode, self.origin = snapshot, episode, origin

    def __eq__(self, other: object) -> bool:
        """Return whether both hold the same bits."""
        return self.to_bytes() == other.to_bytes() if isinstance(other, EnvState) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.origin.task, self.snapshot.tick, self.snapshot.data))

    def __repr__(self) -> str:
        task, drawn = self.origin.task, dict(self.origin.drawn)
        end = f", drawn={drawn}" if drawn else ""
        return f"EnvState({task!r}, tick={self.snapshot.tick}, component={self.snapshot.identity[:12]}...{end})"

    def to_bytes(self) -> bytes:
        """Return a versioned header and plain arrays; see `support.serialization`."""
        header: dict[str, Any] = {"kind": _KIND, "task": self.origin.task, "random": _plain(self.origin.random)}
        if self.origin.drawn:
            header["drawn"] = _plain(self.origin.drawn)
        arrays: dict[str, np.ndarray] = {"snapshot": np.frombuffer(self.snapshot.to_bytes(), np.uint8)}
        if isinstance(self.episode, bytes):
            arrays["episode"] = np.frombuffer(self.episode, np.int64)
        else:
            elapsed, running, counters = self.episode
            header["episode"] = [elapsed, running, {name: float(value).hex() for name, value in counters.items()}]
        return pack(header, arrays)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Read the state that `to_bytes` wrote; `LogError` for anything else."""
        header, arrays = unpack(data)
        try:
            if header["kind"] != _KIND:
                raise LogError(f"these bytes hold a {header['kind']!r}", expected=f"an {_KIND}")
            task, random = header["task"], header["random"]
            if not isinstance(task, str) or not isinstance(random, dict):
                raise LogError("no task or no random numbers", hint="the data is damaged", source="state of an environment")
            bit_generator(random)
            drawn = _validate_drawn(header.get("drawn", {}))
            episode = arrays["episode"] if "episode" in arrays else _validate_episode(*header["episode"])
            if isinstance(episode, np.ndarray):
                if episode.dtype != np.int64 or episode.ndim != 1:
                    raise LogError(
                        f"got {episode.dtype} of shape {episode.shape}",
                        expected="a list of int64",
                        at="episode",
                        source="state of an environment",
                    )
                episode = episode.tobytes()
            return cls(Snapshot.from_bytes(arrays["snapshot"].tobytes()), episode, EpisodeOrigin(task, random, drawn))
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            if isinstance(error, LogError):
                raise
            raise LogError(
                f"these bytes are none: {error}", hint="the data is damaged", source="state of an environment"
            ) from error


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


def _validate_episode(elapsed: Any, running: Any, counters: Any) -> tuple[int, bool, dict[str, float]]:
    if type(elapsed) is not int or elapsed < 0 or type(running) is not bool:
        raise LogError("an environment's state does not say how long its episode lasts", hint="the data is damaged")
    return elapsed, running, {str(name): float.fromhex(text) for name, text in counters.items()}


def _validate_drawn(drawn: Any) -> dict[str, float | dict[str, float]]:
    if not isinstance(drawn, dict):
        raise LogError("an environment's state has drawn parameters that are no mapping", hint="the data is damaged")
    for name, value in drawn.items():
        numbers = value.values() if isinstance(value, dict) else [value]
        if not all(type(number) in (int, float) and math.isfinite(number) for number in numbers):
            raise LogError(f"an environment's state has {name!r} drawn as no finite number", hint="the data is damaged")
    return drawn


def _plain(value: Any) -> Any:
    """Return a bit generator's state as JSON has it."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value
