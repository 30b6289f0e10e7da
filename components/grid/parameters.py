"""Parameters of the grid."""

from __future__ import annotations

from typing import Any

from pydantic import field_validator, model_validator

from ..errors import ParameterError, spelling_hint
from ..materials.elastic import Material, Preset, material_constants, preset_text
from ..materials.plastic_law_catalogue import ChosenPlasticity, Elastic
from ..regions import ChosenArea
from ..support.parameter_fields import Index, Pair, Positive, field, refuse_extreme_values
from ..support.validation import Parameters
from .boundaries import ChosenBoundary
from .mesh_parameters import ChosenShape, Rectangle

Place = Index | Pair


class Region(Parameters):
    """A part of the body with one of the materials."""

    area: ChosenArea = field(..., "area that contains the centres of these cells: a box or a disc", "1")
    material: int = field(..., "number of the material, from 0", "1", ge=0)


class GridParameters(Parameters):
    """A continuum in plane strain on a mesh of quadrilaterals that moves with it; a slab one metre thick."""

    mesh: ChosenShape = field(
        Rectangle(), "{name = rectangle, columns, rows, cell_size}, or {name = quadrilaterals, nodes, cells, edges}", "1",
        examples=[{"name": "rectangle", "columns": 8, "rows": 4}],
    )  # fmt: skip
    material: Preset | Material | list[Preset | Material] = field(
        "steel", f"material, or the name of a preset ({preset_text()}); a list for `regions` or `cell_material`", "1"
    )
    plasticity: list[ChosenPlasticity] = field(
        [Elastic()], "plastic law: elastic, von_mises, drucker_prager, or a table; one for all materials, or one for each", "1"
    )
    regions: list[Region] = field([], "areas of the materials; later ones cover earlier ones, material 0 fills the rest", "1")
    cell_material: list[Index] | None = field(
        None, "number of the material of each cell, instead of `regions`", "1", absent="none"
    )
    boundaries: dict[str, ChosenBoundary] = field(
        {}, "condition of each edge: free (the default), fixed, symmetry, periodic, velocity, traction, absorbing", "1",
        examples=[{"left": "velocity"}],
    )  # fmt: skip
    forced_nodes: list[Place] = field([], "nodes on which the input `force` acts: numbers, or points [x, y]", "1")
    receivers: list[Place] = field([], "nodes with additional outputs of their motion: numbers, or points [x, y]", "1")
    hourglass: float = field(
        1.0, "stiffness against hourglass modes, as a fraction of that of a fully integrated cell", "1", ge=0.0, le=4.0
    )
    step_size: Positive | None = field(None, "internal step; default: 0.8 of the largest stable step, rounded down", "s")

    @property
    def materials(self) -> list[Any]:
        """The materials by number, each the name of a preset or a material."""
        return self.material if isinstance(self.material, list) else [self.material]

    @property
    def plastic_laws(self) -> list[Any]:
        """The plastic law of each material."""
        return self.plasticity * len(self.materials) if len(self.plasticity) == 1 else self.plasticity

    @field_validator("plasticity", mode="before")
    @classmethod
    def _expand_single_law(cls, value: Any) -> Any:
        """Accept a single law, not in a list, as the law of all materials."""
        return value if isinstance(value, (list, tuple)) else [value]

    @model_validator(mode="after")
    def _validate_materials(self) -> GridParameters:
        count = len(self.materials)
        if not count:
            raise ParameterError("got none", expected="at least one", at="material")
        if len(self.plastic_laws) != count:
            raise ParameterError(
                f"got {len(self.plastic_laws)} laws for {count} materials",
                hint="give one for all, or one for each",
                at="plasticity",
            )
        if self.regions and self.cell_material is not None:
            raise ParameterError("`regions` is given too", hint="give only one of them", at="cell_material")
        for place, region in enumerate(self.regions):
            if region.material >= count:
                raise ParameterError(f"got {region.material}", expected=f"0 to {count - 1}", at=("regions", place, "material"))
        for place, number in enumerate(self.cell_material or ()):
            if number >= count:
                raise ParameterError(f"got {number}", expected=f"0 to {count - 1}", at=("cell_material", place))
        return self

    @model_validator(mode="after")
    def _validate_magnitudes(self) -> GridParameters:
        refuse_extreme_values(material_constants(self.material))
        return self

    @model_validator(mode="after")
    def _validate_edges(self) -> GridParameters:
        known = self.mesh.edge_names
        for name in self.boundaries:
            if name not in known:
                raise ParameterError("is not an edge of this mesh", hint=spelling_hint(name, known), at=("boundaries", name))
        return self
