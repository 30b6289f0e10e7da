"""The fate of a conserved quantity: what is stored, what came in, what was lost, and what the numerics left over."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from .support.float_arrays import FloatArray

# A number, or a vector: momentum in the plane has two components.
Amount = float | FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Balance:
    """The fate of a conserved quantity since the reset; each entry is an output variable of its name.

    Attributes:
        quantity: such as "energy"; `<quantity>_residual` is a variable too.
        unit: of all entries.
        stored: what there is now, by entry, such as {"kinetic_energy": 2.0}.
        supplied: what inputs and boundaries have given since the reset.
        lost: what has gone into forms that do not come back, since the reset.
        initial: what was stored at the reset.
    """

    quantity: str
    unit: str
    stored: Mapping[str, Amount]
    supplied: Mapping[str, Amount] = dataclasses.field(default_factory=dict)
    lost: Mapping[str, Amount] = dataclasses.field(default_factory=dict)
    initial: Amount = 0.0

    @property
    def residual(self) -> Amount:
        """Stored + lost - initial - supplied: the error of the numerics."""
        first, *others = [*self.stored.values(), *self.lost.values()]
        left: Any = first
        for amount in others:
            left = left + amount
        left = left - self.initial
        for amount in self.supplied.values():
            left = left - amount
        return left

    @property
    def entries(self) -> dict[str, Amount]:
        """All entries by name, the residual among them."""
        return {**self.stored, **self.lost, **self.supplied, f"{self.quantity}_residual": self.residual}
