"""Conversion of a component's drawables (the points, links, cells, curves that viewers draw) to and from a log's header."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..components.drawables import Cells, Curve, Drawable, Links, Points
from ..components.errors import Location
from ..components.variables import Variable
from .records import damage_error

_KINDS = {"points": Points, "links": Links, "cells": Cells, "curve": Curve}
# The dtype and the number of dimensions of each array of a drawable.
_ARRAYS = {
    "reference": (np.float64, 2), "radius": (np.float64, 1), "pairs": (np.int64, 2), "nodes": (np.float64, 2),
    "connectivity": (np.int64, 2), "coordinate": (np.float64, 1), "period": (np.float64, 1),
}  # fmt: skip
# Fields of a drawable that are optional, so they are written only if a drawable has them.
_OF_SOME = ((Cells, "state"), (Links, "force"), (Points, "period"))
# Largest accepted coordinate [m], so that squares of distances do not overflow.
_FARTHEST = 1e100
# The arrays with the positions of each kind of drawable; then, per output, the arrays one of which has a row per value.
_PLACES = {Points: ("reference", "radius"), Links: ("pairs",), Cells: ("nodes",), Curve: ("coordinate",)}
_COUNTED: dict[type[Drawable], dict[str, tuple[str, ...]]] = {
    Points: {"displacement": ("radius",), "colour": ("radius",), "rotation": ("radius",)},
    Links: {"state": ("pairs",), "force": ("pairs",)},
    Cells: {"displacement": ("nodes",), "field": ("nodes", "connectivity"), "state": ("connectivity",)},
    Curve: {"field": ("coordinate",)},
}


def drawable_facts(drawables: Iterable[Drawable]) -> tuple[list[dict[str, str]], dict[str, np.ndarray]]:
    """Return drawables as JSON values and arrays for the header; the array "1.radius" belongs to the second drawable."""
    facts, arrays = [], {}
    for place, drawable in enumerate(drawables):
        texts = {"kind": next(kind for kind, one in _KINDS.items() if type(drawable) is one)}
        for field in dataclasses.fields(drawable):
            value = getattr(drawable, field.name)
            if (type(drawable), field.name) in _OF_SOME and not len(value):
                continue
            if field.name in _ARRAYS:
                arrays[f"{place}.{field.name}"] = np.asarray(value, _ARRAYS[field.name][0])
            else:
                texts[field.name] = value
        facts.append(texts)
    return facts, arrays


def parse_drawables(facts: Any, arrays: Mapping[str, np.ndarray], variables: Mapping[str, Variable]) -> tuple[Drawable, ...]:
    """Return the drawables from the output of `drawable_facts`; `LogError` for anything else."""
    if not isinstance(facts, list):
        raise damage_error("the list of drawables is invalid", "header.drawables")
    found: list[Drawable] = []
    for place, texts in enumerate(facts):
        drawable = _parse_drawable(place, texts, arrays)
        if isinstance(drawable, Links) and not _has_ends(drawable, found):
            raise damage_error("it links points that do not exist", _fault_location(place, "pairs"))
        if (name := _unfit_output(drawable, variables)) is not None:
            raise damage_error(f"{name!r} has a wrong number of values", _fault_location(place))
        found.append(drawable)
    return tuple(found)


def _fault_location(number: int, *field: str) -> Location:
    return ("header", "drawables", number, *field)


def _parse_drawable(place: int, texts: Any, arrays: Mapping[str, np.ndarray]) -> Drawable:
    kind = _KINDS.get(str(texts.get("kind"))) if isinstance(texts, dict) else None
    if kind is None:
        raise damage_error("the kind of the drawable is unknown", _fault_location(place))
    values: dict[str, Any] = {}
    for field in dataclasses.fields(kind):
        name = f"{place}.{field.name}"
        value = arrays.get(name) if field.name in _ARRAYS else texts.get(field.name)
        if value is None and (kind, field.name) in _OF_SOME:
            continue
        if field.name in _ARRAYS:
            dtype, dimensions = _ARRAYS[field.name]
            sound = value is not None and value.dtype == dtype and value.ndim == dimensions
        else:
            sound = isinstance(value, str)
        if not sound:
            raise damage_error("it is missing or has a wrong type", _fault_location(place, field.name))
        values[field.name] = value
    drawable = kind(**values)
    if not _has_matching_shapes(drawable):
        raise damage_error("the shapes of its arrays do not match", _fault_location(place))
    return drawable


def _has_matching_shapes(drawable: Drawable) -> bool:
    arrays = [getattr(drawable, name) for name in _PLACES[type(drawable)]]
    if len({len(array) for array in arrays}) != 1 or not all((np.abs(array) < _FARTHEST).all() for array in arrays):
        return False
    if isinstance(drawable, Points):
        dimensions, period = drawable.reference.shape[1], drawable.period
        return 1 <= dimensions <= 3 and len(period) in (0, dimensions) and bool(((period >= 0.0) & (period < _FARTHEST)).all())
    if isinstance(drawable, Links):
        return drawable.pairs.shape[1] == 2
    if isinstance(drawable, Cells):
        inside = (drawable.connectivity >= 0) & (drawable.connectivity < len(drawable.nodes))
        return 1 <= drawable.nodes.shape[1] <= 3 and bool(inside.all())
    return True


def _unfit_output(drawable: Drawable, variables: Mapping[str, Variable]) -> str | None:
    """Return the first of a drawable's outputs whose number of values does not match the drawable; None if all match."""
    for role, counted in _COUNTED[type(drawable)].items():
        name = getattr(drawable, role)
        shape = variables[name].shape if name in variables else None
        if shape is None:
            continue
        # A displacement has up to three components; any other output has one number per element.
        is_vector = role == "displacement" and len(shape) == 2 and 1 <= shape[1] <= 3
        if not (len(shape) == 1 or is_vector) or shape[0] not in [len(getattr(drawable, one)) for one in counted]:
            return name
    return None


def _has_ends(links: Links, known: Iterable[Drawable]) -> bool:
    points = next((one for one in known if isinstance(one, Points) and one.name == links.points), None)
    return points is not None and bool(((links.pairs >= 0) & (links.pairs < len(points.radius))).all())
