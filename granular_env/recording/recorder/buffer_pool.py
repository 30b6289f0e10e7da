"""Memory for large frames, used again and again: fresh pages cost the stepping thread far more than the copy into them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

# Smaller arrays come from memory that the process has at hand anyway [bytes].
_LEAST_BYTES = 1 << 16
_MOST_BYTES = 64 << 20


class BufferPool:
    """Copies of arrays, into buffers that come back once they have been written. One thread copies, another gives back."""

    def __init__(self) -> None:
        self._free: dict[tuple[int, ...], list[np.ndarray]] = {}

    def copy(self, value: Any) -> Any:
        """Return a number, or a copy of an array."""
        if value.__class__ is not np.ndarray or value.nbytes < _LEAST_BYTES:
            return np.array(value) if isinstance(value, np.ndarray) else value
        free = self._free.get(value.shape)
        buffer = free.pop() if free else np.empty(value.shape)
        np.copyto(buffer, value)
        return buffer

    def take_back(self, values: Iterable[Any]) -> None:
        """Keep buffers that nobody reads any more, to be used again."""
        for value in values:
            if value.__class__ is np.ndarray and value.nbytes >= _LEAST_BYTES:
                free = self._free.setdefault(value.shape, [])
                if len(free) * value.nbytes < _MOST_BYTES:
                    free.append(value)
