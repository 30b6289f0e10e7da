"""The arguments that kernels take for a chain: law, table and settings.

The adjoint of a chain is a second table, whose entries are derivatives of an objective with respect to those of the first.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..support.float_arrays import FloatArray
from ..support.jit import inlined
from . import layout
from .laws.functions import contact_law


class End(NamedTuple):
    """An end of the chain: free, a piston, or else a wall.

    Attributes:
        is_free: whether a force drives the end grain.
        is_piston: whether the velocity of the end grain is prescribed.
        mass: mass of the end grain [kg].
        static_force: compressive force on a free end [N].
    """

    is_free: bool
    is_piston: bool
    mass: float
    static_force: float


class Settings(NamedTuple):
    """Scalar constants of a chain.

    Attributes:
        grains: number n of grains.
        step: length of a tick [s].
        gravity: acceleration [m/s^2].
        speed_limit: largest velocity of a grain [m/s].
        left: left end.
        right: right end.
    """

    grains: int
    step: float
    gravity: float
    speed_limit: float
    left: End
    right: End


class ChainState(NamedTuple):
    """A chain in the form in which kernels take it as an argument.

    Attributes:
        law: contact law, whose arrays have one number for each contact.
        rows: the table of numbers, with the rows of `layout`: ``chain.rows[V, i + 1]`` is the velocity of grain i, counted from
            0, and contact j lies between columns j and j + 1.
        settings: scalar constants.
    """

    law: Any
    rows: FloatArray
    settings: Settings


@inlined
def chain_state(kind, table):
    """Return a chain with its numbers in a table; `kind` is the class of its contact law, or a law of that class."""
    a = table[layout.SCALARS]
    left = End(a[layout.LEFT_FREE] > 0.0, a[layout.LEFT_PISTON] > 0.0, a[layout.LEFT_MASS], a[layout.LEFT_STATIC])
    right = End(a[layout.RIGHT_FREE] > 0.0, a[layout.RIGHT_PISTON] > 0.0, a[layout.RIGHT_MASS], a[layout.RIGHT_STATIC])
    settings = Settings(int(a[layout.GRAINS]), a[layout.STEP], a[layout.GRAVITY], a[layout.SPEED_LIMIT], left, right)
    constants, history = table[layout.LAW_CONSTANTS : layout.LEFT_DRIVE], table[layout.HISTORY : layout.LOST]
    return ChainState(contact_law(kind, table[layout.STIFFNESS], constants, history), table, settings)


def python_chain_state(kind: type, table: FloatArray) -> ChainState:
    """Return the `ChainState` in Python, to call jitted functions with it."""
    return getattr(chain_state, "py_func", chain_state)(kind, table)
