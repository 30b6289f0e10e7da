"""Absorption-v0: an active right end lets as little as possible of an unknown incoming wave come back."""

from __future__ import annotations

from ...components.chain.energy_roots import energy_between, pull_energy_between
from ...components.chain.objective import Objective
from ...components.chain.table import GRAINS, SCALARS
from ...components.jit import jit
from ..chain_task import ChainTask, Policy

# Layout of the counters.
_INCOMING, _ENERGY, _RETURNED = range(3)


@jit
def _begin(a, counters, constants):
    counters[_INCOMING] = counters[_ENERGY] = energy_between(a, 1, int(a[SCALARS, GRAINS]))
    counters[_RETURNED] = 1.0 if counters[_INCOMING] > 0.0 else 0.0


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    before, incoming = counters[_RETURNED], counters[_INCOMING]
    counters[_ENERGY] = energy_between(a, 1, int(a[SCALARS, GRAINS]))
    # Where nothing comes in, what the end itself puts in counts in joules.
    counters[_RETURNED] = counters[_ENERGY] / incoming if incoming > 0.0 else counters[_ENERGY]
    return before - counters[_RETURNED], False


@jit
def _note(a, step, steps, inputs, constants, sums):
    if step == steps - 1:
        sums[0] += energy_between(a, 1, int(a[SCALARS, GRAINS])) / constants[0]


@jit
def _value(sums, constants, slopes):
    slopes[0] = 1.0
    return sums[0]


@jit
def _pull(a, bar, step, steps, inputs, input_bar, constants, slopes):
    if step == steps - 1:
        pull_energy_between(a, bar, 1, int(a[SCALARS, GRAINS]), slopes[0] / constants[0])


class AbsorptionTask(ChainTask):
    """What an active end lets come back of an unknown wave is to be little. See `AbsorptionEnv`."""

    name = "absorption"
    counter_names = ("incoming_energy", "energy", "returned")
    begin_kernel = _begin
    judge_kernel = _judge
