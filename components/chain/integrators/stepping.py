"""The loop over ticks that the integrators without stages in place share: drive, one step, pistons, tallies, limits."""

from __future__ import annotations

from ...jit import jit
from .. import kernels
from ..kernels import LEFT_DRIVE, RIGHT_DRIVE, SCALARS, TALLY, U, V


def ticking(rows, one_step):
    """`advance` around `one_step(tally, state, constants, scratch, n_left, n_right)`, for a state of so many rows."""

    @jit
    def advance(memory, constants, scratch, drive, left_pieces, tick, ticks):
        """Advance by `ticks`; returns the ticks done, negative if a limit was passed in the last of them."""
        width = constants.shape[1]
        n = int(constants[SCALARS, 8])
        tally = memory[:TALLY]
        state = memory[TALLY : TALLY + rows * width].reshape((rows, width))
        left_piece = kernels.piece_at(drive, 0, left_pieces, tick)
        right_piece = kernels.piece_at(drive, left_pieces, drive.shape[0], tick)
        for t in range(tick, tick + ticks):
            while left_piece + 1 < left_pieces and drive[left_piece + 1, 0] <= t:
                left_piece += 1
            while right_piece + 1 < drive.shape[0] and drive[right_piece + 1, 0] <= t:
                right_piece += 1
            n_left = kernels.recentre(drive, left_piece, 0, t, scratch[LEFT_DRIVE])
            n_right = kernels.recentre(drive, right_piece, left_pieces, t, scratch[RIGHT_DRIVE])
            # What tells one piece of a drive from another: integrators with a memory start anew where it changes.
            mark = piece_mark(drive, left_piece, 0) + 3.0 * piece_mark(drive, right_piece, left_pieces)
            left_before, right_before = state[V, 1], state[V, n]
            one_step(tally, state, constants, scratch, n_left, n_right, mark)
            kernels.tally_pistons(tally, constants, state[V], left_before, right_before)
            if kernels.note_peaks(state[U], constants, state[kernels.PEAK]):
                return -(t + 1 - tick)
        if kernels.unsound(state, constants):
            return -ticks
        return ticks

    return advance


@jit
def piece_mark(drive, piece, first):
    """A number that differs between pieces that differ."""
    mark = 0.0
    if piece >= first:
        for i in range(drive.shape[1]):
            mark = mark * 1.6180339887498949 + drive[piece, i]
    return mark
