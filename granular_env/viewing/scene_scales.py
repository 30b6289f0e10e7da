"""Scales of a scene: displacement factor, colour limits, and bounding box of all shapes.

Quantities of the same unit share a colour scale, so that parts can be compared.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from granular_env.colours import ColourScale, colour_scales, diverging_colours
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.preview.displacement_scale import common_exaggeration

from .scene_data import Motion, SceneData, drawn_positions

# Scenes smaller than this are magnified [m].
_LEAST_LENGTH = 0.1
REST_COLOUR = (150, 150, 150)


@dataclass(frozen=True)
class Scales:
    """Scales that map numbers to lengths and colours in a scene.

    Attributes:
        exaggeration: factor of the drawn displacements.
        colours: colour scales, that of the first particles first.
        low, high: corners (x, y, z) of the bounding box of all shapes in all frames [m].
        settled: whether factor and limits are final; those of a live run may change.
    """

    exaggeration: float
    colours: tuple[ColourScale, ...]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    settled: bool = True

    @property
    def colour_limit(self) -> float:
        """Magnitude at the ends of the first particles' colour scale, in the unit of the colouring output."""
        return self.colours[0].limit if self.colours else 1.0

    @property
    def magnification(self) -> float:
        """Scale factor of the whole scene, a power of 10: rerun clips everything closer than 0.1 to a camera."""
        length = max(high - low for low, high in zip(self.low, self.high, strict=True))
        return 1.0 if length >= _LEAST_LENGTH else 10.0 ** math.ceil(math.log10(_LEAST_LENGTH / length))

    @property
    def stretch_text(self) -> str:
        """The displacement factor as text for titles."""
        if not self.settled:
            return "magnified (factor: see the text)"
        return "true to scale" if self.exaggeration == 1.0 else f"{self.exaggeration:g} x larger"

    def value_colours(self, variable: Variable, values: FloatArray | None, count: int) -> npt.NDArray[np.uint8]:
        """Return the colours of an output's values, or `count` greys if they are unknown, shape (..., 3)."""
        scale = next((one for one in self.colours if variable.name in one.names), None)
        if values is None or scale is None:
            return np.broadcast_to(np.array(REST_COLOUR, np.uint8), (count, 3)).copy()
        return diverging_colours(values, scale.limit)


def make_scales(scene_data: SceneData, exaggerate: float | None = None) -> Scales | None:
    """Return scales that fit the shapes, None without shapes; `exaggerate` replaces the automatic displacement factor."""
    if not scene_data.shapes:
        return None
    factor = exaggerate or common_exaggeration(
        ((one.reference, one.radius, one.displacement) for one in scene_data.motions),
        ((one.nodes, one.displacement) for one in scene_data.meshes),
    )
    corners = []
    for shape in scene_data.shapes:
        drawn, radius = drawn_positions(shape, factor), shape.radius[:, None] if isinstance(shape, Motion) else 0.0
        corners += [(drawn - radius).min(axis=(0, 1)), (drawn + radius).max(axis=(0, 1))]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    colours = colour_scales(scene_data.coloured_outputs(), scene_data.is_plane)
    return Scales(factor, colours, tuple(low.tolist()), tuple(high.tolist()))


def enlarge_scales(scales: Scales, scene_data: SceneData, exaggerate: float | None = None) -> Scales:
    """Return the scales with limits enlarged to include the present frame, unchanged if it is within the limits."""
    now = make_scales(scene_data, exaggerate)
    if now is None:
        return scales
    factor = scales.exaggeration
    if any(np.any(shape.displacement) for shape in scene_data.shapes) and (factor == 1.0 or now.exaggeration < factor):
        factor = now.exaggeration

    def enlarge_scale(scale: ColourScale) -> ColourScale:
        shown = (values.ravel() for variable, values in scene_data.coloured_outputs() if variable.name in scale.names)
        values = np.concatenate([np.zeros(1), *shown])
        if not values.any():
            return scale
        limit = enlarge_limit(0.0 if scale.is_zero else scale.limit, float(np.abs(values).max()))
        return ColourScale(scale.names, scale.unit, limit, scale.has_sign or bool(values.min() < 0.0))

    return dataclasses.replace(scales, exaggeration=factor, colours=tuple(enlarge_scale(scale) for scale in scales.colours))


def enlarge_limit(limit: float, value: float) -> float:
    """Return `limit` if `value` does not exceed it, else the next 1, 2 or 5 x 10^k from `value` on, to change it rarely."""
    if value <= limit or not math.isfinite(value):
        return limit
    decade = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * decade:.6g}") for step in (1, 2, 5, 10) if step * decade >= value * (1.0 - 1e-12))
