"""An environment in mid-episode, as one small object that any process can go on from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from ..components.contract import Snapshot
from ..components.errors import LogError
from ..components.packing import pack, unpack

_KIND = "environment state"


class EnvState:
    """What `ComponentEnv.save` gives and `restore` takes; never changed by what follows.

    Attributes:
        snapshot: the component's state.
        task: name of the task.
        episode: what else changes in an episode: of a chain's environment the bits of its memory (counters, commands on their
            way, the seed of the noise), otherwise control steps done, whether it goes on, and the task's counters.
        random: state of the environment's random numbers, a mapping that numpy's bit generator gave.
    """

    __slots__ = ("episode", "random", "snapshot", "task")

    def __init__(
        self, snapshot: Snapshot, task: str, episode: bytes | tuple[int, bool, Mapping[str, float]], random: Mapping[str, Any]
    ) -> None:
        self.snapshot, self.task, self.episode, self.random = snapshot, task, episode, random

    def to_bytes(self) -> bytes:
        """A versioned header and plain arrays; see `packing`."""
        header: dict[str, Any] = {"kind": _KIND, "task": self.task, "random": _plain(self.random)}
        arrays: dict[str, np.ndarray] = {"snapshot": np.frombuffer(self.snapshot.to_bytes(), np.uint8)}
        if isinstance(self.episode, bytes):
            arrays["episode"] = np.frombuffer(self.episode, np.int64)
        else:
            elapsed, running, counters = self.episode
            header["episode"] = [elapsed, running, {name: float(value).hex() for name, value in counters.items()}]
        return pack(header, arrays)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """The state that `to_bytes` wrote; `LogError` for anything else."""
        header, arrays = unpack(data)
        try:
            if header["kind"] != _KIND:
                raise LogError(f"these bytes hold a {header['kind']!r}, expected an {_KIND}")
            snapshot = Snapshot.from_bytes(arrays["snapshot"].tobytes())
            task, random = header["task"], header["random"]
            if not isinstance(task, str) or not isinstance(random, dict):
                raise LogError("an environment's state has no task or no random numbers; the data is damaged")
            # The bit generator itself says whether these are a state of its kind.
            getattr(np.random, random["bit_generator"])().state = random
            if "episode" in arrays:
                if arrays["episode"].dtype != np.int64:
                    raise LogError("an environment's memory is not a list of 8-byte words")
                return cls(snapshot, task, arrays["episode"].tobytes(), random)
            elapsed, running, counters = header["episode"]
            if type(elapsed) is not int or type(running) is not bool:
                raise LogError("an environment's state does not say how long its episode lasts; the data is damaged")
            return cls(snapshot, task, (elapsed, running, {name: float.fromhex(t) for name, t in counters.items()}), random)
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            if isinstance(error, LogError):
                raise
            raise LogError(f"these bytes are no state of an environment: {error}") from error


def _plain(value: Any) -> Any:
    """A bit generator's state as JSON has it."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value
