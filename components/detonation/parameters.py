"""Parameters of the gas in the tube."""

from __future__ import annotations

from pydantic import model_validator

from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, SignedMagnitude, SignedPair, field
from ..support.validation import Parameters
from .boundaries import ChosenEnd, Closed, Piston
from .gases import MIXTURES, Gas, GasName, gas_from_name
from .limiters import LimiterName
from .reactions import ChosenReaction, Inert, PressureBurn, Reaction

# Tolerance for a position beyond an end, as a fraction of the length, because both have rounding errors.
_ROUNDING = 1e-9


class StartRegion(Parameters):
    """A region of the tube with another initial state."""

    x: SignedPair = field(..., "both ends of the region, which contains the cells with centres between them", "m")
    pressure: Magnitude | None = field(None, "initial pressure; default: that of the tube", "Pa")
    temperature: Magnitude | None = field(None, "initial temperature; default: that of the tube", "K")
    velocity: SignedMagnitude = field(0.0, "initial velocity", "m/s")
    progress: float = field(0.0, "fraction of the gas that has reacted at the start", "1", ge=0.0, le=1.0)


class DetonationParameters(Parameters):
    """A reactive gas in a tube, in one dimension; by default C2H4 + 3 O2 at 100 kPa."""

    length: Magnitude = field(1.52, "length of the tube, from x = 0", "m")
    cells: int = field(760, "number of cells, which have equal lengths", "1", ge=3, le=1_000_000_000)
    cross_section: Magnitude | list[Magnitude] = field(
        1.2254e-3, "cross-section of the tube: one for all cells, or one each; the input `area` changes it", "m^2"
    )
    gas: GasName | Gas = field(
        "ethylene_oxygen",
        f"gas {{gamma, gas_constant, heat_release}}, or a name: {', '.join(MIXTURES)} (tabulated by initial pressure), air",
        "1",
    )
    initial_pressure: Magnitude = field(1e5, "initial pressure", "Pa")
    initial_temperature: Magnitude = field(295.0, "initial temperature, also of the room outside", "K")
    regions: list[StartRegion] = field([], "regions with another initial state; later regions override earlier ones", "1")
    left: ChosenEnd = field(
        Closed(), "end at x = 0: closed, open, absorbing, piston, or a diaphragm with its burst_pressure", "1"
    )
    right: ChosenEnd = field(Closed(), "end at x = length: as `left`", "1")
    ignition_zone: SignedPair = field([0.0, 0.02], "both ends of the zone that the input `ignition_power` heats", "m")
    reaction: ChosenReaction = field(
        PressureBurn(),
        "reaction law: pressure_burn, arrhenius, constant_volume, inert, or a table; a gas that releases no heat is inert",
        "1",
    )
    gauges: list[NotNegativeMagnitude] = field([], "positions x of gauges, with outputs of pressure and velocity", "m")
    limiter: LimiterName = field("monotonized_central", "limiter of slopes: first_order, minmod, monotonized_central", "1")
    step_size: Magnitude | None = field(None, "internal step; default: computed from the fastest expected wave", "s")

    @property
    def chosen_gas(self) -> Gas:
        """The chosen gas; for a mixture, with the constants that belong to the initial pressure."""
        return gas_from_name(self.gas, self.initial_pressure, self.initial_temperature)

    @property
    def chosen_reaction(self) -> Reaction:
        """The law of the reaction; `Inert` for a gas that releases no heat."""
        return self.reaction if self.chosen_gas.heat_release > 0.0 else Inert()

    @property
    def cell_size(self) -> float:
        """Length of a cell [m]."""
        return self.length / self.cells

    @property
    def gauge_cells(self) -> list[int]:
        """Number of the cell in which each gauge lies."""
        return [min(int(x / self.cell_size), self.cells - 1) for x in self.gauges]

    @property
    def has_pistons(self) -> bool:
        """Whether an end is a piston, with which the cells move."""
        return isinstance(self.left, Piston) or isinstance(self.right, Piston)

    @model_validator(mode="after")
    def _validate_pistons(self) -> DetonationParameters:
        if self.has_pistons and self.gauges:
            raise ValueError(
                "gauges: the cells of a tube with a piston move with it, so that no cell stays at a gauge; leave gauges out, "
                "and read pressure and velocity at the output cell_position"
            )
        if self.has_pistons and isinstance(self.cross_section, list) and len(set(self.cross_section)) > 1:
            raise ValueError(
                "cross_section: got different values in a tube with a piston, which must fit all of it; give one number"
            )
        return self

    @model_validator(mode="after")
    def _validate_gas(self) -> DetonationParameters:
        if self.chosen_gas.heat_release == 0.0 and not isinstance(self.reaction, (PressureBurn, Inert)):
            raise ValueError(
                f"reaction: got {self.reaction.name!r} for a gas that releases no heat; give gas.heat_release, or leave the "
                "reaction out"
            )
        return self

    @model_validator(mode="after")
    def _validate_places(self) -> DetonationParameters:
        if isinstance(self.cross_section, list) and len(self.cross_section) != self.cells:
            raise ValueError(
                f"cross_section: got {len(self.cross_section)} numbers, expected one, or {self.cells}, one for each cell"
            )
        places = [("ignition_zone", self.ignition_zone), *((f"regions[{n}].x", one.x) for n, one in enumerate(self.regions))]
        for name, (begin, end) in places:
            if not begin < end:
                raise ValueError(f"{name}: got {begin:g} to {end:g} m, expected the smaller number first")
            if end <= 0.0 or begin >= self.length:
                raise ValueError(f"{name}: got {begin:g} to {end:g} m, outside the tube from 0 to {self.length:g} m")
            # The default ignition zone may be longer than a short tube.
            if name != "ignition_zone" and max(-begin, end - self.length) > _ROUNDING * self.length:
                raise ValueError(
                    f"{name}: got {begin:g} to {end:g} m, which reaches beyond the tube from 0 to {self.length:g} m; give "
                    "the part in the tube"
                )
        for place, x in enumerate(self.gauges):
            if x > self.length:
                raise ValueError(f"gauges[{place}]: got {x:g} m, expected 0 to {self.length:g} m")
        for place, cell in enumerate(self.gauge_cells):
            if cell in self.gauge_cells[:place]:
                raise ValueError(f"gauges[{place}]: lies in the same cell as another gauge; give at most one per cell")
        return self
