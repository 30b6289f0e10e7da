"""What is left out of compilations: branches for arguments that are not there, and places on the stack; the results stay."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from granular_env.components.support.jit import JIT, internal, jit
from granular_env.components.support.plain_function import plain_function

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
