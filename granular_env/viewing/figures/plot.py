"""`plot`: a figure of a recorded variable, an input or a balance of one log, or of several logs in the same axes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import prod
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from granular_env.components.drawables import drawn_outputs
from granular_env.components.errors import GranularError, ParameterError
from granular_env.components.support.validation import finite_number
from granular_env.components.variables import Variable
from granular_env.domains import find_domain
from granular_env.recording.preview.visible_drawables import colouring_outputs, is_plane_filling, visible_cells, visible_points

from ..curves import MOST_CURVES, Curve, component_names, load_input_curves
from ..recorded_fields import Field, curve_names, load_curves, load_fields, recorded_outputs, validity_limit
from ..scene_builder import load_scene, log_title, require_log
from .overlays import overlay_drawables
from .plane import draw_plane, load_plane
from .run_figures import FRAMES, default_indices, draw_balance, draw_curve_panels, draw_fields, find_place
from .spectra import Spectrum, draw_dispersion, draw_spectra, load_spectra

# Kinds that draw several logs in the same axes, that use `at`, and that use `indices`.
_OVERLAID, _AT_TIMES, _OF_ELEMENTS = ("histories", "profiles", "spectrum"), ("profiles", "map"), ("histories", "spectrum")


def plot(
    log: Any,
    name: str,
    kind: str | None = None,
    *,
    at: float | Sequence[float] | None = None,
    indices: int | Sequence[int] | None = None,
    show: str | Sequence[str] = (),
) -> Figure:
    """Return a figure of a recorded variable, an input or a balance of a log.

        figure = ge.viewing.plot(log, "contact_force", "histories", indices=[10, 20])
        figure.savefig("force.pdf")              # or .png, .svg; a notebook shows the figure that a cell returns

    | kind | shows |
    |---|---|
    | "space-time" | an array along a row: values as colours over place and time (x-t diagram) |
    | "profiles" | an array along a row at times |
    | "histories" | scalars, or elements of an array, over time |
    | "map" | a deformed body at times: coloured by the variable, or with arrows, principal stresses or force chains |
    | "spectrum" | one-sided amplitude spectrum of scalars or elements |
    | "dispersion" | magnitude over wave number and frequency of an array along a row, with the curves of theory |
    | "balances" | all entries of a balance, such as "energy", and its residual |

    Args:
        log: an open log, or several, whose histories, profiles and spectra are drawn in the same axes.
        name: a recorded output, an input, or the quantity of a balance.
        kind: one of the kinds above; default: map for values of a body in a plane or in space, space-time along a row,
            histories for scalars and up to six elements. Components of vectors are drawn one above the other.
        at: time or times of profiles and maps [s]; default: four, evenly spaced, or with the first event for maps.
        indices: element or elements of histories and spectra; default: up to five that changed.
        show: further output or outputs drawn over a map: vectors, stresses, forces of links.

    Returns:
        A figure outside pyplot; its axes (`figure.axes`) have physical units and may be changed.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: a log does not contain the variable, a time or an index, or the kind does not apply to the variable.
    """
    logs = list(log) if isinstance(log, (list, tuple)) else [log]
    name = str(name)
    kind = _choose_kind(logs, name, kind)
    times, chosen = _given_values("at", at, kind, _AT_TIMES), _given_values("indices", indices, kind, _OF_ELEMENTS)
    over = _given_values("show", show or None, kind, ("map",)) or []
    if chosen and _is_drawn_as_curves(_find_variable(logs[0], name)):
        raise ParameterError(f"all elements of {name!r} are drawn", hint="omit it", at="indices")
    times = times and [finite_number("at", time) for time in times]
    try:
        return _draw_map(logs[0], name, times, over) if kind == "map" else _draw(logs, name, kind, times, chosen)
    except ParameterError as error:
        raise error.with_argument("times", "at") from None


def _given_values(argument: str, given: Any, kind: str, kinds: Sequence[str]) -> list[Any] | None:
    """Return the values of an argument as a list; raise `ParameterError` if there are none or the kind does not use them."""
    if given is None:
        return None
    if kind not in kinds:
        raise ParameterError(f"does not apply to {kind}", expected=f"kind={' or '.join(map(repr, kinds))}", at=argument)
    if not (values := np.atleast_1d(np.asarray(given, object)).tolist()):
        raise ParameterError("got no values", expected="one or more, or None for the default", at=argument)
    return values


def _draw(logs: Sequence[Any], name: str, kind: str, times: Sequence[float] | None, indices: Sequence[int] | None) -> Figure:
    log = logs[0]
    match kind:
        case "balances":
            # Balances need no frames of the shapes.
            figure = draw_balance(load_scene(log, frames=2), quantity := _find_balance(log, name))
            if figure is None:
                raise ParameterError(f"all entries of the balance of {quantity} are 0", at="name")
            return figure
        case "dispersion":
            return draw_dispersion(log, name, component_names(log.variables[name]), _dispersion_curves(log))
        case "spectrum":
            return draw_spectra(_load_spectra(logs, name, indices), len(logs))
    until = min(validity_limit(one)[0] for one in logs)
    if kind == "histories" and _is_drawn_as_curves(_find_variable(log, name)):
        return draw_curve_panels(list(_load_run_curves(logs, name)), until)
    fields = [field for own in _load_run_fields(logs, name) for field in own]
    return draw_fields(fields, kind, times, indices, until)


def _draw_map(log: Any, name: str, times: Sequence[float] | None, show: Sequence[str]) -> Figure:
    colour, own = name if name in _colouring_outputs(log) else None, [name] if name in overlay_drawables(log) else []
    plane = load_plane(log, load_scene(log), times, colour, list(dict.fromkeys([*own, *show])))
    if plane is None:
        raise ParameterError(f"the shapes that {name!r} colours or moves were not recorded", at="name")
    return draw_plane(plane)


def _choose_kind(logs: Sequence[Any], name: str, kind: str | None) -> str:
    """Return the kind of the figure, by default the first that applies; raise `ParameterError` if it does not apply."""
    for one in logs or [logs]:
        require_log(one)
    first, *others = [_applicable_kinds(log, name) for log in logs]
    kinds = [one for one in first if not others or (one in _OVERLAID and all(one in own for own in others))]
    if len({getattr(_find_variable(log, name), "unit", "") for log in logs}) > 1:
        raise ParameterError(f"{name!r} has different units in the logs", hint="draw one figure for each log", at="log")
    if not kinds:
        raise ParameterError(f"got {len(logs)} logs", expected=f"one log for {name!r}", at="log")
    if kind not in (None, *kinds):
        expected = f"one of {', '.join(kinds)} for {name!r}{' of several logs' if others else ''}"
        raise ParameterError(f"got {kind!r}", expected=expected, at="kind")
    return kind or kinds[0]


def _applicable_kinds(log: Any, name: str) -> list[str]:
    """Return the kinds of figure of a variable or balance, the default first; `ParameterError` if the log lacks it."""
    variable, recorded = _find_variable(log, name), recorded_outputs(log)
    balances = ["balances"] if _find_balance(log, name) else []
    if variable is None and not balances:
        known = ", ".join(dict.fromkeys([*recorded, *log.input_variables, *(one.quantity for one in log.balances)]))
        raise ParameterError(f"{name!r} was not recorded", hint=f"this log contains {known}", at="name")
    if variable is None:
        return balances
    spectrum = ["spectrum"] if name in recorded else []
    if _is_drawn_as_curves(variable):
        return ["histories", *spectrum, *balances]
    is_few, is_row = variable.shape[0] <= MOST_CURVES, not is_plane_filling(log.drawables, variable.shape[0])
    # Outputs that colour, move or break a body, or are drawn over it.
    mapped = [] if is_row else [*_colouring_outputs(log), *drawn_outputs(log.drawables), *overlay_drawables(log)]
    kinds = ["space-time", "profiles"] if is_row else ["map"] if name in mapped else []
    kinds = ["histories", *kinds] if is_few else [*kinds, "histories"]
    return [*kinds, *spectrum, *(["dispersion"] if is_row and spectrum and not is_few else []), *balances]


def _find_variable(log: Any, name: str) -> Variable | None:
    return recorded_outputs(log).get(name) or log.input_variables.get(name)


def _find_balance(log: Any, name: str) -> str:
    """Return the quantity of the balance with this quantity or entry; "" if there is none."""
    return next((one.quantity for one in log.balances if name in (one.quantity, one.residual, *one.entries)), "")


def _is_drawn_as_curves(variable: Variable | None) -> bool:
    """Return whether a variable is a scalar, a vector or an input of a few elements."""
    if variable is None or variable.causality == "input":
        return variable is not None and prod(variable.shape) <= MOST_CURVES
    return bool(curve_names(variable))


def _colouring_outputs(log: Any) -> list[str]:
    return colouring_outputs([*visible_points(log.drawables), *visible_cells(log.drawables)], recorded_outputs(log))


def _run_names(logs: Sequence[Any]) -> list[str]:
    """Return a name for each log: none for a single one, else the titles or, if some are equal, the names of the files."""
    titles, files = [log_title(log) for log in logs], [os.path.basename(log.path) for log in logs]
    return [""] if len(logs) == 1 else titles if len(set(titles)) == len(logs) else files


def _load_run_curves(logs: Sequence[Any], name: str) -> Iterator[Curve]:
    for log, run in zip(logs, _run_names(logs), strict=True):
        acted = load_input_curves(log, name) if name in log.input_variables else None
        for curve in load_curves(log, name) if acted is None else acted.curves:
            words = curve.label or curve.name.replace("_", " ")
            yield replace(curve, label=f"{run}: {words}" if run else curve.label)


def _load_run_fields(logs: Sequence[Any], name: str) -> list[list[Field]]:
    """Return the fields of each log: one for each vector component, without those of an input that are always 0."""
    found = []
    for log, run in zip(logs, _run_names(logs), strict=True):
        fields = [replace(one, run=run) for one in load_fields(log, name, FRAMES)]
        found.append([one for one in fields if one.variable.causality == "output" or one.values.any()] or fields[:1])
    return found


def _load_spectra(logs: Sequence[Any], name: str, indices: Sequence[int] | None) -> list[Spectrum]:
    """Return the spectra of the chosen elements; those of equal elements of all logs are neighbours."""
    names, found = curve_names(logs[0].variables[name]), []
    arrays = [[] for _ in logs] if names else _load_run_fields(logs, name)
    for log, run, fields in zip(logs, _run_names(logs), arrays, strict=True):
        chosen = {number: (name, f"{run}: {words}" if run else words) for number, words in enumerate(names)}
        for component, field in enumerate(fields):
            for place in [find_place(field, index) for index in (default_indices(field) if indices is None else indices)]:
                chosen[place * len(fields) + component] = field.variable.name, field.place_name(place)
        found.append(load_spectra(log, name, chosen))
    return [one for equal in zip(*found, strict=True) for one in equal]


def _dispersion_curves(log: Any) -> Callable[[Any], Any] | None:
    """Return the function of the domain that computes the theory's dispersion curves; None if there is none."""
    curves = find_domain(str(log.metadata.get("component"))).load_attribute("dispersion")
    try:
        return None if curves is None else partial(curves, log.new_component())
    except GranularError:
        return None
