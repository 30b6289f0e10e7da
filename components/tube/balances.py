"""Balances of the tube, composed from those of the gas and the shell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..balances import Amount, Balance
from ..support.float_arrays import FloatArray

# Entry of the shell's balance that the tube leaves out: a shell in a tube has no rigid wall.
_ABSENT = ("wall_energy",)


def join_energy(gas: Balance, shell: Balance, leaked_amount: float) -> Balance:
    """Return the energy balance of both parts; leakage counts as a loss."""
    stored = {name: amount for name, amount in _summed_entries((gas.stored, shell.stored)).items() if name not in _ABSENT}
    supplied, lost = _summed_entries((gas.supplied, shell.supplied)), {**shell.lost, "leaked_energy": leaked_amount}
    return Balance("energy", "J", stored, supplied, lost, gas.initial + shell.initial)


def join_mass(gas: Balance, shell: Balance, leaked_amount: float) -> Balance:
    """Return the mass balance of both parts; leakage counts as a loss."""
    stored = {"gas_mass": gas.stored["mass"], "shell_mass": shell.stored["mass"]}
    return Balance("mass", "kg", stored, gas.supplied, {"leaked_mass": leaked_amount}, gas.initial + shell.initial)


def join_momentum(gas: Balance, shell: Balance, leaked_amount: float) -> Balance:
    """Return the momentum balance of both parts; gas momentum is along x, and `wall_impulse` acts from walls on the gas."""
    ours = {name: vector_along_x(amount) for name, amount in gas.supplied.items()}
    theirs = {name: amount for name, amount in shell.supplied.items() if name != "wall_impulse"}
    stored = {"momentum": vector_along_x(gas.stored["momentum"]) + shell.stored["momentum"]}
    lost = {"leaked_momentum": vector_along_x(leaked_amount)}
    return Balance("momentum", "kg m/s", stored, {**ours, **theirs}, lost, vector_along_x(gas.initial) + shell.initial)


def vector_along_x(amount: Amount) -> FloatArray:
    """Return the vector along x whose x component is `amount`."""
    return np.array([float(amount), 0.0, 0.0])


def _summed_entries(parts: Sequence[Mapping[str, Amount]]) -> dict[str, Any]:
    """Return the balance entries of all parts in one mapping; entries of the same name are added."""
    found: dict[str, Any] = {}
    for part in parts:
        for name, amount in part.items():
            found[name] = found[name] + amount if name in found else amount
    return found
