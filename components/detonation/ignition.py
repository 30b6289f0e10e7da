"""Ignition: whether the gas burns, and the heat that raises the ignition zone to the pressure that a reaction needs.

Heat that is added before sound has crossed the zone acts at constant volume, E = V (p - p0) / (gamma - 1). Heat that is added
slowly expands the gas. At the pressure p hot gas leaves the zone with the velocity u behind a shock of that pressure, and
carries away the power P through each open cross-section A,

    P = gamma / (gamma - 1) p u A,    u = (p - p0) sqrt(2 / (rho0 ((gamma + 1) p + (gamma - 1) p0))).

Measured, for a zone at a closed end and pressures p of 0.1 to 0.4 P_CJ: E is right within 1 % for heat added within 0.3 of the
time in which sound crosses the zone; 0.7 to 0.8 of P suffice for ignition.
Source of u: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 3.1.3.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..support.float_arrays import ordered_sum
from . import kernel_arrays
from .boundaries import ABSORBING, OPEN
from .chapman_jouguet import Flow
from .gases import Gas
from .reactions.inert import Inert

if TYPE_CHECKING:
    from .component import DetonationTube

# Heat acts at constant volume within this fraction of the time in which sound crosses the zone (half the zone with two exits).
_AT_ONCE = 0.3
# Below this unburnt fraction the tube counts as burnt. A front below this fraction of D is not a detonation. Combustion has
# ended if no gas has burnt for the time in which a detonation crosses this number of cells.
_UNBURNT, _SLOW, _IDLE_CELLS = 0.01, 0.5, 10.0


def constant_volume_heat(gas: Gas, ahead: Flow, pressure: float, volume: float) -> float:
    """Return the heat that brings gas to a pressure [Pa] in a constant volume [m^3], in J."""
    return volume * (pressure - ahead.pressure) / (gas.gamma - 1.0)


def steady_ignition_power(gas: Gas, ahead: Flow, pressure: float, area: float) -> float:
    """Return the power that keeps a zone at a pressure [Pa] while gas leaves it through an area [m^2], in W."""
    gamma, excess = gas.gamma, pressure - ahead.pressure
    speed = excess * math.sqrt(2.0 / (ahead.density * ((gamma + 1.0) * pressure + (gamma - 1.0) * ahead.pressure)))
    return gamma / (gamma - 1.0) * pressure * speed * area


def ignition_pressure(gas: DetonationTube) -> float:
    """Return the pressure [Pa] to which gas must be heated at constant volume to ignite; NaN if the law has none."""
    return gas.parameters.chosen_reaction.ignition_pressure(gas.front, (gas.ahead.pressure, gas.ahead.density))


def missing_detonation_text(gas: DetonationTube) -> str:
    """Return a description of gas that could detonate but does not; "" for other gas."""
    _, _, state, _, tally = gas.tables()
    if isinstance(gas.parameters.chosen_reaction, Inert) or gas.unburnt_fraction <= _UNBURNT:
        return ""
    if tally[kernel_arrays.IDLE] * gas.step_size > _IDLE_CELLS * gas.cell_size / gas.front.speed:
        return "the gas has stopped burning" if state.flags[kernel_arrays.IGNITED] else "the gas has not ignited"
    return "the gas burns without a detonation" if 0.0 < gas.get("cj_ratio") < _SLOW else ""


def ignition_conclusion(gas: DetonationTube) -> str:
    """Return a sentence that states whether, where and when the gas ignited, and the unburnt fraction."""
    _, _, state, _, tally = gas.tables()
    if isinstance(gas.parameters.chosen_reaction, Inert):
        least, largest = (1e-3 * float(one) for one in (state.pressure.min(), state.pressure.max()))
        return f"the gas does not react; its pressure is {least:.4g} to {largest:.4g} kPa"
    if not state.flags[kernel_arrays.IGNITED]:
        peak, needed = max(float(tally[kernel_arrays.PEAK]), float(state.pressure.max())), ignition_pressure(gas)
        compared = (
            f"{1e-3 * peak:.4g} kPa" if math.isnan(needed) else f"{peak / needed:.2f} of the {1e-3 * needed:.4g} kPa required"
        )
        return f"the gas has not ignited: its largest pressure was {compared}"
    begin, end = gas.fronts()
    first, ratio = gas.events("ignited"), gas.get("cj_ratio")
    time = f"{1e6 * first[0].tick * gas.step_size:.4g} us after the start" if first else "before the start"
    runs = f"; the front ran at {ratio:.3f} of the Chapman-Jouguet speed" if ratio else ""
    outcome = missing_detonation_text(gas) or f"the gas ignited {time}"
    return f"{outcome}: {gas.unburnt_fraction:.0%} of it is unburnt; burnt gas lies from {begin:.4g} to {end:.4g} m{runs}"


def ignition_cautions(gas: DetonationTube) -> list[str]:
    """Return a caution with the missing heat or power of the ignition zone if the gas does not detonate."""
    text = missing_detonation_text(gas)
    if not text:
        return []
    said = f"{text}, and its pressure is not that of a detonation"
    p, ahead, (_, tube, state, _, tally) = gas.parameters, gas.ahead, gas.tables()
    needed = ignition_pressure(gas)
    if state.flags[kernel_arrays.IGNITED] or math.isnan(needed):
        return [f"{said}; give more ignition_power, or a longer ignition_zone"]
    first, last = (int(cell) for cell in tube.heated)
    sides = ((first > 0, p.left, state.area[first]), (last < p.cells, p.right, state.area[last - 1]))
    # Areas through which gas leaves the zone; none at a wall.
    exits = [float(area) for inside, end, area in sides if inside or end.code in (OPEN, ABSORBING)]
    length = (last - first) * gas.cell_size / max(len(exits), 1)
    heat = constant_volume_heat(gas.gas, ahead, needed, float(state.area[first:last].sum()) * gas.cell_size)
    power = steady_ignition_power(gas.gas, ahead, needed, ordered_sum(*exits))
    sound = math.sqrt(gas.gas.gamma * ahead.pressure / ahead.density)
    given = float(tally[kernel_arrays.IGNITION])
    enough = ", which is enough but was added too slowly" if given >= heat else ""
    slowly = f" within {1e6 * _AT_ONCE * length / sound:.3g} us, or about {1e-6 * power:.3g} MW for longer" if exits else ""
    return [f"{said}: the ignition zone received {given:.3g} J{enough}; it requires {heat:.3g} J{slowly} (ignition_power)"]
