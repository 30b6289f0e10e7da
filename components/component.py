"""What every component is: a physical system that can be reset, stepped, read, saved and restored."""

from __future__ import annotations

import copy
import hashlib
import sys
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

import numpy as np
from pydantic import BaseModel

from .contract import Variable
from .errors import ParameterError, nearest, shortened
from .profiles import CompiledProfile
from .snapshot import FloatArray, Snapshot
from .stepping import Stepping
from .support.memory_limits import refuse_beyond
from .support.serialization import canonical_json
from .support.validation import filled, validated

_LARGEST = sys.float_info.max

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
        """Make what belongs to this one component alone, whose block is there."""
        self._readers: dict[str, Callable[[], Any]] = self._outputs()
        self._prepare_steps()

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

    # -- start, reading ---------------------------------------------------------------------------------------------

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

    # -- snapshots --------------------------------------------------------------------------------------------------

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

    def _check_inputs(self, snapshot: Snapshot) -> None:
        if snapshot.inputs.keys() != self._inputs.keys():
            raise ParameterError(
                f"snapshot: it holds the inputs {sorted(snapshot.inputs)}, this component has {sorted(self._inputs)}"
            )
        self._compiled(snapshot.inputs)

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle and `copy.deepcopy`: the parameters and the state. Observers stay with the original."""
        return _recreate, (type(self), self.parameters.model_dump(), self.save())

    def __copy__(self) -> Component:
        """Return an independent component: one that shares the state would step the original as well."""
        return copy.deepcopy(self)

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
