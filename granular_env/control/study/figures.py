"""Figures of a study: how the methods converged, what the best drives are, and where they lead."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.viewing.figures.drawing import legend, line, new_figure, png, svg, with_style

from .results import Score, StudyResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Returns differ by less than this part of their range by rounding alone.
_ROUNDING = 1e-15
# So many times the range of the inner elements that of all is, before the end elements are left out of the picture.
_FLATTENED = 2.0
# Names of lines need this part of the axes' height.
_CLOSE = 0.06


@dataclass(frozen=True)
class Picture:
    """A figure as the bytes of a PNG file, as a part of the page, and in words."""

    png: bytes
    svg: str
    words: str


def pictures(result: StudyResult) -> dict[str, Picture]:
    """File name -> figure, in the order of the page."""
    drawn: dict[str, tuple[Figure, str]] = {}
    if any(len(trial.record.curve()[0]) for trial in result.trials):
        drawn["convergence"] = (
            _convergence(result),
            "Best return so far against the control steps that were simulated for it, every seed of a method in one colour; "
            "the dotted lines are the baselines. Below: how far that is from the best of all, which itself has no line there.",
        )
    if shown := _best_scores(result):
        drawn["drives"] = _drives(shown), "What the best of each method, and each baseline, does in the first test episode."
        for number, name in enumerate(next(iter(shown.values())).episode.final):
            words = f"At the end of that episode: {name}, element by element."
            drawn["final" if number == 0 else f"final-{number}"] = _final(shown, name), words
    return {name: Picture(png(figure), svg(figure, name), words) for name, (figure, words) in drawn.items()}


def _best_scores(result: StudyResult) -> dict[str, Score]:
    """Return the best trial of every method, and the baselines, by name."""
    found = {label: trials[0].score for label in result.labels() if (trials := result.of(label))}
    baselines = {f"baseline: {name}": score for name, score in result.baselines.items() if name != "nothing"}
    return {name: score for name, score in {**found, **baselines}.items() if score is not None}


@with_style
def _convergence(result: StudyResult) -> Figure:
    figure = new_figure(8.6, 7.0)
    axes, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    top = max(_ends(result))
    for place, label in enumerate(result.labels()):
        name: str | None = label
        for trial in result.trials:
            spent, best = trial.record.curve()
            if trial.label == label and len(spent):
                ends = np.append(spent, max(trial.record.spent, int(spent[-1])))
                values = np.append(best, best[-1])
                axes.step(ends, values, where="post", label=name, **line(place))
                below.step(ends, np.where(values < top, top - values, np.nan), where="post", **line(place))
                name = None
    axes.set(ylabel="best return so far", xscale="log")
    below.set(xlabel="control steps simulated", ylabel="short of the best of all", yscale="log")
    _let_poor_starts_leave(axes, result)
    bottom, _ = below.get_ylim()
    below.set_ylim(bottom=max(bottom, _ROUNDING * (top - min(_ends(result)))) or None)
    levels = {name: score.value for name, score in result.baselines.items()}
    _draw_levels(axes, levels)
    _draw_levels(below, {name: top - value for name, value in levels.items() if value < top})
    legend(axes)
    return figure


def _ends(result: StudyResult) -> list[float]:
    """Return what every trial and every baseline came to."""
    found = [float(best[-1]) for trial in result.trials if len(best := trial.record.curve()[1])]
    return [score.value for score in result.baselines.values()] + found


def _draw_levels(axes: Axes, levels: dict[str, float]) -> None:
    """Lines across the axes; names whose lines lie so close that they would cover each other stand side by side."""
    heights = {
        name: float(axes.transAxes.inverted().transform(axes.transData.transform((1.0, value)))[1])
        for name, value in levels.items()
    }
    shown = sorted((height, name) for name, height in heights.items() if 0.0 <= height <= 1.0)
    groups: list[tuple[float, list[str]]] = []
    for height, name in shown:
        axes.axhline(levels[name], color="0.45", linestyle=(0, (2, 2)), linewidth=1.0)
        if groups and height - groups[-1][0] < _CLOSE:
            groups[-1][1].append(name)
        else:
            groups.append((height, [name]))
    for height, names in groups:
        axes.annotate(
            ", ".join(names), (1.0, height), xycoords="axes fraction", ha="right", va="bottom", fontsize=9, color="0.35"
        )


def _let_poor_starts_leave(axes: Axes, result: StudyResult) -> None:
    """Early returns far below everything else may lie outside the picture: the ends are what is compared."""
    ends = _ends(result)
    low, high = min(ends), max(ends)
    margin = 0.25 * (high - low) or 1.0
    bottom, top = axes.get_ylim()
    axes.set_ylim(max(bottom, low - margin), min(top, high + 0.5 * margin))


@with_style
def _drives(shown: dict[str, Score]) -> Figure:
    figure = new_figure(8.6, 0.9 + 1.25 * len(shown))
    panels = np.atleast_1d(figure.subplots(len(shown), 1, sharex=True, sharey=True))
    for place, (panel, (name, score)) in enumerate(zip(panels, shown.items(), strict=True)):
        times = 1e6 * score.episode.duration * np.arange(len(score.episode.actions) + 1)
        for entry in range(score.episode.actions.shape[1]):
            values = score.episode.actions[:, entry]
            style = {**line(place), "linestyle": "-", "alpha": 1.0 - 0.4 * (entry > 0)}
            panel.step(times, np.append(values, values[-1:]), where="post", **style)
        panel.set_title(f"{name}: {score.value:.6g}", fontsize=10)
        panel.margins(x=0.01)
    panels[-1].set_xlabel("time [\u00b5s]")
    figure.supylabel("action", fontsize=11)
    return figure


@with_style
def _final(shown: dict[str, Score], name: str) -> Figure:
    figure = new_figure(8.6, 4.2)
    axes = figure.subplots()
    for place, (label, score) in enumerate(shown.items()):
        values: Any = score.episode.final[name]
        axes.plot(np.arange(len(values)), values, label=label, **line(place))
    axes.set(xlabel="element", ylabel=name)
    axes.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
    axes.margins(x=0.01)
    _let_ends_leave(axes, [score.episode.final[name] for score in shown.values()])
    legend(axes)
    return figure


def _let_ends_leave(axes: Axes, curves: list[Any]) -> None:
    """Leave an end element, such as a grain that has flown off, outside the picture where it would flatten everything else."""
    inner = np.concatenate([np.asarray(curve)[1:-1] for curve in curves])
    if not len(inner):
        return
    low, high = float(inner.min()), float(inner.max())
    every = np.concatenate(curves)
    if high > low and float(every.max() - every.min()) > _FLATTENED * (high - low):
        axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
        axes.annotate(
            "ends that lie outside flatten everything else", (0.01, 0.01), xycoords="axes fraction", fontsize=9, color="0.35"
        )
