"""What is left out of compilations: branches for arguments that are not there, and places on the stack; the results stay."""

import gc
import operator
import sys
import types
from typing import Any, NamedTuple

import llvmlite.ir as ll
import numba
import numpy as np
import pytest
from llvmlite.ir.instructions import ExtractValue, InsertValue
from numba.core.registry import cpu_target
from numba.core.types.functions import BaseFunction
from numba.extending import overload

from granular_env.components.support.compilation import call_type_cache
from granular_env.components.support.compilation.folded_tuples import FoldingBuilder, remove_unused_fields
from granular_env.components.support.compilation.plain_function import plain_function
from granular_env.components.support.compilation.registry_refresh import refresh_after_imports
from granular_env.components.support.jit import JIT, internal, jit

pytestmark = pytest.mark.skipif(not JIT, reason="nothing is compiled")


class Part(NamedTuple):
    """A tuple of arrays with one that may be missing."""

    values: Any
    weights: Any


@internal
def cannot_be_compiled(values):
    """Ask for what no array has."""
    return values.nothing_of_the_kind


@jit
def total(values, weights):
    """Add up, with weights where there are some."""
    found = 0.0
    for i in range(values.size):
        if weights is None:
            found += cannot_be_compiled(values)
        else:
            found += weights[i] * values[i]
    return found


@jit
def total_of_part(part, scale):
    """Add up what a tuple holds."""
    values, found = part.values, 0.0
    if scale is not None:
        return cannot_be_compiled(values)
    for i in range(values.size):
        if part.weights is not None and values[i] > 0.0:
            found += part.weights[i] * values[i]
        elif part.weights is None:
            found += cannot_be_compiled(values)
    return found


@jit
def last_positive(part, start):
    """Use a tuple and what is set before a loop in all of its branches."""
    values, weights, found = part.values, part.weights, start
    first, size = values[0], values.size
    i = 0
    while i < size:
        if values[i] > first:
            found = weights[i]
        else:
            values[i] = first
        i += 1
    return found


VALUES, WEIGHTS = np.array([1.0, -2.0, 3.0]), np.array([0.5, 0.25, 2.0])


def test_a_branch_for_a_missing_argument_is_not_compiled_where_it_is_there():
    assert total(VALUES, WEIGHTS) == 6.0
    assert total_of_part(Part(VALUES, WEIGHTS), None) == 6.5


def test_such_a_branch_is_compiled_where_the_argument_is_missing():
    for call in (lambda: total(VALUES, None), lambda: total_of_part(Part(VALUES, None), None)):
        with pytest.raises(Exception, match="nothing_of_the_kind"):
            call()


def test_tuples_of_arrays_give_what_plain_python_gives():
    one, other = VALUES.copy(), VALUES.copy()
    assert last_positive(Part(one, WEIGHTS), 7.0) == plain_function(last_positive)(Part(other, WEIGHTS), 7.0) == 2.0
    assert one.tolist() == other.tolist() == [1.0, 1.0, 3.0]


@jit
def product_of_sums(values, factor):
    """Look up sums and products of the same types several times."""
    found = values[0] + values[1] * factor
    for i in range(values.size):
        found = found + values[i] * factor
    return found * factor + found


def test_types_of_a_call_are_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, look_up = [], call_type_cache._look_up

    def count(function: Any, context: Any, arguments: Any, named: Any) -> Any:
        asked.append((function.key[0], tuple(arguments)))
        return look_up(function, context, arguments, named)

    monkeypatch.setattr(call_type_cache, "_look_up", count)
    values = np.array([1.0, 2.0])
    for _ in range(2):
        assert jit(product_of_sums.py_func)(values, 3.0) == product_of_sums.py_func(values, 3.0)
    assert not [one for one in set(asked) if one[0] in (operator.add, operator.mul) and asked.count(one) > 1]


def test_calls_of_other_compilations_are_looked_up_as_numba_does() -> None:
    assert BaseFunction.get_call_type is call_type_cache._look_up
    jit(lambda x: x + 1.0)(2.0)
    assert BaseFunction.get_call_type is call_type_cache._look_up


def doubled(x):
    """Stand for what numba is taught below."""
    return 2.0 * x


@overload(doubled)
def _doubled(x):
    return lambda x: 2.0 * x


def test_calls_that_are_compiled_for_their_caller_are_looked_up_each_time() -> None:
    """An overload is compiled with the flags of the function that calls it."""
    assert jit(lambda x: doubled(x))(1.5) == 3.0
    function = cpu_target.typing_context.resolve_value_type(doubled)
    assert not getattr(function, call_type_cache._CALLS)


def fields_of_tuples(function: Any) -> list[Any]:
    """The instructions of a function that put fields into tuples or take them out."""
    return [one for block in function.blocks for one in block.instructions if isinstance(one, InsertValue | ExtractValue)]


def test_a_field_is_taken_from_where_it_was_put_into_a_tuple() -> None:
    number = ll.DoubleType()
    function = ll.Function(ll.Module(), ll.FunctionType(number, [number] * 2), "f")
    builder = FoldingBuilder(function.append_basic_block())
    pair = builder.insert_value(ll.Constant(ll.LiteralStructType([number] * 2), ll.Undefined), function.args[0], 0)
    pair = builder.insert_value(pair, function.args[1], 1)
    first, second = (builder.extract_value(pair, k) for k in range(2))
    assert (first, second) == tuple(function.args)
    builder.ret(builder.fsub(first, second))
    remove_unused_fields(function)
    assert not fields_of_tuples(function) and len(function.blocks[0].instructions) == 2


def test_fields_of_tuples_that_are_used_stay() -> None:
    number = ll.DoubleType()
    kind = ll.LiteralStructType([number] * 2)
    function = ll.Function(ll.Module(), ll.FunctionType(kind, [kind, number]), "f")
    builder = FoldingBuilder(function.append_basic_block())
    field = builder.extract_value(function.args[0], 1)
    last = function.append_basic_block()
    builder.branch(last)
    above, builder = builder.block, FoldingBuilder(last)
    chosen = builder.phi(number)
    chosen.add_incoming(field, above)
    changed = builder.insert_value(function.args[0], chosen, 0)
    # The other field is as before.
    assert builder.extract_value(changed, 1).aggregate is function.args[0]
    builder.ret(changed)
    remove_unused_fields(function)
    assert fields_of_tuples(function) == [field, changed]


def test_registrations_are_read_after_imports_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[Any] = []

    class Context:
        def refresh(self) -> None:
            read.append(self)

    context = Context()
    refresh_after_imports(context)
    read.clear()
    refresh_after_imports(context)
    assert not read
    monkeypatch.setitem(sys.modules, "a_module_of_this_test", types.ModuleType("a_module_of_this_test"))
    refresh_after_imports(context)
    assert read == [context]


def test_the_collection_of_garbage_and_messages_are_as_before_after_a_compilation() -> None:
    scheme = numba.core.errors.termcolor()
    with pytest.raises(Exception, match="nothing_of_the_kind"):
        jit(cannot_be_compiled.py_func)(VALUES)
    assert gc.isenabled() and numba.core.errors.termcolor() is scheme
