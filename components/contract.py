"""The contract of components: the declarations and methods that the author of a component writes.

    component = SomeComponent(**parameters)          # SI units; ParameterError names the faults
    component.reset(velocity=..., seed=...)          # start values
    component.step(1e-6, left_force=3.0)             # advance by exactly this time, inputs held
    component.get("velocity")                        # any variable, a copy
    state = component.save(); component.restore(state)
    component.balances(); component.events()         # energy, momentum, ...: stored, supplied, lost; what happened when

Time is an integer tick: ``time = tick * step_size``. A call of `step` completes, or restores the state from before the call.
``step(n h)`` is bitwise equal to n times ``step(h)``, with any pause, save and restore in between. Inputs keep their values
until they are set again; `reset` restores their start values. Everything can be read at any time; `step`, `reset` and `restore`
are refused in the middle of a step. `component.Component` keeps these promises for every `Physics`; `oscillator.py` is the
shortest complete component.
"""

from __future__ import annotations

from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

from .balances import Balance
from .drawables import Drawable
from .errors import StepError
from .events import EventDetail
from .inputs import Held
from .support.float_arrays import FloatArray
from .variables import Variable


class Physics(metaclass=ABCMeta):
    """The part of a component that its author writes; `component.Component` provides the rest."""

    event_kinds: ClassVar[Mapping[str, str]] = {}
    """Kinds of possible events -> description; the state then has a list of events."""
    event_details: ClassVar[Mapping[str, EventDetail]] = {}
    """Kind of event -> unit, what its index counts, and the output with the distance from its limit; optional for each kind."""
    step_size: float
    """Length of one internal step [s]; set by `_build_system`."""

    @abstractmethod
    def _build_system(self) -> None:
        """Set `step_size`, call `_define_state`, and compute constant tables, from `self.parameters`."""

    @abstractmethod
    def _declare_variables(self) -> Iterable[Variable]:
        """Declare inputs and outputs; parameters and balance entries are declared automatically."""

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        """Return the readers of outputs that are not arrays of the block: name -> function that returns the value.

        Arrays of the block need not be copied, because `get` copies them.
        """
        return {}

    @abstractmethod
    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        """Write the start state into the zeroed block; return the start values of inputs that differ from the declared ones.

        `super()._write_start_state(seed, values)` writes the values of state variables that are arrays of the block.
        """

    def _prepare_inputs(self, held: Mapping[str, Held]) -> None:  # noqa: B027 - most components have nothing to prepare
        """Compute what steps need of the inputs; called when the held inputs change and one is or was a profile of time.

        It is not called for numbers and arrays: `_advance_state` reads them from `self._held`.
        """

    @abstractmethod
    def _advance_state(self, ticks: int) -> int:
        """Advance the block by whole ticks from `self._tick`; return 0, or a status that `_step_error` turns into an error.

        The result depends only on the block, the tick and the held inputs.
        """

    @abstractmethod
    def _step_error(self, status: int) -> StepError:
        """Return the error that a status of `_advance_state` means; the state at the failure can still be read."""

    @abstractmethod
    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy, momentum, ... since the reset: always the same entries in the same order."""

    @classmethod
    def memory_needed(cls, parameters: Any) -> int:
        """Return a lower bound of the memory for building and stepping [bytes], from the parameters alone; 0 if negligible."""
        return 0

    def report(self) -> dict[str, float]:
        """Return numbers that show whether the model's assumptions hold in this run: name with unit -> value."""
        return {}

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the drawables for viewers, the most important first."""
        return ()

    def nearest_kind(self, ratio: str, index: int) -> str:
        """Return the kind of event that is closest to its limit at an index, of the kinds that share `ratio`; "" if unknown.

        Args:
            ratio: name of the output with the decisive quantity over its limit (`EventDetail.ratio`), shared by several kinds.
            index: of the link, cell, ...
        """
        return ""

    def has_limit(self, ratio: str, index: int) -> bool:
        """Return whether an element can have events of the kinds with this `ratio`; a cell that cannot yield has no limit.

        Args:
            ratio: name of the output with the decisive quantity over its limit (`EventDetail.ratio`).
            index: of the link, cell, ...
        """
        return True

    def conclusions(self) -> list[str]:
        """Return sentences on the outcome of the run, such as whether the body broke, where, and why or why not."""
        return []

    def cautions(self) -> list[str]:
        """Return a sentence for every assumption of the model that the run has violated so far."""
        return []
