"""Section 3.2 A, its end: a heavy striker's waves and a rigid wall."""

from __future__ import annotations

from granular_env import measurement
from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.measurement import History

from .cases import MASS, SPEED, case, grain
from .drawn import TIME, velocity_of

_WAVES = 0.05 * SPEED
# At the wall the first wave turns round; the last one has passed grain 60 in a chain of double length.
_FREE = 160


def compute(context: Context) -> Findings:
    """Six waves of a striker of five masses; their return."""
    wall = case(context, "3.2-wall-striker")
    strikers = {mass: _long(context, mass) for mass in (4, 5, 6)}
    return Findings([_count(context, strikers), _reflected(context, wall)], [_figure(context, wall, strikers[5])])


def _long(context: Context, masses: int) -> History:
    """In a chain so long that nothing comes back to grain 60 before all waves have passed."""
    return case(
        context, "3.2-wall-striker", component__grains=_FREE, component__right="free", component__mass={"0": masses * MASS},
        name=f"nesterenko-1983/3.2-striker-{masses}m",
    )  # fmt: skip


def _count(context: Context, strikers: dict[int, History]) -> Item:
    found = {mass: measurement.waves_at(chain, grain(context, 60), _WAVES) for mass, chain in strikers.items()}
    heights = ", ".join(f"{wave.amplitude / SPEED:.4f}" for wave in found[5])
    values = [Value("5 masses", "6", len(found[5])), Value("their v_m/v0", None, heights)]
    values += [Value(f"{mass} masses", None, str(len(found[mass]))) for mass in (4, 6)]
    return Item(
        "Number of waves of a heavy striker", "section 3.2 A", values,
        remark="At grain 60, above 0.05 v0. “A piston of 5 t” is one of five grain masses (5m): only that makes six waves.",
    )  # fmt: skip


def _reflected(context: Context, wall: History) -> Item:
    """The tallest wave before and after the wall, at a grain that it passes between other waves."""
    place = grain(context, 60)
    before = measurement.waves_at(wall, place, 0.5 * SPEED)[0]
    after = measurement.waves_at(wall, place, 0.5 * SPEED, direction="left")[0]
    change = 100.0 * (after.amplitude / before.amplitude - 1.0)
    return Item(
        "The wall throws the waves back with their form kept", "section 3.2 A",
        [Value("change of the first wave’s v_m", "unchanged", change, "%", paper=0.0, tolerance=0.1, loose=5.0)],
        remark="At grain 60 on the way there and back.",
        reason="On its way back it has passed waves that still came, and each passage costs a little height, as in the head-on "
        "collision.",
    )  # fmt: skip


def _figure(context: Context, wall: History, free: History) -> Figure:
    curves = [
        velocity_of(free, grain(context, 60), "long chain", 0, SPEED, "dashed"),
        velocity_of(wall, grain(context, 60), "wall after grain 80", 1, SPEED),
    ]
    return Figure(
        "figure-wall", "Grain 60, struck by five grain masses",
        f"{len(measurement.waves_at(free, grain(context, 60), _WAVES))} waves, the tallest in front. With a rigid wall after "
        "grain 80 the first ones come back before the last have passed.",
        Axis(TIME), Axis("v / v0"), curves,
    )  # fmt: skip


ENTRY = Entry(
    "3.2-wall",
    "3.2 A",
    "A heavy striker’s waves and a wall",
    "A striker of five grain masses hits a chain of 80 grains at 5 m/s that ends at a rigid wall.",
    compute,
    weight=2.0,
)
