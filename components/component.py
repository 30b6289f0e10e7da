"""The base of all components: a physical system that can be reset, stepped, read, saved and restored."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import math
import operator
import sys
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import BaseModel

from .balances import Balance
from .declaration_checks import validate_balances, validate_events, validate_step_size, validate_variables
from .drawables import element_count, validate_drawables
from .errors import GranularError, IssuedCautions, ParameterError, StepError, nearest, one_line
from .events import MOST_INDEX, Event, EventDetail, event_rows
from .inputs import Held, input_value
from .number_arrays import start_array
from .snapshot import Snapshot
from .state_block import Block, Layout
from .stepping import Stepping
from .support.float_arrays import FloatArray
from .support.memory_limits import refuse_beyond
from .support.serialization import canonical_json
from .support.validation import validate_parameters, whole_number
from .variables import Variable

_LARGEST = sys.float_info.max


class _Fixed(ABCMeta):
    """Closes a component to assignments once its whole `__init__`, that of subclasses too, has run."""

    def __call__(cls, *positional: Any, **named: Any) -> Any:
        made = super().__call__(*positional, **named)
        made._closed = True
        return made


class Component(Stepping, metaclass=_Fixed):
    """A physical system that can be reset, stepped, read, saved and restored.

    Once it is made, its attributes cannot be set, but for private ones (`_name`) of a subclass: parameters are fixed, inputs
    are given to `step`, start values to `reset`.
    """

    version: ClassVar[int] = 1
    """Raised whenever the same parameters and inputs would give other bits."""
    platform_bound: ClassVar[bool] = False
    """True where the same run may give other bits on another CPU."""

    _closed: bool = False
    # Parts in this component's memory, the prefix of their events, their ticks in one of this.
    _included: tuple[tuple[Component, str, int], ...] = ()

    def __init__(self, *, memory: FloatArray | None = None, **parameters: Any) -> None:
        """Check the parameters, allocate everything once, and reset.

        Args:
            memory: of a parent that owns it: float64, C-ordered, as large as `memory` of a component of these parameters. It
                is overwritten, and the state lies in it from now on.
            **parameters: see `Parameters`.

        Raises:
            ParameterError: a parameter is unknown, missing or out of range, or the component would not fit into memory.
        """
        self._given_memory = memory
        self.issued_cautions: IssuedCautions = IssuedCautions()
        self.parameters = validate_parameters(self.Parameters, parameters, f"component {self.name!r}")
        refuse_beyond(self.memory_needed(self.parameters), f"component {self.name!r}")
        self._build_state()
        # Parameters at their default do not count: one that is added later leaves the logs of today as they are.
        chosen = self.parameters.model_dump(mode="json", exclude_defaults=True)
        self.identity: str = hashlib.sha256(canonical_json([self.name, self.version, chosen])).hexdigest()
        self.variables: dict[str, Variable] = {variable.name: variable for variable in self._all_variables()}
        self._inputs = {v.name: v for v in self.variables.values() if v.causality == "input"}
        self._bounds = {
            v.name: (max(v.minimum, -_LARGEST), min(v.maximum, _LARGEST)) for v in self._inputs.values() if v.shape == ()
        }
        self._tick_counts: dict[float | None, int] = {None: 1}
        self._settle()
        self._declare_balances()
        known, starts_itself = self.Parameters.model_fields, type(self)._start is not Component._start
        validate_variables(self.declared(), known, self._block, self._outputs(), self.balance_names, starts_itself)
        self.reset()
        self._validate_drawables_and_events()

    def _build_state(self) -> None:
        try:
            self._build()
        except MemoryError as error:
            raise ParameterError(
                f"this size does not fit into memory: {error}", hint="make it smaller", source=self._full_name
            ) from None
        validate_step_size(getattr(self, "step_size", None))
        if not hasattr(self, "_block"):
            raise ParameterError("it is not laid out", hint="call `_lay_out` in `_build`", at="state", source=self._full_name)

    def _declare_balances(self) -> None:
        """Declare the entries of balances, which are known once there is a state, of zeros.

        An entry may be declared already, for a description of its own, if it is read as the entry alone.
        """
        validate_balances(self.balances())
        for balance in self.balances():
            if not balance.stored:
                raise ParameterError("got no entry", expected="at least one", at=("balances", balance.quantity, "stored"))
            for variable in balance_variables(balance):
                known = self.variables.setdefault(variable.name, variable)
                other = (known.causality, known.unit, known.shape) != (variable.causality, variable.unit, variable.shape)
                if other or (known is not variable and known.name in self._readers):
                    hint = "give one of them another name"
                    raise ParameterError(
                        "another variable has this name", hint=hint, at=("balances", balance.quantity, variable.name)
                    )
        self.balance_names: tuple[str, ...] = tuple(name for balance in self.balances() for name in balance.entries)

    def _validate_drawables_and_events(self) -> None:
        drawables = self.drawables()
        validate_drawables(drawables, self.variables)
        drawn, outputs = [one.name for one in drawables], [v.name for v in self.variables.values() if v.causality == "output"]
        validate_events(list(self.event_kinds), self._own_kinds, self.event_details, self._block, drawn, outputs)
        sizes, details = {one.name: element_count(one) for one in drawables}, self.event_details
        counted = [sizes.get(details[kind].counts, 0) if kind in details else 0 for kind in self._own_kinds]
        # The smallest index of each kind of event, and the first one beyond the largest.
        self._index_limits: FloatArray = np.array([(0, size) if size else (-1, MOST_INDEX) for size in counted], np.float64)

    def _lay_out(self, growing: Layout | None = None, **fields: tuple[Any, ...]) -> None:
        """Set `_block`: the state, as `state_block.Block` lays it out, in the memory of a parent where there is one.

        Where something can happen that is an event, the list `events` comes before those that are given. `restore` checks the
        ranges that are declared here; see `state_block.Field`.
        """
        lists = {**({"events": event_rows(len(self.event_kinds))} if self.event_kinds else {}), **(growing or {})}
        words = sum(math.prod(field[1]) for field in fields.values()) + len(lists)
        self._block = Block(self._claim_memory((words,)), growing=lists, **fields)

    def _include(self, part: Component, prefix: str, ticks: int = 1) -> None:
        """Take a part, which was made in the memory of this component, into its snapshots and events.

        Call it in `_build`, after `_lay_out`. The lists that grow in the part belong to this component's snapshots then, and
        its events are events of this component, their kinds named `<prefix>_<kind>`.

        Args:
            part: lies in the memory of this component's block.
            prefix: of its kinds of events.
            ticks: internal steps of the part in one of this component.

        Raises:
            ParameterError: a kind of that name is there already.
        """
        kinds = {f"{prefix}_{kind}": f"{prefix}: {text}" for kind, text in part.event_kinds.items()}
        for kind in kinds:
            if kind in self.event_kinds:
                raise ParameterError(
                    f"event {kind!r} is there already", hint=f"include the part with another prefix than {prefix!r}"
                )
        self._block.include(part._block)
        self._included = (*self._included, (part, prefix, ticks))
        details = {
            f"{prefix}_{kind}": dataclasses.replace(detail, ratio=detail.ratio and f"{prefix}_{detail.ratio}")
            for kind, detail in part.event_details.items()
        }
        self._declare_events({**self.event_kinds, **kinds}, {**self.event_details, **details})

    def _declare_events(self, kinds: Mapping[str, str], details: Mapping[str, EventDetail]) -> None:
        """Declare the events of this one component, in place of those of its class; call it in `_build`, before `_lay_out`.

        Args:
            kinds: `event_kinds`.
            details: `event_details`.
        """
        vars(self).update(event_kinds=kinds, event_details=details)

    def _claim_memory(self, shape: tuple[int, ...]) -> FloatArray:
        """Return zeros of that shape, in the memory of a parent where there is one."""
        memory: Any = self._given_memory
        if memory is None:
            self._memory = np.zeros(shape)
            return self._memory
        sound = isinstance(memory, np.ndarray) and memory.dtype == np.float64 and memory.flags.c_contiguous
        if not sound or not memory.flags.writeable or memory.size != math.prod(shape):
            came = f"{memory.dtype} of shape {memory.shape}" if isinstance(memory, np.ndarray) else one_line(memory)
            raise ParameterError(f"got {came}", expected=f"writable C-ordered float64 of shape {shape}", at="memory")
        memory[...] = 0.0
        self._memory: FloatArray = memory.reshape(shape)
        return self._memory

    def clone(self, memory: FloatArray | None = None) -> Self:
        """Return a component of the same parameters, at its start; in the memory of a parent where that is given."""
        return type(self)(memory=memory, **self.parameters.model_dump())

    def _settle(self) -> None:
        """Make what belongs to this one component alone, whose block is there."""
        parts = {v.name: self._block.views.get(v.name) for v in self.declared() if v.causality == "output"}
        views = {name: _reader_of(part) for name, part in parts.items() if part is not None}
        self._readers: dict[str, Callable[[], Any]] = views | self._outputs()
        self._prepare_steps()
        for part, *_ in self._included:
            part._belong_to(self)

    def __repr__(self) -> str:
        return f"<{self.name} at {self.time:.9g} s (tick {self.tick})>"

    def __setattr__(self, name: str, value: Any) -> None:
        if self._closed and not name.startswith("_"):
            raise ParameterError(self._assignment_advice(name), at=name)
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        if self._closed and not name.startswith("_"):
            raise ParameterError(self._assignment_advice(name), at=name)
        object.__delattr__(self, name)

    @property
    def _full_name(self) -> str:
        """The name as messages call it."""
        return f"component {self.name!r}"

    def _assignment_advice(self, name: str) -> str:
        """Return advice: what to do instead of setting or deleting an attribute."""
        variable = self.variables.get(name)
        if name == "parameters" or (variable is not None and variable.causality == "parameter"):
            return f"the parameters of {self._full_name} are fixed once it is made; make a new one with the other value"
        if variable is None:
            advice = "" if hasattr(self, name) else f"; {nearest(name, self.variables)}"
            return f"the attributes of {self._full_name} cannot be set once it is made{advice}"
        if variable.causality == "input":
            return f"an input is given to a step: step(duration, {name}=...)"
        return f"a start value is given to reset: reset({name}=...)" if variable.state else "an output can only be read"

    # -- start, reading ---------------------------------------------------------------------------------------------

    def reset(self, *, seed: int | None = None, **start: Any) -> None:
        """Back to tick 0, with nothing left of what was before.

        Args:
            seed: for components that draw random numbers.
            **start: start values of state variables: a number for all, an array, one row for all, or {index: value or row}.

        Raises:
            ParameterError: an unknown variable, a wrong shape, a value that is not finite; the state is unharmed.
        """
        if seed is not None and (isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or not 0 <= seed < 2**64):
            raise ParameterError(f"got {one_line(seed)}", expected="a whole number from 0 to 2^64 - 1, or None", at="seed")
        self._refuse_while_stepping("reset")
        self._refuse_beside_owner("reset")
        values = {name: self._start_values(name, value) for name, value in start.items()}
        before, tick, failure = self._block.to_bytes(), self._tick, self._failure
        self._undo.forget()
        self._block.clear()
        self._tick, self._failure = 0, -1
        try:
            with np.errstate(all="ignore"):  # what is not finite is refused
                given = self.begin(seed, values)
                if start:
                    self._refuse_infinite_balances()
        except BaseException:
            self._block.load(before)
            self._tick, self._failure = tick, failure
            raise
        starts = {name: 0.0 if variable.start is None else variable.start for name, variable in self._inputs.items()}
        try:
            self._hold(self.hold({**starts, **given}))
            self._tell_of_reset()
        except BaseException:
            self._tell_of_reset_once_more()
            raise

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        for name, value in values.items():
            if name not in self._block.views:
                came = "it is a start value, and no part of the state of that name takes it"
                raise ParameterError(came, expected="a `_start` that sets it", at=("variables", name))
            self._block.views[name][...] = value
        return {}

    def _refuse_infinite_balances(self) -> None:
        """Refuse a start whose energy, or another balance, is beyond what a float holds."""
        for balance in self.balances():
            for name, amount in balance.entries.items():
                if not np.isfinite(amount).all():
                    came = f"a {name} of {one_line(amount)} {balance.unit} follows from these values"
                    raise ParameterError(came, expected="a finite one", hint="give smaller values", at="start")

    def get(self, name: str) -> Any:
        """Return the present value of any variable: a number, or a fresh array of its shape."""
        value = self._read(name)
        if value.__class__ is np.ndarray and (value.base is not None or not value.flags.writeable):
            return value.copy()
        return value

    def peek(self, name: str) -> Any:
        """`get` without a copy: an array is read-only and may be the component's memory; read it before the next step."""
        value = self._read(name)
        if value.__class__ is np.ndarray:
            value = value.view()
            value.flags.writeable = False
        return value

    def _read(self, name: str) -> Any:
        reader = self._readers.get(name) if isinstance(name, str) else None
        if reader is not None:
            return reader()
        if isinstance(name, str) and name in self._inputs:
            return input_value(self._held[name], self._tick)
        variable = self.variables.get(name) if isinstance(name, str) else None
        if variable is None:
            hint = nearest(name, self.variables)
            expected = f"the name of a variable of {self._full_name}"
            raise ParameterError(f"got {one_line(name)}", expected=expected, hint=hint, at="variable")
        if variable.causality == "parameter":
            return copy.deepcopy(getattr(self.parameters, name))
        values = self.balance_values()
        if name not in values:
            raise GranularError(
                f"balances() gave {name!r} at the reset and does not now", hint="give the same entries always", at="balances"
            )
        return values[name]

    def balance_values(self) -> dict[str, Any]:
        """Return all entries of the balances by name, the residuals among them."""
        return {name: amount for balance in self.balances() for name, amount in balance.entries.items()}

    def events(self, kind: str | None = None, index: int | None = None) -> list[Event]:
        """Return what has happened since the reset, in the order of time.

        Args:
            kind: only of this kind; see `event_kinds`.
            index: only of this link, grain, ...

        Raises:
            ParameterError: there is no such kind, or the index is none.
        """
        refuse_unknown_events(self.event_kinds, kind, index, self._full_name)
        kinds = sorted(self.event_kinds)
        return [
            Event(int(tick), kinds[int(number)], None if place < 0 else int(place), value, limit)
            for tick, number, place, value, limit in self.event_rows().tolist()
            if kind in (None, kinds[int(number)]) and index in (None, int(place))
        ]

    @property
    def event_count(self) -> int:
        """Return the number of events since the reset."""
        return self._block.count("events") + sum(part.event_count for part, _, _ in self._included)

    def event_rows(self, since: int = 0) -> FloatArray:
        """Return a copy of the events from number `since` on, each a row of numbers as `events.event_rows` says.

        Kinds are numbered in alphabetical order, as the headers of logs hold them; in the state in the order of `event_kinds`.
        """
        own = self._block["events"].copy() if self._block.count("events") else np.zeros((0, 5))
        self._renumber_kinds(own, self._own_kinds)
        return self._merge_events(own)[since:] if self._included else own[since:]

    @property
    def _own_kinds(self) -> list[str]:
        """The kinds of events that this component notes itself; those of included parts follow them."""
        names = list(self.event_kinds)
        return names[: len(names) - sum(len(part.event_kinds) for part, _, _ in self._included)]

    def _renumber_kinds(self, rows: FloatArray, names: list[str]) -> None:
        """Give events whose kinds are numbered in the order of these names the numbers of the alphabetical order of all."""
        order = sorted(self.event_kinds)
        rows[:, 1] = np.array([order.index(name) for name in names], dtype=np.float64)[rows[:, 1].astype(np.int64)]

    def _merge_events(self, own: FloatArray) -> FloatArray:
        """Return own events and those of the parts, by tick; in a tick the own ones first, then those of the first part.

        Who reads between two ticks finds later events behind all earlier ones, whichever part they belong to.
        """
        tables = [own]
        for part, prefix, ticks in self._included:
            rows = part.event_rows()
            rows[:, 0] = np.ceil(rows[:, 0] / ticks)
            self._renumber_kinds(rows, [f"{prefix}_{kind}" for kind in sorted(part.event_kinds)])
            tables.append(rows)
        found = np.concatenate(tables)
        return found[np.argsort(found[:, 0], kind="stable")]

    def _add_event(self, tick: int, kind: str, index: int | None, value: float, limit: float) -> None:
        """Note an event; `tick` is that at the end of the internal step in which it happened."""
        if kind not in self.event_kinds or (index is not None and not 0 <= operator.index(index) < 2**53):
            raise ParameterError(
                f"got {kind!r} of {index}", expected="a kind of `event_kinds`, and a whole number or None", at="event"
            )
        if not (math.isfinite(value) and math.isfinite(limit)):
            raise ParameterError(f"event {kind!r}: got the value {value} and the limit {limit}", expected="finite numbers")
        number = list(self.event_kinds).index(kind)
        self._block.append("events", (tick, number, -1 if index is None else index, value, limit))

    def _excess_error(self, variable: str, unit: str, size: FloatArray, limit: float, advice: str) -> StepError:
        """Return the error for the first element of a variable that is beyond a limit, or not a number.

        Args:
            variable: its name.
            unit: of the sizes and the limit.
            size: of each element, shape (n,); at least one is above the limit.
            limit: what is allowed.
            advice: what the limit means, and what to do.
        """
        index = int(np.argmin(size <= limit))
        return StepError(
            f"reached {size[index]:g} {unit} soon after {self.time:g} s, expected at most {limit:g} {unit}, {advice}",
            time=self.time, at=(variable, index), variable=variable, index=index, value=float(size[index]), limit=limit,
        )  # fmt: skip

    # -- snapshots --------------------------------------------------------------------------------------------------

    def save(self) -> Snapshot:
        """Return the whole state; costs one copy."""
        block = self._block
        data = block.to_bytes() if block.grows else bytes(block.memory_bytes)
        return Snapshot(self.identity, self._tick, data, self._held, True)

    def wake(self) -> None:
        """Have the next steps do all the work that a run may come to: for an estimate of its time, not for a run."""

    @property
    def memory(self) -> FloatArray:
        """The memory that the component lives in: the state, and what its kernels keep beside it. To be read only."""
        return self._memory

    @property
    def state_bytes(self) -> int:
        """Size of the state now [bytes]."""
        return self._block.nbytes

    @property
    def work_in_tick(self) -> int:
        """Words of state that a tick advances, those of a part at each of its steps: what it costs, the same everywhere.

        A word stands for some nanoseconds; a component whose words take far less or more counts them differently.
        """
        parts = sum(steps * part.work_in_tick - part.state_bytes // 8 for part, _, steps in self._included)
        return self.state_bytes // 8 + parts

    def state_view(self) -> memoryview:
        """Return the bits of the state, as `save` would copy them; to be read before the next step."""
        block = self._block
        return memoryview(block.to_bytes()) if block.grows else block.memory_bytes.toreadonly()

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot, bit for bit, whichever process took it.

        Raises:
            ParameterError: it belongs to a component with other parameters, another name or another version, or its state is
                beyond the ranges that the component declares.
        """
        undo = self._undo
        # A small state has no owner, nothing in it grows, and the undo keeps nothing of it between steps.
        is_small = undo.is_small
        if self._stepping or not is_small:
            self._refuse_while_stepping("restore")
            self._refuse_beside_owner("restore")
        if (
            snapshot.__class__ is not Snapshot
            or snapshot.identity != self.identity
            or snapshot.inputs is not self._held
            or not snapshot.is_checked
        ):
            self.refuse_foreign(snapshot)
            self._hold(self._inputs_of(snapshot))
        if not is_small:
            # First: an interrupt after the state has changed must not leave a copy that seems to lead to it.
            undo.forget()
        try:
            try:
                if is_small:
                    undo.memory[:] = snapshot.data
                else:
                    self._block.load(snapshot.data)
            except ValueError:  # another length
                self.refuse_foreign(snapshot)
                raise
            own: dict[str, Any] = self.__dict__  # type: ignore[assignment] - as in `step`
            own["_tick"] = snapshot.tick
            own["_failure"] = -1
            if not is_small:
                undo.keep(snapshot.tick, snapshot.data)
            if self._observers:
                self._tell_of_reset()
        except BaseException:
            self._tell_of_reset_once_more()
            raise

    def refuse_foreign(self, snapshot: Snapshot) -> None:
        """Raise what `restore` would raise for this snapshot, and change nothing."""
        if snapshot.__class__ is not Snapshot:
            expected = "what save() or Snapshot.from_bytes() gave"
            raise ParameterError(f"got {one_line(snapshot)}", expected=expected, at="snapshot")
        if snapshot.identity != self.identity:
            raise ParameterError(
                f"got one of a component with identity {str(snapshot.identity)[:12]}...",
                expected=f"one with {self.identity[:12]}..., as this {self._full_name} has",
                hint="restore it into one of the same parameters and version",
                at="snapshot",
            )
        if self._block.sizes_in(snapshot.data) is None:
            came = f"got a state of {len(snapshot.data)} bytes, whose sizes do not agree"
            raise ParameterError(came, expected=f"a state of this {self._full_name}", at="snapshot")
        if not snapshot.is_checked:
            self._refuse_unsound(self._block, snapshot.data, snapshot.tick, ("snapshot",))
            snapshot.is_checked = True
        if snapshot.inputs is not self._held:
            self._inputs_of(snapshot)

    def _refuse_unsound(self, whole: Block, data: bytes, tick: int, at: tuple[str, ...]) -> None:
        """Refuse a state, of the whole that this is a part of, that is beyond what was declared: kernels rely on it."""
        state = whole.arrays_in(data, self._block)
        self._block.refuse_beyond_range(state, at)
        if self._own_kinds and len(events := state["events"]):
            ticks, kinds, indices = events.T[:3]
            first, beyond = self._index_limits[kinds.astype(np.int64)].T
            if not ((indices >= first) & (indices < beyond) & (np.diff(ticks, append=tick) >= 0.0)).all():
                expected = f"indices of what there is, and ticks that do not fall, up to {tick}"
                raise ParameterError("got other events", expected=expected, at=(*at, "events"))
        if fault := self._contradiction(state):
            raise ParameterError(fault, hint="save() gives no such state", at=at)
        for part, prefix, ticks_in_one in self._included:
            part._refuse_unsound(whole, data, tick * ticks_in_one, (*at, prefix))

    def _contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        """Return what arrays within their ranges contradict that kernels rely on, "" for nothing; override it where they do.

        Args:
            state: arrays and lists by name, of a state that is to be restored; read-only.
        """
        return ""

    def _inputs_of(self, snapshot: Snapshot) -> Mapping[str, Held]:
        if snapshot.inputs.keys() != self._inputs.keys():
            expected = f"those of this {self._full_name}, {sorted(self._inputs)}"
            raise ParameterError(f"got one with the inputs {sorted(snapshot.inputs)}", expected=expected, at="snapshot")
        held = self.hold(snapshot.inputs)
        # The snapshot's own, where they are as this component holds them: then going back to it again checks nothing.
        return snapshot.inputs if all(held[name] is value for name, value in snapshot.inputs.items()) else held

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle and `copy.deepcopy`: the parameters and the state. Observers stay with the original."""
        return _recreate, (type(self), self.parameters.model_dump(), self.save(), self.issued_cautions)

    def share_cautions(self, issued: IssuedCautions) -> None:
        """Issue no caution that is among these, which another component of this kind has issued, and add to them."""
        object.__setattr__(self, "issued_cautions", issued)

    def __copy__(self) -> Component:
        """Return an independent component: one that shares the state would step the original as well."""
        return copy.deepcopy(self)

    def _start_values(self, name: str, value: Any) -> FloatArray:
        variable = self.variables.get(name)
        if variable is None or not variable.state:
            known = [v.name for v in self.variables.values() if v.state]
            came = "an output, but not of the state" if variable is not None else "unknown"
            raise ParameterError(came, hint=nearest(name, known), at=("start", name), source=self._full_name)
        return start_array(("start", name), value, variable.shape)

    def declared(self) -> list[Variable]:
        """Return its own inputs and outputs: all variables but the parameters and the entries of balances."""
        return list(self._declare())

    def _all_variables(self) -> Iterable[Variable]:
        yield from parameter_variables(self.Parameters, self.parameters)
        yield from self._declare()


def _reader_of(view: np.ndarray) -> Callable[[], Any]:
    return (lambda: view) if view.ndim else lambda: float(view)


def refuse_unknown_events(kinds: Iterable[str], kind: Any, index: Any, source: str) -> None:
    """Raise `ParameterError` where events are asked for of a kind that cannot happen, or of what is no index."""
    known = list(kinds)
    if kind is not None and kind not in known:
        raise ParameterError(
            f"got {one_line(kind)}", expected="a kind of event", hint=nearest(str(kind), known), at="kind", source=source
        )
    if index is not None:
        whole_number("index", index, 0)


def _recreate(
    kind: type[Component], parameters: Mapping[str, Any], state: Snapshot, issued_cautions: IssuedCautions
) -> Component:
    """Return a component of these parameters in this state."""
    component = kind(**parameters)
    component.share_cautions(issued_cautions)
    component.restore(state)
    return component


def balance_variables(balance: Balance) -> Iterable[Variable]:
    """Yield an output variable for each entry of a balance."""
    kinds = (
        (balance.stored, "stored"),
        (balance.lost, "lost since the reset"),
        (balance.supplied, "supplied by inputs and boundaries since the reset"),
    )
    quantity = balance.quantity.replace("_", " ")
    for entries, what in kinds:
        for name, amount in entries.items():
            words = name.replace("_", " ")
            # A store is named after what it holds: kinetic energy, momentum.
            text = words if what == "stored" and quantity in words else f"{words}: {quantity} {what}"
            yield Variable(name, "output", balance.unit, np.shape(amount), text)
    added, given = (" + ".join(names) for names in ([*balance.stored, *balance.lost], balance.supplied))
    text = f"{added} - {quantity} at the reset{f' - ({given})' if given else ''}: the error of the numerics"
    yield Variable(f"{balance.quantity}_residual", "output", balance.unit, np.shape(balance.residual), text)


_DTYPES = {bool: "bool", int: "int64", str: "str"}


def parameter_variables(model: type[BaseModel], parameters: BaseModel | None = None) -> Iterable[Variable]:
    """Return the fields of a parameter model as variables: unit and shape come from each field's declaration."""
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        start = getattr(parameters, name) if parameters is not None else field.get_default()
        shape = np.shape(start) if isinstance(start, (list, tuple)) and all(isinstance(x, float) for x in start) else ()
        dtype = str(extra.get("dtype") or _DTYPES.get(type(start), "float64"))
        yield Variable(name, "parameter", str(extra.get("unit", "")), tuple(shape), field.description or "", dtype, start)
