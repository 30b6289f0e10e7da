"""What viewers can draw of a component: a small closed family, logged and drawn without knowing the component."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from .snapshot import FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Points:
    """Bodies with a centre: grains, discs, automata, integration points.

    Attributes:
        name: what they are, such as "grains".
        reference: centres before anything moves, shape (n, d) with 1 to 3 dimensions [m].
        radius: shape (n,) [m].
        displacement: the output that holds their displacements, shape (n,) along x or (n, d) [m].
        colour: the output whose value colours them, shape (n,); empty for none.
        rotation: the output that holds their angles, shape (n,) [rad]; empty for none.
    """

    name: str
    reference: FloatArray
    radius: FloatArray
    displacement: str
    colour: str = ""
    rotation: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class Links:
    """Pairs of points that hold together, until they break.

    Attributes:
        name: what they are, such as "bonds".
        points: the name of the `Points`.
        pairs: indices of the points, shape (m, 2), int64.
        state: the output that is 0 where a pair is not linked, shape (m,); its value colours the others.
    """

    name: str
    points: str
    pairs: npt.NDArray[np.int64]
    state: str


@dataclasses.dataclass(frozen=True, slots=True)
class Cells:
    """Elements of a continuum.

    Attributes:
        name: what they are, such as "grid".
        nodes: before anything moves, shape (n, d) [m].
        connectivity: nodes of each cell in order around it, shape (m, k), int64.
        field: the output that colours the cells, shape (m,) or (n,).
        displacement: the output that holds the nodes' displacements, shape (n, d) [m]; empty for none.
    """

    name: str
    nodes: FloatArray
    connectivity: npt.NDArray[np.int64]
    field: str
    displacement: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class Curve:
    """A field along a line, such as the pressure along a tube.

    Attributes:
        name: what it is, such as "tube".
        coordinate: shape (n,) [m].
        field: the output that holds the values, shape (n,).
    """

    name: str
    coordinate: FloatArray
    field: str


Drawable = Points | Links | Cells | Curve

# Outputs that a drawable names.
_OUTPUTS = ("displacement", "colour", "rotation", "state", "field")


def drawn_outputs(drawables: Iterable[Drawable]) -> list[str]:
    """Return the names of the outputs that drawables show, each once."""
    names = (getattr(drawable, name, "") for drawable in drawables for name in _OUTPUTS)
    return list(dict.fromkeys(name for name in names if name))


def main_points(drawables: Iterable[Drawable]) -> Points | None:
    """Return the first points, their reference with three columns, as viewers want it; None where there are none."""
    points = next((drawable for drawable in drawables if isinstance(drawable, Points)), None)
    return None if points is None else dataclasses.replace(points, reference=spatial(points.reference))


def spatial(vectors: np.ndarray) -> np.ndarray:
    """Return positions or displacements in 1 to 3 dimensions, shape (..., n) along x or (..., n, d), with three columns.

    An array of two dimensions is taken for (n, d); one along x with frames in front needs a last axis of its own.
    """
    rows = vectors[..., np.newaxis] if vectors.ndim == 1 else vectors
    full = np.zeros((*rows.shape[:-1], 3))
    full[..., : rows.shape[-1]] = rows
    return full
