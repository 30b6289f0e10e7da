"""What every measurement looks at: the motion of a chain's grains in time, and the chain that they belong to."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..components.contract import Component, FloatArray
from ..components.errors import LogError, ParameterError, shortened
from .checks import sign, whole_number

if TYPE_CHECKING:
    from ..recording import Log
    from ..recording.index import Segment

Direction = Literal["right", "left"]

# F = k d^1.5 (Nesterenko 1983, (1.1)).
_HERTZ = 1.5


@dataclasses.dataclass(frozen=True, eq=False)
class History:
    """The grains' motion at T times, and the n grains and n + 1 places for contacts of their chain.

    Place j is left of grain j; 0 and n are the walls', and have no contact where there is none. Made by `history` from a log,
    by `observe` or `Watch` from a running chain, or by hand.

    Attributes:
        time: shape (T,), increasing [s].
        velocity: shape (T, n), positive to the right [m/s].
        mass: shape (n,) [kg].
        stiffness: k of F = k overlap^1.5, shape (n + 1,), 0 where there is no contact [N/m^1.5].
        rest_overlap: overlap in the reference configuration, shape (n + 1,), negative for a gap [m].
        position: of the grains in the reference configuration, shape (n,) [m].
        displacement: shape (T, n) [m]; None where it is not known.
        piston: which grains' velocity is prescribed, shape (n,), bool.
        recorded_overlap: shape (T, n + 1) [m], where it is known without the displacement.
    """

    time: FloatArray
    velocity: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    rest_overlap: FloatArray
    position: FloatArray
    displacement: FloatArray | None = None
    piston: np.ndarray | None = None
    recorded_overlap: FloatArray | None = None

    def __post_init__(self) -> None:
        frames, grains = len(np.atleast_1d(self.time)), len(np.atleast_1d(self.mass))
        if frames == 0 or grains == 0:
            raise ParameterError(
                f"history: got {frames} frames of {grains} grains, expected at least one of each; record a run"
            )
        places = grains + 1
        for name, shape in (
            ("time", (frames,)), ("velocity", (frames, grains)), ("mass", (grains,)), ("stiffness", (places,)),
            ("rest_overlap", (places,)), ("position", (grains,)), ("displacement", (frames, grains)), ("piston", (grains,)),
            ("recorded_overlap", (frames, places)),
        ):  # fmt: skip
            value = getattr(self, name)
            if value is not None and np.shape(value) != shape:
                raise ParameterError(f"history: {name} has shape {np.shape(value)}, expected {shape}")
        for name in ("time", "velocity"):
            if not np.isfinite(getattr(self, name)).all():
                raise ParameterError(f"history: {name} holds a value that is not finite")
        if (np.diff(self.time) <= 0.0).any():
            raise ParameterError("history: time does not increase; give one run, without a reset within it")

    @property
    def grains(self) -> int:
        """Number of grains."""
        return len(self.mass)

    @cached_property
    def overlap(self) -> FloatArray:
        """Approach of the surfaces at each place, negative for a gap, NaN where there is no contact, shape (T, n + 1) [m].

        Raises:
            LogError: neither displacement nor overlap was recorded.
        """
        if self.displacement is None:
            if self.recorded_overlap is None:
                raise LogError(
                    "displacement was not recorded, and overlaps, forces and energies need it; "
                    "record with variables=['velocity', 'displacement']"
                )
            return self.recorded_overlap
        still = np.zeros((len(self.time), 1))
        found = self.rest_overlap - np.diff(self.displacement, axis=1, prepend=still, append=still)
        found[:, self.stiffness == 0.0] = np.nan
        return found

    @cached_property
    def contact_force(self) -> FloatArray:
        """Compressive force at each place, never negative, shape (T, n + 1) [N]."""
        pressed = np.maximum(np.nan_to_num(self.overlap), 0.0)
        return self.stiffness * pressed**_HERTZ

    @cached_property
    def contact_energy(self) -> FloatArray:
        """Elastic energy stored at each place, shape (T, n + 1) [J]."""
        pressed = np.maximum(np.nan_to_num(self.overlap), 0.0)
        return self.stiffness * pressed ** (_HERTZ + 1.0) / (_HERTZ + 1.0)

    @cached_property
    def rest_force(self) -> FloatArray:
        """Force at each place in the reference configuration: that of a precompression, shape (n + 1,) [N]."""
        return self.stiffness * np.maximum(self.rest_overlap, 0.0) ** _HERTZ

    def frame(self, time: float) -> int:
        """Number of the frame nearest to a time [s].

        Raises:
            ParameterError: the time is outside of the history.
        """
        first, last = float(self.time[0]), float(self.time[-1])
        margin = 1e-9 * (last - first)
        if not (isinstance(time, (int, float, np.number)) and first - margin <= time <= last + margin):
            raise ParameterError(f"time: got {shortened(time)} s, the history goes from {first:.12g} s to {last:.12g} s")
        return int(np.argmin(np.abs(self.time - time)))

    def window(self, begin: float | None = None, end: float | None = None) -> slice:
        """The frames from a time to another [s], both included; by default from the first to the last."""
        first = 0 if begin is None else self.frame(begin)
        last = len(self.time) - 1 if end is None else self.frame(end)
        if last < first:
            raise ParameterError(f"window: it begins at {begin:g} s and ends at {end:g} s, expected the end to come later")
        return slice(first, last + 1)

    def grain(self, number: Any, name: str = "grain") -> int:
        """A grain's number, checked; the first is 0."""
        return whole_number(name, number, 0, self.grains - 1)

    def contact_behind(self, grain: int, direction: Direction) -> int:
        """Place of the contact through which a wave comes to a grain.

        Raises:
            ParameterError: there is none, at an end without a wall.
        """
        place = self.grain(grain) + (0 if sign(direction) > 0.0 else 1)
        if self.stiffness[place] == 0.0:
            raise ParameterError(
                f"grain: no contact is behind grain {grain}, through which a wave to the {direction} could come; "
                "take one further on"
            )
        return place


def of_chain(
    component: Component,
    time: FloatArray,
    velocity: FloatArray,
    displacement: FloatArray | None = None,
    overlap: FloatArray | None = None,
) -> History:
    """A history of a chain from frames; masses, stiffnesses and positions are the chain's.

    Args:
        component: the chain.
        time: shape (T,) [s].
        velocity: shape (T, n) [m/s].
        displacement: shape (T, n) [m].
        overlap: as the chain's variable, of its contacts only, shape (T, contacts) [m].
    """
    chain = chain_geometry(component)
    parameters: Any = component.parameters
    piston = np.zeros(parameters.grains, dtype=bool)
    piston[0], piston[-1] = piston[0] or parameters.left == "piston", piston[-1] or parameters.right == "piston"
    places = None
    if overlap is not None:
        places = np.full((len(time), parameters.grains + 1), np.nan)
        places[:, chain.real] = overlap
    return History(
        time, velocity, chain.mass, chain.stiffness, chain.rest_overlap, chain.position, displacement, piston, places
    )


def chain_geometry(component: Component) -> Any:
    """The `Geometry` of a chain; `ParameterError` for any other component."""
    if component.name != "chain":
        raise ParameterError(f"component: got a {component.name!r}, expected a chain; only chains are measured")
    return component.geometry  # type: ignore[attr-defined]


def history(log: Log, segment: int | None = None) -> History:
    """The history in a log of a chain: its frames, and the geometry that follows from its parameters.

    Args:
        log: what `ge.open_log` gave.
        segment: which unbroken run, counted from 0, where the chain was reset or restored while it was recorded.

    Raises:
        LogError: it is no log of a chain, the velocity was not recorded, or it holds several runs and none was named.
    """
    component = log.rebuilt() if log.metadata["component"] == "chain" else None
    if component is None:
        raise LogError(
            f"log {str(log.path)!r} is of a {log.metadata['component']!r}, expected a chain; only chains are measured"
        )
    if "velocity" not in log.variables:
        raise LogError(
            f"log {str(log.path)!r}: velocity was not recorded, recorded are {', '.join(log.variables) or 'none'}; "
            "record with variables=['velocity', 'displacement']"
        )
    own = _segment(log, segment)
    time, velocity = log.series("velocity", own)
    if not len(time):
        raise LogError(f"log {str(log.path)!r} holds no frame of the velocity; record with every= and step")
    for name in ("displacement", "overlap"):
        if name in log.variables:
            times, values = log.series(name, own)
            if not np.array_equal(times, time):
                raise LogError(f"log {str(log.path)!r}: {name} and velocity were recorded at different times")
            return of_chain(component, time, velocity, **{name: values})
    return of_chain(component, time, velocity)


def _segment(log: Log, number: int | None) -> Segment | None:
    segments = log.segments
    if number is not None:
        return segments[whole_number("segment", number, 0, len(segments) - 1)]
    if len(segments) > 1:
        raise LogError(
            f"log {str(log.path)!r} holds {len(segments)} runs, a reset or restore between them; "
            f"name one: segment = 0 to {len(segments) - 1}"
        )
    return segments[0] if segments else None
