"""Fluxes through faces: HLLC between cells, and the fluxes at the ends of the tube.

A flux contains mass, momentum, energy and fuel per area. Energy is thermal, kinetic and chemical.
Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics (2009), section 10.4.
"""

from __future__ import annotations

from math import nan, sqrt

from ..support.jit import inlined, internal, internal_inlined
from ..support.powers import power
from .boundaries import ABSORBING, CLOSED, DIAPHRAGM, PISTON

# Lower limit of the room pressure, as a fraction of the pressure inside; the flow is choked already at higher pressures.
_VACUUM = 1e-6
# Newton steps converge quadratically once they are small: after a step of this fraction of the sonic speed the error is below
# rounding. There are 2 to 6 steps, and up to 12 if the gas inside is lighter than the room's by orders of magnitude.
_NEWTON_TOLERANCE, _NEWTON_STEPS = 1e-9, 40


@internal_inlined
def state_flux(medium, density, velocity, pressure, fraction):
    """Return the flux of a state: density [kg/m^3], velocity [m/s], pressure [Pa] and unreacted fraction."""
    mass = density * velocity
    heat = pressure * medium.gamma / (medium.gamma - 1.0)
    kinetic = 0.5 * velocity * velocity
    return mass, mass * velocity + pressure, velocity * heat + mass * (kinetic + fraction * medium.heat), mass * fraction


@internal_inlined
def hllc_flux(medium, left, right):
    """Return the flux between two states; each is density, velocity, pressure and unreacted fraction."""
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
    # If all waves run in the same direction, the flux is that of the upstream state.
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
    """Return the flux at a rigid wall: the pressure alone, from the Riemann problem of the state and its mirror image.

    Args:
        medium: the gas.
        state: density, velocity, pressure and unreacted fraction at the wall.
        side: -1.0 at the left end, 1.0 at the right one.
    """
    r, u, p, _ = state
    out = side * u
    c = sqrt(medium.gamma * p / r)
    speed = out + c if out > 0.0 else c - out
    # The reflected wave runs at `speed` relative to gas that approaches at `out`.
    return 0.0, p + r * (speed + out) * out, 0.0, 0.0


@internal_inlined
def piston_pressure(gamma, density, speed, pressure):
    """Return the pressure on a wall that gas approaches (`speed` > 0) or leaves (`speed` < 0) [Pa]."""
    sound = sqrt(gamma * pressure / density)
    if speed > 0.0:
        half = 0.25 * (gamma + 1.0) * speed
        return pressure + density * speed * (half + sqrt(half * half + sound * sound))
    left = 1.0 + 0.5 * (gamma - 1.0) * speed / sound
    return pressure * power(left, 2.0 * gamma / (gamma - 1.0)) if left > 0.0 else 0.0


@internal_inlined
def piston_impedance(gamma, density, speed, pressure):
    """Return the derivative of `piston_pressure` with respect to the speed [Pa s/m]."""
    sound = sqrt(gamma * pressure / density)
    if speed > 0.0:
        half = 0.25 * (gamma + 1.0) * speed
        root = sqrt(half * half + sound * sound)
        return density * (half + root) * (half + root) / root
    left = 1.0 + 0.5 * (gamma - 1.0) * speed / sound
    return density * sound * power(left, (gamma + 1.0) / (gamma - 1.0)) if left > 0.0 else 0.0


@inlined
def opening_flux(medium, state, side, room_pressure):
    """Return the flux through an opening into a room at rest.

    Outflowing gas expands or is compressed isentropically to the pressure outside; the outflow is at most sonic. Inflowing gas
    is that of the room, without fuel, see `inflow_flux`. At zero velocity both give the pressure outside.

    Args:
        medium: the gas.
        state: as in `wall_flux`.
        side: -1.0 at the left end, 1.0 at the right one.
        room_pressure: pressure of the room [Pa].
    """
    gamma = medium.gamma
    r, u, p, y = state
    out = side * u
    c = sqrt(gamma * p / r)
    room = room_pressure if room_pressure > _VACUUM * p else _VACUUM * p
    ratio = room / p
    # power() accepts only non-negative exponents.
    scale = power(ratio, 0.5 * (gamma - 1.0) / gamma)
    sound = c * scale
    speed = out + 2.0 / (gamma - 1.0) * (c - sound)
    choked = (2.0 * c + (gamma - 1.0) * out) / (gamma + 1.0)
    if out >= c:
        return state_flux(medium, r, u, p, y)
    if speed > sound:
        density = r * power(choked / c, 2.0 / (gamma - 1.0))
        return state_flux(medium, density, side * choked, density * choked * choked / gamma, y)
    if speed >= 0.0:
        return state_flux(medium, gamma * room / (sound * sound), side * speed, room, y)
    return inflow_flux(medium, r, out, p, side, room_pressure)


@internal
def inflow_flux(medium, density, outward_velocity, pressure, side, room_pressure):
    """Return the flux of gas that flows through an opening from a room at rest into the tube.

    Inflowing gas keeps the entropy and total enthalpy of the room. With c0 the speed of sound there and w the inflow velocity:

        T = T0 (1 - (gamma - 1) w^2 / (2 c0^2)),    p = p0 (T / T0)^(gamma / (gamma - 1)).

    The gas inside has the same pressure and velocity behind the shock or rarefaction that runs into it; this is exact. If the
    gas inside moves outwards, it is first brought to rest isentropically, as at an outflow, so that the flux is continuous
    between the two cases; up to the speed of sound this pressure is right within 4 %. If the pressures allow more than sonic
    inflow, w is sonic, and the gas expands further inside.
    Source: A. H. Shapiro, The Dynamics and Thermodynamics of Compressible Fluid Flow (1953), 4; Toro, section 4.2.

    Args:
        medium: the gas.
        density: density inside [kg/m^3].
        outward_velocity: velocity inside, towards the opening [m/s].
        pressure: pressure inside [Pa].
        side: -1.0 at the left end, 1.0 at the right one.
        room_pressure: pressure of the room [Pa].
    """
    gamma = medium.gamma
    if outward_velocity > 0.0:
        stopped = 1.0 + 0.5 * (gamma - 1.0) * outward_velocity / sqrt(gamma * pressure / density)
        density *= power(stopped, 2.0 / (gamma - 1.0))
        pressure *= power(stopped, 2.0 * gamma / (gamma - 1.0))
        outward_velocity = 0.0
    w = inflow_velocity(medium, density, outward_velocity, pressure, room_pressure)
    room_temperature = medium.outside_temperature
    cooling = 1.0 - 0.5 * (gamma - 1.0) * w * w / (gamma * medium.gas_constant * room_temperature)
    pressure = room_pressure * power(cooling, gamma / (gamma - 1.0))
    density = pressure / (medium.gas_constant * room_temperature * cooling)
    return state_flux(medium, density, -side * w, pressure, 0.0)


@internal
def inflow_velocity(medium, density, outward_velocity, pressure, room_pressure):
    """Return the inflow velocity, at most sonic, at which entering gas has the pressure behind the wave inside [m/s].

    The pressure of the entering gas minus that behind the wave falls with w, ever more steeply (for subsonic w). Newton's
    method from w = 0 therefore overshoots once and then converges to the solution from above.

    Args:
        medium: the gas.
        density: density inside [kg/m^3].
        outward_velocity: velocity inside, towards the opening, not positive [m/s].
        pressure: pressure inside [Pa].
        room_pressure: pressure of the room [Pa].
    """
    gamma, square = medium.gamma, medium.gamma * medium.gas_constant * medium.outside_temperature
    sonic, w = sqrt(2.0 / (gamma + 1.0) * square), 0.0
    for step in range(_NEWTON_STEPS):
        cooling = 1.0 - 0.5 * (gamma - 1.0) * w * w / square
        entering = room_pressure * power(cooling, gamma / (gamma - 1.0))
        excess = entering - piston_pressure(gamma, density, outward_velocity + w, pressure)
        fall = gamma * entering * w / (square * cooling) + piston_impedance(gamma, density, outward_velocity + w, pressure)
        if (excess >= 0.0 and w == sonic) or (excess <= 0.0 and w == 0.0):
            return w
        # Gas that leaves a vacuum behind has no impedance.
        change = sonic if excess >= sonic * fall else excess / fall
        w += change
        w = 0.0 if w < 0.0 else (sonic if w > sonic else w)
        if step > 0 and abs(change) <= _NEWTON_TOLERANCE * sonic:
            return w
    return w


@internal_inlined
def end_flux(medium, state, side, end_code, is_open, room_pressure):
    """Return the flux at an end; `end_code` is defined in `boundaries`. A diaphragm is a wall until `is_open`."""
    if end_code == ABSORBING:
        return state_flux(medium, state[0], state[1], state[2], state[3])
    if is_open:
        return opening_flux(medium, state, side, room_pressure)
    if end_code == CLOSED or end_code == DIAPHRAGM or end_code == PISTON:
        return wall_flux(medium, state, side)
    return nan, nan, nan, nan  # an unknown code ends the run
