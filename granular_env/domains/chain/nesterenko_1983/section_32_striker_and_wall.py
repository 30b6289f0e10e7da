"""Section 3.2 A, its end: a heavy striker's waves and a rigid wall."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value

from ..measurement import History
from .cases import MASS, SPEED, case, change, grain
from .velocity_curves import TIME, velocity_of
from .wave_count import CLEAR, RULE, counts, heights, waves

# At the wall the first wave turns round; the last one has passed grain 60 in a chain of double length.
_FREE = 160


def compute(context: Context) -> Findings:
    """Six waves of a striker of five masses; their return."""
    wall = case(context, "3.2-wall-striker")
    strikers = {mass: _long(context, mass) for mass in (4, 5, 6)}
    return Findings([_count(context, strikers), _reflection(context, wall)], [_figure(context, wall, strikers[5])])


def _long(context: Context, masses: int) -> History:
    """Run a chain so long that nothing comes back to grain 60 before all waves have passed."""
    return case(
        context, "3.2-wall-striker", component__grains=_FREE, component__right="free", component__mass={"0": masses * MASS},
        name=f"nesterenko-1983/3.2-striker-{masses}m",
    )  # fmt: skip


def _count(context: Context, strikers: dict[int, History]) -> Item:
    place = grain(context, 60)
    values = counts("5 masses", "6", strikers[5], place)
    values.append(Value("their v_m/v0", None, heights(waves(strikers[5], place), SPEED)))
    for mass in (4, 6):
        values += counts(f"{mass} masses", None, strikers[mass], place)
    return Item(
        "Number of waves of a heavy striker", "section 3.2 A", values,
        remark="At grain 60 of a chain so long that nothing comes back. “A piston of 5 t” is read as one of five grain masses, "
        f"5m. {RULE}",
        reason="Behind the sixth wave come lower and lower ones without an end; how many are counted hangs on the least "
        "height. The paper’s six are those of 5m above 5 %, which neither 4m nor 6m gives; above 2 % none of the three "
        "gives six.",
    )  # fmt: skip


def _reflection(context: Context, wall: History) -> Item:
    """Return the tallest wave before and after the wall, at a grain that it passes between other waves."""
    place = grain(context, 60)
    before, after = waves(wall, place)[0], waves(wall, place, direction="left")[0]
    percent = 100.0 * (after.amplitude / before.amplitude - 1.0)
    return Item(
        "The wall throws the waves back with their form kept", "section 3.2 A",
        [change("change of the first wave’s v_m", "unchanged", percent)],
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
        f"{len(waves(free, grain(context, 60), CLEAR))} waves above 5 % of the tallest, which is in front. With a rigid wall "
        "after grain 80 the first ones come back before the last have passed.",
        Axis(TIME), Axis("v / v0"), curves,
    )  # fmt: skip


ENTRY = Entry(
    "3.2-wall",
    "3.2 A",
    "A heavy striker’s waves and a wall",
    "A striker of five grain masses hits a chain of 80 grains at 5 m/s that ends at a rigid wall.",
    compute,
    weight=0.7,
    runs=4,
)
