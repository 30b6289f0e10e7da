"""States of the contacts, open, pressed, or cut off in their pull, at every force evaluation: where gradients have kinks.

Two runs between which no contact's state differs anywhere lie on one smooth piece of an objective.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...support.jit import internal, jit
from ..component import Chain
from ..integrators import DampedComposition
from ..integrators.dissipative_step import half_sweep, is_closing, prepare
from ..laws.functions import jumps
from ..layout import DISSIPATION, LIMIT, REST_OVERLAP, SCALARS, SMALLEST_OVERLAP, SPEED_LIMIT, STIFFNESS, U, V
from ..state import chain_state
from .gradient import refuse_without_adjoint, tape_rows, validate_drive, validate_ticks
from .loops import loops

_PRIME = np.uint64(1099511628211)
_ONE, _TWO = np.uint64(1), np.uint64(2)


@internal
def _mix(mark, bit):
    return (mark ^ (_TWO if bit else _ONE)) * _PRIME


@internal
def _note_overlaps(chain, u, marks):
    for j in range(chain.settings.grains + 1):
        if chain.rows[STIFFNESS, j] > 0.0:  # a free end has no contact
            marks[j] = _mix(marks[j], u[j] - u[j + 1] + chain.rows[REST_OVERLAP, j] >= SMALLEST_OVERLAP)


@internal
def _note_pulls(chain, u, v, marks):
    """Note where a dashpot's contact closes, and where the dissipative force is cut off in each of the three half sweeps."""
    a, n, h = chain.rows, chain.settings.grains, chain.settings.step
    for i in range(n + 2):
        a[V, i] = v[i]
    for j in range(n + 1):
        d, w = u[j] - u[j + 1] + a[REST_OVERLAP, j], a[V, j] - a[V, j + 1]
        if jumps(chain.law):
            marks[j] = _mix(marks[j], a[STIFFNESS, j] > 0.0 and is_closing(d, w, h))
    prepare(chain, u)
    for sweep in range(3):
        for j in range(sweep % 2, n + 1, 2):
            marks[j] = _mix(marks[j], a[DISSIPATION, j] * (a[V, j] - a[V, j + 1]) > a[DISSIPATION + 1, j])
        half_sweep(chain, sweep % 2)


@jit
def _mark_elastic(kind, table, tape, marks):
    chain = chain_state(kind, table)
    for row in range(len(tape)):
        _note_overlaps(chain, tape[row], marks)


@jit
def _mark_damped(kind, table, tape, rows, marks):
    """Note the states of the contacts on a tape with so many rows for each tick, of which the middle one has velocities."""
    chain = chain_state(kind, table)
    middle = (rows - 1) // 2
    for row in range(len(tape)):
        place = row % rows
        if place != middle + 1:
            _note_overlaps(chain, tape[row], marks)
        if place == middle:
            _note_pulls(chain, tape[row], tape[row + 1], marks)


def contact_states(chain: Chain, drive: npt.ArrayLike, ticks: int) -> npt.NDArray[np.uint64]:
    """Return a mark of what each contact goes through in each control step, shape (steps, n + 1), without changing the chain.

    Marks of two runs differ where a contact is open in the one and closed in the other at any force evaluation, or where its
    dissipative force is cut off in the one and not in the other. Limits are not looked at.

    Raises:
        ParameterError: there is no adjoint of this chain, or the drive does not fit.
    """
    refuse_without_adjoint(chain)
    inputs, ticks = validate_drive(chain, drive), validate_ticks(ticks)
    forward, law = loops(chain.parameters.law.contacts, chain.scheme).forward, chain.state.law
    table, rows = chain.detached_table(), tape_rows(chain)
    table[LIMIT], table[SCALARS, SPEED_LIMIT] = np.inf, np.inf
    tape, state = np.zeros((ticks * rows, table.shape[1])), np.zeros((1, 2, table.shape[1]))
    marks = np.zeros((len(inputs), chain.parameters.grains + 1), dtype=np.uint64)
    with np.errstate(over="ignore"):  # marks wrap around
        for step in range(len(inputs)):
            forward(table, inputs[step : step + 1], 0, ticks, state, tape)
            if isinstance(chain.scheme, DampedComposition):
                _mark_damped(law, table, tape, rows, marks[step])
            else:
                _mark_elastic(law, table, tape, marks[step])
            table[[U, V]] = state[0]
    return marks
