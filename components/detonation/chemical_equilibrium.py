"""New mixtures from chemical equilibrium, by Cantera, which is optional: the Chapman-Jouguet state is that of the least speed.

Of all densities of products in equilibrium that satisfy the conservation of mass, momentum and energy, that of the slowest
detonation is the Chapman-Jouguet state.
Source: W. Fickett, W. C. Davis, Detonation (1979), section 2A.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ..errors import MissingExtraError, ParameterError
from .gases import Gas, fit_gas

# Compression of the products, and how closely the least speed is sought in it.
_LEAST_COMPRESSION, _MOST_COMPRESSION, _SECTIONS = 1.5, 2.2, 22
_COLDEST, _HOTTEST, _BISECTIONS = 2000.0, 5500.0, 36


def equilibrium_gas(composition: str, pressure: float, temperature: float, mechanism: str = "gri30.yaml") -> Gas:
    """Return the gas whose detonation has the speed and the pressure of chemical equilibrium.

    Args:
        composition: moles, such as "C2H4:1, O2:3".
        pressure: initial [Pa].
        temperature: initial [K].
        mechanism: a file of Cantera with the species and their thermodynamic data.

    Raises:
        MissingExtraError: Cantera is not installed.
        ParameterError: Cantera knows no such mixture or mechanism, or the mixture does not detonate.
    """
    for name, value in (("pressure", pressure), ("temperature", temperature)):
        if not 0.0 < value < math.inf:
            raise ParameterError(f"got {value:g}", expected="greater than 0, and finite", at=name)
    try:
        import cantera  # type: ignore[import-not-found]
    except ImportError as error:
        raise MissingExtraError(
            "equilibrium_gas needs the package cantera", hint="pip install 'granular-env[mixtures]'"
        ) from error
    gas = _mixture(cantera, mechanism, composition, pressure, temperature)
    density, enthalpy = float(gas.density), float(gas.enthalpy_mass)

    def products(compression: float) -> tuple[float, float, float]:
        """Return speed [m/s], pressure [Pa] and temperature [K] of the detonation to products so dense."""

        def state(hot: float) -> tuple[float, float, float]:
            """Return what energy is left over [J/kg], speed and pressure of products of this temperature [K]."""
            gas.TDX = hot, compression * density, composition
            gas.equilibrate("TV", rtol=1e-10)
            square = (float(gas.P) - pressure) / (density * (1.0 - 1.0 / compression))
            excess = float(gas.enthalpy_mass) - enthalpy - 0.5 * square * (1.0 - 1.0 / compression**2)
            return excess, math.sqrt(square), float(gas.P)

        low, high = _COLDEST, _HOTTEST
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if state(middle)[0] > 0.0 else (middle, high)
        return *state(high)[1:], high

    compression = _argument_of_least(lambda value: products(value)[0], _LEAST_COMPRESSION, _MOST_COMPRESSION)
    speed, cj_pressure, hot = products(compression)
    if hot < _COLDEST + 1.0:
        came = f"got {composition!r}, which would stay colder than {_COLDEST:g} K"
        raise ParameterError(came, expected="a mixture that detonates: a fuel with its oxidiser", at="composition")
    return fit_gas(speed, cj_pressure, pressure, density, temperature)


def _mixture(cantera: Any, mechanism: str, composition: str, pressure: float, temperature: float) -> Any:
    """Return Cantera's gas in that state; what Cantera refuses is told as of the argument."""
    try:
        gas: Any = cantera.Solution(mechanism)
    except cantera.CanteraError as error:
        raise ParameterError(
            f"got {mechanism!r}: {_words(error)}", hint="gri30.yaml comes with Cantera", at="mechanism"
        ) from error
    try:
        gas.TPX = temperature, pressure, composition
    except cantera.CanteraError as error:
        hint = f"give moles of species of {mechanism}, such as 'C2H4:1, O2:3'"
        raise ParameterError(f"got {composition!r}: {_words(error)}", hint=hint, at="composition") from error
    return gas


def _words(error: Exception) -> str:
    """Return what an error of Cantera says, without its frame of stars and the name of its function."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and not line.startswith("*")]
    return " ".join(lines[1:] if len(lines) > 1 else lines).rstrip(".")


def _argument_of_least(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function with one minimum is least, by golden sections."""
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    for _ in range(_SECTIONS):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, right) if function(left) < function(right) else (left, high)
    return 0.5 * (low + high)
