"""x^p and e^x without pow and exp: accurate to about an ulp, and bitwise equal with and without compilation."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from support.chain_tools import run_python

from granular_env.components.support.powers import exponential, power


def _exact(x: float, p: float) -> Decimal:
    with localcontext() as context:
        context.prec = 50
        return (Decimal(x).ln() * Decimal(p)).exp()


def test_it_is_right_to_about_an_ulp() -> None:
    random, worst = np.random.default_rng(5), 0.0
    for _ in range(3000):
        x, p = 10.0 ** random.uniform(-140.0, 3.0), random.uniform(0.0, 2.0)
        worst = max(worst, abs(float((Decimal(float(power(x, p))) - _exact(x, p)) / _exact(x, p))))
    assert 0.0 < worst < 2.5 * 2.0**-53 * 2.0


@pytest.mark.parametrize(("x", "p", "result"), [(1.0, 3.7, 1.0), (2.0, 10.0, 1024.0), (4.0, 0.5, 2.0), (0.25, 1.5, 0.125)])
def test_exact_powers_are_exact(x: float, p: float, result: float) -> None:
    assert power(x, p) == result


def test_below_and_above_the_range_of_a_float() -> None:
    assert power(1e-200, 2.0) == 0.0
    assert power(1e200, 2.0) == np.inf


def test_the_exponential_is_right_to_about_an_ulp() -> None:
    random, worst = np.random.default_rng(6), 0.0
    for x in (*random.uniform(-700.0, 700.0, 1000), *random.uniform(-1.0, 1.0, 1000)):
        with localcontext() as context:
            context.prec = 50
            exact = Decimal(float(x)).exp()
        worst = max(worst, abs(float((Decimal(float(exponential(x))) - exact) / exact)))
    assert 0.0 < worst < 2.5 * 2.0**-53
    assert exponential(0.0) == 1.0 and exponential(-709.0) == 0.0 and exponential(710.0) == np.inf


def test_the_same_bits_without_the_compiler() -> None:
    code = (
        "from granular_env.components.support.powers import exponential, power\n"
        "print([float(exponential(x)).hex() for x in (-700.0, -3.2, -1e-9, 0.4, 2.0, 600.0)])\n"
        "print([float(power(x, p)).hex() for x in (1e-9, 3.7e-6, .9, 1.4, 1.5, 7e5) for p in (1.0, 1.3, 2.5, 0.4)])"
    )
    assert run_python(code) == run_python(code, NUMBA_DISABLE_JIT="1")
