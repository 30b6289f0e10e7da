"""The base class of all components: a physical system that can be reset, stepped, read, saved and restored."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import math
import sys
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

import numpy as np

from .balances import balance_variables
from .drawables import element_count
from .errors import ParameterError, StepError, one_line, spelling_hint
from .events import MOST_INDEX, Event, EventDetail, decode_events, event_list_field, renumber_kinds
from .inputs import Held, input_value
from .number_arrays import start_array
from .snapshot import Snapshot
from .state_block import Block, Layout
from .stepping import Stepping
from .support.float_arrays import FloatArray
from .support.html_summary import html_summary
from .support.memory_limits import refuse_excess_memory
from .support.serialization import canonical_json
from .support.validation import validate_parameters
from .variables import Variable, parameter_variables

_LARGEST = sys.float_info.max


class Component(Stepping):
    """A physical system that can be reset, stepped, read, saved and restored.

    Variables are not settable attributes: parameters are fixed, inputs are given to `step`, start values to `reset`.
    """

    version: ClassVar[int] = 1
    """Version of the results; increased whenever the results for given parameters and inputs change by a bit."""

    # Parts stored in this component's memory: (part, prefix of its event kinds, its ticks per tick of this component).
    _included: tuple[tuple[Component, str, int], ...] = ()

    def __init__(self, *, memory: FloatArray | None = None, **parameters: Any) -> None:
        """Check the parameters, allocate everything once, and reset.

        Args:
            memory: array of a parent component: float64, C-ordered, as large as `memory` of a component with these
                parameters. It is overwritten and then stores the state.
            **parameters: fields of `Parameters`.

        Raises:
            ParameterError: a parameter is unknown, missing or out of range, or the component does not fit into memory.
        """
        self._given_memory = memory
        self.parameters = validate_parameters(self.Parameters, parameters, self._full_name)
        refuse_excess_memory(self.memory_needed(self.parameters), self._full_name)
        try:
            self._build_system()
        except MemoryError as error:
            came = f"a component of this size does not fit into memory: {error}"
            raise ParameterError(came, hint="reduce its size", source=self._full_name) from None
        # Parameters at their defaults are not hashed, so that adding a parameter later does not change existing identities.
        chosen = self.parameters.model_dump(mode="json", exclude_defaults=True)
        self.identity: str = hashlib.sha256(canonical_json([self.name, self.version, chosen])).hexdigest()
        variables = {v.name: v for v in (*parameter_variables(self.Parameters, self.parameters), *self._declare_variables())}
        self._inputs = {v.name: v for v in variables.values() if v.causality == "input"}
        self._bounds = {
            v.name: (max(v.minimum, -_LARGEST), min(v.maximum, _LARGEST)) for v in self._inputs.values() if v.shape == ()
        }
        self._tick_counts: dict[float | None, int] = {None: 1}
        self._bind_block()
        # The names of the balance entries come from a call of `balances`, which reads the state; it is zero at first.
        for balance in self.balances():
            for variable in balance_variables(balance):
                variables.setdefault(variable.name, variable)
        self.balance_names: tuple[str, ...] = tuple(name for balance in self.balances() for name in balance.entries)
        self.variables: dict[str, Variable] = variables
        self.reset()
        sizes, details = {one.name: element_count(one) for one in self.drawables()}, self.event_details
        counted = [sizes.get(details[kind].counts, 0) if kind in details else 0 for kind in self._own_event_kinds]
        # Range of the index of each kind of event: the smallest index, and one past the largest.
        self._index_limits: FloatArray = np.array([(0, size) if size else (-1, MOST_INDEX) for size in counted], np.float64)

    def __repr__(self) -> str:
        return f"<{self.name} at {self.time:.9g} s (tick {self.tick})>"

    def _repr_html_(self) -> str:
        facts = {"time": f"{self.time:.9g} s", "tick": self.tick, "step size": f"{self.step_size:.6g} s"}
        rows = (
            (one.name, one.causality, getattr(self.parameters, one.name, one.shape), one.unit, one.description)
            for one in self.variables.values()
        )
        return html_summary(f"component {self.name}", facts, ("name", "", "value or shape", "unit", "description"), rows)

    def __setattr__(self, name: str, value: Any) -> None:
        variables = self.__dict__.get("variables", {})
        if name in variables or (variables and name == "parameters"):
            hint = f"parameters are fixed; pass an input to step(duration, {name}=...), a start value to reset({name}=...)"
            raise ParameterError("cannot be set", hint=hint, at=name)
        object.__setattr__(self, name, value)

    @property
    def _full_name(self) -> str:
        return f"component {self.name!r}"

    # -- building, for `_build_system` -------------------------------------------------------------------------------------

    def _define_state(self, growing: Layout | None = None, **fields: tuple[Any, ...]) -> None:
        """Set `_block`, the state, in the memory of a parent if given; see `state_block.Block` and `Field`.

        If there are event kinds, the list `events` precedes the given lists. `restore` checks the ranges declared here.
        """
        lists = {**({"events": event_list_field(len(self.event_kinds))} if self.event_kinds else {}), **(growing or {})}
        words = sum(math.prod(field[1]) for field in fields.values()) + len(lists)
        self._block = Block(self._claim_memory((words,)), growing=lists, **fields)

    def _claim_memory(self, shape: tuple[int, ...]) -> FloatArray:
        """Return an array of zeros, in the memory that a parent component provides, or else in new memory."""
        memory = self._given_memory
        self._memory: FloatArray = np.zeros(shape) if memory is None else memory.reshape(shape)
        self._memory[...] = 0.0
        return self._memory

    def _include_part(self, part: Component, prefix: str, ticks: int = 1) -> None:
        """Add a part to the snapshots and events of this component; call it in `_build_system`, after `_define_state`.

        The lists of the part then belong to this component's snapshots. Its events become events of this component, of the
        kinds `<prefix>_<kind>`.

        Args:
            part: component built in the memory of this component's block.
            prefix: prefix of its event kinds.
            ticks: internal steps of the part per internal step of this component.
        """
        self._block.include_part(part._block)
        self._included = (*self._included, (part, prefix, ticks))
        kinds = {f"{prefix}_{kind}": f"{prefix}: {text}" for kind, text in part.event_kinds.items()}
        details = {
            f"{prefix}_{kind}": dataclasses.replace(detail, ratio=detail.ratio and f"{prefix}_{detail.ratio}")
            for kind, detail in part.event_details.items()
        }
        self._declare_events({**self.event_kinds, **kinds}, {**self.event_details, **details})

    def _declare_events(self, kinds: Mapping[str, str], details: Mapping[str, EventDetail]) -> None:
        """Set `event_kinds` and `event_details` of this instance; call it in `_build_system`, before `_define_state`."""
        vars(self).update(event_kinds=kinds, event_details=details)

    def _bind_block(self) -> None:
        """Set the attributes of this instance that depend on `_block`, the memory of its state."""
        parts = {v.name: self._block.views.get(v.name) for v in self.declared_variables() if v.causality == "output"}
        views = {name: _view_reader(part) for name, part in parts.items() if part is not None}
        self._readers: dict[str, Callable[[], Any]] = views | self._output_readers()
        self._initialise_stepping()
        for part, *_ in self._included:
            part._owner = self

    def clone(self, memory: FloatArray | None = None) -> Self:
        """Return a new component with the same parameters, in the memory of a parent if given."""
        return type(self)(memory=memory, **self.parameters.model_dump())

    def declared_variables(self) -> list[Variable]:
        """Return the inputs and outputs: all variables except parameters and balance entries."""
        return list(self._declare_variables())

    # -- start ------------------------------------------------------------------------------------------------------

    def reset(self, *, seed: int | None = None, **start: Any) -> None:
        """Return to tick 0, independent of the past.

        Args:
            seed: for components that draw random numbers.
            **start: start values of state variables: a number for all, an array, one row for all, or {index: value or row}.

        Raises:
            ParameterError: an unknown variable, a wrong shape, or a value that is not finite; the state is unchanged.
        """
        if seed is not None and (isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or not 0 <= seed < 2**64):
            raise ParameterError(f"got {one_line(seed)}", expected="a whole number from 0 to 2^64 - 1, or None", at="seed")
        if self._busy or self._owner is not None:
            self._refuse_busy_call("reset")
        values = {name: self._start_values(name, value) for name, value in start.items()}
        before, tick = self._block.to_bytes(), self._tick
        self._block.clear()
        self._tick, self._busy = 0, True
        try:
            with np.errstate(all="ignore"):  # non-finite values are refused
                given = self._write_start_state(seed, values)
                if start:
                    self._refuse_infinite_balances()
            starts = {name: 0.0 if variable.start is None else variable.start for name, variable in self._inputs.items()}
            held = self.checked_inputs({**starts, **given})
        except BaseException:
            self._block.load_bytes(before)
            self._tick = tick
            raise
        finally:
            self._busy = False
        self._hold_inputs(held)
        for observer in self._observers:
            observer.on_reset(self)

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        for name, value in values.items():
            self._block.views[name][...] = value
        return {}

    def _start_values(self, name: str, value: Any) -> FloatArray:
        variable = self.variables.get(name)
        if variable is None or not variable.state:
            known = [v.name for v in self.variables.values() if v.state]
            came = "it is an output, but not part of the state" if variable is not None else "unknown"
            raise ParameterError(came, hint=spelling_hint(name, known), at=("start", name), source=self._full_name)
        return start_array(("start", name), value, variable.shape)

    def _refuse_infinite_balances(self) -> None:
        for balance in self.balances():
            for name, amount in balance.entries.items():
                if not np.isfinite(amount).all():
                    came = f"these values give a {name} of {one_line(amount)} {balance.unit}"
                    raise ParameterError(came, expected="a finite amount", hint="give smaller values", at="start")

    # -- reading ----------------------------------------------------------------------------------------------------

    def get(self, name: str) -> Any:
        """Return the present value of any variable: a number, or a new array of its shape."""
        value = self._read_variable(name)
        if value.__class__ is np.ndarray and (value.base is not None or not value.flags.writeable):
            return value.copy()
        return value

    def peek(self, name: str) -> Any:
        """Return the value without a copy: a read-only array may be the component's memory, valid until the next step."""
        value = self._read_variable(name)
        if value.__class__ is np.ndarray:
            value = value.view()
            value.flags.writeable = False
        return value

    def _read_variable(self, name: str) -> Any:
        reader = self._readers.get(name) if isinstance(name, str) else None
        if reader is not None:
            return reader()
        variable = self.variables.get(name) if isinstance(name, str) else None
        if variable is None:
            hint = spelling_hint(name, self.variables)
            expected = f"the name of a variable of {self._full_name}"
            raise ParameterError(f"got {one_line(name)}", expected=expected, hint=hint, at="variable")
        if variable.causality == "input":
            return input_value(self._held[name], self._tick)
        if variable.causality == "parameter":
            return copy.deepcopy(getattr(self.parameters, name))
        return self.balance_values()[name]

    def balance_values(self) -> dict[str, Any]:
        """Return all balance entries by name, including the residuals."""
        return {name: amount for balance in self.balances() for name, amount in balance.entries.items()}

    def _excess_error(self, variable: str, unit: str, size: FloatArray, limit: float, advice: str) -> StepError:
        """Return the error for the first element of `size` above `limit` or NaN; `advice` explains the limit and what to do."""
        index = int(np.argmin(size <= limit))
        return StepError(
            f"reached {size[index]:g} {unit} soon after {self.time:g} s, expected at most {limit:g} {unit}, {advice}",
            time=self.time, at=(variable, index), variable=variable, index=index, value=float(size[index]), limit=limit,
        )  # fmt: skip

    # -- events -----------------------------------------------------------------------------------------------------

    def events(self, kind: str | None = None, index: int | None = None) -> list[Event]:
        """Return the events since the reset, in the order of time.

        Args:
            kind: return only this kind; see `event_kinds`.
            index: return only events of this link, grain, ...

        Raises:
            ParameterError: there is no such kind, or the index is not valid.
        """
        return decode_events(self.event_rows(), self.event_kinds, kind, index, self._full_name)

    @property
    def event_count(self) -> int:
        """Return the number of events since the reset."""
        return self._block.count("events") + sum(part.event_count for part, _, _ in self._included)

    def event_rows(self, since: int = 0) -> FloatArray:
        """Return a copy of the events from number `since` on, in rows as described in `events.event_list_field`.

        Kinds are numbered in alphabetical order, as in the headers of logs; the state numbers them in the order of
        `event_kinds`. Events are sorted by tick; within a tick, own events precede those of the first part. Later events
        therefore follow all earlier ones, whichever part they belong to.
        """
        own = self._block["events"].copy() if self._block.count("events") else np.zeros((0, 5))
        tables = [renumber_kinds(own, self._own_event_kinds, self.event_kinds)]
        for part, prefix, ticks in self._included:
            rows = part.event_rows()
            rows[:, 0] = np.ceil(rows[:, 0] / ticks)
            tables.append(renumber_kinds(rows, [f"{prefix}_{kind}" for kind in sorted(part.event_kinds)], self.event_kinds))
        if len(tables) == 1:
            return own[since:]
        found = np.concatenate(tables)
        return found[np.argsort(found[:, 0], kind="stable")][since:]

    @property
    def _own_event_kinds(self) -> list[str]:
        """Event kinds that this component itself records, without those of included parts."""
        names = list(self.event_kinds)
        return names[: len(names) - sum(len(part.event_kinds) for part, _, _ in self._included)]

    def _add_event(self, tick: int, kind: str, index: int | None, value: float, limit: float) -> None:
        """Record an event; `tick` is the number at the end of the internal step in which it happened."""
        number = list(self.event_kinds).index(kind)
        self._block.append("events", (tick, number, -1 if index is None else index, value, limit))

    # -- snapshots --------------------------------------------------------------------------------------------------

    @property
    def memory(self) -> FloatArray:
        """Memory of the state and of the other arrays of the kernels; do not write to it."""
        return self._memory

    @property
    def state_bytes(self) -> int:
        """Present size of the state [bytes]."""
        return self._block.nbytes

    @property
    def cost_per_tick(self) -> int:
        """Number of state words that a tick advances (each part counts once per step), a measure of cost on any machine.

        A word costs some nanoseconds; a component whose words cost far less or more scales the number.
        """
        parts = sum(steps * part.cost_per_tick - part.state_bytes // 8 for part, _, steps in self._included)
        return self.state_bytes // 8 + parts

    def wake(self) -> None:
        """End a state in which steps are cheap because parts are skipped, so that timed steps are typical of a run."""

    def save(self) -> Snapshot:
        """Return a snapshot, i.e. a copy of the whole state."""
        return Snapshot(self.identity, self._tick, self._block.to_bytes(), self._held, True)

    def state_view(self) -> memoryview:
        """Return the bytes of the state, as `save` would copy them; valid until the next step."""
        block = self._block
        return memoryview(block.to_bytes()) if block.grows else block.memory_bytes.toreadonly()

    def restore(self, snapshot: Snapshot) -> None:
        """Continue from a snapshot with bitwise identical results, in whichever process it was taken.

        Raises:
            ParameterError: the snapshot belongs to a component with other parameters, another name or another version, or its
                state is outside the ranges that the component declares.
        """
        if self._busy or self._owner is not None:
            self._refuse_busy_call("restore")
        if (
            snapshot.__class__ is not Snapshot
            or snapshot.identity != self.identity
            or snapshot.inputs is not self._held
            or not snapshot.is_checked
        ):
            self.refuse_foreign_snapshot(snapshot)
            self._hold_inputs(self._snapshot_inputs(snapshot))
        self._block.load_bytes(snapshot.data)
        own: dict[str, Any] = self.__dict__  # type: ignore[assignment] - as in `step`
        own["_tick"] = snapshot.tick
        for observer in self._observers:
            observer.on_reset(self)

    def refuse_foreign_snapshot(self, snapshot: Snapshot) -> None:
        """Raise the error that `restore` would raise for this snapshot; change nothing."""
        if snapshot.__class__ is not Snapshot:
            expected = "a snapshot from save() or Snapshot.from_bytes()"
            raise ParameterError(f"got {one_line(snapshot)}", expected=expected, at="snapshot")
        if snapshot.identity != self.identity:
            raise ParameterError(
                f"got a snapshot of a component with identity {str(snapshot.identity)[:12]}...",
                expected=f"{self.identity[:12]}..., the identity of this {self._full_name}",
                hint="restore it into a component with the same parameters and version",
                at="snapshot",
            )
        if self._block.list_sizes(snapshot.data) is None:
            came = f"got a state of {len(snapshot.data)} bytes, with inconsistent sizes"
            raise ParameterError(came, expected=f"a state of this {self._full_name}", at="snapshot")
        if not snapshot.is_checked:
            self._refuse_invalid_state(self._block, snapshot.data, snapshot.tick, ("snapshot",))
            snapshot.is_checked = True
        if snapshot.inputs is not self._held:
            self._snapshot_inputs(snapshot)

    def _refuse_invalid_state(self, block: Block, data: bytes, tick: int, at: tuple[str, ...]) -> None:
        """Refuse a state in which an array of this component or of a part is outside the ranges that kernels rely on."""
        state = block.state_arrays(data, self._block)
        self._block.refuse_out_of_range(state, at)
        if self._own_event_kinds and len(events := state["events"]):
            ticks, kinds, indices = events.T[:3]
            first, beyond = self._index_limits[kinds.astype(np.int64)].T
            if not ((indices >= first) & (indices < beyond) & (np.diff(ticks, append=tick) >= 0.0)).all():
                expected = f"events with indices of existing elements, and ticks that do not decrease, up to {tick}"
                raise ParameterError("got invalid events", expected=expected, at=(*at, "events"))
        if fault := self._state_contradiction(state):
            raise ParameterError(fault, hint="save() never returns such a state", at=at)
        for part, prefix, part_ticks in self._included:
            part._refuse_invalid_state(block, data, tick * part_ticks, (*at, prefix))

    def _state_contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        """Describe an inconsistency between the read-only arrays of a state to be restored, each in its range; "" if none."""
        return ""

    def _snapshot_inputs(self, snapshot: Snapshot) -> Mapping[str, Held]:
        if snapshot.inputs.keys() != self._inputs.keys():
            expected = f"the inputs of this {self._full_name}, {sorted(self._inputs)}"
            raise ParameterError(f"got a snapshot with the inputs {sorted(snapshot.inputs)}", expected=expected, at="snapshot")
        held = self.checked_inputs(snapshot.inputs)
        # Keep the snapshot's own mapping of inputs if its values are unchanged: the next restore then skips the checks.
        return snapshot.inputs if all(held[name] is value for name, value in snapshot.inputs.items()) else held

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle and `copy.deepcopy` with the parameters and the state. Observers stay with the original."""
        return _recreate_component, (type(self), self.parameters.model_dump(), self.save())

    def __copy__(self) -> Component:
        """Return an independent component: with a shared state, stepping the copy would step the original too."""
        return copy.deepcopy(self)


def _view_reader(view: np.ndarray) -> Callable[[], Any]:
    return (lambda: view) if view.ndim else lambda: float(view)


def _recreate_component(kind: type[Component], parameters: Mapping[str, Any], state: Snapshot) -> Component:
    component = kind(**parameters)
    component.restore(state)
    return component
