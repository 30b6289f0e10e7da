"""The layout of the one table of numbers `a` that is a chain, for kernels and for whoever fills it.

Constants come first, then scratch that any kernel may use, then the state (one contiguous piece, which is what a snapshot
holds), then an integrator's own scratch. Grains have the columns 1..n; 0 and n + 1 are the walls, which do not move.
Contact j lies between columns j and j + 1.
"""

from __future__ import annotations

# Constants. A prescribed grain has the inverse mass 0 and no mass. From row LAW_CONSTANTS on lies what the contact law wants to
# know of each contact beside its stiffness.
STIFFNESS, REST_OVERLAP, INVERSE_MASS, MASS, LIMIT, SCALARS, LAW_CONSTANTS = range(7)
MOST_LAW_CONSTANTS = 3
# Scratch: the drive's polynomials, re-centred at the present tick; of each contact that dissipates the impulse per speed of
# approach and the one that leaves no pull; the velocities before.
LEFT_DRIVE, RIGHT_DRIVE, IMPULSE_PER_SPEED, MIN_IMPULSE, OLD_VELOCITY = range(9, 14)
# History, state only where the law has any: a law with k rows has the last k of these. Then the energy that has become heat in
# each column (in the grains beside a dissipative contact, in a contact that remembers).
HISTORY = 14
MOST_HISTORY_ROWS = 3
DISSIPATED = HISTORY + MOST_HISTORY_ROWS
# State. The five columns behind the chain's in V hold work, impulse and lost energy (left work, right work, left impulse,
# right impulse, loss) for integrators that carry them as unknowns of their own. Rows from FREE_ROW on are an
# integrator's history, then its scratch.
TALLY, U, V, PEAK, FREE_ROW = range(DISSIPATED + 1, DISSIPATED + 6)

# Columns that a row has beside the grains': two walls, and those five behind the chain.
BESIDE_GRAINS = 7

# Columns of the row SCALARS.
# RIGHT_BASE is scratch: what one tile tells the next, where a right piston was when the tick began.
STEP, LEFT_KIND, RIGHT_KIND, LEFT_MASS, RIGHT_MASS, LEFT_STATIC, RIGHT_STATIC, SPEED_LIMIT, TOLERANCE, GRAINS = range(10)
EXPONENT, GRAVITY, RIGHT_BASE = range(10, 13)
# Columns of the row TALLY: compensated sums (value, compensation), what was there at the reset, the history's length and drive.
WORK_LEFT, WORK_RIGHT, IMPULSE_LEFT, IMPULSE_RIGHT = 0, 2, 4, 6
START_ENERGY, START_MOMENTUM, HISTORY_LENGTH, HISTORY_DRIVE = 8, 9, 10, 11

# Kinds of an end.
FREE, PISTON, WALL = range(3)
# Overlaps below this count as open: their forces would be denormal numbers, which are slow.
SMALLEST_OVERLAP = 1e-150


# A core tells a store from a load by the last twelve bits of their addresses: rows a multiple of 4096 bytes (512 columns)
# apart, or nearly, make it wait. They are at least 80 columns longer than such a multiple, or 32 shorter.
_PAGE, _BEYOND, _BELOW = 512, 80, 32


def row_width(grains: int) -> int:
    """Columns of the table: the grains, two walls, five tallies; at least what the drive's polynomials need."""
    width = max(40, -(-(grains + BESIDE_GRAINS) // 8) * 8)
    beyond = (width + _BELOW) % _PAGE - _BELOW
    return width + _BEYOND - beyond if width + _BELOW >= _PAGE and beyond < _BEYOND else width
