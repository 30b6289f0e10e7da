"""The undo of a step that fails: a copy of the state, and the steps made since it was taken, which are made again."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

import numpy as np

from .inputs import Held
from .profiles import CompiledProfile
from .state_block import Block

# A smaller state is copied at every step, which costs less than to note the steps [bytes].
_SMALL_STATE = 1 << 15
# Part of the time that copies may take.
_SHARE = 0.05
# Steps that are noted at most; and what they may hold of arrays, in sizes of the state.
_MOST_STEPS, _MOST_ARRAYS = 100_000, 4


class Undo:
    """A copy of a component's state, taken now and then, and the steps since.

    The copy of a large state takes as long as a step, or longer. A step gives the same bits whenever it is made, so an older
    copy will do: the steps that were made since are made again.

    Attributes:
        memory: the state, as bytes; of one that grows, what has a fixed size.
        buffer: where a state that does not grow is copied to.
        is_small: whether the state is copied into `buffer` at every step, by whoever steps.
        tick: of the copy.
        steps: (ticks, inputs held) of each step since the copy.
    """

    def __init__(self, block: Block, *, is_shared: bool) -> None:
        """Take the state's block; `is_shared` where others write to its memory too, so that each step needs a fresh copy."""
        self._block = block
        self.memory = block.memory_bytes
        self.buffer = memoryview(bytearray(0 if block.grows else self.memory.nbytes))
        # The copy: in the buffer, or bytes of its own.
        self._data: bytes | memoryview = self.buffer
        self.tick, self.steps = -1, list[tuple[int, Mapping[str, Held]]]()
        # Tick that the copy and the steps lead to. It is set last: whatever is interrupted, what does not fit is not used.
        self._until = -1
        self._is_shared = is_shared
        self._owner: Undo | None = None
        self.is_small = not block.grows and self.memory.nbytes < _SMALL_STATE
        self._taken = self._seconds = 0.0
        self._array_bytes = 0

    def belong_to(self, owner: Undo) -> None:
        """Tell the parent that owns the memory whenever the part is changed beside the parent's steps."""
        self._owner, self.is_small = owner, False

    def prepare(self, tick: int) -> None:
        """Take a copy before a step from this tick, where it is time for one."""
        if self._owner is not None:
            self._owner.forget()
        if self._until != tick or self._is_shared or self.is_small or self._is_due():
            self._until = -1
            begin = perf_counter()
            self._copy()
            self._taken = perf_counter()
            self._seconds = self._taken - begin
            self.tick, self.steps, self._array_bytes = tick, [], 0
            self._until = tick

    def note(self, ticks: int, held: Mapping[str, Held]) -> None:
        """Note a step that was made, with all inputs that were held."""
        before = self.steps[-1][1] if self.steps else {}
        if held is not before:  # most inputs of the step before are held still
            self._array_bytes += sum(_array_bytes(value) for name, value in held.items() if value is not before.get(name))
        self.steps.append((ticks, held))
        self._until += ticks

    def forget(self) -> None:
        """Let the next step take a copy: the state was changed by something else than a step."""
        self._until = -1
        if self._owner is not None:
            self._owner.forget()

    def load(self) -> None:
        """Put the copy into the component's memory."""
        if self._block.grows:
            self._block.load(bytes(self._data))
        else:
            self.memory[:] = self._data

    def keep(self, tick: int, data: bytes) -> None:
        """Use what the state was just restored from as the copy, where nobody can change it: the next step takes none."""
        if data.__class__ is bytes and not self._is_shared:
            self._data, self.tick, self.steps, self._array_bytes = data, tick, [], 0
            self._taken = perf_counter()
            self._until = tick

    def _copy(self) -> None:
        if self._block.grows:
            self._data = self._block.to_bytes()
        else:
            self.buffer[:] = self.memory
            self._data = self.buffer

    def _is_due(self) -> bool:
        is_long = len(self.steps) >= _MOST_STEPS or self._array_bytes > _MOST_ARRAYS * self._block.nbytes
        return is_long or _SHARE * (perf_counter() - self._taken) > self._seconds


def _array_bytes(value: Held) -> int:
    array = value.pattern if isinstance(value, CompiledProfile) else value
    return array.nbytes if isinstance(array, np.ndarray) else 0
