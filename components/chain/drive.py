"""The drive of both ends: a constant, or piecewise polynomials in time, evaluated as one polynomial per tick.

e is the fraction of a step after the tick, s the ticks since the beginning of a piece.
"""

from __future__ import annotations

from typing import NamedTuple

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined
from .layout import LEFT_DRIVE, RIGHT_DRIVE


class Drive(NamedTuple):
    """The inputs of both ends.

    Attributes:
        pieces: rows (first tick, coefficients in ticks), those of the left end first, shape (pieces, 1 + coefficients).
        left_pieces: number of rows of the left end.
        left_number: value before the first piece of the left end [N or m/s].
        right_number: likewise, of the right end.
        left: polynomial of the left input about the present tick, its coefficients per tick^k; written by `centre_drive`.
        right: likewise, of the right input.
    """

    pieces: FloatArray
    left_pieces: int
    left_number: float
    right_number: float
    left: FloatArray
    right: FloatArray


@internal_inlined
def make_drive(table, pieces, left_pieces, left_number, right_number):
    """Return a drive; its present polynomials are stored in the table of the chain."""
    length = max(pieces.shape[1] - 1, 1) if pieces.shape[0] > 0 else 1
    left, right = table[LEFT_DRIVE, :length], table[RIGHT_DRIVE, :length]
    return Drive(pieces, left_pieces, left_number, right_number, left, right)


@internal_inlined
def centre_drive(drive, tick):
    """Write the polynomials `left` and `right` of the inputs, with their origin at a tick."""
    end = drive.pieces.shape[0]
    _centre_piece(drive.left, drive.pieces, _piece_index(drive.pieces, 0, drive.left_pieces, tick), drive.left_number, tick)
    _centre_piece(drive.right, drive.pieces, _piece_index(drive.pieces, drive.left_pieces, end, tick), drive.right_number, tick)


@internal
def _piece_index(pieces, first, last, tick):
    """Return the row in first..last-1 of the piece that applies at a tick; -1 before the first piece."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if pieces[middle, 0] <= tick:
            low = middle + 1
        else:
            high = middle
    return low - 1 if low > first else -1


@internal
def _centre_piece(polynomial, pieces, piece, number, tick):
    """Write the polynomial of a piece about a tick, as a function of the time in steps; `number` before the first piece."""
    n = len(polynomial)
    if piece < 0:
        for i in range(n):
            polynomial[i] = number if i == 0 else 0.0
        return
    for i in range(n):
        polynomial[i] = pieces[piece, i + 1]
    s = tick - pieces[piece, 0]
    for i in range(n - 1):
        for j in range(n - 2, i - 1, -1):
            polynomial[j] += s * polynomial[j + 1]


@internal_inlined
def polynomial_value(polynomial, e):
    """Return the value of a polynomial at the fraction e of a step after the tick."""
    p = 0.0
    for i in range(len(polynomial) - 1, -1, -1):
        p = p * e + polynomial[i]
    return p


@internal_inlined
def polynomial_integral(polynomial, e):
    """Return the integral of a polynomial from the tick to the fraction e of the step after it, with time in steps."""
    p = 0.0
    for i in range(len(polynomial) - 1, -1, -1):
        p = p * e + polynomial[i] / (i + 1)
    return p * e


@internal
def piece_numbers(drive, tick):
    """Return for each end a number that changes with the piece of its input; multistep integrators restart when it changes."""
    left = _piece_index(drive.pieces, 0, drive.left_pieces, tick)
    right = _piece_index(drive.pieces, drive.left_pieces, drive.pieces.shape[0], tick)
    return _piece_number(drive.pieces, left, drive.left_number), _piece_number(drive.pieces, right, drive.right_number)


@internal
def _piece_number(pieces, piece, number):
    mark = number
    if piece >= 0:
        for i in range(pieces.shape[1]):
            mark = mark * 1.6180339887498949 + pieces[piece, i]
    return mark
