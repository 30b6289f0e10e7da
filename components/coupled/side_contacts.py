"""Contacts of automata with free sides of the grid, i.e. boundary sides outside the interface.

Contacts are smooth and elastic:

    N = k (R - d) if d < R, 0 otherwise,        U = (1/2) k (R - d)^2

d is the distance of an automaton from the nearest side, and k the stiffness of a contact between automata. N acts on the
automaton along the line from the nearest point of the side. That point lies at the fraction s of the side, whose nodes take
-(1 - s) N and -s N, so that momentum and angular momentum are conserved. R is half a diameter, or the automaton's initial
distance from the sides if that is smaller. The nodes of free sides are interface nodes that carry no automata: they move with
the steps of the automata. Contacts are frictionless and have no history: their forces depend on the positions alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..automata.lattice import FORCE_X, FORCE_Y, X, Y
from ..grid.mesh import IntArray, Mesh
from ..support.float_arrays import FloatArray, norms
from ..support.jit import internal, internal_inlined, jit
from .interface import Interface


class Sides(NamedTuple):
    """Free sides of the grid, and the automata that may touch them.

    Attributes:
        nodes: the two nodes of each side, with the grid on the left, shape (w, 2).
        rows: indices of these nodes in `Interface.nodes`, shape (w, 2).
        radius: R of each automaton, shape (n,) [m].
        stiffness: k of each automaton, shape (n,) [N/m].
        pairs: automaton and side, in this order, shape (m, 2); part of the state.
        used: number of pairs in use.
    """

    nodes: IntArray
    rows: IntArray
    radius: FloatArray
    stiffness: FloatArray
    pairs: IntArray
    used: int


def free_sides(mesh: Mesh, interface_sides: IntArray) -> IntArray:
    """Return the boundary sides of a grid outside the interface, whose sides are `interface_sides`, shape (w, 2)."""
    known = {tuple(side) for side in interface_sides.tolist()}
    return np.array([side for side in mesh.sides.tolist() if tuple(side) not in known], np.int64).reshape(-1, 2)


def extend_interface(interface: Interface, nodes: IntArray) -> Interface:
    """Return the interface extended by nodes that carry no automata."""
    every = np.unique(np.concatenate([interface.nodes, nodes]))
    counts, mass = np.zeros(len(every), np.int64), np.zeros(len(every))
    known = np.searchsorted(every, interface.nodes)
    counts[known], mass[known] = np.diff(interface.first), interface.mass
    return interface._replace(nodes=every, first=np.concatenate([[0], np.cumsum(counts)]), mass=mass)


def make_sides(
    interface: Interface, sides: IntArray, nodes: FloatArray, centres: FloatArray, radius: float, stiffness: FloatArray
) -> Sides:
    """Return the free sides with an empty list of pairs.

    Args:
        interface: includes the nodes of the sides.
        sides: result of `free_sides`.
        nodes: initial positions of the grid nodes, shape (nodes, 2) [m].
        centres: initial positions of the automata, shape (n, 2) [m].
        radius: half the diameter of an automaton [m].
        stiffness: k of the contacts of each automaton, shape (n,) [N/m].
    """
    radii, none = np.full(len(centres), radius), np.zeros((0, 2), np.int64)
    rows = np.searchsorted(interface.nodes, sides)
    found = Sides(sides, rows.astype(np.int64), radii, stiffness, none, 0)
    pairs = find_close_pairs(found, nodes, centres, np.flatnonzero(interface.free), 0.0)
    if len(pairs):
        shorten_radii(sides, nodes, centres, pairs, radii)
    return found


def find_close_pairs(sides: Sides, nodes: FloatArray, centres: FloatArray, automata: IntArray, margin: float) -> IntArray:
    """Return the sorted pairs of an automaton and a side whose gap may be less than `margin`, shape (m, 2).

    Args:
        sides: `Sides`.
        nodes: present positions of the grid nodes, shape (nodes, 2) [m].
        centres: present positions of the automata, shape (n, 2) [m].
        automata: numbers of the automata to examine.
        margin: gap up to which pairs are included [m].
    """
    from scipy.spatial import cKDTree  # type: ignore[attr-defined]

    start, end = nodes[sides.nodes[:, 0]], nodes[sides.nodes[:, 1]]
    if not len(automata) or not (np.isfinite(start).all() and np.isfinite(centres[automata]).all()):
        return np.zeros((0, 2), np.int64)
    reach = 0.5 * float(norms(end - start).max()) + float(sides.radius.max()) + margin
    tree: Any = cKDTree(0.5 * start + 0.5 * end)
    near = tree.query_ball_point(centres[automata], reach)
    found = [(i, side) for i, some in zip(automata.tolist(), near, strict=True) for side in sorted(some)]
    return np.array(found, np.int64).reshape(-1, 2)


@internal_inlined
def _nearest_side_point(start, end, centre):
    """Return the unit vector from the nearest point of a side to an automaton's centre, the distance, and the fraction s.

    The body lies on the left of the side. A centre inside the body next to the side has a negative distance, and the vector
    still points out of the body. A centre inside the body beyond an end of the side has an infinite distance.
    """
    wx, wy, x, y = end[0] - start[0], end[1] - start[1], centre[0] - start[0], centre[1] - start[1]
    length = np.sqrt(wx * wx + wy * wy)
    nx, ny = wy / length, -wx / length
    height, part = x * nx + y * ny, (x * wx + y * wy) / (length * length)
    if 0.0 <= part <= 1.0:
        return nx, ny, height, part
    part = 0.0 if part < 0.0 else 1.0
    x, y = x - part * wx, y - part * wy
    distance = np.sqrt(x * x + y * y)
    if height < 0.0 or distance == 0.0:
        return nx, ny, np.inf, part
    return x / distance, y / distance, distance, part


@jit
def shorten_radii(sides, nodes, centres, pairs, radii):
    """Reduce the radii of automata to their initial distances from the sides; for arguments see `make_sides` and `Sides`."""
    for row in range(pairs.shape[0]):
        i, a, b = pairs[row, 0], sides[pairs[row, 1], 0], sides[pairs[row, 1], 1]
        start, end = (nodes[a, 0], nodes[a, 1]), (nodes[b, 0], nodes[b, 1])
        _, _, distance, _ = _nearest_side_point(start, end, (centres[i, 0], centres[i, 1]))
        radii[i] = min(radii[i], max(distance, 0.0))


@internal_inlined
def _nearest_side(sides, nodes, automata, row):
    """Return the side nearest to the automaton of a row of `pairs`, its normal, distance, s, and the next automaton's row."""
    i, best, (reference, displacement) = sides.pairs[row, 0], -1, nodes
    nx, ny, nearest, part = 0.0, 0.0, np.inf, 0.0
    p, cells, motion = automata.body.layout.place[i], automata.body.cells, automata.motion
    centre = cells[X, p] + motion[X, p], cells[Y, p] + motion[Y, p]
    while row < sides.used and sides.pairs[row, 0] == i:
        side = sides.pairs[row, 1]
        a, b = sides.nodes[side, 0], sides.nodes[side, 1]
        start = reference[a, 0] + displacement[a, 0], reference[a, 1] + displacement[a, 1]
        end = reference[b, 0] + displacement[b, 0], reference[b, 1] + displacement[b, 1]
        x, y, distance, at = _nearest_side_point(start, end, centre)
        if abs(distance) < abs(nearest):
            nx, ny, nearest, part, best = x, y, distance, at, side
        row += 1
    return best, nx, ny, nearest, part, row


@jit
def add_side_forces(sides, nodes, automata, automata_force):
    """Add the forces of the contacts with sides to automata and interface nodes, and return the energy of these contacts [J].

    Args:
        sides: `Sides`, or None.
        nodes: initial positions of the grid nodes, and their displacements, both of shape (nodes, 2) [m].
        automata: a `parts.AutomataPart`; its forces are updated.
        automata_force: force of automata on interface nodes, see `exchange.Exchange`; updated.
    """
    row, energy, cells = 0, 0.0, automata.scratch.cells
    if sides is not None:
        while row < sides.used:
            i = sides.pairs[row, 0]
            side, nx, ny, distance, part, row = _nearest_side(sides, nodes, automata, row)
            overlap = sides.radius[i] - distance
            if side >= 0 and 0.0 < overlap < 2.0 * sides.radius[i]:
                push = sides.stiffness[i] * overlap
                energy += 0.5 * sides.stiffness[i] * overlap * overlap
                fx, fy = push * nx, push * ny
                p = automata.body.layout.place[i]
                cells[FORCE_X, p] += fx
                cells[FORCE_Y, p] += fy
                for end, share in ((0, 1.0 - part), (1, part)):
                    place = sides.rows[side, end]
                    automata_force[place, 0] -= share * fx
                    automata_force[place, 1] -= share * fy
    return energy


@internal
def largest_side_speed(sides, velocity):
    """Return the speed of the fastest node of the sides [m/s], 0 without sides."""
    largest = 0.0
    if sides is not None:
        for side in range(sides.nodes.shape[0]):
            for end in range(2):
                n = sides.nodes[side, end]
                square = velocity[n, 0] * velocity[n, 0] + velocity[n, 1] * velocity[n, 1]
                largest = square if square > largest else largest
    return np.sqrt(largest)
