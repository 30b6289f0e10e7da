"""The plastic step of a cell in plane strain, for one or several materials.

The laws form a linked list of named tuples (law, rest of the list), so that their types decide which code is compiled. Its
entries are the materials by number: `YieldingEntry` or `ElasticEntry`. The end, `NoYield`, stands for all materials after the
last one that yields.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Any, NamedTuple

from ..materials.hypoelastic import PlaneTensor
from ..materials.plastic_law import PlasticLaw, return_stress, yield_limit
from ..support.dispatch import dispatch_by_class
from ..support.jit import internal


class NoYield(NamedTuple):
    """The end of the list of laws: all materials not listed before it are elastic."""


class ElasticEntry(NamedTuple):
    """The list of laws from a material that does not yield on: `others` is the list for the next materials."""

    others: Any


class YieldingEntry(NamedTuple):
    """The list of laws from a material that yields on: its law, and the list `others` for the next materials."""

    law: Any
    others: Any


class CellStep(NamedTuple):
    """A step of a cell as if it were elastic.

    Attributes:
        moduli: Lame's constants [Pa].
        plastic_strain: equivalent plastic strain before the step.
        area: area of the cell at mid-step [m2].
        old: stress before the step, rotated with the cell [Pa].
        trial: stress after the step if it is elastic [Pa].
    """

    moduli: Any
    plastic_strain: float
    area: float
    old: PlaneTensor
    trial: PlaneTensor


class PlasticStep(NamedTuple):
    """The result of a step after the return of the trial stress to the yield surface.

    Attributes:
        stress: xx, yy, zz, xy [Pa].
        strain: increment of the equivalent plastic strain.
        work: plastic work of the step [J].
        kept: factor by which the deviator of the trial stress is multiplied, 1 without plastic flow.
        equivalent: equivalent (von Mises) trial stress [Pa].
        limit: yield stress [Pa].
    """

    stress: PlaneTensor
    strain: float
    work: float
    kept: float
    equivalent: float
    limit: float


def law_list(laws: Sequence[PlasticLaw]) -> Any:
    """Return the plastic laws of the materials as the list described above."""
    found: Any = NoYield()
    for constants in reversed([law.constants() for law in laws]):
        if constants is not None:
            found = YieldingEntry(constants, found)
        elif found != NoYield():
            found = ElasticEntry(found)
    return found


@dispatch_by_class
def plastic_step(laws, material, step):
    """Return the `PlasticStep` of a cell."""


@plastic_step.register(NoYield)
def _elastic_step(laws, material, step):
    return PlasticStep(step.trial, 0.0, 0.0, 1.0, 0.0, 0.0)


@plastic_step.register(ElasticEntry)
def _skip_elastic_entry(laws, material, step):
    if material == 0:
        return PlasticStep(step.trial, 0.0, 0.0, 1.0, 0.0, 0.0)
    return plastic_step(laws.others, material - 1, step)


@plastic_step.register(YieldingEntry)
def _yield_or_skip_entry(laws, material, step):
    if material == 0:
        return yielding_cell_step(laws.law, step)
    return plastic_step(laws.others, material - 1, step)


@internal
def yielding_cell_step(law, step):
    """Return the `PlasticStep` of a cell whose material can yield."""
    trial, moduli = step.trial, step.moduli
    bulk = moduli.first_lame + 2.0 * moduli.shear / 3.0
    pressure = -(trial.xx + trial.yy + trial.zz) / 3.0
    sxx, syy, szz, sxy = trial.xx + pressure, trial.yy + pressure, trial.zz + pressure, trial.xy
    q = sqrt(1.5 * (sxx * sxx + syy * syy + szz * szz + 2.0 * (sxy * sxy)))
    limit = yield_limit(law, step.plastic_strain, pressure)
    found = return_stress(law, moduli, step.plastic_strain, q, pressure)
    kept = found.equivalent / q if found.plastic_strain > 0.0 and q > 0.0 else 1.0
    gone, after = 1.0 - kept, found.pressure
    stress = PlaneTensor(kept * sxx - after, kept * syy - after, kept * szz - after, kept * sxy)
    # The plastic work is that of the mean of the old and the new stress, on the deviatoric plastic strain and on the dilation.
    old = step.old
    middle = -(old.xx + old.yy + old.zz) / 6.0 + 0.5 * after
    sheared = (
        (0.5 * (old.xx + stress.xx) + middle) * (gone * sxx)
        + (0.5 * (old.yy + stress.yy) + middle) * (gone * syy)
        + (0.5 * (old.zz + stress.zz) + middle) * (gone * szz)
        + (old.xy + stress.xy) * (gone * sxy)
    ) / (2.0 * moduli.shear)
    work = step.area * (sheared - middle * ((after - pressure) / bulk))
    return PlasticStep(stress, found.plastic_strain, work, kept, q, limit)
