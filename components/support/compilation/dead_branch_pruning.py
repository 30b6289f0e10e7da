"""Pruning of branches for arguments that are None, before types are inferred: what is never taken is not compiled.

Numba does so where an argument is None, but not where it is not: then both branches are compiled, with all that they call.
"""

from __future__ import annotations

import operator
from typing import Any

from numba.core import ir, types
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import get_definition, guard

# Of which no value is None.
_NEVER_NONE = (types.Array, types.BaseTuple, types.Number, types.Boolean)


@register_pass(mutates_CFG=False, analysis_only=False)
class DecideTestsForNone(FunctionPass):
    """Replaces `argument is None` by what it is, also for fields of tuples that are arguments: `argument.field is None`."""

    _name = "decide_tests_for_none"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> Any:
        """Look at all tests; return whether there was one."""
        decided = False
        for block in state.func_ir.blocks.values():
            for statement in block.find_insts(ir.Assign):
                answer = _decide(state.func_ir, state.args, statement.value)
                if answer is not None:
                    _replace(state.func_ir, statement, answer)
                    decided = True
        return decided


def _decide(function: Any, arguments: Any, test: Any) -> bool | None:
    """Return what a test for None gives; None for anything else, and where it is not known."""
    if not isinstance(test, ir.Expr) or test.op != "binop" or test.fn not in (operator.is_, operator.is_not):
        return None
    right = guard(get_definition, function, test.rhs)
    if not isinstance(right, ir.Const) or right.value is not None:
        return None
    kind = _kind(function, arguments, test.lhs)
    if isinstance(kind, types.NoneType):
        return test.fn is operator.is_
    return test.fn is operator.is_not if isinstance(kind, _NEVER_NONE) else None


def _kind(function: Any, arguments: Any, variable: Any) -> Any:
    """Return the type of an argument, or of a field of one; None where a variable is something else."""
    found = guard(get_definition, function, variable)
    if isinstance(found, ir.Arg):
        return arguments[found.index]
    if isinstance(found, ir.Expr) and found.op == "getattr":
        owner = _kind(function, arguments, found.value)
        if isinstance(owner, (types.NamedTuple, types.NamedUniTuple)) and found.attr in owner.fields:
            return tuple(owner)[owner.fields.index(found.attr)]
    return None


def _replace(function: Any, statement: Any, answer: bool) -> None:
    constant = ir.Const(answer, statement.loc)
    definitions = function._definitions[statement.target.name]
    definitions[definitions.index(statement.value)] = constant
    statement.value = constant
