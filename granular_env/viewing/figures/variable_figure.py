"""A figure of one recorded variable, by one call: x-t diagram, profiles or histories."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.components.errors import ParameterError

from ..curves import MOST_CURVES, load_elements, load_input
from ..recorded_fields import Field, curves_of, field_names, load_field, load_input_fields, load_vector_fields, vector_names
from . import run_figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_KINDS = ("space-time", "profiles", "histories")


def plot(
    log: Any,
    variable: str,
    kind: str = "space-time",
    *,
    times: Sequence[float] | None = None,
    indices: Sequence[int] | None = None,
) -> Figure:
    """Return a figure of a recorded variable or an input of a log.

        figure = ge.viewing.plot(log, "contact_force", "histories", indices=[10, 20])
        figure.savefig("force.pdf")              # a notebook shows it after %matplotlib inline

    Args:
        log: an open log.
        variable: a recorded output, or an input. Of a scalar, or an input of a few numbers, the course in time is drawn,
            whatever the kind; of vectors at many places each component, one above the other.
        kind: of an array: "space-time", "profiles" (at `times`) or "histories" (of `indices`).
        times: instants of the profiles [s]; default: four, evenly spaced.
        indices: of which elements; default: up to five that changed.

    Returns:
        A figure outside pyplot; `figure.axes` can be changed.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: the log does not hold this variable, an instant or an index, or there is no such kind.
    """
    if kind not in _KINDS:
        raise ParameterError(f"got {kind!r}", expected=f"one of {', '.join(_KINDS)}", at="kind")
    if variable in field_names(log):
        return _figure([load_field(log, variable, run_figures.FRAMES)], kind, times, indices)
    if variable in vector_names(log):
        return _figure(load_vector_fields(log, variable, run_figures.FRAMES), kind, times, indices)
    scalars = [name for name, one in log.variables.items() if one.shape == () and len(log.times(name))]
    if variable in scalars:
        return run_figures.curves(list(curves_of(log, variable)))
    acted = load_input(log, variable) if variable in log.input_variables else None
    if acted is not None:
        shape = acted.variable.shape
        if math.prod(shape) > MOST_CURVES:
            fields = load_input_fields(log, variable, run_figures.FRAMES)
            return _figure([one for one in fields if one.values.any()] or fields[:1], kind, times, indices)
        return run_figures.curves(load_elements(log, variable, np.ndindex(shape)) if shape else acted.curves)
    known = ", ".join([*field_names(log), *vector_names(log), *scalars, *log.input_variables])
    raise ParameterError(f"{variable!r} was not recorded", hint=f"this log holds {known}", at="variable")


def _figure(fields: Sequence[Field], kind: str, times: Sequence[float] | None, indices: Sequence[int] | None) -> Figure:
    """Return a figure of one field, or of several one above the other."""
    draw = {
        "space-time": run_figures.space_time,
        "profiles": lambda field, into=None: run_figures.profiles(field, times, into),
        "histories": lambda field, into=None: run_figures.histories(field, indices, into),
    }[kind]
    return draw(fields[0]) if len(fields) == 1 else run_figures.stack(fields, lambda field, into: draw(field, into=into))
