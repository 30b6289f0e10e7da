"""A report of a run: one HTML page that needs nothing else, and its pictures as PNG files."""

from __future__ import annotations

import json
import math
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.components.errors import LogError, ParameterError
from granular_env.writing import require_writable, with_article, write_files

from . import figures, page
from .events import told_events
from .footage import ENERGIES, MOMENTA, RESIDUALS, Footage, from_log
from .plots import plots

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Frames that the figures use: more than a viewer, they are only drawn once.
_FRAMES = 2000
_LONGEST_LIST = 8
_PAGE = "report.html"


def report(
    log: Any, folder: str | os.PathLike[str], times: Sequence[float] | None = None, grains: Sequence[int] | None = None
) -> Path:
    """Write ``report.html`` and the PNG files of its figures.

    The page carries its pictures and its style, runs no script and is forbidden the network by its own policy; text from
    the log is escaped.

    Args:
        log: an open log, of any component.
        folder: where to; made if it is not there.
        times: instants of the profiles [s]; default: four, evenly spaced.
        grains: whose histories to draw; default: up to five that the wave reached.

    Returns:
        The path of the page.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: an instant or a grain that the log does not have, or `folder` is a file; nothing is written.
        GranularError: the files cannot be written; then none of them is.
    """
    if os.path.lexists(folder) and not os.path.isdir(folder):
        raise ParameterError(f"{os.fspath(folder)!r} is a file, expected a folder; the report's pages and pictures go into it")
    require_writable(Path(folder) / _PAGE)
    footage = from_log(log, _FRAMES)
    drawn = _drawn(footage, times, grains)
    pictures = {name: figures.png(figure) for name, (figure, _) in drawn.items()}
    shown = {name: page.picture(pictures[name], description) for name, (_, description) in drawn.items()}
    html = page.page(f"Run report: {footage.title}", _lead(log, footage), _sections(log, footage, shown))
    return _written(Path(folder), html, pictures)


def _written(folder: Path, html: str, pictures: Mapping[str, bytes]) -> Path:
    target = folder / _PAGE
    write_files({**{folder / f"{name}.png": data for name, data in pictures.items()}, target: html.encode("utf-8")})
    return target


# -- pictures -------------------------------------------------------------------------------------------------------------


def _drawn(footage: Footage, times: Sequence[float] | None, grains: Sequence[int] | None) -> dict[str, tuple[Figure, str]]:
    """File name -> figure and description, in the order of the page."""
    motion = footage.motion
    if (times is not None or grains is not None) and (motion is None or motion.colour is None):
        raise ParameterError("times, grains: this log holds no motion of particles; leave them out")
    drawn: dict[str, tuple[Figure, str]] = {}
    if motion is not None and motion.colour is not None:
        name = motion.colour_variable.name.replace("_", " ")
        right = "red is to the right, blue to the left"
        drawn["space-time"] = (
            figures.space_time(motion),
            f"{name.capitalize()} of every grain (across) at every instant (up); {right}.",
        )
        drawn["profiles"] = figures.profiles(motion, times), f"{name.capitalize()} along the chain at chosen instants."
        drawn["histories"] = figures.histories(motion, grains), f"{name.capitalize()} of chosen grains in time."
    ledger = figures.ledger(footage)
    if ledger is not None:
        drawn["ledger"] = (
            ledger,
            "Energies since the reset, and the energy that the ledger cannot account for: the error of the numerics.",
        )
    for title in ("inputs", "outputs"):
        curves = [
            curve for plot in plots(footage) if plot.group == title for curve in plot.curves if np.any(curve.values != 0.0)
        ]
        if curves:
            drawn[title] = figures.curves(curves), f"{title.capitalize()} in time; those that stay 0 are left out."
    return drawn


# -- sections -------------------------------------------------------------------------------------------------------------

_HEADINGS = {
    "space-time": "x-t diagram",
    "profiles": "Profiles at chosen times",
    "histories": "Histories of chosen grains",
    "outputs": "Outputs",
    "inputs": "Inputs",
}


def _sections(log: Any, footage: Footage, shown: Mapping[str, str]) -> list[tuple[str, str]]:
    found = [(heading, shown[name]) for name, heading in _HEADINGS.items() if name in shown]
    found.append(("Ledger", _ledger(footage) + shown.get("ledger", "")))
    builders: dict[str, Callable[[Any], str]] = {
        "Validity": _validity,
        "Parameters": _parameters,
        "Environment": _environment,
        "Replay it": _replay,
    }
    return [*found, *((heading, build(log)) for heading, build in builders.items())]


def _lead(log: Any, footage: Footage) -> str:
    scale, unit = figures.time_unit(log.duration)
    metadata = log.metadata
    calls = "1 call" if log.calls == 1 else f"{log.calls} calls"
    what = f"{log.duration * scale:.6g} {unit} of {with_article(metadata.get('component'))}, in {calls} of step()"
    notes = [*told_events(log), *footage.notes]
    return page.paragraph(f"{what}; recorded {metadata.get('created')}.", "dim") + (
        page.bullets(notes, "cautions") if notes else ""
    )


def _ledger(footage: Footage) -> str:
    names = [name for name in (*ENERGIES, *RESIDUALS, *MOMENTA) if name in footage.curves and len(footage.curves[name].values)]
    if not names:
        return page.paragraph("The ledger was not recorded.")
    rows = []
    for name in names:
        curve = footage.curves[name]
        first, last, largest = float(curve.values[0]), float(curve.values[-1]), float(np.abs(curve.values).max())
        rows.append([name.replace("_", " "), curve.unit, first, last, largest])
    return page.table(["entry", "unit", "start", "end", "largest magnitude"], rows) + page.paragraph(_closure(footage))


def _closure(footage: Footage) -> str:
    """How well the energies add up, in one sentence."""
    residual = footage.curves.get("energy_residual")
    scale = max((float(np.abs(footage.curves[name].values).max()) for name in ENERGIES if name in footage.curves), default=0.0)
    if residual is None or scale == 0.0:
        return "The residual is what the ledger cannot account for: the error of the numerics."
    worst = float(np.abs(residual.values).max())
    return f"The ledger closes to {worst / scale:.2g} of the largest energy; what is left over is the error of the numerics."


def _validity(log: Any) -> str:
    metadata = log.metadata
    figures_of_run, cautions = metadata.get("report") or {}, metadata.get("cautions") or []
    parts = []
    if figures_of_run:
        rows = [[name, _number(value)] for name, value in figures_of_run.items()]
        parts.append(page.table(["figure", "value"], rows))
    else:
        parts.append(
            page.paragraph("The component reports no figures of validity, or the run was interrupted before it could.")
        )
    parts.append(page.bullets(cautions, "cautions") if cautions else page.paragraph("No cautions."))
    return "".join(parts)


def _number(value: Any) -> Any:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value) if math.isfinite(value) else "unknown"
    return "unknown" if value is None else value


def _parameters(log: Any) -> str:
    metadata = log.metadata
    units = _units(metadata.get("component"))
    rows = [[name, _short(value), units.get(name, "")] for name, value in (metadata.get("parameters") or {}).items()]
    parts = [page.table(["parameter", "value", "unit"], [*rows, ["step_size (as run)", _short(log.step_size), "s"]])]
    if metadata.get("experiment"):
        experiment = json.dumps(metadata["experiment"], indent=2, ensure_ascii=False)
        parts += [page.paragraph("The experiment, as it was run:"), page.preformatted(experiment[:20_000])]
    return "".join(parts)


def _units(component: Any) -> dict[str, str]:
    """Units of the parameters of a component of ours; a log makes us load no other."""
    from granular_env.recording.build import own_or_given

    try:
        fields = own_or_given(component, None).Parameters.model_fields
    except LogError:
        return {}
    extras = {name: field.json_schema_extra for name, field in fields.items()}
    return {name: str(extra.get("unit", "")) for name, extra in extras.items() if isinstance(extra, dict)}


def _short(value: Any) -> str:
    if isinstance(value, list) and len(value) > _LONGEST_LIST:
        if all(entry == value[0] for entry in value):
            return f"{_short(value[0])} ({len(value)} times)"
        return f"{', '.join(str(_short(entry)) for entry in value[:_LONGEST_LIST])}, ... ({len(value)} values)"
    if isinstance(value, dict):
        return ", ".join(f"{key} = {_short(entry)}" for key, entry in value.items())
    return f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value)


def _environment(log: Any) -> str:
    metadata = log.metadata
    rows = [[f"{name} version", text] for name, text in (metadata.get("versions") or {}).items()]
    rows += [[name.replace("_", " "), _short(value)] for name, value in (metadata.get("machine") or {}).items()]
    rows.append(["bits depend on the platform", "yes" if metadata.get("platform_bound") else "no"])
    rows.append(["identity of component and parameters", metadata.get("identity", "")])
    return page.table(["fact", "value"], rows)


def _replay(log: Any) -> str:
    path = shlex.quote(str(log.path))
    middle = log.start_tick * log.step_size + (round(0.5 * log.duration / log.step_size)) * log.step_size
    commands = [
        f"granular-env replay {path} --verify      # re-run it and compare every recorded bit",
        f"granular-env branch {path} --at {middle:.12g}      # go on from there, with other inputs",
        f"granular-env view {path}      # look at it in rerun",
    ]
    return page.paragraph("The log is a program; these commands re-run it, branch it off and show it.") + page.preformatted(
        "\n".join(commands)
    )
