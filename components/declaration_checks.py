"""Checks of what the author of a component declares: when one is built, so that a slip is told there and by name."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from .balances import Balance
from .errors import Location, ParameterError, nearest, one_line
from .events import EventDetail
from .state_block import Block
from .variables import Variable

_NAME = re.compile(r"[a-z][a-z0-9_]*")
# What `step` and `reset` take beside inputs and start values.
_TAKEN = {"input": "duration", "output": "seed"}


def validate_step_size(step_size: object) -> None:
    """Raise `ParameterError` where `_build` left no step that time could go on by."""
    if not (isinstance(step_size, (int, float)) and math.isfinite(step_size) and step_size > 0.0):
        raise ParameterError(
            f"got {step_size!r}", expected="more than 0 and finite, in seconds, set by `_build`", at="step_size"
        )


def validate_variables(
    declared: Sequence[Variable],
    parameters: Collection[str],
    block: Block,
    outputs: Collection[str],
    entries: Collection[str],
    starts_itself: bool,
) -> None:
    """Check the inputs and outputs of a component: their fields, and that each output can be read as it is declared.

    Args:
        declared: what `_declare` gave.
        parameters: their names.
        block: the state.
        outputs: names of those that `_outputs` gave a way to read of.
        entries: names of the entries of balances.
        starts_itself: whether the component has a `_start` of its own, which may set what is no part of the block.

    Raises:
        ParameterError: something does not fit.
    """
    names = [variable.name for variable in declared]
    for place, variable in enumerate(declared):
        _validate_fields(variable)
        if variable.name in names[:place]:
            raise _fault(variable.name, "declared twice", "each name once")
        if variable.name in parameters and variable.causality != "parameter":
            raise _fault(variable.name, "a parameter has this name", "another one")
        if variable.causality == "parameter" and variable.name not in parameters:
            raise _fault(variable.name, "got the causality 'parameter'", "a field of the class of parameters of that name")
        if variable.causality == "output":
            view = block.views.get(variable.name)
            if variable.name not in outputs:
                _validate_part(variable, view, variable.name in entries, [*block.views, *outputs])
            if variable.state and view is None and not starts_itself:
                raise _fault(variable.name, "it is no part of the state that is laid out", "one, or a `_start` that sets it")
    for name in outputs:
        if name not in names and name not in entries:
            raise _fault(name, "`_outputs` gives it, `_declare` does not", "each output declared", nearest(name, names))


def _validate_part(variable: Variable, view: np.ndarray | None, is_entry: bool, known: Collection[str]) -> None:
    """Check an output that `_outputs` does not give: a part of the state of that name, or an entry of a balance."""
    if view is not None and view.shape != variable.shape:
        raise _fault(variable.name, f"got the shape {variable.shape}", f"{view.shape}, as its part of the state has")
    if view is None and not is_entry:
        hint = f"let `_outputs` give it, or lay out a part of the state of that name; {nearest(variable.name, known)}"
        raise _fault(variable.name, "nothing says how to read it", "a way to read each output", hint)


def _validate_fields(variable: Variable) -> None:
    name = variable.name
    if not _NAME.fullmatch(name):
        raise _fault(name, "this is its name", "small letters, digits and underscores, a letter first")
    if variable.causality not in ("parameter", "input", "output"):
        raise _fault(name, f"got the causality {variable.causality!r}", "'input' or 'output'")
    if name == _TAKEN.get(variable.causality) and (variable.causality == "input" or variable.state):
        raise _fault(name, "`step` and `reset` take an argument of that name", "another name")
    if not variable.description:
        raise _fault(name, "got no description", "some words on what it is")
    if variable.dtype != "float64" and variable.causality != "parameter":
        raise _fault(name, f"got the dtype {variable.dtype!r}", "'float64', which all inputs and outputs have")
    if not variable.unit:
        raise _fault(name, "got no unit", "such as 'm/s', or '1' for a plain number")
    if not isinstance(variable.shape, tuple) or not all(isinstance(size, int) and size >= 0 for size in variable.shape):
        raise _fault(name, f"got the shape {variable.shape}", "a tuple of whole numbers")
    if variable.axes and len(variable.axes) != len(variable.shape):
        raise _fault(name, f"got the axes {variable.axes}", f"a name for each index of the shape {variable.shape}, or none")
    if not variable.minimum <= variable.maximum:
        raise _fault(name, f"got values from {variable.minimum:g} to {variable.maximum:g}", "the smaller one first")


def validate_balances(balances: object) -> None:
    """Check that what `balances` gave can be added up.

    Raises:
        ParameterError: something does not fit.
    """
    if not isinstance(balances, tuple) or not all(isinstance(one, Balance) for one in balances):
        raise ParameterError(f"got {one_line(balances)}", expected="a tuple of `Balance`", at="balances")
    quantities = [one.quantity for one in balances]
    for place, one in enumerate(balances):
        if one.quantity in quantities[:place]:
            raise ParameterError("given twice", expected="each quantity once", at=("balances", one.quantity))
        amounts = {**one.stored, **one.supplied, **one.lost}
        shapes = {name: np.shape(amount) for name, amount in amounts.items()}
        for name, shape in shapes.items():
            first = next(iter(shapes.values()))
            if shape != first or len(shape) > 1:
                expected = f"{first}, as the other entries, a number or a vector"
                raise ParameterError(f"got the shape {shape}", expected=expected, at=("balances", one.quantity, name))


def validate_events(
    kinds: Sequence[str],
    own: Sequence[str],
    details: Mapping[str, EventDetail],
    block: Block,
    drawn: Collection[str],
    outputs: Collection[str],
) -> None:
    """Check the kinds of events, where they are noted, and what is said of them.

    Args:
        kinds: all, those of included parts too.
        own: those that this component notes itself.
        details: of some or all of them.
        block: the state.
        drawn: names of the drawables.
        outputs: names of the outputs.

    Raises:
        ParameterError: something does not fit.
    """
    if own and (not block.has_list("events") or block["events"].shape[1:] != (5,)):
        layout = "`_lay_out` makes one for the kinds that are declared before it is called"
        raise ParameterError(
            f"got {', '.join(own)}", expected="a list of the state to note them in", hint=layout, at="event_kinds"
        )
    for kind, detail in details.items():
        at = ("event_details", kind)
        if kind not in kinds:
            raise ParameterError("there is no such kind", expected="one of `event_kinds`", hint=nearest(kind, kinds), at=at)
        if kind not in own:  # a parent need not draw all that its parts draw
            continue
        if detail.counts and detail.counts not in drawn:
            hint = nearest(detail.counts, drawn)
            raise ParameterError(f"got {detail.counts!r}", expected="the name of a drawable", hint=hint, at=(*at, "counts"))
        if detail.ratio and detail.ratio not in outputs:
            hint = nearest(detail.ratio, outputs)
            raise ParameterError(f"got {detail.ratio!r}", expected="the name of an output", hint=hint, at=(*at, "ratio"))


def _fault(name: str, received: str, expected: str, hint: str = "") -> ParameterError:
    at: Location = ("variables", name)
    return ParameterError(received, expected=expected, hint=hint, at=at)
