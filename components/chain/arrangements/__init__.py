"""Arrangements of grains by name: uniform, dimer, tapered, decorated, random, impurity. One a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, SerializeAsAny, ValidationError

from ...errors import nearest, shortened
from ...validation import explained
from .base import Arrangement, Uniform
from .decorated import Decorated
from .dimer import Dimer
from .impurity import Impurity
from .random_radii import Random
from .tapered import Tapered

if TYPE_CHECKING:
    from ..parameters import ChainParameters

__all__ = ["ARRANGEMENTS", "Arrangement", "ChosenArrangement", "Uniform", "refuse_misfit"]

ARRANGEMENTS: dict[str, type[Arrangement]] = {
    "uniform": Uniform,
    "dimer": Dimer,
    "tapered": Tapered,
    "decorated": Decorated,
    "random": Random,
    "impurity": Impurity,
}


def _chosen(given: Any) -> Arrangement:
    """An arrangement from a name, or from a table with one."""
    if isinstance(given, Arrangement):
        return given
    fields = {"name": given} if isinstance(given, str) else given
    if not isinstance(fields, Mapping):
        raise ValueError(f"got {shortened(given)}, expected a name, or a table such as {{name = 'dimer', ...}}")
    name = fields.get("name")
    if name is None:
        raise ValueError(f"name: missing; known: {', '.join(ARRANGEMENTS)}")
    if not isinstance(name, str) or name not in ARRANGEMENTS:
        raise ValueError(f"name: {shortened(name)} is unknown; {nearest(str(name), ARRANGEMENTS)}")
    model = ARRANGEMENTS[name]
    try:
        return model(**{str(key): value for key, value in fields.items()})
    except ValidationError as error:
        raise ValueError("; ".join(explained(error, model))) from None


ChosenArrangement = Annotated[SerializeAsAny[Arrangement], BeforeValidator(_chosen)]


def refuse_misfit(parameters: ChainParameters) -> None:
    """`ValueError` where an arrangement does not fit the chain, or says again what the chain's own parameters say."""
    arrangement, explicit = parameters.arrangement, parameters.model_fields_set
    try:
        arrangement.fit(parameters.grains)
    except ValueError as error:
        raise ValueError(f"arrangement: {error}") from None
    for name in arrangement.given():
        if name in explicit:
            raise ValueError(f"{name}: the arrangement gives it too; give it in one place, as {name} or in the arrangement")
    if isinstance(arrangement, Impurity) and arrangement.mass is not None and parameters.mass is not None:
        twice = [i for i in arrangement.indices if i in parameters.mass] if isinstance(parameters.mass, dict) else True
        if twice:
            raise ValueError("mass: the arrangement 'impurity' gives its mass too; give it in one place")
