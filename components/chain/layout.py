"""Where everything lies in the one table of numbers `a` that is a chain, for kernels and for whoever fills it.

Constants come first, then scratch that any kernel may use, then the state (one contiguous piece, which is what a snapshot
holds), then an integrator's own scratch. Grains have the columns 1..n; 0 and n + 1 are the walls, which do not move.
Contact j lies between columns j and j + 1.
"""

from __future__ import annotations

# Constants. A prescribed grain has the inverse mass 0 and no mass. CONTACT is what the contact law makes of it: a dissipation,
# the root of a yield overlap.
STIFFNESS, REST_OVERLAP, INVERSE_MASS, MASS, LIMIT, CONTACT, SCALARS = range(7)
# Scratch: the drive's polynomials, re-centred at the present tick; two numbers for each contact that dissipates, and the
# velocities before.
LEFT_DRIVE, RIGHT_DRIVE, IMPULSE_PER_SPEED, MIN_IMPULSE, OLD_VELOCITY = range(7, 12)
# History, state only where the law has any: unloading stiffness, residual overlap and deepest overlap of plastic contacts; the
# energy that has become heat in each column (in the grains beside a dissipative contact, in a plastic contact).
UNLOADING, RESIDUAL, DEEPEST, DISSIPATED = range(12, 16)
# State. The five columns behind the chain's in V hold work, impulse and lost energy (left work, right work, left impulse,
# right impulse, loss) for integrators that carry them as unknowns of their own. Rows from FREE_ROW on are an
# integrator's history, then its scratch.
TALLY, U, V, PEAK, FREE_ROW = range(16, 21)

# Columns that a row has beside the grains': two walls, and those five behind the chain.
BESIDE_GRAINS = 7

# Columns of the row SCALARS. RIGHT_BASE is scratch: what one tile tells the next, where a right piston was when the tick began.
STEP, LEFT_KIND, RIGHT_KIND, LEFT_MASS, RIGHT_MASS, LEFT_STATIC, RIGHT_STATIC, SPEED_LIMIT, TOLERANCE, GRAINS = range(10)
ELASTIC, DISSIPATION, EXPONENT, GRAVITY, RIGHT_BASE = range(10, 15)
# Columns of the row TALLY: compensated sums (value, compensation), what was there at the reset, the history's length and drive.
WORK_LEFT, WORK_RIGHT, IMPULSE_LEFT, IMPULSE_RIGHT = 0, 2, 4, 6
START_ENERGY, START_MOMENTUM, HISTORY_LENGTH, HISTORY_DRIVE = 8, 9, 10, 11

# Kinds of an end.
FREE, PISTON, WALL = range(3)
# Kinds of elastic force, and of dissipation beside it.
HERTZ, POWER, PLASTIC = range(3)
NONE, VISCOUS, KUWABARA_KONO = range(3)

# Overlaps below this count as open: their forces would be denormal numbers, which are slow.
SMALLEST_OVERLAP = 1e-150


def row_width(grains: int) -> int:
    """Columns of the table: the grains, two walls, five tallies; at least what the drive's polynomials need."""
    return max(40, -(-(grains + BESIDE_GRAINS) // 8) * 8)
