"""Figures over frequency: amplitude spectra of elements, and the dispersion of waves along a row of elements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from granular_env.colours import PALETTE, SEQUENTIAL
from granular_env.components.support.float_arrays import FloatArray

from ..recorded_fields import evenly_spaced_series
from ..unit_labels import scaled_unit
from .drawing import add_legend, line_style, new_figure, use_style, value_scale

_WIDTH, _HEIGHT, _DISPERSION_HEIGHT = 8.0, 4.2, 5.2  # inch
# Magnitudes below the largest one by more than this have the darkest colour [dB].
_RANGE = 60.0
_CURVE_POINTS, _HEADROOM = 401, 1.15

Curves = Callable[[FloatArray], dict[str, FloatArray]] | None


class Spectrum(NamedTuple):
    """The one-sided amplitude spectrum of an element: frequencies [Hz] and amplitudes in `unit`, both shape (frequencies,)."""

    quantity: str
    unit: str
    label: str
    frequencies: npt.NDArray[Any]
    amplitudes: FloatArray


def load_spectra(log: Any, name: str, elements: Mapping[int, tuple[str, str]]) -> list[Spectrum]:
    """Return the spectra of elements of a recorded variable.

    A sine of amplitude A that has a whole number of periods in the log gives a line of the height A.

    Args:
        log: an open log.
        name: name of the variable.
        elements: quantity and label of each element by its index in the flat array.

    Raises:
        ParameterError: the frames are not evenly spaced in time.
    """
    interval, values = evenly_spaced_series(log, name, list(elements))
    count, unit = len(values), log.variables[name].unit
    amplitudes = np.abs(np.fft.rfft(values, axis=0)) * 2.0 / count
    # Frequency 0 and, for an even count, the highest one have no counterpart of negative frequency.
    amplitudes[0 :: count // 2 if count % 2 == 0 else count] *= 0.5
    frequencies = np.fft.rfftfreq(count, interval)
    return [
        Spectrum(quantity, unit, label, frequencies, own)
        for (quantity, label), own in zip(elements.values(), amplitudes.T, strict=True)
    ]


@use_style
def draw_spectra(spectra: Sequence[Spectrum], runs: int) -> Figure:
    """Draw spectra in one panel for each quantity; those of equal elements of several runs follow each other."""
    scale, unit = scaled_unit("Hz", max(float(one.frequencies[-1]) for one in spectra))
    quantities = list(dict.fromkeys(one.quantity for one in spectra))
    figure = new_figure(_WIDTH, _HEIGHT * len(quantities))
    for axes, quantity in zip(figure.subplots(len(quantities), 1, squeeze=False).flat, quantities, strict=True):
        shown = [one for one in spectra if one.quantity == quantity]
        factor, label = value_scale(f"amplitude of {quantity}", shown[0].unit, *(one.amplitudes for one in shown))
        for place, one in enumerate(shown):
            style = line_style(place, runs if len(shown) > runs else 1)
            axes.plot(scale * one.frequencies, factor * one.amplitudes, label=one.label.replace("_", " "), **style)
        axes.set(xlabel=f"frequency [{unit}]", ylabel=label)
        axes.margins(x=0.0)
        axes.set_ylim(bottom=0.0)
        add_legend(axes)
    return figure


@use_style
def draw_dispersion(log: Any, name: str, components: Sequence[str], curves: Curves) -> Figure:
    """Draw the magnitude of the Fourier transform over time and along the row, with the curves of the theory.

    Waves to the right have positive wave numbers. A Hann window in time and along the row reduces leakage.

    Args:
        log: an open log.
        name: an output with one value or vector for each element of a row.
        components: the names of its vector components; its own name if it has none.
        curves: function(phases) that returns name -> frequencies [Hz], as `Domain.dispersion`; None without a theory.

    Raises:
        ParameterError: the frames are not evenly spaced in time.
    """
    interval, values = evenly_spaced_series(log, name)
    values = values.reshape(len(values), -1, len(components))
    figure = new_figure(_WIDTH, _DISPERSION_HEIGHT * len(components))
    for number, axes in enumerate(figure.subplots(len(components), 1, squeeze=False).flat):
        frequencies, phases, decibels = _transform(interval, values[:, :, number])
        scale, unit = scaled_unit("Hz", float(frequencies[-1]))
        image = axes.pcolormesh(
            phases, scale * frequencies, decibels, vmin=-_RANGE, vmax=0.0, shading="nearest", rasterized=True,
            cmap=LinearSegmentedColormap.from_list("granular-sequential", SEQUENTIAL),
        )  # fmt: skip
        axes.grid(False)
        figure.colorbar(image, ax=axes, label=f"{components[number].replace('_', ' ')} [dB], 0 at the largest", pad=0.02)
        shown = [frequencies[(decibels > -_RANGE).any(axis=1)]]
        lattice = np.linspace(-np.pi, np.pi, _CURVE_POINTS)
        for place, (label, theory) in enumerate(curves(lattice).items() if curves is not None else ()):
            axes.plot(lattice, scale * theory, "--", color=PALETTE[1 + place], linewidth=1.2, label=label)
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.2)
            shown.append(theory)
        axes.set(xlabel="wave number x spacing [rad]", ylabel=f"frequency [{unit}]", xlim=(-np.pi, np.pi))
        highest = _HEADROOM * float(np.concatenate(shown).max(initial=0.0)) or np.inf
        axes.set_ylim(0.0, scale * min(highest, float(frequencies[-1])))
        axes.set_xticks(np.pi * np.linspace(-1.0, 1.0, 5), ["\u2212\u03c0", "\u2212\u03c0/2", "0", "\u03c0/2", "\u03c0"])
    return figure


def _transform(interval: float, values: FloatArray) -> tuple[npt.NDArray[Any], npt.NDArray[Any], FloatArray]:
    """Return the transform of values, shape (frames, n): frequencies [Hz], phases per element (n,) [rad], magnitude [dB]."""
    frames, places = values.shape
    window = np.hanning(frames)[:, None] * np.hanning(places)
    # rfft has the sign of exp(-i omega t); ifft along the row then gives waves to the right positive wave numbers.
    magnitude = np.abs(np.fft.fftshift(np.fft.ifft(np.fft.rfft(values * window, axis=0), axis=1), axes=1))
    decibels = 20.0 * np.log10(np.maximum(magnitude / (magnitude.max() or 1.0), 1e-30))
    return np.fft.rfftfreq(frames, interval), np.fft.fftshift(np.fft.fftfreq(places)) * 2.0 * np.pi, decibels
