"""Sentences on the links and the pieces of a specimen of automata that can break."""

from __future__ import annotations

import numpy as np

from ..drawables import Points
from ..support.float_arrays import FloatArray
from .cracking_specimen import CrackingSpecimen
from .materials import IntArray


def describe_links(specimen: CrackingSpecimen, points: Points, pairs: IntArray, step_size: float, micro_steps: int = 1) -> str:
    """Return a sentence: the number of broken links and the first of them, or the link that is closest to breaking.

    Args:
        specimen: a specimen whose links can break.
        points: the automata as they are drawn; their name and positions identify a link in the sentence.
        pairs: the two automata of each link, shape (links, 2).
        step_size: internal step [s] of the component whose ticks the events record.
        micro_steps: number of steps of the automata per internal step.
    """
    breaks, count = specimen.break_events(), len(pairs)
    if not len(breaks):
        ratio = specimen.criterion_ratio()
        nearest = int(ratio.argmax()) if count else 0
        if not count or not ratio[nearest] > 0.0:
            return f"none of {count} links broke"
        where = _describe_link(points, pairs[nearest])
        return f"none of {count} links broke; the closest to breaking, of {where}, is now at {ratio[nearest]:.3g} of its limit"
    tick, cause, index, value, limit = breaks[0].tolist()
    broken, again = len(np.unique(breaks[:, 2])), ""
    if (held := broken - round(specimen.broken_link_count())) > 0:
        again = f", {held} of them are linked again"
    kind = list(specimen.event_kinds)[int(cause)].replace("_", " ")
    unit = "" if (one := next(iter(specimen.event_details.values())).unit) == "1" else f" {one}"
    return (
        f"{broken} of {count} links broke{again}; the first was a {kind} of {_describe_link(points, pairs[int(index)])} at "
        f"{1e6 * np.ceil(tick / micro_steps) * step_size:.4g} us: {value:.6g}{unit} > {limit:.6g}{unit}"
    )


def describe_pieces(linked_pairs: IntArray, mass: FloatArray) -> str:
    """Return a sentence on the number of pieces of a body, and on the fraction of the mass in the largest piece.

    Args:
        linked_pairs: pairs of automata (or nodes) that are connected, shape (m, 2).
        mass: of each automaton or node, shape (n,) [kg].
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    joins = coo_array(
        (np.ones(len(linked_pairs), np.int8), (linked_pairs[:, 0], linked_pairs[:, 1])), shape=(len(mass), len(mass))
    )
    pieces, piece = connected_components(joins, directed=False)
    # The percentage is rounded down, so that the largest of several pieces never has 100 %.
    largest = np.floor(1e4 * np.bincount(piece, mass).max() / mass.sum()) / 100.0
    return "1 piece" if pieces == 1 else f"{pieces} pieces; the largest has {largest:g} % of the mass"


def _describe_link(points: Points, pair: IntArray) -> str:
    """Return a text that names the two automata of a link, and the initial position of the middle between them."""
    middle = points.reference[pair[0]] + 0.5 * points.shortest_vectors(pair[None])[0]
    return f"{points.name} {pair[0]} and {pair[1]} at ({', '.join(f'{one:.4g}' for one in middle)}) m"
