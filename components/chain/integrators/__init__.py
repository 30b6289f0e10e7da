"""Integrators of the chain: name -> kernel, its forces per step, and the rows of state and scratch it wants.

Every kernel has the signature advance(memory, constants, scratch, drive, left_pieces, tick, ticks) and returns the ticks done, negative
where a limit was passed in the last of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..kernels import STATE_ROWS
from . import compositions, dop853, hamming, runge_kutta


@dataclass(frozen=True)
class Scheme:
    """An integrator.

    Attributes:
        advance: the kernel.
        order: of the error while no contact opens or closes.
        forces: force evaluations of a step (a trial's, where it is adaptive).
        state_rows: rows of state it needs.
        scratch_rows: rows of scratch it needs.
    """

    advance: Callable[..., Any]
    order: int
    forces: int
    state_rows: int
    scratch_rows: int


SCHEMES = {
    "pefrl": Scheme(compositions.advance_pefrl, 4, 4, STATE_ROWS, compositions.SCRATCH_ROWS),
    "leapfrog": Scheme(compositions.advance_leapfrog, 2, 1, STATE_ROWS, compositions.SCRATCH_ROWS),
    "rk4": Scheme(runge_kutta.advance_rk4, 4, 4, runge_kutta.STATE_ROWS, runge_kutta.SCRATCH_ROWS),
    "hamming": Scheme(hamming.advance_hamming, 4, 2, hamming.STATE_ROWS, hamming.SCRATCH_ROWS),
    "dop853": Scheme(dop853.advance_dop853, 8, 12, dop853.STATE_ROWS, dop853.SCRATCH_ROWS),
}
