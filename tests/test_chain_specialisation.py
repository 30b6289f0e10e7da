"""Kernels of one's own that ask for what depends on the contact law: they get that of the chain that they are used with."""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.chain import differentiable_quantities
from granular_env.components.chain.differentiable_quantities import contact_force, input_work
from granular_env.components.chain.layout import GRAINS, SCALARS
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError
from granular_env.components.support.jit import JIT, jit
from granular_env.domains.chain.control import value_and_grad

LAWS: dict[str, dict[str, Any]] = {
    "hertz": {},
    "power": {"law": {"name": "power", "exponent": 1.8}, "contact_stiffness": 2e11},
    "viscous": {"law": {"name": "viscous", "dissipation": 20.0}},
    "walton_braun": {"law": {"name": "walton_braun", "unloading_stiffness": 2.5e7}, "contact_stiffness": 1e7},
}
WEIGHT = 2.0


def pressed(name: str) -> ge.Chain:
    chain = ge.Chain(grains=5, right="plane", precompression=50.0, step_size=1e-8, **LAWS[name])
    chain.reset(velocity=np.array([1.0, 0.5, 0.0, 0.0, 0.0]))
    return chain


@jit
def own_force(a, j):  # noqa: ANN001, ANN202
    """Call a quantity by its name."""
    return WEIGHT * contact_force(a, j)


@jit
def own_force_of_module(a, j):  # noqa: ANN001, ANN202
    """Call it as an attribute of its module."""
    return WEIGHT * differentiable_quantities.contact_force(a, j)


library = types.ModuleType("a_library_of_ones_own")
library.own_force = own_force  # type: ignore[attr-defined]
pair = (contact_force, input_work)


@jit
def own_force_of_library(a, j):  # noqa: ANN001, ANN202
    """Call a function of another module that calls it."""
    return library.own_force(a, j)


@jit
def own_force_of_pair(a, j):  # noqa: ANN001, ANN202
    """Call it as an element of a tuple."""
    return WEIGHT * pair[0](a, j)


def enclosing() -> Callable[..., Any]:
    inner = own_force

    @jit
    def own_force_enclosed(a, j):  # noqa: ANN001, ANN202
        return inner(a, j)

    return own_force_enclosed


WAYS = [own_force, own_force_of_module, own_force_of_library, own_force_of_pair, enclosing()]


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("kernel", WAYS, ids=lambda kernel: kernel.__name__)
def test_kernels_of_any_module_get_the_law_of_the_chain(kernel: Callable[..., Any], name: str) -> None:
    chain = pressed(name)
    specialised = chain.specialise(kernel)
    assert specialised is not kernel and chain.specialise(kernel) is specialised
    assert [specialised(chain.table, j) for j in range(6)] == (2.0 * chain.get("contact_force")).tolist()


def test_what_asks_nothing_of_the_law_is_not_copied() -> None:
    @jit
    def last_grain(a):  # noqa: ANN001, ANN202
        return a[SCALARS, GRAINS]

    chain = pressed("hertz")
    assert chain.specialise(last_grain) is last_grain
    assert chain.specialise(input_work) is input_work


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_another_value_of_a_global_is_refused_after_specialising(monkeypatch: pytest.MonkeyPatch) -> None:
    chain = pressed("hertz")
    chain.specialise(own_force_of_library)
    monkeypatch.setitem(globals(), "WEIGHT", 3.0)
    for kernel in (own_force, own_force_of_library):
        with pytest.raises(ParameterError, match="WEIGHT has another value than when own_force was compiled"):
            chain.specialise(kernel)


# -- tasks and objectives -----------------------------------------------------------------------------------------------


@jit
def _note(a, step, steps, inputs, constants, sums):  # noqa: ANN001, ANN202
    if step == steps - 1:
        sums[0] += contact_force(a, 2)


@jit
def _value(sums, constants, slopes):  # noqa: ANN001, ANN202
    slopes[0] = 1.0
    return sums[0]


@jit
def _pullback(a, adjoint, step, steps, inputs, input_adjoint, constants, slopes):  # noqa: ANN001, ANN202
    if step == steps - 1:
        differentiable_quantities.contact_force_pullback(a, adjoint, 2, slopes[0])


@pytest.mark.parametrize("name", ["hertz", "power", "viscous"])
def test_one_objective_serves_chains_of_several_laws(name: str) -> None:
    chain, drive, h = pressed(name), np.zeros((20, 2)), 1e-4
    drive[:, 0] = 30.0
    objective = Objective(_note, _value, _pullback)
    force, gradient = value_and_grad(objective, chain, drive, ticks=20)
    # What is held at the end of the drive is in the output too.
    twin = pressed(name)
    twin.step(400 * twin.step_size, left_force=30.0)
    assert force == twin.get("contact_force")[2]
    forces = [value_and_grad(objective, chain, drive + sign * h, ticks=20)[0] for sign in (1.0, -1.0)]
    assert gradient["drive"][:, 0].sum() == pytest.approx((forces[0] - forces[1]) / (2.0 * h), rel=1e-5)
