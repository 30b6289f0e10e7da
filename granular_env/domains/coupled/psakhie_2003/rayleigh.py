"""Section 3: the Rayleigh wave of figure 7: close behind S, elliptical, and gone at a small depth."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.grid.theory import rayleigh_ellipse, rayleigh_speed
from granular_env.components.support.float_arrays import FloatArray

from .cases import INSTANTS, LOAD, MATERIAL, S_SPEED, exact, half_space
from .velocity_field import Motion, motion
from .waves import crest

_SPEED = rayleigh_speed(MATERIAL)
_LENGTH = _SPEED * LOAD
_SIDES = {"grid": -1.0, "automata": 1.0}
_FINE, _SPARSE = 2001, 61
_DEPTHS = np.linspace(0.0, 1.0, 41) * _LENGTH
# "Decays quickly": half of its kinetic energy is gone at this part of its length.
_SHALLOW = 0.5
_QUICKLY = "half of its energy is gone in half of its length"
_MILLI = 1e3


def compute(context: Context) -> Findings:
    """Measure speed, ellipse and decay in the grid and in the automata."""
    log = context.run(half_space(context, "symmetric"))
    moving = {time: motion(log, time) for time in INSTANTS}
    last = moving[INSTANTS[-1]]
    return Findings([_behind(moving), _ellipse(last), _decay(last)], [_hodograph(last), _depths(last)])


def _window(time: float, samples: int = _FINE) -> FloatArray:
    """Return x from the source within the wave: behind its front, while the load lasted [m]."""
    return np.linspace(_SPEED * (time - LOAD), _SPEED * time, samples)


def surface_crest(moving: Motion, side: float, time: float) -> float:
    """Return how far from the load the crest of the vertical velocity on the surface is, to the right (side 1) or left [m]."""
    x = _window(time)
    return crest(x, moving.at(side * x, np.zeros_like(x))[:, 1])


def _behind(moving: dict[float, Motion]) -> Item:
    values: list[Value] = []
    for part, side in _SIDES.items():
        places = [surface_crest(moving[time], side, time) for time in INSTANTS]
        speed = (places[1] - places[0]) / (INSTANTS[1] - INSTANTS[0])
        values.append(
            Value(
                f"in the {part}",
                "slightly behind S",
                "slightly behind S" if 0.8 < speed / S_SPEED < 1.0 else "not",
                reading="more than 0.8 of its speed",
            )
        )
        values.append(Value(f"its speed over that of S, {part}", None, speed / S_SPEED, digits=3))
    values.append(Value("theory", None, _SPEED / S_SPEED, digits=5))
    return Item(
        "The Rayleigh wave “runs near the free surface, slightly behind the transverse one”", "section 3", values,
        remark="Speed of the crest of the vertical velocity on the surface between 40 and 70 µs.",
        reason="The paper has no number: more than 0.8 of its speed is our reading of slightly behind.",
    )  # fmt: skip


def ellipse(last: Motion, side: float) -> float:
    """Return the vertical over the horizontal axis at the surface, as the roots of their energies within the wave."""
    x = np.linspace(_SPEED * (INSTANTS[-1] - 1.5 * LOAD), _SPEED * (INSTANTS[-1] + 0.5 * LOAD), 4 * _FINE)
    taper = np.hanning(len(x))[:, None]
    spectrum = np.abs(np.fft.rfft(last.at(side * x, np.zeros_like(x)) * taper, axis=0))
    return float(np.sqrt((spectrum[1:16, 1] ** 2).sum() / (spectrum[1:16, 0] ** 2).sum()))


def _ellipse(last: Motion) -> Item:
    values: list[Value] = []
    for part, side in _SIDES.items():
        ours = ellipse(last, side)
        values.append(Value(f"in the {part}", "elliptical", "elliptical" if ours > 0.0 and _turns(last, side) else "not"))
        values.append(Value(f"vertical over horizontal axis, {part}", None, ours, digits=3))
    values.append(Value("theory, any frequency", None, rayleigh_ellipse(MATERIAL), digits=5))
    return Item(
        "The Rayleigh wave “has an elliptical polarisation”", "section 3", values,
        remark="Elliptical: as the wave passes, the velocity of a point of the surface turns around, against the sense of "
        "rolling. Axes from the spectra of both components.",
        reason="It does not turn.",
    )  # fmt: skip


def _turns(last: Motion, side: float) -> bool:
    """Tell whether the velocity turns by more than half a turn against the sense of rolling as the wave passes."""
    x = _window(INSTANTS[-1])
    velocity = last.at(side * x, np.zeros_like(x)) * [side, 1.0]
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    own = speed > 0.3 * speed.max()
    # What has passed a point lies ahead of it: along x the velocity turns clockwise where in time it turns against the clock.
    angle = np.unwrap(np.arctan2(velocity[own, 1], velocity[own, 0]))
    return bool(angle[0] - angle[-1] > np.pi)


def _decay(last: Motion) -> Item:
    values: list[Value] = []
    for part, side in _SIDES.items():
        depth = half_depth(_energies(last, side)) / _LENGTH
        fast = "decays quickly" if depth < _SHALLOW else "does not"
        values.append(Value(f"in the {part}", "decays quickly", fast, reading=_QUICKLY))
        values.append(Value(f"depth at which half is left, over its length, {part}", None, depth, digits=2))
    return Item(
        "The Rayleigh wave “decays quickly with depth”", "section 3", values,
        remark=f"Kinetic energy of a layer within the length of the wave, {_LENGTH * _MILLI:.0f} mm, against that at the "
        "surface.",
        reason=f"The paper has no number: {_QUICKLY} is our reading of quickly.",
    )  # fmt: skip


def _energies(last: Motion, side: float) -> FloatArray:
    """Return the mean squares of the velocity within the wave at the depths, over that at the surface."""
    found = np.array([_energy(last, side, depth) for depth in _DEPTHS])
    return found / found[0]


def _energy(last: Motion, side: float, depth: float) -> float:
    """Return the mean square of the velocity within the wave at a depth [m2/s2]."""
    x = _window(INSTANTS[-1])
    return float((last.at(side * x, np.full_like(x, -depth)) ** 2).sum(axis=1).mean())


def half_depth(energies: FloatArray) -> float:
    """Return the least depth at which half is left [m]."""
    below = int(np.argmax(energies < 0.5))
    return float(np.interp(0.5, energies[below - 1 : below + 1][::-1], _DEPTHS[below - 1 : below + 1][::-1]))


def _hodograph(last: Motion) -> Figure:
    curves: list[Curve] = []
    for number, (part, side) in enumerate(_SIDES.items()):
        x = _window(INSTANTS[-1], 201)
        velocity = _MILLI * last.at(side * x, np.zeros_like(x))
        curves.append(Curve(part, side * velocity[:, 0], velocity[:, 1], "line" if number == 0 else "dashed", number))
    return Figure(
        "figure-rayleigh-ellipse", "The path of the velocity as the Rayleigh wave passes",
        "On the surface at 70 µs: the vertical over the horizontal velocity, this counted away from the load. In a wave of one "
        "frequency it would be an ellipse; this one is a pulse. On both sides it is the same.",
        Axis("horizontal velocity, mm/s"), Axis("vertical velocity, mm/s"), curves,
    )  # fmt: skip


def _depths(last: Motion) -> Figure:
    curves = [
        Curve(part, _DEPTHS / _LENGTH, _energies(last, side), "line" if number == 0 else "dashed", number)
        for number, (part, side) in enumerate(_SIDES.items())
    ]
    curves.append(Curve("exact solution", *_exact_energies(_energy(last, -1.0, 0.0)), "points", 2))
    return Figure(
        "figure-rayleigh-depth", "The Rayleigh wave with depth",
        "Kinetic energy within the length of the wave, at 70 µs, over that at the surface. "
        "What is left below is of the S wave, which is still near.",
        Axis("depth, in lengths of the wave", 0.0, 1.0), Axis("kinetic energy", 0.0), curves,
    )  # fmt: skip


def _exact_energies(at_surface: float) -> tuple[FloatArray, FloatArray]:
    """Return depths in lengths of the wave, and the mean squares of the exact velocity over that of the grid at the surface."""
    solution, x, time = exact(), _window(INSTANTS[-1], _SPARSE), np.array([INSTANTS[-1]])
    depths = np.array([0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0])
    means = [float(np.mean([(solution.displacement(p, d * _LENGTH, time)[0] ** 2).sum() for p in x])) for d in depths]
    return depths, np.array(means) / at_surface


ENTRY = Entry(
    "3-rayleigh",
    "3",
    "The Rayleigh wave",
    "Along the free surface a wave runs in which the medium moves on ellipses; below a small depth there is nothing of it.",
    compute,
    weight=6.0,
    runs=1,
)
