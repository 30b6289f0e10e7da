"""The contract: what every component declares, and what its author writes, on one page.

    component = SomeComponent(**parameters)          # SI units; ParameterError names what is wrong
    component.reset(velocity=..., seed=...)          # start values
    component.step(1e-6, left_force=3.0)             # advance exactly so long, inputs held
    component.get("velocity")                        # any variable, a copy
    state = component.save(); component.restore(state)
    component.balances(); component.events()         # energy, momentum, ...: stored, supplied, lost; what happened when

Time is an integer tick: ``time = tick * step_size``. A step happens whole or not at all. ``step(n h)`` is bit-equal to n
times ``step(h)``, with any pause, save and restore between. Inputs keep their value until they are set again, `reset` puts
them back to their start. `component.Component` keeps these promises for every `Physics`; `oscillator.py` is the shortest
complete component.
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
    """The part of a component that its author writes; `component.Component` does the rest."""

    event_kinds: ClassVar[Mapping[str, str]] = {}
    """Kinds of events that can happen -> what they are; then the state has a list of events."""
    event_details: ClassVar[Mapping[str, EventDetail]] = {}
    """Unit of some or all of these kinds, what their indices count, and the output that says how near each is to one."""
    step_size: float
    """Length of one internal step [s]; set by `_build`."""

    @abstractmethod
    def _build(self) -> None:
        """Set `step_size`, call `_lay_out`, and compute the tables that do not change, from `self.parameters`."""

    @abstractmethod
    def _declare(self) -> Iterable[Variable]:
        """Declare inputs and outputs; parameters and the entries of balances are declared for you, if you do not."""

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        """Return how to read each output of `_declare` that is no part of the block: name -> function that returns its value.

        An array that lies in the block need not be copied: `get` does that.
        """
        return {}

    @abstractmethod
    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        """Write the start state into the (zeroed) block; return the inputs' start values that are not those declared.

        `super()._start(seed, values)` writes the values of state variables that are parts of the block.
        """

    def _apply(self, held: Mapping[str, Held]) -> None:  # noqa: B027 - most components have nothing to prepare
        """Prepare for the inputs that are held from now on, one of which is, or just was, a profile.

        Where all are numbers and arrays this is not called: `_advance` finds them in `self._held`.
        """

    @abstractmethod
    def _advance(self, ticks: int) -> int:
        """Advance the block by whole ticks from `self._tick`; 0, or a status that `_explain` turns into an error.

        It depends on the block, the tick and the inputs held alone: after a failure earlier steps are made again.
        """

    @abstractmethod
    def _explain(self, status: int) -> StepError:
        """Return the error for a status, while the failed state is still there."""

    @abstractmethod
    def balances(self) -> tuple[Balance, ...]:
        """Return what became of energy, momentum, ... since the reset: always the same entries, in the same order."""

    @classmethod
    def memory_needed(cls, parameters: Any) -> int:
        """Bytes that building and stepping take at least, from the parameters alone; 0 where they are too few to matter."""
        return 0

    def report(self) -> dict[str, float]:
        """Figures that say how far the model's own assumptions held, name with unit -> value."""
        return {}

    def drawables(self) -> tuple[Drawable, ...]:
        """Return what viewers can draw; what comes first matters most."""
        return ()

    def nearest_kind(self, ratio: str, index: int) -> str:
        """Return the kind of event that is near at an index, of those that an output decides; "" where it is not known.

        Args:
            ratio: name of the output, the `EventDetail.ratio` of several kinds.
            index: of the link, cell, ...
        """
        return ""

    def has_limit(self, ratio: str, index: int) -> bool:
        """Return whether there is a limit at an index that could be passed, unlike in a cell that cannot yield.

        Args:
            ratio: name of the output that says how near it is, the `EventDetail.ratio` of kinds of events.
            index: of the link, cell, ...
        """
        return True

    def conclusions(self) -> list[str]:
        """Return sentences on what has become of the system, such as whether it broke, where, and why or why not."""
        return []

    def cautions(self) -> list[str]:
        """Sentences for every assumption that the run so far has left behind."""
        return []
