"""The solitary wave of the discrete lattice: a travelling wave u(x - Vt) of (2.1). Dimensionless: m = A = a = 1.

With d(x) the overlap above its rest value, F the contact force above its rest value, and the tent 1 - |x| on |x| < 1,

    V^2 d = tent * F(d),   F = (d0 + d)^1.5 - d0^1.5,   V v = box * F,

where * is convolution (Friesecke & Wattis 1994; English & Pego 2005). Iteration at fixed height converges, and does so
quickly if the linear part of F is first moved to the left side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import GranularError, ParameterError
from ...support.elementary_functions import exponential, fourier, root, sine_of_pi
from ...support.float_arrays import FloatArray

# Values of the uncompressed wave from `lattice_wave(0)`; runs of the chain agree with all of them to six digits.
# Speed in diameters times (k/m)^(2/5) v_m^(1/5), v_m the largest velocity of a grain (paper: 0.915).
SOLITARY_SPEED = 0.9074700784
# Energy of the wave in m v_m^2, and its momentum in m v_m.
SOLITARY_ENERGY = 1.0693229458
SOLITARY_MOMENTUM = 1.6699712493
# Largest value at a front with weak losses over the value far behind it: overlap, pressure (by (2.7): 1.5625, 1.9531).
LATTICE_STRAIN_OVERSHOOT = 1.4873593743
LATTICE_PRESSURE_OVERSHOOT = 1.8139439880
# Velocity of the last grain after it leaves a free end, in v_m; from a run of the chain.
FREE_END_VELOCITY = 1.44606

# Change of the shape at which the iteration stops: _TOLERANCE, or, for a small rise e, _ROUNDING / e^2 due to rounding.
_TOLERANCE, _ROUNDING = 1e-13, 5e-13
_ITERATIONS = 500
_POINTS_PER_GRAIN = 16
# Half the length computed: an uncompressed wave decays doubly exponentially, others as exp(-2 sqrt(e/2) |x|) or faster.
_HALF_BOX = 16.0
_DECADES = 34.0
_SMALLEST_RISE = 0.005


@dataclass(frozen=True, eq=False)
class LatticeWave:
    """The discrete solitary wave; it travels towards larger x. All values are in units with m = A = a = 1.

    Attributes:
        position: x - Vt of a contact (overlap) or a grain (velocity), equidistant, with the crest at 0, shape (n,).
        overlap: overlap above its rest value, shape (n,).
        velocity: velocity of the grains, shape (n,).
        rest_overlap: overlap d0 at rest; 0 without precompression.
        speed: speed V of the wave.
    """

    position: FloatArray
    overlap: FloatArray
    velocity: FloatArray
    rest_overlap: float
    speed: float

    @property
    def displacement(self) -> FloatArray:
        """Return the displacement of the grains: 0 far ahead, the total displacement far behind, shape (n,)."""
        # u' = -v/V, integrated as a Fourier series.
        step = self.position[1] - self.position[0]
        wave_number = 2.0 * np.pi * np.fft.rfftfreq(len(self.position), step)
        series = np.fft.rfft(-self.velocity / self.speed)
        mean = series[0].real / len(self.position)
        series[1:] /= 1j * wave_number[1:]
        series[0] = series[-1] = 0.0
        whole = np.fft.irfft(series, len(self.position)) + mean * self.position
        return whole - whole[-1]

    @property
    def speed_coefficient(self) -> float:
        """Speed coefficient V / v_m^(1/5); 0.907470 for the uncompressed wave of any height."""
        return self.speed / float(root(self.velocity.max(), 5))

    @property
    def speed_ratio(self) -> float:
        """V/c0, the speed over that of long waves in the chain at rest; infinite without precompression."""
        return self.speed / (1.5 * self.rest_overlap**0.5) ** 0.5 if self.rest_overlap else np.inf

    @property
    def momentum(self) -> float:
        """Total momentum, the sum of the grains' velocities (m = 1); constant in time."""
        return float(self.velocity.sum()) * self._grain_fraction

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy, averaged over time; without precompression 5/4 of the potential energy (virial theorem)."""
        return 0.5 * float((self.velocity**2).sum()) * self._grain_fraction

    @property
    def potential_energy(self) -> float:
        """Return the contacts' energy above its rest value minus the work of the compressive force, averaged over time."""
        rest, whole = self.rest_overlap, self.rest_overlap + self.overlap
        return float((0.4 * (whole**2.5 - rest**2.5) - rest**1.5 * self.overlap).sum()) * self._grain_fraction

    @property
    def energy_ratio(self) -> float:
        """Mean of Ek/Ep over the time in which the wave advances by one grain; 1.25077 for the uncompressed wave."""
        every = round(1.0 / self._grain_fraction)
        rest, whole = self.rest_overlap, self.rest_overlap + self.overlap
        stored = 0.4 * (whole**2.5 - rest**2.5) - rest**1.5 * self.overlap
        # Grains lie at whole numbers, contacts half a grain from them.
        kinetic = (0.5 * self.velocity**2).reshape(-1, every).sum(axis=0)
        potential = np.roll(stored, every // 2).reshape(-1, every).sum(axis=0)
        return float((kinetic / potential).mean())

    @property
    def width(self) -> float:
        """Full width of the overlap at half its height, in diameters."""
        from scipy.interpolate import CubicSpline

        right = self.position >= 0.0
        curve = CubicSpline(self.position[right], self.overlap[right] - 0.5 * self.overlap.max())
        return 2.0 * float(curve.roots(extrapolate=False)[0])

    @property
    def _grain_fraction(self) -> float:
        return float(self.position[1] - self.position[0])


def lattice_wave(rest_overlap: float, height: float = 1.0) -> LatticeWave:
    """Return the solitary wave of (2.1) whose overlap rises by `height` from `rest_overlap` d0, r = 1 + height/d0.

    V is exact to about 1e-11, the shape of a wave that rises by e = height/d0 << 1 to 5e-13/e^2. The difference between V and
    the closed form of the continuum (`speed_ratio`) is the error of the continuum.

    Args:
        rest_overlap: d0 >= 0, in diameters, like the height.
        height: > 0; at least 0.005 d0, below which `korteweg_de_vries_speed_ratio` has an error of less than 1e-6.
    """
    rest, height = float(rest_overlap), float(height)
    if not (rest >= 0.0 and 0.0 < height < math.inf and height >= _SMALLEST_RISE * rest):
        raise ParameterError(
            f"got {height:g} above a rest_overlap of {rest:g}",
            expected=f"more than 0, and at least {_SMALLEST_RISE:g} times the rest_overlap",
            at="height",
        )
    rise = height / rest if rest else math.inf
    rate = min(1.0, math.sqrt(0.5 * rise))
    half = _HALF_BOX if rise > 8.0 else 0.5 * _DECADES / rate + 6.0
    count = 1 << (math.ceil(2.0 * half * _POINTS_PER_GRAIN) - 1).bit_length()
    steps = (np.arange(count) + count // 2) % count - count // 2  # 0, 1, ..., -2, -1
    place, waves = steps / _POINTS_PER_GRAIN, steps * (_POINTS_PER_GRAIN / count)
    box = np.where(steps == 0, 1.0, sine_of_pi(waves) / np.where(steps == 0, 1.0, math.pi * waves))
    tent = box * box
    # Overlaps are divided by the height of the wave; since F ~ d^1.5, V is proportional to the height's fourth root.
    start = rest / height
    linear = 1.5 * math.sqrt(start)
    rise_of_guess = exponential(np.minimum(rate * np.abs(place), 300.0))
    guess = 2.0 / (rise_of_guess + 1.0 / rise_of_guess)
    shape = guess * guess
    tolerance = max(_TOLERANCE, _ROUNDING / rise**2)
    for _ in range(_ITERATIONS):
        # Functions even about index 0 have real spectra; without the imaginary rounding errors the wave cannot drift.
        force, overlap = fourier(_force_rise(shape, start), shape)
        square = float((force * tent).sum()) / count
        # The linear part of the force is moved to the left side, so that low wave numbers converge as fast as high ones.
        better, _ = fourier((force - linear * overlap) * tent / (square - linear * tent), np.zeros(count))
        better = better / better[0]
        change = float(np.abs(better - shape).max())
        shape = better
        if change < tolerance:
            break
    else:
        raise GranularError(
            f"no convergence for rest_overlap {rest:g} and height {height:g}", hint="take a larger height", at="lattice_wave"
        )
    speed = math.sqrt(square)
    pushed = fourier(_force_rise(shape, start), np.zeros(count))[0] * box
    velocity = fourier(pushed, np.zeros(count))[0] / (speed * count)
    place, shape, velocity = (np.roll(values, count // 2) for values in (place, shape, velocity))
    # Far from the wave rounding leaves overlaps of +-1e-16 instead of 0.
    overlap = np.maximum(shape, 0.0) * height
    fourth_root = math.sqrt(math.sqrt(height))
    return LatticeWave(place, overlap, velocity * (height * fourth_root), rest, speed * fourth_root)


def _force_rise(shape: FloatArray, start: float) -> FloatArray:
    whole = start + np.maximum(shape, 0.0)
    return whole * np.sqrt(whole) - start * math.sqrt(start)
