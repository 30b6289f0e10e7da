"""The gas: perfect, with one adiabatic exponent, and with a heat of reaction.

p = (gamma - 1) rho e, where e is the thermal part of the internal energy, and T = p / (rho R). A mixture of a real fuel has one
gamma and one heat release for each initial pressure, fitted so that the detonation speed and the Chapman-Jouguet pressure are
those of chemical equilibrium.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import AfterValidator

from ..errors import ParameterError
from ..support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from ..support.validation import Parameters, positive_number

# Bounds of gamma, within which every real gas lies.
SMALLEST_GAMMA, LARGEST_GAMMA = 1.01, 3.0


class Gas(Parameters):
    """A perfect gas with one adiabatic exponent, which may release heat."""

    gamma: float = field(1.4, "adiabatic exponent", "1", gt=SMALLEST_GAMMA, le=LARGEST_GAMMA)
    gas_constant: Magnitude = field(287.05, "specific gas constant, p / (rho T)", "J/(kg K)")
    heat_release: NotNegativeMagnitude = field(0.0, "heat released by the complete reaction; 0 for an inert gas", "J/kg")


class Mixture(NamedTuple):
    """A fuel and its oxidiser at one initial temperature.

    Attributes:
        gas_constant: specific gas constant of the unburnt mixture [J/(kg K)].
        temperature: initial temperature [K].
        rows: table of initial pressure [Pa], gamma [1] and heat release [J/kg], in order of increasing pressure.
    """

    gas_constant: float
    temperature: float
    rows: tuple[tuple[float, float, float], ...]


# Chemical equilibrium of the Chapman-Jouguet state by Cantera 3.2 with the mechanism GRI-Mech 3.0 (gri30.yaml): the smallest
# detonation speed D over all densities of the products, then `fit_gas` with D and the pressure. D is 2363, 2374, 2383, 2390,
# 2397, 2402 m/s, the pressure 2.680, 3.378, 4.082, 4.789, 5.500, 6.215 MPa.
MIXTURES = {
    "ethylene_oxygen": Mixture(  # C2H4 + 3 O2
        268.1047,
        295.0,
        (
            (80e3, 1.13736, 9.20758e6),
            (100e3, 1.13872, 9.19669e6),
            (120e3, 1.13983, 9.18851e6),
            (140e3, 1.14076, 9.18214e6),
            (160e3, 1.14157, 9.17702e6),
            (180e3, 1.14227, 9.17294e6),
        ),
    ),
}
INERT_GASES = {"air": Gas()}
_OWN_GAS = "or give gamma, gas_constant and heat_release"
# Largest difference of the initial temperature from the temperature of a mixture's table [K].
_TEMPERATURE_RANGE = 15.0


def _validate_name(name: str) -> str:
    known = [*MIXTURES, *INERT_GASES]
    if name not in known:
        raise ValueError(f"{name!r} is not a gas; known: {', '.join(known)}; {_OWN_GAS}")
    return name


GasName = Annotated[str, AfterValidator(_validate_name)]
"""Parameter type: the name of a gas or a mixture."""


def gas_from_name(value: str | Gas, pressure: float, temperature: float) -> Gas:
    """Return the gas with a given name at an initial state; table rows are interpolated linearly in pressure.

    Args:
        value: a name, or the gas itself.
        pressure: initial pressure [Pa].
        temperature: initial temperature [K].

    Raises:
        ValueError: the table of the mixture does not cover this state.
    """
    if isinstance(value, Gas):
        return value
    if value in INERT_GASES:
        return INERT_GASES[value]
    mixture = MIXTURES[value]
    low, high = mixture.rows[0][0], mixture.rows[-1][0]
    if not low <= pressure <= high:
        raise ValueError(
            f"initial_pressure: got {pressure:g} Pa, expected {low:g} to {high:g} Pa for the mixture {value!r}; {_OWN_GAS}"
        )
    if abs(temperature - mixture.temperature) > _TEMPERATURE_RANGE:
        coldest, warmest = mixture.temperature - _TEMPERATURE_RANGE, mixture.temperature + _TEMPERATURE_RANGE
        raise ValueError(
            f"initial_temperature: got {temperature:g} K, expected {coldest:g} to {warmest:g} K for the mixture "
            f"{value!r}; {_OWN_GAS}"
        )
    place = max(1, next(place for place, row in enumerate(mixture.rows) if pressure <= row[0]))
    below, above = mixture.rows[place - 1], mixture.rows[place]
    part = (pressure - below[0]) / (above[0] - below[0])
    gamma, heat = (low + part * (high - low) for low, high in zip(below[1:], above[1:], strict=True))
    return Gas(gamma=gamma, gas_constant=mixture.gas_constant, heat_release=heat)


def fit_gas(speed: float, cj_pressure: float, pressure: float, density: float, temperature: float) -> Gas:
    """Return the gas with this detonation speed and Chapman-Jouguet pressure.

    gamma = (p0 + rho0 D^2) / P_CJ - 1, and q from M = D / c0: H = ((M^2 - 1) / 2 M)^2 = (gamma^2 - 1) q / (2 c0^2).

    Args:
        speed: detonation speed, computed for chemical equilibrium or measured [m/s].
        cj_pressure: pressure at the end of the reaction [Pa].
        pressure: initial pressure [Pa].
        density: initial density [kg/m^3].
        temperature: initial temperature [K].

    Raises:
        ParameterError: a number is not positive, or no gas has these properties.
    """
    given = {"speed": speed, "cj_pressure": cj_pressure, "pressure": pressure, "density": density, "temperature": temperature}
    for name, value in given.items():
        positive_number(name, value)
    gamma = (pressure + density * speed * speed) / cj_pressure - 1.0
    mach_squared = density * speed * speed / (gamma * pressure)
    if not (SMALLEST_GAMMA < gamma <= LARGEST_GAMMA and mach_squared > 1.0):
        raise ParameterError(
            f"got {cj_pressure:g} Pa: gamma would be {gamma:.4g}, and the squared Mach number of the front {mach_squared:.4g}",
            expected=f"a gamma of {SMALLEST_GAMMA:g} to {LARGEST_GAMMA:g}, and a front faster than sound",
            at="cj_pressure",
        )
    heat = 0.5 * (mach_squared - 1.0) ** 2 / mach_squared * (gamma * pressure / density) / (gamma * gamma - 1.0)
    return Gas(gamma=gamma, gas_constant=pressure / (density * temperature), heat_release=heat)
