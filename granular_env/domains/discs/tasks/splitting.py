"""Splitting-v1: break a row of discs at a given link and at no other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np

from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import finite_number, positive_number, whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import Options, environment_factory, refuse_early_deadline
from granular_env.envs.policies import Constant, OpenLoop, Policy
from granular_env.envs.task import Seen, Task

# Duration of the pulses of the "theory" drive, over a wave's travel time from disc to disc.
_PULSE_LENGTH = 4.0


class SplittingTask(Task):
    """Break a given link of a row of discs, and no other. See `make_splitting`.

    Args:
        discs: the component with the row of discs.
        target: number of the link to break.
        force_scale: force on an end disc at action 1 [N].
        work_price: cost, in reward, of an amount of work equal to the energy of a link at breaking.
        control_step: length of a control step [s].
    """

    name = "splitting"

    def __init__(self, discs: Discs, target: int, force_scale: float, work_price: float, control_step: float) -> None:
        p = discs.parameters
        self.actions = {"force[0,0]": force_scale, "force[-1,0]": force_scale}
        self.observations = {"displacement": p.breaking_strain * 2.0 * p.radius, "velocity": 0.25, "linked": 1.0}
        self.target, self._limit = target, p.breaking_strain * 2.0 * p.radius
        self._strength, self._price = p.stiffness * self._limit, work_price / (0.5 * p.stiffness * self._limit**2)
        # A wave passes one link, of length 2 r, in this time: long waves run at the speed 2 r sqrt(k / m).
        self._disc_time, self._control_step, self._links = math.sqrt(p.mass / p.stiffness), control_step, p.columns - 1

    def begin_episode(self, component: Component, outputs: Seen) -> None:
        """Set closeness and wrong links to 0, and the work to that done so far."""
        self.counters = {"closeness": 0.0, "wrong_links": 0.0, "work": component.get("input_work")}

    def evaluate_step(self, component: Component, outputs: Seen, duration: float) -> tuple[float, bool]:
        """Return the increase of "closeness" minus 1 per wrong broken link minus the work's cost; end with the target link."""
        linked, along = outputs["linked"], outputs["displacement"][:, 0]
        is_split = bool(linked[self.target] == 0.0)
        lengthening = 1.0 if is_split else min(float(along[self.target + 1] - along[self.target]) / self._limit, 1.0)
        before = dict(self.counters)
        self.counters = {
            "closeness": max(before["closeness"], lengthening),
            "wrong_links": float(np.count_nonzero(linked == 0.0)) - is_split,
            "work": component.get("input_work"),
        }
        gain, wrong, work = (self.counters[name] - before[name] for name in self.counters)
        return gain - wrong - self._price * work, is_split

    def colours(self, component: Component) -> Mapping[str, FloatArray]:
        """Return the tension of each link over that at which it breaks; the discs are grey."""
        return {"discs": np.zeros(self._links + 1), "links": -component.get("link_force") / self._strength}

    def baselines(self) -> Mapping[str, Policy]:
        """Return the policies "nothing" and "theory"; the latter pulls both ends so that the pulses meet at the target link."""
        return {"nothing": Constant([0.0, 0.0]), "theory": OpenLoop(self._theory_drive())}

    def _theory_drive(self) -> np.ndarray:
        """Return the actions of both ends: half sines, delayed at the end nearer to the target; shape (control steps, 2)."""
        ways = np.array([self.target + 0.5, self._links - self.target - 0.5])
        starts, length = (ways.max() - ways) * self._disc_time, _PULSE_LENGTH * self._disc_time
        times = (np.arange(math.ceil((starts.max() + length) / self._control_step)) + 0.5) * self._control_step
        phase = (times[:, None] - starts) / length
        return np.where((phase > 0.0) & (phase < 1.0), np.sin(np.pi * np.clip(phase, 0.0, 1.0)), 0.0) * [-1.0, 1.0]


@environment_factory
def make_splitting(
    columns: int = 10,
    target: int = 2,
    *,
    breaking_strain: float = 0.01,
    force_scale: float = 1.5,
    work_price: float = 0.1,
    step_size: float = 5e-5,
    discs: Mapping[str, Any] | None = None,
    **options: Unpack[Options],
) -> ComponentEnv:
    """Pull at both ends of a row of linked discs so that it breaks at a given link and at no other.

    The ends are pulled with less force than a link carries. A tensile pulse travels from each end into the row, and the two
    pulses together can break the link at which they meet.

    ## Action space
    The force on the first and on the last disc along x.

    ## Observation space
    For each link 1 if intact, 0 if broken. Counters: "closeness", "wrong_links" (other broken links) and "work" [J].

    ## Rewards
    "closeness" is the largest elongation of the target link up to now over its breaking elongation; it is 1 once the link has
    broken. The reward of a step is its gain in closeness, minus 1 for each other link that broke, minus `work_price` times
    the work of the forces over the energy of a link at breaking.

    ## Start state
    All discs at rest, all links intact.

    ## End of the episode
    Terminated when the target link breaks. Truncated after `deadline` control steps.

    ## Arguments
    * `columns` (10): discs in the row. `target` (2): number of the target link; 0 is between the first two discs.
    * `breaking_strain` (0.01): of a link, which then carries 2 N. `force_scale` (1.5 N): force at action 1. `work_price` (0.1).
    * `step_size` (5e-5 s): internal step of the component. A wave travels from disc to disc in 1 ms.
    * `discs`: further parameters of the component, e.g. `{"stiffness": 2e4}`.

    ## Baselines
    "theory" pulls with a half sine at each end, timed so that the pulses meet at the target link; it returns 0.587. The
    study `splitting` finds drives that return 0.85.
    """
    parameters = {"rows": 1, "columns": columns, "breaking_strain": breaking_strain, "step_size": step_size}
    component = Discs(**{**parameters, **(discs or {})})
    if component.parameters.rows != 1:
        raise ParameterError(f"got {component.parameters.rows}", expected="1, a single row to split", at=("discs", "rows"))
    links = len(component.get("linked"))
    if links < 2:
        raise ParameterError(f"got {one_line(columns)}", expected="at least 3 discs, which have 2 links", at="columns")
    target = whole_number("target", target, 0, links - 1)
    settings: dict[str, Any] = {"internal_steps": 4, "deadline": 60, **options}
    control_step, deadline = (
        whole_number("internal_steps", settings["internal_steps"]) * component.step_size,
        settings["deadline"],
    )
    scale, price = positive_number("force_scale", force_scale), finite_number("work_price", work_price)
    if price < 0.0:
        raise ParameterError(f"got {price:g}", expected="0 or more", at="work_price")
    if deadline is not None:
        ways = min(target + 0.5, links - target - 0.5) * math.sqrt(component.parameters.mass / component.parameters.stiffness)
        why = f"a wave takes {ways:.3g} s from the nearer end to link {target}"
        refuse_early_deadline(whole_number("deadline", deadline), math.ceil(ways / control_step), control_step, why)
    return ComponentEnv(component, SplittingTask(component, target, scale, price, control_step), **settings)
