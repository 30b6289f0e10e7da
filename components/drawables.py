"""Drawables, the shapes that viewers can draw of a component: a small closed family, logged and drawn for any component."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import ParameterError, one_line
from .support.float_arrays import FloatArray


class _Geometry:
    """Copies the arrays of a drawable, which are often the component's own tables, and closes them to writing."""

    __slots__ = ()

    def __post_init__(self) -> None:
        for name in ("reference", "radius", "pairs", "nodes", "connectivity", "coordinate", "period"):
            if hasattr(self, name):
                copied = np.array(getattr(self, name))
                if name in ("reference", "nodes") and copied.ndim == 1:  # along a line
                    copied = copied[:, np.newaxis]
                copied.flags.writeable = False
                object.__setattr__(self, name, copied)


@dataclasses.dataclass(frozen=True, slots=True)
class Points(_Geometry):
    """Bodies with a centre: grains, discs, automata, integration points.

    Attributes:
        name: what they are, such as "grains".
        reference: centres before anything moves, shape (n, d) with 1 to 3 dimensions, or (n,) along a line [m].
        radius: shape (n,) [m].
        displacement: the output that holds their displacements, shape (n,) along x or (n, d) [m].
        colour: the output whose value colours them, shape (n,); empty for none.
        rotation: the output that holds their angles, shape (n,) [rad]; empty for none.
        period: the lengths after which the body begins again along each axis, 0 along one where it does not, shape (d,) [m];
            (0,) where it does along none.
    """

    name: str
    reference: FloatArray
    radius: FloatArray
    displacement: str
    colour: str = ""
    rotation: str = ""
    period: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(0))

    def ways(self, pairs: npt.NDArray[np.int64]) -> FloatArray:
        """Return the shortest way from the first to the second point of each pair at rest, shape (m, d) [m]."""
        places = self.reference.reshape(len(self.radius), -1)
        ways = places[pairs[:, 1]] - places[pairs[:, 0]]
        for axis in np.flatnonzero(self.period):
            ways[:, axis] -= self.period[axis] * np.rint(ways[:, axis] / self.period[axis])
        return ways

    def stays_inside(self, pairs: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Return for each pair whether the shortest way lies inside of the body as it is drawn, shape (m,)."""
        places = self.reference.reshape(len(self.radius), -1)
        apart = np.abs(places[pairs[:, 1]] - places[pairs[:, 0]])[:, : len(self.period)]
        across: npt.NDArray[np.bool_] = (self.period > 0.0) & (2.0 * apart > self.period)
        return np.logical_not(np.any(across, axis=1))


@dataclasses.dataclass(frozen=True, slots=True)
class Links(_Geometry):
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
class Cells(_Geometry):
    """Elements of a continuum.

    Attributes:
        name: what they are, such as "grid".
        nodes: before anything moves, shape (n, d) [m].
        connectivity: nodes of each cell in order around it, of the surface of a body counter-clockwise as seen from outside,
            shape (m, k), int64.
        field: the output that colours the cells, shape (m,) or (n,).
        displacement: the output that holds the nodes' displacements, shape (n, d) [m]; empty for none.
        state: the output that is 0 where a cell is broken, so that it is not drawn, shape (m,); empty for none.
    """

    name: str
    nodes: FloatArray
    connectivity: npt.NDArray[np.int64]
    field: str
    displacement: str = ""
    state: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class Curve(_Geometry):
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

# The fields of drawables that name an output, or are "".
OUTPUT_FIELDS = ("displacement", "colour", "rotation", "state", "field")
# Those that cannot be "".
_NEEDED = {Points: ("displacement",), Links: ("state",), Cells: ("field",), Curve: ("field",)}


def element_count(drawn: Drawable) -> int:
    """Return how many elements events of a kind may count by its number: points, links or cells; 0 of what has none."""
    match drawn:
        case Links():
            return len(drawn.pairs)
        case Points():
            return len(drawn.reference)
        case Cells():
            return len(drawn.connectivity)
        case _:
            return 0


def validate_drawables(drawables: Sequence[Drawable], variables: Mapping[str, Any]) -> None:
    """Check what a component declares: names, dimensions, numbers, indices, and the shapes of the outputs that are named.

    Raises:
        ParameterError: something does not fit.
    """
    for one in drawables:
        if not isinstance(one, Drawable):
            raise ParameterError(f"got {one_line(one)}", expected="Points, Links, Cells or Curve", at="drawables")
    points = {one.name: len(one.reference) for one in drawables if isinstance(one, Points)}
    names = [one.name for one in drawables]
    for place, one in enumerate(drawables):
        if one.name in names[:place]:
            raise _fault((one.name, "name"), f"got {one.name!r} again", "each name once")
        match one:
            case Points():
                _expect_places((one.name, "reference"), one.reference)
                count, shapes = len(one.reference), {"colour": 1, "rotation": 1, "displacement": 2}
                if one.radius.shape != (count,):
                    raise _fault((one.name, "radius"), f"got shape {one.radius.shape}", f"one for each of the {count} points")
                _expect_finite((one.name, "radius"), one.radius)
                dimensions = one.reference.shape[1]
                if one.period.shape not in ((0,), (dimensions,)) or (one.period < 0.0).any():
                    raise _fault((one.name, "period"), f"got {one.period}", f"{dimensions} lengths, 0 for none")
                _expect_finite((one.name, "period"), one.period)
                if (one.radius < 0.0).any():
                    raise _fault((one.name, "radius"), f"got {one.radius.min():g}", "no negative one")
            case Links():
                if one.points not in points:
                    raise _fault((one.name, "points"), f"got {one.points!r}", f"one of {', '.join(points) or 'none'}")
                _expect_indices((one.name, "pairs"), one.pairs, points[one.points])
                if one.pairs.shape[1] != 2:
                    raise _fault((one.name, "pairs"), f"got shape {one.pairs.shape}", "two columns")
                count, shapes = len(one.pairs), {"state": 1}
            case Cells():
                _expect_places((one.name, "nodes"), one.nodes)
                _expect_indices((one.name, "connectivity"), one.connectivity, len(one.nodes))
                if not len(one.connectivity):
                    raise _fault((one.name, "connectivity"), "got no cells", "at least one; leave out what there is none of")
                count, shapes = len(one.nodes), {"displacement": 2}
                _expect_states(one, variables)
            case Curve():
                _expect_finite((one.name, "coordinate"), one.coordinate)
                count, shapes = len(one.coordinate), {"field": 1}
        for role in OUTPUT_FIELDS:
            name = getattr(one, role, "")
            if not name and role not in _NEEDED[type(one)]:
                continue
            if name not in variables or variables[name].causality != "output":
                raise _fault((one.name, role), f"got {name!r}", "the name of an output")
            shape = variables[name].shape
            if role in shapes and not (shape[:1] == (count,) and len(shape) <= shapes[role] and shape[1:] <= (3,)):
                raise _fault((one.name, role), f"got {name!r} of shape {shape}", f"a row for each of the {count} drawn")
            if isinstance(one, Cells) and role == "field" and shape not in ((len(one.connectivity),), (count,)):
                expected = f"one for each of the {len(one.connectivity)} cells, or of the {count} nodes"
                raise _fault((one.name, role), f"got {name!r} of shape {shape}", expected)


def _expect_places(where: tuple[str, str], places: np.ndarray) -> None:
    if places.ndim != 2 or not len(places) or places.shape[1] not in (1, 2, 3):
        raise _fault(where, f"got shape {places.shape}", "a row for each of at least one, of 1 to 3 columns")
    _expect_finite(where, places)


def _expect_finite(where: tuple[str, str], numbers: np.ndarray) -> None:
    if numbers.dtype.kind not in "fiu":
        raise _fault(where, f"got an array of {numbers.dtype}", "numbers")
    bad = np.argwhere(~np.isfinite(numbers))
    if len(bad):
        first = tuple(bad[0].tolist())
        raise _fault(where, f"got {numbers[first]:g} at {list(first)}", "finite numbers")


def _expect_indices(where: tuple[str, str], indices: np.ndarray, count: int) -> None:
    if not np.issubdtype(indices.dtype, np.integer):
        raise _fault(where, f"got {indices.dtype}", "whole numbers, int64")
    if indices.ndim != 2 or (indices.size and (indices.min() < 0 or indices.max() >= count)):
        span = f", from {indices.min()} to {indices.max()}" if indices.size else ""
        raise _fault(where, f"got shape {indices.shape}{span}", f"rows of indices from 0 to {count - 1}")


def _expect_states(cells: Cells, variables: Mapping[str, Any]) -> None:
    expected = (len(cells.connectivity),)
    if cells.state in variables and variables[cells.state].shape != expected:
        received = f"got {cells.state!r} of shape {variables[cells.state].shape}"
        raise _fault((cells.name, "state"), received, f"one for each of the {expected[0]} cells")


def _fault(where: tuple[str, str], received: str, expected: str) -> ParameterError:
    return ParameterError(received, expected=expected, at=("drawables", *where))


def drawn_outputs(drawables: Iterable[Drawable]) -> list[str]:
    """Return the names of the outputs that drawables show, each once."""
    names = (getattr(drawable, name, "") for drawable in drawables for name in OUTPUT_FIELDS)
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
