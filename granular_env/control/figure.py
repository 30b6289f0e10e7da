"""The figure of a study: convergence and best drive of each method."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from granular_env.viewing.figures.drawing import add_legend, line_style, new_figure, to_png, use_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .results import StudyResult


@use_style
def draw_study(result: StudyResult) -> bytes:
    """Return a PNG: each method's best return against the simulated steps, and the actions of its best drive or policy."""
    methods = list(dict.fromkeys(trial.method for trial in result.trials))
    figure = new_figure(8.6, 4.2 + 1.1 * len(methods))
    axes, *panels = figure.subplots(1 + len(methods), 1, height_ratios=[4, *[1] * len(methods)])
    for place, method in enumerate(methods):
        for number, trial in enumerate(result.method_trials(method)):
            steps, best = np.array([*trial.curve, (trial.spent, trial.curve[-1][1])]).T
            axes.step(steps, best, where="post", label=method if number == 0 else None, **line_style(place))
    for name, score in result.baselines.items():
        axes.axhline(score.value, color="0.45", linestyle=(0, (2, 2)), linewidth=1.0)
        axes.annotate(name, (1.0, score.value), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=9)
    axes.set(xlabel="control steps simulated", ylabel="best return so far", xscale="log")
    _hide_poor_starts(axes, result)
    add_legend(axes)
    for place, (panel, method) in enumerate(zip(panels, methods, strict=True)):
        if place:
            panel.sharex(panels[0])
            panel.sharey(panels[0])
        best = result.method_trials(method)[0].score
        times = 1e6 * best.duration * np.arange(len(best.actions) + 1)
        for entry in np.array(best.actions).T:
            panel.step(times, [*entry, entry[-1]], where="post", **{**line_style(place), "linestyle": "-"})
        panel.set_title(f"{method}: {best.value:.6g}", fontsize=10)
    panels[-1].set_xlabel("time [\u00b5s]")
    figure.supylabel("action", fontsize=11)
    return to_png(figure)


def _hide_poor_starts(axes: Axes, result: StudyResult) -> None:
    """Limit the return axis to the final returns and the baselines; the first returns of a search may be far below."""
    ends = [trial.search_return for trial in result.trials] + [score.value for score in result.baselines.values()]
    margin = 0.25 * (max(ends) - min(ends)) or 1.0
    bottom, top = axes.get_ylim()
    axes.set_ylim(max(bottom, min(ends) - margin), min(top, max(ends) + 0.5 * margin))
