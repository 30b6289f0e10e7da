"""The layout of a scene in rerun: particles at the top, then the domain's views, plots and caption."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun.blueprint as rrb

from ..domain_views import Views
from ..plot_groups import Plot, select_plots
from ..scene_data import SceneData
from ..scene_scales import Scales
from .profiles import profile_pane
from .scene import LEGEND, TIMELINE, plot_paths, whole_camera

# Approximate wall time in which rerun plays a whole run [s].
_PLAYBACK_SECONDS = 10.0
# Largest number of plots, with particles and without: more would be too small to read; users can add others in the viewer.
_SHOWN_PLOTS, _SHOWN_PLOTS_ALONE = 3, 4
# A plot gets this part more of the height for each curve, so that its legend fits.
_LEGEND_SHARE = 0.2
# Largest number of panes with fields along a line.
_SHOWN_PROFILES = 4

# Distance of the eye from a body in space, in diagonals of its box, so that the body fits rerun's 55-degree field of view.
_EYE_DISTANCE = 1.1

# A picture of a plane with a smaller ratio of width to height is placed next to the plots, not above them.
_WIDE = 2.0


def make_blueprint(scene_data: SceneData, scales: Scales | None, views: Views | None, duration: float | None) -> Any:
    """Return the layout of a scene.

    Args:
        scene_data: the scene.
        scales: scales of the scene; None if it has plots but no shapes.
        views: views of the component's domain; None without particles.
        duration: simulated time of the run [s], which sets the playback speed; None for a running simulation.
    """
    shown: list[Any] = [rrb.TextDocumentView(origin="caption", name="What you see")]
    scalars = select_plots(scene_data, _SHOWN_PLOTS_ALONE if scales is None else _SHOWN_PLOTS)
    if scalars:
        shares = [1.0 + _LEGEND_SHARE * len(plot.curves) for plot in scalars]
        shown.insert(0, rrb.Vertical(*(_plot_pane(plot) for plot in scalars), row_shares=shares))
    motion = scene_data.motion
    rows: list[tuple[Any, float]] = []
    if scales is not None:
        rows = [(_whole_view(scene_data, scales, views), 3.6)]
        if scales.colours and scene_data.is_plane:
            legend = rrb.Spatial2DView(origin=LEGEND, name="Colours", background=[13, 16, 17])
            rows.append((legend, 0.45 + 0.75 * len(scales.colours)))
        if motion is not None and views is not None:
            shown = [*views.side_panes(motion, scales), *shown]
            rows += views.full_width_panes(motion, scales)
    if profiles := [profile_pane(profile) for profile in scene_data.profiles[:_SHOWN_PROFILES]]:
        # A two-column grid with one pane would leave half of the width empty.
        rows.append((profiles[0] if len(profiles) == 1 else rrb.Grid(*profiles, grid_columns=2), 4.5))
    if scales is not None and _is_tall(scene_data, scales):
        # Put the scene and the plots side by side, because a nearly square picture would be small above the plots.
        beside = rrb.Vertical(*reversed(shown), row_shares=[3.0, 6.0][-len(shown) :])
        content = rrb.Horizontal(_stack_panes(rows, 10.0), beside, column_shares=[5.0, 4.0])
    else:
        rows.append((rrb.Horizontal(*shown, column_shares=[4.0, 4.0, 3.0][-len(shown) :]), 6.0))
        content = _stack_panes(rows)
    return rrb.Blueprint(
        content,
        _time_panel(duration),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_views=False,
    )


def _stack_panes(rows: list[tuple[Any, float]], first: float | None = None) -> Any:
    """Return panes one above the other with their shares of the height; `first`, if given, is the share of the first pane."""
    shares = [share for _, share in rows]
    return rrb.Vertical(*(row for row, _ in rows), row_shares=[first or shares[0], *shares[1:]])


def _is_tall(scene_data: SceneData, scales: Scales) -> bool:
    width, height = (high - low for low, high in zip(scales.low[:2], scales.high[:2], strict=True))
    return scene_data.is_solid or (scene_data.is_plane and width < _WIDE * height)


def _time_panel(duration: float | None) -> Any:
    if duration is None:
        return rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following")
    speed = duration / _PLAYBACK_SECONDS if duration > 0.0 else 1.0
    return rrb.TimePanel(state="collapsed", timeline=TIMELINE, playback_speed=speed, play_state="playing", loop_mode="all")


def _plot_pane(plot: Plot) -> Any:
    several = len(plot.curves) > 1
    legend = rrb.PlotLegend("LeftTop", visible=several)
    title = plot.title if several or ":" in plot.title else f"{plot.title}: {next(iter(plot.curves)).name.replace('_', ' ')}"
    return rrb.TimeSeriesView(contents=plot_paths(plot), name=title, plot_legend=legend)


def _whole_view(scene_data: SceneData, scales: Scales, views: Views | None) -> Any:
    """Return the whole scene from the side or from above, and a second tab with an interactive 3D view.

    The second tab is active for a body in space.
    """
    located = any(shape.located for shape in scene_data.shapes)
    drawn = f"; displacements drawn {scales.stretch_text}" if located else "; positions at the start"
    drawn = drawn if scene_data.movable_shapes else ""
    sizes = ", particles to scale" if scene_data.motions else ""
    name = f"{'From above' if scene_data.is_plane else 'From the side'}{drawn}{sizes}"
    in_space = f"In space{drawn}{sizes}" if scene_data.is_solid else "The same in 3D"
    return rrb.Tabs(
        whole_camera(scene_data, scales, views).make_pane(name, ["scene/**"]),
        rrb.Spatial3DView(
            origin="/", contents=["scene/**"], name=in_space, line_grid=False, eye_controls=_oblique_eye(scene_data, scales)
        ),
        active_tab=int(scene_data.is_solid),
    )


def _oblique_eye(scene_data: SceneData, scales: Scales) -> Any:
    """Return the eye of the 3D view, looking obliquely: close to a row or a plane, far enough away to show a whole body."""
    low, high = scales.magnification * np.array(scales.low), scales.magnification * np.array(scales.high)
    middle = 0.5 * (low + high)
    away = np.array([-0.35, -0.55, 0.3]) * float((high - low).max())
    if scene_data.is_solid:
        away = scene_data.viewpoint * _EYE_DISTANCE * float(np.sqrt(((high - low) ** 2).sum()))
    position = (middle + away).tolist()
    return rrb.EyeControls3D(kind="Orbital", position=position, look_target=middle.tolist(), eye_up=[0.0, 0.0, 1.0])
