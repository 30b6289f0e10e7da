"""Parameters of the solid."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, SerializeAsAny, model_validator

from ..materials.thermoviscoplastic import FlowConstants, Thermoviscoplastic
from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, SignedPair, field
from ..support.tagged_union import ByName, Named
from ..support.validation import Parameters
from .boundaries import BoundaryName, EdgeName
from .fracture.laws import ChosenFracture, NoFracture
from .geometry.bodies import ChosenBody, Plate, Rod, Tube
from .geometry.notch import notch_edge
from .quadrature import RuleName
from .shape_functions import BasisName

# Support radius of a point in node distances: the smallest one that works for each basis.
_RADII = {"linear": 1.7, "quadratic": 2.7}
# Parameters of an example that is quick to build, also with kernels that are not compiled.
COARSE_RING = {"name": "tube", "along": 4, "around": 12, "layers": 2}


class LinearElastic(Named):
    """Hooke's law for the Jaumann rate of the Kirchhoff stress."""

    name: Literal["elastic"] = field("elastic", "a material that never yields", "1")
    young: Magnitude = field(69e9, "Young's modulus", "Pa")
    poisson: float = field(0.33, "Poisson's ratio", "1", gt=-1.0, le=0.49)
    density: Magnitude = field(2719.0, "mass density", "kg/m^3")

    @property
    def melting_temperature(self) -> float | None:
        """None: an elastic body has no temperature."""
        return None

    def constants(self, step_size: float) -> FlowConstants:
        """Return the constants for kernels, for ticks of a given length [s], without plastic flow."""
        law = Thermoviscoplastic(
            young=self.young, poisson=self.poisson, density=self.density, temperature_dependent=False, softening=0.0
        )
        return law.constants(step_size)


SolidMaterial = LinearElastic | Thermoviscoplastic
ChosenMaterial = Annotated[
    SerializeAsAny[SolidMaterial], ByName({"elastic": LinearElastic, "thermoviscoplastic": Thermoviscoplastic})
]


class Integration(Parameters):
    """The points at which stresses are computed."""

    surface: RuleName = Field(
        "column", description="column: one point at each column of nodes; cell: 2 x 2 points between columns",
        json_schema_extra={"unit": "1"},
    )  # fmt: skip
    through: int = field(2, "number of Gauss points through the thickness, at least layers - 1", "1", ge=1, le=8)


class ShellParameters(Parameters):
    """A solid of thin walls, in three dimensions and without a mesh; by default a ring of the tube of Gato & Shie (2010)."""

    body: ChosenBody = field(Tube(), "plate, tube or rod, with its measures and numbers of nodes", "1", examples=[COARSE_RING])
    material: ChosenMaterial = field(
        LinearElastic(), "elastic {young, poisson, density} or thermoviscoplastic (Gato & Shie 2010)", "1"
    )
    boundaries: dict[EdgeName, BoundaryName] = field(
        {},
        "conditions of the edges start, end, left, right, bottom, top: clamped, symmetry, moved (its velocity is an input), "
        "platen (moved along its normal, frictionless), or wall (start or end: a rigid wall without adhesion); default: free",
        "1",
    )
    basis: BasisName = field("linear", "fields that the shape functions reproduce: linear or quadratic", "1")
    radius: Magnitude | None = field(
        None, "support radius of a point, in node spacings; default: 1.7, or 2.7 with the quadratic basis", "1", le=6.0
    )
    integration: Integration | None = field(
        None, "{surface, through}; default: column (cell for a rod), with one point fewer than layers but at least 2", "1"
    )
    hourglass: NotNegativeMagnitude = field(
        0.05, "stiffness against displacements that alternate from column to column, relative to the material", "1", le=1.0
    )
    gauges: list[SignedPair] = field(
        [], "strain gauges on the outer surface: x, and the angle from z to y [rad] (tube) or y (other bodies)", "m"
    )
    fracture: ChosenFracture = field(
        NoFracture(), "fracture law: principal_stress {factor or stress}, plastic_strain {strain}, or none", "1"
    )
    initial_temperature: Magnitude = field(293.0, "temperature at the start", "K")
    step_size: Magnitude | None = field(
        None,
        "internal step; default: 0.8 of the largest stable step (two thirds of that with a fracture law), rounded down to 1, 2 "
        "or 5 times a power of ten; at most 0.9 of the largest stable step (0.6 with a fracture law)",
        "s",
    )

    @property
    def chosen_radius(self) -> float:
        """Support radius of a point, in node distances."""
        return _RADII[self.basis] if self.radius is None else self.radius

    @property
    def integration_rule(self) -> Integration:
        """The integration rule."""
        if self.integration is not None:
            return self.integration
        layers = self.body.node_counts[2]
        return Integration(surface="cell" if isinstance(self.body, Rod) else "column", through=max(layers - 1, 2))

    @model_validator(mode="after")
    def _validate_boundaries(self) -> ShellParameters:
        edges = self.body.edges
        for edge, kind in self.boundaries.items():
            if edge not in edges:
                raise ValueError(f"boundaries: got {edge!r}, expected an edge of the {self.body.name}: {', '.join(edges)}")
            if kind == "wall" and edge not in ("start", "end"):
                raise ValueError(f"boundaries.{edge}: got 'wall', expected it at start or end")
        if [*self.boundaries.values()].count("wall") > 1:
            raise ValueError("boundaries: got two walls, expected at most one")
        return self

    @model_validator(mode="after")
    def _validate_notch(self) -> ShellParameters:
        body = self.body
        if not isinstance(body, Tube | Plate) or body.notch is None:
            return self
        # Only a plate has edges across it that may be free: around a tube there are planes of symmetry, or no edges.
        kinds = {str(one): kind for one, kind in self.boundaries.items()}
        places = [("position", body.notch.position, body.length, ("start", "end"))]
        if isinstance(body, Plate):
            places.append(("around", body.notch.around, body.width, ("left", "right")))
        for name, middle, length, edges in places:
            edge = notch_edge(middle, length, *edges)
            if edge and kinds.get(edge) != "symmetry":
                raise ValueError(
                    f"body.notch.{name}: got {middle:g} m, so the notch would reach beyond the edge {edge!r}; move it into the "
                    f"body, or give boundaries.{edge} = 'symmetry'"
                )
        return self

    @model_validator(mode="after")
    def _validate_neighbourhoods(self) -> ShellParameters:
        across = self.body.node_counts[1]
        notched = isinstance(self.body, Tube | Plate) and self.body.notch is not None
        if notched and self.chosen_radius >= 2.0:
            raise ValueError(
                f"radius: got {self.chosen_radius:g} spacings, expected less than 2 with a notch, so that no support spans it"
            )
        closed = isinstance(self.body, Tube) and not self.body.half
        if closed and across <= 2.0 * self.chosen_radius:
            raise ValueError(
                f"body.around: got {across}, expected more than {2.0 * self.chosen_radius:g}, twice the "
                "support radius of a point: some nodes would be neighbours of a point on both sides"
            )
        return self
