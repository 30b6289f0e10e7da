"""What stock viewers draw: a thinned film of the run, written when the log is closed.

``/particles`` is a ``foxglove.PointCloud`` of every particle at its true place, coloured by the component's colour variable
(blue - grey - red for - 0 +); ``/scalars`` is a ROS 2 ``JointState`` that names the ledger's entries, the inputs and the
scalar outputs. Rerun and Foxglove plot both without our code. They are single precision and thinned: never read back.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from functools import cache

import numpy as np

from ..components.contract import Component, Ledger, Particles
from . import schemas
from .sink import Sink

_MOST_FRAMES = 400
# Memory that the film may take while the run goes on, and so its share of the file [bytes].
_MOST_BYTES = 16 << 20
LEDGER = tuple(field.name for field in dataclasses.fields(Ledger))
_SHADES = 127
_NEGATIVE, _ZERO, _POSITIVE = np.array([[40.0, 90.0, 220.0], [190.0, 190.0, 190.0], [220.0, 50.0, 40.0]])


@dataclasses.dataclass(slots=True)
class _Picture:
    number: int
    nanoseconds: int
    scalars: list[float]
    displacement: np.ndarray | None
    colour: np.ndarray | None


class Track:
    """Keeps every 2^k-th of the frames that it is shown, k growing so that at most 400 stay."""

    def __init__(self, particles: Particles | None, scalars: list[str], stride: int = 1) -> None:
        """`scalars` are the names that `add` will give values for; `stride` is how much it thins to begin with."""
        self._particles, self.names = particles, scalars
        size = 8 * len(scalars) + (0 if particles is None else 16 * len(particles.radius))
        self._capacity = max(8, min(_MOST_FRAMES, _MOST_BYTES // max(size, 1)))
        self._stride = stride
        self._kept: list[_Picture] = []

    @property
    def particles(self) -> Particles | None:
        """What it draws."""
        return self._particles

    @property
    def stride(self) -> int:
        """Distance of the frames that it keeps: those whose number it divides."""
        return self._stride

    def wants(self, number: int) -> bool:
        """Whether the frame of this number would be kept."""
        return number % self._stride == 0

    def take(self, number: int, nanoseconds: int, component: Component, ledger: Ledger) -> None:
        """Show it a frame of a component, whose ledger has been drawn up."""
        particles = self._particles
        seen = (None, None) if particles is None else (component.peek(particles.displacement), component.peek(particles.colour))
        self.add(number, nanoseconds, scalar_values(component, self.names, ledger), *seen)

    def add(self, number: int, nanoseconds: int, scalars: list[float], displacement: object, colour: object) -> None:
        """Show it a frame."""
        single = [None if values is None else np.asarray(values, dtype=np.float32) for values in (displacement, colour)]
        self._kept.append(_Picture(number, nanoseconds, scalars, *single))
        if len(self._kept) > self._capacity:
            self._stride *= 2
            self._kept = [picture for picture in self._kept if self.wants(picture.number)]

    def forget_from(self, number: int) -> None:
        """Drop the frames of this number and later: they are counted anew."""
        self._kept = [picture for picture in self._kept if picture.number < number]

    def write(self, sink: Sink) -> None:
        """Write the film."""
        largest = max((float(np.abs(p.colour).max(initial=0.0)) for p in self._kept if p.colour is not None), default=0.0)
        for picture in self._kept:
            sink.add_message(
                "/scalars", schemas.joint_state(picture.nanoseconds, self.names, picture.scalars), picture.nanoseconds
            )
            if self._particles is not None and picture.displacement is not None and picture.colour is not None:
                positions = positions_of(self._particles, picture.displacement)
                cloud = schemas.point_cloud(picture.nanoseconds, positions, colours_of(picture.colour, largest))
                sink.add_message("/particles", cloud, picture.nanoseconds)


def scalar_names(component: Component) -> list[str]:
    """The ledger's entries, the inputs and the scalar outputs of a component."""
    own = [
        v.name for v in component.variables.values() if v.causality != "parameter" and v.shape == () and v.name not in LEDGER
    ]
    return [*LEDGER, *own]


def scalar_values(component: Component, names: Iterable[str], ledger: Ledger) -> list[float]:
    """Values of such names, the ledger having been drawn up."""
    return [float(getattr(ledger, name) if name in LEDGER else component.get(name)) for name in names]


def positions_of(particles: Particles, displacement: np.ndarray) -> np.ndarray:
    """Reference plus displacement (along x where it is one number a particle), shape (n, 3) [m], single precision."""
    positions = particles.reference.astype(np.float32)
    if displacement.ndim == 1:
        positions[:, 0] = particles.reference[:, 0] + displacement
    else:
        positions[:] = particles.reference + displacement
    return positions


def colours_of(values: np.ndarray, largest: float) -> np.ndarray:
    """Blue below 0, grey at 0, red above, full at `largest`; shape (n, 4) uint8."""
    shades = np.clip(values * np.float32(_SHADES / (largest or 1.0)), -_SHADES, _SHADES)
    return _palette()[shades.astype(np.int16) + _SHADES]


@cache
def _palette() -> np.ndarray:
    part = np.linspace(-1.0, 1.0, 2 * _SHADES + 1)[:, None]
    shade = np.where(part < 0.0, _ZERO + (_ZERO - _NEGATIVE) * part, _ZERO + (_POSITIVE - _ZERO) * part)
    return np.concatenate([shade, np.full_like(part, 255.0)], axis=1).round().astype(np.uint8)
