"""Distance of a chain from wanted solitary waves, in the energy norm (`energy_root`): kernels, and their shapes.

A goal is `waves` rows (amplitude, place, speed): the largest grain velocity [m/s], the grain at which the crest shall be when
the time left is 0 (a real number, the first grain is 0), and the speed [grains/s]. Before that the crest is behind by the
way that is left: a wave that is right is right at all times.

Shapes are tables over the distance to the crest: grain velocity / amplitude, and energy root of the contact / (sqrt(m)
amplitude), of the exact wave of the lattice (`theory.lattice_wave`), read by cubics through four points. One table serves
every amplitude where the chain is not precompressed; otherwise each wave has its own.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from granular_env.components.chain.differentiable_quantities import energy_root, energy_root_pullback, input_work
from granular_env.components.chain.layout import GRAINS, MASS, SCALARS, V
from granular_env.components.chain.theory.lattice_wave import LatticeWave, lattice_wave
from granular_env.components.errors import ParameterError
from granular_env.components.support.elementary_functions import exponential, logarithm, root
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import inlined, jit

# Layout of the shapes: how many, points of a table, points per grain, reach [grains], the mass of the grains that the shapes
# stand for, then the tables.
SHAPES, POINTS, DENSITY, REACH, GRAIN_MASS, TABLES = range(6)
# Columns of a goal.
AMPLITUDE, PLACE, SPEED = range(3)
COLUMNS = 3

# Beyond its reach a wave is taken for nothing: it has fallen to this part of its crest.
_NOTHING = 1e-8
_LARGEST_REACH = 60.0


# -- kernels ----------------------------------------------------------------------------------------------------------


@inlined
def _shape(shapes, table, x):
    """Return the table at a distance x from the crest."""
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
def _target(shapes, goal, waves, left, place, contact):
    """Return the target at a place, with time `left`: grain velocity, or energy root / sqrt(m) of a contact; the waves' sum."""
    total, count = 0.0, int(shapes[POINTS])
    for w in range(waves):
        row, table = COLUMNS * w, TABLES + 2 * count * min(w, int(shapes[SHAPES]) - 1)
        table += count if contact else 0
        x = place - (goal[row + PLACE] - goal[row + SPEED] * left)
        total += goal[row + AMPLITUDE] * _shape(shapes, table, x)
    return total


@jit
def distance(a, shapes, goal, waves, left):
    """Square of the distance to the wanted waves, `left` seconds before they are due [J]."""
    n, root, total = int(a[SCALARS, GRAINS]), math.sqrt(shapes[GRAIN_MASS]), 0.0
    for i in range(1, n + 1):
        off = a[V, i] - _target(shapes, goal, waves, left, i - 1.0, False)
        total += 0.5 * a[MASS, i] * (off * off)
    for j in range(1, n):
        off = energy_root(a, j) - root * _target(shapes, goal, waves, left, j - 0.5, True)
        total += off * off
    return total


@jit
def distance_pullback(a, adjoint, shapes, goal, waves, left, slope):
    """Bar += slope ddistance/da."""
    n, root = int(a[SCALARS, GRAINS]), math.sqrt(shapes[GRAIN_MASS])
    for i in range(1, n + 1):
        off = a[V, i] - _target(shapes, goal, waves, left, i - 1.0, False)
        adjoint[V, i] += slope * a[MASS, i] * off
        adjoint[MASS, i] += slope * 0.5 * (off * off)
    for j in range(1, n):
        off = energy_root(a, j) - root * _target(shapes, goal, waves, left, j - 0.5, True)
        energy_root_pullback(a, adjoint, j, 2.0 * slope * off)


@jit
def energy_outside(a, goal, waves, left, window):
    """Energy of grains and contacts further than `window` grains from every wanted crest, and that of all [J]."""
    n, outside, whole = int(a[SCALARS, GRAINS]), 0.0, 0.0
    for i in range(1, n + 1):
        energy = 0.5 * a[MASS, i] * (a[V, i] * a[V, i])
        whole += energy
        outside += energy if _apart(goal, waves, left, i - 1.0, window) else 0.0
    for j in range(n + 1):
        q = energy_root(a, j)
        whole += q * q
        outside += q * q if _apart(goal, waves, left, j - 0.5, window) else 0.0
    return outside, whole


@jit
def amplitude_error(a, shapes, goal, waves, left, window):
    """Largest relative error, over the waves, of the fastest grain's velocity within `window` grains of the crest.

    It is compared with the fastest wanted there at the same instant; waves that have not come yet have none.
    """
    n, worst = int(a[SCALARS, GRAINS]), 0.0
    for w in range(waves):
        row = COLUMNS * w
        place = goal[row + PLACE] - goal[row + SPEED] * left
        fastest, wanted = 0.0, 0.0
        for i in range(max(int(np.ceil(place - window)), 0) + 1, min(int(np.floor(place + window)), n - 1) + 2):
            fastest = max(fastest, a[V, i])
            wanted = max(wanted, _target(shapes, goal, waves, left, i - 1.0, False))
        if wanted > 0.5 * goal[row + AMPLITUDE]:
            worst = max(worst, abs(fastest / wanted - 1.0))
    return worst


@jit
def _apart(goal, waves, left, place, window):
    for w in range(waves):
        row = COLUMNS * w
        if goal[row + AMPLITUDE] > 0.0 and abs(place - (goal[row + PLACE] - goal[row + SPEED] * left)) <= window:
            return False
    return True


@jit
def follow(a, shapes, goal, waves, left, window, energy, counters):
    """Update the counters of tasks with target waves; return the gain in nearness, distance before less distance now.

    Args:
        a: the chain's table.
        shapes: of the waves.
        goal: rows (amplitude, place, speed).
        waves: how many rows.
        left: time until they are due [s].
        window: half width of what counts as a wave [grains].
        energy: of the wanted waves, the unit of the distance [J].
        counters: distance, energy outside over the energy put in, amplitude error; written.
    """
    before = counters[0]
    outside, whole = energy_outside(a, goal, waves, left, window)
    put_in = max(input_work(a), whole)
    counters[0] = distance(a, shapes, goal, waves, left) / energy
    counters[1] = outside / put_in if put_in > 0.0 else 0.0
    counters[2] = amplitude_error(a, shapes, goal, waves, left, window)
    return before - counters[0]


# -- shapes -----------------------------------------------------------------------------------------------------------


def wave_shapes(mass: float, stiffness: float, rest_overlap: float, amplitudes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shapes of the wanted waves in the layout of the kernels, and their speeds [grains/s], shape (waves,).

    Args:
        mass: of a grain [kg].
        stiffness: k of its contacts [N/m^1.5].
        rest_overlap: overlap of the contacts at rest; 0 without precompression [m].
        amplitudes: of the waves, shape (waves,) [m/s].
    """
    constant = stiffness / mass
    if rest_overlap <= 0.0:
        wave = _wave_without_precompression()
        speeds = wave.speed_coefficient * root(constant * constant * np.asarray(amplitudes, dtype=np.float64), 5)
        waves = [wave]
    else:
        waves = [_pressed_wave(constant, rest_overlap, float(one)) for one in amplitudes]
        # Lengths are in overlaps at rest, times in A^-0.5 d0^-0.25.
        speeds = np.array([wave.speed * math.sqrt(constant) * math.sqrt(math.sqrt(rest_overlap)) for wave in waves])
    return _layout(mass, waves), speeds


@cache
def _wave_without_precompression() -> LatticeWave:
    """Return the wave of an uncompressed chain, in units of its amplitude: environments that draw chains ask often."""
    return lattice_wave(0.0)


def _pressed_wave(constant: float, rest_overlap: float, amplitude: float) -> LatticeWave:
    """Return the wave of an amplitude on a precompressed chain, in units of the overlap at rest and A."""
    from scipy.optimize import brentq

    unit = math.sqrt(constant) * rest_overlap * math.sqrt(math.sqrt(rest_overlap))
    wanted = amplitude / unit

    def too_high(height: float) -> float:
        return float(logarithm(lattice_wave(1.0, float(exponential(height))).velocity.max() / wanted))

    low, high = float(logarithm(0.01)), float(logarithm(1e6))
    if too_high(low) > 0.0 or too_high(high) < 0.0:
        raise ParameterError(
            f"got {amplitude:g} m/s",
            expected=f"1e-2 to 1e7 times {unit:.3g} m/s in a chain of this precompression",
            at="amplitude",
        )
    height = float(exponential(brentq(too_high, low, high, xtol=1e-13)))  # type: ignore[arg-type]
    return lattice_wave(1.0, height)


def _layout(mass: float, waves: list[LatticeWave]) -> FloatArray:
    density = round(1.0 / float(waves[0].position[1] - waves[0].position[0]))
    reach = min(max(_reach(wave) for wave in waves), _LARGEST_REACH)
    # Two more points at either end, which the cubics read.
    count = 2 * round(reach * density) + 5
    tables = []
    for wave in waves:
        crest = int(np.argmax(wave.velocity))
        piece = slice(crest - count // 2, crest + count // 2 + 1)
        tables += [_pad(wave.velocity, piece, count), _pad(_energy_roots(wave), piece, count)]
    scaled = [table / float(waves[i // 2].velocity.max()) for i, table in enumerate(tables)]
    # The first point lies one beyond the reach.
    head = [float(len(waves)), float(count), float(density), (count - 3) / 2.0 / density, mass]
    return np.concatenate([np.array(head), *scaled])


def _reach(wave: LatticeWave) -> float:
    return float(np.abs(wave.position[wave.velocity > _NOTHING * wave.velocity.max()]).max())


def _pad(values: FloatArray, piece: slice, count: int) -> FloatArray:
    out = np.zeros(count)
    begin = max(piece.start, 0)
    chosen = values[begin : piece.stop]
    out[begin - piece.start : begin - piece.start + len(chosen)] = chosen
    return out


def _energy_roots(wave: LatticeWave) -> FloatArray:
    """Return q of a contact, m = A = 1."""
    s, s0 = np.sqrt(wave.rest_overlap + wave.overlap), np.sqrt(wave.rest_overlap)
    return (s - s0) * np.sqrt(0.4 * s * s * s + 0.8 * s * s * s0 + 1.2 * s * s0 * s0 + 0.6 * s0 * s0 * s0)


def shape_energies(shapes: FloatArray, amplitudes: FloatArray) -> FloatArray:
    """Energy of each wave, its mean over time [J], shape (waves,)."""
    count, density = int(shapes[POINTS]), shapes[DENSITY]
    tables = shapes[TABLES:].reshape(-1, 2, count)
    energies = (0.5 * tables[:, 0] ** 2 + tables[:, 1] ** 2).sum(axis=1) / density
    chosen = np.minimum(np.arange(len(amplitudes)), len(energies) - 1)
    return shapes[GRAIN_MASS] * energies[chosen] * np.asarray(amplitudes) ** 2
