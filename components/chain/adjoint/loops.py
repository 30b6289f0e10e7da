"""Loops over control steps, for calls from Python: forward runs, backward sweeps, and the evaluation of objectives.

A block is a number of successive control steps. `states` are the displacements and velocities after each of them,
shape (steps, 2, columns). `tape` has the rows that each of their ticks needs for the backward sweep.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...support.jit import JIT, internal, jit
from ...support.unowned_array import unowned_array
from .. import forces
from ..drive import make_drive
from ..integrators.scheme import advance
from ..layout import U, V
from ..state import chain_state
from .reverse import reverse_tick

_LARGEST = np.finfo(np.float64).max


class RunLoops(NamedTuple):
    """The compiled loops for one contact law and one integrator.

    Attributes:
        forward: forward(table, drive, tick, ticks, states, tape) runs a block; returns the number of completed control steps.
        backward: backward(table, adjoint, drive, ticks, tape, sources, input_adjoints) reverses a block and adds the `sources`
            of each control step to the adjoint of the state after it. It returns 0, or one more than the index of the control
            step in which a derivative became infinite.
    """

    forward: Any
    backward: Any


class ObjectiveLoops(NamedTuple):
    """The compiled loops for one objective and one contact law.

    Attributes:
        note: note(table, drive, states, span, constants, sums) adds the features of a block; returns the number of control
            steps with finite sums. The block begins with step span[0] of span[1].
        pullback: pullback(table, adjoint, drive, input_adjoints, states, sources, span, numbers) writes derivatives with
            respect to states to `sources`, and adds those with respect to constants to `adjoint`; `numbers` are constants and
            slopes. It returns the number of control steps with finite derivatives.
    """

    note: Any
    pullback: Any


@internal
def _has_infinity(a):
    """Return whether the adjoint table holds an infinite or NaN derivative with respect to the state."""
    found = False
    for i in range(a.shape[1]):
        found |= not (abs(a[U, i]) <= _LARGEST and abs(a[V, i]) <= _LARGEST)
    return found


@internal
def _set_state(a, state):
    forces.copy_array(state[0], a[U])
    forces.copy_array(state[1], a[V])


@cache
def make_run_loops(kind: type, scheme: Any) -> RunLoops:
    """Return the loops for the class of a law and the coefficients of an integrator."""

    @jit
    def forward(table, drive, tick, ticks, states, tape):
        table, drive, tape, states = unowned_array(table), unowned_array(drive), unowned_array(tape), unowned_array(states)
        chain, rows = chain_state(kind, table), len(tape) // len(drive)
        for k in range(len(drive)):
            held = make_drive(table, table[:0], 0, drive[k, 0], drive[k, 1])
            if advance(scheme, chain, held, tick + k * ticks, ticks, tape[k * rows : (k + 1) * rows]) != ticks:
                return k
            forces.copy_array(table[U], states[k, 0])
            forces.copy_array(table[V], states[k, 1])
        return len(drive)

    @jit
    def backward(table, adjoint, drive, ticks, tape, sources, input_adjoints):
        table, adjoint, drive, tape = unowned_array(table), unowned_array(adjoint), unowned_array(drive), unowned_array(tape)
        sources, input_adjoints = unowned_array(sources), unowned_array(input_adjoints)
        chain, reverse = chain_state(kind, table), chain_state(kind, adjoint)
        rows = len(tape) // (len(drive) * ticks)
        for k in range(len(drive) - 1, -1, -1):
            for i in range(table.shape[1]):
                adjoint[U, i] += sources[k, 0, i]
                adjoint[V, i] += sources[k, 1, i]
            for t in range(ticks - 1, -1, -1):
                row = (k * ticks + t) * rows
                reverse_tick(scheme, chain, reverse, drive[k], input_adjoints[k], tape[row : row + rows])
            if _has_infinity(adjoint):
                return k + 1
        return 0

    return RunLoops(forward, backward)


@lru_cache(maxsize=64)
def make_objective_loops(kind: type, note: Callable[..., Any], pullback: Callable[..., Any]) -> ObjectiveLoops:
    """Return the loops for the class of a law and two functions of an `Objective`."""
    note, pullback = _compiled_function(note), _compiled_function(pullback)

    @jit
    def note_steps(table, drive, states, span, constants, sums):
        table, drive, states = unowned_array(table), unowned_array(drive), unowned_array(states)
        chain, first, steps = chain_state(kind, table), span[0], span[1]
        for k in range(len(drive)):
            _set_state(table, states[k])
            note(chain, first + k, steps, drive[k], constants, sums)
            for s in range(len(sums)):
                if not np.isfinite(sums[s]):
                    return k
        return len(drive)

    @jit
    def pull_back_steps(table, adjoint, drive, input_adjoints, states, sources, span, numbers):
        table, adjoint, drive, states = (
            unowned_array(table),
            unowned_array(adjoint),
            unowned_array(drive),
            unowned_array(states),
        )
        sources, input_adjoints = unowned_array(sources), unowned_array(input_adjoints)
        chain, reverse, first, steps = chain_state(kind, table), chain_state(kind, adjoint), span[0], span[1]
        constants, slopes = numbers
        for k in range(len(drive)):
            _set_state(table, states[k])
            forces.fill_array(adjoint[U], 0.0)
            forces.fill_array(adjoint[V], 0.0)
            pullback(chain, reverse, first + k, steps, drive[k], input_adjoints[k], constants, slopes)
            if _has_infinity(adjoint):
                return k
            forces.copy_array(adjoint[U], sources[k, 0])
            forces.copy_array(adjoint[V], sources[k, 1])
        return len(drive)

    return ObjectiveLoops(note_steps, pull_back_steps)


def _compiled_function(function: Callable[..., Any]) -> Callable[..., Any]:
    return function if hasattr(function, "py_func") or not JIT else jit(function)
