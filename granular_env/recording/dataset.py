"""A log as an `xarray.Dataset`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..components.errors import LogError
from ..components.variables import Variable
from ..optional_packages import import_optional

if TYPE_CHECKING:
    from .log import Log


def make_dataset(log: Log) -> Any:
    """Return all frames of a log; see `Log.to_xarray`."""
    xarray = import_optional("xarray", "to_xarray")
    times, data = None, {}
    sizes: dict[str, int] = {}
    for name, variable in log.variables.items():
        own_times, values = log.series(name)
        times = own_times if times is None else times
        if not np.array_equal(times, own_times):
            came = f"the frames of {name!r} have other times than those of the preceding variables"
            raise LogError(came, hint="read each variable with series(name)", source=log.source)
        attributes = {"units": variable.unit, "description": variable.description}
        data[name] = (["time", *_dimension_names(variable, sizes, log.variables)], values, attributes)
    coordinates: dict[str, Any] = {name: (name, np.arange(size), {"units": "1"}) for name, size in sizes.items()}
    coordinates["time"] = ("time", np.zeros(0) if times is None else times, {"units": "s"})
    return xarray.Dataset(data, coordinates, {"component": str(log.header.get("component"))})


def _dimension_names(variable: Variable, sizes: dict[str, int], used_names: Iterable[str]) -> list[str]:
    """Return the names of a variable's dimensions (except time), and store their sizes in `sizes`.

    If another dimension of that name has another size, or a variable has the name, the name combines variable and axis.
    """
    names = []
    for axis, size in enumerate(variable.shape):
        name = variable.axes[axis] if variable.axes else f"{variable.name}_{axis}"
        if name in ("time", *used_names) or sizes.get(name, size) != size:
            name = f"{variable.name}_{axis}"
        sizes[name] = size
        names.append(name)
    return names
