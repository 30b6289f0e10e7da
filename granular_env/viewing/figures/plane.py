"""Pictures of bodies in a plane, or obliquely in space, at some instants: points, links and cells, coloured by an output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.colours import DIVERGING, diverging
from granular_env.components.drawables import Cells, Drawable, Links, Points, drawn_outputs, spatial
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.round_numbers import round_down_to_125
from granular_env.optional_packages import import_optional
from granular_env.recording.preview.displacement_scale import common_exaggeration

from ..colour_scales import ColourScale, colour_scales, scale_of
from ..cracks import MOST_LINES, crack_lines
from ..recorded_fields import coloured_drawables, sample_frames, validity_of
from ..scene_data import MAXIMUM_SHOWN_LINKS, SceneData
from ..scene_scales import scales_of
from ..viewpoint import focus_normal, viewpoint, viewpoint_words
from ..visible_drawables import is_hidden, is_plane, is_solid
from .colour_bar import add_bar
from .drawing import new_figure, time_unit, with_style
from .run_figures import frame_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Beyond so many things a picture holds pixels, not shapes: a page with a path for each of them would be slow.
_MOST_SHAPES = 400
_WIDTH, _TWO_ABREAST, _LARGEST_HEIGHT = 8.0, 2.5, 4.5  # inch, width over height, inch
# The bar that says how large things are, of the width of the picture, at most.
_LENGTH_PART, _LENGTH_HEIGHT = 0.3, 0.4  # and its room, inch
# The edges are grey on any page, and narrower than a twelfth of a thing; links and cracks are seen on white, on red and on the
# pages' grounds.
_EDGE, _LINK, _CRACK, _SPOKE = "#737373", "#218a52", "#101214", "#808080"
_WIDEST_EDGE, _EDGE_PART, _LEAST_EDGED = 0.6, 1.0 / 16.0, 3.0  # point, of a thing, point
# Cells touch, so that lines between small ones would be most of what is seen [point].
_LEAST_EDGED_CELL = 8.0
# What turns away from the light, which comes from the eye, is so much darker.
_SHADE, _INSIDE, _UNKNOWN = 0.35, np.array([0.23, 0.24, 0.26, 1.0]), (0.855, 0.855, 0.855)
# An event that is so near to the start or the end, in lengths of the run, has no picture of its own.
_MARGIN = 0.05


@dataclass(frozen=True)
class Plane:
    """The drawn parts of a plane, in some frames.

    Attributes:
        drawables: points, links and cells with at least two coordinates.
        times: of the frames, ascending [s].
        values: the outputs that the drawables name, as far as they were recorded, name -> (frames, *shape).
        exaggeration: factor of the displacements.
        scales: of the colours.
        focus_normal: the outward direction of a body in space where most happens; None where nothing tells.
        valid_until: as of `SceneData`.
    """

    drawables: tuple[Drawable, ...]
    times: FloatArray
    values: Mapping[str, FloatArray]
    exaggeration: float
    scales: tuple[ColourScale, ...]
    focus_normal: FloatArray | None = None
    valid_until: float = np.inf

    def places(self, drawable: Points | Cells, frame: int | slice) -> FloatArray:
        """Return where in the picture points, or the nodes of cells, are drawn, shape (..., n, 2) [m]."""
        return self.seen(drawable, frame)[..., :2]

    def seen(self, drawable: Points | Cells, frame: int | slice) -> FloatArray:
        """Return the same with the distance towards the eye behind it, shape (..., n, 3) [m]."""
        rest = spatial(drawable.reference if isinstance(drawable, Points) else drawable.nodes)
        moved = self.values.get(drawable.displacement)
        if moved is None:
            return rest @ self.eye
        return (rest + self.exaggeration * spatial(moved[frame])) @ self.eye

    @cached_property
    def is_solid(self) -> bool:
        """True where a body in space is drawn, which is seen obliquely; a plane is seen from above."""
        return any(isinstance(one, Cells) and is_solid(one.nodes) for one in self.drawables)

    @cached_property
    def eye(self) -> FloatArray:
        """The directions right and up in the picture, and towards the eye, as columns."""
        if not self.is_solid:
            return np.eye(3)
        x, y, z = viewpoint(self.focus_normal).tolist()
        level = float(np.hypot(x, y))
        return np.array([[-y / level, x / level, 0.0], [-x * z / level, -y * z / level, level], [x, y, z]]).T

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """The corners of what is drawn in any of the frames [m]."""
        corners = []
        for one in self.drawables:
            if isinstance(one, Points | Cells):
                reach = one.radius[:, None] if isinstance(one, Points) else 0.0
                places = self.places(one, slice(None))
                corners += [(places - reach).reshape(-1, 2), (places + reach).reshape(-1, 2)]
        everything = np.concatenate(corners)
        low, high = everything.min(axis=0), everything.max(axis=0)
        room = 0.02 * float((high - low).max())
        return low - room, high + room


def load_plane(
    log: Any, scene_data: SceneData | None, times: Sequence[float] | None = None, colour: str | None = None
) -> Plane | None:
    """Read what a log holds of a plane at some instants.

    Args:
        log: an open log.
        scene_data: of it: displacements are stretched and colours chosen for the whole run; None for what suits the instants.
        times: the instants [s]; default: four that show the run, the first event among them.
        colour: a recorded output that colours what it can, with a scale for these instants; the rest is grey.

    Returns:
        None where nothing lies or moves in a plane, or nothing of it was recorded.

    Raises:
        ParameterError: an instant outside the recorded span, or nothing can be coloured by that output.
    """
    everything = coloured_drawables(log, colour)
    drawables = tuple(one for one in everything if _is_planar(one, log) and not is_hidden(one, everything))
    names = [name for name in drawn_outputs(drawables) if name in log.variables and len(log.times(name))]
    if not any(not isinstance(one, Links) for one in drawables) or not names:
        return None
    clock = np.asarray(log.times(names[0]), dtype=np.float64)
    picked = np.unique([frame_at(clock, time) for time in (_instants(log, clock) if times is None else times)])
    values = {name: sample_frames(log, name, picked)[1] for name in names}
    coloured = [one.field if isinstance(one, Cells) else getattr(one, "colour", "") for one in drawables]
    if scene_data is None or colour is not None:
        now = None if scene_data is None else scales_of(scene_data)
        factor = _exaggeration(drawables, values) if now is None else now.exaggeration
        coloured = [name for name in coloured if colour in (None, name)]
        scales = colour_scales(((log.variables[name], values[name]) for name in coloured if name in values), is_plane=True)
    else:
        now = scales_of(scene_data)
        factor, scales = (1.0, ()) if now is None else (now.exaggeration, now.colours)
    shown = tuple(scale for scale in scales if set(scale.names) & set(coloured) & set(values))
    focus = focus_normal(log, everything) if scene_data is None else scene_data.focus_normal
    return Plane(drawables, clock[picked], values, factor, shown, focus, validity_of(log)[0])


def _exaggeration(drawables: Sequence[Drawable], values: Mapping[str, FloatArray]) -> float:
    moved = [one for one in drawables if isinstance(one, Points | Cells) and one.displacement in values]
    return common_exaggeration(
        ((spatial(one.reference), one.radius, spatial(values[one.displacement])) for one in moved if isinstance(one, Points)),
        ((one.nodes, values[one.displacement]) for one in moved if isinstance(one, Cells)),
    )


def _is_planar(drawable: Drawable, log: Any) -> bool:
    """Return whether a drawable has a place in a plane: two coordinates or more, and not only one that differs or moves."""
    if isinstance(drawable, Links):
        ends = next((one for one in log.drawables if isinstance(one, Points) and one.name == drawable.points), None)
        return ends is not None and _is_planar(ends, log) and len(drawable.pairs) <= MAXIMUM_SHOWN_LINKS
    if not isinstance(drawable, Points | Cells):
        return False
    rest = drawable.reference if isinstance(drawable, Points) else drawable.nodes
    return rest.shape[1] > 1 and is_plane(rest, log.variables.get(drawable.displacement))


def events_in_sight(log: Any) -> Sequence[Any]:
    """Return the events at something that is drawn; without any all, such as the ignition of the gas in a tube."""
    happened, details = log.events(), log.event_details
    return [event for event in happened if event.kind in details and details[event.kind].counts] or happened


def _instants(log: Any, clock: FloatArray) -> list[float]:
    """Return the start, the first event or a third of the run, an instant between it and the end, and the end [s]."""
    start, end = float(clock[0]), float(clock[-1])
    third, events = start + (end - start) / 3.0, events_in_sight(log)
    first = events[0].tick * log.step_size if events else third
    if not _MARGIN <= (first - start) / max(end - start, 1e-300) <= 1.0 - _MARGIN:
        first = third  # too near to the start or to the end for a picture of its own
    return [start, first, 0.5 * (first + end), end]


@with_style
def draw_plane(plane: Plane) -> Figure:
    """Draw the plane at each of its instants, with a colour bar for each quantity."""
    low, high = plane.box
    width, height = (high - low).tolist()
    columns = 2 if width < _TWO_ABREAST * height and len(plane.times) > 1 else 1
    rows = -(-len(plane.times) // columns)
    tall = min(_WIDTH / columns * height / width + 0.35, _LARGEST_HEIGHT)
    figure = new_figure(_WIDTH, rows * tall + 0.7 * len(plane.scales) + _LENGTH_HEIGHT)
    panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    scale, unit = time_unit(float(plane.times[-1]))
    for frame, (axes, time) in enumerate(zip(panels, plane.times, strict=False)):
        draw_instant(axes, plane, frame)
        axes.set_title(f"t = {time * scale:.4g} {unit}{'' if time < plane.valid_until else ', not valid'}", fontsize=11)
    for axes in panels[len(plane.times) :]:
        axes.set_visible(False)
    _add_length(panels[0], plane)
    if stretched := stretch_words(plane):
        figure.supxlabel(stretched, x=0.0, horizontalalignment="left", fontsize=10)
    for one in plane.scales:
        add_bar(figure, one, ax=panels, shrink=0.5, aspect=40, pad=0.02)
    return figure


def _add_length(axes: Axes, plane: Plane) -> None:
    """Draw a bar of a round length below a picture."""
    low, high = plane.box
    length = round_down_to_125(_LENGTH_PART * float(high[0] - low[0]))
    label = import_optional("matplotlib.ticker", "figures").EngFormatter("m")(length)
    artists = import_optional("mpl_toolkits.axes_grid1.anchored_artists", "figures")
    axes.add_artist(
        artists.AnchoredSizeBar(
            axes.transData, length, label, "upper left", bbox_to_anchor=(0.0, 0.0), bbox_transform=axes.transAxes,
            borderpad=0.0, pad=0.3, sep=3.0, frameon=False,
        )
    )  # fmt: skip


def draw_instant(axes: Axes, plane: Plane, frame: int) -> None:
    """Draw everything in one frame; the axes show the box of all frames."""
    low, high = plane.box
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    for kind in (Cells, Points, Links):
        for drawable in plane.drawables:
            if isinstance(drawable, kind):
                _draw(axes, plane, drawable, frame)


def _draw(axes: Axes, plane: Plane, drawable: Drawable, frame: int) -> None:
    if isinstance(drawable, Links):
        _draw_links(axes, plane, drawable, frame)
    elif isinstance(drawable, Cells):
        _draw_cells(axes, plane, drawable, frame)
    elif isinstance(drawable, Points):
        _draw_points(axes, plane, drawable, frame)


def _edge_width(axes: Axes, plane: Plane, size: float, least: float = _LEAST_EDGED) -> float:
    """Return how wide the edge of a thing of some size [m] is [point]; 0 below `least`, where it would hide the colours."""
    low, high = plane.box
    place, figure = axes.get_position(), axes.get_figure(root=True)
    assert figure is not None
    inches = figure.get_size_inches() * np.array([place.width, place.height])
    drawn = size * float((72.0 * inches / (high - low)).min())
    return min(_WIDEST_EDGE, _EDGE_PART * drawn) if drawn >= least else 0.0


def _draw_points(axes: Axes, plane: Plane, points: Points, frame: int) -> None:
    collections = import_optional("matplotlib.collections", "figures")
    places, size = plane.places(points, frame), 2.0 * points.radius
    width = _edge_width(axes, plane, float(np.median(size)))
    discs = collections.EllipseCollection(
        size, size, np.zeros(len(size)), units="xy", offsets=places, offset_transform=axes.transData, edgecolor=_EDGE,
        linewidth=width,
    )  # fmt: skip
    discs.set_rasterized(len(size) > _MOST_SHAPES)
    values = plane.values.get(points.colour)
    _add(axes, plane, discs, points.colour, None if values is None else values[frame])
    if width and points.rotation in plane.values:
        angle = plane.values[points.rotation][frame]
        along = points.radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        spokes = collections.LineCollection(
            list(np.stack([places, places + along], axis=1)), colors=_SPOKE, linewidths=2.0 * width
        )
        spokes.set_rasterized(len(size) > _MOST_SHAPES)
        axes.add_collection(spokes)


def _draw_cells(axes: Axes, plane: Plane, cells: Cells, frame: int) -> None:
    states, seen = plane.values.get(cells.state), plane.seen(cells, frame)
    shown = np.arange(len(cells.connectivity)) if states is None else np.flatnonzero(states[frame])
    if plane.is_solid:
        # What is nearer to the eye hides what is behind it.
        shown = shown[np.argsort(seen[cells.connectivity[shown], 2].mean(axis=1), kind="stable")]
    corners = seen[cells.connectivity[shown]][..., :2]
    size = float(np.sqrt(np.median(np.ptp(corners, axis=1).prod(axis=1)))) if len(corners) else 0.0
    width = min(0.2, _edge_width(axes, plane, size, _LEAST_EDGED_CELL))
    # Smooth edges of cells without lines between them would leave seams.
    edge = {"edgecolor": _EDGE, "linewidth": width} if width else {"linewidth": 0.0, "antialiased": False}
    shapes = import_optional("matplotlib.collections", "figures").PolyCollection(corners, **edge)
    # Browsers round narrow shapes without lines to whole pixels, so that they leave gaps: these are pixels already.
    shapes.set_rasterized(len(corners) > _MOST_SHAPES or not width)
    if not plane.is_solid:
        _add(axes, plane, shapes, cells.field, _of_cells(plane, cells, frame, shown))
        return
    axes.add_collection(shapes)
    shapes.set_facecolor(_lit(_colours(plane, cells, frame, shown), seen[cells.connectivity[shown]]))


def _of_cells(plane: Plane, cells: Cells, frame: int, shown: np.ndarray) -> FloatArray | None:
    """Return what colours some cells, of nodes the mean of each cell's; None where it was not recorded."""
    values = plane.values.get(cells.field)
    if values is None:
        return None
    now = values[frame]
    return (now[cells.connectivity].mean(axis=1) if len(now) == len(cells.nodes) else now)[shown]


def _colours(plane: Plane, cells: Cells, frame: int, shown: np.ndarray) -> FloatArray:
    """Return the colours of some cells, shape (m, 4), 0 to 1."""
    scale, values = scale_of(plane.scales, cells.field), _of_cells(plane, cells, frame, shown)
    if scale is None or values is None:
        return np.full((len(shown), 4), [*_UNKNOWN, 1.0])
    return np.concatenate([diverging(values, scale.limit) / 255.0, np.ones((len(values), 1))], axis=1)


def _lit(colours: FloatArray, corners: FloatArray) -> FloatArray:
    """Return colours with light from the eye, and the inside of the body, which is seen through gaps, dark.

    Args:
        colours: of the cells, shape (m, 4).
        corners: of each, as seen, shape (m, k, 3).
    """
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
    length = np.maximum(np.sqrt((normal * normal).sum(axis=1)), 1e-300)
    towards = (normal[:, 2] / length)[:, None]
    lit = np.concatenate([colours[:, :3] * (1.0 - _SHADE * (1.0 - np.abs(towards))), colours[:, 3:]], axis=1)
    return np.where(towards > 0.0, lit, _INSIDE)


def _draw_links(axes: Axes, plane: Plane, links: Links, frame: int) -> None:
    """Draw the cracks and, where they hide nothing, the links that hold."""
    if links.state not in plane.values:
        return
    points = next(one for one in plane.drawables if isinstance(one, Points) and one.name == links.points)
    inside = points.stays_inside(links.pairs)
    places, pairs, state = plane.places(points, frame), links.pairs[inside], plane.values[links.state][frame][inside]
    width = _edge_width(axes, plane, 2.0 * float(np.median(points.radius)))
    if len(links.pairs) <= MOST_LINES:
        _add_lines(axes, places[pairs[state != 0.0]], _LINK, 2.0)
    _add_lines(axes, crack_lines(places, points.reference[:, :2], pairs, state), _CRACK, max(3.0 * width, 0.5))


def _add_lines(axes: Axes, lines: FloatArray, colour: str, width: float) -> None:
    shapes = import_optional("matplotlib.collections", "figures").LineCollection(
        list(lines), colors=colour, linewidths=width, capstyle="round"
    )
    shapes.set_rasterized(len(lines) > _MOST_SHAPES)
    axes.add_collection(shapes)


def _add(axes: Axes, plane: Plane, shapes: Any, name: str, values: FloatArray | None) -> None:
    """Put shapes into a picture, in the colours of an output where it was recorded."""
    axes.add_collection(shapes)
    scale = scale_of(plane.scales, name)
    if scale is None or values is None:
        shapes.set_facecolor(_UNKNOWN)
        return
    colours = import_optional("matplotlib.colors", "figures").LinearSegmentedColormap.from_list("granular", DIVERGING)
    shapes.set(array=values, clim=(-scale.limit, scale.limit), cmap=colours)


def stretch_words(plane: Plane) -> str:
    """Return how displacements are drawn, in words; "" where they are true to scale."""
    movable = [one for one in plane.drawables if isinstance(one, Points | Cells) and one.displacement]
    still = [one.name for one in movable if one.displacement not in plane.values]
    parts = [] if plane.exaggeration == 1.0 else [f"displacements drawn {plane.exaggeration:g} x larger"]
    if still:
        names = " and ".join(still).replace("_", " ")
        parts.append(f"{names} drawn at the places of the start: no displacements recorded")
    return "; ".join(parts)


def words(plane: Plane) -> str:
    """Return what the pictures show, in words."""
    kinds = [one.name.replace("_", " ") for one in plane.drawables]
    shown = ", ".join(kinds[:-1]) + (f" and {kinds[-1]}" if len(kinds) > 1 else kinds[-1])
    where = f"{viewpoint_words(plane.eye[:, 2])}; dark is the inside" if plane.is_solid else "x to the right, y up"
    parts = [f"{shown.capitalize()} at chosen instants, {where}"]
    parts += [stretched] if (stretched := stretch_words(plane)) else []
    if any(isinstance(one, Points) and one.rotation in plane.values for one in plane.drawables):
        parts.append("a spoke shows how each is turned")
    if any(isinstance(one, Cells) and one.state in plane.values for one in plane.drawables):
        parts.append("cells that a crack crosses are left out")
    links = [one for one in plane.drawables if isinstance(one, Links) and one.state in plane.values]
    if links:
        parts.append("a broken link is a short black line across, while its two ends are near")
    if any(len(one.pairs) > MOST_LINES for one in links):
        parts.append("links that hold are not drawn: they would hide the colours")
    return "; ".join(parts) + "."
