"""Recorded outputs drawn over the picture of a body: force chains, arrows of vectors, crosses of principal stresses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import FancyArrowPatch, Rectangle
from scipy.spatial import KDTree

from granular_env.colours import DIVERGING, symmetric_limit
from granular_env.components.drawables import Cells, Drawable, Links, Points, to_three_columns
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.preview.visible_drawables import has_elements, visible_cells, visible_points

from ..recorded_fields import nearest_frame, recorded_outputs
from ..scene_builder import to_vectors
from ..unit_labels import scaled_unit

if TYPE_CHECKING:
    from .plane import Plane

# Tension is positive in the blue-to-red colour map of stresses, so it is red here too.
_COMPRESSION, _TENSION, _ARROW = DIVERGING[0], DIVERGING[-1], "#1a1c1f"
# Most arrows or crosses along a body; length and width of the largest sample of each kind, relative to the spacing.
_MOST_ALONG, _SIZES = 40, {"arrow": (1.7, 0.09), "cross": (0.95, 0.09), "link": (1.2, 0.4)}
# This part of all magnitudes is below the limit; forces, stresses and vectors below this fraction of the limit are not drawn.
_USUAL, _LEAST = 0.97, 0.03
# Columns xx, yy, xy of stresses with three and with four entries per element.
_IN_PLANE = {3: (0, 1, 2), 4: (0, 1, 3)}


@dataclass(frozen=True)
class Overlay:
    """Vectors, stresses or link forces drawn over a body.

    Attributes:
        variable: name, unit and meaning of the output.
        values: values of the drawn elements, shape (frames, n, ...); of links, shape (frames, m).
        rest: initial positions of the points or of the elements' middles, shape (n, 3) [m].
        displacement: their displacements, shape (frames, n, 3) [m].
        limit: magnitude drawn with the greatest length or width; larger ones are drawn with the same.
        spacing: distance between drawn arrows or crosses, or between linked points [m].
        pairs: indices of the two points of each link, shape (m, 2); None for vectors and stresses.
    """

    variable: Variable
    values: FloatArray
    rest: FloatArray
    displacement: FloatArray
    limit: float
    spacing: float
    pairs: npt.NDArray[np.int64] | None = None

    @property
    def kind(self) -> str:
        """How an element is drawn: "arrow", "cross" or "link"."""
        return "link" if self.pairs is not None else "arrow" if _is_vector(self.variable) else "cross"

    @property
    def largest(self) -> FloatArray:
        """The length and width of the largest arrow or line of a cross, or of a sample of the widest link [m]."""
        return self.spacing * np.array(_SIZES[self.kind])

    def draw(self, axes: Axes, plane: Plane, frame: int) -> None:
        """Draw one frame."""
        places = ((self.rest + plane.scales.exaggeration * self.displacement[frame]) @ plane.eye_axes)[:, :2]
        values = self.values[frame] / self.limit
        if self.kind == "arrow":
            self._draw_arrows(axes, places, (to_three_columns(values) @ plane.eye_axes)[:, :2])
        elif self.pairs is not None:
            self._draw_lines(axes, places[self.pairs], -values, np.minimum(np.abs(values), 1.0))
        else:
            stresses, directions = principal_stresses(values)
            reach = 0.5 * self.largest[0] * np.clip(stresses, -1.0, 1.0)[..., None] * directions
            ends = np.stack([places[:, None] - reach, places[:, None] + reach], axis=2).reshape(-1, 2, 2)
            self._draw_lines(axes, ends, stresses.ravel(), np.ones(len(ends)))

    def _draw_arrows(self, axes: Axes, places: FloatArray, vectors: FloatArray) -> None:
        """Draw vectors, relative to the limit, at places, both of shape (n, 2)."""
        lengths = np.sqrt((vectors * vectors).sum(axis=1))
        large = lengths > _LEAST
        arrows = self.largest[0] * vectors[large] / np.maximum(lengths[large], 1.0)[:, None]
        axes.quiver(
            *places[large].T, *arrows.T, angles="xy", scale_units="xy", scale=1.0, units="xy", width=self.largest[1],
            color=_ARROW, headwidth=4.0, headlength=4.5, headaxislength=4.0, zorder=3,
        )  # fmt: skip

    def _draw_lines(self, axes: Axes, ends: FloatArray, tensions: FloatArray, widths: FloatArray) -> None:
        """Draw lines between ends, shape (m, 2, 2) [m], tension last; tensions and widths are relative to the largest."""
        order = np.argsort(tensions, kind="stable")
        drawn = order[np.abs(tensions[order]) > _LEAST]
        along = ends[drawn, 1] - ends[drawn, 0]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(np.hypot(*along.T), 1e-300)[:, None]
        reach = (0.5 * self.largest[1] * widths[drawn, None] * across)[:, None]
        corners = np.concatenate([ends[drawn] - reach, ends[drawn, ::-1] + reach], axis=1)
        colours = np.where(tensions[drawn] > 0.0, _TENSION, _COMPRESSION).tolist()
        axes.add_collection(PolyCollection(list(corners), facecolor=colours, linewidth=0.0, zorder=3))

    def key(self) -> list[tuple[Artist, str]]:
        """Return samples of the largest arrow or lines, in data coordinates, with their labels."""
        factor, unit = scaled_unit(self.variable.unit, self.limit)
        least = f"\u2265 {self.limit * factor:.3g} {unit}" if self.values.any() else "= 0"
        length, width = self.largest
        if self.kind == "arrow":
            shape: Any = {"arrowstyle": "-|>", "mutation_scale": 7.0, "shrinkA": 0.0, "shrinkB": 0.0}
            arrow = FancyArrowPatch((0.0, 0.0), (length, 0.0), **shape)
            return [(arrow, f"{self.variable.name.replace('_', ' ')} {least}")]
        kinds = {"compression": _COMPRESSION, "tension": _TENSION}
        return [(Rectangle((0.0, 0.0), length, width, facecolor=kinds[words]), f"{words} {least}") for words in kinds]


def principal_stresses(stresses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the principal stresses in the plane, shape (n, 2), largest first, and their directions, shape (n, 2, 2).

    Args:
        stresses: components xx, yy, xy, shape (n, 3), or xx, yy, zz, xy, shape (n, 4).
    """
    xx, yy, xy = stresses[:, _IN_PLANE[stresses.shape[1]]].T
    mean, half, angle = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy), 0.5 * np.arctan2(2.0 * xy, xx - yy)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([mean + half, mean - half], axis=1), np.stack([cosine, sine, -sine, cosine], axis=1).reshape(-1, 2, 2)


def load_overlays(log: Any, times: FloatArray, names: Sequence[str]) -> tuple[Overlay, ...]:
    """Read vectors, stresses and link forces at given times [s]; `ParameterError` for an output of another kind."""
    known, names = overlay_drawables(log), [names] if isinstance(names, str) else names
    if unknown := [name for name in names if name not in known]:
        raise ParameterError(
            f"{unknown[0]!r} is not a recorded vector, stress or link force of a drawn body",
            hint=f"this log can show {', '.join(known) or 'nothing'}", at="show",
        )  # fmt: skip
    found = [_read_overlay(log, known[name], log.variables[name], times) for name in dict.fromkeys(names)]
    # Samples of one kind and unit have one scale.
    largest = dict[tuple[str, str], float]()
    for one in found:
        if one.values.any():
            scale = one.kind, one.variable.unit
            largest[scale] = max(largest.get(scale, 0.0), one.limit)
    return tuple(replace(one, limit=largest.get((one.kind, one.variable.unit), one.limit)) for one in found)


def overlay_drawables(log: Any) -> dict[str, Drawable]:
    """Return the drawable of each recorded output that can be drawn over pictures."""
    recorded = recorded_outputs(log)
    bodies = [*visible_points(log.drawables), *visible_cells(log.drawables)]
    found: dict[str, Drawable] = {}
    for name, one in recorded.items():
        is_stress = one.unit == "Pa" and one.shape[1:] in [(count,) for count in _IN_PLANE]
        owner = next((body for body in bodies if has_elements(body, recorded, name)), None)
        if owner is not None and (is_stress or _is_vector(one)):
            found[name] = owner
    return found | {one.force: one for one in log.drawables if isinstance(one, Links) and one.force in recorded}


def _read_overlay(log: Any, drawable: Drawable, variable: Variable, times: FloatArray) -> Overlay:
    clock = np.asarray(log.times(variable.name), dtype=np.float64)
    frames = np.array([nearest_frame(clock, float(time)) for time in times])
    values = log.frames_at(variable.name, frames)
    body = drawable
    if isinstance(drawable, Links):
        body = next(one for one in log.drawables if isinstance(one, Points) and one.name == drawable.points)
    assert isinstance(body, Points | Cells)
    rest = to_three_columns(body.nodes if isinstance(body, Cells) else body.reference)
    displacement = np.zeros((len(times), *rest.shape))
    if body.displacement in recorded_outputs(log):
        displacement = to_vectors(log.frames_at(body.displacement, frames))
    if isinstance(drawable, Links) and isinstance(body, Points):
        inside = body.is_unwrapped(drawable.pairs)
        pairs, values = drawable.pairs[inside], values[:, inside]
        spacing = float(np.median(np.linalg.norm(rest[pairs[:, 1]] - rest[pairs[:, 0]], axis=1)))
        return Overlay(variable, values, rest, displacement, _usual_limit(values), spacing, pairs)
    if isinstance(body, Cells) and variable.shape[0] == len(body.connectivity) != len(body.nodes):
        rest, displacement = rest[body.connectivity].mean(axis=1), displacement[:, body.connectivity].mean(axis=2)
    magnitudes = np.sqrt((values**2).sum(axis=-1)) if _is_vector(variable) else principal_stresses(np.concatenate(values))[0]
    picked, spacing = _pick_apart(rest)
    return Overlay(variable, values[:, picked], rest[picked], displacement[:, picked], _usual_limit(magnitudes), spacing)


def _is_vector(variable: Variable) -> bool:
    return variable.axes[1:] == ("direction",)


def _usual_limit(values: FloatArray) -> float:
    magnitudes = np.abs(values[values != 0.0])
    return symmetric_limit(np.quantile(magnitudes, _USUAL) if len(magnitudes) else 0.0)


def _pick_apart(places: FloatArray) -> tuple[npt.NDArray[np.int64], float]:
    """Return the indices of places, one in each cube of a lattice, and the size of the cubes [m]."""
    distance = float(np.median(KDTree(places).query(places, 2)[0][:, 1]))
    along = float(np.ptp(places, axis=0).max()) / _MOST_ALONG
    spacing = distance * max(1.0, float(np.ceil(along / distance - 1e-6)))
    cubes = np.floor((places - places.min(axis=0) + 0.5 * distance) / spacing)
    return np.unique(cubes, axis=0, return_index=True)[1], spacing
