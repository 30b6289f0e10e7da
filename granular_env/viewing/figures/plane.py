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

from granular_env.colours import ColourScale
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.preview.visible_drawables import area_vectors

from ..cracks import MOST_LINES, corner_pieces, crack_lines
from ..picture_sentences import picture_sentences
from ..recorded_fields import located_events
from ..scene_builder import load_shapes
from ..scene_data import LinkFrames, MeshFrames, Motion, SceneData, drawn_positions
from ..scene_scales import Scales, make_scales
from .drawing import new_figure, time_unit, use_style
from .keys import draw_keys, keys_height
from .overlays import Overlay, load_overlays

# Pictures with more shapes than this are embedded as pixels: a page with one SVG path for each shape would be slow.
_MOST_SHAPES = 400
_WIDTH, _TWO_ABREAST, _LARGEST_HEIGHT = 8.0, 2.5, 4.5  # inch, width over height, inch
# Colours of edges, links, cracks, spokes, and of bodies below force chains or crosses. Intact links are thin, cracks thick.
_EDGE, _LINK, _CRACK, _SPOKE, _PALE, _PALE_EDGE = "#737373", "#5b6068", "#101214", "#808080", (0.9, 0.91, 0.92), "#c4c8cc"
_LINK_WIDTH, _CRACK_WIDTH = 0.7, 1.1  # point
_WIDEST_EDGE, _EDGE_PART, _LEAST_EDGED = 0.6, 1.0 / 16.0, 3.0  # largest width [point], part of the size, smallest size [point]
# Smallest cell drawn with edges [point]: cells touch, and the edges of smaller cells would hide the colours.
_LEAST_EDGED_CELL = 8.0
# Light comes from the eye: the more a cell faces away, the darker it is, by up to this fraction; the inside has this colour.
_SHADE, _INSIDE = 0.35, np.array([0.23, 0.24, 0.26])
# Brightness of broken cells.
_BROKEN = 0.45
# Events closer than this to the start or the end, as a fraction of the run, get no extra picture.
_MARGIN = 0.05


@dataclass(frozen=True)
class Plane:
    """The shapes of a scene (in a plane or in space) in the frames to be drawn as pictures, and the scales of the pictures."""

    scene: SceneData
    scales: Scales
    overlays: tuple[Overlay, ...] = ()
    is_pale: bool = False
    """Whether the shapes have no colours, so that the overlays are easy to see."""

    @property
    def colour_scales(self) -> tuple[ColourScale, ...]:
        """The colour scales of the drawn shapes."""
        return () if self.is_pale else self.scales.colours

    def points_per_metre(self, axes: Axes) -> float:
        """Return the scale of a picture [point/m]."""
        (low, high), figure = self.bounding_box, axes.get_figure(root=True)
        assert figure is not None
        return 72.0 / figure.dpi * float((np.array([axes.bbox.width, axes.bbox.height]) / (high - low)).min())

    def fill_colours(self, variable: Variable, values: FloatArray | None, count: int) -> FloatArray:
        """Return the colours of `count` points or cells with the values of an output, shape (count, 3)."""
        if self.is_pale:
            return np.broadcast_to(np.array(_PALE), (count, 3))
        return self.scales.value_colours(variable, values, count) / 255.0

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
        """The corners of the bounding box of all shapes in all frames, with room for arrows [m]."""
        corners = []
        for shape in self.scene.shapes:
            reach = shape.radius[:, None] if isinstance(shape, Motion) else 0.0
            places = self.picture_coordinates(shape, slice(None))[..., :2]
            corners += [(places - reach).reshape(-1, 2), (places + reach).reshape(-1, 2)]
        everything = np.concatenate(corners)
        low, high = everything.min(axis=0), everything.max(axis=0)
        room = max(0.02 * float((high - low).max()), *(one.largest[0] for one in self.overlays), 0.0)
        return low - room, high + room


def load_plane(
    log: Any,
    scene_data: SceneData,
    times: Sequence[float] | None = None,
    colour: str | None = None,
    show: Sequence[str] = (),
) -> Plane | None:
    """Read the shapes of a log at given times; None if no shape lies or moves in a plane or in space.

    Args:
        log: an open log.
        scene_data: scene data of the whole log, which set the displacement factor and the colour scales.
        times: times of the pictures [s]; default: four times that include the first event.
        colour: a recorded output that colours the shapes, with a scale for these times.
        show: recorded vectors, stresses and link forces to draw over the shapes.

    Raises:
        ParameterError: a time outside the recorded span, or an output that can colour or be drawn over no shape.
    """
    scales = make_scales(scene_data)
    if scales is None or not scene_data.is_plane:
        return None
    scene = load_shapes(log, _choose_instants(log, scene_data.shapes[0].times) if times is None else times, colour)
    if colour is not None:
        scales = make_scales(scene, scales.exaggeration) or scales
    return add_overlays(log, Plane(scene, scales), show, may_be_pale=colour is None)


def add_overlays(log: Any, plane: Plane, show: Sequence[str], may_be_pale: bool) -> Plane:
    """Return the plane with overlays; below force chains and crosses, shapes without a chosen colour are pale."""
    overlays = load_overlays(log, plane.times, show)
    return Plane(plane.scene, plane.scales, overlays, may_be_pale and not all(one.kind == "arrow" for one in overlays))


def visible_events(log: Any) -> Sequence[Any]:
    """Return the events located at a drawn shape, or all events if there are none (for example ignition in a tube)."""
    return located_events(log) or log.events()


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
    (low, high), times = plane.bounding_box, plane.times
    columns = 2 if (high - low)[0] < _TWO_ABREAST * (high - low)[1] and len(times) > 1 else 1
    figure, panels = make_panels(plane, -(-len(times) // columns), columns)
    for frame, axes in enumerate(panels[: len(times)]):
        draw_instant(axes, plane, frame)
        axes.set_title(f"t = {instant_text(plane, frame)}", fontsize=11)
    for axes in panels[len(times) :]:
        axes.set_visible(False)
    return figure


def make_panels(plane: Plane, rows: int, columns: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with axes for pictures of a plane, in rows, and the keys below them."""
    low, high = plane.bounding_box
    tall = rows * min(_WIDTH / columns * (high - low)[1] / (high - low)[0] + 0.35, _LARGEST_HEIGHT)
    below = keys_height(plane)
    figure = new_figure(_WIDTH, tall + below)
    above, keys = figure.subfigures(2, 1, squeeze=False, height_ratios=[tall, below]).flat
    panels = above.subplots(rows, columns, squeeze=False).ravel().tolist()
    draw_keys(keys, panels[0], plane)
    return figure, panels


def instant_text(plane: Plane, frame: int) -> str:
    """Return the label of a frame: its time, with a note if the results are no longer valid."""
    scale, unit = time_unit(float(plane.times[-1]))
    time = plane.times[frame]
    return f"{time * scale:.4g} {unit}{'' if time < plane.scene.valid_until else ', not valid'}"


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
    for overlay in plane.overlays:
        overlay.draw(axes, plane, frame)


def _edge_width(axes: Axes, plane: Plane, size: float, least: float = _LEAST_EDGED) -> float:
    """Return the width of edges [point] for shapes of a size [m]; 0 if shapes are smaller than `least` [point] when drawn."""
    drawn = size * plane.points_per_metre(axes)
    return min(_WIDEST_EDGE, _EDGE_PART * drawn) if drawn >= least else 0.0


def _draw_points(axes: Axes, plane: Plane, motion: Motion, frame: int) -> None:
    places, size = plane.picture_coordinates(motion, frame)[:, :2], 2.0 * motion.radius
    width = _edge_width(axes, plane, float(np.median(size)))
    values = None if motion.colour is None else motion.colour[frame]
    fill, edge = plane.fill_colours(motion.colour_variable, values, len(size)), _PALE_EDGE if plane.is_pale else _EDGE
    discs = EllipseCollection(
        size, size, np.zeros(len(size)), units="xy", offsets=places, offset_transform=axes.transData, edgecolor=edge,
        linewidth=width, facecolor=fill,
    )  # fmt: skip
    discs.set_rasterized(len(size) > _MOST_SHAPES)
    axes.add_collection(discs)
    if width and motion.rotation is not None and not plane.is_pale:
        angle = motion.rotation[frame]
        along = motion.radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        _add_lines(axes, np.stack([places, places + along], axis=1), _SPOKE, 2.0 * width)


def _draw_cells(axes: Axes, plane: Plane, mesh: MeshFrames, frame: int) -> None:
    whole = np.ones(len(mesh.connectivity), bool) if mesh.whole is None else mesh.whole[frame]
    values = None if mesh.field is None else mesh.field[frame]
    if values is not None:  # one value per corner, shape (m, k)
        values = np.tile(values[:, None], mesh.connectivity.shape[1]) if mesh.has_cell_values else values[mesh.connectivity]
        values = np.concatenate([values[whole].mean(axis=1), values[~whole].ravel()])
    cells = plane.picture_coordinates(mesh, frame)[mesh.connectivity[whole]]
    # Broken cells are dark pieces that stay with the parts of the body, so that only opened cracks are gaps.
    moved = plane.scales.exaggeration * mesh.displacement[frame]
    pieces = corner_pieces(mesh.nodes, moved, mesh.connectivity[~whole]) @ plane.eye_axes
    polygons, order = [*cells[..., :2], *pieces[..., :2]], np.arange(len(cells) + len(pieces))
    colours = plane.fill_colours(mesh.field_variable, values, len(order))
    colours = np.where(order[:, None] < len(cells), 1.0, _BROKEN) * colours
    if plane.scene.is_solid:
        normals = np.concatenate([area_vectors(cells), area_vectors(pieces)])
        colours = _shade_colours(colours, normals)
        # Draw the nearest cells last, so that they hide the others.
        order = np.argsort(np.concatenate([one[..., 2].mean(axis=1) for one in (cells, pieces)]), kind="stable")
    size = float(np.sqrt(np.median(np.ptp(cells[..., :2], axis=1).prod(axis=1)))) if len(cells) else 0.0
    width = min(0.2, _edge_width(axes, plane, size, _LEAST_EDGED_CELL))
    # Without edge lines, antialiasing would leave seams between cells.
    edge = {"edgecolor": _EDGE, "linewidth": width} if width else {"linewidth": 0.0, "antialiased": False}
    shapes = PolyCollection([polygons[one] for one in order], facecolor=colours[order], **edge)
    # Rasterise shapes without lines: browsers round narrow ones to whole pixels, which leaves gaps.
    shapes.set_rasterized(len(polygons) > _MOST_SHAPES or not width)
    axes.add_collection(shapes)


def _shade_colours(colours: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the colours of cells, shape (m, 3), as lit from the eye; the inside of a body, seen through gaps, is dark."""
    length = np.maximum(np.sqrt((normals * normals).sum(axis=1)), 1e-300)
    towards = (normals[:, 2] / length)[:, None]
    return np.where(towards > 0.0, colours * (1.0 - _SHADE * (1.0 - np.abs(towards))), _INSIDE)


def _draw_links(axes: Axes, plane: Plane, motion: Motion, links: LinkFrames, frame: int) -> None:
    """Draw the cracks and, unless they hide the points, the intact links."""
    places, state = plane.picture_coordinates(motion, frame), links.state[frame]
    width = _edge_width(axes, plane, 2.0 * float(np.median(motion.radius)))
    if len(links.pairs) <= MOST_LINES:
        _add_lines(axes, places[links.pairs[state != 0.0], :2], _LINK, _LINK_WIDTH)
    cracks = crack_lines(places, motion.reference, links.pairs, state, np.array([0.0, 0.0, 1.0]))
    _add_lines(axes, cracks[..., :2], _CRACK, max(4.0 * width, _CRACK_WIDTH), zorder=4)  # above overlays


def _add_lines(axes: Axes, lines: FloatArray, colour: str, width: float, zorder: int = 2) -> None:
    shapes = LineCollection(list(lines), colors=colour, linewidths=width, capstyle="round", zorder=zorder)
    shapes.set_rasterized(len(lines) > _MOST_SHAPES)
    axes.add_collection(shapes)


def plane_text(plane: Plane) -> str:
    """Return sentences on what the pictures show: shapes, colours and viewpoint."""
    links = [one for motion in plane.scene.motions for one in motion.links]
    names = ", ".join(one.name.replace("_", " ") for one in (*plane.scene.shapes, *links))
    axes = "" if plane.scene.is_solid else ", x to the right, y up"
    return " ".join([f"{names.capitalize()} at chosen instants{axes}.", *picture_sentences(plane.scene)])
