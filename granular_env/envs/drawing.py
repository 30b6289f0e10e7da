"""A picture of a component in numpy alone: its particles, what colours them, and the inputs it feels.

From the top: time and inputs in words; the particles in true size and place, coloured by velocity (blue to the left, red to the
right), and its walls; the same values as bars under each particle, with what is wanted of them as dark marks. A component
without particles shows its observed outputs as bars.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..components.component import Component
from .font import text_mask
from .task import Task

Image = npt.NDArray[np.uint8]
WIDTH, HEIGHT = 960, 360
_MARGIN = 40
_GRAINS_ROW, _BARS_ROW, _BARS_REACH = 105, 255, 72

_PAPER, _INK, _PALE = (255, 255, 255), (40, 40, 48), (205, 205, 212)
_BLUE, _GREY, _RED = np.array([33.0, 102.0, 172.0]), np.array([225.0, 225.0, 228.0]), np.array([178.0, 24.0, 43.0])


def draw(
    component: Component,
    task: Task,
    walls: tuple[bool, bool] = (False, False),
    wanted: npt.NDArray[np.float64] | None = None,
) -> Image:
    """Return a picture of the present state, shape (360, 960, 3), uint8.

    Args:
        component: what is drawn.
        task: gives names and scales.
        walls: whether there is one at the left and at the right end.
        wanted: of each particle, what its coloured quantity should be now; None where nothing is wanted.
    """
    image = np.empty((HEIGHT, WIDTH, 3), dtype=np.uint8)
    image[:] = _PAPER
    _write(image, 16, _MARGIN, _caption(component, task), scale=2)
    if component.particles() is None:
        _draw_outputs(image, component, task)
    else:
        _draw_particles(image, component, task, walls, wanted)
    return image


def _caption(component: Component, task: Task) -> str:
    parts = [task.name, f"t = {component.time * 1e3:.4f} ms" if component.step_size < 1e-3 else f"t = {component.time:.2f} s"]
    for name in task.actions:
        parts.append(f"{name} = {component.get(name):+.2f} {component.variables[name].unit}")
    return "   ".join(parts)


def _draw_particles(
    image: Image, component: Component, task: Task, walls: tuple[bool, bool], wanted: npt.NDArray[np.float64] | None
) -> None:
    particles = component.particles()
    assert particles is not None
    along = particles.reference[:, 0]
    begin, end = float((along - particles.radius).min()), float((along + particles.radius).max())
    pixels = (WIDTH - 2 * _MARGIN) / (end - begin)
    moved = component.get(particles.displacement)
    moved = moved if moved.ndim == 1 else moved[:, 0]
    values = component.get(particles.colour)
    variable = component.variables[particles.colour]
    scale = task.observations.get(particles.colour) or float(np.abs(values).max()) or 1.0
    colours = _colours(values / scale)
    image[_GRAINS_ROW - 1 : _GRAINS_ROW + 1, _MARGIN : WIDTH - _MARGIN] = _PALE
    for place, shift, radius, colour in zip(along, moved, particles.radius, colours, strict=True):
        _disc(image, _GRAINS_ROW, _MARGIN + (place + shift - begin) * pixels, max(radius * pixels, 1.5), colour)
    half = 0.4 * pixels * float(np.diff(along).min()) if len(along) > 1 else 8.0
    _draw_axis(image, f"{particles.colour} of each particle, {variable.unit}", scale)
    for place, value, colour in zip(along, values / scale, colours, strict=True):
        _bar(image, _MARGIN + (place - begin) * pixels, half, value, colour)
    for side, column in ((0, _MARGIN - 8), (1, WIDTH - _MARGIN)):
        if walls[side]:
            image[_GRAINS_ROW - 40 : _GRAINS_ROW + 40, column : column + 8] = _INK
    for place, value in zip(along, [] if wanted is None else wanted / scale, strict=wanted is not None):
        column, row = _MARGIN + (place - begin) * pixels, _BARS_ROW - round(float(np.clip(value, -1.0, 1.0)) * _BARS_REACH)
        if row != _BARS_ROW:
            image[row - 1 : row + 2, max(round(column - half) - 1, 0) : round(column + half) + 2] = _INK


def _draw_outputs(image: Image, component: Component, task: Task) -> None:
    values = [np.ravel(component.get(name)) / scale for name, scale in task.observations.items()]
    flat = np.concatenate(values)
    pitch = (WIDTH - 2 * _MARGIN) / len(flat)
    _draw_axis(
        image,
        ", ".join(f"{name} / {scale:g} {component.variables[name].unit}" for name, scale in task.observations.items()),
        1.0,
    )
    for index, (value, colour) in enumerate(zip(flat, _colours(flat), strict=True)):
        _bar(image, _MARGIN + (index + 0.5) * pitch, min(0.4 * pitch, 30.0), value, colour)


def _draw_axis(image: Image, title: str, scale: float) -> None:
    image[_BARS_ROW, _MARGIN : WIDTH - _MARGIN] = _INK
    for side in (-1, 1):
        image[_BARS_ROW - side * _BARS_REACH, _MARGIN : WIDTH - _MARGIN : 4] = _PALE
        _write(image, _BARS_ROW - side * _BARS_REACH - 5, 4, f"{side * scale:+.4g}", scale=2)
    _write(image, _BARS_ROW + _BARS_REACH + 14, _MARGIN, title, scale=2)


def _bar(image: Image, centre: float, half: float, value: float, colour: npt.NDArray[np.uint8]) -> None:
    left, right = round(centre - max(half, 0.5)), round(centre + max(half, 0.5))
    height = round(float(np.clip(value, -1.0, 1.0)) * _BARS_REACH)
    top, bottom = (_BARS_ROW - height, _BARS_ROW) if height > 0 else (_BARS_ROW + 1, _BARS_ROW + 1 - height)
    image[top:bottom, max(left, 0) : max(right, left + 1)] = colour


def _disc(image: Image, row: float, column: float, radius: float, colour: npt.NDArray[np.uint8]) -> None:
    """A filled circle with a darker rim; what lies outside the picture is cut."""
    reach = int(radius) + 2
    top, left = max(int(row) - reach, 0), max(int(column) - reach, 0)
    window = image[top : max(int(row) + reach, 0), left : max(int(column) + reach, 0)]
    if not window.size:
        return
    rows, columns = np.ogrid[top : top + window.shape[0], left : left + window.shape[1]]
    distance = np.sqrt((rows + 0.5 - row) ** 2 + (columns + 0.5 - column) ** 2)
    window[distance <= radius] = colour // 2
    window[distance <= radius - 1.0] = colour


def _colours(values: npt.NDArray[np.float64]) -> npt.NDArray[np.uint8]:
    """Blue at -1, grey at 0, red at 1; shape (n, 3)."""
    # The root lets weak motion show.
    strength = np.sqrt(np.clip(np.abs(values), 0.0, 1.0))[:, None]
    ends = np.where(values[:, None] < 0.0, _BLUE, _RED)
    return (_GREY + strength * (ends - _GREY)).astype(np.uint8)


def _write(image: Image, row: int, column: int, text: str, scale: int) -> None:
    mask = text_mask(text, scale)
    window = image[row : row + mask.shape[0], column : column + mask.shape[1]]
    window[mask[: window.shape[0], : window.shape[1]]] = _INK
