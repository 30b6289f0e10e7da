"""Arrangements of grains by name: uniform, dimer, tapered, decorated, random, impurity. One a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import SerializeAsAny

from ...errors import ParameterError
from ...support.tagged_union import ByName
from .arrangement import Arrangement, Uniform
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


ChosenArrangement = Annotated[SerializeAsAny[Arrangement], ByName(ARRANGEMENTS)]


def refuse_misfit(parameters: ChainParameters) -> None:
    """`ParameterError` where an arrangement does not fit the chain, or says again what the chain's own parameters say."""
    arrangement, explicit = parameters.arrangement, parameters.model_fields_set
    try:
        arrangement.fit(parameters.grains)
    except ParameterError as error:
        raise error.within("arrangement") from None
    for name in arrangement.own_parameters():
        if name in explicit:
            raise ParameterError(
                "the arrangement gives it too", hint=f"give it in one place, as {name} or in the arrangement", at=name
            )
    if isinstance(arrangement, Impurity) and arrangement.mass is not None and parameters.mass is not None:
        twice = [i for i in arrangement.indices if i in parameters.mass] if isinstance(parameters.mass, dict) else True
        if twice:
            raise ParameterError("the arrangement 'impurity' gives its mass too", hint="give it in one place", at="mass")
