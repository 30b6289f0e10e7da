"""The input of every measurement: the motion of a chain's grains in time, and the constants of the chain."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import Any, Literal

import numpy as np

from granular_env.components.chain import forces, layout
from granular_env.components.chain.laws import Hertz, Law
from granular_env.components.chain.laws.functions import energy as contact_energy
from granular_env.components.chain.state import chain_state, python_chain_state
from granular_env.components.errors import LogError, ParameterError, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import whole_number

Direction = Literal["right", "left"]


@dataclasses.dataclass(frozen=True, eq=False)
class History:
    """The motion of n grains at T times (frames), and the constants of the grains and of their n + 1 contact places.

    Place j is left of grain j; places 0 and n belong to the walls. An end without a wall has no contact, and its force and
    overlap are 0, as in the chain's outputs. `history` makes one from a log, `observe` or `Watch` from a running chain.

    Attributes:
        time: shape (T,), increasing [s].
        velocity: shape (T, n), positive to the right [m/s].
        mass: shape (n,) [kg].
        stiffness: k of F = k overlap^p, shape (n + 1,), 0 where there is no contact [N/m^p]; p = 1.5 for spheres.
        rest_overlap: overlap in the reference configuration, shape (n + 1,), negative for a gap [m].
        position: positions of the grains in the reference configuration, shape (n,) [m].
        displacement: shape (T, n) [m]; None if unknown.
        piston: whether a grain has a prescribed velocity, shape (n,), bool.
        recorded_overlap: shape (T, n + 1) [m], if known without the displacement.
        recorded_force: shape (T, n + 1) [N], if contact forces were recorded.
        law: law of the contacts.
        law_constants: k constants of the law for each contact besides the stiffness, such as dissipation, (n + 1, k), or None.
    """

    time: FloatArray
    velocity: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    rest_overlap: FloatArray
    position: FloatArray
    displacement: FloatArray | None = None
    piston: np.ndarray | None = None
    recorded_overlap: FloatArray | None = None
    recorded_force: FloatArray | None = None
    law: Law = Hertz()
    law_constants: FloatArray | None = None

    def __post_init__(self) -> None:
        frames, grains = len(np.atleast_1d(self.time)), len(np.atleast_1d(self.mass))
        if frames == 0 or grains == 0:
            raise ParameterError(
                f"got {frames} frames of {grains} grains", expected="at least one of each", hint="record a run", at="history"
            )
        places = grains + 1
        for name, shape in (
            ("time", (frames,)), ("velocity", (frames, grains)), ("mass", (grains,)), ("stiffness", (places,)),
            ("rest_overlap", (places,)), ("position", (grains,)), ("displacement", (frames, grains)), ("piston", (grains,)),
            ("recorded_overlap", (frames, places)), ("recorded_force", (frames, places)), 
        ):  # fmt: skip
            value = getattr(self, name)
            if value is not None and np.shape(value) != shape:
                raise ParameterError(f"{name} has shape {np.shape(value)}", expected=str(shape), at="history")
        if self.law_constants is not None and (np.ndim(self.law_constants) != 2 or len(self.law_constants) != places):
            raise ParameterError(
                f"law_constants has shape {np.shape(self.law_constants)}", expected=f"({places}, k)", at="history"
            )
        for name in ("time", "velocity"):
            if not np.isfinite(getattr(self, name)).all():
                raise ParameterError(f"{name} contains a value that is not finite", at="history")
        if (np.diff(self.time) <= 0.0).any():
            raise ParameterError("time does not increase", hint="give one run, without a reset within it", at="history")

    def __repr__(self) -> str:
        begin, end = self.time[[0, -1]]
        return f"<history of {self.grains} grains, {len(self.time)} frames from {begin:.9g} to {end:.9g} s>"

    @property
    def grains(self) -> int:
        """Number of grains."""
        return len(self.mass)

    @cached_property
    def overlap(self) -> FloatArray:
        """Overlap of the surfaces at each contact place, negative for a gap, 0 without a contact, shape (T, n + 1) [m].

        Raises:
            LogError: neither displacement nor overlap was recorded.
        """
        if self.displacement is None:
            if self.recorded_overlap is None:
                raise LogError(
                    "displacement was not recorded, but overlaps, forces and energies require it",
                    hint="record with variables=['velocity', 'displacement']",
                )
            return self.recorded_overlap
        still = np.zeros((len(self.time), 1))
        found = self.rest_overlap - np.diff(self.displacement, axis=1, prepend=still, append=still)
        found[:, self.stiffness == 0.0] = 0.0
        return found

    @cached_property
    def contact_force(self) -> FloatArray:
        """Compressive force at each contact place, never negative, (T, n + 1) [N]; computed by the law if not recorded.

        Raises:
            LogError: overlaps are unknown, or the force depends on the contact's history and was not recorded.
        """
        if self.recorded_force is not None:
            return self.recorded_force
        if self.law.has_history:
            raise LogError(
                f"contact_force was not recorded, and with law {self.law.name!r} it depends on the history of the "
                "contact, which is not in the frames",
                hint="record with variables=['velocity', 'displacement', 'contact_force']",
            )
        return self._contact_forces_and_energies[0]

    @cached_property
    def contact_energy(self) -> FloatArray:
        """Elastic energy stored in each contact according to the chain's law, shape (T, n + 1) [J].

        Raises:
            LogError: overlaps are unknown, or the energy depends on the contact's history.
        """
        if self.law.has_history:
            raise LogError(
                f"with law {self.law.name!r} the energy of a contact depends on its history, which is not in the frames",
                hint="record the output 'potential_energy', the energy of all contacts",
            )
        return self._contact_forces_and_energies[1]

    @property
    def rest_force(self) -> FloatArray:
        """Force in each contact in the reference configuration, from precompression and weight, shape (n + 1,) [N]."""
        return self._rest_forces_and_energies[0]

    @property
    def rest_energy(self) -> FloatArray:
        """Elastic energy stored in each contact in the reference configuration, shape (n + 1,) [J]."""
        return self._rest_forces_and_energies[1]

    @cached_property
    def _contact_forces_and_energies(self) -> tuple[FloatArray, FloatArray]:
        return self._law_forces_and_energies(self.overlap, self.velocity)

    @cached_property
    def _rest_forces_and_energies(self) -> tuple[FloatArray, FloatArray]:
        force, energy = self._law_forces_and_energies(self.rest_overlap[None], np.zeros((1, self.grains)))
        return force[0], energy[0]

    def _law_forces_and_energies(self, overlap: FloatArray, velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
        constants = np.zeros((self.grains + 1, 0)) if self.law_constants is None else self.law_constants
        return forces_and_energies(self.law, self.stiffness, constants, overlap, velocity)

    def frame_number(self, time: float) -> int:
        """Return the index of the frame nearest to a time [s].

        Raises:
            ParameterError: the time is outside the history.
        """
        first, last = float(self.time[0]), float(self.time[-1])
        margin = 1e-9 * (last - first)
        if not (isinstance(time, (int, float, np.number)) and first - margin <= time <= last + margin):
            raise ParameterError(f"got {one_line(time)} s; the history extends from {first:.12g} s to {last:.12g} s", at="time")
        return int(np.argmin(np.abs(self.time - time)))

    def window(self, begin: float | None = None, end: float | None = None) -> slice:
        """Return the slice of the frames from `begin` to `end` [s], both included; by default all frames."""
        first = 0 if begin is None else self.frame_number(begin)
        last = len(self.time) - 1 if end is None else self.frame_number(end)
        if last < first:
            raise ParameterError(
                f"it begins at {begin:g} s and ends at {end:g} s", expected="an end after the beginning", at="window"
            )
        return slice(first, last + 1)

    def valid_grain(self, number: Any, name: str = "grain") -> int:
        """Return a grain number (the first is 0), or raise `ParameterError` if the chain has no such grain."""
        return whole_number(name, number, 0, self.grains - 1)

    def contact_behind(self, grain: int, direction: Direction) -> int:
        """Return the contact place through which a wave running in `direction` reaches a grain.

        Raises:
            ParameterError: there is no contact (an end without a wall).
        """
        place = self.valid_grain(grain) + (0 if direction_sign(direction) > 0.0 else 1)
        if self.stiffness[place] == 0.0:
            raise ParameterError(
                f"grain {grain} has no contact on the side from which a wave travelling {direction} arrives",
                hint="choose a grain further along",
                at="grain",
            )
        return place


def require_history(name: str, value: Any) -> None:
    """Raise `ParameterError` unless the value is a `History`."""
    if not isinstance(value, History):
        raise ParameterError(
            f"got {one_line(value)}", expected="a History", hint="use measurement.history or measurement.observe", at=name
        )


def direction_sign(direction: Any) -> float:
    """Return +1 for waves that run to the right, -1 to the left."""
    if direction not in ("right", "left"):
        raise ParameterError(f"got {one_line(direction)}", expected="'right' or 'left'", at="direction")
    return 1.0 if direction == "right" else -1.0


def forces_and_energies(
    law: Law, stiffness: FloatArray, constants: FloatArray, overlap: FloatArray, velocity: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the compressive force [N] and stored energy [J] of each contact in each frame, both of shape (T, n + 1).

    The forces are bitwise identical to the chain's `contact_force`. Contacts with memory are treated as on first loading.

    Args:
        law: the contact law.
        stiffness: shape (n + 1,), 0 without a contact.
        constants: constants of the law in addition to the stiffness, shape (n + 1, k).
        overlap: shape (T, n + 1), 0 without a contact [m].
        velocity: velocities of the grains, shape (T, n) [m/s].
    """
    table, places = np.zeros((layout.FREE_ROW, layout.row_width(len(stiffness) - 1))), slice(0, len(stiffness))
    table[layout.STIFFNESS, places] = stiffness
    table[layout.LAW_CONSTANTS : layout.LAW_CONSTANTS + constants.shape[1], places] = constants.T
    table[layout.SCALARS, layout.GRAINS] = len(stiffness) - 1
    force, energy = np.empty_like(overlap), np.empty_like(overlap)
    _write_forces_and_energies(python_chain_state(law.contacts, table).law, table, overlap, velocity, force, energy)
    return force, energy


@jit
def _write_forces_and_energies(law, table, overlap, velocity, force, energy):
    """Write the force and energy of each contact; the overlaps enter as rest overlaps of a chain without displacements."""
    chain = chain_state(law, table)
    forces.initialise_histories(chain)
    for t in range(len(overlap)):
        forces.copy_array(overlap[t], table[layout.REST_OVERLAP])
        forces.copy_array(velocity[t], table[layout.V, 1:])
        forces.contact_forces(chain, force[t])
        for j in range(overlap.shape[1]):
            energy[t, j] = contact_energy(chain.law, j, forces.positive_part(overlap[t, j]))
