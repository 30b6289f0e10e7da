"""The step of a coupled body and the micro-steps of the automata in it: chosen, or refused where they are not stable."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..errors import ParameterError
from ..support.roots import round_down_to_125
from ..support.stable_step import ALLOWED, SUGGESTED
from .parameters import CoupledParameters

# The part of the largest stable step that is allowed, and the part that is suggested, for the grid where automata make several
# steps in one of it: kicks that come at a multiple of the period of a mode of the automata feed that mode, the faster the
# larger they are. Measured with n = 2, 3, 4: 3000 steps of a noisy motion keep the energy to 1 % up to 0.35, to 25 % at 0.44,
# and not at all at 0.8.
_ALLOWED_IMPULSES, _SUGGESTED_IMPULSES = 0.5, 0.35


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
    suggestion = min(suggested * grid_limit, SUGGESTED * micro * automata_limit)
    step = round_down_to_125(suggestion) if given is None else given
    largest = min(allowed * grid_limit, ALLOWED * micro * automata_limit)
    if step > largest:
        chosen = "" if parameters.micro_steps is not None else ", which this step needs"
        raise ParameterError(
            f"got {step:g} s with micro_steps = {micro}{chosen}",
            expected=(
                f"at most {largest:.6g} s: {allowed:g} of the largest stable one of the grid, {grid_limit:.6g} s, and "
                f"{ALLOWED:g} of that of the automata in each micro-step, {automata_limit:.6g} s"
            ),
            hint="leave it out, or change micro_steps",
            at="step_size",
        )
    return StepSizes(step, micro, step / grid_limit, step / (micro * automata_limit))


def _micro_steps_needed(step: float | None, grid_limit: float, automata_limit: float) -> int:
    """Return how many micro-steps of the automata a step of the grid holds; 1 where they are about as large."""
    if step is not None:
        return max(math.ceil(step / (ALLOWED * automata_limit)), 1)
    step = _SUGGESTED_IMPULSES * grid_limit
    return 1 if SUGGESTED * automata_limit >= step else math.ceil(step / (SUGGESTED * automata_limit))
