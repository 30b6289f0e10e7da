"""A small picture of a component: its particles, what colours them, and the inputs it feels.

From the top: time and inputs in words; the particles in true size and place, coloured by velocity (blue to the left, red to the
right), and its walls; the same values as bars under each particle, with what is wanted of them as dark marks. Particles in
a plane, and cells, are seen from above. A component without either shows its observed outputs as bars.
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
from ..components.variables import parse_element
from .task import Task

Colour = tuple[int, ...]
WIDTH, HEIGHT = 960, 360
_MARGIN = 40
_POINTS_ROW, _BARS_ROW, _BARS_REACH = 105, 255, 72
_LETTERS = 16

_PAPER, _INK, _PALE = (255, 255, 255), (40, 40, 48), (205, 205, 212)
_ZERO = "#e1e1e4"


def draw(
    component: Component,
    task: Task,
    wanted: npt.NDArray[np.float64] | None = None,
) -> npt.NDArray[np.uint8]:
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
        _draw_outputs(pen, component, task)
    return np.array(image)


def _caption(component: Component, task: Task) -> str:
    parts = [task.name, f"t = {component.time * 1e3:.4f} ms" if component.step_size < 1e-3 else f"t = {component.time:.2f} s"]
    for name in task.actions:
        element = parse_element(name)
        value, unit = element.of(component.get(element.name)), component.variables[element.name].unit
        largest = float(np.abs(value).max())
        amount = f"{value:+.2f}" if np.ndim(value) == 0 else f"{largest:.2f}"
        if largest >= 1e5 or 0.0 < largest < 0.01:
            amount = f"{value:+.3g}" if np.ndim(value) == 0 else f"{largest:.3g}"
        shown = f"{name} = {amount}" if np.ndim(value) == 0 else f"|{name}| <= {amount}"
        parts.append(f"{shown} {unit}")
    return "      ".join(parts)


def _draw_plane(pen: ImageDraw.ImageDraw, component: Component, task: Task, points: list[Points], cells: list[Cells]) -> None:
    """Draw points and cells as seen from above, in the room below the caption."""
    corners = [one.nodes[:, :2] for one in cells]
    for one in points:
        corners += [one.reference[:, :2] - one.radius[:, None], one.reference[:, :2] + one.radius[:, None]]
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    pixels = float(((WIDTH - 2 * _MARGIN, HEIGHT - 2 * _MARGIN) / (high - low)).min())
    middle = np.array([WIDTH / 2, HEIGHT / 2 + _MARGIN / 2])

    def places(rest: npt.NDArray[np.float64], displacement: str) -> npt.NDArray[np.float64]:
        moved = component.get(displacement) if displacement else np.zeros_like(rest)
        shift = moved[:, :2] if moved.ndim == 2 else np.stack([moved, np.zeros_like(moved)], axis=1)
        return middle + (rest[:, :2] + shift - 0.5 * (low + high)) * (pixels, -pixels)

    for one in cells:
        nodes, values = places(one.nodes, one.displacement), _parts(component, task, one.field)
        whole = values if len(values) == len(one.connectivity) else values[one.connectivity].mean(axis=1)
        for corner, colour in zip(nodes[one.connectivity], _colours(whole), strict=True):
            pen.polygon([tuple(place) for place in corner.tolist()], colour)
    for one in points:
        values = _parts(component, task, one.colour) if one.colour else np.zeros(len(one.radius))
        for (column, row), size, colour in zip(
            places(one.reference, one.displacement), one.radius, _colours(values), strict=True
        ):
            _disc(pen, column, row, max(size * pixels, 1.5), colour)


def _parts(component: Component, task: Task, name: str) -> npt.NDArray[np.float64]:
    """Return an output in units of the task's scale of it; of the largest magnitude, where it is not observed."""
    values = component.get(name)
    return values / (task.observations.get(name) or float(np.abs(values).max()) or 1.0)


def _draw_row(
    pen: ImageDraw.ImageDraw,
    component: Component,
    task: Task,
    particles: Points,
    wanted: npt.NDArray[np.float64] | None,
) -> None:
    along = particles.reference[:, 0]
    begin, end = float((along - particles.radius).min()), float((along + particles.radius).max())
    pixels = (WIDTH - 2 * _MARGIN) / (end - begin)
    moved = component.get(particles.displacement)
    moved = moved if moved.ndim == 1 else moved[:, 0]
    values = component.get(particles.colour) if particles.colour else np.zeros(len(along))
    title = f"{particles.colour} of each particle, {component.variables[particles.colour].unit}" if particles.colour else ""
    scale = task.observations.get(particles.colour) or float(np.abs(values).max()) or 1.0
    colours = _colours(values / scale)
    pen.rectangle((_MARGIN, _POINTS_ROW - 1, WIDTH - _MARGIN, _POINTS_ROW), _PALE)
    for place, shift, radius, colour in zip(along, moved, particles.radius, colours, strict=True):
        _disc(pen, _MARGIN + (place + shift - begin) * pixels, _POINTS_ROW, max(radius * pixels, 1.5), colour)
    half = 0.4 * pixels * float(np.diff(along).min()) if len(along) > 1 else 8.0
    _draw_axis(pen, title, scale)
    for place, value, colour in zip(along, values / scale, colours, strict=True):
        _bar(pen, _MARGIN + (place - begin) * pixels, half, value, colour)
    for place, value in zip(along, [] if wanted is None else wanted / scale, strict=wanted is not None):
        column, row = _MARGIN + (place - begin) * pixels, _BARS_ROW - round(float(np.clip(value, -1.0, 1.0)) * _BARS_REACH)
        if row != _BARS_ROW:
            pen.rectangle((round(column - half) - 1, row - 1, round(column + half) + 1, row + 1), _INK)


def _draw_outputs(pen: ImageDraw.ImageDraw, component: Component, task: Task) -> None:
    elements = {parse_element(name): scale for name, scale in task.observations.items()}
    values = [np.ravel(one.of(component.get(one.name))) / scale for one, scale in elements.items()]
    flat = np.concatenate(values)
    pitch = (WIDTH - 2 * _MARGIN) / len(flat)
    _draw_axis(
        pen,
        ", ".join(f"{one} / {scale:g} {component.variables[one.name].unit}" for one, scale in elements.items()),
        1.0,
    )
    for index, (value, colour) in enumerate(zip(flat, _colours(flat), strict=True)):
        _bar(pen, _MARGIN + (index + 0.5) * pitch, min(0.4 * pitch, 30.0), value, colour)


def _draw_axis(pen: ImageDraw.ImageDraw, title: str, scale: float) -> None:
    pen.line((_MARGIN, _BARS_ROW, WIDTH - _MARGIN, _BARS_ROW), _INK)
    for side in (-1, 1):
        row = _BARS_ROW - side * _BARS_REACH
        pen.point([(column, row) for column in range(_MARGIN, WIDTH - _MARGIN, 4)], _PALE)
        _write(pen, 4, row, f"{side * scale:+.4g}")
    _write(pen, _MARGIN, _BARS_ROW + _BARS_REACH + 19, title)


def _bar(pen: ImageDraw.ImageDraw, centre: float, half: float, value: float, colour: Colour) -> None:
    left, right = round(centre - max(half, 0.5)), round(centre + max(half, 0.5))
    height = round(float(np.clip(value, -1.0, 1.0)) * _BARS_REACH)
    if height:
        top, bottom = (_BARS_ROW - height, _BARS_ROW - 1) if height > 0 else (_BARS_ROW + 1, _BARS_ROW - height)
        pen.rectangle((left, top, max(right - 1, left), bottom), colour)


def _disc(pen: ImageDraw.ImageDraw, column: float, row: float, radius: float, colour: Colour) -> None:
    """Draw a filled circle with a darker rim."""
    box = (column - radius, row - radius, column + radius, row + radius)
    pen.ellipse(box, colour, tuple(channel // 2 for channel in colour))


def _colours(values: npt.NDArray[np.float64]) -> list[Colour]:
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
