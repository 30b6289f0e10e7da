"""`plot`: a figure of a recorded variable, an input or a balance of one log, or of several logs in the same axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from granular_env.components.drawables import drawn_outputs, to_three_columns
from granular_env.components.errors import GranularError, ParameterError
from granular_env.components.support.validation import finite_number
from granular_env.components.variables import Variable
from granular_env.domains import find_domain

from ..curves import MOST_CURVES, Curve, component_names, load_input_curves
from ..places import place_name
from ..recorded_fields import Field, curve_names, load_curves, load_fields, recorded_outputs, validity_limit
from ..scene_builder import load_scene, log_title, require_log
from ..visible_drawables import colouring_outputs, is_plane, is_plane_filling, visible_cells, visible_points
from .plane import draw_plane, load_plane
from .run_figures import FRAMES, default_indices, draw_balance, draw_curve_panels, draw_fields, place_column
from .spectra import Element, draw_dispersion, draw_spectra

# Kinds that draw several logs in the same axes, that use `at`, and that use `indices`.
_OVERLAID, _AT_TIMES, _OF_ELEMENTS = ("histories", "profiles", "spectrum"), ("profiles", "map"), ("histories", "spectrum")


def plot(
    log: Any,
    name: str,
    kind: str | None = None,
    *,
    at: float | Sequence[float] | None = None,
    indices: Sequence[int] | None = None,
) -> Figure:
    """Return a figure of a recorded variable, an input or a balance of a log.

        figure = ge.viewing.plot(log, "contact_force", "histories", indices=[10, 20])
        figure.savefig("force.pdf")              # or .png, .svg; a notebook shows the figure that a cell returns

    | kind | shows |
    |---|---|
    | "space-time" | an array along a row: values as colours over place and time (x-t diagram) |
    | "profiles" | an array along a row at times |
    | "histories" | scalars, or elements of an array, over time |
    | "map" | a body in a plane or in space at times: deformed, coloured by the variable |
    | "spectrum" | one-sided amplitude spectrum of scalars or elements |
    | "dispersion" | magnitude over wave number and frequency of an array along a row, with the curves of theory |
    | "balances" | all entries of a balance, such as "energy", and its residual |

    Args:
        log: an open log, or several, whose histories, profiles and spectra are drawn in the same axes.
        name: a recorded output, an input, or the quantity of a balance.
        kind: one of the kinds above; default: map for values of a body in a plane or in space, space-time along a row,
            histories for scalars and up to six elements. Components of vectors are drawn one above the other.
        at: time or times of profiles and maps [s]; default: four, evenly spaced, or with the first event for maps.
        indices: elements of histories and spectra; default: up to five that changed.

    Returns:
        A figure outside pyplot; its axes (`figure.axes`) have physical units and may be changed.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: a log does not contain the variable, a time or an index, or the kind does not apply to the variable.
    """
    logs = list(log) if isinstance(log, (list, tuple)) else [log]
    for one in logs:
        require_log(one)
    kind = _choose_kind(logs, name, kind)
    for argument, given, kinds in (("at", at, _AT_TIMES), ("indices", indices, _OF_ELEMENTS)):
        if given is not None and kind not in kinds:
            raise ParameterError(f"does not apply to {kind}", expected=f"kind={' or '.join(map(repr, kinds))}", at=argument)
    times = None if at is None else [finite_number("at", time) for time in np.atleast_1d(np.asarray(at, object)).tolist()]
    if kind == "balances":
        return _draw_balance(logs[0], name)
    if kind == "spectrum":
        return draw_spectra(list(_spectrum_elements(logs, name, indices)), len(logs))
    if kind == "dispersion":
        return draw_dispersion(logs[0], name, component_names(logs[0].variables[name]), _dispersion_curves(logs[0]))
    try:
        if kind == "map":
            return _draw_map(logs[0], name, times)
        until = min(validity_limit(one)[0] for one in logs)
        if kind == "histories" and _is_drawn_as_curves(_find_variable(logs[0], name)):
            return draw_curve_panels(list(_load_run_curves(logs, name)), until)
        return draw_fields(list(_load_run_fields(logs, name)), kind, times, indices, until)
    except ParameterError as error:
        raise error.with_argument("times", "at") from None


def _choose_kind(logs: Sequence[Any], name: str, kind: str | None) -> str:
    """Return the kind of the figure, by default the first that applies; raise `ParameterError` if it does not apply."""
    if not logs:
        raise ParameterError("got no log", expected="an open log, or several", at="log")
    known = [_applicable_kinds(log, name) for log in logs]
    if len({getattr(_find_variable(log, name), "unit", "") for log in logs}) > 1:
        raise ParameterError(f"{name!r} has different units in the logs", hint="draw one figure for each log", at="log")
    kinds = [one for one in known[0] if all(one in own for own in known) and (len(logs) == 1 or one in _OVERLAID)]
    if kind is None and kinds:
        return kinds[0]
    if kind not in kinds:
        several = " of several logs" if len(logs) > 1 else ""
        expected = f"one of {', '.join(kinds)}, which apply to {name!r}{several}" if kinds else f"no plot of {name!r}{several}"
        raise ParameterError(f"got {kind!r}", expected=expected, at="kind")
    return kind


def _find_variable(log: Any, name: str) -> Variable | None:
    return recorded_outputs(log).get(name) or log.input_variables.get(name)


def _applicable_kinds(log: Any, name: str) -> list[str]:
    """Return the kinds of figure of a variable or balance, the default first; `ParameterError` if the log lacks it."""
    variable, recorded = _find_variable(log, name), recorded_outputs(log)
    balances = ["balances"] if _find_balance(log, name) else []
    if variable is None:
        if not balances:
            known = ", ".join(dict.fromkeys([*recorded, *log.input_variables, *(one.quantity for one in log.balances)]))
            raise ParameterError(f"{name!r} was not recorded", hint=f"this log contains {known}", at="name")
        return balances
    spectrum = ["spectrum"] if name in recorded else []
    if _is_drawn_as_curves(variable):
        return ["histories", *spectrum, *balances]
    is_few, is_row = prod(variable.shape) <= MOST_CURVES, not is_plane_filling(log.drawables, variable.shape[0])
    along_row = ["space-time", "profiles"] if is_row else []
    body = ["map"] if _is_mapped(log, name) else []
    kinds = ["histories", *along_row, *body] if is_few else [*along_row, *body, "histories"]
    return [*kinds, *spectrum, *(["dispersion"] if is_row and spectrum and not is_few else []), *balances]


def _is_drawn_as_curves(variable: Variable | None) -> bool:
    if variable is None or variable.causality == "input":
        return variable is not None and prod(variable.shape) <= MOST_CURVES
    return bool(curve_names(variable))


def _is_mapped(log: Any, name: str) -> bool:
    """Return whether an output colours, moves or breaks a body in a plane or in space."""
    bodies = [(one, one.reference) for one in visible_points(log.drawables)]
    bodies += [(one, one.nodes) for one in visible_cells(log.drawables)]
    if not any(is_plane(to_three_columns(rest), log.variables.get(one.displacement)) for one, rest in bodies):
        return False
    drawn = [one for one, _ in bodies]
    return name in colouring_outputs(drawn, recorded_outputs(log)) or name in drawn_outputs(log.drawables)


def _draw_map(log: Any, name: str, times: Sequence[float] | None) -> Figure:
    drawn = [*visible_points(log.drawables), *visible_cells(log.drawables)]
    colour = name if name in colouring_outputs(drawn, recorded_outputs(log)) else None
    plane = load_plane(log, load_scene(log), times, colour)
    if plane is None:
        raise ParameterError(f"the shapes that {name!r} colours or moves were not recorded", at="name")
    return draw_plane(plane)


def _find_balance(log: Any, name: str) -> str:
    """Return the quantity of the balance with this quantity or entry; "" if there is none."""
    return next((one.quantity for one in log.balances if name in (one.quantity, one.residual, *one.entries)), "")


def _draw_balance(log: Any, name: str) -> Figure:
    # Balances need no frames of the shapes.
    figure = draw_balance(load_scene(log, frames=2), quantity := _find_balance(log, name))
    if figure is None:
        raise ParameterError(f"all entries of the balance of {quantity} are 0", at="name")
    return figure


def _run_names(logs: Sequence[Any]) -> list[str]:
    """Return a name for each log: none for a single one, else the titles or, if some are equal, the names of the files."""
    if len(logs) == 1:
        return [""]
    titles = [log_title(log) for log in logs]
    stems = [Path(str(log.path)).stem for log in logs]
    return next((names for names in (titles, stems) if len(set(names)) == len(logs)), [str(log.path) for log in logs])


def _load_run_curves(logs: Sequence[Any], name: str) -> Iterator[Curve]:
    for log, run in zip(logs, _run_names(logs), strict=True):
        if name in recorded_outputs(log):
            found = list(load_curves(log, name))
        elif (acted := load_input_curves(log, name)) is None:
            raise ParameterError("the log contains no step", at="log")
        else:
            found = list(acted.curves)
        for curve in found:
            label = curve.label or curve.name.replace("_", " ")
            yield replace(curve, label=f"{run}: {label}" if run else curve.label)


def _load_run_fields(logs: Sequence[Any], name: str) -> Iterator[Field]:
    for log, run in zip(logs, _run_names(logs), strict=True):
        fields = load_fields(log, name, FRAMES)
        if name not in recorded_outputs(log):  # omit the components of an input that are always 0
            fields = [one for one in fields if one.values.any()] or fields[:1]
        yield from (replace(one, run=run) for one in fields)


def _spectrum_elements(logs: Sequence[Any], name: str, indices: Sequence[int] | None) -> Iterator[Element]:
    """Yield the elements whose spectra are drawn, those of equal index next to each other."""
    runs = list(enumerate(zip(logs, _run_names(logs), strict=True)))
    if names := curve_names(logs[0].variables[name]):
        for number, one in enumerate(names):
            for place, (log, run) in runs:
                yield Element(log, name, number, ": ".join(filter(None, [run, one.replace("_", " ")])), place, name)
        return
    fields = [load_fields(log, name, FRAMES) for log in logs]
    for component, field in enumerate(fields[0]):
        for index in default_indices(fields[0][0]) if indices is None else indices:
            for place, (log, run) in runs:
                own = fields[place][component]
                place_column(own, index)  # refuses unknown indices
                number = index % own.total
                label = ": ".join(filter(None, [run, place_name(own.place, number, own.positions)]))
                yield Element(log, name, number * len(fields[place]) + component, label, place, field.variable.name)


def _dispersion_curves(log: Any) -> Callable[[Any], Any] | None:
    """Return the function of the domain that computes the theory's dispersion curves; None if there is none."""
    curves = find_domain(str(log.metadata.get("component"))).load_attribute("dispersion")
    try:
        return None if curves is None else partial(curves, log.new_component())
    except GranularError:
        return None
