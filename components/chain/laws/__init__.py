"""Contact laws, one a file: parameters, formulas, their derivatives, sources. `placeholders.py` says what a law's file defines.

A law is conservative, velocity-dependent or has a history, and says so. A new law is a file and a line in `LAWS`.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ...support.tagged_union import ByName
from .elastic_plastic import ElasticPlastic
from .hertz import Hertz
from .kuwabara_kono import KuwabaraKono
from .law import Dissipative, Law
from .linear import Linear
from .power import Power
from .viscous import Viscous
from .walton_braun import WaltonBraun

__all__ = [
    "LAWS", "ChosenLaw", "Dissipative", "ElasticPlastic", "Hertz", "KuwabaraKono", "Law", "Linear", "Power", "Viscous",
    "WaltonBraun",
]  # fmt: skip

LAWS: dict[str, type[Law]] = {
    "hertz": Hertz,
    "power": Power,
    "viscous": Viscous,
    "kuwabara_kono": KuwabaraKono,
    "elastic_plastic": ElasticPlastic,
    "linear": Linear,
    "walton_braun": WaltonBraun,
}

ChosenLaw = Annotated[SerializeAsAny[Law], ByName(LAWS)]
