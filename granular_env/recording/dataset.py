"""A log as an `xarray.Dataset` that can be drawn without this package: values, positions, connectivity, units, parameters."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..components.drawables import Cells, Curve, Links, Points
from ..components.errors import LogError
from ..components.variables import DIRECTIONS, entry_names
from ..documents import to_toml
from ..optional_packages import import_optional
from .element_arrays import element_arrays, listed_positions
from .header import header_table, header_title

if TYPE_CHECKING:
    from .log import Log


def make_dataset(log: Log) -> Any:
    """Return all frames of a log; see `Log.to_xarray`."""
    series = {name: log.series(name) for name in log.variables}
    times = next((own for own, _ in series.values()), np.zeros(0))
    for name, (own, _) in series.items():
        if not np.array_equal(times, own):
            came = f"the frames of {name!r} have other times than those of the preceding variables"
            raise LogError(came, hint="read each variable with series(name)", source=log.source)
    return assemble_dataset(log, times, {name: values for name, (_, values) in series.items()})


def assemble_dataset(log: Log, times: np.ndarray, values: Mapping[str, np.ndarray]) -> Any:
    """Return a dataset of some variables of a log with these times and values."""
    xarray = import_optional("xarray", "to_xarray")
    dimensions, data = _dimensions(log), {}
    coordinates: dict[str, Any] = {"time": ("time", times, {"units": "s", "description": "simulated time"})}
    for name, frames in values.items():
        variable, own = log.variables[name], dimensions[name]
        data[name] = (["time", *own], frames, {"units": variable.unit, "description": variable.description})
        for dimension, size, axis in zip(own, variable.shape, variable.axes or own, strict=True):
            coordinates.setdefault(dimension, (dimension, np.array(entry_names(axis, size) or range(size))))
    for name, dimension, content, unit, description in _geometry(log, dimensions):
        if name not in log.variables:
            coordinates.setdefault(name, (dimension, content, {"units": unit, "description": description}))
    experiment, facts = header_table(log.header.get("experiment")), log.header
    attributes = {
        "title": header_title(facts), "component": str(facts.get("component")), "step_size": log.step_size,
        "experiment": to_toml(experiment) if experiment else "", "created": str(facts.get("created")),
        **{name: json.dumps(facts.get(name)) for name in ("parameters", "versions")},
    }  # fmt: skip
    return xarray.Dataset(data, coordinates, attributes)


def _dimensions(log: Log) -> dict[str, list[str]]:
    """Return the names of the dimensions of each variable except time: its axes; for vectors in a balance, the direction.

    If another dimension of that name has another size, or a variable has the name, the name combines variable and axis.
    """
    balanced = {name for one in log.balances for name in (*one.entries, one.residual)}
    sizes: dict[str, int] = {}
    found: dict[str, list[str]] = {}
    for name, variable in log.variables.items():
        axes = variable.axes or (("direction",) if name in balanced and len(variable.shape) == 1 else ())
        found[name] = []
        for axis, size in enumerate(variable.shape):
            own = axes[axis].replace(" ", "_") if axes else ""
            if own in ("", "time", *log.variables, *found[name]) or sizes.get(own, size) != size:
                own = f"{name}_{axis}"
            sizes[own] = size
            found[name].append(own)
    return found


def _geometry(log: Log, dimensions: Mapping[str, list[str]]) -> Iterator[tuple[str, Any, np.ndarray, str, str]]:
    """Yield coordinates: name, dimensions, content, unit, description.

    The elements of a drawable have the dimension of its recorded outputs or, if none is recorded, the drawable's name.
    """

    def positions(own: str, points: np.ndarray, what: str) -> Iterator[tuple[str, Any, np.ndarray, str, str]]:
        for direction, column in zip(DIRECTIONS, points.reshape(len(points), -1).T, strict=False):
            yield f"{own}_{direction}", own, column, "m", what

    of_points: dict[str, str] = {}
    for name, variable in log.variables.items():
        if (points := listed_positions(header_table(log.header.get("parameters")), variable)) is not None:
            yield from positions(dimensions[name][0], points, "position")
    for one in log.drawables:
        own, cell = (
            dimensions[names[0]][0] if names else one.name.replace(" ", "_") for names in element_arrays(one, log.variables)
        )
        of_points[one.name] = own
        match one:
            case Points():
                yield from positions(own, one.reference, "initial position")
                yield f"{own}_radius", own, one.radius, "m", "radius"
            case Cells():
                own = own if own != cell else f"{cell}_node"
                yield from positions(own, one.nodes, "initial position")
                yield from positions(cell, one.nodes[one.connectivity].mean(axis=1), "initial position of the centre")
                text = f"nodes of each cell in cyclic order, as indices of {own}"
                yield f"{cell}_nodes", (cell, f"{cell}_vertex"), one.connectivity, "1", text
            case Curve():
                yield from positions(own, one.coordinate, "position")
            case Links():
                text = f"linked points, as indices of {of_points[one.points]}"
                yield f"{cell}_points", (cell, "link_end"), one.pairs, "1", text
