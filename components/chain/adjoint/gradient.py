"""Values and gradients of an objective of a driven chain, by the discrete adjoint of its integrator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba.core.errors import NumbaError

from ...errors import ParameterError, StepError, one_line
from ...number_arrays import number_array
from ...support.float_arrays import FloatArray
from ...support.validation import whole_number
from ..component import Chain
from ..integrators import SCHEMES, DampedComposition
from ..laws import LAWS
from ..laws.law import Law, missing_members
from ..layout import INVERSE_MASS, LEFT_DRIVE, LEFT_FREE, LEFT_PISTON, LOST, RIGHT_FREE, RIGHT_PISTON, SCALARS, U, V
from ..objective import Objective
from .loops import ObjectiveLoops, make_objective_loops, make_run_loops
from .reverse import INVERSE_MASS_SUM, reverse_tick

# Control steps per block if no states are saved for a backward sweep.
_LONG_BLOCK = 256
# Rows of a table with the displacements and velocities: a run changes them, and checkpoints save them.
_STATE = slice(U, V + 1)


@dataclass(frozen=True, eq=False)
class Adjoints:
    """An objective and its derivatives with respect to all numbers of the kernels.

    Attributes:
        value: the objective J.
        inputs: derivatives with respect to left and right inputs, shape (steps, 2); 0 for an end without input.
        table: derivatives with respect to the chain's table, meaningful in the rows STIFFNESS, REST_OVERLAP, INVERSE_MASS,
            LAW_CONSTANTS, MASS if the objective uses it, and in LEFT_STATIC, RIGHT_STATIC and GRAVITY of the row SCALARS.
        displacement: derivatives with respect to the start displacement, shape (n,).
        velocity: derivatives with respect to the start velocity, shape (n,).
    """

    value: float
    inputs: FloatArray
    table: FloatArray
    displacement: FloatArray
    velocity: FloatArray


def evaluate_objective(chain: Chain, drives: npt.ArrayLike, ticks: int, objective: Objective) -> FloatArray:
    """Return the objective of each of many drives, each from the chain's present state; the chain is not changed.

    Args:
        chain: any chain.
        drives: inputs held in each control step, left and right, shape (members, steps, 2); 0 for an end without input.
        ticks: internal steps per control step.
        objective: the objective.

    Returns:
        The values, shape (members,).

    Raises:
        ParameterError: a drive does not fit, or the objective is not a number.
        StepError: the physics breaks down; it names the control step.
    """
    given = number_array("drives", drives, "an array of numbers")
    if given.ndim != 3:
        raise ParameterError(f"got the shape {given.shape}", expected="(members, control steps, 2)", at="drives")
    ticks = whole_number("ticks", ticks, 1)
    run = _BlockwiseRun(chain, ticks, objective, given.shape[1])
    values = np.empty(len(given))
    for member, drive in enumerate(given):
        run.table[:] = run.start
        sums = run.forward(validate_drive(chain, drive), min(_LONG_BLOCK, len(drive)))
        values[member], _ = value_and_slopes(objective, sums)
    return values


def value_and_adjoint(chain: Chain, drive: npt.ArrayLike, ticks: int, objective: Objective) -> Adjoints:
    """Return the objective of a drive from the chain's present state, with exact derivatives; the chain is not changed.

    The derivatives are those of the floating-point run itself, from the transpose of each of its operations (with another order
    of summation). Time: about four plain runs. Memory: the states of sqrt(steps) checkpoints, and as much for the tape.

    Args:
        chain: with the integrator pefrl or leapfrog, and a law without history.
        drive: inputs held in each control step, left and right, shape (steps, 2); 0 for an end without input.
        ticks: internal steps per control step.
        objective: the objective.

    Raises:
        ParameterError: the chain has no adjoint, the drive does not fit, or the objective is not a number.
        StepError: the physics breaks down; it names the control step.
    """
    refuse_missing_adjoint(chain)
    ticks, inputs = whole_number("ticks", ticks, 1), validate_drive(chain, drive)
    run, block = _BlockwiseRun(chain, ticks, objective, len(inputs)), math.isqrt(len(inputs) - 1) + 1
    saved_states: list[FloatArray] = []
    value, slopes = value_and_slopes(objective, run.forward(inputs, block, saved_states))
    adjoint, input_adjoints = run.backward(inputs, block, saved_states, slopes)
    _zero_wall_inputs(chain, input_adjoints)
    grains = slice(1, chain.parameters.grains + 1)
    return Adjoints(value, input_adjoints, adjoint, adjoint[U, grains].copy(), adjoint[V, grains].copy())


class _BlockwiseRun:
    """Runs of a drive on a copy of a chain, in blocks of control steps.

    Attributes:
        table: table of the copy.
        start: initial table.
    """

    def __init__(self, chain: Chain, ticks: int, objective: Objective, steps: int) -> None:
        objective.require_grain_count(chain.parameters.grains, steps)
        self.chain, self.ticks, self.objective, self.steps = chain, ticks, objective, steps
        self.table = chain.detached_table()
        self.start = self.table.copy()
        self._run_loops = make_run_loops(chain.parameters.law.contacts, chain.scheme)
        self._objective_loops = compiled_objective(objective, chain)

    def forward(self, drive: FloatArray, block: int, saved_states: list[FloatArray] | None = None) -> FloatArray:
        """Run a drive; return the sums of the features, and append the state before each block to `saved_states` if given."""
        sums, tick = np.zeros(self.objective.count), self.chain.tick
        states, nothing = np.empty((block, 2, self.table.shape[1])), self.table[:0]
        for begin in range(0, len(drive), block):
            some = drive[begin : begin + block]
            if saved_states is not None:
                saved_states.append(self.table[_STATE].copy())
            done = self._run_loops.forward(self.table, some, tick + begin * self.ticks, self.ticks, states, nothing)
            sound = self._objective_loops.note(
                self.table, some[:done], states, (begin, self.steps), self.objective.constants, sums
            )
            if sound < done:
                k = int(np.argmin(np.isfinite(sums)))
                raise ParameterError(
                    f"sums[{k}] became {sums[k]} after control step {begin + sound} of {len(drive)}; the state is finite",
                    hint="correct the feature, or check its constants",
                    at="objective.note",
                )
            if done < len(some):
                _raise_step_error(self.chain, drive, self.ticks, begin + done)
        return sums

    def backward(
        self, drive: FloatArray, block: int, saved_states: list[FloatArray], slopes: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives with respect to table and inputs, by running each block again with a tape and reversing it."""
        adjoint, input_adjoints, running = np.zeros_like(self.table), np.zeros_like(drive), np.zeros((2, self.table.shape[1]))
        states, sources = (np.zeros((block, 2, self.table.shape[1])) for _ in range(2))
        tape = np.zeros((block * self.ticks * tape_rows(self.chain), self.table.shape[1]))
        numbers = self.objective.constants, slopes
        for place in range(len(saved_states) - 1, -1, -1):
            begin = place * block
            some, own = drive[begin : begin + block], input_adjoints[begin : begin + block]
            rows = tape[: len(some) * self.ticks * tape_rows(self.chain)]
            self.table[_STATE] = saved_states[place]
            self._run_loops.forward(self.table, some, 0, self.ticks, states, rows)
            span = (begin, self.steps)
            judged = self._objective_loops.pullback(self.table, adjoint, some, own, states, sources, span, numbers)
            if judged < len(some):
                _raise_infinite_derivative(adjoint, begin + judged, self.steps, by_objective=True)
            adjoint[_STATE] = running
            sound = self._run_loops.backward(self.table, adjoint, some, self.ticks, rows, sources, own)
            if sound > 0:
                _raise_infinite_derivative(adjoint, begin + sound - 1, self.steps, by_objective=False)
            running[:] = adjoint[_STATE]
        # The scratch row INVERSE_MASS_SUM holds w dJ/dw for each inverse mass w.
        moved = self.table[INVERSE_MASS] > 0.0
        adjoint[INVERSE_MASS, moved] += adjoint[INVERSE_MASS_SUM, moved] / self.table[INVERSE_MASS, moved]
        adjoint[LEFT_DRIVE : LOST + 1] = 0.0
        return adjoint, input_adjoints


def tape_rows(chain: Chain) -> int:
    """Return the number of tape rows per tick: displacements at each kick and, with dissipation, the velocities before it."""
    return len(chain.scheme.kicks) + isinstance(chain.scheme, DampedComposition)


def compiled_objective(objective: Objective, chain: Chain) -> ObjectiveLoops:
    """Return the loops of an objective after compiling them; `ParameterError` if a function does not compile."""
    objective_loops = make_objective_loops(chain.parameters.law.contacts, objective.note, objective.pullback)
    table, sums = chain.table.copy(), np.zeros(objective.count)
    none, no_states = np.zeros((0, 2)), np.zeros((0, 2, table.shape[1]))
    arguments: dict[str, tuple[Any, ...]] = {
        "note": (table, none, no_states, (0, 1), objective.constants, sums),
        "pullback": (table, table, none, none, no_states, no_states, (0, 1), (objective.constants, sums)),
    }
    for name, given in arguments.items():
        try:
            getattr(objective_loops, name)(*given)
        except (NumbaError, TypeError) as error:
            reason = " ".join(str(error).split())
            raise ParameterError(f"it does not compile: {one_line(reason, 400)}", at=f"objective.{name}") from None
    return objective_loops


def value_and_slopes(objective: Objective, sums: FloatArray) -> tuple[float, FloatArray]:
    """Return the objective and dJ/dsums for these sums of features; `ParameterError` if one is not a finite number."""
    slopes = np.zeros(objective.count)
    given = objective.value(sums, objective.constants, slopes)
    if not isinstance(given, (int, float, np.number)):
        raise ParameterError(f"got {one_line(given)} from it", expected="a number", at="objective.value")
    value = float(given)
    if not math.isfinite(value) or not np.isfinite(slopes).all():
        what = f"J is {value}" if not math.isfinite(value) else f"dJ/dsums is {one_line(slopes)}"
        raise ParameterError(
            f"{what} for the sums {one_line(sums)}", hint="correct the function, or check its constants", at="objective.value"
        )
    return value, slopes


def has_gradient(law: type[Law]) -> bool:
    """Return whether runs with a contact law have gradients, i.e. whether it has the functions for them and no history."""
    return not law.history_rows and not missing_members(law, gradient=True)


def refuse_missing_adjoint(chain: Chain) -> None:
    """Raise `ParameterError` if the law or the integrator of a chain has no adjoint."""
    law, integrator = chain.parameters.law, chain.parameters.integrator
    if not has_gradient(type(law)):
        missing = missing_members(type(law), gradient=True)
        reason = "its contacts have a history" if law.has_history else f"it lacks {', '.join(missing)}"
        known = [name for name, one in LAWS.items() if has_gradient(one)]
        raise ParameterError(
            f"law {law.name!r} has no gradients: {reason}", hint=f"use {', '.join(known[:-1])} or {known[-1]}", at="law"
        )
    if type(chain.scheme) not in reverse_tick.implementations:
        known = " or ".join(repr(name) for name, one in SCHEMES.items() if not one.is_explicit)
        raise ParameterError(
            f"integrator {integrator!r} has no gradients", hint=f"build the chain with integrator = {known}", at="integrator"
        )


def validate_drive(chain: Chain, values: npt.ArrayLike) -> FloatArray:
    """Return a contiguous, finite copy with zeros for ends without an input, shape (steps, 2)."""
    drive = number_array("drive", values, "an array of numbers")
    if drive.ndim != 2 or drive.shape[1] != 2 or not len(drive):
        raise ParameterError(f"got the shape {drive.shape}", expected="(control steps, 2): left and right input", at="drive")
    _zero_wall_inputs(chain, drive)
    return drive


def _zero_wall_inputs(chain: Chain, columns: FloatArray) -> None:
    """Set the columns of walls, which take no input, to 0."""
    numbers = chain.table[SCALARS]
    for side, (free, piston) in enumerate(((LEFT_FREE, LEFT_PISTON), (RIGHT_FREE, RIGHT_PISTON))):
        if not numbers[free] and not numbers[piston]:
            columns[:, side] = 0.0


def _raise_infinite_derivative(adjoint: FloatArray, step: int, steps: int, *, by_objective: bool) -> None:
    name, row = ("U", U) if not np.isfinite(adjoint[U]).all() else ("V", V)
    column = int(np.argmin(np.isfinite(adjoint[row])))
    hint = (
        "shorten the run, which may be too long or too chaotic for a gradient; or check the derivatives of the contact law, "
        "which may be infinite when a contact opens"
    )
    raise ParameterError(
        f"adjoint[{name}, {column}] became {adjoint[row, column]} in control step {step} of {steps}, during the backward sweep",
        hint="correct the derivative, or check its constants" if by_objective else hint,
        at="objective.pullback" if by_objective else "objective",
    )


def _raise_step_error(chain: Chain, drive: FloatArray, ticks: int, failed_step: int) -> None:
    """Step a copy of the chain to the failed control step, which raises the `StepError`."""
    twin = type(chain)(**chain.parameters.model_dump())
    twin.restore(chain.save())
    names = [name for name, variable in twin.variables.items() if variable.causality == "input"]
    for step, held in enumerate(drive[: failed_step + 1]):
        inputs = {name: float(held[0 if name.startswith("left") else 1]) for name in names}
        try:
            twin.step(ticks * twin.step_size, **inputs)
        except StepError as error:
            raise error.with_source(f"control step {step} of {len(drive)}") from None
    raise AssertionError("the run failed, but its single steps did not")
