"""Recorded arrays with one value, vector or tensor per element of a drawable: per point, node, cell or link."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..components.drawables import Cells, Curve, Drawable, Points, element_count
from ..components.support.float_arrays import FloatArray
from ..components.variables import DIRECTIONS, Variable


def element_arrays(drawable: Drawable, variables: Mapping[str, Variable]) -> tuple[list[str], list[str]]:
    """Return the variables per center, node or sample of a drawable, and those per cell or link; its own outputs come first."""

    def find(count: int, roles: Iterable[str]) -> list[str]:
        # Other variables need the axis of the drawable's outputs or, if none is recorded, any axis.
        fitting = {name: one for name, one in variables.items() if count and one.shape[:1] == (count,)}
        own = [name for role in roles if (name := getattr(drawable, role, "")) in fitting]
        axes = {fitting[name].axes[:1] for name in own}
        return list(dict.fromkeys([*own, *(name for name, one in fitting.items() if not axes or one.axes[:1] in axes)]))

    arrays = {Points: "radius", Cells: "nodes", Curve: "coordinate"}
    points = len(getattr(drawable, arrays.get(type(drawable), ""), ()))
    cells = 0 if isinstance(drawable, Points) else element_count(drawable)
    of_points = find(points, ("displacement", "rotation", "colour", "field"))
    return of_points, [name for name in find(cells, ("state", "field", "force")) if name not in of_points]


def listed_positions(parameters: Mapping[str, Any], variable: Variable) -> FloatArray | None:
    """Return the positions in a parameter named after a variable's first axis, shape (n, d) [m]; None if there is none.

    This is `receivers` for "receiver" and `gas.gauges` for "gas gauge". Of gauges only x is known: their second number may be
    an angle. Receivers may be numbers of nodes, which are no positions.
    """
    axis, size = (*variable.axes, "")[0], (*variable.shape, 0)[0]
    tables = {"": parameters, **{name: one for name, one in parameters.items() if isinstance(one, Mapping)}}
    lists = [(part, name, one) for part, table in tables.items() for name, one in table.items() if isinstance(one, list)]
    for part, name, places in lists:
        is_named = axis in (name[:-1], f"{part} {name[:-1]}")
        if is_named and len(places) == size and all(isinstance(one, float | list) for one in places):
            return np.array([np.ravel(one) for one in places])[:, : 1 if name == "gauges" else len(DIRECTIONS)]
    return None
