"""The selection of frames that a preview shows: thinned while the run goes on, in bounded memory."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from ...components.component import Component
from ...components.drawables import Drawable, Links, Points, drawn_outputs
from ...components.variables import Variable
from .messages import PreviewFacts, PreviewFrame, PreviewMessage, pictured, preview_messages

_MOST_FRAMES = 400
# Memory that the frames may take while the run goes on [bytes].
_MOST_BYTES = 8 << 20

# What the end of a log says of a preview that was made from its frames.
FROM_FRAMES: Mapping[str, str] = {"source": "frames"}


class PreviewFrames:
    """Keeps every 2^k-th of the frames that it is shown, k growing so that at most 400 stay.

    Attributes:
        facts: what the preview needs to know beside the frames.
        frames: those kept, in the order of time.
        capacity: how many it keeps at most.
    """

    def __init__(self, facts: PreviewFacts, stride: int = 1) -> None:
        """Start with every `stride`-th frame."""
        self.facts = facts
        self.frames: list[PreviewFrame] = []
        size = 8 * len(facts.units) + sum(4 * count for count in facts.sizes.values())
        self.capacity = max(8, min(_MOST_FRAMES, _MOST_BYTES // max(size, 1)))
        self._stride, self._pictured = stride, drawn_outputs(pictured(facts.drawables))

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

    def take(self, number: int, nanoseconds: int, component: Component, balances: Mapping[str, Any]) -> None:
        """Show it a frame of a component, and the entries of its balances, which have been drawn up."""
        drawn = {name: component.peek(name) for name in self._pictured}
        self.add(number, nanoseconds, scalar_values(component, self.names, balances), drawn)

    def add(self, number: int, nanoseconds: int, scalars: list[float], drawn: Mapping[str, Any]) -> None:
        """Show it a frame; the arguments are those of `PreviewFrame`, `drawn` may hold more than that."""
        single = {name: np.array(drawn[name], dtype=np.float32) for name in self._pictured}
        before = [frame for frame in self.frames if frame.number < number]  # later ones are of a step that was undone
        frames, stride = [*before, PreviewFrame(number, nanoseconds, scalars, single)], self._stride
        if len(frames) > self.capacity:
            stride *= 2
            frames = [frame for frame in frames if frame.number % stride == 0]
        self.frames, self._stride = frames, stride  # nothing interrupts two assignments in a row

    def forget_from(self, number: int) -> None:
        """Drop the frames of this number and later: they are counted anew."""
        self.frames = [frame for frame in self.frames if frame.number < number]

    def messages(self) -> Iterator[PreviewMessage]:
        """Yield the preview of the frames kept."""
        return preview_messages(self.facts, self.frames)


def facts_of(component: Component, title: str | None = None) -> PreviewFacts:
    """Return the facts of a component's preview: what is drawn, the balances, the inputs and the scalar outputs."""
    units = {name: component.variables[name].unit for name in scalar_names(component)}
    return preview_facts(title or component.name, component.drawables(), component.variables, units)


def preview_facts(
    title: str, drawables: Iterable[Drawable], variables: Mapping[str, Variable], units: Mapping[str, str]
) -> PreviewFacts:
    """Return the facts of a preview.

    Args:
        title: name of the experiment, else of the component.
        drawables: what is drawn.
        variables: those that can be had; what shows others is left out.
        units: unit of each scalar, by name.
    """
    whole = [drawable for drawable in drawables if set(drawn_outputs([drawable])) <= variables.keys()]
    # Links lie between points, which have to be shown too.
    points = {drawable.name for drawable in whole if isinstance(drawable, Points)}
    shown = tuple(drawable for drawable in whole if not isinstance(drawable, Links) or drawable.points in points)
    outputs = {name: variables[name] for name in drawn_outputs(shown)}
    sizes = {name: math.prod(variable.shape) for name, variable in outputs.items()}
    drawn_units = {name: variable.unit for name, variable in outputs.items()}
    # The others are not held on to: those of a large body take as much memory as three frames.
    return PreviewFacts(title, pictured(shown), drawn_units, sizes, units)


def scalar_names(component: Component) -> list[str]:
    """Return the names of the balances' entries, the inputs and the outputs of a component that are one number."""
    names = [*component.balance_names, *(v.name for v in component.variables.values() if v.causality != "parameter")]
    return [name for name in dict.fromkeys(names) if component.variables[name].shape == ()]


def scalar_values(component: Component, names: Iterable[str], balances: Mapping[str, Any]) -> list[float]:
    """Return the values of such names, the balances having been drawn up."""
    return [float(balances[name] if name in balances else component.get(name)) for name in names]
