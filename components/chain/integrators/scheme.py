"""The interface of integrators, `advance_tick`, dispatched on the class of their coefficients; and the loop over ticks."""

from __future__ import annotations

from functools import cache, partial
from typing import Any, NamedTuple

from ...support.dispatch import dispatch_by_class
from ...support.jit import internal_inlined, jit
from ...support.unowned_array import unowned_array
from .. import forces
from ..drive import centre_drive, make_drive
from ..layout import V
from ..state import chain_state

# `advance` subtracts this from its result if a velocity passed its limit or is NaN.
UNSOUND = 1 << 60


@partial(dispatch_by_class, inlined=True)
def advance_tick(scheme, chain, drive, tick, tape):
    """Advance a chain by one tick, with the drive set to it; return whether an overlap passed its limit.

    `tape` receives the data that an adjoint needs of the tick; without rows nothing is recorded.
    """


@internal_inlined
def advance(scheme, chain, drive, tick, ticks, tape):
    """Advance by `ticks` ticks, or until a limit is passed; `tape` holds the same number of rows for each of the ticks.

    Returns:
        Number of completed ticks, negative if an overlap passed its limit, and minus `UNSOUND` if a velocity did.
    """
    v, rows = chain.rows[V, 1 : chain.settings.grains + 1], len(tape) // ticks
    for t in range(tick, tick + ticks):
        centre_drive(drive, t)
        done = t + 1 - tick
        passed_limit = advance_tick(scheme, chain, drive, t, tape[(done - 1) * rows : done * rows])
        forces.update_histories(chain)
        if forces.is_too_fast(v, chain.settings.speed_limit):
            return -done - UNSOUND
        if passed_limit:
            return -done
    return ticks


class EntryPoints(NamedTuple):
    """Compiled functions of a law and an integrator for calls from Python; all take a chain's table.

    Attributes:
        advance: advance(table, pieces, left_pieces, left, right, tick, ticks), for a drive of pieces.
        advance_held: advance_held(table, left, right, tick, ticks), for constant inputs.
        advance_batch: advance_batch(tables, inputs, ticks, count, is_moving, saved_rows, first) advances each chain in
            `is_moving` by `count` ticks with the inputs held; a chain that fails keeps its state and is removed from
            `is_moving`. `saved_rows` is scratch for the state of a chain, whose rows begin at `first`.
        energies: energies(table, mass), see `forces.energies`.
        contact_forces: contact_forces(table, out).
        initialise_histories: initialise_histories(table).
        update_histories: update_histories(table).
    """

    advance: Any
    advance_held: Any
    advance_batch: Any
    energies: Any
    contact_forces: Any
    initialise_histories: Any
    update_histories: Any


@cache
def make_entry_points(kind: type, integrator: Any) -> EntryPoints:
    """Return the functions for a law's class and an integrator, whose arguments are only a few arrays and numbers.

    A `ChainState` as an argument would cost a microsecond per array in each call from Python.
    """

    @jit
    def advance_driven(table, pieces, left_pieces, left, right, tick, ticks):
        table = unowned_array(table)
        drive = make_drive(table, pieces, left_pieces, left, right)
        return advance(integrator, chain_state(kind, table), drive, tick, ticks, table[:0])

    @jit
    def advance_held(table, left, right, tick, ticks):
        table = unowned_array(table)
        drive = make_drive(table, table[:0], 0, left, right)
        return advance(integrator, chain_state(kind, table), drive, tick, ticks, table[:0])

    @jit
    def advance_batch(tables, inputs, ticks, count, is_moving, saved_rows, first):
        tables = unowned_array(tables)
        for k in range(len(ticks)):
            if is_moving[k]:
                table = tables[k]
                for row in range(len(saved_rows)):
                    forces.copy_array(table[first + row], saved_rows[row])
                drive = make_drive(table, table[:0], 0, inputs[k, 0], inputs[k, 1])
                if advance(integrator, chain_state(kind, table), drive, ticks[k], count, table[:0]) == count:
                    ticks[k] += count
                else:
                    is_moving[k] = False
                    for row in range(len(saved_rows)):
                        forces.copy_array(saved_rows[row], table[first + row])

    @jit
    def energies(table, mass):
        return forces.energies(chain_state(kind, table), mass)

    @jit
    def contact_forces(table, out):
        forces.contact_forces(chain_state(kind, table), out)

    @jit
    def initialise_histories(table):
        forces.initialise_histories(chain_state(kind, table))

    @jit
    def update_histories(table):
        forces.update_histories(chain_state(kind, table))

    return EntryPoints(
        advance_driven, advance_held, advance_batch, energies, contact_forces, initialise_histories, update_histories
    )
