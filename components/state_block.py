"""The memory that the changing state of a component lies in: a fixed part with named views, and lists that grow."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .errors import GranularError, ParameterError
from .support.float_arrays import FloatArray
from .support.memory_limits import refuse_beyond

_FIRST_CAPACITY = 16
LARGEST = sys.float_info.max


class Field(NamedTuple):
    """The declaration of one array of a state, or of the rows of a list that grows; a plain tuple will do.

    Without limits a float may be any finite number.

    Attributes:
        dtype: of 8 bytes: "f8", "i8" or "u8".
        shape: of the array, or of one row of a list.
        low: smallest value, a number or an array that broadcasts against the shape; integers need both limits.
        high: largest value, likewise.
        capacity: largest number of rows of a list.
    """

    dtype: str
    shape: tuple[int, ...]
    low: Any = -LARGEST
    high: Any = LARGEST
    capacity: int = 2**53


Layout = Mapping[str, tuple[Any, ...]]


class Block:
    """The changing state of a component: memory with named views, and lists that grow.

    What has a fixed size lies in one piece of memory, so that a snapshot is one copy. A list that grows has an array with a
    capacity, which is raised between ticks; a snapshot holds the rows in use. The numbers of rows in use are the last words of
    the memory, so a parent that owns the memory of parts has those of their lists too, and with `include` the rows.

    Attributes:
        memory: what has a fixed size, shape (words,).
        memory_bytes: the same as bytes.
        views: each part of it, by name.
        grows: whether there are lists, of its own or of parts.
    """

    def __init__(
        self,
        memory: FloatArray | None = None,
        /,
        growing: Layout | None = None,
        **fields: tuple[Any, ...],
    ) -> None:
        """Lay out the state in fresh zeros, or in the memory given.

        Args:
            memory: shape (words,); see `words`.
            growing: name of a list -> the `Field` of its rows.
            **fields: name -> `Field`, one after the other.

        Raises:
            ParameterError: a dtype of another size, or integers without a range.
        """
        lists = growing or {}
        # What `refuse_beyond_range` checks, by name.
        self._fields = {name: Field(*field) for name, field in (*fields.items(), *lists.items())}
        for name, field in self._fields.items():
            kind = np.dtype(field.dtype)
            if kind.itemsize != 8 or kind.kind not in "iuf":
                raise ParameterError(f"got the type {field.dtype!r}", expected="'f8', 'i8' or 'u8'", at=("state", name))
            if kind.kind != "f" and (np.min(field.low) == -LARGEST or np.max(field.high) == LARGEST):
                expected = f"their smallest and largest value, such as ({field.dtype!r}, {field.shape}, 0, 9)"
                raise ParameterError("got integers without a range", expected=expected, at=("state", name))
        layout = {name: self._fields[name] for name in fields}
        if lists:
            layout["_counts"] = Field("i8", (len(lists),))
        sizes = {name: math.prod(field.shape) for name, field in layout.items()}
        self.memory: FloatArray = np.zeros(sum(sizes.values())) if memory is None else memory
        # Assigning between byte views is the quickest copy there is from Python.
        self.memory_bytes = self.memory.reshape(-1).data.cast("B")
        self.views: dict[str, np.ndarray] = {}
        self._words = dict[str, int]()  # at which each of them begins
        offset = 0
        for name, field in layout.items():
            part = self.memory[offset : offset + sizes[name]]
            self.views[name], self._words[name] = part.view(field.dtype).reshape(field.shape), offset
            offset += sizes[name]
        self._lists = {name: np.zeros((_FIRST_CAPACITY, *self._fields[name].shape), self._fields[name].dtype) for name in lists}
        self._places = {name: place for place, name in enumerate(lists)}
        # All lists whose counts lie in this memory: its own, and those of parts.
        self._tables: list[tuple[Block, str]] = [(self, name) for name in lists]
        self.grows = bool(lists)

    def include(self, part: Block) -> None:
        """Take the lists of a part, which lies in this block's memory, into copies of this one; they stay the part's.

        Raises:
            ValueError: the part lies elsewhere.
        """
        if not np.shares_memory(self.memory, part.memory) or self._word_of(part) + part.memory.size > self.memory.size:
            raise ValueError("the part does not lie in this block's memory")
        # The part declares what may lie there.
        for name, view in self.views.items():
            if np.may_share_memory(view, part.memory):
                self._fields.pop(name, None)
        self._tables += part._tables
        self.grows = bool(self._tables)

    def _word_of(self, part: Block) -> int:
        """Return the number of the word of this memory at which that of a part, or of itself, begins."""
        return 0 if part is self else (part.memory.ctypes.data - self.memory.ctypes.data) // 8

    def _count_word(self, name: str) -> int:
        """Return the number of the word of this memory that holds how long a list is: they are the last ones."""
        return self.memory.size - len(self._lists) + self._places[name]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.views[name] if name in self.views else self._lists[name][: self.count(name)]

    def __setitem__(self, name: str, value: Any) -> None:
        self[name][...] = value

    @property
    def nbytes(self) -> int:
        """Bytes of the state, of lists the rows in use."""
        return self.memory.nbytes + sum(block[name].nbytes for block, name in self._tables)

    def has_list(self, name: str) -> bool:
        """Return whether there is a list of this name that grows."""
        return name in self._lists

    def count(self, name: str) -> int:
        """Return how many rows of a list are in use; 0 where there is no such list."""
        place = self._places.get(name)
        return 0 if place is None else int(self.views["_counts"][place])

    def room(self, name: str, rows: int) -> np.ndarray:
        """Return the whole array of a list, its capacity raised so that so many further rows fit; then set `set_count`.

        Raises:
            GranularError: there is not so much memory.
        """
        used, array = self.count(name), self._lists[name]
        if used + rows > len(array):
            capacity = max(2 * len(array), used + rows)
            refuse_beyond(capacity * array[:1].nbytes, f"the list {name!r} with {capacity} rows", GranularError)
            larger = np.zeros((capacity, *array.shape[1:]), array.dtype)
            larger[:used] = array[:used]
            self._lists[name] = array = larger
        return array

    def set_count(self, name: str, count: int) -> None:
        """Say how many rows of a list are in use.

        Raises:
            ValueError: the list has no room for them.
        """
        if not 0 <= count <= len(self._lists[name]):
            raise ValueError(f"the list {name!r} has room for {len(self._lists[name])} rows, got {count}: call `room` first")
        self.views["_counts"][self._places[name]] = count

    def append(self, name: str, row: Any) -> None:
        """Put a row at the end of a list.

        Raises:
            ValueError: there is no such list, or its rows have another length.
        """
        if name not in self._lists:
            raise ValueError(f"there is no list {name!r} that grows; known: {', '.join(self._lists) or 'none'}")
        count = self.count(name)
        self.room(name, 1)[count] = row
        self.set_count(name, count + 1)

    def clear(self) -> None:
        """Set all to 0, lists to no rows."""
        self.memory[:] = 0.0

    def to_bytes(self) -> bytes:
        """Return the state: the fixed part, then the rows in use of each list."""
        if not self._tables:
            return self.memory.tobytes()
        return b"".join([self.memory.data, *self._rows()])

    def rows_to_bytes(self) -> bytes:
        """Return the rows in use of each list, which `to_bytes` puts behind the fixed part."""
        return b"".join(self._rows())

    def _rows(self) -> list[memoryview]:
        return [block[name].data for block, name in self._tables]

    def sizes_in(self, data: bytes) -> list[int] | None:
        """Return the bytes of each list in a state that `to_bytes` gave; None where it is no such state."""
        fixed = self.memory.nbytes
        if not self._tables:  # as usual, and on the way of every restore of an environment
            return [] if len(data) == fixed else None
        if len(data) < fixed:
            return None
        words = np.frombuffer(data, np.int64, fixed // 8)
        counts = [int(words[self._word_of(block) + block._count_word(name)]) for block, name in self._tables]
        sizes = [count * block._lists[name][:1].nbytes for count, (block, name) in zip(counts, self._tables, strict=True)]
        return sizes if all(count >= 0 for count in counts) and fixed + sum(sizes) == len(data) else None

    def arrays_in(self, data: bytes, part: Block) -> dict[str, np.ndarray]:
        """Return the arrays and lists of this block, or of an included part, in a state for which `sizes_in` gave sizes."""
        words, start = np.frombuffer(data, np.int64), self._word_of(part)
        found: dict[str, np.ndarray] = {}
        for name, view in part.views.items():
            begin = start + part._words[name]
            found[name] = words[begin : begin + view.size].view(view.dtype).reshape(view.shape)
        begin = self.memory.size
        for (block, name), size in zip(self._tables, self.sizes_in(data) or [], strict=True):
            if block is part:
                rows = block._lists[name]
                found[name] = words[begin : begin + size // 8].view(rows.dtype).reshape(-1, *rows.shape[1:])
            begin += size // 8
        return found

    def refuse_beyond_range(self, arrays: Mapping[str, np.ndarray], at: tuple[str, ...]) -> None:
        """Check what `arrays_in` gave of this block against the declared ranges and capacities.

        Raises:
            ParameterError: a value or the length of a list is out of range.
        """
        for name, field in self._fields.items():
            array = arrays[name]
            if name in self._lists and len(array) > field.capacity:
                raise ParameterError(f"got {len(array)} rows", expected=f"at most {field.capacity}", at=(*at, name))
            sound = (array >= field.low) & (array <= field.high)  # NaN is neither
            if not sound.all():
                where = tuple(np.argwhere(~sound)[0].tolist())
                low, high = (np.broadcast_to(limit, array.shape)[where] for limit in (field.low, field.high))
                expected = f"{low:.17g} to {high:.17g}"
                if high >= LARGEST:
                    expected = "a finite number" if low == -LARGEST else f"{low:.17g} or more"
                raise ParameterError(f"got {array[where]:.17g}", expected=expected, at=(*at, name, *where))

    def load(self, data: bytes) -> None:
        """Go back to a state that `to_bytes` gave; `ValueError` where it is none of this layout."""
        if self.sizes_in(data) is None:
            raise ValueError(f"a state of {len(data)} bytes")
        whole, fixed = memoryview(data), self.memory.nbytes
        self.load_parts(whole[:fixed], whole[fixed:])

    def load_parts(self, fixed: memoryview, rows: bytes | memoryview) -> None:
        """Go back to a state: `memory_bytes` as they were, and what `rows_to_bytes` gave then."""
        words, offset = np.frombuffer(fixed, np.int64), 0
        for block, name in self._tables:
            array, count = block._lists[name], int(words[self._word_of(block) + block._count_word(name)])
            kept = np.frombuffer(rows, array.dtype, count * array[:1].size, offset).reshape(count, *array.shape[1:])
            block.set_count(name, 0)
            block.room(name, count)[:count] = kept
            offset += kept.nbytes
        self.memory[:] = words.view(np.float64)
