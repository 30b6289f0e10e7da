"""Recorded arrays with one value, vector or tensor per element of a drawable: per point, node, cell or link."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..components.drawables import Cells, Curve, Drawable, Links, Points
from ..components.variables import Variable

Variables = Mapping[str, Variable]


def point_arrays(drawable: Drawable, variables: Variables) -> list[str]:
    """Return the variables with one entry per center, node or sample of a drawable; its own outputs come first."""
    arrays = {Points: "radius", Cells: "nodes", Curve: "coordinate"}
    count = len(getattr(drawable, arrays.get(type(drawable), ""), ()))
    return _element_arrays(drawable, ("displacement", "rotation", "colour", "field"), count, variables)


def cell_arrays(drawable: Drawable, variables: Variables) -> list[str]:
    """Return the variables with one entry per cell or link of a drawable; its own outputs come first."""
    count = len(drawable.pairs) if isinstance(drawable, Links) else len(getattr(drawable, "connectivity", ()))
    of_points = point_arrays(drawable, variables)
    return [name for name in _element_arrays(drawable, ("state", "field", "force"), count, variables) if name not in of_points]


def _element_arrays(drawable: Drawable, roles: Iterable[str], count: int, variables: Variables) -> list[str]:
    """Return the variables with `count` entries along the axis of the drawable's outputs or, if none is recorded, any axis."""
    fitting = {name: one for name, one in variables.items() if count and one.shape[:1] == (count,)}
    own = [name for role in roles if (name := getattr(drawable, role, "")) in fitting]
    axes = {fitting[name].axes[:1] for name in own}
    return list(dict.fromkeys([*own, *(name for name, one in fitting.items() if not axes or one.axes[:1] in axes)]))
