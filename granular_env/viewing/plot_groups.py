"""Groups of scalars that are plotted together: one plot never mixes units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from .curves import Curve
from .scene_data import SceneData


@dataclass(frozen=True)
class Plot:
    """Curves of one unit under one title; `paths` says where they are in a scene."""

    title: str
    group: str
    curves: tuple[Curve, ...]

    @property
    def paths(self) -> tuple[str, ...]:
        """Entity of each curve."""
        return tuple(f"{self.group}/{curve.name}" for curve in self.curves)


def plots(scene_data: SceneData) -> list[Plot]:
    """All plots of scene data, the most telling ones first; what stays zero comes last."""
    named: dict[str, tuple[str, tuple[str, ...]]] = {}
    for balance in scene_data.balances:
        words = balance.quantity.replace("_", " ").capitalize()
        residuals = tuple(name for name in scene_data.curves if name.startswith(balance.residual))
        named[balance.quantity] = f"{words} [{balance.unit}]", balance.entries
        named[balance.residual] = f"{words} residual [{balance.unit}]: the error of the numerics", residuals
    balances = [
        Plot(
            title,
            group,
            tuple(scene_data.curves[name] for name in names if name in scene_data.curves and _moves(scene_data.curves[name])),
        )
        for group, (title, names) in named.items()
    ]
    balances = [replace(plot, title=f"{plot.title}{_reach(plot)}") for plot in balances]
    known = {name for _, names in named.values() for name in names}
    outputs = [curve for name, curve in scene_data.curves.items() if name not in known]
    found = [*balances[:2], *_by_unit("Inputs", scene_data.inputs.values()), *_by_unit("Outputs", outputs), *balances[2:]]
    return sorted((plot for plot in found if plot.curves), key=_is_quiet)


def select_plots(scene_data: SceneData, most: int) -> list[Plot]:
    """Return the plots with a pane of their own: at most so many, and none that stays zero in a finished run."""
    return [plot for plot in plots(scene_data) if not _is_quiet(plot) or len(plot.curves[0].values) < 2][:most]


def _by_unit(title: str, curves: Iterable[Curve]) -> list[Plot]:
    curves = list(curves)
    units = list(dict.fromkeys(curve.unit for curve in curves))
    return [Plot(f"{title} [{unit}]", title.lower(), tuple(curve for curve in curves if curve.unit == unit)) for unit in units]


def _reach(plot: Plot) -> str:
    """Return how large a residual becomes, in words: the axis of a small one has a single label, which gives no scale."""
    values = [np.abs(curve.values).max() for curve in plot.curves if len(curve.values) > 1]
    return f"; at most {max(values):.2g}" if plot.group.endswith("_residual") and values else ""


def _moves(curve: Curve) -> bool:
    """Return whether a curve of a balance says anything; of a single sample, nobody knows yet."""
    return len(curve.values) < 2 or bool(np.any(curve.values != 0.0))


def _is_quiet(plot: Plot) -> bool:
    return not any(np.any(curve.values != 0.0) for curve in plot.curves)
