"""Scales of a scene: the factor of the displacements, the limits of the colours, and the box around all shapes.

Quantities of one unit have one scale of colours, so that parts compare.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from granular_env.colours import diverging, symmetric_limit
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.preview.displacement_scale import common_exaggeration

from .scene_data import Motion, SceneData, drawn_places
from .unit_labels import label_with_unit

# In a plane a few values that are this many times larger than nearly all others do not set the limit: the place where a load
# acts would leave a wave without colour.
_OUTSTANDING, _NEARLY_ALL = 2.5, 0.995
# Scenes that are smaller are magnified [m].
_LEAST_LENGTH = 0.1
REST_COLOUR = (150, 150, 150)


@dataclass(frozen=True)
class ColourScale:
    """A scale of colours for one output, or for several of one unit.

    Attributes:
        names: of the outputs.
        unit: of all of them.
        limit: the magnitude of the fullest colour.
        has_sign: whether any value is negative.
        is_exceeded: whether some values are larger than the limit.
    """

    names: tuple[str, ...]
    unit: str
    limit: float
    has_sign: bool
    is_exceeded: bool = False

    @property
    def label(self) -> str:
        """Names and unit, for a reader."""
        return label_with_unit(", ".join(self.names), self.unit)


def colour_scales(shown: Iterable[tuple[Variable, FloatArray]], is_plane: bool = False) -> tuple[ColourScale, ...]:
    """Return the scales of outputs: one for those of a unit, each its own where they have none.

    Args:
        shown: outputs and their values, any shape.
        is_plane: whether a few outstanding values do not count (see above).
    """
    groups: dict[str, list[tuple[Variable, FloatArray]]] = {}
    for variable, values in shown:
        groups.setdefault(variable.name if variable.unit == "1" else variable.unit, []).append((variable, values))
    return tuple(_scale(group, is_plane) for group in groups.values())


def _scale(group: Sequence[tuple[Variable, FloatArray]], is_plane: bool) -> ColourScale:
    values = np.concatenate([np.ravel(values) for _, values in group])
    values, unit = values[np.isfinite(values)], group[0][0].unit
    magnitudes = np.abs(values)
    largest = nearly_all = float(magnitudes.max(initial=0.0))
    if is_plane and unit != "1" and magnitudes.any():
        nearly_all = float(np.quantile(magnitudes[magnitudes > 0.0], _NEARLY_ALL))
    is_exceeded = largest > _OUTSTANDING * nearly_all
    names = tuple(dict.fromkeys(variable.name for variable, _ in group))
    limit = symmetric_limit([nearly_all if is_exceeded else largest])
    return ColourScale(names, unit, limit, bool(values.min(initial=0.0) < 0.0), is_exceeded)


@dataclass(frozen=True)
class Scales:
    """Scales from numbers to lengths and colours in one scene.

    Attributes:
        exaggeration: displacements are drawn this many times larger.
        colours: one for each quantity that colours something, that of the first particles first.
        low, high: corners of the box around all shapes in all frames; x, y, z [m].
        settled: whether factor and limits hold for the whole scene; those of a live run may change.
    """

    exaggeration: float
    colours: tuple[ColourScale, ...]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    settled: bool = True

    @property
    def colour_limit(self) -> float:
        """Magnitude at the ends of the colours of the first particles, in the unit of what colours them."""
        return self.colours[0].limit if self.colours else 1.0

    @property
    def magnification(self) -> float:
        """Factor of the whole scene, a power of 10: rerun draws nothing nearer than 0.1 to a camera, in single precision."""
        length = max(high - low for low, high in zip(self.low, self.high, strict=True))
        return 1.0 if length >= _LEAST_LENGTH else 10.0 ** math.ceil(math.log10(_LEAST_LENGTH / length))

    @property
    def stretch(self) -> str:
        """The factor in words, for titles."""
        if not self.settled:
            return "larger than they are (how much: see the text)"
        return "true to scale" if self.exaggeration == 1.0 else f"{self.exaggeration:g} x larger"

    def colours_of(self, variable: Variable, values: FloatArray | None, count: int) -> npt.NDArray[np.uint8]:
        """Return the colours of an output's values, or `count` times grey where it is not known; shape (..., 3)."""
        scale = next((one for one in self.colours if variable.name in one.names), None)
        if values is None or scale is None:
            return np.broadcast_to(np.array(REST_COLOUR, np.uint8), (count, 3)).copy()
        return diverging(values, scale.limit)


def scales_of(scene_data: SceneData, exaggerate: float | None = None) -> Scales | None:
    """Return scales that fit the shapes, None without shapes; `exaggerate` overrides the automatic factor."""
    if not scene_data.shapes:
        return None
    factor = exaggerate or common_exaggeration(
        ((one.reference, one.radius, one.displacement) for one in scene_data.motions),
        ((one.nodes, one.displacement) for one in scene_data.meshes),
    )
    corners = []
    for shape in scene_data.shapes:
        drawn, radius = drawn_places(shape, factor), shape.radius[:, None] if isinstance(shape, Motion) else 0.0
        corners += [(drawn - radius).min(axis=(0, 1)), (drawn + radius).max(axis=(0, 1))]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    colours = colour_scales(scene_data.coloured(), scene_data.is_plane)
    return Scales(factor, colours, tuple(low.tolist()), tuple(high.tolist()))


def enlarge_scales(scales: Scales, scene_data: SceneData, exaggerate: float | None = None) -> Scales:
    """Return the same scene's scales with limits that hold this frame too; unchanged while they hold."""
    now = scales_of(scene_data, exaggerate)
    if now is None:
        return scales
    factor = scales.exaggeration
    if any(np.any(shape.displacement) for shape in scene_data.shapes) and (factor == 1.0 or now.exaggeration < factor):
        factor = now.exaggeration
    values = {variable.name: values for variable, values in scene_data.coloured()}

    def larger(scale: ColourScale) -> ColourScale:
        own = [values[name] for name in scale.names if name in values]
        largest = max((float(np.abs(one).max(initial=0.0)) for one in own), default=0.0)
        has_sign = scale.has_sign or any(bool(np.any(one < 0.0)) for one in own)
        return dataclasses.replace(scale, limit=roomy_limit(scale.limit, largest), has_sign=has_sign, is_exceeded=False)

    return dataclasses.replace(scales, exaggeration=factor, colours=tuple(larger(scale) for scale in scales.colours))


def roomy_limit(limit: float, value: float) -> float:
    """Return the limit while it holds the value, else the next 1, 2 or 5 x 10^k: few changes while a wave grows."""
    if value <= limit or not math.isfinite(value):
        return limit
    decade = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * decade:.6g}") for step in (1, 2, 5, 10) if step * decade >= value * (1.0 - 1e-12))
