"""States of the contacts, open, pressed, or cut off in their pull, at every force evaluation: where gradients have kinks.

Two runs between which no contact's state differs anywhere lie on one smooth piece of an objective.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...support.jit import jit
from ..component import Chain
from ..integrators.dissipative_step import half_sweep, is_closing, prepare
from ..laws.placeholders import DISSIPATES, JUMPS
from ..layout import (
    FREE_ROW,
    GRAINS,
    IMPULSE_PER_SPEED,
    MIN_IMPULSE,
    REST_OVERLAP,
    SCALARS,
    SMALLEST_OVERLAP,
    STEP,
    STIFFNESS,
    V,
)
from ..specialisation import specialise
from .gradient import composition_of, validate_drive, validate_ticks
from .tape import record, rows_per_tick

_PRIME = np.uint64(1099511628211)
_ONE, _TWO = np.uint64(1), np.uint64(2)


@jit
def _mix(mark, bit):
    return (mark ^ (_TWO if bit else _ONE)) * _PRIME


@jit
def _note_overlaps(a, row, marks):
    for j in range(int(a[SCALARS, GRAINS]) + 1):
        if a[STIFFNESS, j] > 0.0:  # a free end has no contact
            marks[j] = _mix(marks[j], a[row, j] - a[row, j + 1] + a[REST_OVERLAP, j] >= SMALLEST_OVERLAP)


@jit
def _note_pulls(a, row, marks):
    """Note where a dashpot's contact closes, and where the dissipative force is cut off in each of the three half sweeps."""
    for i in range(a.shape[1]):
        a[V, i] = a[row + 1, i]
    if JUMPS:
        for j in range(int(a[SCALARS, GRAINS]) + 1):
            d, w = a[row, j] - a[row, j + 1] + a[REST_OVERLAP, j], a[V, j] - a[V, j + 1]
            marks[j] = _mix(marks[j], a[STIFFNESS, j] > 0.0 and is_closing(d, w, a[SCALARS, STEP]))
    prepare(a, row, a[SCALARS, STEP])
    for sweep in range(3):
        parity = sweep % 2
        for j in range(parity, int(a[SCALARS, GRAINS]) + 1, 2):
            marks[j] = _mix(marks[j], a[IMPULSE_PER_SPEED, j] * (a[V, j] - a[V, j + 1]) > a[MIN_IMPULSE, j])
        half_sweep(a, np.uint64(parity))


@jit
def _watch(a, drive, ticks, drifts, kicks, passed, marks):
    steps, stages, n = drive.shape[0], len(kicks), int(a[SCALARS, GRAINS])
    for step in range(steps):
        record(a, drive[step, 0], drive[step, 1], ticks, FREE_ROW + 1, drifts, kicks, passed)
        before = a[V].copy()
        row = FREE_ROW + 1
        for _ in range(ticks):
            for s in range(stages):
                _note_overlaps(a, row, marks[step])
                if DISSIPATES and s == stages // 2:
                    _note_pulls(a, row, marks[step])
                    row += 1
                row += 1
        for i in range(n + 2):
            a[V, i] = before[i]


def contact_states(chain: Chain, drive: npt.ArrayLike, ticks: int) -> npt.NDArray[np.uint64]:
    """Return a mark of what each contact goes through in each control step, shape (steps, n + 1), without changing the chain.

    Marks of two runs differ where a contact is open in the one and closed in the other at any force evaluation, or where its
    dissipative force is cut off in the one and not in the other. Limits are not looked at.

    Raises:
        ParameterError: there is no adjoint of this chain, or the drive does not fit.
    """
    composition, law_type = composition_of(chain), type(chain.parameters.law)
    inputs, ticks = validate_drive(chain, drive), validate_ticks(ticks)
    a = chain.detached_table(ticks * specialise(rows_per_tick, law_type)(len(composition.kicks)))
    marks = np.zeros((len(inputs), chain.parameters.grains + 1), dtype=np.uint64)
    with np.errstate(over="ignore"):  # marks wrap around
        specialise(_watch, law_type)(a, inputs, ticks, composition.drifts, composition.kicks, composition.passed, marks)
    return marks
