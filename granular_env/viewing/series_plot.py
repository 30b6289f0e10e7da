"""One call that returns a matplotlib figure of a recorded variable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from granular_env.components.errors import ParameterError

from . import figures
from .fields import field_names, load_field
from .report_figures import FRAMES
from .scene_data import curves_of, input_curve_of

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
        figure.savefig("force.pdf")              # or let a notebook show it: it is the value of the cell

    Args:
        log: an open log.
        variable: a recorded output, or an input. Of a scalar its course in time is drawn, whatever the kind.
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
        field = load_field(log, variable, FRAMES)
        if kind == "profiles":
            return figures.profiles(field, times)
        return figures.histories(field, indices) if kind == "histories" else figures.space_time(field)
    scalars = [name for name, one in log.variables.items() if one.shape == () and len(log.times(name))]
    if variable in scalars:
        return figures.curves(list(curves_of(log, variable)))
    if variable in log.inputs and len(log.inputs[variable][0]):
        return figures.curves([input_curve_of(log, variable)])
    known = ", ".join([*field_names(log), *scalars, *log.inputs])
    raise ParameterError(f"{variable!r} was not recorded", hint=f"this log holds {known}", at="variable")
