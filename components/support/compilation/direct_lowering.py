"""Numba's lowering without the stack: a variable that is assigned once is its value, where numba stores it and reads it again.

A tuple of many arrays is hundreds of numbers: to read it for each of its fields makes a program so long that LLVM takes half of
its time to shorten it again. The same machine code comes out.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any

from numba.core import ir, lowering, typed_passes
from numba.core.analysis import compute_cfg_from_blocks, compute_use_defs, must_use_alloca
from numba.core.compiler_machinery import register_pass

from .folded_tuples import FoldingBuilder, remove_unused_fields


class DirectLower(lowering.Lower):
    """Numba's lowering without a place on the stack for what is assigned once, before all that uses it."""

    def _find_singly_assigned_variable(self) -> None:
        """Note the variables without a place on the stack: those of numba, which one block alone uses, and more."""
        super()._find_singly_assigned_variable()
        # With counted references a variable is emptied where it ends, and has to be somewhere.
        if not self.func_ir.func_id.is_generator and not self.context.enable_nrt:
            self._singly_assigned_vars |= _assigned_before_use(self.func_ir.blocks)

    def setup_function(self, fndesc: Any) -> None:
        """Begin a function; what is put into a tuple and taken out again needs no instruction."""
        super().setup_function(fndesc)
        self.builder = FoldingBuilder(self.entry_block)
        self.call_helper = self.call_conv.init_call_helper(self.builder)

    def post_lower(self) -> None:
        """End a function."""
        super().post_lower()
        if not self.func_ir.func_id.is_generator:
            remove_unused_fields(self.function)


def _assigned_before_use(blocks: dict[int, Any]) -> set[str]:
    """Return the variables that are assigned once, in a block that is passed, and lowered, before all others that use them."""
    found: Counter[str] = Counter()
    home: dict[str, int] = {}
    for label, block in blocks.items():
        for statement in block.find_insts(ir.Assign):
            found[statement.target.name] += 1
            home[statement.target.name] = label
    users: dict[str, set[int]] = defaultdict(set)
    for label, names in compute_use_defs(blocks).usemap.items():
        for name in names:
            users[name].add(label)
    dominators, on_stack = compute_cfg_from_blocks(blocks).dominators(), must_use_alloca(blocks)
    return {
        name
        for name, times in found.items()
        if times == 1
        and name not in on_stack
        and all(home[name] < user and home[name] in dominators[user] for user in users[name])
    }


@register_pass(mutates_CFG=True, analysis_only=False)
class DirectLowering(typed_passes.NativeLowering):
    """Numba's pass that writes LLVM's code, with `DirectLower`."""

    _name = "direct_lowering"

    @property
    def lowering_class(self) -> Any:
        """The class that does it."""
        return DirectLower
