"""Contact laws, one module each: parameters, formulas, derivatives, sources. `functions.py` lists the functions of a law.

A law is conservative, dissipative, or has a history. A new law needs a module and an entry in `LAWS`; a law of another package
is an entry point of the group ``granular_env.chain_laws``, with the name of the law and its class as the object.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Annotated

from pydantic import SerializeAsAny

from ...errors import ParameterError, one_line
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

ENTRY_POINT_GROUP = "granular_env.chain_laws"

LAWS: dict[str, type[Law]] = {
    "hertz": Hertz,
    "power": Power,
    "viscous": Viscous,
    "kuwabara_kono": KuwabaraKono,
    "elastic_plastic": ElasticPlastic,
    "linear": Linear,
    "walton_braun": WaltonBraun,
}


class _KnownLaws(Mapping[str, type[Law]]):
    """`LAWS` and the laws of other packages, which are imported when chosen."""

    @cached_property
    def _plugin_laws(self) -> dict[str, EntryPoint]:
        return {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}

    def __getitem__(self, name: str) -> type[Law]:
        if name in LAWS:
            return LAWS[name]
        point = self._plugin_laws[name]
        try:
            law = point.load()
        except Exception as error:  # from a third-party package
            raise ParameterError(f"law {name!r} of {point.value} cannot be loaded: {one_line(error)}", at="law") from error
        if not (isinstance(law, type) and issubclass(law, Law)):
            raise ParameterError(f"law {name!r}: {point.value} is {one_line(law)}", expected="a subclass of Law", at="law")
        return law

    def __iter__(self) -> Iterator[str]:
        yield from LAWS
        yield from (name for name in self._plugin_laws if name not in LAWS)

    def __len__(self) -> int:
        return len(list(iter(self)))


CHOSEN_LAWS = _KnownLaws()
ChosenLaw = Annotated[SerializeAsAny[Law], ByName(CHOSEN_LAWS)]
