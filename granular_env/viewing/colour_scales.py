"""Scales of colours: which magnitude has the fullest colour. What is measured alike has one scale, so that parts compare."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from granular_env.colours import symmetric_limit
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable

from .unit_labels import label_with_unit

# In a plane a few values that are so many times larger than nearly all others get the fullest colour along with these: the
# place where a load acts would leave a wave without colour.
_OUTSTANDING, _NEARLY_ALL = 2.5, 0.995


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


def scale_of(scales: Iterable[ColourScale], name: str) -> ColourScale | None:
    """Return the scale of an output; None where it has no colours."""
    return next((scale for scale in scales if name in scale.names), None)


def rescale(scale: ColourScale, limit: float, has_sign: bool) -> ColourScale:
    """Return a scale with another limit, of a run that goes on."""
    return replace(scale, limit=limit, has_sign=has_sign, is_exceeded=False)
