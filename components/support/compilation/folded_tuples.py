"""Instructions of tuples that need none: what is put into a tuple and taken out again is taken from where it was.

Numba puts a tuple of arrays together where a function begins, and takes it apart for each field and each call: more than half
of all instructions that it writes, which LLVM has to read and to remove again.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

from llvmlite.ir import IRBuilder
from llvmlite.ir.instructions import ExtractValue, InsertValue, PhiInstr

# What has no effect but its result.
_PURE = (InsertValue, ExtractValue)


class FoldingBuilder(IRBuilder):
    """A builder that takes a field of a tuple from where it was put in."""

    def extract_value(self, agg: Any, idx: Any, name: str = "") -> Any:
        """Return a field; an instruction is written where it is not known."""
        place = tuple(idx) if isinstance(idx, tuple | list) else (idx,)
        while isinstance(agg, InsertValue) and len(agg.indices) == len(place) == 1:
            if tuple(agg.indices) == place:
                return agg.value
            agg = agg.aggregate
        return super().extract_value(agg, place, name)


def remove_unused_fields(function: Any) -> None:
    """Remove instructions of tuples whose results nobody uses from a function that is complete."""
    uses: Counter[int] = Counter()
    for block in function.blocks:
        for instruction in block.instructions:
            uses.update(map(id, _used(instruction)))
    for block in reversed(function.blocks):
        kept = []
        for instruction in reversed(block.instructions):
            if isinstance(instruction, _PURE) and not uses[id(instruction)]:
                uses.subtract(map(id, instruction.operands))
            else:
                kept.append(instruction)
        block.instructions[:] = reversed(kept)


def _used(instruction: Any) -> Any:
    if isinstance(instruction, PhiInstr):
        return [value for value, _ in instruction.incomings]
    return instruction.operands
