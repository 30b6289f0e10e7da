"""The contract: what every component offers, on one page.

    component = SomeComponent(**parameters)          # SI units; ParameterError names what is wrong
    component.reset(velocity=..., seed=...)          # start values
    component.step(1e-6, left_force=3.0)             # advance exactly so long, inputs held
    component.get("velocity")                        # any variable, a copy
    state = component.save(); component.restore(state)
    component.ledger()                               # energy and momentum: in, stored, lost, left over

Time is an integer tick: ``time = tick * step_size``. A step happens whole or not at all. ``step(n h)`` is bit-equal to n
times ``step(h)``, with any pause, save and restore between. Inputs keep their value until they are set again, `reset` puts
them back to their start. `oscillator.py` is the shortest complete component.
"""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import math
import sys
from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from time import perf_counter
from typing import Any, ClassVar, Literal, Protocol, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, model_validator

from .errors import FmuError, GranularError, GranularWarning, LogError, ParameterError, StepError, nearest, shortened
from .memory import refuse_beyond
from .packing import canonical_json
from .profiles import CompiledProfile, Profile, finite_number
from .roots import round_down_to_125
from .state import Block, FloatArray, Held, Snapshot
from .validation import Fixed, filled, plain, validated

__all__ = [
    "Block",
    "Component",
    "FmuError",
    "GranularError",
    "GranularWarning",
    "Ledger",
    "LogError",
    "Observer",
    "ParameterError",
    "Parameters",
    "Particles",
    "Snapshot",
    "StepError",
    "Variable",
]

Model = TypeVar("Model", bound=BaseModel)

# A long step is cut, invisibly, into pieces of about this wall time, so that Ctrl-C and observers get their turn [s].
_CHUNK_SECONDS = 0.05
_LARGEST = sys.float_info.max


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


_LEDGER_VARIABLES = (
    ("kinetic_energy", "J", "kinetic energy"),
    ("potential_energy", "J", "stored energy: elastic, and of the weight where there is gravity"),
    ("dissipated_energy", "J", "energy lost to dissipation since the reset"),
    ("fracture_energy", "J", "energy spent on fracture since the reset"),
    ("input_work", "J", "work done by inputs and boundaries since the reset"),
    ("energy_residual", "J", "energy now + lost - at the reset - input_work: the error of the numerics"),
    ("momentum", "kg m/s", "total momentum"),
    ("impulse", "kg m/s", "impulse given by inputs and boundaries since the reset"),
    ("momentum_residual", "kg m/s", "momentum now - at the reset - impulse: the error of the numerics"),
)


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


class Parameters(Fixed):
    """Base of every component's parameters: frozen, no unknown keys, finite numbers; every field declares a unit."""

    model_config = ConfigDict(validate_default=True)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, fields: Any) -> Any:
        if not isinstance(fields, dict):
            return fields
        truths = {name for name, field in cls.model_fields.items() if field.annotation is bool}
        return {name: value if name in truths else plain(name, value) for name, value in fields.items()}


class Observer(Protocol):
    """Looks at a component while it steps (a recorder, a viewer, a progress bar); never changes it."""

    next_tick: int
    """The next tick at which `look` wants to be called; a step that goes past is cut there, invisibly."""

    def began(self, component: Component) -> None:
        """After a reset or a restore: a new history starts here."""

    def look(self, component: Component) -> None:
        """At `next_tick`, perhaps inside a step; sets `next_tick` anew."""

    def stepped(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """After a whole step, with the inputs that were set by it (compiled).

        What is raised here reaches the caller once all observers have been told; the step stands.
        """

    def failed(self, component: Component, error: BaseException) -> None:
        """After a step that failed or was interrupted: the component is back where that step began."""


class _Fixed(ABCMeta):
    """Closes a component to assignments once its whole `__init__`, that of subclasses too, has run."""

    def __call__(cls, *positional: Any, **named: Any) -> Any:
        made = super().__call__(*positional, **named)
        made._closed = True
        return made


class Component(metaclass=_Fixed):
    """A physical system that can be reset, stepped, read, saved and restored.

    Once it is made, its attributes cannot be set, but for private ones (`_name`) of a subclass: parameters are fixed, inputs
    are given to `step`, start values to `reset`.
    """

    name: ClassVar[str]
    """Catalogue name."""
    version: ClassVar[int] = 1
    """Raised whenever the same parameters and inputs would give other bits."""
    Parameters: ClassVar[type[Parameters]]
    platform_bound: ClassVar[bool] = False
    """True where the same run may give other bits on another CPU."""

    _closed: bool = False
    _tick: int
    # Replaced, never changed in place: snapshots share it.
    _held: Mapping[str, Held]

    # Set by `_build`.
    step_size: float
    """Length of one internal step [s]."""
    _block: Block

    def __init__(self, **parameters: Any) -> None:
        """Check the parameters, allocate everything once, and reset.

        Raises:
            ParameterError: a parameter is unknown, missing or out of range, or the component would not fit into memory.
        """
        self.parameters = validated(self.Parameters, parameters, f"component {self.name!r}")
        refuse_beyond(self.memory_needed(self.parameters), f"component {self.name!r}")
        try:
            self._build()
        except MemoryError as error:
            raise ParameterError(f"component {self.name!r}: this size does not fit into memory: {error}") from None
        # Parameters at their default do not count: one that is added later leaves the logs of today as they are.
        told = self.parameters.model_dump(mode="json", exclude_defaults=True)
        self.identity: str = hashlib.sha256(canonical_json([self.name, self.version, told])).hexdigest()
        self.variables: dict[str, Variable] = {variable.name: variable for variable in self._all_variables()}
        self._inputs = {v.name: v for v in self.variables.values() if v.causality == "input"}
        self._bounds = {v.name: (max(v.minimum, -_LARGEST), min(v.maximum, _LARGEST)) for v in self._inputs.values()}
        self._tick_counts: dict[float | None, int] = {None: 1}
        self._settle()
        self.reset()

    def _settle(self) -> None:
        """What belongs to this one component alone, whose block is there."""
        self._readers: dict[str, Callable[[], Any]] = self._outputs()
        self._observers: list[Observer] = []
        # Two threads at once would mix two steps into one.
        self._stepping = False
        self._chunk_ticks = 256
        self._backup = self._block.memory.copy()
        # Assigning between byte views is the quickest copy there is from Python.
        self._memory_bytes, self._backup_bytes = self._block.memory.data.cast("B"), self._backup.data.cast("B")
        self._held = {}
        # Whether any of them is a profile.
        self._profiled = False
        self._tick = 0

    def __repr__(self) -> str:
        return f"<{self.name} at {self.time:.9g} s (tick {self.tick})>"

    def __setattr__(self, name: str, value: Any) -> None:
        if self._closed and not name.startswith("_"):
            raise ParameterError(f"{name}: {self._assignment_advice(name)}")
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        if self._closed and not name.startswith("_"):
            raise ParameterError(f"{name}: {self._assignment_advice(name)}")
        object.__delattr__(self, name)

    @property
    def _named(self) -> str:
        """The name with its article."""
        return f"{'an' if self.name[:1].lower() in 'aeiou' else 'a'} {self.name}"

    def _assignment_advice(self, name: str) -> str:
        """What to do instead of setting or deleting an attribute."""
        variable = self.variables.get(name)
        if name == "parameters" or (variable is not None and variable.causality == "parameter"):
            return f"the parameters of {self._named} are fixed once it is made; make a new one with the other value"
        if variable is None:
            advice = "" if hasattr(self, name) else f"; {nearest(name, self.variables)}"
            return f"{self._named}'s attributes cannot be set once it is made{advice}"
        if variable.causality == "input":
            return f"an input is given to a step: step(duration, {name}=...)"
        return f"a start value is given to reset: reset({name}=...)" if variable.state else "an output can only be read"

    # -- what a component has to provide ----------------------------------------------------------------------------

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

    # -- life cycle -------------------------------------------------------------------------------------------------

    @property
    def tick(self) -> int:
        """Integer time."""
        return self._tick

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._tick * self.step_size

    def reset(self, *, seed: int | None = None, **start: Any) -> None:
        """Back to tick 0, with nothing left of what was before.

        Args:
            seed: for components that draw random numbers.
            **start: start values of state variables: a number for all, an array, or {index: value}.

        Raises:
            ParameterError: an unknown variable, a wrong shape, a value that is not finite; the state is unharmed.
        """
        if seed is not None and (isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or not 0 <= seed < 2**64):
            raise ParameterError(f"seed: got {shortened(seed)}, expected a whole number from 0 to 2^64 - 1, or None")
        values = {name: self._start_values(name, value) for name, value in start.items()}
        before, tick = self._block.memory.copy(), self._tick
        self._block.memory[:] = 0.0
        self._tick = 0
        try:
            given = self._start(seed, values)
        except BaseException:
            self._block.memory[:] = before
            self._tick = tick
            raise
        self._hold({name: float(given.get(name, 0.0)) for name in self._inputs})
        for observer in self._observers:
            observer.began(self)

    def step(self, duration: float | None = None, **inputs: Any) -> None:
        """Advance by exactly `duration` [s] (default: one internal step) with the inputs held.

        Args:
            duration: a whole number of internal steps.
            **inputs: numbers, or profiles of time; each keeps its value until it is set again.

        Raises:
            ParameterError: an input or the duration is not valid; nothing has changed.
            StepError: the physics would break down; the state is that from before the step.
            GranularError: another thread, or an observer, steps it while it steps.
        """
        # This is the hot path of step-wise control: what is usual is looked up, everything else goes to a slower function.
        # Writing to `own` bypasses `__setattr__`, which would cost a third of a short step.
        own: dict[str, Any] = self.__dict__  # type: ignore[assignment]
        try:
            ticks = self._tick_counts[duration]
        except (KeyError, TypeError):
            ticks = self._whole_ticks(duration)
        if self._stepping:
            raise GranularError(
                f"step: this {self.name} is in the middle of a step, of another thread or of an observer; "
                "give each thread a component of its own"
            )
        own["_stepping"] = True
        try:
            held = self._held
            if inputs:
                bounds, numbers = self._bounds, not self._profiled
                for name, value in inputs.items():
                    if value.__class__ is float and name in bounds:
                        low, high = bounds[name]
                        if low <= value <= high:
                            continue
                    inputs, numbers = self._compiled(inputs), False
                    break
                if numbers:
                    own["_held"] = inputs if len(inputs) == len(bounds) else {**held, **inputs}
                else:
                    self._hold({**held, **inputs})
            if self._observers or ticks > self._chunk_ticks:
                self._long_step(ticks, inputs, held)
                return
            before = self._tick
            self._backup_bytes[:] = self._memory_bytes
            try:
                status = self._advance(ticks)
                if status:
                    raise self._explain(status)
                own["_tick"] = before + ticks
            except BaseException:  # Ctrl-C too
                self._undo(before, held)
                raise
        finally:
            own["_stepping"] = False

    def get(self, name: str) -> Any:
        """The present value of any variable: a number, or a fresh array of its shape."""
        value = self.peek(name)
        return value.copy() if value.__class__ is np.ndarray and value.base is not None else value

    def peek(self, name: str) -> Any:
        """`get` without a copy: an array may be the component's own memory. Read it before the next step, never write to it."""
        reader = self._readers.get(name) if isinstance(name, str) else None
        if reader is not None:
            return reader()
        if isinstance(name, str) and name in self._inputs:
            value = self._held[name]
            return value.value(self._tick) if isinstance(value, CompiledProfile) else value
        variable = self.variables.get(name) if isinstance(name, str) else None
        if variable is None:
            raise ParameterError(f"variable {name!r} is unknown to {self.name!r}; {nearest(name, self.variables)}")
        if variable.causality == "parameter":
            return copy.deepcopy(getattr(self.parameters, name))
        return getattr(self.ledger(), name)

    def save(self) -> Snapshot:
        """The whole state; costs one copy."""
        return Snapshot(self.identity, self._tick, bytes(self._memory_bytes), self._held)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot, bit for bit, whichever process took it.

        Raises:
            ParameterError: it belongs to a component with other parameters, another name or another version.
        """
        if snapshot.__class__ is not Snapshot or snapshot.identity != self.identity or snapshot.inputs is not self._held:
            self.refuse_foreign(snapshot)
            self._hold(snapshot.inputs)
        try:
            self._memory_bytes[:] = snapshot.data
        except ValueError:  # another length
            self.refuse_foreign(snapshot)
            raise
        vars(self)["_tick"] = snapshot.tick  # as in `step`
        for observer in self._observers:
            observer.began(self)

    def refuse_foreign(self, snapshot: Snapshot) -> None:
        """Raise what `restore` would raise for this snapshot, and change nothing."""
        if snapshot.__class__ is not Snapshot:
            raise ParameterError(f"snapshot: got {shortened(snapshot)}, expected what save() or Snapshot.from_bytes() gave")
        if snapshot.identity != self.identity:
            raise ParameterError(
                f"snapshot: it belongs to a component with identity {str(snapshot.identity)[:12]}..., this one has "
                f"{self.identity[:12]}...; restore it into one of the same parameters and version"
            )
        if len(snapshot.data) != self._memory_bytes.nbytes:
            raise ParameterError(
                f"snapshot: its state has {len(snapshot.data)} bytes, this component's has {self._memory_bytes.nbytes}"
            )
        if snapshot.inputs is not self._held:
            self._check_inputs(snapshot)

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle and `copy.deepcopy`: the parameters and the state. Observers stay with the original."""
        return _recreate, (type(self), self.parameters.model_dump(), self.save())

    def __copy__(self) -> Component:
        """Return an independent component: one that shares the state would step the original as well."""
        return copy.deepcopy(self)

    def observe(self, observer: Observer) -> None:
        """Let an observer look on from now."""
        self._observers.append(observer)
        observer.began(self)

    def ignore(self, observer: Observer) -> None:
        """Stop an observer's looking on."""
        if observer in self._observers:
            self._observers.remove(observer)

    # -- details ----------------------------------------------------------------------------------------------------

    def ticks_in(self, duration: float, name: str = "duration") -> int:
        """The whole number of internal steps in a duration [s]; `ParameterError` where it is none."""
        duration = finite_number(name, duration, "seconds")
        exact = duration / self.step_size
        if not math.isfinite(exact) or exact <= 0.0:
            raise ParameterError(f"got {duration!r} s, expected more than 0 and finite", at=name)
        ticks = round(exact)
        if ticks < 1 or abs(exact - ticks) > 1e-9 * ticks or ticks > 2**52:
            if ticks > 2**52:
                raise ParameterError(f"{duration:.12g} s is {exact:.3g} internal steps, more than can be counted", at=name)
            steps = sorted({max(math.floor(exact), 1), max(math.ceil(exact), 1)})
            choices = " or ".join(f"{count * self.step_size:.12g} s" for count in steps)
            raise ParameterError(
                f"{duration:.12g} s is {exact:.9g} internal steps of {self.step_size:.12g} s, expected a whole number; "
                f"use {choices}, or {self._fitting_step(duration)}",
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

    def _compiled(self, inputs: Mapping[str, Any]) -> dict[str, Held]:
        checked: dict[str, Held] = {}
        for name, value in inputs.items():
            if name not in self._inputs:
                raise ParameterError(f"input {name!r} is unknown to this {self.name}; {self._input_advice(name)}")
            if isinstance(value, Profile):
                checked[name] = value.compile(self.step_size, name)
            elif isinstance(value, CompiledProfile):
                if value.step_size != self.step_size:
                    raise ParameterError(
                        f"input {name!r} was compiled for steps of {value.step_size:g} s, not of {self.step_size:g} s"
                    )
                checked[name] = value
            else:
                number = value
                if type(value) is not float or not math.isfinite(value):
                    hint = "; sample a function with Profile.table(times, values)" if callable(value) else ""
                    number = finite_number(f"input {name!r}", value, f"a number or a Profile{hint}")
                variable = self._inputs[name]
                if not variable.minimum <= number <= variable.maximum:
                    raise ParameterError(
                        f"input {name!r}: got {number:g} {variable.unit}, expected {variable.minimum:g} to {variable.maximum:g}"
                    )
                checked[name] = number
        return checked

    def _hold(self, held: Mapping[str, Held]) -> None:
        before, self._profiled = self._profiled, any(value.__class__ is not float for value in held.values())
        self._held = held
        if before or self._profiled:
            self._apply(held)

    def _input_advice(self, name: str) -> str:
        """What to say to whoever gives an input that there is not."""
        return nearest(name, self._inputs)

    def _check_inputs(self, snapshot: Snapshot) -> None:
        if snapshot.inputs.keys() != self._inputs.keys():
            raise ParameterError(
                f"snapshot: it holds the inputs {sorted(snapshot.inputs)}, this component has {sorted(self._inputs)}"
            )
        self._compiled(snapshot.inputs)

    def _long_step(self, ticks: int, inputs: Mapping[str, Held], held: Mapping[str, Held]) -> None:
        """A step in pieces: for observers and for Ctrl-C; all of it or nothing."""
        start, end = self._tick, self._tick + ticks
        self._backup[:] = self._block.memory
        try:
            while self._tick < end:
                stop = min(end, self._tick + self._chunk_ticks)
                for observer in self._observers:
                    stop = min(stop, max(observer.next_tick, self._tick + 1))
                self._timed_advance(stop - self._tick)
                for observer in self._observers:
                    if observer.next_tick <= stop:
                        observer.look(self)
        except BaseException as error:
            self._undo(start, held)
            _call_all([observer.failed for observer in self._observers], self, error)
            raise
        if len(self._observers) == 1:  # as usual, and quicker
            self._observers[0].stepped(self, ticks, inputs)
        else:
            _call_all([observer.stepped for observer in self._observers], self, ticks, inputs)

    def _timed_advance(self, ticks: int) -> None:
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

    def _undo(self, tick: int, held: Mapping[str, Held]) -> None:
        self._block.memory[:] = self._backup
        self._tick = tick
        self._hold(held)

    def _start_values(self, name: str, value: Any) -> FloatArray:
        variable = self.variables.get(name)
        if variable is None or not variable.state:
            known = [v.name for v in self.variables.values() if v.state]
            raise ParameterError(f"start value {name!r} is no state variable of this {self.name}; {nearest(name, known)}")
        return filled(f"start.{name}", value, variable.shape)

    def _all_variables(self) -> Iterable[Variable]:
        yield from parameter_variables(self.Parameters, self.parameters)
        yield from self._declare()
        for name, unit, description in _LEDGER_VARIABLES:
            yield Variable(name, "output", unit, (), description)


def _call_all(functions: Iterable[Callable[..., None]], *arguments: Any) -> None:
    """Call all of them, then raise what the first one raised: the others must not miss a step."""
    faults: list[BaseException] = []
    for function in functions:
        try:
            function(*arguments)
        except BaseException as error:
            faults.append(error)
    if faults:
        raise faults[0]


def _recreate(kind: type[Component], parameters: Mapping[str, Any], state: Snapshot) -> Component:
    """Return a component of these parameters in this state."""
    component = kind(**parameters)
    component.restore(state)
    return component


_DTYPES = {bool: "bool", int: "int64", str: "str"}


def parameter_variables(model: type[BaseModel], parameters: BaseModel | None = None) -> Iterable[Variable]:
    """The fields of a parameter model as variables: unit and shape come from each field's declaration."""
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        start = getattr(parameters, name) if parameters is not None else field.get_default()
        shape = np.shape(start) if isinstance(start, (list, tuple)) and all(isinstance(x, float) for x in start) else ()
        dtype = str(extra.get("dtype") or _DTYPES.get(type(start), "float64"))
        yield Variable(name, "parameter", str(extra.get("unit", "")), tuple(shape), field.description or "", dtype, start)
