"""Boundary conditions at the ends of the tube, by name: closed, open, absorbing, diaphragm, piston."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import SerializeAsAny

from ..support.parameter_fields import Magnitude, field
from ..support.tagged_union import ByName, Named

# Codes of the ends in kernels; a diaphragm that has burst acts as an open end.
CLOSED, OPEN, ABSORBING, DIAPHRAGM, PISTON = 0, 1, 2, 3, 4


class End(Named):
    """An end of the tube, chosen by its `name`."""

    code: ClassVar[int]


class Closed(End):
    """A rigid wall."""

    code: ClassVar[int] = CLOSED
    name: Literal["closed"] = field("closed", "a rigid wall", "1")


class Open(End):
    """An opening to a room at rest with the pressure of the input `<end>_pressure` and the initial temperature of the tube.

    Gas flows in or out, at most at the speed of sound. Inflowing gas keeps the entropy and total enthalpy of the room.
    """

    code: ClassVar[int] = OPEN
    name: Literal["open"] = field("open", "an opening into a room whose pressure is an input", "1")


class Absorbing(End):
    """A non-reflecting end: the flow continues unchanged beyond it."""

    code: ClassVar[int] = ABSORBING
    name: Literal["absorbing"] = field("absorbing", "a non-reflecting end", "1")


class Diaphragm(End):
    """A wall that bursts, and stays open, once the pressure on it reaches `burst_pressure`."""

    code: ClassVar[int] = DIAPHRAGM
    name: Literal["diaphragm"] = field("diaphragm", "a wall that bursts and stays open", "1")
    burst_pressure: Magnitude = field(2e5, "pressure on the wall at which it bursts", "Pa")


class Piston(End):
    """A wall that moves at the velocity of the input `<end>_velocity`; all cells shrink or grow uniformly with it."""

    code: ClassVar[int] = PISTON
    name: Literal["piston"] = field("piston", "a wall whose velocity along x is an input", "1")


ENDS: dict[str, type[End]] = {
    "closed": Closed, "open": Open, "absorbing": Absorbing, "diaphragm": Diaphragm, "piston": Piston
}  # fmt: skip
ChosenEnd = Annotated[SerializeAsAny[End], ByName(ENDS)]
