"""A native batch of chains: their tables in one array, advanced by one call of compiled code, and read row by row."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain import differentiable_quantities as quantities
from granular_env.components.chain.integrators import SIGNATURE as ADVANCE
from granular_env.components.chain.layout import TALLY, WORK_LEFT, WORK_RIGHT, U, V
from granular_env.components.errors import StepError
from granular_env.components.support.addresses import address, caller
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit

_NO_DRIVE = np.zeros((0, 2))
_SIDES = {"left": 0, "right": 1}
_advance = caller(ADVANCE)


@jit
def _advance_chains(advance, tables, drive, inputs, ticks, count, moving, kept, first):
    """Advance each chain that moves by `count` ticks; those that cannot stay where they were and no longer move.

    Args:
        advance: address of the integrator.
        tables: of the chains, shape (chains, rows, width).
        drive: no pieces of a profile.
        inputs: held at the left and the right end, shape (chains, 2).
        ticks: of the chains, shape (chains,); written.
        count: ticks to advance.
        moving: which chains are to be advanced, shape (chains,); written.
        kept: room for the state of a chain, whose rows begin with `first`.
        first: row.
    """
    for k in range(len(ticks)):
        if moving[k]:
            a = tables[k]
            for row in range(kept.shape[0]):
                for i in range(np.uint64(kept.shape[1])):
                    kept[row, i] = a[first + row, i]
            if _advance(advance, (a, drive, np.int64(0), inputs[k, 0], inputs[k, 1], ticks[k], count)) == count:
                ticks[k] += count
            else:
                moving[k] = False
                for row in range(kept.shape[0]):
                    for i in range(np.uint64(kept.shape[1])):
                        a[first + row, i] = kept[row, i]


@jit
def _contact_forces(tables, first, out):
    for k in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[k, j] = quantities.contact_force(tables[k], first + j)


@jit
def _energies_between(tables, first, last, out):
    for k in range(len(out)):
        out[k] = quantities.energy_between(tables[k], first, last)


class ChainRows:
    """Chains as rows of arrays, for tasks that judge rows and for native batches.

    Args:
        chains: of equal size, law and integrator.
        together: whether the chains are copied into one array; otherwise there is one chain, which stays where it is.

    Attributes:
        components: the chains.
        tables: their tables, shape (chains, rows, width).
        displacement: of the grains, shape (chains, grains) [m]; a view that cannot be written.
        velocity: likewise [m/s].
    """

    def __init__(self, chains: Sequence[Chain], together: bool = False) -> None:
        first, count = chains[0], len(chains)
        self.tables: FloatArray = np.zeros((count, *first.table.shape)) if together else first.table[None]
        self.components: list[Chain] = [*chains]
        self.grains = first.parameters.grains
        self.displacement, self.velocity = (self.tables[:, row, 1 : self.grains + 1] for row in (U, V))
        self.displacement.flags.writeable = self.velocity.flags.writeable = False
        self._names = [
            (side, f"{side}_{name}") for side in _SIDES for name in ("force", "velocity") if f"{side}_{name}" in first.variables
        ]
        self._ticks, self._inputs = np.zeros(count, np.int64), np.zeros((count, 2))
        self._together, self._kernels = together, dict[Any, Any]()
        if together:
            self._address = address(first.scheme_kernel, ADVANCE)
            rows = first.state_rows
            for k, chain in enumerate(chains):
                self.adopt(k, chain).restore(chain.save())
            self._kept, self._first_row = np.zeros((rows.stop - rows.start, self.tables.shape[2])), rows.start

    # -- what tasks read ----------------------------------------------------------------------------------------------

    @property
    def input_work(self) -> FloatArray:
        """Return the work done by inputs and boundaries since the reset, shape (chains,) [J]."""
        behind = self.grains + 2
        tallied = self.tables[:, TALLY, WORK_LEFT] + self.tables[:, TALLY, WORK_RIGHT]
        return tallied + self.tables[:, V, behind] + self.tables[:, V, behind + 1]

    @property
    def contact_force(self) -> FloatArray:
        """Return the compressive force in each contact, shape (chains, grains + 1) [N]."""
        return self._contact_forces(0, self.grains + 1)

    @property
    def right_wall_force(self) -> FloatArray:
        """Return the force of the right wall on the chain, shape (chains,), positive to the right [N]."""
        return 0.0 - self._contact_forces(self.grains, 1)[:, 0]

    def _contact_forces(self, first: int, count: int) -> FloatArray:
        forces = np.empty((len(self.tables), count))
        self.call(_contact_forces, first, forces)
        return forces

    def energy_from(self, grain: int) -> FloatArray:
        """Return the energy above that at rest of the grains from `grain` on and of their contacts, shape (chains,) [J]."""
        energies = np.empty(len(self.tables))
        self.call(_energies_between, grain + 1, self.grains, energies)
        return energies

    def call(self, kernel: Callable[..., Any], *arguments: Any) -> Any:
        """Call a jitted function with the tables and further arguments, for the contact law of the chains."""
        if kernel not in self._kernels:
            self._kernels[kernel] = self.components[0].specialise(kernel)
        return self._kernels[kernel](self.tables, *arguments)

    # -- what batches do ----------------------------------------------------------------------------------------------

    @property
    def time(self) -> FloatArray:
        """Return the time since each chain's reset, shape (chains,) [s]."""
        return self._ticks * self.components[0].step_size

    def read(self, name: str) -> FloatArray:
        """Return an output of every chain, with a leading axis."""
        if name in ("displacement", "velocity", "contact_force", "right_wall_force", "input_work"):
            return getattr(self, name)
        for k in range(len(self.components)) if self._together else ():
            self.synchronise(k)
        return np.array([chain.get(name) for chain in self.components], dtype=np.float64)

    def adopt(self, k: int, chain: Chain) -> Chain:
        """Return chain k replaced by one like the one given, in the memory of the batch."""
        self.components[k] = chain.clone(self.tables[k])
        return self.components[k]

    def refresh(self, chosen: Collection[int]) -> None:
        """Take time and inputs of the chosen chains, which were used by themselves."""
        for k in chosen:
            chain = self.components[k]
            self._ticks[k] = chain.tick
            for side, name in self._names:
                self._inputs[k, _SIDES[side]] = chain.peek(name)

    def synchronise(self, k: int) -> None:
        """Tell chain k which time it is and which inputs are held."""
        chain = self.components[k]
        if not chain.follows_profile:
            held = {name: float(self._inputs[k, _SIDES[side]]) for side, name in self._names}
            chain.adopt(int(self._ticks[k]), held)

    def advance(
        self, inputs: Mapping[str, FloatArray], ticks: int, moving: npt.NDArray[np.bool_], alone: Collection[int]
    ) -> dict[int, str]:
        """Advance the chains that move; return the messages of those that refuse, which stay where they were.

        Args:
            inputs: name -> value for each chain.
            ticks: to advance.
            moving: which chains move.
            alone: chains that step by themselves, because somebody observes them or their inputs follow a profile.
        """
        before, together, errors = self._inputs.copy(), moving.copy(), dict[int, str]()
        together[[*alone]] = False
        for name, values in inputs.items():
            self._inputs[:, _SIDES[name.partition("_")[0]]] = values
        self._inputs[~moving] = before[~moving]
        wanted = together.copy()
        _advance_chains(
            self._address, self.tables, _NO_DRIVE, self._inputs, self._ticks, ticks, together, self._kept, self._first_row
        )
        # The kernel also returns where a chain has something to warn of: then the chain itself can take the step.
        for k in [*np.flatnonzero(wanted & ~together).tolist(), *(k for k in alone if moving[k])]:
            self._inputs[k] = before[k]
            self.synchronise(k)
            chain = self.components[k]
            try:
                chain.step(ticks * chain.step_size, **{name: float(values[k]) for name, values in inputs.items()})
            except StepError as error:
                errors[k] = str(error)
            self.refresh([k])
        return errors
