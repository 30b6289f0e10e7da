"""Contact laws, one a file: what they declare, and their formulas.

A law is conservative, velocity-dependent or has a history, and says so. Elastic forces and dissipation are given to the kernels
as kinds (`layout`), `dispatch` finds the functions.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ...support.tagged_union import ByName
from .elastic_plastic import ElasticPlastic
from .hertz import Hertz
from .kuwabara_kono import KuwabaraKono
from .law import Dissipative, Law
from .power import Power
from .viscous import Viscous

__all__ = ["LAWS", "ChosenLaw", "Dissipative", "ElasticPlastic", "Hertz", "KuwabaraKono", "Law", "Power", "Viscous"]

LAWS: dict[str, type[Law]] = {
    "hertz": Hertz,
    "power": Power,
    "viscous": Viscous,
    "kuwabara_kono": KuwabaraKono,
    "elastic_plastic": ElasticPlastic,
}

ChosenLaw = Annotated[SerializeAsAny[Law], ByName(LAWS)]
