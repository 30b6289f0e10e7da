"""Balances of conserved quantities: stored, supplied and lost amounts, and the residual of the numerical scheme."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from .support.float_arrays import FloatArray
from .variables import Variable

# A number or a vector, e.g. momentum in the plane with two components.
Amount = float | FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Balance:
    """The balance of a conserved quantity since the reset; each entry is an output variable of the same name.

    Attributes:
        quantity: name, such as "energy"; the variable `<quantity>_residual` is the residual.
        unit: unit of all entries.
        stored: present amounts by entry, such as {"kinetic_energy": 2.0}.
        supplied: amounts from inputs and boundaries since the reset.
        lost: amounts dissipated or irreversibly stored since the reset.
        initial: amount stored at the reset.
    """

    quantity: str
    unit: str
    stored: Mapping[str, Amount]
    supplied: Mapping[str, Amount] = dataclasses.field(default_factory=dict)
    lost: Mapping[str, Amount] = dataclasses.field(default_factory=dict)
    initial: Amount = 0.0

    @property
    def residual(self) -> Amount:
        """Stored + lost - initial - supplied: the error of the numerical scheme."""
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
        """All entries by name, including the residual."""
        return {**self.stored, **self.lost, **self.supplied, f"{self.quantity}_residual": self.residual}


def balance_variables(balance: Balance) -> Iterable[Variable]:
    """Yield the declaration of an output variable for each entry of a balance."""
    kinds = (
        (balance.stored, "stored"),
        (balance.lost, "lost since the reset"),
        (balance.supplied, "supplied by inputs and boundaries since the reset"),
    )
    quantity = balance.quantity.replace("_", " ")
    for entries, what in kinds:
        for name, amount in entries.items():
            words = name.replace("_", " ")
            # The name of a stored amount is description enough if it contains the quantity: kinetic energy, momentum.
            text = words if what == "stored" and quantity in words else f"{words}: {quantity} {what}"
            yield Variable(name, "output", balance.unit, np.shape(amount), text)
    added, given = (" + ".join(names) for names in ([*balance.stored, *balance.lost], balance.supplied))
    text = f"error of the numerical scheme: {added} - {quantity} at the reset{f' - ({given})' if given else ''}"
    yield Variable(f"{balance.quantity}_residual", "output", balance.unit, np.shape(balance.residual), text)
