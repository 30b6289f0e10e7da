"""Values and gradients of an objective of a driven chain, by the discrete adjoint of its integrator."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numba.core.errors import NumbaError

from ...errors import ParameterError, StepError, one_line
from ...support.addresses import address
from ...support.float_arrays import FloatArray
from ...support.jit import JIT, jit
from ..component import Chain
from ..integrators import SCHEMES, SIGNATURE
from ..integrators.compositions import Composition
from ..laws import LAWS, Dissipative
from ..laws.law import Law, missing_parts
from ..layout import FREE, LEFT_KIND, PISTON, RIGHT_KIND, SCALARS, U, V
from ..objective import Objective
from ..specialisation import specialise
from . import loops
from .tape import rows_per_tick

_NO_PIECES = np.zeros((0, 2))
_NO_STATES = np.zeros((0, 2, 0))


def _address_of(function: Callable[..., Any], law: type[Law], signature: str, name: str) -> tuple[Any, Callable[..., Any]]:
    """Return where compiled code finds a function for a contact law, and what has to live meanwhile."""
    where, jitted, compiled = _look_up(function, law, signature, name)
    return where, compiled


# Looking it up takes longer than many a run.
@lru_cache(maxsize=64)
def _look_up(
    function: Callable[..., Any], law: type[Law], signature: str, name: str
) -> tuple[Any, Callable[..., Any], Callable[..., Any]]:
    jitted = function if hasattr(function, "compile") or not JIT else jit(function)
    compiled = specialise(jitted, law)
    try:
        return address(compiled, signature), jitted, compiled
    except (NumbaError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise ParameterError(f"it does not compile as {signature}: {one_line(reason, 400)}", at=name) from None


@dataclass(frozen=True, eq=False)
class Adjoints:
    """An objective and its derivatives by everything that the kernels see.

    Attributes:
        value: J.
        inputs: by the left and right input of each control step, shape (steps, 2); 0 where an end has none.
        table: by the entries of the chain's table; those that are constants count: STIFFNESS, REST_OVERLAP, INVERSE_MASS,
            LAW_CONSTANTS, what the objective itself takes from it (MASS), and LEFT_STATIC, RIGHT_STATIC and GRAVITY of SCALARS.
        displacement: by the start displacement, shape (n,).
        velocity: by the start velocity, shape (n,).
    """

    value: float
    inputs: FloatArray
    table: FloatArray
    displacement: FloatArray
    velocity: FloatArray


def evaluate(chain: Chain, drives: npt.ArrayLike, ticks: int, objective: Objective) -> FloatArray:
    """Return the objective of each of many drives, each from the chain's present state; the chain stays as it is.

    Args:
        chain: any chain.
        drives: inputs left and right held in each control step, shape (members, steps, 2); 0 where an end has none.
        ticks: internal steps of a control step.
        objective: what to evaluate.

    Returns:
        The values, shape (members,).

    Raises:
        ParameterError: a drive that does not fit, or an objective that is not a number.
        StepError: the physics breaks down; it names the control step.
    """
    given = _numbers("drives", drives)
    if given.ndim != 3:
        raise ParameterError(f"got the shape {given.shape}", expected="(members, control steps, 2)", at="drives")
    ticks = validate_ticks(ticks)
    a = chain.detached_table()
    start = a[U:].copy(), a[:U].copy()
    values = np.empty(len(given))
    for member, drive in enumerate(given):
        a[U:], a[:U] = start
        sums, _ = _run(chain, a, validate_drive(chain, drive), ticks, objective, 0)
        values[member], _ = value_and_slopes(objective, sums)
    return values


def value_and_adjoint(chain: Chain, drive: npt.ArrayLike, ticks: int, objective: Objective) -> Adjoints:
    """Return the objective of a drive from the chain's present state, and its exact derivatives; the chain stays as it is.

    The derivatives are those of the floating-point run itself, by the transpose of each of its operations (in another order of
    sums than theirs). Time: some four plain runs. Memory: the states of sqrt(steps) checkpoints, and as much for the tape.

    Args:
        chain: one of the integrators pefrl and leapfrog, of any law without history.
        drive: inputs left and right held in each control step, shape (steps, 2); 0 where an end has none.
        ticks: internal steps of a control step.
        objective: what to differentiate.

    Raises:
        ParameterError: there is no adjoint of this chain, the drive does not fit, or the objective is not a number.
        StepError: the physics breaks down; it names the control step.
    """
    composition, law = composition_of(chain), type(chain.parameters.law)
    ticks, inputs = validate_ticks(ticks), validate_drive(chain, drive)
    steps = len(inputs)
    step_rows = ticks * specialise(rows_per_tick, law)(len(composition.kicks)) + 2
    interval = checkpoint_interval(steps, step_rows)
    a = chain.detached_table(interval * step_rows)
    sums, saved = _run(chain, a, inputs, ticks, objective, interval)
    value, slopes = value_and_slopes(objective, sums)
    adjoint, input_adjoints = np.zeros(chain.table.shape), np.zeros_like(inputs)
    pullback, kept = _address_of(objective.pullback, law, loops.PULLBACK, "objective.pullback")
    step, ended = specialise(loops.backward, law)(
        a, adjoint, pullback, inputs, ticks, objective.constants, slopes, saved, interval,
        composition.drifts, composition.kicks, composition.passed, input_adjoints, np.zeros(2),
    )  # fmt: skip
    del kept  # only now may its machine code go
    if ended != loops.DONE:
        _explain_derivative(adjoint, step, steps, ended)
    _keep_to_inputs(chain, input_adjoints)
    grains = slice(1, chain.parameters.grains + 1)
    return Adjoints(value, input_adjoints, adjoint, adjoint[U, grains].copy(), adjoint[V, grains].copy())


def checkpoint_interval(steps: int, step_rows: int) -> int:
    """Control steps from checkpoint to checkpoint for the least memory: that of the states, two rows each, and of one tape."""
    return max(1, min(steps, round(math.sqrt(2.0 * steps / step_rows))))


def _run(
    chain: Chain, a: FloatArray, drive: FloatArray, ticks: int, objective: Objective, interval: int
) -> tuple[FloatArray, FloatArray]:
    """Return the sums of the features, and the states at every `interval` control steps (none for 0)."""
    objective.fit(chain.parameters.grains, len(drive))
    count = -(-len(drive) // interval) if interval else 0
    saved = np.empty((count, 2, a.shape[1])) if interval else _NO_STATES
    sums = np.zeros(objective.count)
    law = type(chain.parameters.law)
    advance, _ = _address_of(chain.scheme_kernel, law, SIGNATURE, "integrator")
    note, kept = _address_of(objective.note, law, loops.NOTE, "objective.note")
    step, ended = loops.forward(
        a, advance, note, drive, _NO_PIECES, chain.tick, ticks,
        objective.constants, sums, saved, max(interval, 1),
    )  # fmt: skip
    del kept  # only now may its machine code go
    if ended == loops.STEP_FAILED:
        _explain_failure(chain, drive, ticks, step)
    if ended == loops.NOTE_FAILED:
        k = int(np.argmin(np.isfinite(sums)))
        raise ParameterError(
            f"sums[{k}] became {sums[k]} after control step {step} of {len(drive)}, the state being finite",
            hint="mend the feature, or check its constants",
            at="objective.note",
        )
    return sums, saved


def value_and_slopes(objective: Objective, sums: FloatArray) -> tuple[float, FloatArray]:
    """Return the objective for these sums of its features, and dJ/dsums; `ParameterError` where one is no finite number."""
    slopes = np.zeros(objective.count)
    given = objective.value(sums, objective.constants, slopes)
    if not isinstance(given, (int, float, np.number)):
        raise ParameterError(f"got {one_line(given)} from it", expected="a number", at="objective.value")
    value = float(given)
    if not math.isfinite(value) or not np.isfinite(slopes).all():
        what = f"J is {value}" if not math.isfinite(value) else f"dJ/dsums is {one_line(slopes)}"
        raise ParameterError(
            f"{what} for the sums {one_line(sums)}", hint="mend the function, or check its constants", at="objective.value"
        )
    return value, slopes


def check_functions(objective: Objective, law: type[Law]) -> None:
    """Compile an objective's note and pullback for a contact law; `ParameterError` where one does not compile."""
    _address_of(objective.note, law, loops.NOTE, "objective.note")
    _address_of(objective.pullback, law, loops.PULLBACK, "objective.pullback")


def has_gradient(law: type[Law]) -> bool:
    """Return whether runs of a contact law have gradients: it has the functions for them, and no history."""
    return not law.history_rows and not missing_parts(law, gradient=True)


def composition_of(chain: Chain) -> Composition:
    """Return the drifts and kicks of a chain that has an adjoint.

    Raises:
        ParameterError: there is none for its law or its integrator.
    """
    law, integrator = chain.parameters.law, chain.parameters.integrator
    if not has_gradient(type(law)):
        missing = missing_parts(type(law), gradient=True)
        reason = "whose contacts remember" if law.has_history else f"which lacks {', '.join(missing)}"
        known = [name for name, one in LAWS.items() if has_gradient(one)]
        raise ParameterError(
            f"there are no gradients of {law.name!r}, {reason}", hint=f"use {', '.join(known[:-1])} or {known[-1]}", at="law"
        )
    scheme = SCHEMES[integrator]
    composition = scheme.damped_composition if isinstance(law, Dissipative) else scheme.composition
    if composition is None:
        known = " or ".join(repr(name) for name, one in SCHEMES.items() if one.composition is not None)
        raise ParameterError(
            f"there are no gradients of {integrator!r}", hint=f"build the chain with integrator = {known}", at="integrator"
        )
    return composition


def _numbers(name: str, given: npt.ArrayLike) -> FloatArray:
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(f"got {one_line(given)}", expected="an array of numbers", at=name) from None


def validate_ticks(ticks: int) -> int:
    """Return the internal steps of a control step."""
    if isinstance(ticks, bool) or not isinstance(ticks, (int, np.integer)) or ticks < 1:
        raise ParameterError(f"got {one_line(ticks)}", expected="the internal steps of a control step, at least 1", at="ticks")
    return int(ticks)


def validate_drive(chain: Chain, given: npt.ArrayLike) -> FloatArray:
    """Return a copy, contiguous and finite, with zeros where an end takes no input, shape (steps, 2)."""
    drive = _numbers("drive", given)
    if drive.ndim != 2 or drive.shape[1] != 2 or not len(drive):
        raise ParameterError(f"got the shape {drive.shape}", expected="(control steps, 2): left and right input", at="drive")
    wrong = ~np.isfinite(drive)
    if wrong.any():
        step, side = (int(place) for place in np.argwhere(wrong)[0])
        raise ParameterError(f"got {drive[step, side]}", expected="a finite number", at=("drive", step, side))
    inputs = np.array(drive, order="C")
    _keep_to_inputs(chain, inputs)
    return inputs


def _keep_to_inputs(chain: Chain, columns: FloatArray) -> None:
    """Walls take no input."""
    for side, kind in enumerate((LEFT_KIND, RIGHT_KIND)):
        if chain.table[SCALARS, kind] not in (FREE, PISTON):
            columns[:, side] = 0.0


def _explain_derivative(adjoint: FloatArray, step: int, steps: int, ended: int) -> None:
    name, row = ("U", U) if not np.isfinite(adjoint[U]).all() else ("V", V)
    column = int(np.argmin(np.isfinite(adjoint[row])))
    value, when = adjoint[row, column], f"control step {step} of {steps}"
    if ended == loops.PULLBACK_FAILED:
        raise ParameterError(
            f"adjoint[{name}, {column}] became {value} at {when}",
            hint="mend the derivative, or check its constants",
            at="objective.pullback",
        )
    raise ParameterError(
        f"its derivative by {name}[{column}] became {value} in {when}, on the way back",
        hint="the run is too long or too chaotic for a gradient, so shorten it; or a derivative of the contact law is not "
        "finite, perhaps where a contact opens",
        at="objective",
    )


def _explain_failure(chain: Chain, drive: FloatArray, ticks: int, failed: int) -> None:
    """Step a twin of the chain to the control step that failed, for its own account of what went wrong."""
    twin = type(chain)(**chain.parameters.model_dump())
    twin.restore(chain.save())
    names = [name for name, variable in twin.variables.items() if variable.causality == "input"]
    for step, held in enumerate(drive[: failed + 1]):
        inputs = {name: float(held[0 if name.startswith("left") else 1]) for name in names}
        try:
            twin.step(ticks * twin.step_size, **inputs)
        except StepError as error:
            raise error.of(f"control step {step} of {len(drive)}") from None
    raise AssertionError("a run failed whose steps do not")
