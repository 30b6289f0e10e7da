"""Asking for memory ahead of time: it is asked for, line by line, and nothing is changed by it."""

import numba
import numpy as np
import pytest

from granular_env.components.support.jit import JIT, jit
from granular_env.components.support.prefetch import prefetch


def sum_with_request(numbers, begin, end):
    prefetch(numbers, begin, end)
    total = 0.0
    for i in range(begin, end):
        total += numbers[i]
    return total


@pytest.mark.parametrize(("begin", "end"), [(0, 40), (3, 21), (5, 5)])
def test_nothing_is_changed(begin: int, end: int) -> None:
    numbers = np.arange(40.0)
    assert jit(sum_with_request)(numbers, begin, end) == float(np.arange(40.0)[begin:end].sum())
    np.testing.assert_array_equal(numbers, np.arange(40.0))


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_lines_are_asked_for_to_be_read_into_the_second_level_cache() -> None:
    kernel = numba.njit(sum_with_request)  # not `jit`: of machine code from disk nothing can be seen
    kernel(np.arange(40.0), 0, 40)
    (text,) = kernel.inspect_llvm().values()
    requests = [line for line in text.splitlines() if "call void @llvm.prefetch" in line]
    assert requests and all("i32 0, i32 2, i32 1" in line for line in requests)
