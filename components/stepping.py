"""Stepping of components: integer ticks, held inputs, division of long steps, and observers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from time import perf_counter
from typing import Any, ClassVar, Protocol

from .contract import Physics
from .errors import GranularError, Location, ParameterError, one_line, spelling_hint
from .inputs import Held, hold_input
from .profiles import CompiledProfile
from .state_block import Block
from .support.validation import Parameters, finite_number
from .variables import Variable

# A long step is advanced in pieces of about this wall time, between which Ctrl-C and observers are served [s].
_PIECE_SECONDS = 0.05


class Observer(Protocol):
    """Observer of a component during steps (a recorder, a viewer, a progress bar), which it does not change."""

    next_tick: int
    """The next tick at which `on_sample` is called; a longer step is interrupted there without effect on the results."""

    def on_reset(self, component: Any) -> None:
        """Start a new history after a reset or a restore."""

    def on_sample(self, component: Any) -> None:
        """Observe the component at `next_tick`, perhaps inside a step; set `next_tick` to a later tick."""

    def on_step(self, component: Any, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Observe a complete step with its compiled inputs. The step remains valid even if this method raises."""

    def on_failure(self, component: Any, error: BaseException) -> None:
        """Observe a failed or interrupted step; the state from before the step has been restored."""


class Stepping(Physics):
    """The stepping of a component: `step` and its helpers."""

    name: ClassVar[str]
    """Name of the component in `catalogue`."""
    Parameters: ClassVar[type[Parameters]]

    # The following attributes exist after the component has been built.
    _block: Block
    _inputs: dict[str, Variable]
    _bounds: dict[str, tuple[float, float]]
    _tick_counts: dict[float | None, int]
    _tick: int
    # This mapping is replaced, never changed in place, because snapshots share it.
    _held: Mapping[str, Held]
    _profiled: bool

    def _initialise_stepping(self) -> None:
        """Set the attributes of this instance that stepping needs."""
        self._observers: list[Observer] = []
        # The component that contains this one as a part; only the owner steps, resets and restores it.
        self._owner: Stepping | None = None
        # True in the middle of a step or a reset.
        self._busy = False
        self._chunk_ticks = 256
        self._held, self._profiled = {}, False
        self._tick = 0

    @property
    def tick(self) -> int:
        """Integer time: the number of internal steps since the reset."""
        return self._tick

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._tick * self.step_size

    def step(self, duration: float | None = None, **inputs: Any) -> None:
        """Advance by exactly `duration` [s] (default: one internal step) with the inputs held.

        Any exception, including Ctrl-C, restores the state from before the call: each call makes one copy of the state, which
        costs one-tick calls of very large bodies about a fifth of their time.

        Args:
            duration: a whole number of internal steps.
            **inputs: numbers, arrays of the input's shape, or profiles of time; each keeps its value until it is set again.

        Raises:
            ParameterError: an input or the duration is not valid.
            StepError: the physics would break down.
            GranularError: memory ran out, or another thread or an observer steps the component during its step.
        """
        # Hot path of step-wise control: usual values are looked up, other values go through a slower function.
        # `own` bypasses `__setattr__`, which would take a third of a short step.
        own: dict[str, Any] = self.__dict__  # type: ignore[assignment] - pyright finds that of the class
        try:
            ticks = self._tick_counts[duration]
        except (KeyError, TypeError):
            ticks = self._cached_ticks(duration)
        if self._busy or self._owner is not None:
            self._refuse_busy_call("step")
        own["_busy"] = True
        try:
            held, before, numbers = self._held, self._tick, not self._profiled
            if inputs:
                bounds = self._bounds
                for name, value in inputs.items():
                    if value.__class__ is float and name in bounds:
                        low, high = bounds[name]
                        if low <= value <= high:
                            continue
                    inputs, numbers = self.checked_inputs(inputs), False
                    break
            observers = self._observers
            self._block.back_up()
            try:
                if inputs:
                    if numbers:
                        own["_held"] = inputs if len(inputs) == len(held) else {**held, **inputs}
                    else:
                        self._hold_inputs({**held, **inputs})
                if ticks > self._chunk_ticks or (observers and self._has_sample_until(before + ticks)):
                    self._advance_in_pieces(ticks)
                else:
                    status = self._advance_state(ticks)
                    if status:
                        raise self._step_error(status)
                    own["_tick"] = before + ticks
            except BaseException as error:
                self._undo_step(before, held, error)
                raise
            for observer in observers:
                observer.on_step(self, ticks, inputs)
        finally:
            own["_busy"] = False

    def _undo_step(self, tick: int, held_inputs: Mapping[str, Held], error: BaseException) -> None:
        self._block.restore_backup()
        self._tick = tick
        self._hold_inputs(held_inputs)
        for observer in self._observers:
            observer.on_failure(self, error)

    def _refuse_busy_call(self, call: str) -> None:
        """Refuse a call during a step, and a call on a part by anyone but its owner."""
        if self._busy:
            raise GranularError(
                f"component {self.name!r} is in the middle of a step of another thread or an observer",
                hint="use a separate component in each thread",
                at=call,
            )
        owner = self._owner
        if owner is not None and not owner._is_stepping:
            raise GranularError(
                f"component {self.name!r} is a part of component {owner.name!r}, which owns the state of both",
                hint=f"call {call} of the whole, or of a `copy.copy` of the part",
                at=call,
            )

    @property
    def _is_stepping(self) -> bool:
        return self._busy or (self._owner is not None and self._owner._is_stepping)

    # -- observers, and pieces of a long step -----------------------------------------------------------------------

    @property
    def is_observed(self) -> bool:
        """Return whether there are observers."""
        return bool(self._observers)

    def observe(self, observer: Observer) -> None:
        """Add an observer; `ParameterError` if it is not an observer, `GranularError` for a part of another component."""
        if self._owner is not None:
            self._refuse_busy_call("observe")
        if not all(callable(getattr(observer, call, None)) for call in ("on_reset", "on_sample", "on_step", "on_failure")):
            raise ParameterError(f"got {one_line(observer)}", expected="the methods of `stepping.Observer`", at="observer")
        observer.on_reset(self)
        self._observers.append(observer)

    def ignore(self, observer: Observer) -> None:
        """Remove an observer."""
        if observer in self._observers:
            self._observers.remove(observer)

    def _has_sample_until(self, end_tick: int) -> bool:
        for observer in self._observers:  # noqa: SIM110 - `any` would take twice as long, of each step that is recorded
            if observer.next_tick <= end_tick:
                return True
        return False

    def _advance_in_pieces(self, ticks: int) -> None:
        end = self._tick + ticks
        while self._tick < end:
            stop = min(end, self._tick + self._chunk_ticks)
            for observer in self._observers:
                stop = min(stop, max(observer.next_tick, self._tick + 1))
            piece, begin = stop - self._tick, perf_counter()
            status = self._advance_state(piece)
            if status:
                raise self._step_error(status)
            self._tick = stop
            if piece == self._chunk_ticks:
                spent = perf_counter() - begin
                if spent < 0.5 * _PIECE_SECONDS:
                    self._chunk_ticks *= 2
                elif spent > 2.0 * _PIECE_SECONDS and piece > 1:
                    self._chunk_ticks //= 2
            for observer in self._observers:
                if observer.next_tick <= stop:
                    observer.on_sample(self)

    # -- a part that the kernels of its owner advance ---------------------------------------------------------------

    @property
    def has_profile_input(self) -> bool:
        """Return whether a held input is a profile of time."""
        return self._profiled

    def set_progress(self, tick: int, inputs: Mapping[str, float]) -> None:
        """Set the tick to which the owner has advanced this part, and the input numbers of its last step."""
        self._tick = tick
        if any(self._held.get(name) != value for name, value in inputs.items()):
            self._held = {**self._held, **inputs}

    # -- durations --------------------------------------------------------------------------------------------------

    def duration_ticks(self, duration: float, name: str | Location = "duration") -> int:
        """Return the number of internal steps in a duration [s]; `ParameterError` if it is not a whole number."""
        duration = finite_number(name, duration, "seconds")
        exact = duration / self.step_size
        if not math.isfinite(exact) or exact <= 0.0:
            raise ParameterError(f"got {duration!r} s", expected="more than 0 and finite", at=name)
        ticks = round(exact)
        if ticks > 2**52:
            came = f"got {duration:.12g} s, which is {exact:.3g} internal steps"
            raise ParameterError(came, expected="at most 2^52 internal steps", at=name)
        if ticks < 1 or abs(exact - ticks) > 1e-9 * ticks:
            counts = sorted({max(math.floor(exact), 1), max(math.ceil(exact), 1)})
            choices = " or ".join(f"{count * self.step_size:.12g} s" for count in counts)
            raise ParameterError(
                f"got {duration:.12g} s, which is {exact:.9g} internal steps of {self.step_size:.12g} s",
                expected="a whole number of them",
                hint=f"use {choices}, or another step_size",
                at=name,
            )
        return ticks

    def _cached_ticks(self, duration: float | None) -> int:
        ticks = self.duration_ticks(duration)  # type: ignore[arg-type]
        if len(self._tick_counts) < 1024:
            self._tick_counts[float(duration)] = ticks  # type: ignore[arg-type]
        return ticks

    # -- inputs -----------------------------------------------------------------------------------------------------

    @property
    def held_inputs(self) -> Mapping[str, Held]:
        """The inputs held now, in the form that kernels use; never changed in place."""
        return self._held

    def checked_inputs(self, inputs: Mapping[str, Any]) -> dict[str, Held]:
        """Return these inputs checked and in the form of kernels; raise `ParameterError` if one is not valid."""
        held: dict[str, Held] = {}
        for name, value in inputs.items():
            variable = self._inputs.get(name)
            if variable is None:
                where = f"component {self.name!r}"
                raise ParameterError("unknown", hint=self.input_advice(name), at=("input", name), source=where)
            held[name] = hold_input(variable, value, self.step_size)
        return held

    def _hold_inputs(self, inputs: Mapping[str, Held]) -> None:
        """Set the values of all inputs of the component for the following steps."""
        before, self._profiled = self._profiled, any(value.__class__ is CompiledProfile for value in inputs.values())
        self._held = inputs
        if before or self._profiled:
            self._prepare_inputs(inputs)

    def input_advice(self, name: str) -> str:
        """Return the hint of the error for an input that the component does not have."""
        return spelling_hint(name, self._inputs)
