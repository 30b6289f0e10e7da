"""Drawables: the closed family of shapes that viewers can draw for any component and that logs contain."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from .support.float_arrays import FloatArray


class _Geometry:
    """Base of drawables: replaces arrays, which may be the component's own tables, by read-only copies."""

    __slots__ = ()

    def __repr__(self) -> str:
        values = ((name, getattr(self, name)) for name in self.__slots__)
        texts = (
            f"{name}=<array {value.shape}>" if isinstance(value, np.ndarray) else f"{name}={value!r}" for name, value in values
        )
        return f"{type(self).__name__}({', '.join(texts)})"

    def __post_init__(self) -> None:
        for name in ("reference", "radius", "pairs", "nodes", "connectivity", "coordinate", "period"):
            if hasattr(self, name):
                copied = np.array(getattr(self, name))
                if name in ("reference", "nodes") and copied.ndim == 1:  # along a line
                    copied = copied[:, np.newaxis]
                copied.flags.writeable = False
                object.__setattr__(self, name, copied)


@dataclasses.dataclass(frozen=True, slots=True, repr=False)
class Points(_Geometry):
    """Bodies with a centre: grains, discs, automata, integration points.

    Attributes:
        name: for example "grains".
        reference: initial centres, shape (n, d) with 1 to 3 dimensions, or (n,) along a line [m].
        radius: shape (n,) [m].
        displacement: the output with their displacements, shape (n,) along x or (n, d) [m].
        colour: the output that colours them, shape (n,); empty for none.
        rotation: the output with their angles, shape (n,) [rad]; empty for none.
        period: period of the body along each axis, 0 for none, shape (d,) [m]; shape (0,) if no axis is periodic.
    """

    name: str
    reference: FloatArray
    radius: FloatArray
    displacement: str
    colour: str = ""
    rotation: str = ""
    period: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(0))

    def shortest_vectors(self, pairs: npt.NDArray[np.int64]) -> FloatArray:
        """Return the initial shortest vector from the first to the second point of each pair, shape (m, d) [m]."""
        places = self.reference.reshape(len(self.radius), -1)
        ways = places[pairs[:, 1]] - places[pairs[:, 0]]
        for axis in np.flatnonzero(self.period):
            ways[:, axis] -= self.period[axis] * np.rint(ways[:, axis] / self.period[axis])
        return ways

    def is_unwrapped(self, pairs: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Return, for each pair, whether the shortest vector crosses no periodic edge, shape (m,)."""
        places = self.reference.reshape(len(self.radius), -1)
        apart = np.abs(places[pairs[:, 1]] - places[pairs[:, 0]])[:, : len(self.period)]
        across: npt.NDArray[np.bool_] = (self.period > 0.0) & (2.0 * apart > self.period)
        return np.logical_not(np.any(across, axis=1))


@dataclasses.dataclass(frozen=True, slots=True, repr=False)
class Links(_Geometry):
    """Pairs of points that are linked until they break.

    Attributes:
        name: for example "bonds".
        points: the name of the `Points`.
        pairs: indices of the points, shape (m, 2), int64.
        state: the output that is 0 for unlinked pairs, shape (m,); its value colours the others.
        force: the output with the force along the line of centres, compression positive, shape (m,) [N]; empty for none.
    """

    name: str
    points: str
    pairs: npt.NDArray[np.int64]
    state: str
    force: str = ""


@dataclasses.dataclass(frozen=True, slots=True, repr=False)
class Cells(_Geometry):
    """Elements of a continuum.

    Attributes:
        name: for example "grid".
        nodes: initial positions, shape (n, d) [m].
        connectivity: nodes of each cell in cyclic order (on the surface of a body, counter-clockwise as seen from outside),
            shape (m, k), int64.
        field: the output that colours the cells, shape (m,) or (n,).
        displacement: the output with the displacements of the nodes, shape (n, d) [m]; empty for none.
        state: the output that is 0 for broken cells, which are not drawn, shape (m,); empty for none.
    """

    name: str
    nodes: FloatArray
    connectivity: npt.NDArray[np.int64]
    field: str
    displacement: str = ""
    state: str = ""


@dataclasses.dataclass(frozen=True, slots=True, repr=False)
class Curve(_Geometry):
    """A field along a line, such as the pressure along a tube.

    Attributes:
        name: for example "tube".
        coordinate: shape (n,) [m].
        field: the output with the values, shape (n,).
    """

    name: str
    coordinate: FloatArray
    field: str


Drawable = Points | Links | Cells | Curve

# Fields of drawables that contain the name of an output, or "".
OUTPUT_FIELDS = ("displacement", "colour", "rotation", "state", "field", "force")


def element_count(drawable: Drawable) -> int:
    """Return the number of elements that event indices may refer to: points, links or cells; 0 for a curve."""
    match drawable:
        case Links():
            return len(drawable.pairs)
        case Points():
            return len(drawable.reference)
        case Cells():
            return len(drawable.connectivity)
        case _:
            return 0


def element_positions(
    drawable: Drawable, others: Iterable[Drawable], chosen: slice | Sequence[int] = slice(None)
) -> FloatArray:
    """Return the initial positions of points, middles of links, centres of cells or samples of a curve, shape (n, d) [m].

    `others` contains the points of links; `chosen` selects elements.
    """
    match drawable:
        case Links():
            points = next(one for one in others if isinstance(one, Points) and one.name == drawable.points)
            pairs = drawable.pairs[chosen]
            return points.reference[pairs[:, 0]] + 0.5 * points.shortest_vectors(pairs)
        case Points():
            return drawable.reference[chosen]
        case Cells():
            return drawable.nodes[drawable.connectivity[chosen]].mean(axis=1)
        case Curve():
            return drawable.coordinate[chosen, np.newaxis]


def drawn_outputs(drawables: Iterable[Drawable]) -> list[str]:
    """Return the names of the outputs that drawables use, each once; without forces, which a log has on request only."""
    names = (getattr(drawable, name, "") for drawable in drawables for name in OUTPUT_FIELDS if name != "force")
    return list(dict.fromkeys(name for name in names if name))


def main_points(drawables: Iterable[Drawable]) -> Points | None:
    """Return the first `Points`, with the three columns in `reference` that viewers require; None if there are none."""
    points = next((drawable for drawable in drawables if isinstance(drawable, Points)), None)
    return None if points is None else dataclasses.replace(points, reference=to_three_columns(points.reference))


def to_three_columns(vectors: np.ndarray) -> np.ndarray:
    """Return positions or displacements padded with zeros to three columns x, y, z, shape (n, 3) or (frames, n, 3).

    The given shape is (n,) along x, (n, d) or (frames, n, d), d = 1 to 3. Frames along x need the shape (frames, n, 1).
    """
    rows = vectors[..., np.newaxis] if vectors.ndim == 1 else vectors
    full = np.zeros((*rows.shape[:-1], 3))
    full[..., : rows.shape[-1]] = rows
    return full
