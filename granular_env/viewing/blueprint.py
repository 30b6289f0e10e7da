"""How a scene is laid out in rerun: the chain and its close-up above, the x-t diagram, the plots and the caption below."""

from __future__ import annotations

from typing import Any

from .closeup import WINDOW, closeup_eye, has_closeup
from .extras import needed
from .footage import Footage, Motion
from .plots import Plot, shown_plots
from .scene import TIMELINE, Scales, whole_eye

# A run is played back in about this wall time [s].
_PLAYBACK_SECONDS = 10.0
# With or without particles: more than so many plots are too small to be read; the others can be added in the viewer.
_SHOWN_PLOTS, _SHOWN_PLOTS_ALONE = 3, 4


def blueprint(footage: Footage, scales: Scales | None, duration: float | None) -> Any:
    """The layout of a scene.

    Args:
        footage: what is shown.
        scales: None where there are no particles.
        duration: of the run [s], which sets the playback speed; None for a run that is still going on.
    """
    rrb = needed("rerun.blueprint", "the viewer")
    shown: list[Any] = [rrb.TextDocumentView(origin="caption", name="What you see")]
    scalars = shown_plots(footage, _SHOWN_PLOTS_ALONE if scales is None else _SHOWN_PLOTS)
    if scalars:
        shown.insert(0, rrb.Vertical(*(_plot(rrb, plot) for plot in scalars)))
    motion = footage.motion
    if motion is not None and motion.colour is not None and (duration is None or len(motion.times) > 1):
        shown.insert(0, rrb.Spatial2DView(origin="space_time", name="x-t diagram"))
    rows: list[Any] = [rrb.Horizontal(*shown, column_shares=[4.0, 4.0, 3.0][-len(shown) :])]
    shares = [6.0]
    if motion is not None and scales is not None:
        if has_closeup(motion):
            rows, shares = [_closeup(motion, scales), *rows], [1.2, *shares]
        rows, shares = [_whole(rrb, motion, scales), *rows], [3.6, *shares]
    return rrb.Blueprint(
        rrb.Vertical(*rows, row_shares=shares),
        _time_panel(rrb, duration),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_views=False,
    )


def _time_panel(rrb: Any, duration: float | None) -> Any:
    if duration is None:
        return rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following")
    speed = duration / _PLAYBACK_SECONDS if duration > 0.0 else 1.0
    return rrb.TimePanel(state="collapsed", timeline=TIMELINE, playback_speed=speed, play_state="playing", loop_mode="all")


def _plot(rrb: Any, plot: Plot) -> Any:
    several = len(plot.curves) > 1
    legend = rrb.PlotLegend("LeftTop", visible=several)
    title = plot.title if several or ":" in plot.title else f"{plot.title}: {next(iter(plot.curves)).name.replace('_', ' ')}"
    return rrb.TimeSeriesView(contents=list(plot.paths), name=title, plot_legend=legend)


def _closeup(motion: Motion, scales: Scales) -> Any:
    name = f"Close-up: the {WINDOW} grains around the one of largest {motion.colour_variable.name}"
    drawn = f"overlaps drawn {scales.stretch}" if motion.located else "positions at the start"
    return closeup_eye(motion).view(f"{name}; {drawn}", ["closeup/**"])


def _whole(rrb: Any, motion: Motion, scales: Scales) -> Any:
    """From the side, and in a second tab as a space to turn around in."""
    drawn = f"displacements drawn {scales.stretch}" if motion.located else "positions at the start"
    name = f"The chain from the side; {drawn}, grains to scale"
    return rrb.Tabs(
        whole_eye(scales).view(name, ["scene/**"]),
        rrb.Spatial3DView(origin="scene", name="The same in 3D", line_grid=False, eye_controls=_oblique(rrb, scales)),
        active_tab=0,
    )


def _oblique(rrb: Any, scales: Scales) -> Any:
    middle = 0.5 * (scales.low + scales.high)
    position = [middle - 0.35 * scales.length, -0.55 * scales.length, 0.3 * scales.length]
    return rrb.EyeControls3D(kind="Orbital", position=position, look_target=[middle, 0.0, 0.0], eye_up=[0.0, 0.0, 1.0])
