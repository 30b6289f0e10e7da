"""Figure 1: the pressure near the notch, of a detonation in a rigid tube."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.detonation.theory import TaylorWave
from granular_env.recording.log import Log

from .cases import MIDDLE
from .rigid_tube import front_speed, gas_tube

_PRESSURES = (80e3, 100e3, 180e3)
# Samples that numerical reaction zones take behind the front.
_BEHIND = 5


def compute(context: Context) -> Findings:
    """Run the fillings between which the experiments lie."""
    logs = {pressure: context.run(gas_tube(pressure)) for pressure in _PRESSURES}
    return Findings([_range(logs), _profile(logs)], [_figure(logs)])


def _range(logs: dict[float, Log]) -> Item:
    values: list[Value] = []
    ends = ((_PRESSURES[0], "2300", 2300.0, "2.6", 2.6), (_PRESSURES[-1], "2400", 2400.0, "6.1", 6.1))
    for pressure, speed_printed, speed, peak_printed, peak in ends:
        tube: Any = logs[pressure].rebuilt()
        values.append(Value(
            f"{pressure / 1e3:.0f} kPa: speed of the front", speed_printed, front_speed(logs[pressure]), "m/s", paper=speed,
            loose=0.03 * speed, digits=4,
        ))  # fmt: skip
        values.append(Value(
            f"{pressure / 1e3:.0f} kPa: pressure of Chapman and Jouguet", peak_printed, tube.front.burnt.pressure / 1e6, "MPa",
            paper=peak, loose=0.05 * peak, digits=4,
        ))  # fmt: skip
    return Item(
        "“The speed of the detonation varied from 2300 to 2400 m/s, and the pressure in the Chapman–Jouguet state from 2.6 to "
        "6.1 "
        "MPa”, with the initial pressure from 80 to 180 kPa", "section Results", values,
        remark="C2H4 + 3 O2 at 295 K by chemical equilibrium (GRI-Mech 3.0). The speed is measured on the front, on cells of 3 "
        "mm.",
        reason="The paper rounds the experiments’ numbers and states no error; within 3 % and 5 % we take for agreement.",
    )  # fmt: skip


def _wave(log: Log) -> TaylorWave:
    tube: Any = log.rebuilt()
    return TaylorWave(tube.front, tube.ahead, tube.gas.gamma)


def _profile(logs: dict[float, Log]) -> Item:
    values: list[Value] = []
    for pressure, log in logs.items():
        wave = _wave(log)
        times, gauges = log.series("gauge_pressure")
        late = times < MIDDLE / wave.resting_sound_speed
        passed = late & (times > MIDDLE / wave.front.speed + _BEHIND * 3e-6)
        expected = wave.at(np.full(int(passed.sum()), MIDDLE), times[passed])[2]
        gap = float(np.abs(gauges[passed, -1] - expected).max()) / wave.front.burnt.pressure
        values.append(
            Value(f"{pressure / 1e3:.0f} kPa: largest gap to Taylor’s wave, over the peak", None, 100 * gap, "%", digits=2)
        )
        values.append(Value(f"{pressure / 1e3:.0f} kPa: decay time", None, 1e6 * wave.decay_time(MIDDLE), "µs", digits=3))
    return Item(
        "“The profile of the pressure over time near the place of the notch”", "figure 1", values,
        remark="The paper prints the figure without numbers that could be read off the scan. Taylor’s wave is the exact "
        "solution "
        "for a front that starts at a closed end as it arrives at a place; from some 15 µs behind the front on.",
    )  # fmt: skip


def _figure(logs: dict[float, Log]) -> Figure:
    curves: list[Curve] = []
    for number, (pressure, log) in enumerate(logs.items()):
        times, gauges = log.series("gauge_pressure")
        wave = _wave(log)
        arrival = MIDDLE / wave.front.speed
        shown = (times > arrival - 5e-5) & (times < arrival + 3e-4)
        exact = wave.at(np.full(int(shown.sum()), MIDDLE), times[shown])[2]
        curves.append(Curve(f"{pressure / 1e3:.0f} kPa", times[shown] * 1e6, gauges[shown, -1] / 1e6, "line", number))
        curves.append(Curve("Taylor’s wave" if number == 0 else "", times[shown] * 1e6, exact / 1e6, "dashed", 5))
    return Figure(
        "figure-1", "Figure 1: pressure at the middle of the notch over time",
        "The front arrives as a jump to the pressure behind it; then the gas expands to that at rest. Dashed: the exact "
        "solution "
        "for a front that starts at full speed at the closed end.",
        Axis("time, µs"), Axis("pressure, MPa", 0.0), curves,
    )  # fmt: skip


ENTRY = Entry(
    "figure-1",
    "Results",
    "Figure 1: a detonation in a rigid tube",
    "First the gas alone: C2H4 + 3 O2 in a tube that does not give way. The pressure near the notch then loads the wall.",
    compute,
    weight=6.0,
    runs=3,
)
