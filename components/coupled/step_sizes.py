"""The step of a coupled body and the micro-steps of the automata in it: chosen, or refused where they are not stable."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..errors import ParameterError
from ..support.roots import round_down_to_125
from ..support.stable_step import ALLOWED, SUGGESTED
from .parameters import CoupledParameters

# The part of the largest stable step that is allowed, and the part that is suggested, for the grid where automata make several
# steps in one of it.
_ALLOWED_IMPULSES, _SUGGESTED_IMPULSES = 0.44, 0.35
# The same for the step of the grid in largest stable ones of the automata: kicks that come each time a mode of the automata has
# passed through a multiple of half its period feed that mode. Measured with noise, an inclusion, n = 2 to 8 and stiffnesses
# up to 20 to 1: 3000 steps gain at most 5 % up to 2.4, and without bound from 2.6 on.
_ALLOWED_KICK, _SUGGESTED_KICK = 2.4, 2.35


class StepSizes(NamedTuple):
    """The steps of both parts.

    Attributes:
        step: of the grid, and of the whole [s].
        micro: how many the automata make in it.
        grid_part: the step in largest stable ones of the grid.
        automata_part: the micro-step in largest stable ones of the automata.
    """

    step: float
    micro: int
    grid_part: float
    automata_part: float


def choose_steps(parameters: CoupledParameters, grid_limit: float, automata_limit: float) -> StepSizes:
    """Return the steps that are given, and those that fit where none are.

    Args:
        parameters: of the coupled body.
        grid_limit: the largest stable step of the grid [s].
        automata_limit: that of the automata [s].

    Raises:
        ParameterError: the step that is given is not stable.
    """
    given = parameters.step_size
    micro = parameters.micro_steps or _micro_steps_needed(given, grid_limit, automata_limit)
    together = micro == 1 or parameters.scheme == "literal"
    allowed, suggested = (ALLOWED, SUGGESTED) if together else (_ALLOWED_IMPULSES, _SUGGESTED_IMPULSES)
    allowed_kick, suggested_kick = (math.inf, math.inf) if together else (_ALLOWED_KICK, _SUGGESTED_KICK)
    suggestion = min(suggested * grid_limit, min(SUGGESTED * micro, suggested_kick) * automata_limit)
    step = round_down_to_125(suggestion) if given is None else given
    largest = min(allowed * grid_limit, min(ALLOWED * micro, allowed_kick) * automata_limit)
    if step > largest:
        chosen = f" with micro_steps = {micro}" if parameters.micro_steps is not None else ""
        several = "" if together else f" and {allowed_kick:g} in the whole step"
        raise ParameterError(
            f"got {step:g} s{chosen}",
            expected=(
                f"at most {largest:.6g} s: {allowed:g} of the largest stable one of the grid, {grid_limit:.6g} s, "
                f"and of that of the automata, {automata_limit:.6g} s, {ALLOWED:g} in each micro-step{several}"
            ),
            hint="leave it out, or change micro_steps",
            at="step_size",
        )
    return StepSizes(step, micro, step / grid_limit, step / (micro * automata_limit))


def _micro_steps_needed(step: float | None, grid_limit: float, automata_limit: float) -> int:
    """Return how many micro-steps of the automata a step of the grid holds; 1 where they are about as large."""
    if step is not None:
        return max(math.ceil(min(step / automata_limit, _ALLOWED_KICK) / ALLOWED), 1)
    step = min(_SUGGESTED_IMPULSES * grid_limit, _SUGGESTED_KICK * automata_limit)
    return max(math.ceil(step / (SUGGESTED * automata_limit)), 1)
