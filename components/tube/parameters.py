"""Parameters of a gas in a tube, of the deformable section of the tube, and of their coupling."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import SerializeAsAny, model_validator

from ..detonation.parameters import DetonationParameters
from ..shell.geometry.bodies import Tube
from ..shell.parameters import COARSE_RING, ShellParameters
from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from ..support.tagged_union import ByName, Named
from ..support.validation import Parameters

# Largest relative difference between the cross-sections of gas and shell.
_SAME_AREA = 1e-3
# Largest number of steps of a part in an internal step.
MOST_STEPS = 1000
# Boundaries that the ends of a shell in a tube may have: those that neither move nor open.
_ENDS = ("clamped", "symmetry")


class Coupling(Named):
    """A coupling of gas and shell, chosen by its `name`."""

    @property
    def has_moving_wall(self) -> bool:
        """Whether the gas has the present cross-section of the wall and does work on the wall."""
        return False

    @property
    def has_leakage(self) -> bool:
        """Whether gas leaks through open cracks."""
        return False


class OneWay(Coupling):
    """The gas flows as in a rigid tube, and its pressure loads the wall: Gato & Shie (2010)."""

    name: Literal["one_way"] = field("one_way", "the gas flows as in a rigid tube", "1")


class TwoWay(Coupling):
    """The gas flows through the present cross-section of the wall, and does work on the wall."""

    name: Literal["two_way"] = field("two_way", "the motion of the wall acts back on the gas", "1")
    motion: bool = field(True, "whether the motion of the wall acts on the gas", "1")
    leakage: bool = field(True, "whether gas leaves through open cracks", "1")

    @property
    def has_moving_wall(self) -> bool:
        """Whether the gas has the present cross-section of the wall and does work on the wall."""
        return self.motion

    @property
    def has_leakage(self) -> bool:
        """Whether gas leaks through open cracks."""
        return self.leakage


COUPLINGS: dict[str, type[Coupling]] = {"one_way": OneWay, "two_way": TwoWay}
ChosenCoupling = Annotated[SerializeAsAny[Coupling], ByName(COUPLINGS)]


class TubeParameters(Parameters):
    """A gas in a rigid tube, a section of which is a shell; by default 20 mm of the tube of Gato & Shie (2010)."""

    gas: DetonationParameters = field(
        DetonationParameters(),
        "gas: a table of the parameters of a detonation, without step_size",
        "1",
    )
    shell: ShellParameters = field(
        ShellParameters(),
        "deformable section: a table of the parameters of a shell whose body is a tube, without step_size; a half tube "
        "contains half of the gas, so that gas.cross_section is half of a circle",
        "1",
        examples=[{"body": COARSE_RING}],
    )
    position: NotNegativeMagnitude = field(1.45, "start of the section, in the coordinate x of the gas", "m")
    coupling: ChosenCoupling = field(
        OneWay(), "one_way: the gas flows as in a rigid tube; two_way: the wall acts back on the gas {motion, leakage}", "1"
    )
    outside_pressure: NotNegativeMagnitude | None = field(
        None,
        "pressure outside, subtracted from that on the inner surface, as for a thin wall; 0 for a vacuum; default: the "
        "initial pressure of the gas",
        "Pa",
    )
    vent: NotNegativeMagnitude | None = field(
        None, "position x of a vent, whose area is the input `vent_area`", "m", absent="none"
    )
    discharge: Magnitude = field(
        0.8, "discharge coefficient: mass flow / that of the ideal nozzle; 0.6 to 0.85 for sharp edges", "1", le=1.0
    )
    gas_steps: int | None = field(
        None, "steps of the gas per internal step; default: the suggested number", "1", ge=1, le=MOST_STEPS
    )
    shell_steps: int | None = field(
        None, "steps of the shell per internal step; default: the suggested number", "1", ge=1, le=MOST_STEPS
    )
    step_size: Magnitude | None = field(None, "internal step; default: the larger of the default steps of gas and shell", "s")

    @property
    def room_pressure(self) -> float:
        """Pressure outside [Pa]."""
        return self.gas.initial_pressure if self.outside_pressure is None else self.outside_pressure

    @model_validator(mode="after")
    def _validate_parts(self) -> TubeParameters:
        for part in ("gas", "shell"):
            if getattr(self, part).step_size is not None:
                raise ValueError(
                    f"{part}.step_size: the parts share the step_size of the tube; give it there, and {part}_steps if the "
                    f"{part} makes several steps in it"
                )
        if self.gas.has_pistons:
            raise ValueError(
                "gas: got a piston, which moves the cells, but the shell requires cells at rest; give another kind of end"
            )
        if not isinstance(self.shell.body, Tube):
            raise ValueError(f"shell.body: got {self.shell.body.name!r}, expected a tube")
        for edge, kind in self.shell.boundaries.items():
            if kind not in _ENDS:
                raise ValueError(f"shell.boundaries.{edge}: got {kind!r}, expected {' or '.join(_ENDS)}, or none (free)")
        return self

    @model_validator(mode="after")
    def _validate_places(self) -> TubeParameters:
        body, length = self.shell.body, self.gas.length
        assert isinstance(body, Tube)
        begin, end = self.position, self.position + body.length
        if end > length * (1.0 + 1e-12):
            raise ValueError(
                f"position: got {begin:g} m: the shell would reach from {begin:g} to {end:g} m, beyond the gas "
                f"from 0 to {length:g} m; move it, or make shell.body.length smaller or gas.length larger"
            )
        if self.vent is not None and self.vent > length:
            raise ValueError(f"vent: got {self.vent:g} m, expected 0 to {length:g} m, the length of the gas")
        areas = self.gas.cross_section
        # For a half tube the gas is halved too, so that all amounts belong to the half.
        part = 0.5 if body.half else 1.0
        size, expected = self.gas.cell_size, part * math.pi * body.inner_radius * body.inner_radius
        first, last = int(begin / size), min(math.ceil(end / size), self.gas.cells)
        covered = enumerate(areas[first:last], first) if isinstance(areas, list) else [(first, areas)]
        for cell, area in covered:
            if abs(area - expected) > _SAME_AREA * expected:
                where = f"gas.cross_section[{cell}]" if isinstance(areas, list) else "gas.cross_section"
                radius = math.sqrt(area / (part * math.pi))
                raise ValueError(
                    f"{where}: got {area:g} m^2, a radius of {radius:g} m{' of a half tube' if body.half else ''}, but the "
                    f"shell has {body.inner_radius:g} m; give {expected:.5g} m^2, or another shell.body.inner_radius"
                )
        return self
