"""The plastic step of a cell in plane strain, for one or several materials.

The laws form a nested list of named tuples, so that their types decide which code is compiled. A material that yields is a
`YieldingEntry`, an elastic one before it an `ElasticEntry`. `NoYield` at the end represents all materials after the last that
yields.
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
    """The end of the list: no further material yields."""


class ElasticEntry(NamedTuple):
    """A material that does not yield, and the rest of the list."""

    others: Any


class YieldingEntry(NamedTuple):
    """The law of a material that yields, and the rest of the list."""

    law: Any
    others: Any


class CellStep(NamedTuple):
    """An elastic step of a cell.

    Attributes:
        moduli: Lame's constants [Pa].
        plastic_strain: equivalent, before the step.
        area: at mid-step [m2].
        old: stress before the step, rotated [Pa].
        trial: trial stress after the step [Pa].
    """

    moduli: Any
    plastic_strain: float
    area: float
    old: PlaneTensor
    trial: PlaneTensor


class PlasticStep(NamedTuple):
    """The stress after the plastic return of a step.

    Attributes:
        stress: xx, yy, zz, xy [Pa].
        strain: equivalent plastic strain of the step.
        work: plastic work [J].
        kept: factor of the trial deviator, 1 without plastic flow.
        equivalent: of the trial stress [Pa].
        limit: yield stress [Pa].
    """

    stress: PlaneTensor
    strain: float
    work: float
    kept: float
    equivalent: float
    limit: float


def law_list(laws: Sequence[PlasticLaw]) -> Any:
    """Return the laws of the materials for kernels."""
    found: Any = NoYield()
    for constants in reversed([law.constants() for law in laws]):
        if constants is not None:
            found = YieldingEntry(constants, found)
        elif found != NoYield():
            found = ElasticEntry(found)
    return found


@dispatch_by_class
def plastic_step(laws, material, step):
    """Return the `PlasticStep` of a cell for its `CellStep`; the number of the material starts from 0."""


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
        return yield_cell(laws.law, step)
    return plastic_step(laws.others, material - 1, step)


@internal
def yield_cell(law, step):
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
    # The mean of the stress before and after the step does the work, on the deviatoric plastic strain and on the dilation.
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
