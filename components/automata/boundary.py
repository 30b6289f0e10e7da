"""Loads and grips: inputs as forces and tractions on a specimen (`Load`), and as prescribed velocities (`Grip`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..contract import Variable
from ..inputs import Held
from ..profiles import CompiledProfile
from .motion import HOLDS_X, HOLDS_Y, Grip, Load
from .packing import Packing
from .parameters import AutomataParameters
from .shapes import Rectangle
from .sides import SIDES, Side, find_sides, shared_areas


class Boundary:
    """The inputs of a specimen, and the loads and grips that they fill.

    Attributes:
        load: forces, with the values of the inputs that were applied last.
        grip: prescribed velocities, likewise.
        load_before: memory for `motion.add_loads`.
        grip_before: memory for `motion.hold`.
    """

    def __init__(self, parameters: AutomataParameters, packing: Packing) -> None:
        """Find the automata that inputs act on; raises `IndexError` where one of `loaded` does not exist."""
        p = self._parameters = parameters
        count = len(packing.kind)
        self._loaded = np.arange(count) if p.loaded == "all" else np.array(p.loaded, np.int64)
        if self._loaded.size and self._loaded.max() >= count:
            raise IndexError(int(self._loaded.max()))
        self._sides = find_sides(packing, {name: getattr(p, name) for name in SIDES}, p.grip_depth)
        self._fill_load(packing)
        self._fill_grip()

    def _fill_load(self, packing: Packing) -> None:
        p, start = self._parameters, len(self._loaded)
        groups, self._shares = [self._loaded], []
        for side in self._of_kind("traction"):
            assert isinstance(p.shape, Rectangle)
            area = p.thickness * (p.shape.height if side.axis == 0 else p.shape.width)
            self._shares.append((side, slice(start, start + len(side.automata)), shared_areas(packing, side, area)))
            groups.append(side.automata)
            start += len(side.automata)
        automata = np.concatenate(groups).astype(np.int64)
        self.load = Load(automata, np.zeros((len(automata), 2)))
        self.load_before = np.zeros((len(automata), 2))

    def _fill_grip(self) -> None:
        held: dict[int, int] = {}
        self._moved: list[tuple[Side, int, np.ndarray]] = []
        owner: dict[tuple[int, int], Side] = {}
        for side in self._sides:
            for i in side.automata.tolist() if side.held else ():
                held[i] = held.get(i, 0) | side.held
                for axis, bit in enumerate((HOLDS_X, HOLDS_Y)):
                    if side.held & bit:
                        owner[i, axis] = side
        automata = np.array(sorted(held), np.int64)
        self.grip = Grip(automata, np.array([held[i] for i in automata.tolist()], np.int64), np.zeros((len(automata), 2)))
        self.grip_before = np.zeros((len(automata), 3))
        for side in self._of_kind("velocity", "platen"):
            for axis in (0, 1):
                rows = [row for row, i in enumerate(automata.tolist()) if owner.get((i, axis)) is side]
                if rows:
                    self._moved.append((side, axis, np.array(rows, np.int64)))

    def _of_kind(self, *kinds: str) -> list[Side]:
        return [side for side in self._sides if side.kind in kinds]

    def side(self, name: str) -> Side | None:
        """Return one of the sides, or None where it is free."""
        return next((side for side in self._sides if side.name == name), None)

    def inputs(self) -> Iterable[Variable]:
        """Declare the inputs."""
        if self._loaded.size:
            shape, axes = (len(self._loaded), 2), ("loaded automaton", "direction")
            yield Variable("force", "input", "N", shape, "force on each loaded automaton", start=0.0, axes=axes)
        for side in self._sides:
            name, kind = side.name, side.kind
            if kind == "velocity":
                text = f"velocity of the {name} side"
                yield Variable(f"{name}_velocity", "input", "m/s", (2,), text, start=0.0, axes=("direction",))
            elif kind == "platen":
                along = "x" if side.axis == 0 else "y"
                text = f"velocity of the {name} side's platen along {along}"
                yield Variable(f"{name}_speed", "input", "m/s", (), text, start=0.0)
            elif kind == "traction":
                text = f"force per area on the {name} side"
                yield Variable(f"{name}_traction", "input", "Pa", (2,), text, start=0.0, axes=("direction",))

    def apply(self, held: Mapping[str, Held], tick: int, part: float = 1.0) -> None:
        """Fill loads and grips for the internal step that begins at a tick: forces at its middle, velocities at a part."""
        if self._loaded.size:
            self.load.force[: len(self._loaded)] = _value(held["force"], tick, 0.5)
        for side, rows, areas in self._shares:
            self.load.force[rows] = areas[:, np.newaxis] * _value(held[f"{side.name}_traction"], tick, 0.5)
        for side, axis, rows in self._moved:
            if side.kind == "platen":
                self.grip.velocity[rows, axis] = _value(held[f"{side.name}_speed"], tick, part)
            else:
                self.grip.velocity[rows, axis] = _value(held[f"{side.name}_velocity"], tick, part)[axis]


def _value(held: Held, tick: int, part: float) -> Any:
    return held.value(tick, part) if isinstance(held, CompiledProfile) else held
