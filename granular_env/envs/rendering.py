"""A small picture of a component: its particles, the quantity that colours them, and its inputs.

From the top: time and inputs as text; the particles to scale, coloured by velocity (blue to the left, red to the right); and a
graph of these values, with target values as dark dots. Particles in a plane and cells are seen from above. A component
without particles and cells shows a graph of its observed outputs. A task can choose other quantities (`Task.colours`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from granular_env.colours import diverging_colours
from granular_env.recording.preview.visible_drawables import colour_name, visible_points

from ..components.component import Component
from ..components.drawables import Cells, Links, Points, element_count, main_points
from ..components.support.float_arrays import FloatArray
from ..components.variables import parse_element
from .task import Task

Colour = tuple[int, ...]
WIDTH, HEIGHT = 960, 360
_MARGIN, _LETTERS = 40, 16
_POINTS_ROW, _GRAPH_ROW, _GRAPH_REACH, _DOT, _LARGE_DOT, _BAR = 105, 255, 72, 4.0, 12.0, 16

_PAPER, _INK, _PALE, _ZERO = (255, 255, 255), (40, 40, 48), (205, 205, 212), "#e1e1e4"


def draw_state(component: Component, task: Task, target: FloatArray | None = None) -> npt.NDArray[np.uint8]:
    """Return a picture of the present state, shape (360, 960, 3), uint8; `target`: wanted values of the particles' colours."""
    image = Image.new("RGB", (WIDTH, HEIGHT), _PAPER)
    pen = ImageDraw.Draw(image)
    pen.text((_MARGIN, 24), _caption(component, task), _INK, anchor="lm", font_size=_LETTERS)
    drawables = component.drawables()
    points, cells = main_points(visible_points(drawables)), [one for one in drawables if isinstance(one, Cells)]
    if points is None and not cells:
        outputs = [(parse_element(name), scale) for name, scale in task.observations.items()]
        values = np.concatenate([np.ravel(one.select_from(component.get(one.name))) / scale for one, scale in outputs])
        columns = _MARGIN + (np.arange(len(values)) + 0.5) * (WIDTH - 2 * _MARGIN) / len(values)
        _draw_graph(pen, columns, values, value_colours(values), _LARGE_DOT)
        return np.array(image)
    is_row = points is not None and not cells and component.get(points.displacement).ndim == 1
    row = _POINTS_ROW if is_row else HEIGHT // 2 + _MARGIN // 2
    columns = _draw_bodies(pen, component, task, [] if points is None else [points], cells, row)
    if points is not None and is_row:
        values = _scale_values(component, task, points.colour, component.get(points.colour))
        _draw_graph(pen, columns, values, value_colours(values), _DOT)
        if target is not None:
            _draw_graph(pen, columns, _scale_values(component, task, points.colour, target), [_INK] * len(columns), 0.5 * _DOT)
    return np.array(image)


def _caption(component: Component, task: Task) -> str:
    parts = [task.name, f"t = {component.time * 1e3:.4f} ms" if component.step_size < 1e-3 else f"t = {component.time:.2f} s"]
    for name in task.actions:
        element = parse_element(name)
        value, unit = element.select_from(component.get(element.name)), component.variables[element.name].unit
        amount = f"{name} = {value:+.3g}" if np.ndim(value) == 0 else f"|{name}| <= {np.abs(value).max():.3g}"
        parts.append(f"{amount} {unit}")
    return "      ".join(parts)


def _draw_bodies(
    pen: ImageDraw.ImageDraw, component: Component, task: Task, points: list[Points], cells: list[Cells], row: int
) -> FloatArray:
    """Draw points and cells from above, centred on pixel row `row`; return the pixel columns of the points' rest positions."""
    corners = [one.nodes[:, :2] for one in cells]
    for one in points:
        corners += [one.reference[:, :2] - one.radius[:, None], one.reference[:, :2] + one.radius[:, None]]
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    extent = np.maximum(high - low, 1e-300)
    pixels = float(((WIDTH - 2 * _MARGIN, HEIGHT - 2 * _MARGIN) / extent[: len(low)]).min())
    columns = np.zeros(0)

    def pixel_positions(reference: FloatArray, displacement: str) -> FloatArray:
        moved = component.get(displacement) if displacement else np.zeros_like(reference)
        shift = moved[:, :2] if moved.ndim == 2 else np.stack([moved, np.zeros_like(moved)], axis=1)
        return (WIDTH / 2, row) + (reference[:, :2] + shift - 0.5 * (low + high)) * (pixels, -pixels)

    given = task.colours(component)
    for one in cells:
        nodes = pixel_positions(one.nodes, one.displacement)
        values = given.get(one.name, _output_values(component, task, one))
        whole = values if len(values) == len(one.connectivity) else values[one.connectivity].mean(axis=1)
        for corner, colour in zip(nodes[one.connectivity], value_colours(whole), strict=True):
            pen.polygon([tuple(place) for place in corner.tolist()], colour)
    for one in points:
        places = pixel_positions(one.reference, one.displacement)
        values = given.get(one.name, _output_values(component, task, one))
        _draw_discs(pen, places, one.radius * pixels, value_colours(values))
        for links in component.drawables():
            if isinstance(links, Links) and links.points == one.name and links.name in given:
                _draw_links(pen, places[links.pairs], component.get(links.state), value_colours(given[links.name]))
        columns = pixel_positions(one.reference, "")[:, 0]
    return columns


def _draw_links(pen: ImageDraw.ImageDraw, ends: FloatArray, state: FloatArray, colours: list[Colour]) -> None:
    """Draw intact links as bars with dark rims between their ends, shape (m, 2, 2) [pixels]."""
    for k in np.flatnonzero(state).tolist():
        for colour, width in ((_INK, _BAR + 2), (colours[k], _BAR)):
            pen.line([tuple(place) for place in ends[k].tolist()], colour, width)


def _output_values(component: Component, task: Task, drawable: Points | Cells) -> FloatArray:
    """Return the values of the output that colours points or cells, divided by their scale; 0 without an output."""
    name = colour_name(drawable)
    return _scale_values(component, task, name, component.get(name)) if name else np.zeros(element_count(drawable))


def _scale_values(component: Component, task: Task, name: str, values: FloatArray) -> FloatArray:
    """Return values of an output over its scale in the task or, if it is not observed, over the largest magnitude."""
    return values / (task.observations.get(name) or float(np.abs(component.get(name)).max()) or 1.0)


def _draw_graph(pen: ImageDraw.ImageDraw, x: FloatArray, values: FloatArray, colours: list[Colour], radius: float) -> None:
    """Draw a dot for each value (already divided by the scale), and lines at 0 and at 1."""
    for level, colour in ((-1, _PALE), (0, _INK), (1, _PALE)):
        row = _GRAPH_ROW - level * _GRAPH_REACH
        pen.line((_MARGIN, row, WIDTH - _MARGIN, row), colour)
    rows = _GRAPH_ROW - np.clip(values, -1.0, 1.0) * _GRAPH_REACH
    _draw_discs(pen, np.stack([x, rows], axis=1), np.full(len(x), radius), colours)


def _draw_discs(pen: ImageDraw.ImageDraw, places: FloatArray, radii: FloatArray, colours: list[Colour]) -> None:
    """Draw filled circles with darker rims."""
    for (column, row), radius, colour in zip(places, np.maximum(radii, 1.5), colours, strict=True):
        box = (column - radius, row - radius, column + radius, row + radius)
        pen.ellipse(box, colour, tuple(channel // 2 for channel in colour))


def value_colours(values: FloatArray) -> list[Colour]:
    """Return the colour of each value: blue at -1, grey at 0, red at 1."""
    # The root makes weak motion visible.
    strength = np.sign(values) * np.sqrt(np.clip(np.abs(values), 0.0, 1.0))
    return [tuple(colour) for colour in diverging_colours(strength, 1.0, _ZERO).tolist()]
