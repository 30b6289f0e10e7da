"""The changing state of a component: the memory it lies in, and a copy of it that any process can go on from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Self

import numpy as np
import numpy.typing as npt

from .errors import GranularError, LogError, ParameterError
from .inputs import Held
from .profiles import CompiledProfile
from .support.serialization import pack, unpack

FloatArray = npt.NDArray[np.float64]


class Block:
    """The changing state of a component: one block of memory with named views, so that a snapshot is one copy."""

    def __init__(self, memory: FloatArray | None = None, /, **fields: tuple[str, tuple[int, ...]]) -> None:
        """Lay out `fields`, name -> (dtype of 8 bytes, shape), one after the other, in fresh zeros or in the memory given."""
        sizes = {name: math.prod(shape) for name, (_, shape) in fields.items()}
        self.memory: FloatArray = np.zeros(sum(sizes.values())) if memory is None else memory
        self.views: dict[str, np.ndarray] = {}
        offset = 0
        for name, (dtype, shape) in fields.items():
            part = self.memory[offset : offset + sizes[name]]
            self.views[name] = part.view(dtype).reshape(shape)
            offset += sizes[name]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.views[name]


class Snapshot:
    """Everything that changes in a component, at one tick, and the identity of the component it belongs to.

    Attributes:
        identity: hash of the component's name, version and parameters.
        tick: integer time.
        data: the state's bits, as bytes: the quickest copy there is from Python.
        inputs: the inputs held at that moment.
    """

    __slots__ = ("data", "identity", "inputs", "tick")

    def __init__(self, identity: str, tick: int, data: bytes, inputs: Mapping[str, Held]) -> None:
        self.identity, self.tick, self.data, self.inputs = identity, tick, data, inputs

    def __repr__(self) -> str:
        return f"<snapshot at tick {self.tick}, {len(self.data)} bytes, of {self.identity[:12]}>"

    @property
    def memory(self) -> FloatArray:
        """The state as 8-byte words, read-only, shape (words,)."""
        return np.frombuffer(self.data)

    def to_bytes(self) -> bytes:
        """A versioned header and plain arrays; see `packing`."""
        numbers = {name: value for name, value in self.inputs.items() if not isinstance(value, CompiledProfile)}
        profiles = {name: value for name, value in self.inputs.items() if isinstance(value, CompiledProfile)}
        header = {
            "kind": "snapshot",
            "identity": self.identity,
            "tick": self.tick,
            "inputs": {name: float(value).hex() for name, value in numbers.items()},
            "profiles": {name: value.step_size.hex() for name, value in profiles.items()},
        }
        arrays: dict[str, np.ndarray] = {"memory": self.memory.view(np.int64)}
        for name, value in profiles.items():
            arrays[f"{name}.ticks"], arrays[f"{name}.coefficients"] = value.ticks, value.coefficients
        return pack(header, arrays)

    @classmethod
    def from_bytes(cls, data: bytes, most_text: int | None = None) -> Self:
        """Return the snapshot that `to_bytes` wrote; `LogError` for anything else. `most_text` is that of `unpack`."""
        header, arrays = unpack(data, most_text)
        try:
            if header["kind"] != "snapshot":
                raise LogError(f"these bytes hold a {header['kind']!r}, expected a snapshot")
            inputs: dict[str, Held] = {name: float.fromhex(text) for name, text in header["inputs"].items()}
            if not all(math.isfinite(value) for value in inputs.values() if not isinstance(value, CompiledProfile)):
                raise LogError("a snapshot holds an input that is not finite")
            for name, step_size in header["profiles"].items():
                ticks, coefficients = arrays[f"{name}.ticks"], arrays[f"{name}.coefficients"]
                if ticks.dtype != np.int64 or coefficients.dtype != np.float64:
                    raise LogError(f"the profile of {name!r} in a snapshot has the wrong dtype")
                inputs[name] = CompiledProfile(float.fromhex(step_size), ticks, coefficients)
            memory, tick, identity = arrays["memory"], header["tick"], header["identity"]
            if memory.dtype != np.int64 or memory.ndim != 1:
                raise LogError("a snapshot's memory is not a list of 8-byte words")
            if not (isinstance(tick, int) and 0 <= tick < 2**62 and isinstance(identity, str)):
                raise LogError(f"a snapshot has tick {tick!r}, expected a whole number from 0")
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            if isinstance(error, GranularError) and not isinstance(error, ParameterError):
                raise
            raise LogError(f"these bytes are no snapshot: {error}") from error
        return cls(identity, tick, memory.tobytes(), inputs)
