"""Names and initial positions of the elements of a variable (grains, nodes, receivers), for legends."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.components.drawables import Cells, Curve, element_positions
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import DIRECTIONS, Variable, entry_names
from granular_env.recording.element_arrays import element_arrays, listed_positions

from .unit_labels import scaled_unit


def vector_names(shape: tuple[int, ...], axes: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the entries of an array that is a single vector or symmetric tensor; () for any other array."""
    return entry_names(axes[0] if axes else "direction", shape[0]) if len(shape) == 1 else ()


def variable_positions(log: Any, variable: Variable) -> FloatArray | None:
    """Return the initial positions of the elements along a variable's first axis, shape (n, d) [m]; None if unknown.

    They are those of a drawable with this axis, or the parameter named after it, such as `receivers`.
    """
    if not variable.axes:
        return None
    variables = {**log.variables, variable.name: variable}
    # Curves first: a coordinate says more than the centres of cells along a tube.
    for drawable in sorted(log.drawables, key=lambda one: not isinstance(one, Curve)):
        of_points, of_cells = element_arrays(drawable, variables)
        if variable.name in of_points and isinstance(drawable, Cells):
            return drawable.nodes
        if variable.name in (*of_points, *of_cells):
            return element_positions(drawable, log.drawables)
    return listed_positions(log.metadata["parameters"], variable)


def place_name(place: str, number: int, positions: FloatArray | None) -> str:
    """Return the name of one of the places with the given positions: "node 2010, x = 0.1 m, y = 0.2 m"."""
    if positions is None:
        return f"{place} {number}"
    factor, unit = scaled_unit("m", float(np.abs(positions).max()))
    # Rounding errors of zero are 0, not -0.
    values = [round(factor * float(value), 6) + 0.0 for value in positions[number]]
    own = (f"{axis} = {value:.4g} {unit}" for axis, value in zip(DIRECTIONS, values, strict=False))
    return ", ".join([f"{place} {number}", *own])


def element_label(variable: Variable, index: tuple[int, ...], positions: FloatArray | None) -> str:
    """Return an element of a variable as text for legends: "force y, node 3, x = 0.1 m, y = 0.2 m"."""
    axes, words = variable.axes, variable.name.replace("_", " ")
    if names := vector_names(variable.shape, axes) or (len(index) == 2 and vector_names(variable.shape[1:], axes[1:])):
        words, index = f"{words} {names[index[-1]]}", index[:-1]
    if not index:
        return words
    number, *others = index
    return ", ".join([words, place_name(place_noun(variable), number, positions), *map(str, others)])


def place_noun(variable: Variable) -> str:
    """Return the name of a single element along a variable's first axis, such as "grain"; "element" without axes."""
    return variable.axes[0].replace("_", " ") if variable.axes else "element"
