"""Grouping of a run's scalar curves into plots; the curves of a plot have the same unit."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .curves import Curve
from .scene_data import SceneData


@dataclass(frozen=True)
class Plot:
    """The curves of one plot, which have the same unit; `group` is the folder of their paths in a rerun scene."""

    title: str
    group: str
    curves: tuple[Curve, ...]


def make_plots(scene_data: SceneData) -> list[Plot]:
    """Return all plots of the scalars in scene data: energy first, curves that are always zero last."""
    balances, known = list[Plot](), set[str]()
    for balance in scene_data.balances:
        words = balance.quantity.replace("_", " ").capitalize()
        residuals = [name for name in scene_data.curves if name.startswith(balance.residual)]
        known |= {*balance.entries, *residuals}
        balances.append(Plot(f"{words} [{balance.unit}]", balance.quantity, _changing_curves(scene_data, balance.entries)))
        curves = _changing_curves(scene_data, residuals)
        # The title states the largest residual, because the axis of such small values has a single label, which shows no scale.
        largest = max((np.abs(curve.values).max() for curve in curves if len(curve.values) > 1), default=0.0)
        title = f"{words} residual [{balance.unit}]: numerical error"
        balances.append(Plot(f"{title}; at most {largest:.2g}" if largest else title, balance.residual, curves))
    outputs = [curve for name, curve in scene_data.curves.items() if name not in known]
    found = [*balances[:2], *_unit_plots("Inputs", scene_data.inputs.values()), *_unit_plots("Outputs", outputs), *balances[2:]]
    return sorted((plot for plot in found if plot.curves), key=_is_quiet)


def select_plots(scene_data: SceneData, max_count: int) -> list[Plot]:
    """Return the plots to be shown in a pane: at most `max_count`, and none whose curves are always zero in a finished run."""
    return [plot for plot in make_plots(scene_data) if not _is_quiet(plot) or len(plot.curves[0].values) < 2][:max_count]


def _unit_plots(title: str, curves: Iterable[Curve]) -> list[Plot]:
    curves = list(curves)
    units = list(dict.fromkeys(curve.unit for curve in curves))
    return [Plot(f"{title} [{unit}]", title.lower(), tuple(curve for curve in curves if curve.unit == unit)) for unit in units]


def _changing_curves(scene_data: SceneData, names: Iterable[str]) -> tuple[Curve, ...]:
    """Return those curves `names` of a balance that are not always zero or have a single sample (the start of a live run)."""
    found = (scene_data.curves[name] for name in names if name in scene_data.curves)
    return tuple(one for one in found if len(one.values) < 2 or np.any(one.values != 0.0))


def _is_quiet(plot: Plot) -> bool:
    return not any(np.any(curve.values != 0.0) for curve in plot.curves)
