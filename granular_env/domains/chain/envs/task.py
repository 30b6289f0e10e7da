"""A task on a chain whose judgement is compiled, so that one environment and a native batch of them run the very same code."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, ClassVar

import numpy as np
from numpy.random import Generator

from granular_env.components.chain import Chain
from granular_env.components.chain.objective import Objective
from granular_env.components.component import Component
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import JIT, jit
from granular_env.envs.task import Seen, Task, no_objective

# The table (`components.chain.layout`), the counters, the task's constants.
BEGIN = "void(float64[:, ::1], float64[::1], float64[::1])"
# The table, the inputs applied (left, right), the counters, the constants, the control step's length, control steps done,
# the deadline.
JUDGE = "Tuple((float64, boolean))(float64[:, ::1], float64[::1], float64[::1], float64[::1], float64, int64, int64)"


class ChainTask(Task):
    """Base of every task on a chain; `ChainEnv` and `ChainVectorEnv` run it.

    A subclass sets `actions` (which inputs of the chain it drives), `observations` (the scales of "displacement" [m] and
    "velocity" [m/s]), `constants` and `counter_names`, and gives two functions made with
    `granular_env.components.support.jit.jit`. They may call jitted functions of any module and refer to globals; an edit of
    these, or another value, is noticed. Within a process a global must keep its value: numbers that vary are `constants`.

    Attributes:
        counter_names: what the counters hold, in order; each is shown in ``info``.
        constants: numbers for both kernels.
        observed_force: force observed as 1 by sensors of force [N].
        hold: control steps for which an action is held; the environment sets it, and `baselines` act for so long.
        goal_scales: of a goal that is drawn for each episode: what of each of its numbers is observed as 1, behind the
            readings. The goal itself is in the first counters, whose names come first in `counter_names`.
        begin_kernel: begin(a, counters, constants), at the start of an episode; the counters are 0 before, but for
            a goal.
        judge_kernel: judge(a, inputs, counters, constants, duration, elapsed, steps) -> (reward, done), after each control
            step. `inputs`, shape (2,), are what was applied left and right [N or m/s], `duration` is the control step's
            length [s], `elapsed` counts the control steps done, this one included, `steps` is the deadline (0: none).
    """

    counter_names: tuple[str, ...] = ()
    constants: FloatArray = np.zeros(1)
    observed_force: float = 1000.0
    goal_scales: tuple[float, ...] = ()
    hold: int = 1
    begin_kernel: ClassVar[Callable[..., Any]]
    judge_kernel: ClassVar[Callable[..., Any]]

    def goal(self, random: Generator) -> FloatArray:
        """Return the goal of an episode, as many numbers as `goal_scales`; drawn after `start`."""
        return np.zeros(0)

    def given_goal(self, given: Any) -> FloatArray:
        """Return the goal that `reset(options={"goal": ...})` asks for, in the form of `goal`.

        Raises:
            ParameterError: it is no goal, or this task has none.
        """
        raise ParameterError(f"task {self.name!r} draws no goal, and takes none", at="options.goal")

    def objective(self, chain: Chain, steps: int) -> Objective:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Return the smooth counterpart of minus the return, for gradients.

        A task may have keyword arguments of its own behind these two, with defaults: a study gives them in stages, such as
        `way` and `sharpness`. One that draws goals has `goal`, and is given that of the episode.

        Raises:
            ParameterError: this task has none.
        """
        raise no_objective(self)

    def wanted_velocity(self, elapsed: int, counters: FloatArray) -> FloatArray | None:
        """Return the velocity that each grain should have now, for pictures, shape (grains,) [m/s]; None where none is wanted.

        Args:
            elapsed: control steps done.
            counters: the present ones, the goal first.
        """
        return None

    # What `Task` asks for is done by the kernels.

    def begin(self, component: Component, seen: Seen) -> None:
        """Do nothing: `begin_kernel` is used in its place."""

    def judge(self, component: Component, seen: Seen, duration: float) -> tuple[float, bool]:
        """Do nothing: `judge_kernel` is used in its place."""
        raise ParameterError(f"task {self.name!r} is judged by compiled code", hint="make its environment with ChainEnv")


def task_kernel(task: ChainTask, name: str) -> Callable[..., Any]:
    """Return a task's begin_kernel or judge_kernel, jitted; a plain function is jitted here, once.

    Raises:
        ParameterError: there is none, or it was given to the task itself, not to its class.
    """
    if name in vars(task):
        raise ParameterError(
            f"task {task.name!r}: {name} was set on the task itself",
            expected=f"it in the body of {type(task).__name__}",
            hint="give numbers that vary as constants, and another judgement as another class",
        )
    function = getattr(type(task), name, None)
    if not callable(function):
        raise ParameterError(f"task {task.name!r}: it has no {name}", hint="give it a jitted function, see ChainTask")
    return function if hasattr(function, "compile") or not JIT else _compile(function)


@cache
def _compile(function: Callable[..., Any]) -> Callable[..., Any]:
    return jit(function)
