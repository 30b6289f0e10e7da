"""Pictures of bodies in a plane, or of bodies in space seen obliquely: points, links and cells, coloured by an output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.round_numbers import round_down_to_125
from granular_env.recording.preview.visible_drawables import area_vectors

from ..cracks import MOST_LINES, crack_lines
from ..picture_sentences import picture_sentences
from ..scene_builder import load_shapes
from ..scene_data import LinkFrames, MeshFrames, Motion, SceneData, drawn_positions
from ..scene_scales import Scales, make_scales
from .colour_bar import add_colour_bar
from .drawing import new_figure, time_unit, use_style

# Pictures with more shapes than this are embedded as pixels: a page with one SVG path for each shape would be slow.
_MOST_SHAPES = 400
_WIDTH, _TWO_ABREAST, _LARGEST_HEIGHT = 8.0, 2.5, 4.5  # inch, width over height, inch
# Largest length of the scale bar, as a fraction of the picture's width.
_LENGTH_PART, _LENGTH_HEIGHT = 0.3, 0.4  # and its height, inch
# Colours of edges, links, cracks, spokes; links and cracks are visible on white, on red, and on light and dark pages.
_EDGE, _LINK, _CRACK, _SPOKE = "#737373", "#218a52", "#101214", "#808080"
_WIDEST_EDGE, _EDGE_PART, _LEAST_EDGED = 0.6, 1.0 / 16.0, 3.0  # largest width [point], part of the size, smallest size [point]
# Smallest cell drawn with edges [point]: cells touch, and the edges of smaller cells would hide the colours.
_LEAST_EDGED_CELL = 8.0
# Light comes from the eye: the more a cell faces away, the darker it is, by up to this fraction; the inside has this colour.
_SHADE, _INSIDE = 0.35, np.array([0.23, 0.24, 0.26])
# Events closer than this to the start or the end, as a fraction of the run, get no extra picture.
_MARGIN = 0.05


@dataclass(frozen=True)
class Plane:
    """The shapes of a scene (in a plane or in space) in the frames to be drawn as pictures, and the scales of the pictures."""

    scene: SceneData
    scales: Scales

    @property
    def times(self) -> FloatArray:
        """The times of the frames, ascending [s]."""
        return self.scene.shapes[0].times

    def picture_coordinates(self, shape: Motion | MeshFrames, frames: int | slice) -> FloatArray:
        """Return the positions of points or nodes along the axes right, up and towards the eye, shape (..., n, 3) [m]."""
        return drawn_positions(shape, self.scales.exaggeration, frames) @ self.eye_axes

    @cached_property
    def eye_axes(self) -> FloatArray:
        """The directions right, up and towards the eye as columns; a plane is seen from above."""
        if not self.scene.is_solid:
            return np.eye(3)
        x, y, z = self.scene.viewpoint.tolist()
        level = float(np.hypot(x, y))
        return np.array([[-y / level, x / level, 0.0], [-x * z / level, -y * z / level, level], [x, y, z]]).T

    @cached_property
    def bounding_box(self) -> tuple[FloatArray, FloatArray]:
        """The corners of the bounding box of all shapes in all frames [m]."""
        corners = []
        for shape in self.scene.shapes:
            reach = shape.radius[:, None] if isinstance(shape, Motion) else 0.0
            places = self.picture_coordinates(shape, slice(None))[..., :2]
            corners += [(places - reach).reshape(-1, 2), (places + reach).reshape(-1, 2)]
        everything = np.concatenate(corners)
        low, high = everything.min(axis=0), everything.max(axis=0)
        room = 0.02 * float((high - low).max())
        return low - room, high + room


def load_plane(
    log: Any, scene_data: SceneData, times: Sequence[float] | None = None, colour: str | None = None
) -> Plane | None:
    """Read the shapes of a log at given times; None if no shape lies or moves in a plane or in space.

    Args:
        log: an open log.
        scene_data: scene data of the whole log, which set the displacement factor and the colour scales.
        times: times of the pictures [s]; default: four times that include the first event.
        colour: a recorded output that colours the shapes, with a scale for these times.

    Raises:
        ParameterError: a time outside the recorded span, or an output that can colour no shape.
    """
    scales = make_scales(scene_data)
    if scales is None or not scene_data.is_plane:
        return None
    scene = load_shapes(log, _choose_instants(log, scene_data.shapes[0].times) if times is None else times, colour)
    if colour is not None:
        scales = make_scales(scene, scales.exaggeration) or scales
    return Plane(scene, scales)


def visible_events(log: Any) -> Sequence[Any]:
    """Return the events located at a drawn shape, or all events if there are none (for example ignition in a tube)."""
    happened, details = log.events(), log.event_details
    return [event for event in happened if event.kind in details and details[event.kind].counts] or happened


def _choose_instants(log: Any, clock: FloatArray) -> list[float]:
    """Return four times [s]: the start, the first event (else a third of the run), one between it and the end, and the end."""
    start, end = float(clock[0]), float(clock[-1])
    third, events = start + (end - start) / 3.0, visible_events(log)
    first = events[0].tick * log.step_size if events else third
    if not _MARGIN <= (first - start) / max(end - start, 1e-300) <= 1.0 - _MARGIN:
        first = third  # the first event is too close to the start or the end
    return [start, first, 0.5 * (first + end), end]


@use_style
def draw_plane(plane: Plane) -> Figure:
    """Draw the plane at each of its times, with a colour bar for each quantity."""
    low, high = plane.bounding_box
    width, height = (high - low).tolist()
    bars, times = plane.scales.colours, plane.times
    columns = 2 if width < _TWO_ABREAST * height and len(times) > 1 else 1
    rows = -(-len(times) // columns)
    tall = min(_WIDTH / columns * height / width + 0.35, _LARGEST_HEIGHT)
    figure = new_figure(_WIDTH, rows * tall + 0.7 * len(bars) + _LENGTH_HEIGHT)
    panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    for frame, axes in enumerate(panels[: len(times)]):
        draw_instant(axes, plane, frame)
        axes.set_title(f"t = {instant_text(plane, frame)}", fontsize=11)
    for axes in panels[len(times) :]:
        axes.set_visible(False)
    _add_scale_bar(panels[0], plane)
    if stretched := exaggeration_text(plane):
        figure.supxlabel(stretched, x=0.0, horizontalalignment="left", fontsize=10)
    for one in bars:
        add_colour_bar(figure, one, ax=panels, shrink=0.5, aspect=40, pad=0.02)
    return figure


def instant_text(plane: Plane, frame: int) -> str:
    """Return the label of a frame: its time and, if the results have ceased to be valid before it, a note on that."""
    scale, unit = time_unit(float(plane.times[-1]))
    time = plane.times[frame]
    return f"{time * scale:.4g} {unit}{'' if time < plane.scene.valid_until else ', not valid'}"


def _add_scale_bar(axes: Axes, plane: Plane) -> None:
    """Draw a scale bar of a round length below a picture."""
    low, high = plane.bounding_box
    length = round_down_to_125(_LENGTH_PART * float(high[0] - low[0]))
    axes.add_artist(
        AnchoredSizeBar(
            axes.transData, length, EngFormatter("m")(length), "upper left", bbox_to_anchor=(0.0, 0.0),
            bbox_transform=axes.transAxes, borderpad=0.0, pad=0.3, sep=3, frameon=False,
        )
    )  # fmt: skip


def draw_instant(axes: Axes, plane: Plane, frame: int) -> None:
    """Draw one frame into axes that cover the bounding box of the shapes in all frames."""
    low, high = plane.bounding_box
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    for mesh in plane.scene.meshes:
        _draw_cells(axes, plane, mesh, frame)
    for motion in plane.scene.motions:
        _draw_points(axes, plane, motion, frame)
    for motion in plane.scene.motions:
        for links in motion.links:
            _draw_links(axes, plane, motion, links, frame)


def _edge_width(axes: Axes, plane: Plane, size: float, least: float = _LEAST_EDGED) -> float:
    """Return the width of edges [point] for shapes of a size [m]; 0 if shapes are smaller than `least` [point] when drawn."""
    low, high = plane.bounding_box
    place, figure = axes.get_position(), axes.get_figure(root=True)
    assert figure is not None
    inches = figure.get_size_inches() * np.array([place.width, place.height])
    drawn = size * float((72.0 * inches / (high - low)).min())
    return min(_WIDEST_EDGE, _EDGE_PART * drawn) if drawn >= least else 0.0


def _draw_points(axes: Axes, plane: Plane, motion: Motion, frame: int) -> None:
    places, size = plane.picture_coordinates(motion, frame)[:, :2], 2.0 * motion.radius
    width = _edge_width(axes, plane, float(np.median(size)))
    values = None if motion.colour is None else motion.colour[frame]
    discs = EllipseCollection(
        size, size, np.zeros(len(size)), units="xy", offsets=places, offset_transform=axes.transData, edgecolor=_EDGE,
        linewidth=width, facecolor=plane.scales.value_colours(motion.colour_variable, values, len(size)) / 255.0,
    )  # fmt: skip
    discs.set_rasterized(len(size) > _MOST_SHAPES)
    axes.add_collection(discs)
    if width and motion.rotation is not None:
        angle = motion.rotation[frame]
        along = motion.radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        _add_lines(axes, np.stack([places, places + along], axis=1), _SPOKE, 2.0 * width)


def _draw_cells(axes: Axes, plane: Plane, mesh: MeshFrames, frame: int) -> None:
    seen = plane.picture_coordinates(mesh, frame)
    shown = np.arange(len(mesh.connectivity)) if mesh.whole is None else np.flatnonzero(mesh.whole[frame])
    values = None if mesh.field is None else mesh.field[frame]
    if values is not None and not mesh.has_cell_values:
        values = values[mesh.connectivity].mean(axis=1)
    colours = plane.scales.value_colours(mesh.field_variable, values, len(mesh.connectivity)) / 255.0
    if plane.scene.is_solid:
        # Draw the nearest cells last, so that they hide the others.
        shown = shown[np.argsort(seen[mesh.connectivity[shown], 2].mean(axis=1), kind="stable")]
        colours = _shade_colours(colours, seen[mesh.connectivity])
    corners = seen[mesh.connectivity[shown]][..., :2]
    size = float(np.sqrt(np.median(np.ptp(corners, axis=1).prod(axis=1)))) if len(corners) else 0.0
    width = min(0.2, _edge_width(axes, plane, size, _LEAST_EDGED_CELL))
    # Without edge lines, antialiasing would leave seams between cells.
    edge = {"edgecolor": _EDGE, "linewidth": width} if width else {"linewidth": 0.0, "antialiased": False}
    shapes = PolyCollection(list(corners), facecolor=colours[shown], **edge)
    # Rasterise shapes without lines: browsers round narrow ones to whole pixels, which leaves gaps.
    shapes.set_rasterized(len(corners) > _MOST_SHAPES or not width)
    axes.add_collection(shapes)


def _shade_colours(colours: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the colours of cells as lit from the eye; the inside of a body, seen through gaps, gets a dark colour.

    Args:
        colours: colours of the cells, shape (m, 3).
        corners: corners of each cell in picture coordinates, shape (m, k, 3).
    """
    normal = area_vectors(corners)
    length = np.maximum(np.sqrt((normal * normal).sum(axis=1)), 1e-300)
    towards = (normal[:, 2] / length)[:, None]
    return np.where(towards > 0.0, colours * (1.0 - _SHADE * (1.0 - np.abs(towards))), _INSIDE)


def _draw_links(axes: Axes, plane: Plane, motion: Motion, links: LinkFrames, frame: int) -> None:
    """Draw the cracks and, unless they hide the points, the intact links."""
    places, state = plane.picture_coordinates(motion, frame)[:, :2], links.state[frame]
    width = _edge_width(axes, plane, 2.0 * float(np.median(motion.radius)))
    if len(links.pairs) <= MOST_LINES:
        _add_lines(axes, places[links.pairs[state != 0.0]], _LINK, 2.0)
    _add_lines(axes, crack_lines(places, motion.reference[:, :2], links.pairs, state), _CRACK, max(3.0 * width, 0.5))


def _add_lines(axes: Axes, lines: FloatArray, colour: str, width: float) -> None:
    shapes = LineCollection(list(lines), colors=colour, linewidths=width, capstyle="round")
    shapes.set_rasterized(len(lines) > _MOST_SHAPES)
    axes.add_collection(shapes)


def exaggeration_text(plane: Plane) -> str:
    """Return sentences on the factor by which displacements are drawn larger; "" if they are true to scale."""
    sentences = [] if plane.scales.exaggeration == 1.0 else [f"Displacements drawn {plane.scales.exaggeration:g} x larger."]
    if still := plane.scene.unmoved_shapes:
        sentences.append(f"Drawn at the initial positions, because no displacements were recorded: {', '.join(still)}.")
    return " ".join(sentences)


def plane_text(plane: Plane) -> str:
    """Return sentences on what the pictures show: shapes, colours and viewpoint."""
    links = [one for motion in plane.scene.motions for one in motion.links]
    names = ", ".join(one.name.replace("_", " ") for one in (*plane.scene.shapes, *links))
    axes = "" if plane.scene.is_solid else ", x to the right, y up"
    sentences = [f"{names.capitalize()} at chosen instants{axes}.", exaggeration_text(plane), *picture_sentences(plane.scene)]
    return " ".join(filter(None, sentences))
