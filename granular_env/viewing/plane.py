"""Pictures of a plane at some instants: points, links and cells where they are then, coloured by what colours them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.colours import DIVERGING, symmetric_limit
from granular_env.components.drawables import Cells, Drawable, Links, Points, drawn_outputs
from granular_env.components.support.arrays import FloatArray
from granular_env.components.support.roots import round_down_to_125
from granular_env.recording.displacement_scale import choose_exaggeration

from .figure_style import new_figure, time_unit, with_style
from .figures import frame_at
from .optional_packages import import_optional
from .scene_data import MAXIMUM_SHOWN_LINKS, Motion, sample_frames
from .units import label_with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Beyond so many things a picture holds pixels, not shapes: a page with a path for each of them would be slow.
_MOST_SHAPES = 400
# Nodes are drawn so far from where they began, at most, in lengths of the picture.
_DRAWN_TRAVEL = 0.1
_WIDTH, _TWO_ABREAST, _LARGEST_HEIGHT = 8.0, 2.5, 4.5  # inch, width over height, inch
# The edges are grey on any page; links are seen on white, on red and on the pages' grounds.
_EDGE, _LINK = "#737373", "#218a52"


@dataclass(frozen=True)
class Plane:
    """The drawn parts of a plane, in some frames.

    Attributes:
        drawables: points, links and cells with at least two coordinates.
        times: of the frames, ascending [s].
        values: the outputs that the drawables name, as far as they were recorded, name -> (frames, *shape).
        units: of these outputs.
        exaggeration: factor of the displacements.
    """

    drawables: tuple[Drawable, ...]
    times: FloatArray
    values: Mapping[str, FloatArray]
    units: Mapping[str, str]
    exaggeration: float

    def places(self, drawable: Points | Cells, frame: int | slice) -> FloatArray:
        """Return x and y of points, or of the nodes of cells, as they are drawn, shape (..., n, 2) [m]."""
        rest = (drawable.reference if isinstance(drawable, Points) else drawable.nodes)[:, :2]
        moved = self.values.get(drawable.displacement)
        return rest + (0.0 if moved is None else self.exaggeration * moved[frame][..., :2])

    def limit(self, name: str) -> tuple[float, bool]:
        """Return the magnitude at the ends of the colours of an output, and whether it has a sign."""
        values = self.values[name]
        return symmetric_limit(values), bool(np.nanmin(values, initial=0.0) < 0.0)


def load_plane(log: Any, motion: Motion | None, times: Sequence[float] | None = None) -> Plane | None:
    """Read what a log holds of a plane at some instants.

    Args:
        log: an open log.
        motion: of its particles; None where there are none.
        times: the instants [s]; default: four that show the run, the first event among them.

    Returns:
        None where nothing lies or moves in a plane, or nothing of it was recorded.

    Raises:
        ParameterError: an instant outside the recorded span.
    """
    drawables = tuple(one for one in log.drawables if _is_planar(one, log) and not _is_hidden(one, log.drawables))
    names = [name for name in drawn_outputs(drawables) if name in log.variables and len(log.times(name))]
    if not any(not isinstance(one, Links) for one in drawables) or not names:
        return None
    clock = np.asarray(log.times(names[0]), dtype=np.float64)
    picked = np.unique([frame_at(clock, time) for time in (_instants(log, clock) if times is None else times)])
    values = {name: sample_frames(log, name, picked)[1] for name in names}
    units = {name: log.variables[name].unit for name in names}
    return Plane(drawables, clock[picked], values, units, _exaggeration(drawables, values, motion))


def _is_hidden(drawable: Drawable, others: Sequence[Drawable]) -> bool:
    """Return whether a drawable would hide others: points that are the nodes of cells, which are drawn themselves."""
    return isinstance(drawable, Points) and any(
        isinstance(one, Cells) and one.displacement == drawable.displacement and np.array_equal(one.nodes, drawable.reference)
        for one in others
    )


def _is_planar(drawable: Drawable, log: Any) -> bool:
    """Return whether a drawable has a place in a plane: two coordinates or more, and not only one that differs or moves."""
    if isinstance(drawable, Links):
        ends = next((one for one in log.drawables if isinstance(one, Points) and one.name == drawable.points), None)
        return ends is not None and _is_planar(ends, log) and len(drawable.pairs) <= MAXIMUM_SHOWN_LINKS
    if not isinstance(drawable, Points | Cells):
        return False
    rest = drawable.reference if isinstance(drawable, Points) else drawable.nodes
    displacement = log.variables.get(drawable.displacement)
    moves = displacement is not None and len(displacement.shape) == 2 and displacement.shape[1] > 1
    return rest.shape[1] > 1 and (moves or bool(np.ptp(rest[:, 1]) > 0.0))


def _instants(log: Any, clock: FloatArray) -> list[float]:
    """Return the start, the first event or a third of the run, an instant between it and the end, and the end [s]."""
    start, end = float(clock[0]), float(clock[-1])
    third, events = start + (end - start) / 3.0, log.events()
    first = events[0].tick * log.step_size if events else third
    if not 0.5 * (start + third) <= first <= 0.5 * (third + end):
        first = third  # too near to the start or to the end for a picture of its own
    return [start, first, 0.5 * (first + end), end]


def _exaggeration(drawables: Sequence[Drawable], values: Mapping[str, FloatArray], motion: Motion | None) -> float:
    """Return one factor for all displacements: particles do not pass one another, nodes stay near."""
    factors = []
    if motion is not None and motion.located:
        factors.append(choose_exaggeration(motion.reference, motion.radius, motion.displacement))
    for one in drawables:
        if isinstance(one, Cells) and (travel := float(np.abs(values.get(one.displacement, np.zeros(1))).max())) > 0.0:
            size = float(np.ptp(one.nodes, axis=0).max())
            factors.append(max(1.0, round_down_to_125(_DRAWN_TRAVEL * size / travel)))
    return min(factors, default=1.0)


@with_style
def draw_plane(plane: Plane) -> Figure:
    """Draw the plane at each of its instants, with a colour bar for each quantity."""
    low, high = _box(plane)
    width, height = (high - low).tolist()
    columns = 2 if width < _TWO_ABREAST * height and len(plane.times) > 1 else 1
    rows = -(-len(plane.times) // columns)
    tall = min(_WIDTH / columns * height / width + 0.35, _LARGEST_HEIGHT)
    figure = new_figure(_WIDTH, rows * tall + 0.9)
    panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    scale, unit = time_unit(float(plane.times[-1]))
    drawn: dict[str, Any] = {}
    for frame, (axes, time) in enumerate(zip(panels, plane.times, strict=False)):
        for drawable in plane.drawables:
            drawn |= _draw(axes, plane, drawable, frame)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
        axes.set_title(f"t = {time * scale:.4g} {unit}", fontsize=11)
        axes.spines[:].set_visible(False)
    for axes in panels[len(plane.times) :]:
        axes.set_visible(False)
    for name, collection in drawn.items():
        bar = figure.colorbar(
            collection, ax=panels, orientation="horizontal", label=label_with_unit(name, plane.units[name]),
            shrink=0.5, aspect=40, pad=0.02,
        )  # fmt: skip
        limit, has_sign = plane.limit(name)
        bar.ax.set_xlim(-limit if has_sign else 0.0, limit)
    return figure


def _box(plane: Plane) -> tuple[FloatArray, FloatArray]:
    """Return the corners of what is drawn in any of the frames [m]."""
    corners = []
    for one in plane.drawables:
        if isinstance(one, Points | Cells):
            reach = one.radius[:, None] if isinstance(one, Points) else 0.0
            places = plane.places(one, slice(None))
            corners += [(places - reach).reshape(-1, 2), (places + reach).reshape(-1, 2)]
    everything = np.concatenate(corners)
    low, high = everything.min(axis=0), everything.max(axis=0)
    room = 0.02 * float((high - low).max())
    return low - room, high + room


def _draw(axes: Axes, plane: Plane, drawable: Drawable, frame: int) -> dict[str, Any]:
    """Draw one drawable in one frame; return what its colours belong to, name -> collection."""
    if isinstance(drawable, Links):
        return _draw_links(axes, plane, drawable, frame)
    if isinstance(drawable, Cells):
        return _draw_cells(axes, plane, drawable, frame)
    return _draw_points(axes, plane, drawable, frame) if isinstance(drawable, Points) else {}


def _draw_points(axes: Axes, plane: Plane, points: Points, frame: int) -> dict[str, Any]:
    collections = import_optional("matplotlib.collections", "figures")
    places, size = plane.places(points, frame), 2.0 * points.radius
    angles = np.zeros(len(size))
    discs = collections.EllipseCollection(
        size, size, angles, units="xy", offsets=places, offset_transform=axes.transData, edgecolor=_EDGE, linewidth=0.6
    )
    drawn = _add(axes, plane, discs, points.colour, frame, len(size))
    if points.rotation in plane.values and len(size) <= _MOST_SHAPES:
        angle = plane.values[points.rotation][frame]
        along = points.radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        axes.add_collection(collections.LineCollection(list(np.stack([places, places + along], axis=1)), colors=_EDGE))
    return drawn


def _draw_cells(axes: Axes, plane: Plane, cells: Cells, frame: int) -> dict[str, Any]:
    corners = plane.places(cells, frame)[cells.connectivity]
    shapes = import_optional("matplotlib.collections", "figures").PolyCollection(corners, edgecolor=_EDGE, linewidth=0.2)
    return _add(axes, plane, shapes, cells.field, frame, len(corners), cells.connectivity)


def _draw_links(axes: Axes, plane: Plane, links: Links, frame: int) -> dict[str, Any]:
    if links.state not in plane.values:
        return {}
    points = next(one for one in plane.drawables if isinstance(one, Points) and one.name == links.points)
    whole = links.pairs[plane.values[links.state][frame] != 0.0]
    lines = import_optional("matplotlib.collections", "figures").LineCollection(
        list(plane.places(points, frame)[whole]), colors=_LINK, linewidths=2.0 if len(links.pairs) <= _MOST_SHAPES else 0.8
    )
    lines.set_rasterized(len(whole) > _MOST_SHAPES)
    axes.add_collection(lines)
    return {}


def _add(
    axes: Axes, plane: Plane, shapes: Any, name: str, frame: int, count: int, connectivity: np.ndarray | None = None
) -> dict[str, Any]:
    """Put shapes into a picture, in the colours of an output where it was recorded: of nodes, in the mean of each cell's."""
    shapes.set_rasterized(count > _MOST_SHAPES)
    axes.add_collection(shapes)
    if name not in plane.values:
        shapes.set_facecolor("#dadada")
        return {}
    values = plane.values[name][frame]
    if connectivity is not None and len(values) != count:
        values = values[connectivity].mean(axis=1)
    limit, _ = plane.limit(name)
    colours = import_optional("matplotlib.colors", "figures").LinearSegmentedColormap.from_list("granular", DIVERGING)
    shapes.set(array=values, clim=(-limit, limit), cmap=colours)
    return {name: shapes}


def words(plane: Plane) -> str:
    """Return what the pictures show, in words."""
    kinds = [one.name.replace("_", " ") for one in plane.drawables]
    shown = ", ".join(kinds[:-1]) + (f" and {kinds[-1]}" if len(kinds) > 1 else kinds[-1])
    parts = [f"{shown.capitalize()} at chosen instants, x to the right, y up"]
    moves = any(isinstance(one, Points | Cells) and one.displacement in plane.values for one in plane.drawables)
    if not moves:
        parts.append("at their places at the start, since no displacements were recorded")
    elif plane.exaggeration != 1.0:
        parts.append(f"displacements drawn {plane.exaggeration:g} x larger")
    if any(isinstance(one, Links) and one.state in plane.values for one in plane.drawables):
        parts.append("a broken link has no line")
    return "; ".join(parts) + "."
