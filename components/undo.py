"""The undo of a step that fails: a copy of the state, and the steps made since it was taken, which are made again."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

import numpy as np

from .inputs import Held
from .profiles import CompiledProfile
from .state_block import Block

# A smaller state is copied at every step, which costs a chain of 200 grains as much as to note the steps, and it is
# restored without a word to the undo [bytes].
_SMALL_STATE = 6 << 10
# Part of the time that copies may take; to note the steps costs a chain of 300 grains half as much again.
_SHARE = 0.015
# What a copy costs beside the copying: to look at the clock, and to begin a new list of steps [s].
_BESIDE_COPY = 1.5e-6
# Steps that are noted at most; and what they may hold of arrays, in sizes of the state.
_MOST_STEPS, _MOST_ARRAYS = 100_000, 4


class Undo:
    """A copy of a component's state, taken now and then, and the steps since.

    The copy of a large state takes as long as a step, or longer. A step gives the same bits whenever it is made, so an older
    copy will do: the steps that were made since are made again.

    Whoever steps asks `prepare` for a copy where `until` is not the tick or there are `limit` steps, and notes each step.

    Attributes:
        memory: the state, as bytes; of one that grows, what has a fixed size.
        buffer: where that is copied to, always into the same place: copies that come and go would leave holes in the heap. Of a
            large state it is empty until there is a copy; a part of a parent never needs one.
        is_small: whether the state is copied into `buffer` at every step, by whoever steps.
        tick: of the copy.
        steps: (ticks, inputs held) of each step since the copy.
        until: tick that the copy and the steps lead to. It is set last: whatever is interrupted, what does not fit is not used.
        limit: number of steps at which to look whether a copy is due.
        counts_arrays: whether steps may hold arrays, so that they have to be noted with `note`.
    """

    def __init__(self, block: Block, *, is_shared: bool, counts_arrays: bool = True) -> None:
        """Take the state's block; `is_shared` where others write to its memory too, so that each step needs a fresh copy."""
        self._block = block
        self.memory = block.memory_bytes
        # The copy: in the buffer, and the rows of lists beside it; or bytes that the state was restored from.
        self._rows, self._restored = b"", b""
        self.tick, self.steps = -1, list[tuple[int, Mapping[str, Held]]]()
        self.until, self.limit, self.counts_arrays = -1, 0, counts_arrays
        self._is_shared = is_shared
        self.is_small = not block.grows and self.memory.nbytes < _SMALL_STATE
        self.buffer = self._make_buffer() if self.is_small else memoryview(b"")
        self._taken = self._seconds = 0.0
        self._array_bytes = 0

    def prepare(self, tick: int) -> None:
        """Take a copy before a step from this tick, where it is time for one."""
        if self.until == tick and not self._is_shared and not self.is_small and not self._is_due():
            return
        self.until = -1
        begin = perf_counter()
        self._copy()
        self._taken = perf_counter()
        self._seconds = self._taken - begin + _BESIDE_COPY
        self.tick, self.steps, self._array_bytes = tick, [], 0
        self.until = tick

    def note(self, ticks: int, held: Mapping[str, Held]) -> None:
        """Note a step that was made, with all inputs that were held."""
        if self.counts_arrays:
            before = self.steps[-1][1] if self.steps else {}
            if held is not before:  # most inputs of the step before are held still
                self._array_bytes += sum(_array_bytes(value) for name, value in held.items() if value is not before.get(name))
                if self._array_bytes > _MOST_ARRAYS * self._block.nbytes:
                    self.limit = 0
        self.steps.append((ticks, held))
        self.until += ticks

    def forget(self) -> None:
        """Let the next step take a copy: the state was changed by something else than a step."""
        self.until = -1

    def load(self) -> None:
        """Put the copy into the component's memory."""
        if self._restored:
            self._block.load(self._restored)
        else:
            self._block.load_parts(self.buffer, self._rows)

    def keep(self, tick: int, data: bytes) -> None:
        """Use what the state was just restored from as the copy, where nobody can change it: the next step takes none."""
        if data.__class__ is bytes and not self._is_shared:
            self._restored, self.tick, self.steps, self._array_bytes = data, tick, [], 0
            self._taken = perf_counter()
            self.until = tick

    def _make_buffer(self) -> memoryview:
        return memoryview(bytearray(self.memory.nbytes))

    def _copy(self) -> None:
        self._rows = self._restored = b""  # the older copy goes first: nothing needs both
        self.buffer = self.buffer or self._make_buffer()
        self.buffer[:] = self.memory
        self._rows = self._block.rows_to_bytes()

    def _is_due(self) -> bool:
        """Return whether a copy is due; set the number of steps at which to ask again, from what a step has taken so far."""
        count = len(self.steps)
        if not count or count < self.limit:
            return False
        if count >= _MOST_STEPS or self._array_bytes > _MOST_ARRAYS * self._block.nbytes:
            self.limit = 1
            return True
        affordable = _SHARE * (perf_counter() - self._taken)
        is_due = affordable >= self._seconds
        wanted = int(count * self._seconds / affordable) if affordable > 0.0 else _MOST_STEPS
        self.limit = max(1, wanted) if is_due else min(max(wanted, count + 1), 2 * count + 1)
        return is_due


def _array_bytes(value: Held) -> int:
    array = value.pattern if isinstance(value, CompiledProfile) else value
    return array.nbytes if isinstance(array, np.ndarray) else 0
