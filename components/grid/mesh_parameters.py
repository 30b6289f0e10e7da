"""Meshes as parameters, chosen by name: a rectangle with holes and notches, or explicit nodes and cells."""

from __future__ import annotations

import re
from abc import abstractmethod
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, SerializeAsAny, model_validator

from ..errors import ParameterError
from ..regions import ChosenArea
from ..support.parameter_fields import (
    Index,
    Pair,
    Positive,
    PositivePair,
    field,
    refuse_extreme_coordinates,
    refuse_extreme_values,
)
from ..support.tagged_union import ByName, Named
from .mesh import Mesh, mesh_without_cells, rectangle_mesh

_Corners = Annotated[list[Index], Field(min_length=4, max_length=4)]
_MOST_CELLS = 100_000_000


def _validate_edge_name(name: str) -> str:
    """Refuse an edge name from which no valid input name can be formed, or whose input would have the name of an output."""
    if not re.fullmatch("[a-z][a-z0-9_]*", name) or name == "receiver":
        raise ValueError(f"edges: got the name {name!r}, expected lower-case letters, digits and _, but not 'receiver'")
    return name


EdgeName = Annotated[str, AfterValidator(_validate_edge_name)]


class Shape(Named):
    """A mesh, chosen by its `name`."""

    @property
    @abstractmethod
    def cell_count(self) -> int:
        """Upper bound of the number of cells, known before building."""

    @property
    @abstractmethod
    def edge_names(self) -> tuple[str, ...]:
        """Names of the edges of the domain."""

    @abstractmethod
    def build_mesh(self) -> Mesh:
        """Return the mesh; raise `ParameterError` if it is unusable."""


class Rectangle(Shape):
    """A rectangle of equal cells, without those whose centre lies in a hole or notch."""

    name: Literal["rectangle"] = field("rectangle", "equal cells along the axes", "1")
    columns: int = field(40, "cells along x", "1", ge=1, le=_MOST_CELLS)
    rows: int = field(20, "cells along y", "1", ge=1, le=_MOST_CELLS)
    cell_size: Positive | PositivePair = field(1e-3, "side length of a cell, or its width and height", "m")
    centre: Pair | None = field(
        None, "centre of the rectangle; default: lower left corner at 0. About [0, 0], mirror images are exact", "m"
    )
    holes: list[ChosenArea] = field([], "areas without cells: boxes or discs; an area at the boundary makes a notch", "1")

    @model_validator(mode="after")
    def _validate_magnitudes(self) -> Rectangle:
        sizes = self.cell_size if isinstance(self.cell_size, list) else [self.cell_size]
        refuse_extreme_values((("cell_size",), one) for one in sizes)
        refuse_extreme_coordinates((("centre", place), one) for place, one in enumerate(self.centre or ()))
        return self

    @property
    def cell_count(self) -> int:  # noqa: D102
        return self.columns * self.rows

    @property
    def edge_names(self) -> tuple[str, ...]:  # noqa: D102
        return ("left", "right", "bottom", "top")

    @property
    def cell_sides(self) -> tuple[float, float]:
        """Width and height of a cell [m]."""
        size = self.cell_size
        return (size[0], size[1]) if isinstance(size, list) else (size, size)

    def build_mesh(self) -> Mesh:  # noqa: D102
        mesh = rectangle_mesh(
            self.columns, self.rows, self.cell_sides, None if self.centre is None else (self.centre[0], self.centre[1])
        )
        if not self.holes:
            return mesh
        removed = np.zeros(len(mesh.cells), dtype=bool)
        for place, hole in enumerate(self.holes):
            inside = hole.contains(mesh.centres)
            if not inside.any():
                raise ParameterError(
                    "does not contain the centre of any cell", hint="make it larger, or leave it out", at=("holes", place)
                )
            removed |= inside
        if removed.all():
            raise ParameterError("the holes remove all cells", at="holes")
        return mesh_without_cells(mesh, removed)


class Quadrilaterals(Shape):
    """A mesh given by its nodes and cells."""

    name: Literal["quadrilaterals"] = field("quadrilaterals", "explicit nodes and cells", "1")
    nodes: list[Pair] = field(..., "x and y of each node", "m", min_length=4)
    cells: list[_Corners] = field(..., "the four nodes of each cell, counterclockwise", "1", min_length=1)
    edges: dict[EdgeName, Annotated[list[Index], Field(min_length=2)]] = field(
        {}, "parts of the boundary by name: their nodes in order along the boundary, also the order in inputs of the edge", "1"
    )

    @model_validator(mode="after")
    def _validate(self) -> Quadrilaterals:
        nodes = np.array(self.nodes, dtype=np.float64)
        farthest = int(np.abs(nodes).max(axis=1).argmax())
        refuse_extreme_coordinates((("nodes", farthest), one) for one in self.nodes[farthest])
        refuse_extreme_values([(("nodes",), float(np.ptp(nodes, axis=0).max()))])
        self.build_mesh()
        return self

    @property
    def cell_count(self) -> int:  # noqa: D102
        return len(self.cells)

    @property
    def edge_names(self) -> tuple[str, ...]:  # noqa: D102
        return tuple(self.edges)

    def build_mesh(self) -> Mesh:  # noqa: D102
        mesh = Mesh(np.array(self.nodes, dtype=np.float64), np.array(self.cells, dtype=np.int64))
        problem = mesh.first_problem()
        if problem is not None:
            raise ParameterError(problem[1], at=problem[0])
        oriented = {tuple(sorted(side)): tuple(side) for side in mesh.sides.tolist()}
        edges = {}
        for name, chain in self.edges.items():
            sides: dict[tuple[int, int], None] = {}
            for first, second in zip(chain, chain[1:], strict=False):
                side = oriented.get((min(first, second), max(first, second)))
                if side is None:
                    raise ParameterError(
                        f"the nodes {first} and {second} are not joined by a side of the boundary", at=("edges", name)
                    )
                if side in sides:
                    raise ParameterError(
                        f"contains the side between the nodes {first} and {second} twice",
                        hint="give each side once",
                        at=("edges", name),
                    )
                sides[side] = None
            edges[name] = np.array(list(sides), dtype=np.int64)
        orders = {name: np.array(list(dict.fromkeys(chain)), dtype=np.int64) for name, chain in self.edges.items()}
        return Mesh(mesh.nodes, mesh.cells, edges, orders=orders)


SHAPES: dict[str, type[Shape]] = {"rectangle": Rectangle, "quadrilaterals": Quadrilaterals}

ChosenShape = Annotated[SerializeAsAny[Shape], ByName(SHAPES)]
