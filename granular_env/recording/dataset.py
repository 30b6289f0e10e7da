"""A log as an `xarray.Dataset`."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from typing import Any

import numpy as np

from ..components.errors import LogError
from ..components.variables import Variable
from ..optional_packages import import_optional


def dataset_of(
    variables: Mapping[str, Variable], series: Callable[[str], tuple[np.ndarray, np.ndarray]], component: str, source: str
) -> Any:
    """Return all frames of a log; see `Log.to_xarray`.

    Args:
        variables: those recorded, by name.
        series: returns times and values of a variable.
        component: name of the component.
        source: name of the log in messages.
    """
    xarray = import_optional("xarray", "to_xarray")
    times, data = None, {}
    sizes: dict[str, int] = {}
    for name, variable in variables.items():
        own_times, values = series(name)
        times = own_times if times is None else times
        if not np.array_equal(times, own_times):
            came = f"the frames of {name!r} are at other times than those of the variables before it"
            raise LogError(came, hint="read each with series(name)", source=source)
        attributes = {"units": variable.unit, "description": variable.description}
        data[name] = (["time", *_dimensions(variable, sizes, variables)], values, attributes)
    coordinates: dict[str, Any] = {name: (name, np.arange(size), {"units": "1"}) for name, size in sizes.items()}
    coordinates["time"] = ("time", np.zeros(0) if times is None else times, {"units": "s"})
    return xarray.Dataset(data, coordinates, {"component": component})


def _dimensions(variable: Variable, sizes: dict[str, int], taken: Container[str]) -> list[str]:
    """Return the names of a variable's own dimensions, and note their sizes.

    One of another size, or with a name that is taken by a variable, gets a name of its own.
    """
    names = []
    for axis, size in enumerate(variable.shape):
        name = variable.axes[axis] if variable.axes else f"{variable.name}_{axis}"
        if name == "time" or name in taken or sizes.setdefault(name, size) != size:
            name = f"{variable.name}_{axis}"
            sizes[name] = size
        names.append(name)
    return names
