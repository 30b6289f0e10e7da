"""Waves along the chain at an instant: where each one is, over which grains, and the energy and momentum in it."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env.components.support.float_arrays import FloatArray
from granular_env.crests_and_crossings import ridges, top

from .chain_history import Direction, History, sign


@dataclasses.dataclass(frozen=True, slots=True)
class WaveInChain:
    """A wave at an instant.

    Attributes:
        grain: the one that is fastest at that instant.
        position: of the crest between the grains, in the reference configuration [m].
        amplitude: the fastest grain's velocity at that instant [m/s]. While the crest is between two grains neither is at its
            fastest, and this is up to a quarter below the amplitude that `waves_at` gives.
        first: first grain in it.
        last: last grain in it.
        kinetic_energy: of its grains [J].
        potential_energy: of its contacts, above the static one, half of a contact at its border [J].
        momentum: in its direction [kg m/s].
    """

    grain: int
    position: float
    amplitude: float
    first: int
    last: int
    kinetic_energy: float
    potential_energy: float
    momentum: float

    @property
    def energy(self) -> float:
        """Kinetic and potential energy [J]."""
        return self.kinetic_energy + self.potential_energy


def waves_along(
    history: History, time: float, above: float, separation: float = 1.0, direction: Direction = "right"
) -> list[WaveInChain]:
    """Return the waves in a chain at an instant, from left to right, each from the slowest grain before it to the one after.

    Neighbouring waves share no grain, so energies add up.

    Args:
        history: of a chain, with overlaps.
        time: the nearest frame is taken [s].
        above: the least velocity of its fastest grain, more than 0 [m/s].
        separation: as in `waves_at`, here along the chain.
        direction: which way the waves run.

    Raises:
        ParameterError: a time outside of the history, a threshold that is not positive, another separation or direction.
        LogError: overlaps are not known.
    """
    frame, towards = history.frame(time), sign(direction)
    velocity = towards * history.velocity[frame]
    kinetic, potential = 0.5 * history.mass * velocity**2, _potential(history, frame)
    momentum = history.mass * velocity
    found, free = [], 0
    # Beyond the ends nothing moves: a wave may be at its highest in an end grain.
    for begin, peak, end in ridges(np.pad(velocity, 1), above, separation):
        first, last = max(begin - 1, free), min(end - 1, history.grains - 1)
        free = last + 1
        own = slice(first, last + 1)
        place, _ = top(np.arange(-1.0, history.grains + 1.0), np.pad(velocity, 1), peak)
        found.append(
            WaveInChain(
                peak - 1,
                float(np.interp(place, np.arange(history.grains), history.position)),
                float(velocity[peak - 1]),
                first,
                last,
                float(kinetic[own].sum()),
                float(potential[own].sum()),
                float(momentum[own].sum()),
            )  # fmt: skip
        )
    return found


def _potential(history: History, frame: int) -> FloatArray:
    """Energy of the contacts above their static state, half to either grain, a wall's to the one that it has; shape (n,)."""
    stored = history.contact_energy[frame] - history.rest_energy
    approach = history.overlap[frame] - history.rest_overlap
    energy = stored - history.rest_force * approach
    shares = 0.5 * (energy[:-1] + energy[1:])
    shares[0] += 0.5 * energy[0]
    shares[-1] += 0.5 * energy[-1]
    return shares
