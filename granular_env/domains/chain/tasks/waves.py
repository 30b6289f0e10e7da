"""Target solitary waves: their shapes, the distance of a chain's state from them in the energy norm, and drives that make them.

A goal has rows (amplitude, place, speed): largest grain velocity [m/s], place of the crest at the deadline (a real number,
the first grain is 0), and speed [grains/s]. Before the deadline, the target crest is behind its place by speed x time left,
so an exact wave matches the target at all times. Rows of amplitude 0 are ignored.

A shape consists of two tables over the distance to the crest of the exact lattice wave (`theory.lattice_wave`): grain velocity
/ amplitude, and q / (sqrt(m) amplitude), where q is the square root of a contact's energy above that at rest. Cubics through
four points interpolate. Without precompression one shape serves all amplitudes; otherwise each wave has its own.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from granular_env.components.chain.differentiable_quantities import energy_root, energy_root_pullback, input_work
from granular_env.components.chain.layout import MASS, V
from granular_env.components.chain.objective import Objective
from granular_env.components.chain.state import chain_state
from granular_env.components.chain.theory.lattice_wave import LatticeWave, lattice_wave
from granular_env.components.errors import ParameterError
from granular_env.components.support.elementary_functions import exponential, logarithm, natural_spline, root
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import inlined, jit
from granular_env.envs.factory import refuse_early_deadline

from .driven_end import single_sum_value

# Indices in the array `shapes`: number of shapes, points of a table, points per grain, reach (largest distance from the crest)
# [grains], mass of a grain [kg], first entry of the tables.
SHAPES, POINTS, DENSITY, REACH, GRAIN_MASS, TABLES = range(6)
# Columns of a goal.
AMPLITUDE, PLACE, SPEED = range(3)
COLUMNS = 3
# Largest fraction of a target wave's energy that may be in the chain at the start of the episode, or, at the deadline, beyond
# an end of the chain or beyond the midpoint between two waves.
_PART = 1e-3
_FINE, _FINER = 16, 32

# At its reach a wave has fallen to this fraction of its crest; farther away it is set to 0.
_NOTHING = 1e-8
_LARGEST_REACH = 60.0


@inlined
def _shape_value(shapes, table, x):
    """Return the interpolated value of a shape's table at distance x [grains] from the crest."""
    count, reach = int(shapes[POINTS]), shapes[REACH]
    if not (-reach < x < reach):
        return 0.0
    place = (x + reach) * shapes[DENSITY] + 1.0
    i = int(place)
    t, first = place - i, table + i
    before, here, after, beyond = shapes[first - 1], shapes[first], shapes[first + 1], shapes[first + 2]
    if i > count - 3:
        return 0.0
    slope, next_slope = 0.5 * (after - before), 0.5 * (beyond - here)
    rise = after - here
    return here + t * (slope + t * (3.0 * rise - 2.0 * slope - next_slope + t * (slope + next_slope - 2.0 * rise)))


@jit
def _target_value(shapes, goal, waves, time_left, place, contact):
    """Return the sum of all target waves at a grain or contact, `time_left` seconds before the deadline.

    The sum is that of the velocities [m/s] or, with `contact`, that of q / sqrt(m), see the module.
    """
    total, count = 0.0, int(shapes[POINTS])
    for w in range(waves):
        row, table = COLUMNS * w, TABLES + 2 * count * min(w, int(shapes[SHAPES]) - 1)
        table += count if contact else 0
        x = place - (goal[row + PLACE] - goal[row + SPEED] * time_left)
        total += goal[row + AMPLITUDE] * _shape_value(shapes, table, x)
    return total


@jit
def distance(chain, shapes, goal, waves, time_left):
    """Return the squared distance of the chain's state from the target waves, `time_left` seconds before the deadline [J]."""
    n, root, total = chain.settings.grains, math.sqrt(shapes[GRAIN_MASS]), 0.0
    for i in range(1, n + 1):
        off = chain.rows[V, i] - _target_value(shapes, goal, waves, time_left, i - 1.0, False)
        total += 0.5 * chain.rows[MASS, i] * (off * off)
    for j in range(1, n):
        off = energy_root(chain, j) - root * _target_value(shapes, goal, waves, time_left, j - 0.5, True)
        total += off * off
    return total


@jit
def distance_pullback(chain, adjoint, shapes, goal, waves, time_left, slope):
    """Add slope times the derivative of `distance` to the adjoint."""
    n, root = chain.settings.grains, math.sqrt(shapes[GRAIN_MASS])
    for i in range(1, n + 1):
        off = chain.rows[V, i] - _target_value(shapes, goal, waves, time_left, i - 1.0, False)
        adjoint.rows[V, i] += slope * chain.rows[MASS, i] * off
        adjoint.rows[MASS, i] += slope * 0.5 * (off * off)
    for j in range(1, n):
        off = energy_root(chain, j) - root * _target_value(shapes, goal, waves, time_left, j - 0.5, True)
        energy_root_pullback(chain, adjoint, j, 2.0 * slope * off)


@jit
def energy_outside(chain, goal, waves, time_left, window):
    """Return the chain's energy farther than `window` grains from all target crests, and its total energy [J]."""
    n, outside, whole = chain.settings.grains, 0.0, 0.0
    for i in range(1, n + 1):
        energy = 0.5 * chain.rows[MASS, i] * (chain.rows[V, i] * chain.rows[V, i])
        whole += energy
        outside += energy if _is_outside(goal, waves, time_left, i - 1.0, window) else 0.0
    for j in range(n + 1):
        q = energy_root(chain, j)
        whole += q * q
        outside += q * q if _is_outside(goal, waves, time_left, j - 0.5, window) else 0.0
    return outside, whole


@jit
def amplitude_error(chain, shapes, goal, waves, time_left, window):
    """Return the largest relative error, over the waves, of the peak grain velocity within `window` grains of the crest.

    The error is relative to the largest target velocity there at the same instant. Waves still outside are left out.
    """
    n, worst = chain.settings.grains, 0.0
    for w in range(waves):
        row = COLUMNS * w
        place = goal[row + PLACE] - goal[row + SPEED] * time_left
        fastest, wanted = 0.0, 0.0
        for i in range(max(int(np.ceil(place - window)), 0) + 1, min(int(np.floor(place + window)), n - 1) + 2):
            fastest = max(fastest, chain.rows[V, i])
            wanted = max(wanted, _target_value(shapes, goal, waves, time_left, i - 1.0, False))
        if wanted > 0.5 * goal[row + AMPLITUDE]:
            worst = max(worst, abs(fastest / wanted - 1.0))
    return worst


@jit
def _is_outside(goal, waves, time_left, place, window):
    for w in range(waves):
        row = COLUMNS * w
        if goal[row + AMPLITUDE] > 0.0 and abs(place - (goal[row + PLACE] - goal[row + SPEED] * time_left)) <= window:
            return False
    return True


@jit
def compare_with_goals(law, tables, shapes, goals, time_left, windows, energies, results):
    """Write for each chain the distance from its goal, the fraction of the energy outside the waves, and the amplitude error.

    Every argument except `law` has one row per chain.

    Args:
        law: a contact law of the class that the chains have.
        tables: tables of the chains.
        shapes: shapes of the waves.
        goals: rows (amplitude, place, speed) of all waves, flattened, shape (chains, 3 x waves).
        time_left: time until the deadline [s].
        windows: half width of a wave's window [grains].
        energies: energies of the target waves, which normalise the distance [J].
        results: shape (chains, 3), overwritten.
    """
    for k in range(len(time_left)):
        chain, goal, waves = chain_state(law, tables[k]), goals[k], len(goals[k]) // COLUMNS
        outside, whole = energy_outside(chain, goal, waves, time_left[k], windows[k])
        put_in = max(input_work(chain), whole)
        results[k, 0] = distance(chain, shapes[k], goal, waves, time_left[k]) / energies[k]
        results[k, 1] = outside / put_in if put_in > 0.0 else 0.0
        results[k, 2] = amplitude_error(chain, shapes[k], goal, waves, time_left[k], windows[k])


# -- the objective ----------------------------------------------------------------------------------------------------

# Indices of the objective's constants: energy of the target waves [J], number of waves, length of a control step [s], weight
# `way` of the mean distance over all steps; then follow the goal and the shapes.
_ENERGY, _WAVES, _DURATION, _WAY, _GOAL = range(5)


@jit
def _step_weight(step, steps, constants):
    """Return the weight of the distance after control step `step`: way / steps, plus 1 - way for the last step."""
    way = constants[_WAY]
    return way / steps + (1.0 - way if step == steps - 1 else 0.0)


@jit
def _add_to_sums(chain, step, steps, inputs, constants, sums):
    weight = _step_weight(step, steps, constants)
    if weight > 0.0:
        waves, time_left = int(constants[_WAVES]), (steps - 1 - step) * constants[_DURATION]
        shapes = constants[_GOAL + COLUMNS * waves :]
        sums[0] += weight * distance(chain, shapes, constants[_GOAL:], waves, time_left) / constants[_ENERGY]


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    weight = _step_weight(step, steps, constants)
    if weight > 0.0:
        waves, time_left = int(constants[_WAVES]), (steps - 1 - step) * constants[_DURATION]
        shapes = constants[_GOAL + COLUMNS * waves :]
        distance_pullback(chain, adjoint, shapes, constants[_GOAL:], waves, time_left, slopes[0] * weight / constants[_ENERGY])


def distance_objective(goal: FloatArray, shapes: FloatArray, energy: float, duration: float, way: float = 0.0) -> Objective:
    """Return an objective: the final squared distance from the target waves over their energy.

    Args:
        goal: rows (amplitude, place, speed), flattened.
        shapes: shapes of the waves.
        energy: energy of the waves [J].
        duration: duration of a control step [s].
        way: weight, 0 to 1, of the mean distance over all control steps, which is added to the final distance times 1 - way.
            The final distance has no gradient if a wave is far from its target; the mean has.
    """
    constants = np.concatenate([[energy, len(goal) // COLUMNS, duration, way], goal, shapes])
    text = "final squared distance from the wanted waves in the energy norm, divided by their energy"
    return Objective(_add_to_sums, single_sum_value, _pullback, constants, description=text)


def wave_shapes(mass: float, stiffness: float, rest_overlap: float, amplitudes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shapes of waves as one array (see `SHAPES`), and the speeds of the waves [grains/s], shape (waves,).

    Args:
        mass: mass of a grain [kg].
        stiffness: k of its contacts [N/m^1.5].
        rest_overlap: overlap of the contacts at rest; 0 without precompression [m].
        amplitudes: amplitudes of the waves, shape (waves,) [m/s].
    """
    constant = stiffness / mass
    if rest_overlap <= 0.0:
        wave = _wave_without_precompression()
        speeds = wave.speed_coefficient * root(constant * constant * np.asarray(amplitudes, dtype=np.float64), 5)
        waves = [wave]
    else:
        waves = [_precompressed_wave(constant, rest_overlap, float(one)) for one in amplitudes]
        # Lengths are divided by the overlap at rest d0, times by A^-0.5 d0^-0.25, where A = stiffness / mass is `constant`.
        speeds = np.array([wave.speed * math.sqrt(constant) * math.sqrt(math.sqrt(rest_overlap)) for wave in waves])
    return _pack_shapes(mass, waves), speeds


@cache
def _wave_without_precompression() -> LatticeWave:
    """Return the wave of an uncompressed chain, in units of its amplitude; cached, because environments request it often."""
    return lattice_wave(0.0)


def _precompressed_wave(constant: float, rest_overlap: float, amplitude: float) -> LatticeWave:
    """Return the wave of a given amplitude [m/s] on a precompressed chain; lengths and times in the units of `wave_shapes`."""
    from scipy.optimize import brentq

    unit = math.sqrt(constant) * rest_overlap * math.sqrt(math.sqrt(rest_overlap))
    wanted = amplitude / unit

    def amplitude_excess(height: float) -> float:
        return float(logarithm(lattice_wave(1.0, float(exponential(height))).velocity.max() / wanted))

    low, high = float(logarithm(0.01)), float(logarithm(1e6))
    if amplitude_excess(low) > 0.0 or amplitude_excess(high) < 0.0:
        raise ParameterError(
            f"got {amplitude:g} m/s",
            expected=f"1e-2 to 1e7 times {unit:.3g} m/s at this precompression",
            at="amplitude",
        )
    height = float(exponential(brentq(amplitude_excess, low, high, xtol=1e-13)))  # type: ignore[arg-type]
    return lattice_wave(1.0, height)


def _pack_shapes(mass: float, waves: list[LatticeWave]) -> FloatArray:
    density = round(1.0 / float(waves[0].position[1] - waves[0].position[0]))
    reach = min(max(_wave_reach(wave) for wave in waves), _LARGEST_REACH)
    # The cubic interpolation needs two more points at each end.
    count = 2 * round(reach * density) + 5
    tables = []
    for wave in waves:
        crest = int(np.argmax(wave.velocity))
        piece = slice(crest - count // 2, crest + count // 2 + 1)
        tables += [_pad_table(wave.velocity, piece, count), _pad_table(_energy_roots(wave), piece, count)]
    scaled = [table / float(waves[i // 2].velocity.max()) for i, table in enumerate(tables)]
    # The first point of a table lies one point spacing beyond the reach.
    head = [float(len(waves)), float(count), float(density), (count - 3) / 2.0 / density, mass]
    return np.concatenate([np.array(head), *scaled])


def _wave_reach(wave: LatticeWave) -> float:
    return float(np.abs(wave.position[wave.velocity > _NOTHING * wave.velocity.max()]).max())


def _pad_table(values: FloatArray, piece: slice, count: int) -> FloatArray:
    out = np.zeros(count)
    begin = max(piece.start, 0)
    chosen = values[begin : piece.stop]
    out[begin - piece.start : begin - piece.start + len(chosen)] = chosen
    return out


def _energy_roots(wave: LatticeWave) -> FloatArray:
    """Return the root q of the contact energy (see the module) at the points of a wave, for m = k = 1."""
    s, s0 = np.sqrt(wave.rest_overlap + wave.overlap), np.sqrt(wave.rest_overlap)
    return (s - s0) * np.sqrt(0.4 * s * s * s + 0.8 * s * s * s0 + 1.2 * s * s0 * s0 + 0.6 * s0 * s0 * s0)


def shape_energies(shapes: FloatArray, amplitudes: FloatArray) -> FloatArray:
    """Return the time-averaged energy of each wave [J], shape (waves,)."""
    count, density = int(shapes[POINTS]), shapes[DENSITY]
    tables = shapes[TABLES:].reshape(-1, 2, count)
    energies = (0.5 * tables[:, 0] ** 2 + tables[:, 1] ** 2).sum(axis=1) / density
    chosen = np.minimum(np.arange(len(amplitudes)), len(energies) - 1)
    return shapes[GRAIN_MASS] * energies[chosen] * np.asarray(amplitudes) ** 2


def half_width(shapes: FloatArray, row: int) -> float:
    """Return the half width of a wave [grains]: a thousandth of its kinetic energy is farther than this behind the crest."""
    place, velocity = _velocity_table(shapes, row)
    squares = velocity * velocity
    return float(-place[np.searchsorted(np.cumsum(squares), _PART * squares.sum())])


def _velocity_table(shapes: FloatArray, row: int) -> tuple[FloatArray, FloatArray]:
    """Return the distances from the crest [grains] in a wave's velocity table, and its velocities over the amplitude."""
    count = int(shapes[POINTS])
    table = TABLES + 2 * count * min(row, int(shapes[SHAPES]) - 1)
    return (np.arange(count) - 1.0) / shapes[DENSITY] - shapes[REACH], shapes[table : table + count]


def passing_waves(shapes: FloatArray, goal: FloatArray, duration: float, steps: int, action: str) -> FloatArray:
    """Return the drive of the left end that sends solitary waves to their places at the deadline, shape (steps,).

    A force is the mean over a control step of the force that grain -1 of an infinite chain would exert on grain 0. Its impulse
    equals the change of the momentum of grains i >= 0, m A sum_i f(i - x(t)), where A is the amplitude, f the velocity shape
    and x the place of the crest. The velocity of a piston is the mean velocity of grain 0 over a control step.

    Args:
        shapes: shapes of the waves.
        goal: rows (amplitude, place, speed); the places are those after the last step.
        duration: duration of a control step [s].
        steps: number of control steps.
        action: the input, "left_force" or "left_velocity".
    """
    total = np.zeros(steps)
    for row, wave in enumerate(goal):
        if wave[AMPLITUDE] <= 0.0:
            continue
        place, values = _velocity_shape(shapes, row)
        reach = float(shapes[REACH])
        fine = np.arange(steps * _FINE + 1) * (duration / _FINE)
        crest = wave[PLACE] - wave[SPEED] * (duration * steps - fine)
        if not action.endswith("force"):
            v = wave[AMPLITUDE] * np.interp(-crest, place, values, left=0.0, right=0.0)
            total += 0.5 * (v[:-1] + v[1:]).reshape(steps, _FINE).mean(axis=1)
            continue
        edges = crest[::_FINE]
        grains = np.arange(int(np.ceil(max(edges.max(), 0.0) + reach)) + 2)
        moving = np.interp(grains[None, :] - edges[:, None], place, values, left=0.0, right=0.0).sum(axis=1)
        total += shapes[GRAIN_MASS] * wave[AMPLITUDE] * np.diff(moving) / duration
    return total


def wave_velocities(shapes: FloatArray, goal: FloatArray, time_left: float, grains: int) -> FloatArray:
    """Return the grain velocities of travelling waves, `time_left` seconds before the deadline [m/s]."""
    total = np.zeros(grains)
    for row, wave in enumerate(goal):
        if wave[AMPLITUDE] > 0.0:
            place, values = _velocity_shape(shapes, row)
            crest = wave[PLACE] - wave[SPEED] * time_left
            total += wave[AMPLITUDE] * np.interp(np.arange(grains) - crest, place, values, left=0.0, right=0.0)
    return total


def _velocity_shape(shapes: FloatArray, row: int) -> tuple[FloatArray, FloatArray]:
    """Return distances and velocities as `_velocity_table`, interpolated to a finer grid by cubics."""
    place, velocity = _velocity_table(shapes, row)
    return np.linspace(place[0], place[-1], _FINER * (len(place) - 1) + 1), natural_spline(velocity, _FINER)


def refuse_early_waves(shapes: FloatArray, waves: FloatArray, duration: float, steps: int, name: str = "deadline") -> None:
    """Refuse waves that would have to be in the chain already at the start to reach their places by the deadline.

    Args:
        shapes: shapes of the waves.
        waves: rows (amplitude, place, speed).
        duration: duration of a control step [s].
        steps: number of control steps until the deadline.
        name: name of the argument that the error names.

    Raises:
        ParameterError: more than a thousandth of a wave's energy is in the chain at the start.
    """
    for row, wave in enumerate(waves):
        if wave[AMPLITUDE] > 0.0:
            # A thousandth of the wave's energy is farther than this ahead of the crest.
            place, velocity = _velocity_table(shapes, row)
            ahead = np.cumsum((velocity * velocity)[::-1])[::-1]
            front = place[np.flatnonzero(ahead / ahead[0] > _PART)[-1]]
            # At the start this point must be left of the first grain's left side.
            least = math.floor((wave[PLACE] + front + 0.5) / (wave[SPEED] * duration)) + 1
            arrival = f"a wave of {wave[AMPLITUDE]:g} m/s needs this many to travel from the left end to grain {wave[PLACE]:g}"
            refuse_early_deadline(steps, least, duration, arrival, name)


def refuse_crowded_waves(shapes: FloatArray, waves: FloatArray, grains: int, name: str = "place") -> None:
    """Refuse waves that overlap or extend beyond an end of the chain, because no state of the chain consists of them.

    Args:
        shapes: shapes of the waves.
        waves: rows (amplitude, place, speed), in any order.
        grains: number of grains of the chain.
        name: name of the argument that the error names.

    Raises:
        ParameterError: more than a thousandth of a wave's energy is beyond an end, or two waves are closer than their width.
    """
    kept = sorted((float(wave[PLACE]), half_width(shapes, row)) for row, wave in enumerate(waves) if wave[AMPLITUDE] > 0.0)
    for place, half in kept:
        low, high = half - 0.5, grains - 0.5 - half
        if not low <= place <= high:
            raise ParameterError(
                f"a wave at grain {place:g} extends beyond the end of the chain",
                expected=f"{low:g} to {high:g}",
                hint="choose another place, or more grains",
                at=name,
            )
    for (place, half), (other, other_half) in zip(kept, kept[1:], strict=False):
        if other - place < half + other_half:
            raise ParameterError(
                f"waves at grains {place:g} and {other:g} overlap",
                expected=f"a distance of at least {half + other_half:g} grains",
                at=name,
            )
