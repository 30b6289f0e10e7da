"""The frames of a run that its preview shows: thinned while the run goes on, in bounded memory."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator

import numpy as np

from ..components.component import Component
from ..components.contract import Ledger, Particles
from .preview import PreviewFacts, PreviewFrame, PreviewMessage, preview_messages

_MOST_FRAMES = 400
# Memory that the frames may take while the run goes on [bytes].
_MOST_BYTES = 16 << 20
LEDGER = tuple(field.name for field in dataclasses.fields(Ledger))


class Track:
    """Keeps every 2^k-th of the frames that it is shown, k growing so that at most 400 stay.

    Attributes:
        facts: what the preview needs to know beside the frames.
        frames: those kept, in the order of time.
    """

    def __init__(self, facts: PreviewFacts, stride: int = 1) -> None:
        """Start with every `stride`-th frame."""
        self.facts = facts
        self.frames: list[PreviewFrame] = []
        size = 8 * len(facts.units) + (0 if facts.particles is None else 16 * len(facts.particles.radius))
        self._capacity = max(8, min(_MOST_FRAMES, _MOST_BYTES // max(size, 1)))
        self._stride = stride

    @property
    def particles(self) -> Particles | None:
        """What it draws."""
        return self.facts.particles

    @property
    def names(self) -> list[str]:
        """The scalars that `add` wants values of."""
        return list(self.facts.units)

    @property
    def stride(self) -> int:
        """Distance of the frames that it keeps: those whose number it divides."""
        return self._stride

    def wants(self, number: int) -> bool:
        """Return whether the frame of this number would be kept."""
        return number % self._stride == 0

    def take(self, number: int, nanoseconds: int, component: Component, ledger: Ledger) -> None:
        """Show it a frame of a component, whose ledger has been drawn up."""
        particles = self.facts.particles
        seen = (None, None) if particles is None else (component.peek(particles.displacement), component.peek(particles.colour))
        self.add(number, nanoseconds, scalar_values(component, self.names, ledger), *seen)

    def add(self, number: int, nanoseconds: int, scalars: list[float], displacement: object, colour: object) -> None:
        """Show it a frame; the arguments are those of `PreviewFrame`."""
        single = [None if values is None else np.array(values, dtype=np.float32) for values in (displacement, colour)]
        self.frames.append(PreviewFrame(number, nanoseconds, scalars, *single))
        if len(self.frames) > self._capacity:
            self._stride *= 2
            self.frames = [frame for frame in self.frames if self.wants(frame.number)]

    def forget_from(self, number: int) -> None:
        """Drop the frames of this number and later: they are counted anew."""
        self.frames = [frame for frame in self.frames if frame.number < number]

    def messages(self) -> Iterator[PreviewMessage]:
        """Yield the preview of the frames kept."""
        return preview_messages(self.facts, self.frames)


def facts_of(component: Component, title: str | None = None) -> PreviewFacts:
    """Return the facts of a component's preview: the ledger's entries, the inputs and the scalar outputs."""
    particles = component.particles()
    colour_unit = "" if particles is None else component.variables[particles.colour].unit
    units = {name: component.variables[name].unit for name in scalar_names(component)}
    return PreviewFacts(title or component.name, particles, colour_unit, units)


def scalar_names(component: Component) -> list[str]:
    """Return the names of the ledger's entries, the inputs and the scalar outputs of a component."""
    own = [
        v.name for v in component.variables.values() if v.causality != "parameter" and v.shape == () and v.name not in LEDGER
    ]
    return [*LEDGER, *own]


def scalar_values(component: Component, names: Iterable[str], ledger: Ledger) -> list[float]:
    """Return the values of such names, the ledger having been drawn up."""
    return [float(getattr(ledger, name) if name in LEDGER else component.get(name)) for name in names]
