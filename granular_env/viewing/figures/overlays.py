"""Recorded outputs drawn over the picture of a body: force chains, arrows of vectors, crosses of principal stresses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Rectangle
from scipy.spatial import KDTree

from granular_env.colours import DIVERGING, symmetric_limit
from granular_env.components.drawables import Cells, Drawable, Links, Points, to_three_columns
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.preview.visible_drawables import has_elements, visible_cells, visible_points

from ..recorded_fields import nearest_frame, recorded_outputs, sample_frames
from ..unit_labels import scaled_unit

if TYPE_CHECKING:
    from .plane import Plane

# Tension is positive in the blue-to-red colour map of stresses, so it is red here too.
_COMPRESSION, _TENSION, _ARROW = DIVERGING[0], DIVERGING[-1], "#1a1c1f"
# Most arrows or crosses along a body; lengths of the longest and width of a shaft, relative to their spacing.
_MOST_ALONG, _ARROW_LENGTH, _SHAFT, _CROSS_LENGTH = 40, 1.7, 0.09, 0.95
# Width of the widest force line, relative to the distance between its points; width of the lines of crosses [point].
_CHAIN_WIDTH, _CROSS_WIDTH = 0.4, 1.2
# This part of all magnitudes is below the limit; forces and vectors below this fraction of the limit are not drawn.
_USUAL, _LEAST = 0.97, 0.03
# Columns xx, yy, xy of stresses with three and with four entries per element.
_IN_PLANE = {3: (0, 1, 2), 4: (0, 1, 3)}


@dataclass(frozen=True)
class Overlay:
    """An output drawn over the elements of a drawable.

    Attributes:
        variable: name, unit and meaning of the output.
        values: values of the elements, shape (frames, n, ...).
        rest: initial positions of the points or of the elements' middles, shape (n, 3) [m].
        displacement: their displacements, shape (frames, n, 3) [m].
        limit: magnitude drawn with the greatest length or width; larger ones are drawn with the same.
    """

    variable: Variable
    values: FloatArray
    rest: FloatArray
    displacement: FloatArray
    limit: float

    def draw(self, axes: Axes, plane: Plane, frame: int) -> None:
        """Draw one frame."""
        raise NotImplementedError

    def key(self) -> list[tuple[Artist, str]]:
        """Return samples of the lines, in data coordinates, with their labels."""
        raise NotImplementedError

    def places(self, plane: Plane, frame: int) -> FloatArray:
        """Return the drawn positions in the picture, shape (n, 2) [m]."""
        return ((self.rest + plane.scales.exaggeration * self.displacement[frame]) @ plane.eye_axes)[:, :2]

    def label(self, words: str = "") -> str:
        """Return the limit with its unit, after the output's name or other words."""
        factor, unit = scaled_unit(self.variable.unit, self.limit)
        return f"{words or self.variable.name.replace('_', ' ')} \u2265 {self.limit * factor:.3g} {unit}"

    @cached_property
    def distance(self) -> float:
        """The usual distance between neighbouring elements [m]."""
        return float(np.median(KDTree(self.rest).query(self.rest, 2)[0][:, 1]))

    @cached_property
    def spacing(self) -> float:
        """The distance between drawn arrows or crosses [m]: a multiple of the elements' distance."""
        along = float(np.ptp(self.rest, axis=0).max()) / _MOST_ALONG
        return self.distance * max(1.0, float(np.ceil(along / self.distance - 1e-6)))

    @cached_property
    def thinned(self) -> npt.NDArray[np.int64]:
        """The indices of the drawn elements: one in each cube of the size `spacing` in the initial state."""
        cubes = np.floor((self.rest - self.rest.min(axis=0) + 0.5 * self.distance) / self.spacing)
        return np.unique(cubes, axis=0, return_index=True)[1]


@dataclass(frozen=True)
class ForceChains(Overlay):
    """Lines between linked points: the width is the magnitude of the force, the colour compression or tension.

    Attributes:
        pairs: indices of the two points of each link, shape (m, 2).
    """

    pairs: npt.NDArray[np.int64]

    def draw(self, axes: Axes, plane: Plane, frame: int) -> None:
        """Draw one frame, the largest forces last."""
        forces = self.values[frame]
        strength = np.minimum(np.abs(forces) / self.limit, 1.0)
        drawn = np.flatnonzero(strength > _LEAST)
        drawn = drawn[np.argsort(strength[drawn], kind="stable")]
        ends = self.places(plane, frame)[self.pairs[drawn]]
        along = ends[:, 1] - ends[:, 0]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
        reach = 0.5 * self.width * strength[drawn, None] * across
        corners = np.stack([ends[:, 0] - reach, ends[:, 0] + reach, ends[:, 1] + reach, ends[:, 1] - reach], axis=1)
        colours = np.where(forces[drawn] > 0.0, _COMPRESSION, _TENSION).tolist()
        axes.add_collection(PolyCollection(list(corners), facecolor=colours, linewidth=0.0, zorder=3))

    @property
    def width(self) -> float:
        """The width of the widest line [m]."""
        along = self.rest[self.pairs[:, 1]] - self.rest[self.pairs[:, 0]]
        return _CHAIN_WIDTH * float(np.median(np.sqrt((along * along).sum(axis=1))))

    def key(self) -> list[tuple[Artist, str]]:
        """Return a line for compression and, if any force is negative, one for tension."""
        kinds = [("compression", _COMPRESSION), *([("tension", _TENSION)] if self.values.min(initial=0.0) < 0.0 else [])]
        size = 3.0 * self.width, self.width
        return [(Rectangle((0.0, 0.0), *size, facecolor=colour), self.label(words)) for words, colour in kinds]


@dataclass(frozen=True)
class Arrows(Overlay):
    """An arrow for each vector, at most one in each small square."""

    def draw(self, axes: Axes, plane: Plane, frame: int) -> None:
        """Draw one frame."""
        vectors = (to_three_columns(self.values[frame])[self.thinned] @ plane.eye_axes)[:, :2] / self.limit
        lengths = np.sqrt((vectors * vectors).sum(axis=1))
        large = lengths > _LEAST
        arrows = _ARROW_LENGTH * self.spacing * vectors[large] / np.maximum(lengths[large], 1.0)[:, None]
        axes.quiver(
            *self.places(plane, frame)[self.thinned[large]].T, *arrows.T, angles="xy", scale_units="xy", scale=1.0, units="xy",
            width=_SHAFT * self.spacing, color=_ARROW, headwidth=4.0, headlength=4.5, headaxislength=4.0, zorder=3,
        )  # fmt: skip

    def key(self) -> list[tuple[Artist, str]]:
        """Return an arrow of the length of the limit."""
        ends, shape = ((0.0, 0.0), (_ARROW_LENGTH * self.spacing, 0.0)), {"arrowstyle": "-|>", "mutation_scale": 7.0}
        return [(FancyArrowPatch(*ends, **shape, shrinkA=0.0, shrinkB=0.0), self.label())]


@dataclass(frozen=True)
class PrincipalStresses(Overlay):
    """A cross for each stress: lines along the two principal directions in the plane, of lengths given by the two stresses."""

    def draw(self, axes: Axes, plane: Plane, frame: int) -> None:
        """Draw one frame."""
        stresses, directions = principal_stresses(self.values[frame][self.thinned])
        reach = 0.5 * _CROSS_LENGTH * self.spacing * np.minimum(np.abs(stresses) / self.limit, 1.0)
        middle = self.places(plane, frame)[self.thinned][:, None]
        ends = reach[..., None] * directions
        order = np.argsort(stresses, axis=None)  # tension last
        lines = np.stack([middle - ends, middle + ends], axis=2).reshape(-1, 2, 2)[order]
        colours = np.where(stresses.ravel()[order] > 0.0, _TENSION, _COMPRESSION).tolist()
        axes.add_collection(LineCollection(list(lines), colors=colours, linewidths=_CROSS_WIDTH, zorder=3))

    def key(self) -> list[tuple[Artist, str]]:
        """Return a line for tension and one for compression, of the length of the limit."""
        ends = [0.0, _CROSS_LENGTH * self.spacing], [0.0, 0.0]
        return [
            (Line2D(*ends, color=colour, linewidth=_CROSS_WIDTH), self.label(words))
            for words, colour in (("tension", _TENSION), ("compression", _COMPRESSION))
        ]


def principal_stresses(stresses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the principal stresses in the plane, shape (n, 2), largest first, and their directions, shape (n, 2, 2).

    Args:
        stresses: components xx, yy, xy, shape (n, 3), or xx, yy, zz, xy, shape (n, 4).
    """
    xx, yy, xy = stresses[:, _IN_PLANE[stresses.shape[1]]].T
    mean, half, angle = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy), 0.5 * np.arctan2(2.0 * xy, xx - yy)
    first = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    second = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    return np.stack([mean + half, mean - half], axis=1), np.stack([first, second], axis=1)


def load_overlays(log: Any, times: FloatArray, names: Sequence[str]) -> tuple[Overlay, ...]:
    """Read vectors, stresses and link forces at given times [s]; `ParameterError` for an output of another kind."""
    known = overlay_drawables(log)
    if unknown := [name for name in names if name not in known]:
        raise ParameterError(
            f"{unknown[0]!r} is not a recorded vector, stress or link force of a drawn body",
            hint=f"this log can show {', '.join(known) or 'nothing'}", at="show",
        )  # fmt: skip
    return tuple(_read_overlay(log, known[name], log.variables[name], times) for name in names)


def overlay_drawables(log: Any) -> dict[str, Drawable]:
    """Return the drawable of each recorded output that can be drawn over pictures."""
    recorded = recorded_outputs(log)
    bodies = [*visible_points(log.drawables), *visible_cells(log.drawables)]
    found: dict[str, Drawable] = {}
    for name, one in recorded.items():
        is_stress = one.unit == "Pa" and one.shape[1:] in [(count,) for count in _IN_PLANE]
        owner = next((body for body in bodies if has_elements(body, recorded, name)), None)
        if owner is not None and (is_stress or one.axes[1:] == ("direction",)):
            found[name] = owner
    for links in log.drawables:
        if isinstance(links, Links) and links.force in recorded:
            found[links.force] = links
    return found


def _read_overlay(log: Any, drawable: Drawable, variable: Variable, times: FloatArray) -> Overlay:
    values = _read_frames(log, variable.name, times)
    magnitudes = np.abs(_magnitudes(variable, values))
    limit = symmetric_limit(np.quantile(magnitudes[magnitudes > 0.0], _USUAL) if magnitudes.any() else 0.0)
    if isinstance(drawable, Links):
        points = next(one for one in log.drawables if isinstance(one, Points) and one.name == drawable.points)
        inside = points.is_unwrapped(drawable.pairs)
        return ForceChains(variable, values[:, inside], *_read_places(log, points, times), limit, drawable.pairs[inside])
    assert isinstance(drawable, Points | Cells)
    rest, displacement = _read_places(log, drawable, times)
    if isinstance(drawable, Cells) and variable.shape[0] == len(drawable.connectivity) != len(drawable.nodes):
        rest, displacement = rest[drawable.connectivity].mean(axis=1), displacement[:, drawable.connectivity].mean(axis=2)
    kind = Arrows if variable.axes[1:] == ("direction",) else PrincipalStresses
    return kind(variable, values, rest, displacement, limit)


def _magnitudes(variable: Variable, values: FloatArray) -> FloatArray:
    if variable.axes[1:] == ("direction",):
        return np.sqrt((values * values).sum(axis=-1))
    return values if values.ndim == 2 else principal_stresses(values.reshape(-1, values.shape[-1]))[0]


def _read_places(log: Any, drawable: Points | Cells, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return initial positions, shape (n, 3), and displacements, shape (frames, n, 3) [m]; zeros if not recorded."""
    rest = to_three_columns(drawable.nodes if isinstance(drawable, Cells) else drawable.reference)
    if drawable.displacement not in recorded_outputs(log):
        return rest, np.zeros((len(times), *rest.shape))
    moved = _read_frames(log, drawable.displacement, times)
    return rest, to_three_columns(moved if moved.ndim == 3 else moved[..., np.newaxis])


def _read_frames(log: Any, name: str, times: FloatArray) -> FloatArray:
    """Return the frames of an output nearest to given times."""
    clock = np.asarray(log.times(name), dtype=np.float64)
    return sample_frames(log, name, np.array([nearest_frame(clock, float(time)) for time in times]))[1]
