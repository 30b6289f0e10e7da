"""Steps: integer ticks, pieces of a long step, what undoes a step that fails, and observers that look on."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from time import perf_counter
from typing import Any, ClassVar, Protocol

from .contract import Physics
from .errors import GranularError, Location, ParameterError, StepError, caution, nearest, one_line
from .inputs import Held, hold_input
from .profiles import CompiledProfile
from .state_block import Block
from .support.float_arrays import FloatArray
from .support.round_numbers import round_down_to_125
from .support.validation import Parameters, finite_number
from .undo import Undo
from .variables import Variable

# A long step is cut, invisibly, into pieces of about this wall time, so that Ctrl-C and observers get their turn [s].
_CHUNK_SECONDS = 0.05
# A step of so many ticks that has lasted so long, and has so long to go, is told of: a slip in a duration takes hours [s].
_MANY_TICKS = 1_000_000
_SILENT_SECONDS, _LONG_SECONDS = 5.0, 60.0

# How often the state before a failed step is put back anew where that is interrupted.
_ATTEMPTS = 100
# So often in a row at the same tick a fault is one that lasts.
_REPEATS = 3

# Which calls are legal when. "ready": made, reset, restored or stepped; "stepping": in the middle of a step, where an observer
# (or another thread) calls; "failed": the last step raised, and the state is that before it.
LIFE_CYCLE: Mapping[str, frozenset[str]] = {
    "step": frozenset({"ready", "failed"}),
    "reset": frozenset({"ready", "failed"}),
    "restore": frozenset({"ready", "failed"}),
    **dict.fromkeys(
        ("get", "peek", "save", "balances", "events", "drawables", "report", "conclusions", "cautions", "observe", "ignore"),
        frozenset({"ready", "stepping", "failed"}),
    ),
}


class Observer(Protocol):
    """Looks at a component while it steps (a recorder, a viewer, a progress bar); never changes it."""

    next_tick: int
    """The next tick at which `on_sample` wants to be called; a step that goes past is cut there, invisibly."""

    def on_reset(self, component: Any) -> None:
        """After a reset or a restore: a new history starts here."""

    def on_sample(self, component: Any) -> None:
        """At `next_tick`, perhaps inside a step; sets `next_tick` anew."""

    def on_step(self, component: Any, ticks: int, inputs: Mapping[str, Held]) -> None:
        """After a whole step, with the inputs that were set by it (compiled).

        What is raised here, an interrupt too, reaches the caller once all observers have been told; the step stands. Whoever
        raises it is told once more, as it may have been cut short: `component.tick` says whether it has that step.
        """

    def on_failure(self, component: Any, error: BaseException) -> None:
        """After a step that failed or was interrupted: the component is back where that step began."""


class Stepping(Physics):
    """The stepping of a component: `step`, and what it needs."""

    name: ClassVar[str]
    """Catalogue name."""
    Parameters: ClassVar[type[Parameters]]

    # That of a parent, where one owns the state.
    _given_memory: FloatArray | None
    # The component that this one is a part of: nobody else may change the state.
    _owner: Stepping | None = None
    # Whether the start state is being written, or the memory advanced for whoever owns it.
    _at_work: bool = False
    # Set once the component has been built.
    _block: Block
    _inputs: dict[str, Variable]
    _bounds: dict[str, tuple[float, float]]
    _tick_counts: dict[float | None, int]
    _tick: int
    # Replaced, never changed in place: snapshots share it.
    _held: Mapping[str, Held]

    def _prepare_steps(self) -> None:
        """Make what belongs to this one component alone, whose block is there."""
        self._observers: list[Observer] = []
        self._step_start = 0
        # Two threads at once would mix two steps into one.
        self._stepping = False
        # The tick at which the last step failed, until something else succeeds.
        self._failure = -1
        self._chunk_ticks = 256
        takes_arrays = any(variable.shape for variable in self._inputs.values())
        self._undo = Undo(self._block, is_shared=self._given_memory is not None, counts_arrays=takes_arrays)
        self._held = {}
        # Whether any of them is a profile.
        self._profiled = False
        self._tick = 0

    def _belong_to(self, owner: Stepping) -> None:
        """Let nobody but this component, which includes it, step, reset or restore it."""
        self._owner = owner
        self._undo.is_small = False  # where the undo prepares for a step it is asked who makes it

    @property
    def tick(self) -> int:
        """Integer time."""
        return self._tick

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._tick * self.step_size

    def step(self, duration: float | None = None, **inputs: Any) -> None:
        """Advance by exactly `duration` [s] (default: one internal step) with the inputs held.

        Args:
            duration: a whole number of internal steps.
            **inputs: numbers, arrays of the input's shape, or profiles of time; each keeps its value until it is set again.

        Raises:
            ParameterError: an input or the duration is not valid; nothing has changed.
            StepError: the physics would break down; the state is that from before the step.
            GranularError: memory ran out, and the state is that from before the step too; or another thread, or an observer,
                steps it while it steps.
        """
        # This is the hot path of step-wise control: what is usual is looked up, everything else goes to a slower function.
        # `own` goes past `__setattr__`, which would cost a third of a short step.
        own: dict[str, Any] = self.__dict__  # type: ignore[assignment] - pyright finds that of the class
        try:
            ticks = self._tick_counts[duration]
        except (KeyError, TypeError):
            ticks = self._whole_ticks(duration)
        if self._stepping:
            self._refuse_while_stepping("step")
        own["_stepping"] = True
        try:
            held, before, numbers = self._held, self._tick, not self._profiled
            if inputs:
                bounds = self._bounds
                for name, value in inputs.items():
                    if value.__class__ is float and name in bounds:
                        low, high = bounds[name]
                        if low <= value <= high:
                            continue
                    inputs, numbers = self.hold(inputs), False
                    break
            observers, untold = self._observers, None
            if ticks > self._chunk_ticks or (observers and self._is_looked_at(before + ticks)):
                self._long_step(ticks, inputs)
                return
            undo = self._undo
            if undo.is_small:
                undo.buffer[:] = undo.memory
            elif undo.until != before or len(undo.steps) >= undo.limit:  # always, of a part
                self._refuse_beside_owner("step")
                undo.prepare(before)
            try:
                if inputs:
                    if numbers:
                        own["_held"] = inputs if len(inputs) == len(held) else {**held, **inputs}
                    else:
                        self._hold({**held, **inputs})
                status = self._advance(ticks)
                if status:
                    raise self._explain(status)
                own["_tick"] = before + ticks
                if observers:
                    untold = observers[::-1]
                    self._tell(untold, ticks, inputs)
            except BaseException as error:  # Ctrl-C too
                self._end_cut_step(before, held, untold, ticks, inputs, error)
                raise
            if undo.is_small:
                return
            if undo.counts_arrays:
                undo.note(ticks, self._held)
            else:  # as `note` does
                undo.steps.append((ticks, self._held))
                undo.until = before + ticks
        finally:
            own["_stepping"] = False

    @property
    def phase(self) -> str:
        """Return "ready", "stepping" or "failed"; `LIFE_CYCLE` says which calls are legal then."""
        if self._stepping:
            return "stepping"
        return "failed" if self._failure == self._tick else "ready"

    def _refuse_while_stepping(self, call: str) -> None:
        if self._stepping:
            raise GranularError(
                f"component {self.name!r} is in the middle of a step, of another thread or of an observer",
                hint="give each thread a component of its own",
                at=call,
            )

    def _refuse_beside_owner(self, call: str) -> None:
        """Refuse what would change the state of the whole that this is a part of, of which the whole would know nothing."""
        owner = self._owner
        if owner is not None and not owner._is_under_way:
            raise GranularError(
                f"component {self.name!r} is a part of component {owner.name!r}, which holds the state of both",
                hint=f"{call} the whole, or a `copy.copy` of the part",
                at=call,
            )

    @property
    def _is_under_way(self) -> bool:
        """Return whether it steps or starts, by itself or for the component that it is a part of."""
        return self._stepping or self._at_work or (self._owner is not None and self._owner._is_under_way)

    @property
    def step_start(self) -> int:
        """The tick at which the step under way began, for an observer that looks in the middle of it."""
        return self._step_start

    @property
    def is_observed(self) -> bool:
        """Return whether somebody looks on."""
        return bool(self._observers)

    @property
    def follows_profile(self) -> bool:
        """Return whether an input that is held is a profile of time."""
        return self._profiled

    def observe(self, observer: Observer) -> None:
        """Let an observer look on from now; `ParameterError` where it is none."""
        if not all(callable(getattr(observer, call, None)) for call in ("on_reset", "on_sample", "on_step", "on_failure")):
            raise ParameterError(f"got {one_line(observer)}", expected="what `observer.Observer` describes", at="observer")
        observer.on_reset(self)
        self._observers.append(observer)

    def ignore(self, observer: Observer) -> None:
        """Stop an observer's looking on."""
        if observer in self._observers:
            self._observers.remove(observer)

    def _tell_of_reset(self) -> None:
        for observer in self._observers:
            observer.on_reset(self)

    def _tell_of_reset_once_more(self) -> None:
        """Tell it again while an error is under way, perhaps an interrupt, which came after the state may have changed."""
        _call_all([observer.on_reset for observer in self._observers], self)

    # -- a part of a parent, whose kernels advance it ------------------------------------------------------------------

    def begin(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        """Write the start state into the memory, which the parent has cleared; return start values of inputs that follow.

        `reset` does more: it checks the values, and puts the tick and the inputs back.
        """
        self._at_work = True
        try:
            return self._start(seed, values)
        finally:
            self._at_work = False

    def adopt(self, tick: int, inputs: Mapping[str, float]) -> None:
        """Take over that whoever owns the memory has advanced it, to this tick and with these numbers held last."""
        self._tick = tick
        if any(self._held.get(name) != value for name, value in inputs.items()):
            self._held = {**self._held, **inputs}

    def adopt_inputs(self, held: Mapping[str, Held]) -> None:
        """Hold from now on what `hold` gave, of the part or of the parent: all inputs of the part, by its own names."""
        self._hold(held)

    def advance(self, ticks: int) -> int:
        """Advance the memory by whole ticks, from the tick and with the inputs adopted last; 0, or a status for `explain`."""
        self._at_work = True
        try:
            return self._advance(ticks)
        finally:
            self._at_work = False

    def explain(self, status: int) -> StepError:
        """Return the error for a status of the part's kernels, while the failed state is still there."""
        return self._explain(status)

    # -- durations --------------------------------------------------------------------------------------------------

    def ticks_in(self, duration: float, name: str | Location = "duration") -> int:
        """Return the whole number of internal steps in a duration [s]; `ParameterError` where it is none."""
        duration = finite_number(name, duration, "seconds")
        exact = duration / self.step_size
        if not math.isfinite(exact) or exact <= 0.0:
            raise ParameterError(f"got {duration!r} s", expected="more than 0 and finite", at=name)
        ticks = round(exact)
        if ticks < 1 or abs(exact - ticks) > 1e-9 * ticks or ticks > 2**52:
            if ticks > 2**52:
                came = f"got {duration:.12g} s, which is {exact:.3g} internal steps"
                raise ParameterError(came, expected="at most 2^52 of them", at=name)
            steps = sorted({max(math.floor(exact), 1), max(math.ceil(exact), 1)})
            choices = " or ".join(f"{count * self.step_size:.12g} s" for count in steps)
            raise ParameterError(
                f"got {duration:.12g} s, which is {exact:.9g} internal steps of {self.step_size:.12g} s",
                expected="a whole number of them",
                hint=f"use {choices}, or {self._fitting_step(duration)}",
                at=name,
            )
        return ticks

    def _fitting_step(self, duration: float) -> str:
        """Advice on a step_size of which a duration is a whole number: 1, 2 or 5 x 10^k where one of the next few is such."""
        if "step_size" not in self.Parameters.model_fields:
            return "another step"
        step = min(self.step_size, duration)
        for _ in range(6):
            step = round_down_to_125(step)
            if abs(duration / step - round(duration / step)) <= 1e-9 * (duration / step):
                return f"give step_size = {step:g} (s)"
            step *= 0.99
        return "give another step_size"

    def _whole_ticks(self, duration: float | None) -> int:
        ticks = self.ticks_in(duration)  # type: ignore[arg-type]
        if len(self._tick_counts) < 1024:
            self._tick_counts[float(duration)] = ticks  # type: ignore[arg-type]
        return ticks

    # -- inputs -----------------------------------------------------------------------------------------------------

    @property
    def held_inputs(self) -> Mapping[str, Held]:
        """The inputs that are held now, as the kernels get them; never changed in place."""
        return self._held

    def hold(self, inputs: Mapping[str, Any]) -> dict[str, Held]:
        """Return what would be held of such inputs, and change nothing; `ParameterError` where one is not valid."""
        held: dict[str, Held] = {}
        for name, value in inputs.items():
            variable = self._inputs.get(name)
            if variable is None:
                where = f"component {self.name!r}"
                raise ParameterError("unknown", hint=self.input_advice(name), at=("input", name), source=where)
            held[name] = hold_input(
                name,
                value,
                shape=variable.shape,
                unit=variable.unit,
                minimum=variable.minimum,
                maximum=variable.maximum,
                step_size=self.step_size,
            )
        return held

    def _hold(self, held: Mapping[str, Held]) -> None:
        before, self._profiled = self._profiled, any(value.__class__ is CompiledProfile for value in held.values())
        self._held = held
        if before or self._profiled:
            self._apply(held)

    def input_advice(self, name: str) -> str:
        """Return what to say to whoever gives an input that there is not."""
        return nearest(name, self._inputs)

    # -- pieces of a long step, and their undoing --------------------------------------------------------------------

    def _is_looked_at(self, end: int) -> bool:
        """Return whether an observer wants to look before a step is over, or when it is."""
        for observer in self._observers:  # noqa: SIM110 - `any` would take twice as long, of each step that is recorded
            if observer.next_tick <= end:
                return True
        return False

    def _long_step(self, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Step in pieces, for observers and for Ctrl-C; all of it or nothing."""
        self._refuse_beside_owner("step")
        start, end, held = self._tick, self._tick + ticks, self._held
        self._undo.prepare(start)
        vars(self)["_step_start"] = start  # as in `step`
        begun, warned = perf_counter(), ticks < _MANY_TICKS
        untold: list[Observer] | None = None
        try:
            if inputs:
                self._hold({**held, **inputs})
            while self._tick < end:
                stop = min(end, self._tick + self._chunk_ticks)
                for observer in self._observers:
                    stop = min(stop, max(observer.next_tick, self._tick + 1))
                self._advance_with_timing(stop - self._tick)
                if not warned and (spent := perf_counter() - begun) > _SILENT_SECONDS:
                    warned = True
                    self._tell_time_left(self._tick - start, ticks, spent)
                for observer in self._observers:
                    if observer.next_tick <= stop:
                        observer.on_sample(self)
            untold = self._observers[::-1]
            self._tell(untold, ticks, inputs)
        except BaseException as error:
            self._end_cut_step(start, held, untold, ticks, inputs, error)
            raise
        if not self._undo.is_small:  # last: where that is cut, the next step takes a copy
            self._undo.note(ticks, self._held)

    def _tell(self, untold: list[Observer], ticks: int, inputs: Mapping[str, Held]) -> None:
        """Tell the observers of a step, the last of the list first, and leave in the list who was not told."""
        while untold:
            untold[-1].on_step(self, ticks, inputs)
            untold.pop()

    def _end_cut_step(
        self,
        start: int,
        held: Mapping[str, Held],
        untold: list[Observer] | None,
        ticks: int,
        inputs: Mapping[str, Held],
        error: BaseException,
    ) -> None:
        """Put a step back that was not made (`untold` is None); one that was stands, and the others are told of it."""
        if untold is None:
            self._put_back(start, held)
            _call_all([observer.on_failure for observer in self._observers], self, error)
            if isinstance(error, MemoryError):
                raise GranularError(
                    f"component {self.name!r} needed more memory than there is; its state is that from before the step",
                    hint="make it smaller, or record less often", at="step",
                ) from error  # fmt: skip
        else:  # whoever was not told of it, or was interrupted while it was, is told now
            _call_all([observer.on_step for observer in reversed(untold)], self, ticks, inputs)

    def _tell_time_left(self, done: int, ticks: int, spent: float) -> None:
        """Warn of a step that has `spent` seconds behind it and takes much longer."""
        left = spent * (ticks - done) / done
        if left < _LONG_SECONDS:
            return
        words = f"{left / 3600.0:,.1f} hours" if left > 7200.0 else f"{left / 60.0:.0f} minutes"
        size = f"{ticks * self.step_size:.9g} s are {ticks:,} internal steps of {self.step_size:.9g} s"
        caution(
            f"step: {size}; after {spent:.0f} s of wall time {done / ticks:.1%} are done, about {words} are left; Ctrl-C "
            "undoes the step. Durations are in seconds: a microsecond is 1e-6"
        )

    def _advance_with_timing(self, ticks: int) -> None:
        begin = perf_counter()
        status = self._advance(ticks)
        if status:
            raise self._explain(status)
        vars(self)["_tick"] += ticks  # as in `step`
        if ticks == self._chunk_ticks:
            spent = perf_counter() - begin
            if spent < 0.5 * _CHUNK_SECONDS:
                self._chunk_ticks *= 2
            elif spent > 2.0 * _CHUNK_SECONDS and ticks > 1:
                self._chunk_ticks //= 2

    def _put_back(self, tick: int, held: Mapping[str, Held]) -> None:
        """Put the state of a tick back, and what was held then: a copy, and the steps since it was taken, made again.

        Whatever interrupts that (Ctrl-C, a timeout of the caller's), it is begun anew, and the error under way is told. A fault
        that comes again at the same place is no interrupt: then the component stays where that is.
        """
        before, repeats, fault = None, 0, None
        for _ in range(_ATTEMPTS):
            try:
                self._undo.load()
                if not self._undo.is_small:
                    self._make_again()
                self._tick = self._failure = tick
                self._hold(held)
                return
            except BaseException as error:
                place = type(error), str(error), self._tick
                repeats = repeats + 1 if place == before else 1
                before, fault = place, error
                if repeats == _REPEATS:
                    break
        self._undo.forget()
        self._failure = self._tick
        raise GranularError(
            f"component {self.name!r} could not be put back to {tick * self.step_size:.12g} s, where a step failed "
            f"({_description(sys.exception())}): {_description(fault)}",
            hint=f"it is at {self.time:.12g} s; restore a snapshot, or reset it",
        ) from fault

    def _make_again(self) -> None:
        """Make the steps since the copy again; they gave no error before."""
        self._tick = self._undo.tick
        for ticks, inputs in self._undo.steps:
            self._hold(inputs)
            if self._advance(ticks):
                raise GranularError("a step that was made before fails now", hint="`_advance` depends on more than the block")
            self._tick += ticks


def _description(error: BaseException | None) -> str:
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:400]}" if text else type(error).__name__


def _call_all(functions: Iterable[Callable[..., None]], *arguments: Any) -> None:
    """Call all of them while an error is under way, whatever they raise: none must miss what the others are told."""
    for function in functions:
        with suppress(BaseException):
            function(*arguments)
