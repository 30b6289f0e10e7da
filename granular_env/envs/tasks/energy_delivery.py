"""EnergyDelivery-v0: by the deadline a wanted energy is in the last grains; work costs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...components.chain import Chain
from ...components.chain.energy_roots import energy_between, pull_energy_between
from ...components.chain.objective import Objective
from ...components.chain.readings import input_work
from ...components.chain.table import GRAINS, SCALARS
from ...components.jit import jit
from ..chain_task import ChainTask, Policy

# Layout of the constants: the wanted energy [J], price of that much work, first grain of the target region (its column).
_ENERGY, _PRICE, _FIRST = range(3)
# Layout of the counters.
_DELIVERED, _WORK, _CLOSENESS = range(3)


@jit
def _count(a, counters, constants):
    counters[_DELIVERED] = energy_between(a, int(constants[_FIRST]), int(a[SCALARS, GRAINS]))
    counters[_WORK] = input_work(a)
    off = counters[_DELIVERED] / constants[_ENERGY] - 1.0
    counters[_CLOSENESS] = 1.0 - off * off


@jit
def _begin(a, counters, constants):
    _count(a, counters, constants)


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    closeness, work = counters[_CLOSENESS], counters[_WORK]
    _count(a, counters, constants)
    cost = constants[_PRICE] * (counters[_WORK] - work) / constants[_ENERGY]
    return counters[_CLOSENESS] - closeness - cost, False


@jit
def _note(a, step, steps, inputs, constants, sums):
    if step == steps - 1:
        n = int(a[SCALARS, GRAINS])
        sums[0] += energy_between(a, int(constants[_FIRST]), n) / constants[_ENERGY]
        sums[1] += energy_between(a, 1, n) / constants[_ENERGY]


@jit
def _value(sums, constants, slopes):
    off = sums[0] - 1.0
    slopes[0], slopes[1] = 2.0 * off, constants[_PRICE]
    return off * off + constants[_PRICE] * sums[1]


@jit
def _pull(a, bar, step, steps, inputs, input_bar, constants, slopes):
    if step == steps - 1:
        n = int(a[SCALARS, GRAINS])
        pull_energy_between(a, bar, int(constants[_FIRST]), n, slopes[0] / constants[_ENERGY])
        pull_energy_between(a, bar, 1, n, slopes[1] / constants[_ENERGY])


class EnergyDeliveryTask(ChainTask):
    """The last grains shall hold an energy at the deadline; work costs. See `EnergyDeliveryEnv`."""

    name = "energy_delivery"
    counter_names = ("delivered_energy", "work", "closeness")
    begin_kernel = _begin
    judge_kernel = _judge
