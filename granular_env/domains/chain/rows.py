"""A native batch of chains: their states (tables) are rows of one array, and a single compiled call advances all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain import differentiable_quantities as quantities
from granular_env.components.chain.layout import TALLY, WORK_LEFT, WORK_RIGHT, U, V
from granular_env.components.chain.state import chain_state
from granular_env.components.errors import ParameterError, StepError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit

_SIDES = {"left": 0, "right": 1}


@jit
def _contact_forces(law, tables, first, out):
    for k in range(out.shape[0]):
        chain = chain_state(law, tables[k])
        for j in range(out.shape[1]):
            out[k, j] = quantities.contact_force(chain, first + j)


@jit
def _energies_between(law, tables, first, last, out):
    for k in range(len(out)):
        out[k, 0] = quantities.excess_energy(chain_state(law, tables[k]), first, last)


class ChainRows:
    """Many chains, or one, as rows of arrays, for tasks that judge many episodes at once (`RowTask`).

    For a single chain (`is_batch` false) the axis "chains" is missing in all shapes except that of `tables`.

    Args:
        chains: chains of equal size, law and integrator.
        is_batch: whether to copy the chains into one array; otherwise there must be one chain, which keeps its own memory.

    Attributes:
        components: the chains.
        tables: their tables (state and constants, see `layout`), shape (chains, rows, width).
        displacement: displacements of the grains, shape (chains, grains) [m]; a read-only view.
        velocity: velocities of the grains, shape (chains, grains) [m/s]; a read-only view.
    """

    def __init__(self, chains: Sequence[Chain], is_batch: bool = False) -> None:
        first, count = chains[0], len(chains)
        self.tables: FloatArray = np.zeros((count, *first.table.shape)) if is_batch else first.table[None]
        self.components: list[Chain] = [*chains]
        self.grains = first.parameters.grains
        self._chosen: Any = slice(None) if is_batch else 0
        self.displacement, self.velocity = (self.tables[self._chosen, row, 1 : self.grains + 1] for row in (U, V))
        self.displacement.flags.writeable = self.velocity.flags.writeable = False
        self._names = [
            (side, f"{side}_{name}") for side in _SIDES for name in ("force", "velocity") if f"{side}_{name}" in first.variables
        ]
        self._ticks, self._inputs = np.zeros(count, np.int64), np.zeros((count, 2))
        self._together, self._law = is_batch, first.state.law
        if is_batch:
            rows = first.state_rows
            for k, chain in enumerate(chains):
                self.replace_chain(k, chain)
                self.update_batch(k)
            self._kept, self._first_row = np.zeros((rows.stop - rows.start, self.tables.shape[2])), rows.start

    @property
    def input_work(self) -> FloatArray:
        """Return the work done by inputs and boundaries since the reset, shape (chains,) [J]."""
        tables, k, behind = self.tables, self._chosen, self.grains + 2
        return tables[k, TALLY, WORK_LEFT] + tables[k, TALLY, WORK_RIGHT] + tables[k, V, behind] + tables[k, V, behind + 1]

    @property
    def contact_force(self) -> FloatArray:
        """Return the compressive force in each contact, shape (chains, grains + 1) [N]."""
        return self.call_kernel(_contact_forces, self.grains + 1, 0)

    @property
    def right_wall_force(self) -> FloatArray:
        """Return the force of the right wall on the chain, shape (chains,), positive to the right [N]."""
        if not self._together:
            return self.components[0].get("right_wall_force")
        return 0.0 - self.call_kernel(_contact_forces, 1, self.grains)[:, 0]

    def tail_energy(self, grain: int) -> FloatArray:
        """Return the energy above the rest state of grains `grain` to the last and their contacts, shape (chains,) [J]."""
        return self.call_kernel(_energies_between, 1, grain + 1, self.grains)[..., 0]

    def call_kernel(self, kernel: Callable[..., Any], size: int, *arguments: Any) -> FloatArray:
        """Return the `size` numbers that a jitted function computes for each chain, shape (chains, size).

        The function is called as kernel(law, tables, *arguments, output); ``chain_state(law, tables[k])`` gives chain k.
        Integer arguments are common to all chains; all other arguments have one row per chain.
        """
        if not self._together:
            arguments = tuple(one if isinstance(one, int) else np.asarray(one, dtype=np.float64)[None] for one in arguments)
        found = np.empty((len(self.tables), size))
        kernel(self._law, self.tables, *arguments, found)
        return found[self._chosen]

    @property
    def time(self) -> FloatArray:
        """Return the time since each chain's reset, shape (chains,) [s]."""
        return np.asarray(self._ticks * self.components[0].step_size, dtype=np.float64)

    def read_output(self, name: str) -> FloatArray:
        """Return an output of all chains of a batch, with a leading axis for the chains."""
        if name in ("displacement", "velocity", "contact_force", "right_wall_force", "input_work"):
            return getattr(self, name)
        for k in range(len(self.components)):
            self.update_chain(k)
        return np.array([chain.get(name) for chain in self.components], dtype=np.float64)

    def replace_chain(self, k: int, chain: Chain) -> Chain:
        """Replace chain k by a copy of `chain` in the memory of the batch, and return the copy."""
        self.components[k] = chain.clone(self.tables[k])
        self.components[k].restore(chain.save())
        return self.components[k]

    def update_batch(self, k: int) -> None:
        """Copy time and inputs of chain k to the batch, after the chain was stepped outside the batch.

        Raises:
            ParameterError: an input follows a profile, or the chain is recorded (the batch steps without the recorder).
        """
        chain = self.components[k]
        if chain.is_observed:
            raise ParameterError(
                "a component of the batch is being recorded", hint="restore its state in a single environment", at="record"
            )
        if chain.has_profile_input:
            raise ParameterError("an input follows a profile", hint="continue in a single environment", at="state")
        self._ticks[k] = chain.tick
        for side, name in self._names:
            self._inputs[k, _SIDES[side]] = chain.peek(name)

    def update_chain(self, k: int) -> None:
        """Copy the batch's time and held inputs of chain k to the chain."""
        held = {name: float(self._inputs[k, _SIDES[side]]) for side, name in self._names}
        self.components[k].set_progress(int(self._ticks[k]), held)

    def advance_chains(self, inputs: Mapping[str, FloatArray], ticks: int, moving: npt.NDArray[np.bool_]) -> dict[int, str]:
        """Advance the chains `moving`, with `inputs` name -> values; return errors of those that failed, left unchanged."""
        before, done, errors = self._inputs.copy(), moving.copy(), dict[int, str]()
        for name, values in inputs.items():
            np.copyto(self._inputs[:, _SIDES[name.partition("_")[0]]], values, where=moving)
        first = self.components[0]
        first.entries.advance_batch(self.tables, self._inputs, self._ticks, ticks, done, self._kept, self._first_row)
        # The kernel also leaves out a chain that would issue a warning; that chain then takes the step outside the batch.
        for k in np.flatnonzero(moving & ~done).tolist():
            self._inputs[k] = before[k]
            self.update_chain(k)
            chain = self.components[k]
            try:
                chain.step(ticks * chain.step_size, **{name: float(values[k]) for name, values in inputs.items()})
            except StepError as error:
                errors[k] = str(error)
            self.update_batch(k)
        return errors
