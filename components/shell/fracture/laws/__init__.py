"""Fracture laws by name, one module each."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import SerializeAsAny

from ....support.parameter_fields import field
from ....support.tagged_union import ByName, Named
from .fracture_law import FractureLaw
from .plastic_strain import PlasticStrain
from .principal_stress import PrincipalStress


class NoFracture(Named):
    """No fracture: the body stays whole."""

    name: Literal["none"] = field("none", "nothing parts", "1")


LAWS: dict[str, type[Named]] = {"none": NoFracture, "principal_stress": PrincipalStress, "plastic_strain": PlasticStrain}
ChosenFracture = Annotated[SerializeAsAny[NoFracture | FractureLaw], ByName(LAWS)]
