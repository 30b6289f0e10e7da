"""A small picture of a component: its particles, what colours them, and the inputs it feels.

From the top: time and inputs in words; the particles in true size and place, coloured by velocity (blue to the left, red to the
right); the same values as bars under each particle, with what is wanted of them as dark marks. Particles in a plane, and cells,
are seen from above. A component without either shows its observed outputs as bars.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from granular_env.colours import diverging
from granular_env.viewing.visible_drawables import visible_points

from ..components.component import Component
from ..components.drawables import Cells, Points, main_points
from ..components.support.float_arrays import FloatArray
from ..components.variables import parse_element
from .task import Task

Colour = tuple[int, ...]
WIDTH, HEIGHT = 960, 360
_MARGIN, _LETTERS = 40, 16
_POINTS_ROW, _BARS_ROW, _BARS_REACH = 105, 255, 72

_PAPER, _INK, _PALE = (255, 255, 255), (40, 40, 48), (205, 205, 212)
_ZERO = "#e1e1e4"


def draw(component: Component, task: Task, wanted: FloatArray | None = None) -> npt.NDArray[np.uint8]:
    """Return a picture of the present state, shape (360, 960, 3), uint8.

    Args:
        component: what is drawn.
        task: gives names and scales.
        wanted: of each particle, what its coloured quantity should be now; None where nothing is wanted.
    """
    image = Image.new("RGB", (WIDTH, HEIGHT), _PAPER)
    pen = ImageDraw.Draw(image)
    _write(pen, _MARGIN, 24, _caption(component, task))
    drawables = component.drawables()
    points, cells = main_points(visible_points(drawables)), [one for one in drawables if isinstance(one, Cells)]
    if cells or (points is not None and component.get(points.displacement).ndim == 2):
        _draw_plane(pen, component, task, [] if points is None else [points], cells)
    elif points is not None:
        _draw_row(pen, component, task, points, wanted)
    else:
        outputs = [(parse_element(name), scale) for name, scale in task.observations.items()]
        values = np.concatenate([np.ravel(one.of(component.get(one.name))) / scale for one, scale in outputs])
        title = ", ".join(f"{one} / {scale:g} {component.variables[one.name].unit}" for one, scale in outputs)
        pitch = (WIDTH - 2 * _MARGIN) / len(values)
        _draw_bars(pen, _MARGIN + (np.arange(len(values)) + 0.5) * pitch, min(0.4 * pitch, 30.0), values)
        _draw_axis(pen, title, 1.0)
    return np.array(image)


def _caption(component: Component, task: Task) -> str:
    parts = [task.name, f"t = {component.time * 1e3:.4f} ms" if component.step_size < 1e-3 else f"t = {component.time:.2f} s"]
    for name in task.actions:
        element = parse_element(name)
        value, unit = element.of(component.get(element.name)), component.variables[element.name].unit
        parts.append(
            f"{name} = {value:+.3g} {unit}" if np.ndim(value) == 0 else f"|{name}| <= {np.abs(value).max():.3g} {unit}"
        )
    return "      ".join(parts)


def _draw_plane(pen: ImageDraw.ImageDraw, component: Component, task: Task, points: list[Points], cells: list[Cells]) -> None:
    """Draw points and cells as seen from above, in the room below the caption."""
    corners = [one.nodes[:, :2] for one in cells]
    for one in points:
        corners += [one.reference[:, :2] - one.radius[:, None], one.reference[:, :2] + one.radius[:, None]]
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    pixels = float(((WIDTH - 2 * _MARGIN, HEIGHT - 2 * _MARGIN) / (high - low)).min())
    middle = np.array([WIDTH / 2, HEIGHT / 2 + _MARGIN / 2])

    def places(rest: FloatArray, displacement: str) -> FloatArray:
        moved = component.get(displacement) if displacement else np.zeros_like(rest)
        shift = moved[:, :2] if moved.ndim == 2 else np.stack([moved, np.zeros_like(moved)], axis=1)
        return middle + (rest[:, :2] + shift - 0.5 * (low + high)) * (pixels, -pixels)

    for one in cells:
        nodes, (values, _) = places(one.nodes, one.displacement), _scaled(component, task, one.field, len(one.connectivity))
        whole = values if len(values) == len(one.connectivity) else values[one.connectivity].mean(axis=1)
        for corner, colour in zip(nodes[one.connectivity], colours_of(whole), strict=True):
            pen.polygon([tuple(place) for place in corner.tolist()], colour)
    for one in points:
        values, _ = _scaled(component, task, one.colour, len(one.radius))
        _draw_discs(pen, places(one.reference, one.displacement), one.radius * pixels, values)


def _draw_row(pen: ImageDraw.ImageDraw, component: Component, task: Task, particles: Points, wanted: FloatArray | None) -> None:
    """Draw particles along a line, and the quantity that colours them as bars below."""
    along, radius = particles.reference[:, 0], particles.radius
    begin, end = float((along - radius).min()), float((along + radius).max())
    pixels = (WIDTH - 2 * _MARGIN) / (end - begin)
    values, scale = _scaled(component, task, particles.colour, len(along))
    moved = component.get(particles.displacement).reshape(len(along), -1)[:, 0]
    columns = _MARGIN + (along - begin) * pixels
    pen.rectangle((_MARGIN, _POINTS_ROW - 1, WIDTH - _MARGIN, _POINTS_ROW), _PALE)
    _draw_discs(pen, np.stack([columns + moved * pixels, np.full(len(along), _POINTS_ROW)], axis=1), radius * pixels, values)
    half = 0.4 * pixels * float(np.diff(along).min()) if len(along) > 1 else 8.0
    title = f"{particles.colour} of each particle, {component.variables[particles.colour].unit}" if particles.colour else ""
    _draw_axis(pen, title, scale)
    _draw_bars(pen, columns, half, values)
    for column, value in () if wanted is None else zip(columns, np.clip(wanted / scale, -1.0, 1.0), strict=True):
        if row := round(float(value) * _BARS_REACH):
            pen.rectangle((round(column - half) - 1, _BARS_ROW - row - 1, round(column + half) + 1, _BARS_ROW - row + 1), _INK)


def _scaled(component: Component, task: Task, name: str, count: int) -> tuple[FloatArray, float]:
    """Return an output in units of the task's scale of it, and that; of the largest magnitude, where it is not observed."""
    values = component.get(name) if name else np.zeros(count)
    scale = task.observations.get(name) or float(np.abs(values).max()) or 1.0
    return values / scale, scale


def _draw_axis(pen: ImageDraw.ImageDraw, title: str, scale: float) -> None:
    pen.line((_MARGIN, _BARS_ROW, WIDTH - _MARGIN, _BARS_ROW), _INK)
    for side in (-1, 1):
        row = _BARS_ROW - side * _BARS_REACH
        pen.point([(column, row) for column in range(_MARGIN, WIDTH - _MARGIN, 4)], _PALE)
        _write(pen, 4, row, f"{side * scale:+.4g}")
    _write(pen, _MARGIN, _BARS_ROW + _BARS_REACH + 19, title)


def _draw_bars(pen: ImageDraw.ImageDraw, columns: FloatArray, half: float, values: FloatArray) -> None:
    for column, value, colour in zip(columns, np.clip(values, -1.0, 1.0), colours_of(values), strict=True):
        if height := round(float(value) * _BARS_REACH):
            left, right = round(column - max(half, 0.5)), round(column + max(half, 0.5))
            top, bottom = (_BARS_ROW - height, _BARS_ROW - 1) if height > 0 else (_BARS_ROW + 1, _BARS_ROW - height)
            pen.rectangle((left, top, max(right - 1, left), bottom), colour)


def _draw_discs(pen: ImageDraw.ImageDraw, places: FloatArray, radii: FloatArray, values: FloatArray) -> None:
    """Draw filled circles with darker rims."""
    for (column, row), radius, colour in zip(places, np.maximum(radii, 1.5), colours_of(values), strict=True):
        box = (column - radius, row - radius, column + radius, row + radius)
        pen.ellipse(box, colour, tuple(channel // 2 for channel in colour))


def colours_of(values: FloatArray) -> list[Colour]:
    """Return blue at -1, grey at 0, red at 1."""
    # The root lets weak motion show.
    strength = np.sign(values) * np.sqrt(np.clip(np.abs(values), 0.0, 1.0))
    return [tuple(colour) for colour in diverging(strength, 1.0, _ZERO).tolist()]


def _write(pen: ImageDraw.ImageDraw, column: int, row: int, text: str) -> None:
    """Write a line of text that begins at a column, centred on a row."""
    pen.text((column, row), text, _INK, _font(), anchor="lm")


@cache
def _font() -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(_LETTERS)
