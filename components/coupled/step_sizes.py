"""Choice and stability check of the step of a coupled body, in lockstep or with micro-steps of the automata.

A step h kicks with the cell forces -Kg u for h/2, lets the automata make n micro-steps, and kicks again. For a mode of the
automata with the frequency w, sin(p/2) = w h/2n and W = (n/h) sin p, n micro-steps turn u into u cos np + v sin(np)/W, and

    u(k+1) + u(k-1) = 2 (C - (h/2) S Kg) u(k),        C = cos np,  S = sin(np)/W,    functions of one matrix, M^-1 Ka.

As long as np < pi for all modes, S is positive and the matrix on the right is similar to a symmetric one. All motion is bounded
if Kg < (2/h) W cot(np/2). The bound is a concave function of w^2, from 4/h^2 at 0 to 0 at np = pi, and so lies above its chord.
With Kg <= (2/h_g)^2 M_g, Ka <= (2/h_a)^2 M_a, and M = M_g + M_a it is sufficient that

    h < h_g,        h < n sin(pi/2n) h_a,

where h_g and h_a are the largest stable steps of the two parts. Beyond the second bound, the kicks excite pairs of modes with
n(p + q) = 2 pi, in narrow windows of the step: 3e-4 per step at 1.84 h_a for a strip with two automata per cell. From about
2.5 h_a on the windows are wide.
"""

from __future__ import annotations

from typing import NamedTuple

from ..errors import ParameterError
from ..support.elementary_functions import sine_of_pi
from ..support.round_numbers import round_down_to_125
from ..support.stable_step import ALLOWED, SUGGESTED
from .parameters import CoupledParameters

# Allowed and suggested step if the automata make several steps in it, as fractions of the grid's largest stable step. With 0.44
# the energy of noise stays within 8 % of its initial value.
_ALLOWED_IMPULSES, _SUGGESTED_IMPULSES = 0.44, 0.35
# Suggested step with several micro-steps, as a fraction of the longest stable one.
_SUGGESTED_KICK = 0.85


class StepSizes(NamedTuple):
    """The steps of both parts.

    Attributes:
        step: of the grid and of the coupled body [s].
        micro: number of steps of the automata in it.
        grid_part: ratio of the step to the largest stable step of the grid.
        automata_part: ratio of the micro-step to the largest stable step of the automata.
    """

    step: float
    micro: int
    grid_part: float
    automata_part: float


def choose_steps(parameters: CoupledParameters, grid_limit: float, automata_limit: float) -> StepSizes:
    """Return the steps of both parts, given or chosen; `grid_limit` and `automata_limit` are their largest stable steps [s].

    Raises:
        ParameterError: the given step is not stable.
    """
    given, micro = parameters.step_size, parameters.micro_steps
    together = micro == 1 or parameters.scheme == "literal"
    allowed, suggested = (ALLOWED, SUGGESTED) if together else (_ALLOWED_IMPULSES, _SUGGESTED_IMPULSES)
    of_kick, suggested_kick = (ALLOWED * micro, SUGGESTED * micro) if together else _micro_step_limits(micro)
    suggestion = min(suggested * grid_limit, suggested_kick * automata_limit)
    step = round_down_to_125(suggestion) if given is None else given
    largest = min(allowed * grid_limit, of_kick * automata_limit)
    if step > largest:
        raise ParameterError(
            f"got {step:g} s with micro_steps = {micro}",
            expected=(
                f"at most {largest:.6g} s: {allowed:g} times the largest stable step of the grid, {grid_limit:.6g} s, "
                f"and {of_kick:.3g} times that of the automata, {automata_limit:.6g} s"
            ),
            hint="leave it out, or change micro_steps",
            at="step_size",
        )
    return StepSizes(step, micro, step / grid_limit, step / (micro * automata_limit))


def _micro_step_limits(micro_steps: int) -> tuple[float, float]:
    """Return the longest allowed and the suggested step with micro-steps, over the largest stable step of the automata."""
    longest = micro_steps * float(sine_of_pi(0.5 / micro_steps))
    return ALLOWED * longest, _SUGGESTED_KICK * longest
