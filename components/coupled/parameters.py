"""Parameters of a grid and automata that share an interface."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from ..automata.parameters import AutomataParameters
from ..errors import ParameterError
from ..grid.parameters import GridParameters
from ..support.parameter_fields import Pair, Positive, field, refuse_extreme_coordinates
from ..support.validation import Parameters

Scheme = Literal["force", "momentum", "literal"]


class CoupledParameters(Parameters):
    """A grid, and automata that fill the rest of the body; they meet at the interface; a slab one metre thick."""

    grid: GridParameters = field(
        ...,
        "continuous part: a table of the parameters of a grid, without step_size",
        "1",
        examples=[
            {
                "mesh": {"name": "rectangle", "columns": 4, "rows": 2, "cell_size": 0.01, "centre": [0.02, 0.03]},
                "boundaries": {"top": "velocity"},
            }
        ],
    )
    automata: AutomataParameters = field(
        ...,
        "discrete part: a table of the parameters of automata, without step_size and thickness",
        "1",
        examples=[{"shape": {"name": "rectangle", "width": 0.04, "height": 0.02}, "diameter": 0.01, "packing": "square"}],
    )
    origin: Pair = field([0.0, 0.0], "position of the origin of the automata's shape, in the coordinates of the grid", "m")
    scheme: Scheme = field(
        "force",
        "motion of interface nodes. force: by the sum of the forces of both parts; momentum: each part moves its own nodes, "
        "then momenta are added (equal to rounding); literal: the sub-steps of Psakhie et al. as written (unstable)",
        "1",
    )
    micro_steps: int = field(
        1,
        "internal steps of the automata per step of the grid. 1: lockstep, in which a body at rest stays at rest; more: "
        "longer steps of the grid with small automata, but static stresses oscillate at the interface",
        "1",
        ge=1,
        le=1000,
    )
    step_size: Positive | None = field(
        None,
        "internal step; default: 0.8 of the largest step stable for both parts, less with micro-steps, rounded down",
        "s",
    )

    side_contacts: bool = field(
        False, "whether automata can touch the (frictionless) free sides of the grid; requires links that break or yield", "1"
    )

    @model_validator(mode="after")
    def _validate_side_contacts(self) -> CoupledParameters:
        if self.side_contacts and self.scheme == "literal":
            raise ParameterError("is not possible with scheme = literal", hint="choose scheme = force", at="side_contacts")
        if self.side_contacts and not self.automata.has_history:
            raise ParameterError(
                "got true, but no automaton can detach", hint="choose a criterion, or leave it out", at="side_contacts"
            )
        periodic = [name for name, boundary in self.grid.boundaries.items() if boundary.name == "periodic"]
        if self.side_contacts and (periodic or any(self.automata.periodic)):
            raise ParameterError("got true for a body with periodic edges", expected="no periodic edges", at="side_contacts")
        return self

    @model_validator(mode="after")
    def _validate_parts(self) -> CoupledParameters:
        for part in ("grid", "automata"):
            if getattr(self, part).step_size is not None:
                raise ParameterError(
                    "both parts have the same step_size", hint=f"give it next to {part}, not in it", at=(part, "step_size")
                )
        if self.automata.thickness != 1.0:
            raise ParameterError(
                f"got {self.automata.thickness:g} m",
                expected="1 m, the thickness of the grid",
                at=("automata", "thickness"),
            )
        refuse_extreme_coordinates((("origin", place), one) for place, one in enumerate(self.origin))
        if self.scheme == "literal" and self.micro_steps == 1:
            raise ParameterError(
                "got 1 with scheme = literal, which differs from the others only in its sub-steps",
                expected="2 or more",
                hint='give the number of sub-steps of the automata per step; for 1 choose scheme = "force"',
                at="micro_steps",
            )
        return self
