"""The outcome of a run, read from its log: how near a tube came to parting, how far cracks ran, and in words."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Unpack

import numpy as np
import numpy.typing as npt

from granular_env.atlas.context import Context
from granular_env.components.drawables import Cells, Links, Points
from granular_env.components.shell.fracture.outcome import OUTCOMES
from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.log import Log

from .cases import ARRIVAL, DRAWN_OUT, INCH, MIDDLE, Changes, run_notched_tube


@dataclasses.dataclass(frozen=True)
class Outcome:
    """A tube at the end of its run.

    Attributes:
        x: of the nodes of the outer surface, from the middle of the notch, shape (s,) [m].
        arc: their angle from the notch, shape (s,) [rad], 0 to pi.
        stress: equivalent stress at these, shape (s,) [Pa].
        pairs: indices of neighbours in the surface, shape (links, 2).
        cut: whether a crack lies between them, shape (links,).
        ratio: the largest principal stress over its limit, until the end of the log; 0 where it stayed below a half.
        nearest: where that was: from the middle of the notch [m], and its angle from the notch [rad].
        pieces: how many there are.
        parted: how many points have parted, until the end of the log.
        strain: largest plastic strain at the end of the log.
        end: of the log, after the front has passed the middle of the notch [s].
        words: the outcome in a word, as the component reads it: whole, bulged, axial crack, hoop crack, severed.
        along: how far cracks reach along the tube, from the first place to the last [m]; 0 where none runs along it.
        around: the largest part of the circumference that cracks take at one place along the tube.
        reach: the part of the circumference over which cracks reach from the notch, both ways, wherever along the tube.
        time: of all this, after the front has passed the middle of the notch [s].
        valid_until: when a cross-section has grown by more than half, which a gas of one-way coupling does not feel: after the
            front has passed the middle of the notch [s]; infinity where none has.
    """

    x: FloatArray
    arc: FloatArray
    stress: FloatArray
    pairs: npt.NDArray[np.int64]
    cut: npt.NDArray[np.bool_]
    ratio: float
    nearest: tuple[float, float]
    pieces: float
    parted: float
    strain: float
    end: float
    words: str
    along: float
    around: float
    reach: float
    time: float
    valid_until: float

    @property
    def is_valid(self) -> bool:
        """True while the gas flows in a tube whose cross-section has not grown by half."""
        return self.time < self.valid_until

    @property
    def is_drawn_out(self) -> bool:
        """True where a point has flowed so far that aluminium would have torn."""
        return self.strain >= DRAWN_OUT

    def crosses_axis(self) -> npt.NDArray[np.bool_]:
        """Return of each pair whether its nodes lie behind one another along the tube: a crack between them runs around it."""
        x, arc = self.x[self.pairs], self.arc[self.pairs]
        return np.abs(np.diff(x, axis=1)[:, 0]) > np.abs(np.diff(arc, axis=1)[:, 0]) * 1e-6


def outcome(context: Context, inches: int, factor: float, **changes: Unpack[Changes]) -> Outcome:
    """Run a notched tube, or read its log; see `run_notched_tube`."""
    return read_outcome(run_notched_tube(context, inches, factor, **changes))


def read_outcome(log: Log, time: float | None = None) -> Outcome:
    """Return what became of a tube until a time, by default the end of its log."""
    [surface] = [one for one in log.drawables if isinstance(one, Cells) and one.name == "surface"]
    [nodes] = [one for one in log.drawables if isinstance(one, Points) and one.name == "nodes"]
    [links] = [one for one in log.drawables if isinstance(one, Links)]
    end = float(log.times("shell_pieces")[-1])
    late = end if time is None else min(time, end)
    # Links name the nodes of the body, the surface has numbers of its own.
    number = {tuple(place): k for k, place in enumerate(np.round(surface.nodes, 9).tolist())}
    of_node = [number.get(tuple(place), -1) for place in np.round(nodes.reference, 9).tolist()]
    report = log.metadata["report"]
    ratio = float(report.get("shell: largest fracture ratio so far, above 0.5", 0.0))
    place = float(report.get("shell: along the body, m", 0.0)) - 0.5 * float(np.ptp(surface.nodes[:, 0]))
    arc, pairs = np.arctan2(surface.nodes[:, 1], surface.nodes[:, 2]), np.asarray(of_node)[links.pairs]
    cut = np.asarray(log.get("shell_surface_links", late)) == 0.0
    grown = log.events("cross_section_grown")
    return Outcome(
        surface.nodes[:, 0] - MIDDLE, arc, np.asarray(log.get("shell_surface_stress", late)), pairs, cut, ratio,
        (place, float(report.get("shell: angle around, rad", math.nan))), float(log.get("shell_pieces", late)),
        float(report.get("shell: points that have parted", 0.0)), float(report["shell: largest plastic strain"]),
        end - ARRIVAL, OUTCOMES[int(log.get("shell_outcome", late))],
        float(log.get("shell_crack_along", late)), float(log.get("shell_crack_around", late)),
        float(_reaches(arc, pairs)[cut].max(initial=0.0)), late - ARRIVAL,
        grown[0].tick * log.step_size - ARRIVAL if grown else math.inf,
    )  # fmt: skip


def reach_history(log: Log) -> tuple[FloatArray, FloatArray]:
    """Return the instants of a log [s], and at each the part of the circumference over which cracks reach."""
    end = read_outcome(log)
    reaches = _reaches(end.arc, end.pairs)
    times, links = log.series("shell_surface_links")
    return times, np.where(links == 0.0, reaches, 0.0).max(axis=1)


def _reaches(arc: FloatArray, pairs: npt.NDArray[np.int64]) -> FloatArray:
    """Return how far from the notch a crack between each pair reaches, over half a turn: the other half is its mirror image.

    A crack between two columns of nodes lies halfway between them; one across a column goes through its strip, to there.
    """
    places = np.round(arc, 9)
    columns, first = np.unique(places, return_index=True)
    angles = arc[first]
    ends = np.append(0.5 * (angles[1:] + angles[:-1]), angles[-1])
    strips = np.searchsorted(columns, places[pairs].min(axis=1))
    return ends[strips] / math.pi


# Heads of the columns of a table of outcomes, and what stands there.
HEAD = ("outcome", "reach along", "reach around", "at one place", "pieces", "valid until")
# Limits of an axis of parts [%], so that what lies at 0 and at 100 is seen whole.
PARTS = (-4.0, 104.0)
# What they are, for captions.
REACH = (
    "Reach along: from the first place of a crack along the tube to the last; reach around: over which part of the "
    "circumference cracks lie, wherever along the tube; at one place: the largest part of the circumference that they take "
    "there. Valid until: when a cross-section of the tube has grown by more than half, after the front; a gas of one-way "
    "coupling loads the wall as if it had not."
)


def row_of(one: Outcome) -> list[str]:
    """Return the columns of a table of outcomes: in a word, how far cracks reach along the tube and around it, and pieces."""
    parts = [f"{100.0 * part:.0f} %" for part in (one.reach, one.around)]
    valid = "the end" if one.is_valid else f"{1e3 * one.valid_until:.2g} ms"
    return [one.words, f"{1e3 * one.along:.0f} mm", *parts, f"{one.pieces:.0f}", valid]


def compare(some: Sequence[Outcome]) -> str:
    """Return the outcomes of several runs in words, always with the range of what differs between them."""
    words = " or ".join(sorted({one.words for one in some}))
    reach, pieces = [100.0 * one.reach for one in some], [one.pieces for one in some]
    return (
        f"{words}; around {min(reach):.0f} to {max(reach):.0f} % of the circumference; {min(pieces):.0f} to {max(pieces):.0f} "
        "pieces"
    )


def ratio(one: float, other: float) -> float:
    """Return one length over another; infinity where there is the first one alone, and 1 where there is neither."""
    return one / other if other > 0.0 else (1.0 if one == 0.0 else math.inf)


def in_notch(inches: int, place: tuple[float, float]) -> bool:
    """Tell whether a place lies in the notch or within a tenth of an inch of its ends."""
    return abs(place[0]) <= (0.5 * inches + 0.1) * INCH and abs(place[1]) < 0.1
