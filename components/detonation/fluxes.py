"""Fluxes through faces: HLLC between cells, and what the ends of the tube let through.

A flux is that of mass, momentum, energy and fuel per area. Energy is thermal, kinetic and chemical.
Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 10.4.
"""

from __future__ import annotations

from math import sqrt

from ..support.jit import internal_inlined
from ..support.powers import power
from .boundaries import ABSORBING

# A room at less than this part of the pressure inside is a vacuum: the flow is choked long before.
_VACUUM = 1e-6


@internal_inlined
def flux_of(medium, density, velocity, pressure, fraction):
    """Return the flux of a state: density [kg/m^3], velocity [m/s], pressure [Pa], and the part that has not reacted."""
    mass = density * velocity
    heat = pressure * medium.gamma / (medium.gamma - 1.0)
    kinetic = 0.5 * velocity * velocity
    return mass, mass * velocity + pressure, velocity * heat + mass * (kinetic + fraction * medium.heat), mass * fraction


@internal_inlined
def hllc_flux(medium, left, right):
    """Return the flux between two states, each density, velocity, pressure and the part that has not reacted."""
    gamma = medium.gamma
    rl, ul, pl, yl = left
    rr, ur, pr, yr = right
    cl, cr = sqrt(gamma * pl / rl), sqrt(gamma * pr / rr)
    one, two = ul - cl, ur - cr
    sl = one if one < two else two
    one, two = ul + cl, ur + cr
    sr = one if one > two else two
    ml, mr = rl * (sl - ul), rr * (sr - ur)
    contact = (pr - pl + ul * ml - ur * mr) / (ml - mr)
    leftward = contact < 0.0
    r, u = (rr if leftward else rl), (ur if leftward else ul)
    p, y = (pr if leftward else pl), (yr if leftward else yl)
    s, m = (sr if leftward else sl), (mr if leftward else ml)
    # All waves go one way: the flux is that of the state they come from.
    outside = s < 0.0 if leftward else s > 0.0
    density = r if outside else m / (s - contact)
    velocity = u if outside else contact
    pressure = p if outside else p + m * (contact - u)
    inner = p / ((gamma - 1.0) * r) + 0.5 * u * u + y * medium.heat
    energy = inner if outside else inner + (contact - u) * (contact + p / m)
    mass = density * velocity
    return mass, mass * velocity + pressure, velocity * (density * energy + pressure), mass * y


@internal_inlined
def wall_flux(medium, state, side):
    """Return the flux at a rigid wall: its pressure alone, that between the state and its mirror image.

    Args:
        medium: the gas.
        state: density, velocity, pressure and the part that has not reacted, at the wall.
        side: -1.0 at the left end, 1.0 at the right one.
    """
    r, u, p, _ = state
    out = side * u
    c = sqrt(medium.gamma * p / r)
    speed = out + c if out > 0.0 else c - out
    # The wave goes back at `speed`, relative to gas that comes at `out`.
    return 0.0, p + r * (speed + out) * out, 0.0, 0.0


@internal_inlined
def opening_flux(medium, state, side, outside):
    """Return the flux through an opening into a room at rest.

    The gas expands, or is compressed, without a change of entropy to the pressure outside; sonic flow is the most that leaves.
    What enters has the temperature of the room and no fuel.

    Args:
        medium: the gas.
        state: as of `wall_flux`.
        side: -1.0 at the left end, 1.0 at the right one.
        outside: pressure of the room [Pa].
    """
    gamma = medium.gamma
    r, u, p, y = state
    out = side * u
    c = sqrt(gamma * p / r)
    room = outside if outside > _VACUUM * p else _VACUUM * p
    ratio = room / p
    # power() takes exponents that are not negative.
    scale = power(ratio, 0.5 * (gamma - 1.0) / gamma)
    sound = c * scale
    speed = out + 2.0 / (gamma - 1.0) * (c - sound)
    choked = (2.0 * c + (gamma - 1.0) * out) / (gamma + 1.0)
    if out >= c:
        return flux_of(medium, r, u, p, y)
    if speed > sound:
        density = r * power(choked / c, 2.0 / (gamma - 1.0))
        return flux_of(medium, density, side * choked, density * choked * choked / gamma, y)
    if speed >= 0.0:
        return flux_of(medium, gamma * room / (sound * sound), side * speed, room, y)
    return flux_of(medium, room / (medium.gas_constant * medium.outside_temperature), side * speed, room, 0.0)


@internal_inlined
def end_flux(medium, state, side, code, is_open, outside):
    """Return the flux at an end; `code` is that of `boundaries`, a diaphragm is a wall until `is_open`."""
    if code == ABSORBING:
        return flux_of(medium, state[0], state[1], state[2], state[3])
    if is_open:
        return opening_flux(medium, state, side, outside)
    return wall_flux(medium, state, side)
