"""Check an objective's hand-written derivatives against difference quotients (`finite_differences` checks whole runs)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from granular_env.components.chain import Chain, layout
from granular_env.components.chain.adjoint import compiled_objective, value_and_slopes
from granular_env.components.chain.laws import Dissipative
from granular_env.components.chain.objective import Objective
from granular_env.components.chain.state import python_chain_state
from granular_env.components.errors import Fault, ParameterError
from granular_env.components.support.float_arrays import FloatArray

from .gradient import refuse_without_gradients

_ROWS = {
    name: getattr(layout, name) for name in ("STIFFNESS", "REST_OVERLAP", "INVERSE_MASS", "MASS", "LAW_CONSTANTS", "U", "V")
}
_STEP = 1e-5
_SEED = 20
# A derivative (times its variable's scale) below this fraction of the objective is lost in the quotient's rounding error.
_SMALL_PART = 1e-3


def check_objective(objective: Objective, chain: Chain, *, steps: int = 8, tolerance: float = 1e-6) -> float:
    """Compare an objective's derivatives with difference quotients, in a random state of a chain with compressed contacts.

    Args:
        objective: the objective to check.
        chain: a chain of the objective's size and law; it is not changed.
        steps: number of control steps of an imagined run; the derivatives are checked at its first, second and last step.
        tolerance: largest accepted error of a derivative, relative to it.

    Returns:
        The largest relative error found.

    Raises:
        ParameterError: a derivative is wrong, or `note` reads a row of the chain's table that has no derivative.
    """
    refuse_without_gradients(chain)
    objective.require_grain_count(chain.parameters.grains, steps)
    compiled_objective(objective, chain)
    note, pullback = _wrap_for_tables(chain, objective.note), _wrap_for_tables(chain, objective.pullback)
    objective = replace(objective, note=note, value=objective.value, pullback=pullback)
    # Of the constants of a contact law other than the stiffness, only the dissipation has a gradient.
    is_dissipative = isinstance(chain.parameters.law, Dissipative)
    rows = {name: row for name, row in _ROWS.items() if name != "LAW_CONSTANTS" or is_dissipative}
    rng = np.random.default_rng(_SEED)
    a, inputs = _random_state(chain, rng), rng.normal(size=2)
    sums = _feature_sums(objective, a, 0, steps, inputs)
    for step in range(1, steps):
        sums += _feature_sums(objective, a, step, steps, inputs)
    worst = _check_value(objective, sums, tolerance)
    looked_at = sorted({0, min(1, steps - 1), steps - 1})
    for step in looked_at:
        _refuse_peaks(objective, a, step, steps, inputs)
    for step in looked_at:
        slopes = rng.normal(size=objective.count)
        worst = max(worst, _check_pullback(objective, a, step, steps, inputs, slopes, tolerance, rows))
    return worst


def _wrap_for_tables(chain: Chain, function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function of an objective so that it accepts the tables (arrays) of a chain and its adjoint instead of them."""
    kind = chain.parameters.law.contacts

    def call(table: FloatArray, *rest: Any) -> Any:
        states = [python_chain_state(kind, table)]
        if rest and isinstance(rest[0], np.ndarray) and rest[0].ndim == 2:  # the adjoint
            states.append(python_chain_state(kind, rest[0]))
        return function(*states, *rest[len(states) - 1 :])

    return call


def _random_state(chain: Chain, rng: np.random.Generator) -> FloatArray:
    """Return the table of a random state: overlaps of 1 to 2 % of the smallest radius, Gaussian velocities of about 1 m/s."""
    a, n = chain.detached_table(), chain.parameters.grains
    overlap = 1e-2 * float(chain.geometry.radius.min()) * (1.0 + rng.random(n + 1))
    a[layout.U, 1 : n + 1] = -np.cumsum(overlap[:n])
    a[layout.REST_OVERLAP, : n + 1] = overlap + a[layout.U, 1 : n + 2] - a[layout.U, : n + 1]
    a[layout.REST_OVERLAP, : n + 1] *= a[layout.STIFFNESS, : n + 1] > 0.0
    a[layout.V, 1 : n + 1] = rng.normal(size=n)
    return a


def _feature_sums(objective: Objective, a: FloatArray, step: int, steps: int, inputs: FloatArray) -> FloatArray:
    sums = np.zeros(objective.count)
    objective.note(a, step, steps, inputs, objective.constants, sums)
    if not np.isfinite(sums).all():
        k = int(np.argmin(np.isfinite(sums)))
        raise ParameterError(f"sums[{k}] is {sums[k]} at control step {step} for a finite state", at="objective.note")
    return sums


def _central_difference(function: Callable[[], FloatArray], memory: FloatArray, place: tuple[int, ...], h: float) -> FloatArray:
    """Return the derivative of `function` with respect to `memory[place]`, by a fourth-order central difference with step h."""
    before, found = memory[place], []
    for way in (1.0, -1.0, 2.0, -2.0):
        memory[place] = before + way * h
        found.append(function())
    memory[place] = before
    return (8.0 * (found[0] - found[1]) - (found[2] - found[3])) / (12.0 * h)


def _check_value(objective: Objective, sums: FloatArray, tolerance: float) -> float:
    _, slopes = value_and_slopes(objective, sums)
    spare = np.zeros(objective.count)
    trial = sums.copy()

    def value() -> FloatArray:
        return np.array(objective.value(trial, objective.constants, spare))

    scales = np.where(sums == 0.0, 1.0, np.abs(sums))
    quotients = np.array([float(_central_difference(value, trial, (k,), _STEP * scales[k])) for k in range(objective.count)])
    errors = np.abs(slopes - quotients) * scales
    sizes = np.maximum(np.abs(slopes), np.abs(quotients)) * scales
    return _largest_error(
        errors, sizes, abs(float(value())), tolerance,
        lambda k: Fault(("objective", "value"), f"slopes[{k}] is {slopes[k]:.9g}", f"quotient {quotients[k]:.9g}"),
    )  # fmt: skip


def _check_pullback(
    objective: Objective,
    a: FloatArray,
    step: int,
    steps: int,
    inputs: FloatArray,
    slopes: FloatArray,
    tolerance: float,
    rows: Mapping[str, int],
) -> float:
    adjoint, input_adjoint, before = np.zeros_like(a), np.zeros(2), a.copy()
    objective.pullback(a, adjoint, step, steps, inputs, input_adjoint, objective.constants, slopes)
    if not np.array_equal(a, before):
        expected = "additions to `adjoint` and `input_adjoint` only"
        raise ParameterError("it changes `chain`", expected=expected, at="objective.pullback")

    def feature() -> FloatArray:
        return np.array(slopes @ _feature_sums(objective, a, step, steps, inputs))

    names, given, quotients, scales = [], [], [], []
    for name, row in rows.items():
        scale = float(np.abs(a[row]).max()) or 1.0
        for column in range(int(a[layout.SCALARS, layout.GRAINS]) + 2):
            names.append(f"adjoint[{name}, {column}]")
            given.append(adjoint[row, column])
            quotients.append(float(_central_difference(feature, a, (row, column), _STEP * scale)))
            scales.append(scale)
    for side in range(2):
        names.append(f"input_adjoint[{side}]")
        given.append(input_adjoint[side])
        quotients.append(float(_central_difference(feature, inputs, (side,), _STEP)))
        scales.append(1.0)
    found, wanted, weights = np.array(given), np.array(quotients), np.array(scales)
    sizes = np.maximum(np.abs(found), np.abs(wanted)) * weights
    return _largest_error(
        np.abs(found - wanted) * weights, sizes, abs(float(feature())), tolerance,
        lambda k: Fault(
            ("objective", "pullback"), f"{names[k]} is {found[k]:.9g} at step {step}", f"{wanted[k]:.9g}, quotient of note"
        ),
    )  # fmt: skip


def _refuse_peaks(objective: Objective, a: FloatArray, step: int, steps: int, inputs: FloatArray) -> None:
    before = _feature_sums(objective, a, step, steps, inputs)
    for name in ("PEAK", "LOST", "TALLY", "LIMIT"):
        row = getattr(layout, name)
        kept = a[row].copy()
        a[row] = 1.0 + np.where(np.isfinite(kept), kept, 0.0)
        after = _feature_sums(objective, a, step, steps, inputs)
        a[row] = kept
        if not np.array_equal(before, after):
            raise ParameterError(
                f"it reads the row {name}, which has no derivative",
                hint=(
                    "use displacements, velocities, inputs and the table's constants (for a peak over time, use the p-norm "
                    "`differentiable_quantities.peak_value`)"
                ),
                at="objective.note",
            )


def _largest_error(
    errors: FloatArray, sizes: FloatArray, value: float, tolerance: float, fault_at: Callable[[int], Fault]
) -> float:
    """Return the largest error relative to size + `_SMALL_PART` x value; above the tolerance, raise the fault at its index."""
    relative = errors / np.maximum(sizes + _SMALL_PART * value, np.finfo(np.float64).tiny)
    wrong = int(np.argmax(relative))
    if not relative[wrong] <= tolerance:
        raise ParameterError(fault_at(wrong))
    return float(relative[wrong])
