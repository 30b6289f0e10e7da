"""The layout of the table of numbers that a chain is: the numbers of its rows and columns.

One table makes a call from Python cheap, and a snapshot one copy. Its rows are constants first, then scratch, then the state
(contiguous: this is what a snapshot holds), then the scratch of an integrator. Grains have the columns 1 to n; columns 0 and
n + 1 are the walls, which do not move. Contact j lies between columns j and j + 1.
"""

from __future__ import annotations

# Constants. A prescribed grain has the inverse mass 0 and no mass. LAW_CONSTANTS is the first of the rows with the constants of
# the contact law in addition to the stiffness.
STIFFNESS, REST_OVERLAP, INVERSE_MASS, MASS, LIMIT, SCALARS, LAW_CONSTANTS = range(7)
MOST_LAW_CONSTANTS = 3
# Scratch: the polynomials of the drive about the present tick; a second row of displacements; three rows of the dissipative
# part of a step.
LEFT_DRIVE, RIGHT_DRIVE, OTHER_U, DISSIPATION = range(9, 13)
DISSIPATION_ROWS = 3
# History: state only where the law has any; a law with k rows has the last k of these. LOST is the energy that has become heat
# in each column: in the grains next to a dissipative contact, in a contact that remembers.
HISTORY = DISSIPATION + DISSIPATION_ROWS
MOST_HISTORY_ROWS = 3
LOST = HISTORY + MOST_HISTORY_ROWS
# State. Rows from FREE_ROW on are the history of an integrator, then its scratch.
TALLY, U, V, PEAK, FREE_ROW = range(LOST + 1, LOST + 6)

# Columns of a row in addition to those of the grains: two walls and, in V, five tallies of integrators that carry these as
# unknowns: work left and right, impulse left and right, lost energy.
BESIDE_GRAINS = 7
# Columns of the row TALLY: compensated sums (value, compensation), the sums at the reset, and the memory of Hamming's method.
WORK_LEFT, WORK_RIGHT, IMPULSE_LEFT, IMPULSE_RIGHT = 0, 2, 4, 6
START_ENERGY, START_MOMENTUM, HISTORY_LENGTH, HISTORY_DRIVE = 8, 9, 10, 11

# Overlaps below this count as open: their forces would be denormal numbers, which are slow.
SMALLEST_OVERLAP = 1e-150

# Columns of the row SCALARS.
STEP, GRAVITY, SPEED_LIMIT, GRAINS, LEFT_FREE, LEFT_PISTON, LEFT_MASS, LEFT_STATIC = range(8)
RIGHT_FREE, RIGHT_PISTON, RIGHT_MASS, RIGHT_STATIC = range(8, 12)

# A core distinguishes stores from loads by the last twelve bits of their addresses: rows a multiple of 4096 bytes (512
# columns) apart, or nearly, make it wait. They are at least 80 columns longer than such a multiple, or 32 shorter.
_PAGE, _BEYOND, _BELOW = 512, 80, 32


def row_width(grains: int) -> int:
    """Columns of the table: the grains, two walls, five tallies; at least what the drive's polynomials need."""
    width = max(40, -(-(grains + BESIDE_GRAINS) // 8) * 8)
    beyond = (width + _BELOW) % _PAGE - _BELOW
    return width + _BEYOND - beyond if width + _BELOW >= _PAGE and beyond < _BEYOND else width
