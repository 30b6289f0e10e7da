"""Snapshots: copies of the changing state of a component, from which any process can continue."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from .errors import GranularError, LogError, ParameterError, one_line
from .inputs import Held, make_read_only
from .profiles import CompiledProfile
from .support.float_arrays import FloatArray
from .support.serialization import pack_parts, unpack


class Snapshot:
    """The changing state of a component at one tick, and the identity of the component.

    Attributes:
        identity: hash of the component's name, version and parameters.
        tick: integer time.
        data: bytes of the state.
        inputs: values of the inputs at that tick.
        is_checked: whether the state is known to lie in the ranges that the component declares: True after `save`, and after
            the first `restore` of any other snapshot.
    """

    __slots__ = ("data", "identity", "inputs", "is_checked", "tick")

    def __init__(self, identity: str, tick: int, data: bytes, inputs: Mapping[str, Held], is_checked: bool = False) -> None:
        self.identity, self.tick, self.data, self.inputs, self.is_checked = identity, tick, data, inputs, is_checked

    def __repr__(self) -> str:
        return f"<snapshot at tick {self.tick}, {len(self.data)} bytes, of {self.identity[:12]}>"

    @property
    def memory(self) -> FloatArray:
        """The state as 8-byte words, read-only, shape (words,)."""
        return np.frombuffer(self.data)

    def to_bytes(self) -> bytes:
        """Return a versioned header and plain arrays, independent of the order of the inputs; see `serialization`."""
        return b"".join(self.to_parts())

    def to_parts(self) -> list[bytes | memoryview]:
        """Return the pieces that `to_bytes` joins, without copying the state."""
        inputs = sorted(self.inputs.items())
        numbers = {name: value for name, value in inputs if isinstance(value, float)}
        profiles = {name: value for name, value in inputs if isinstance(value, CompiledProfile)}
        held_arrays = {name: value for name, value in inputs if isinstance(value, np.ndarray)}
        header = {
            "kind": "snapshot",
            "identity": self.identity,
            "tick": self.tick,
            "inputs": {name: value.hex() for name, value in numbers.items()},
            "arrays": list(held_arrays),
            "profiles": {name: value.step_size.hex() for name, value in profiles.items()},
        }
        arrays: dict[str, np.ndarray] = {"memory": self.memory.view(np.int64)}
        for name, value in profiles.items():
            arrays[f"{name}.ticks"], arrays[f"{name}.coefficients"] = value.ticks, value.coefficients
            if value.pattern is not None:
                arrays[f"{name}.pattern"] = value.pattern
        arrays |= {f"{name}.values": value for name, value in held_arrays.items()}
        return pack_parts(header, arrays)

    @classmethod
    def from_bytes(cls, data: bytes, text_limit: int | None = None) -> Self:
        """Return the snapshot written by `to_bytes`; raise `LogError` for other data. `text_limit` is passed to `unpack`."""
        header, arrays = unpack(data, text_limit)
        try:
            if header["kind"] != "snapshot":
                raise LogError(f"these bytes contain a {header['kind']!r}", expected="a snapshot")
            inputs = _decode_inputs(header, arrays)
            memory, tick, identity = arrays["memory"], header["tick"], header["identity"]
            if memory.dtype != np.int64 or memory.ndim != 1:
                raise LogError(
                    f"got {memory.dtype} of shape {memory.shape}", expected="a list of int64", at="memory", source="snapshot"
                )
            if not (isinstance(tick, int) and 0 <= tick <= 2**52 and isinstance(identity, str)):
                raise LogError(f"got {one_line(tick)}", expected="a whole number from 0 to 2^52", at="tick", source="snapshot")
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            if isinstance(error, GranularError) and not isinstance(error, ParameterError):
                raise
            raise LogError(f"these bytes are not a snapshot: {error}", source="snapshot") from error
        return cls(identity, tick, memory.tobytes(), inputs)


def _decode_inputs(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> dict[str, Held]:
    """Return the inputs written by `Snapshot.to_bytes`."""
    inputs: dict[str, Held] = {name: float.fromhex(text) for name, text in header["inputs"].items()}
    inputs |= {name: make_read_only(_float_array(arrays, f"{name}.values")) for name in header["arrays"]}
    if not all(np.isfinite(value).all() for value in inputs.values() if not isinstance(value, CompiledProfile)):
        raise LogError("an input is not finite", at="inputs", source="snapshot")
    for name, step_size in header["profiles"].items():
        ticks, coefficients = arrays[f"{name}.ticks"], _float_array(arrays, f"{name}.coefficients")
        if ticks.dtype != np.int64:
            raise LogError(f"got the dtype {ticks.dtype}", expected="int64", at=(name, "ticks"), source="snapshot")
        pattern = _float_array(arrays, f"{name}.pattern") if f"{name}.pattern" in arrays else None
        inputs[name] = CompiledProfile(float.fromhex(step_size), ticks, coefficients, pattern)
    return inputs


def _float_array(arrays: Mapping[str, np.ndarray], name: str) -> FloatArray:
    if arrays[name].dtype != np.float64:
        raise LogError(f"got the dtype {arrays[name].dtype}", expected="float64", at=name, source="snapshot")
    return arrays[name]
