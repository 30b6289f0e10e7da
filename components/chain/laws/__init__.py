"""Contact laws, one a file: what they declare, and their formulas.

A law is conservative, velocity-dependent or has a history, and says so. Elastic forces and dissipation are given to the kernels
as kinds (`table`), `dispatch` finds the functions.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Tag

from ...errors import nearest, shortened
from .elastic_plastic import ElasticPlastic
from .hertz import Hertz
from .kuwabara_kono import KuwabaraKono
from .law import Dissipative, Law
from .power import Power
from .viscous import Viscous

__all__ = ["LAWS", "AnyLaw", "Dissipative", "ElasticPlastic", "Hertz", "KuwabaraKono", "Law", "Power", "Viscous"]

LAWS: dict[str, type[Law]] = {
    "hertz": Hertz,
    "power": Power,
    "viscous": Viscous,
    "kuwabara_kono": KuwabaraKono,
    "elastic_plastic": ElasticPlastic,
}


def _by_name(given: Any) -> Any:
    """A bare name stands for the law with its defaults."""
    given = {"name": given} if isinstance(given, str) else given
    if isinstance(given, dict):
        name = given.get("name")
        if not isinstance(name, str) or name not in LAWS:
            raise ValueError(f"name: got {name!r}; {nearest(str(name), LAWS)}")
    elif not isinstance(given, Law):
        raise ValueError(f"got {shortened(given)}, expected the name of a law ({', '.join(LAWS)}) or a table with its name")
    return given


def _tag(given: Any) -> str:
    return str(given.get("name")) if isinstance(given, dict) else str(getattr(given, "name", ""))


AnyLaw = Annotated[
    Annotated[Hertz, Tag("hertz")]
    | Annotated[Power, Tag("power")]
    | Annotated[Viscous, Tag("viscous")]
    | Annotated[KuwabaraKono, Tag("kuwabara_kono")]
    | Annotated[ElasticPlastic, Tag("elastic_plastic")],
    Discriminator(_tag),
    BeforeValidator(_by_name),
]
