"""Response functions of a pair, one a file: the four of Psakhie et al. (2003), figure 3.

Beyond an onset the equivalent stress follows a line of smaller slope. Unloading tells them apart: (b) it returns to the origin
with a reduced modulus, (c) it is elastic and leaves a strain, (d) something of both. They differ in one number, the part of the
excess that degrades the modulus; `return_mapping.py` has the formula.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ...support.tagged_union import OneOrEach
from .degrading import Degrading
from .linear import Linear
from .plastic import Plastic
from .plastic_degrading import PlasticDegrading
from .response import Response

__all__ = ["RESPONSES", "ChosenResponses", "Degrading", "Linear", "Plastic", "PlasticDegrading", "Response"]

RESPONSES: dict[str, type[Response]] = {
    "linear": Linear,
    "degrading": Degrading,
    "plastic": Plastic,
    "plastic_degrading": PlasticDegrading,
}

ChosenResponses = Annotated[SerializeAsAny[Response] | list[SerializeAsAny[Response]], OneOrEach(RESPONSES)]
