"""The memory of the changing state of a component: a fixed part with named views, and lists that grow."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .errors import GranularError, ParameterError
from .support.float_arrays import FloatArray
from .support.memory_limits import refuse_excess_memory

_FIRST_CAPACITY = 16
LARGEST = sys.float_info.max


class Field(NamedTuple):
    """Declaration of one array of a state, or of the rows of a growing list; a plain tuple is accepted too.

    Attributes:
        dtype: 8-byte type: "f8", "i8" or "u8".
        shape: shape of the array, or of one row of a list.
        low: smallest value, a number or an array that broadcasts to the shape. By default floats may be any finite number;
            integers need both limits.
        high: largest value, with the same shape and default.
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

    All data of fixed size lie in one array, so that a snapshot is one copy. A list has a separate array, whose capacity grows
    between ticks; a snapshot contains the rows in use. The numbers of rows in use are the last words of the memory.
    A parent that owns the memory of its parts therefore also owns the row counts of their lists; `include_part` adds the rows.

    Attributes:
        memory: all data of fixed size, shape (words,).
        memory_bytes: the same memory as bytes.
        views: arrays in this memory, by name.
        grows: whether there are lists, in this block or in parts.
    """

    def __init__(self, memory: FloatArray | None = None, /, growing: Layout | None = None, **fields: tuple[Any, ...]) -> None:
        """Lay out the state in new zeroed memory, or in the given memory.

        Args:
            memory: shape (words,).
            growing: name of a list -> the `Field` of its rows.
            **fields: name -> `Field`, in order.
        """
        lists = {name: Field(*field) for name, field in (growing or {}).items()}
        layout = {name: Field(*field) for name, field in fields.items()}
        # Declared ranges, which `refuse_out_of_range` checks.
        self.fields = {**layout, **lists}
        if lists:
            layout["_counts"] = Field("i8", (len(lists),))
        sizes = {name: math.prod(field.shape) for name, field in layout.items()}
        self.memory: FloatArray = np.zeros(sum(sizes.values())) if memory is None else memory
        # Assignment between byte views is the fastest copy in Python.
        self.memory_bytes = self.memory.reshape(-1).data.cast("B")
        self.views: dict[str, np.ndarray] = {}
        self._words = dict[str, int]()  # first word of each view
        offset = 0
        for name, field in layout.items():
            part = self.memory[offset : offset + sizes[name]]
            self.views[name], self._words[name] = part.view(field.dtype).reshape(field.shape), offset
            offset += sizes[name]
        self._lists = {name: np.zeros((_FIRST_CAPACITY, *field.shape), field.dtype) for name, field in lists.items()}
        self._places = {name: place for place, name in enumerate(lists)}
        # Lists of this block and of its parts, whose counts are in this memory.
        self._tables: list[tuple[Block, str]] = [(self, name) for name in lists]
        self.grows = bool(lists)
        # Allocated once, at the first call: repeated large allocations would fragment the heap.
        self._backup, self._backup_rows = memoryview(b""), b""

    def include_part(self, part: Block) -> None:
        """Include the lists of a part, whose memory is a section of this memory, in backups and snapshots of this block."""
        # The part itself declares the ranges of its memory.
        for name, view in self.views.items():
            if np.may_share_memory(view, part.memory):
                self.fields.pop(name, None)
        self._tables += part._tables
        self.grows = bool(self._tables)

    def _first_word(self, part: Block) -> int:
        """Return the index of the word of this memory at which the memory of a part begins; 0 for this block itself."""
        return 0 if part is self else (part.memory.ctypes.data - self.memory.ctypes.data) // 8

    def __getitem__(self, name: str) -> np.ndarray:
        return self.views[name] if name in self.views else self._lists[name][: self.count(name)]

    def __setitem__(self, name: str, value: Any) -> None:
        self[name][...] = value

    @property
    def nbytes(self) -> int:
        """Size of the state [bytes]; lists count with their rows in use."""
        return self.memory.nbytes + sum(block[name].nbytes for block, name in self._tables)

    # -- lists ------------------------------------------------------------------------------------------------------

    def count(self, name: str) -> int:
        """Return the number of rows in use of a list; 0 if there is no such list."""
        place = self._places.get(name)
        return 0 if place is None else int(self.views["_counts"][place])

    def reserve_rows(self, name: str, rows: int) -> np.ndarray:
        """Return the whole array of a list, with capacity for `rows` more; call `set_row_count` afterwards.

        Raises:
            GranularError: it does not fit into memory.
        """
        used, array = self.count(name), self._lists[name]
        if used + rows > len(array):
            capacity = max(2 * len(array), used + rows)
            refuse_excess_memory(capacity * array[:1].nbytes, f"the list {name!r} with {capacity} rows", GranularError)
            larger = np.zeros((capacity, *array.shape[1:]), array.dtype)
            larger[:used] = array[:used]
            self._lists[name] = array = larger
        return array

    def set_row_count(self, name: str, count: int) -> None:
        """Set the number of rows in use of a list, within the capacity from `reserve_rows`."""
        self.views["_counts"][self._places[name]] = count

    def append(self, name: str, row: Any) -> None:
        """Append a row to a list."""
        count = self.count(name)
        self.reserve_rows(name, 1)[count] = row
        self.set_row_count(name, count + 1)

    # -- copies -----------------------------------------------------------------------------------------------------

    def clear(self) -> None:
        """Set all memory to 0, which empties the lists."""
        self.memory[:] = 0.0

    def back_up(self) -> None:
        """Copy the state, for `restore_backup`."""
        if not self._backup:
            self._backup = memoryview(bytearray(self.memory.nbytes))
        self._backup[:] = self.memory_bytes
        if self.grows:
            self._backup_rows = b"".join(self._list_rows())

    def restore_backup(self) -> None:
        """Restore the state copied by `back_up`."""
        self._load_parts(self._backup, self._backup_rows)

    def to_bytes(self) -> bytes:
        """Return the state: the fixed part, then the rows in use of each list."""
        return b"".join([self.memory_bytes, *self._list_rows()]) if self.grows else bytes(self.memory_bytes)

    def load_bytes(self, data: bytes) -> None:
        """Restore a state from `to_bytes` that `list_sizes` has checked."""
        if self.grows:
            whole, fixed = memoryview(data), self.memory.nbytes
            self._load_parts(whole[:fixed], whole[fixed:])
        else:
            self.memory_bytes[:] = data

    def _list_rows(self) -> list[memoryview]:
        return [block[name].data for block, name in self._tables]

    def _load_parts(self, fixed_part: memoryview, rows: bytes | memoryview) -> None:
        words, offset = np.frombuffer(fixed_part, np.int64), 0
        for block, name in self._tables:
            array, count = block._lists[name], int(words[self._count_word(block, name)])
            kept = np.frombuffer(rows, array.dtype, count * array[:1].size, offset).reshape(count, *array.shape[1:])
            block.set_row_count(name, 0)
            block.reserve_rows(name, count)[:count] = kept
            offset += kept.nbytes
        self.memory_bytes[:] = fixed_part

    def _count_word(self, block: Block, name: str) -> int:
        """Return the index of the word of this memory that holds the row count of a list of this block or of a part."""
        return self._first_word(block) + block.memory.size - len(block._lists) + block._places[name]

    # -- states of unknown origin -----------------------------------------------------------------------------------

    def list_sizes(self, data: bytes) -> list[int] | None:
        """Return the bytes of each list in a state from `to_bytes`; None if it is not such a state."""
        fixed = self.memory.nbytes
        if len(data) < fixed:
            return None
        words = np.frombuffer(data, np.int64, fixed // 8)
        counts = [int(words[self._count_word(block, name)]) for block, name in self._tables]
        sizes = [count * block._lists[name][:1].nbytes for count, (block, name) in zip(counts, self._tables, strict=True)]
        return sizes if all(count >= 0 for count in counts) and fixed + sum(sizes) == len(data) else None

    def state_arrays(self, data: bytes, part: Block) -> dict[str, np.ndarray]:
        """Return the arrays and lists of this block, or of an included part, in a state accepted by `list_sizes`."""
        words, start = np.frombuffer(data, np.int64), self._first_word(part)
        found: dict[str, np.ndarray] = {}
        for name, view in part.views.items():
            begin = start + part._words[name]
            found[name] = words[begin : begin + view.size].view(view.dtype).reshape(view.shape)
        begin = self.memory.size
        for (block, name), size in zip(self._tables, self.list_sizes(data) or [], strict=True):
            if block is part:
                rows = block._lists[name]
                found[name] = words[begin : begin + size // 8].view(rows.dtype).reshape(-1, *rows.shape[1:])
            begin += size // 8
        return found

    def refuse_out_of_range(self, arrays: Mapping[str, np.ndarray], at: tuple[str, ...]) -> None:
        """Check the arrays of `state_arrays` against the declared ranges and capacities.

        Raises:
            ParameterError: a value or the length of a list is out of range.
        """
        for name, field in self.fields.items():
            array = arrays[name]
            if name in self._lists and len(array) > field.capacity:
                raise ParameterError(f"got {len(array)} rows", expected=f"at most {field.capacity}", at=(*at, name))
            sound = (array >= field.low) & (array <= field.high)  # False for NaN
            if not sound.all():
                where = tuple(np.argwhere(~sound)[0].tolist())
                low, high = (np.broadcast_to(limit, array.shape)[where] for limit in (field.low, field.high))
                expected = f"{low:.17g} to {high:.17g}"
                if high >= LARGEST:
                    expected = "a finite number" if low == -LARGEST else f"{low:.17g} or more"
                raise ParameterError(f"got {array[where]:.17g}", expected=expected, at=(*at, name, *where))
