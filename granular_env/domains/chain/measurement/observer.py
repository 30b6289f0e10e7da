"""Records the `History` of a running chain; observing does not change the motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from granular_env.components.component import Component
from granular_env.components.errors import ParameterError
from granular_env.components.inputs import Held
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.memory_limits import refuse_excess_memory
from granular_env.components.support.validation import positive_number

from .chain_history import History
from .history_sources import chain_geometry, make_history


class Watch:
    """An observer that stores the motion of a chain at even intervals.

        watch = Watch(every=1e-6)
        ge.run("nesterenko-1983/3.4-piston", observers=[watch])      # or chain.observe(watch), then step
        watch.history

    A reset or a restore starts a new history.
    """

    next_tick: int

    def __init__(self, every: float) -> None:
        """Set the sampling interval.

        Args:
            every: time between two frames, a whole number of the chain's internal steps [s].

        Raises:
            ParameterError: `every` is not positive; later, at the first reset: not a chain, or not a whole number of steps.
        """
        self._every = positive_number("every", every)
        self._component: Component | None = None
        self._variables: tuple[str, ...] = ()
        self.next_tick = 0
        self._clear_frames()

    def _clear_frames(self) -> None:
        self._ticks: list[int] = []
        self._frames: list[tuple[FloatArray, ...]] = []

    @property
    def variables(self) -> tuple[str, ...]:
        """Return the names of the stored variables; empty before the first reset."""
        return self._variables

    @property
    def history(self) -> History:
        """Return the history so far, as a copy."""
        if self._component is None:
            raise ParameterError("it has not observed a chain yet", hint="attach it with chain.observe(watch)", at="watch")
        time = np.array(self._ticks) * self._component.step_size
        frames = {name: np.array([frame[i] for frame in self._frames]) for i, name in enumerate(self._variables)}
        return make_history(self._component, time, **frames)

    def on_reset(self, component: Component) -> None:
        """Start a new history."""
        chain_geometry(component)
        self._variables = history_variables(component)
        self._interval = component.duration_ticks(self._every, "every")
        self._component = component
        self._clear_frames()
        self.on_sample(component)

    def on_sample(self, component: Component) -> None:
        """Store a frame."""
        self._ticks.append(component.tick)
        self._frames.append(tuple(component.get(name) for name in self._variables))
        self.next_tick = component.tick + self._interval

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Do nothing: only frames are stored."""

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Drop the frames of a failed step."""
        while self._ticks and self._ticks[-1] > component.tick:
            self._ticks.pop()
            self._frames.pop()
        self.next_tick = self._ticks[-1] + self._interval


def history_variables(chain: Component) -> tuple[str, ...]:
    """Return the names of the variables that have to be stored for a history of this chain."""
    parameters: Any = chain.parameters
    # The forces of contacts with memory cannot be computed from the overlaps of single frames.
    return ("velocity", "displacement", *(["contact_force"] if parameters.law.has_history else []))


def observe(chain: Component, duration: float, every: float, **inputs: Any) -> History:
    """Advance a chain from its present state, and return its motion.

    Args:
        chain: the chain; afterwards its state is that after ``chain.step(duration, **inputs)``.
        duration: a whole number of internal steps [s].
        every: time between two frames, a whole number of internal steps [s].
        **inputs: inputs of the step (numbers or profiles).

    Raises:
        ParameterError: not a chain, a time that is not a whole number of steps, an invalid input, or too many frames.
        StepError: the physics would break down; the chain is unchanged.
    """
    watch = Watch(every)
    chain_geometry(chain)
    numbers = sum(np.size(chain.get(name)) for name in history_variables(chain))
    frames = chain.duration_ticks(duration, "duration") // chain.duration_ticks(every, "every") + 1
    refuse_excess_memory(8 * numbers * frames, f"every: {frames:.6g} frames of {numbers} numbers, from duration / every,")
    watch.on_reset(chain)  # raises before the chain stores the observer
    chain.observe(watch)
    try:
        chain.step(duration, **inputs)
    finally:
        chain.ignore(watch)
    return watch.history
