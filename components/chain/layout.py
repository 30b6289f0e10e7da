"""Layout of the table that stores a chain: indices of its rows and columns.

A single table makes calls from Python cheap, and a snapshot is one copy. Its rows are the constants, then scratch, then the
state (contiguous, because a snapshot copies it), then the scratch of an integrator. Grains have the columns 1 to n; columns 0
and n + 1 are the walls, which do not move. Contact j lies between columns j and j + 1.
"""

from __future__ import annotations

# Constants. A prescribed grain has the inverse mass 0 and the mass 0. LAW_CONSTANTS is the first of the rows with additional
# constants of the contact law.
STIFFNESS, REST_OVERLAP, INVERSE_MASS, MASS, LIMIT, SCALARS, LAW_CONSTANTS = range(7)
MOST_LAW_CONSTANTS = 3
# Scratch: polynomials of the drive centred at the present tick; a second row of displacements; three rows for the dissipative
# part of a step.
LEFT_DRIVE, RIGHT_DRIVE, OTHER_U, DISSIPATION = range(9, 13)
DISSIPATION_ROWS = 3
# History: part of the state only for laws with a history; a law with k rows has the last k of these. LOST is the energy
# dissipated in each column: in the grains next to a dissipative contact, or in a contact with a history.
HISTORY = DISSIPATION + DISSIPATION_ROWS
MOST_HISTORY_ROWS = 3
LOST = HISTORY + MOST_HISTORY_ROWS
# State. Rows from FREE_ROW on are the history of an integrator, then its scratch.
TALLY, U, V, PEAK, FREE_ROW = range(LOST + 1, LOST + 6)

# Columns of a row in addition to the grains: two walls and, in V, five tallies for integrators that treat them as unknowns:
# work left and right, impulse left and right, dissipated energy.
BESIDE_GRAINS = 7
# Columns of the row TALLY: compensated sums (value, compensation), the sums at the reset, and the memory of Hamming's method.
WORK_LEFT, WORK_RIGHT, IMPULSE_LEFT, IMPULSE_RIGHT = 0, 2, 4, 6
START_ENERGY, START_MOMENTUM, HISTORY_LENGTH, HISTORY_DRIVE = 8, 9, 10, 11

# Contacts with smaller overlaps count as open, because their forces would be subnormal numbers, which are slow.
SMALLEST_OVERLAP = 1e-150

# Columns of the row SCALARS.
STEP, GRAVITY, SPEED_LIMIT, GRAINS, LEFT_FREE, LEFT_PISTON, LEFT_MASS, LEFT_STATIC = range(8)
RIGHT_FREE, RIGHT_PISTON, RIGHT_MASS, RIGHT_STATIC = range(8, 12)

# A core distinguishes stores from loads by the last twelve bits of their addresses: it stalls if rows are a multiple of 4096
# bytes (512 columns) apart, or nearly. Rows are therefore at least 80 columns longer than a multiple, or 32 shorter.
_PAGE, _BEYOND, _BELOW = 512, 80, 32


def row_width(grains: int) -> int:
    """Return the number of columns: grains, two walls, five tallies, and at least enough for the drive's polynomials."""
    width = max(40, -(-(grains + BESIDE_GRAINS) // 8) * 8)
    beyond = (width + _BELOW) % _PAGE - _BELOW
    return width + _BEYOND - beyond if width + _BELOW >= _PAGE and beyond < _BEYOND else width
