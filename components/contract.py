"""The contract: what every component declares, and what its author writes, on one page.

    component = SomeComponent(**parameters)          # SI units; ParameterError names what is wrong
    component.reset(velocity=..., seed=...)          # start values
    component.step(1e-6, left_force=3.0)             # advance exactly so long, inputs held
    component.get("velocity")                        # any variable, a copy
    state = component.save(); component.restore(state)
    component.ledger()                               # energy and momentum: in, stored, lost, left over

Time is an integer tick: ``time = tick * step_size``. A step happens whole or not at all. ``step(n h)`` is bit-equal to n
times ``step(h)``, with any pause, save and restore between. Inputs keep their value until they are set again, `reset` puts
them back to their start. `component.Component` keeps these promises for every `Physics`; `oscillator.py` is the shortest
complete component.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, Protocol

from .errors import StepError
from .inputs import Held
from .snapshot import FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Variable:
    """One named quantity of a component: everything that a file, a space, a schema or a page needs to know of it."""

    name: str
    causality: Literal["parameter", "input", "output"]
    unit: str
    shape: tuple[int, ...]
    description: str
    dtype: str = "float64"
    start: Any = None
    minimum: float = -math.inf
    maximum: float = math.inf
    state: bool = False
    """Whether it is part of the state: it can be given to `reset`, and logs hash it."""
    axes: tuple[str, ...] = ()
    """What each index of its shape counts, such as ("grain",): variables with the same axis share it in a data set."""


@dataclasses.dataclass(frozen=True, slots=True)
class Ledger:
    """Energy [J] and momentum [kg m/s] of a component since its reset, and what the numerics left over."""

    kinetic_energy: float
    potential_energy: float
    dissipated_energy: float
    fracture_energy: float
    input_work: float
    energy_residual: float
    momentum: float
    impulse: float
    momentum_residual: float


@dataclasses.dataclass(frozen=True, slots=True)
class Particles:
    """What a viewer can draw of a component: spheres, how they move and what colours them.

    Attributes:
        reference: positions before anything moves, shape (n, 3) [m].
        radius: shape (n,) [m].
        displacement: name of the output that holds each particle's displacement, shape (n,) along x or (n, 3) [m].
        colour: name of the output whose value colours each particle, shape (n,).
    """

    reference: FloatArray
    radius: FloatArray
    displacement: str
    colour: str


class Observer(Protocol):
    """Looks at a component while it steps (a recorder, a viewer, a progress bar); never changes it."""

    next_tick: int
    """The next tick at which `look` wants to be called; a step that goes past is cut there, invisibly."""

    def began(self, component: Any) -> None:
        """After a reset or a restore: a new history starts here."""

    def look(self, component: Any) -> None:
        """At `next_tick`, perhaps inside a step; sets `next_tick` anew."""

    def stepped(self, component: Any, ticks: int, inputs: Mapping[str, Held]) -> None:
        """After a whole step, with the inputs that were set by it (compiled).

        What is raised here reaches the caller once all observers have been told; the step stands.
        """

    def failed(self, component: Any, error: BaseException) -> None:
        """After a step that failed or was interrupted: the component is back where that step began."""


class Physics(metaclass=ABCMeta):
    """What the author of a component writes; `component.Component` does the rest."""

    step_size: float
    """Length of one internal step [s]; set by `_build`."""

    @abstractmethod
    def _build(self) -> None:
        """From `self.parameters`: set `step_size` and `_block`, compute the tables that do not change."""

    @abstractmethod
    def _declare(self) -> Iterable[Variable]:
        """Inputs and outputs (parameters and the ledger's entries are declared by this class)."""

    @abstractmethod
    def _outputs(self) -> dict[str, Callable[[], Any]]:
        """How to read each output of `_declare`: name -> function that returns a number or an array.

        The array may lie in the block: `get` copies such a one.
        """

    @abstractmethod
    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, float]:
        """Write the start state into the (zeroed) block; return the inputs' start values that are not 0."""

    def _apply(self, held: Mapping[str, Held]) -> None:  # noqa: B027 - most components have nothing to prepare
        """Prepare for the inputs that are held from now on, one of which is, or just was, a profile.

        Where all are numbers this is not called: `_advance` finds them in `self._held`.
        """

    @abstractmethod
    def _advance(self, ticks: int) -> int:
        """Advance the block by whole ticks from `self._tick`; 0, or a status that `_explain` turns into an error."""

    @abstractmethod
    def _explain(self, status: int) -> StepError:
        """The error for a status, while the failed state is still there."""

    @abstractmethod
    def ledger(self) -> Ledger:
        """Energy and momentum: in, stored, lost, and what is left over."""

    @classmethod
    def memory_needed(cls, parameters: Any) -> int:
        """Bytes that building and stepping take at least, from the parameters alone; 0 where they are too few to matter."""
        return 0

    def report(self) -> dict[str, float]:
        """Figures that say how far the model's own assumptions held, name with unit -> value."""
        return {}

    def particles(self) -> Particles | None:
        """What a viewer can draw; None where there is nothing."""
        return None

    def cautions(self) -> list[str]:
        """Sentences for every assumption that the run so far has left behind."""
        return []
