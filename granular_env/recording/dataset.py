"""A log as an `xarray.Dataset` that can be drawn without this package: values, positions, connectivity, units, parameters."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..components.drawables import Cells, Curve, Links, Points
from ..components.errors import LogError
from ..components.variables import Variable
from ..documents import to_toml
from ..optional_packages import import_optional
from .element_arrays import cell_arrays, point_arrays
from .header import header_table, header_title

if TYPE_CHECKING:
    from .log import Log

# Names of the entries along an axis of a variable: of vectors, and of symmetric tensors by their number of entries.
_DIRECTIONS = ("x", "y", "z")
_TENSORS = {3: ("xx", "yy", "xy"), 4: ("xx", "yy", "zz", "xy"), 6: ("xx", "yy", "zz", "xy", "yz", "zx")}


def make_dataset(log: Log) -> Any:
    """Return all frames of a log; see `Log.to_xarray`."""
    times, values = np.zeros(0), {}
    for name in log.variables:
        own_times, values[name] = log.series(name)
        if len(values) == 1:
            times = own_times
        if not np.array_equal(times, own_times):
            came = f"the frames of {name!r} have other times than those of the preceding variables"
            raise LogError(came, hint="read each variable with series(name)", source=log.source)
    return assemble_dataset(log, list(log.variables), times, values)


def assemble_dataset(log: Log, names: Sequence[str], times: np.ndarray, values: Mapping[str, np.ndarray]) -> Any:
    """Return a dataset of some variables of a log with these times and values; without values it has no frames."""
    xarray = import_optional("xarray", "to_xarray")
    variables = {name: log.variables[name] for name in names}
    dimensions = _dimensions(variables, {name for one in log.balances for name in (*one.entries, one.residual)})
    data, coordinates = {}, {"time": ("time", times, {"units": "s", "description": "simulated time"})}
    for name, variable in variables.items():
        attributes = {"units": variable.unit, "description": variable.description}
        frames = values.get(name, np.zeros((0, *variable.shape)))
        data[name] = (["time", *dimensions[name]], frames, attributes)
        for dimension, size, axis in zip(dimensions[name], variable.shape, variable.axes or dimensions[name], strict=True):
            coordinates.setdefault(dimension, (dimension, _entry_names(axis, size), {}))
    for name, coordinate in _geometry(log, variables, dimensions):
        if name not in data:
            coordinates.setdefault(name, coordinate)
    return xarray.Dataset(data, coordinates, _attributes(log))


def _entry_names(axis: str, size: int) -> np.ndarray:
    """Return the names of the entries along an axis; numbers from 0 if they have no names."""
    if axis in ("entry", "component") and size in _TENSORS:
        return np.array(_TENSORS[size])
    return np.array(_DIRECTIONS[:size]) if axis == "direction" and size <= len(_DIRECTIONS) else np.arange(size)


def _dimensions(variables: Mapping[str, Variable], balanced: set[str]) -> dict[str, list[str]]:
    """Return the names of the dimensions of each variable except time: those of its axes.

    The entries of a vector in a balance, which has no names of axes, are those of a direction. If another dimension of that
    name has another size, or a variable has the name, the name combines variable and axis.
    """
    sizes: dict[str, int] = {}
    found: dict[str, list[str]] = {}
    for name, variable in variables.items():
        axes = variable.axes or (("direction",) if name in balanced and len(variable.shape) == 1 else ())
        found[name] = []
        for axis, size in enumerate(variable.shape):
            own = axes[axis] if axes else f"{name}_{axis}"
            if own in ("time", *variables) or own in found[name] or sizes.get(own, size) != size:
                own = f"{name}_{axis}"
            sizes[own] = size
            found[name].append(own)
    return found


def _geometry(
    log: Log, variables: Mapping[str, Variable], dimensions: Mapping[str, list[str]]
) -> Iterator[tuple[str, tuple[Any, np.ndarray, dict[str, Any]]]]:
    """Yield coordinates by name: initial positions and radii of points, centres and nodes of cells, points of links.

    The elements of a drawable have the dimension of its outputs or, if none is in the dataset, the drawable's name.
    """

    def dimension(names: list[str], default: str) -> str:
        return dimensions[names[0]][0] if names else default

    def positions(own: str, points: np.ndarray, what: str) -> Iterator[tuple[str, tuple[Any, np.ndarray, dict[str, Any]]]]:
        for direction, column in zip(_DIRECTIONS, points.reshape(len(points), -1).T, strict=False):
            yield f"{own}_{direction}", (own, column, {"units": "m", "description": what})

    of_points = {one.name: dimension(point_arrays(one, variables), one.name) for one in log.drawables}
    for one in log.drawables:
        own, cell = of_points[one.name], dimension(cell_arrays(one, variables), one.name)
        match one:
            case Points():
                yield from positions(own, one.reference, "initial position")
                yield f"{own}_radius", (own, one.radius, {"units": "m", "description": "radius"})
            case Cells():
                own = own if own != cell else f"{cell}_node"
                yield from positions(own, one.nodes, "initial position")
                yield from positions(cell, one.nodes[one.connectivity].mean(axis=1), "initial position of the centre")
                text = f"nodes of each cell in cyclic order, as indices of {own}"
                yield f"{cell}_nodes", ((cell, f"{cell}_vertex"), one.connectivity, {"units": "1", "description": text})
            case Curve():
                yield from positions(own, one.coordinate, "position")
            case Links():
                text = f"linked points, as indices of {of_points[one.points]}"
                yield f"{cell}_points", ((cell, "link_end"), one.pairs, {"units": "1", "description": text})


def _attributes(log: Log) -> dict[str, Any]:
    experiment = header_table(log.header.get("experiment"))
    return {
        "title": header_title(log.header),
        "component": str(log.header.get("component")),
        "experiment": to_toml(experiment) if experiment else "",
        "parameters": json.dumps(log.header.get("parameters")),
        "step_size": log.step_size,
        "versions": json.dumps(log.header.get("versions")),
        "created": str(log.header.get("created")),
    }
