"""The waves in a chain at an instant: position, extent, energy and momentum of each."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env.components.support.float_arrays import FloatArray
from granular_env.crests_and_crossings import crest_indices, interpolated_maximum

from .chain_history import Direction, History, direction_sign


@dataclasses.dataclass(frozen=True, slots=True)
class WaveInChain:
    """A wave at an instant.

    Attributes:
        grain: the fastest grain at that instant.
        position: position of the crest between the grains, in the reference configuration [m].
        amplitude: the fastest grain's velocity at that instant [m/s]. While the crest is between two grains, it is up to a
            quarter below the amplitude from `waves_at`.
        first: first grain of the wave.
        last: last grain of the wave.
        kinetic_energy: kinetic energy of the wave's grains [J].
        potential_energy: elastic energy of its contacts above the state at rest; a contact at the border counts half [J].
        momentum: momentum in the wave's direction [kg m/s].
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
        """Kinetic plus potential energy [J]."""
        return self.kinetic_energy + self.potential_energy


def waves_along(
    history: History, time: float, above: float, separation: float = 1.0, direction: Direction = "right"
) -> list[WaveInChain]:
    """Return the waves in a chain at an instant, from left to right, each delimited by the slowest grains around its crest.

    Neighbouring waves share no grain, so energies add up.

    Args:
        history: history of a chain, with overlaps.
        time: time of the instant [s]; the nearest frame is used.
        above: smallest velocity of a wave's fastest grain that counts, greater than 0 [m/s].
        separation: as in `waves_at`, but between neighbouring maxima along the chain instead of in time.
        direction: direction in which the waves run.

    Raises:
        ParameterError: a time outside the history, a threshold that is not positive, an invalid separation or direction.
        LogError: overlaps are unknown.
    """
    frame, towards = history.frame_number(time), direction_sign(direction)
    velocity = towards * history.velocity[frame]
    kinetic, potential = 0.5 * history.mass * velocity**2, _potential_energies(history, frame)
    momentum = history.mass * velocity
    found, free = [], 0
    # Add a grain of zero velocity beyond each end, because a wave may have its crest at an end grain.
    for begin, peak, end in crest_indices(np.pad(velocity, 1), above, separation):
        first, last = max(begin - 1, free), min(end - 1, history.grains - 1)
        free = last + 1
        own = slice(first, last + 1)
        place, _ = interpolated_maximum(np.arange(-1.0, history.grains + 1.0), np.pad(velocity, 1), peak)
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


def _potential_energies(history: History, frame: int) -> FloatArray:
    """Return each grain's share (half; all at a wall) of the contact energies above the state at rest, shape (n,) [J]."""
    stored = history.contact_energy[frame] - history.rest_energy
    approach = history.overlap[frame] - history.rest_overlap
    energy = stored - history.rest_force * approach
    shares = 0.5 * (energy[:-1] + energy[1:])
    shares[0] += 0.5 * energy[0]
    shares[-1] += 0.5 * energy[-1]
    return shares
