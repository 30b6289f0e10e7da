"""Section 3: the kinds of waves that a load on the surface makes, how fast they are and how the medium moves in them."""

from __future__ import annotations

import math

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.support.float_arrays import FloatArray

from .cases import INSTANTS, LOAD, P_SPEED, S_SPEED, exact, half_space
from .pictures import Window, rotation, spin, vectors
from .velocity_field import Motion, motion

# The ray along which body waves are looked at, from the depth.
_ANGLE = 0.25 * math.pi
_SPEED_READING, _MOSTLY = 2.0, 90.0
_SIDES = {"grid": -1.0, "automata": 1.0}
_FINE = 4001
# Samples of the exact solution along a wave.
_SPARSE = 121


def compute(context: Context) -> Findings:
    """Measure the waves of figure 7, square packing, in the grid and in the automata."""
    log = context.run(half_space(context, "symmetric"))
    moving = {time: motion(log, time) for time in INSTANTS}
    last = moving[INSTANTS[-1]]
    items = [_speeds(moving), _directions(last), _head(last), _vortex(last)]
    return Findings(items, [_rotation(last), _enlarged(last)])


# -- body waves ----------------------------------------------------------------------------------------------------------


def _ray(side: float) -> tuple[FloatArray, FloatArray]:
    """Return the direction of a ray into the depth, and the one across it."""
    return np.array([side * math.sin(_ANGLE), -math.cos(_ANGLE)]), np.array([math.cos(_ANGLE), side * math.sin(_ANGLE)])


def _wave(speed: float, time: float, samples: int = _FINE) -> FloatArray:
    """Return distances from the source within a wave of this speed: behind its front, while the load lasted [m]."""
    return np.linspace(speed * (time - LOAD), speed * time, samples)


def crest(places: FloatArray, values: FloatArray) -> float:
    """Return where the largest magnitude is, between samples by a parabola."""
    size = np.abs(values)
    i = int(np.clip(np.argmax(size), 1, len(size) - 2))
    before, at, after = size[i - 1 : i + 2]
    return float(places[i] + 0.5 * (places[1] - places[0]) * (before - after) / (before - 2.0 * at + after))


def _crest_speed(moving: dict[float, Motion], side: float, speed: float, shear: bool) -> float:
    along, across = _ray(side)
    found: list[float] = []
    for time in INSTANTS:
        r = _wave(speed, time)
        found.append(crest(r, moving[time].at(r * along[0], r * along[1]) @ (across if shear else along)))
    return (found[1] - found[0]) / (INSTANTS[1] - INSTANTS[0])


def _exact_crest_speed(speed: float, shear: bool) -> float:
    solution, found = exact(), []
    along, across = _ray(1.0)
    for time in INSTANTS:
        r = _wave(speed, time, _SPARSE)
        down = np.array([solution.displacement(p * along[0], -p * along[1], np.array([time]))[0] for p in r])
        found.append(crest(r, (down * [1.0, -1.0]) @ (across if shear else along)))
    return (found[1] - found[0]) / (INSTANTS[1] - INSTANTS[0])


def _speeds(moving: dict[float, Motion]) -> Item:
    values: list[Value] = []
    for name, formula, speed, shear in (("P", "√((K + 4μ/3)/ρ)", P_SPEED, False), ("S", "√(μ/ρ)", S_SPEED, True)):
        for part, side in _SIDES.items():
            ours = _crest_speed(moving, side, speed, shear)
            values.append(Value(
                f"{name} in the {part}", f"{formula} = {speed:.0f}", ours, "m/s", paper=speed,
                loose=round(0.01 * _SPEED_READING * speed, -1), digits=4,
            ))  # fmt: skip
        values.append(Value(f"{name}’s crest in the exact solution", None, _exact_crest_speed(speed, shear), "m/s", digits=4))
    return Item(
        "P and S waves “propagate with different speeds” that follow from the elastic constants", "section 3", values,
        remark="Speed of the crest between 40 and 70 µs on a ray at 45°: of the velocity along the ray for P, across it for S.",
        reason=f"The paper gives the formulas and no measurement; we take some {_SPEED_READING:g} % for agreement. The crest "
        "of a cylindrical wave changes its shape near the source, and so is a little faster than its front: the exact solution "
        "does the same.",
    )  # fmt: skip


def _directions(last: Motion) -> Item:
    values: list[Value] = []
    for part, side in _SIDES.items():
        along, across = _ray(side)
        for name, speed, direction, words in (("P", P_SPEED, along, "along the ray"), ("S", S_SPEED, across, "across the ray")):
            r = _wave(speed, INSTANTS[-1])
            velocity = last.at(r * along[0], r * along[1])
            percent = 100.0 * float(((velocity @ direction) ** 2).sum() / (velocity**2).sum())
            values.append(Value(
                f"{name} in the {part}", words, percent, "%", paper=100.0, loose=100.0 - _MOSTLY, digits=3,
            ))  # fmt: skip
    return Item(
        "In P “the motion of particles is along the ray”, in S “perpendicular” to it", "section 3", values,
        remark="The part of the kinetic energy that is in this direction, on a ray at 45°, as long as the load has made the "
        "wave.",
        reason=f"The paper says it of the fronts; {_MOSTLY:g} % of the energy is our reading. Of a wave from near by some "
        "motion is in the other direction, and P passes into the head wave.",
    )  # fmt: skip


# -- head waves ----------------------------------------------------------------------------------------------------------

_SINE = S_SPEED / P_SPEED
# Depths at which the head wave stands free of S [m]; its first half wave is this part of its length, behind the front.
_DEPTHS, _FIRST = np.linspace(0.01, 0.05, 17), 0.6


def _head_front(depth: FloatArray) -> FloatArray:
    """Return the x of the front that theory predicts at a depth."""
    return (S_SPEED * INSTANTS[-1] - depth * math.sqrt(1.0 - _SINE * _SINE)) / _SINE


def head_wave(last: Motion, side: float) -> tuple[float, float]:
    """Return the angle between the head wave's normal and the depth [rad], and where its crest meets the surface [m]."""
    found: list[float] = []
    for depth in _DEPTHS:
        front = float(_head_front(depth))
        x = np.linspace(front - _FIRST * P_SPEED * LOAD, front, _FINE)
        # Its first half wave turns the medium towards where it goes.
        found.append(crest(x, np.minimum(side * spin(last, side * x, np.full_like(x, -depth)), 0.0)))
    slope, start = np.polyfit(_DEPTHS, found, 1)
    return math.atan2(1.0, -slope), float(start)


def _head(last: Motion) -> Item:
    values: list[Value] = []
    predicted = math.degrees(math.asin(_SINE))
    for part, side in _SIDES.items():
        angle, start = head_wave(last, side)
        values.append(Value(
            f"angle of its normal in the {part}", f"tangent to S: {predicted:.1f}", math.degrees(angle), "°", paper=predicted,
            loose=2.0, digits=3,
        ))  # fmt: skip
        behind = (P_SPEED * INSTANTS[-1] - start) / P_SPEED
        within = "at P’s exit" if 0.0 < behind < LOAD else "elsewhere"
        values.append(Value(f"where it meets the surface, {part}", "at P’s exit", within))
    return Item(
        "The conical wave’s front “stretches from the exit of P at the surface along the tangent to the front of S”",
        "section 3, figures 7 and 8", values,
        remark="From the first crest of the rate of rotation behind the front, 10 to 50 mm deep. A line that touches S and "
        "begins where P meets the surface has a normal at arcsin(c_S/c_P) to the depth. At P’s exit: not before P, nor more "
        "than the load’s 20 µs behind it.",
        reason="The paper shows it; 2° is our reading.",
    )  # fmt: skip


def _vortex(last: Motion) -> Item:
    values = [Value(f"in the {part}", "vortex", "vortex" if vortices(last, side) else "none") for part, side in _SIDES.items()]
    places = [f"x = {x:.3f} m, y = {y:.3f} m" for side in _SIDES.values() for x, y in vortices(last, side)]
    return Item(
        "“A vortex motion of particles between the fronts of the conical and the transverse waves”", "section 3", values,
        remark="A point at rest about which the velocity turns once, ahead of the middle of S and behind the front of C: "
        f"{'; '.join(places)}.",
        reason="No such point was found.",
    )  # fmt: skip


def vortices(last: Motion, side: float) -> list[tuple[float, float]]:
    """Return points between head wave and S about which the velocity turns once in the sense of its rotation."""
    x, y = np.arange(0.12, 0.26, 1e-3), np.arange(-0.16, -0.03, 1e-3)
    velocity = last.at(*np.meshgrid(side * x, y))
    angle = np.arctan2(velocity[..., 1], side * velocity[..., 0])
    corners = [angle[:-1, :-1], angle[:-1, 1:], angle[1:, 1:], angle[1:, :-1]]
    turns = sum(
        (np.diff([a, b], axis=0)[0] + math.pi) % (2.0 * math.pi) - math.pi
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    )
    found: list[tuple[float, float]] = []
    for row, column in np.argwhere(turns > math.pi):
        px, py = x[column] + 5e-4, y[row] + 5e-4
        ahead_of_s = math.hypot(px, py) > S_SPEED * (INSTANTS[-1] - 0.5 * LOAD)
        behind_c = _SINE * px - math.sqrt(1.0 - _SINE**2) * py < S_SPEED * INSTANTS[-1]
        if ahead_of_s and behind_c:
            found.append((float(side * px), float(py)))
    return found


# -- pictures ------------------------------------------------------------------------------------------------------------


def _rotation(last: Motion) -> Figure:
    return rotation(
        "figure-waves-rotation", "Rate of rotation: S, head and Rayleigh waves alone",
        "P waves do not rotate the medium, so that here the head wave (C) is seen, which in the speed of figure 7 is hidden: a "
        "straight front from where P comes out at the surface to S. Blue turns clockwise, orange against the "
        "clock.", last, Window(),
    )  # fmt: skip


def _enlarged(last: Motion) -> Figure:
    return vectors(
        "figure-waves-enlarged", "Figure 7 enlarged: between head wave and S, in the automata",
        "Between the front of the head wave and that of S the velocity turns about points at rest: the vortex of which the "
        "paper speaks.",
        last, Window(0.08, 0.38, 0.0, -0.16),
    )  # fmt: skip


ENTRY = Entry(
    "3-waves",
    "3",
    "Which waves there are",
    "A load on the surface makes longitudinal (P) and transverse (S) waves, conical or head waves (C) that join them along the "
    "surface, and the Rayleigh wave (R). The paper describes each of them in words; here is the run of figure 7, square "
    "packing.",
    compute,
    weight=6.0,
    runs=1,
)
