"""Observations of a chain: every grain, or readings of sensors in chosen places; with noise where it is wanted.

A plan is a few numbers that one jitted function, `observe`, turns into an observation: for one chain and for a batch alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain import differentiable_quantities as quantities
from granular_env.components.chain.layout import U, V
from granular_env.components.errors import ParameterError, nearest, one_line
from granular_env.components.support.counter_random import normal, stream_key
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import JIT, inlined, jit
from granular_env.components.support.validation import finite_number

# Kinds of a block of readings: a row of the table, or one of these.
CONTACT, _GRAIN = -1, -2
OBSERVE = "void(float64[:, ::1], int64[:, ::1], float64[::1], float64, float64, int64, int64, float32[::1])"

_SENSORS = {
    "displacement": "a grain's displacement",
    "velocity": "a grain's velocity",
    "force": "the mean of the forces in a grain's two contacts",
    "contact_force": "the force in a contact, i being left of grain i and -1 the right wall's",
    "wall_force": 'the force at "left" or "right" between the chain and its wall',
}


@jit
def _observe(a, blocks, factors, limit, noise, seed, step, out):
    place = 0
    # Noise comes before the clipping.
    edge = limit if noise == 0.0 else np.inf
    for block in range(blocks.shape[0]):
        kind, first, count = blocks[block, 0], blocks[block, 1], blocks[block, 2]
        if kind >= 0:
            _read_row(a, kind, first, count, factors[block], edge, place, out)
        else:
            for i in range(count):
                force = quantities.contact_force(a, first + i) if kind == CONTACT else quantities.grain_force(a, first + i)
                out[place + i] = min(max(force * factors[block], -edge), edge)
        place += count
    if noise > 0.0:
        key = stream_key(seed, step)
        for i in range(place):
            out[i] = min(max(out[i] + noise * normal(key, i), -limit), limit)


@jit
def show_goal(counters, scales, limit, out):
    """Write the episode's goal, the first counters, to the end of the observation, without noise."""
    place = len(out) - len(scales)
    for i in range(len(scales)):
        out[place + i] = min(max(counters[i] / scales[i], -limit), limit)


@inlined
def _read_row(a, row, first, count, factor, edge, place, out):
    """Columns from `first` of a row; a loop of its own, so that it becomes vectors."""
    for i in range(np.uint64(count)):
        x = a[row, np.uint64(first) + i] * factor
        x = edge if x > edge else x
        out[np.uint64(place) + i] = -edge if x < -edge else x


# observe(a, blocks, factors, limit, noise, seed, step, out): readings times factors, blurred and clipped, into `out`.
# With the JIT off, numpy's scalars would warn of the wrapping products of the noise.
observe = np.errstate(over="ignore")(_observe) if not JIT else _observe


@dataclass(frozen=True, eq=False)
class Observing:
    """A plan for `observe`.

    Attributes:
        blocks: kind (a row of the table, or a force), first column, count; shape (blocks, 3).
        factors: 1 / scale of each block.
        limit: readings are clipped to +- this.
        noise: standard deviation of the noise, in scales.
        size: length of an observation.
    """

    blocks: npt.NDArray[np.int64]
    factors: FloatArray
    limit: float
    noise: float
    size: int

    @staticmethod
    def of(chain: Chain, choice: Any, scales: Mapping[str, float], limit: float, noise: float = 0.0) -> Observing:
        """Return a plan from what an environment's `observe` and `noise` say.

        Args:
            chain: what is looked at.
            choice: "full" (displacement and velocity of every grain), or sensor -> places: "displacement", "velocity" and
                "force" at grains, "contact_force" in contacts, "wall_force" at "left" and "right".
            scales: "displacement" [m], "velocity" [m/s] and "force" [N] that are seen as 1.
            limit: readings are clipped to +- this, in scales.
            noise: standard deviation relative to the scales.

        Raises:
            ParameterError: a sensor is unknown, a place is not there or named twice, nothing is observed, or noise is no number
                from 0.
        """
        grains = chain.parameters.grains
        noise = finite_number("noise", noise)
        if noise < 0.0:
            raise ParameterError(f"got {noise:g}", expected="0 or more, in units of the observation's scales", at="noise")
        if isinstance(choice, str) and choice == "full":
            choice = {"displacement": range(grains), "velocity": range(grains)}
        if not isinstance(choice, Mapping):
            raise ParameterError(f"got {one_line(choice)}", expected='"full" or sensor -> places', at="observe")
        blocks = [
            (*block, 1.0 / scales[name if name in scales else "force"])
            for name, places in choice.items()
            for block in _blocks(chain, name, places)
        ]
        if not blocks:
            raise ParameterError(
                f"got {one_line(choice)}", expected=f"at least one sensor: {', '.join(_SENSORS)}", at="observe"
            )
        table = np.array([block[:3] for block in blocks], dtype=np.int64)
        return Observing(table, np.array([block[3] for block in blocks]), float(limit), noise, int(table[:, 2].sum()))


def _blocks(chain: Chain, name: Any, places: Any) -> Iterable[tuple[int, int, int]]:
    """Yield the runs of neighbouring readings of one sensor: kind, first column, count."""
    if name not in _SENSORS:
        raise ParameterError(f"no sensor {one_line(name)}", hint=nearest(str(name), _SENSORS), at="observe")
    if isinstance(places, (str, int, np.integer)):
        places = [places]
    if not isinstance(places, Iterable):
        raise ParameterError(f"got {one_line(places)}", expected=f"a list of places: {_SENSORS[name]}", at=f"observe.{name}")
    if name == "wall_force":
        columns, kind = [_wall_place(chain, side) for side in places], CONTACT
    elif name == "contact_force":
        columns, kind = [_contact_place(chain, place) for place in places], CONTACT
    else:
        columns = [1 + _index(f"observe.{name}", place, chain.parameters.grains) for place in places]
        kind = {"displacement": U, "velocity": V, "force": _GRAIN}[name]
    if len(set(columns)) < len(columns):
        raise ParameterError(f"got {one_line(places)}", expected="each place once", at=f"observe.{name}")
    starts = [i for i, column in enumerate(columns) if i == 0 or column != columns[i - 1] + 1]
    return [(kind, columns[a], b - a) for a, b in pairwise([*starts, len(columns)])]


def _index(name: str, place: Any, count: int) -> int:
    if isinstance(place, bool) or not isinstance(place, (int, np.integer)) or not -count <= place < count:
        raise ParameterError(f"got {one_line(place)}", expected=f"whole numbers from {-count} to {count - 1}", at=name)
    return int(place) % count


def _contact_place(chain: Chain, place: Any) -> int:
    column = _index("observe.contact_force", place, chain.parameters.contact_places)
    if not chain.parameters.has_contact(column):
        raise ParameterError(
            f"got {place}, but {chain.parameters.absent_contact(column)}",
            hint="contact i is left of grain i",
            at="observe.contact_force",
        )
    return column


def _wall_place(chain: Chain, side: Any) -> int:
    ends = {"left": (chain.parameters.left, 0), "right": (chain.parameters.right, chain.parameters.grains)}
    if side not in ends:
        raise ParameterError(f"got {one_line(side)}", expected='"left" or "right"', at="observe.wall_force")
    boundary, place = ends[side]
    if boundary in ("free", "piston"):
        raise ParameterError(
            f"{side} is {boundary!r}, and has no wall",
            hint=f"give {side} = 'plane', or read contact_force",
            at="observe.wall_force",
        )
    return place
