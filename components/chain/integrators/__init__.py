"""Integrators of the chain: name -> kernel, its force evaluations, and the rows of history and scratch it wants.

Every kernel has the signature advance(a, drive, left_pieces, left, right, tick, ticks) and returns what
`equations_of_motion.outcome` says; `specialise` makes one for a contact law of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from . import compositions, dop853, hamming, runge_kutta


@dataclass(frozen=True)
class Scheme:
    """An integrator.

    Attributes:
        advance: the kernel.
        adaptive: whether it takes as many steps within one as its error wants.
        order: of the error while no contact opens or closes; 2 at most for damped compositions.
        evaluations: force evaluations of a step (a trial's, where it is adaptive).
        history_rows: rows of state it needs beyond displacement, velocity and peak.
        scratch_rows: rows of scratch it needs.
        step_factor: the step that it needs for the accuracy of the default, in units of PEFRL's.
        pressed_angle: largest step x the lattice's highest angular frequency, under a static load.
        wanted_forces: force evaluations that a contact should see, so that velocities are about as exact as 1e-3.
        composition: its drifts and kicks, None where it is no composition.
        damped_composition: the same where contacts dissipate.
    """

    advance: Callable[..., Any]
    adaptive: bool = field(default=False, kw_only=True)
    order: int
    evaluations: int
    history_rows: int
    scratch_rows: int
    step_factor: float = 1.0
    pressed_angle: float = 0.5
    wanted_forces: float = 60.0
    composition: compositions.Composition | None = None
    damped_composition: compositions.Composition | None = None

    @property
    def explicit(self) -> bool:
        """Return whether dissipation is a force like any other to it; a strong one, in a fixed step, then makes it unstable."""
        return self.composition is None


# The table, the drive (rows of pieces), how many of them are the left end's, the numbers held at both ends, the tick,
# and how many ticks.
SIGNATURE = "int64(float64[:, ::1], float64[:, ::1], int64, float64, float64, int64, int64)"

SCHEMES = {
    "pefrl": Scheme(
        compositions.advance_pefrl,
        4,
        4,
        compositions.HISTORY_ROWS,
        compositions.SCRATCH_ROWS,
        composition=compositions.PEFRL,
        damped_composition=compositions.DAMPED_PEFRL,
    ),
    "leapfrog": Scheme(
        compositions.advance_leapfrog,
        2,
        1,
        compositions.HISTORY_ROWS,
        compositions.SCRATCH_ROWS,
        # Second order: an eighth of the step for the error of the others.
        step_factor=0.125,
        pressed_angle=0.0625,
        wanted_forces=120.0,
        composition=compositions.LEAPFROG,
        damped_composition=compositions.DAMPED_LEAPFROG,
    ),
    "rk4": Scheme(
        runge_kutta.advance_rk4,
        4,
        4,
        runge_kutta.HISTORY_ROWS,
        runge_kutta.SCRATCH_ROWS,
        pressed_angle=0.2,
    ),
    "hamming": Scheme(
        hamming.advance_hamming,
        5,
        2,
        hamming.HISTORY_ROWS,
        hamming.SCRATCH_ROWS,
        pressed_angle=0.2,
        wanted_forces=30.0,
    ),
    "dop853": Scheme(dop853.advance_dop853, 8, 12, dop853.HISTORY_ROWS, dop853.SCRATCH_ROWS, adaptive=True),
}
