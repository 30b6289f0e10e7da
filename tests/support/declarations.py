"""Checks of a component's declarations; `test_conformance.py` calls `check_declarations` for every component."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np

from granular_env.components.component import Component
from granular_env.components.drawables import OUTPUT_FIELDS, Cells, Curve, Drawable, Links, Points
from granular_env.components.state_block import LARGEST
from granular_env.components.variables import Variable

# Output fields that each drawable must name, and the largest number of dimensions of these outputs.
_NEEDED = {Points: ("displacement",), Links: ("state",), Cells: ("field",), Curve: ("field",)}
_DIMENSIONS = {"colour": 1, "rotation": 1, "displacement": 2, "state": 1, "field": 1, "force": 1}


def check_declarations(component: Component) -> None:
    """Assert that step size, state, variables, balances, events and drawables of a component are consistent."""
    assert math.isfinite(component.step_size) and component.step_size > 0.0, "`_build_system` sets step_size, in seconds"
    for name, field in component._block.fields.items():
        assert field.dtype in ("f8", "i8", "u8"), f"{name}: 8 bytes"
        bounded = np.min(field.low) > -LARGEST and np.max(field.high) < LARGEST
        assert field.dtype == "f8" or bounded, f"{name}: integers need their smallest and largest value"
    _check_variables(component)
    _check_balances(component)
    _check_events(component)
    check_drawables(component.drawables(), component.variables)


def _check_variables(component: Component) -> None:
    declared, parameters, views = component.declared_variables(), component.Parameters.model_fields, component._block.views
    names, outputs = [variable.name for variable in declared], component._output_readers()
    assert len(set(names)) == len(names) and not set(names) & set(parameters), "each name once"
    for variable in declared:
        name = variable.name
        assert re.fullmatch(r"[a-z][a-z0-9_]*", name), f"{name}: lower_snake_case"
        assert variable.causality in ("input", "output"), name
        assert name != ("duration" if variable.causality == "input" else "seed"), f"{name}: an argument of step and reset"
        assert variable.description and variable.unit and variable.dtype == "float64", name
        assert all(type(size) is int and size >= 0 for size in variable.shape), name
        assert len(variable.axes) in (0, len(variable.shape)) and variable.minimum <= variable.maximum, name
        if variable.causality == "output":
            assert np.shape(component.get(name)) == variable.shape, f"{name}: the declared shape"
            starts_itself = type(component)._write_start_state is not Component._write_start_state
            assert not variable.state or name in views or starts_itself, (
                f"{name}: part of the state, or set by `_write_start_state`"
            )
    assert set(outputs) <= {*names, *component.balance_names}, "each output of `_output_readers` is declared"


def _check_balances(component: Component) -> None:
    balances = component.balances()
    assert isinstance(balances, tuple) and len({one.quantity for one in balances}) == len(balances)
    for one in balances:
        assert one.stored and len({np.shape(amount) for amount in one.entries.values()}) == 1, one.quantity
        for name, amount in one.entries.items():
            known = component.variables[name]
            assert (known.causality, known.unit, known.shape) == ("output", one.unit, np.shape(amount)), name
            assert np.array_equal(component.get(name), amount), f"{name}: an entry of a balance and another output"


def _check_events(component: Component) -> None:
    own, drawn = component._own_event_kinds, {one.name for one in component.drawables()}
    assert not own or component._block["events"].shape[1:] == (5,), "declare kinds of events before `_define_state`"
    assert set(component.event_details) <= set(component.event_kinds)
    for kind in own:
        detail = component.event_details.get(kind)
        if detail is not None:
            assert not detail.counts or detail.counts in drawn, kind
            assert not detail.ratio or component.variables[detail.ratio].causality == "output", kind


def check_drawables(drawables: tuple[Drawable, ...], variables: Mapping[str, Variable]) -> None:
    """Assert that the arrays of drawables are consistent with the outputs that they name."""
    points = {one.name: len(one.reference) for one in drawables if isinstance(one, Points)}
    assert len({one.name for one in drawables}) == len(drawables)
    for one in drawables:
        counts = _check_arrays(one, points)
        for role in OUTPUT_FIELDS:
            name = getattr(one, role, "")
            if name or role in _NEEDED[type(one)]:
                shape = variables[name].shape
                assert variables[name].causality == "output" and shape[0] in counts.get(role, counts[""]), (one.name, role)
                assert len(shape) <= _DIMENSIONS[role] and shape[1:] <= (3,), (one.name, role)


def _check_arrays(one: Drawable, points: Mapping[str, int]) -> dict[str, tuple[int, ...]]:
    """Return field -> valid lengths of the output named by a drawable; the key "" is for all other fields."""
    match one:
        case Points():
            _check_places(one.reference)
            assert one.radius.shape == (len(one.reference),) and (one.radius >= 0.0).all() and np.isfinite(one.radius).all()
            assert one.period.shape in ((0,), one.reference.shape[1:]) and (one.period >= 0.0).all()
            return {"": (len(one.reference),)}
        case Links():
            _check_indices(one.pairs, points[one.points])
            assert one.pairs.shape[1] == 2
            return {"": (len(one.pairs),)}
        case Cells():
            _check_places(one.nodes)
            _check_indices(one.connectivity, len(one.nodes))
            cells, nodes = len(one.connectivity), len(one.nodes)
            assert cells
            return {"field": (cells, nodes), "state": (cells,), "": (nodes,)}
        case Curve():
            assert np.isfinite(one.coordinate).all()
            return {"": (len(one.coordinate),)}


def _check_places(places: np.ndarray) -> None:
    assert places.ndim == 2 and len(places) and places.shape[1] in (1, 2, 3) and np.isfinite(places).all()


def _check_indices(indices: np.ndarray, count: int) -> None:
    assert indices.ndim == 2 and np.issubdtype(indices.dtype, np.integer)
    assert not indices.size or (indices.min() >= 0 and indices.max() < count)
