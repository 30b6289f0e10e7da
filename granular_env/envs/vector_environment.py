"""A batch of environments of one component and task, advanced together."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from ..components.errors import ParameterError, one_line
from ..components.support.validation import whole_number
from ..components.variables import parse_element
from ..domains import find_domain, import_object, load_environments
from .environment import ComponentEnv, validate_actions
from .randomization import sampled_parameter_info
from .state import COMMANDS, ELAPSED, RUNNING, EnvState
from .task import RowTask, stack_constants

Infos = dict[str, Any]
# Attributes that `set_attr` may change, because they may differ between the environments of a native batch.
_OWN = "np_random", "render_mode", "step_error_reward"


def make_batch(
    environment: Callable[..., ComponentEnv],
    num_envs: int = 1,
    *,
    autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    info: str = "brief",
    **arguments: Any,
) -> SyncVectorEnv:
    """Return a batch of environments: a `ComponentVectorEnv` if the task is a `RowTask`, otherwise Gymnasium's `SyncVectorEnv`.

    Args:
        environment: function that makes a `ComponentEnv`.
        num_envs: number of environments.
        autoreset_mode: any `gymnasium.vector.AutoresetMode`.
        info: "brief" or "full", as for the single environment.
        **arguments: arguments of the single environment.
    """
    make, count = partial(environment, info=info, **arguments), whole_number("num_envs", num_envs)
    first = make()
    if isinstance(first.task, RowTask):
        return ComponentVectorEnv(first, count, autoreset_mode)
    return SyncVectorEnv([make] * count, autoreset_mode=autoreset_mode)


class ComponentVectorEnv(SyncVectorEnv):
    """A native batch: environments with a `RowTask`, all advanced by one call of compiled code.

    `gymnasium.make_vec("granular_env/Protection-v1", num_envs=256)` makes one. Observations, rewards, ends and infos are
    bitwise identical to `SyncVectorEnv` of the single environment. Environment i equals the single environment reset with
    seed + i. `copy.deepcopy`, pickle and cloudpickle give an independent batch that continues with the same bits. `call` and
    `get_attr` return current environments; `envs` may be out of date. To record an environment, restore its saved state in
    a single environment.

    Args:
        environment: template of all environments, which becomes the first; its task is a `RowTask`.
        num_envs: number of environments.
        autoreset_mode: any `gymnasium.vector.AutoresetMode`. With `DISABLED`, `reset(options={"reset_mask": mask})` resets
            ended environments.
    """

    envs: list[ComponentEnv]  # type: ignore[assignment]

    def __init__(self, environment: ComponentEnv, num_envs: int, autoreset_mode: str | AutoresetMode) -> None:
        make_more = partial(copy.deepcopy, environment)
        super().__init__([lambda: environment, *[make_more] * (num_envs - 1)], autoreset_mode=autoreset_mode)
        self.env_fns = ()
        self._gather_memories()

    def _gather_memories(self) -> None:
        """Move the memories of the environments and their components into arrays of the batch."""
        first = self.envs[0]
        self._task = cast(RowTask, copy.copy(first.task))
        self._memories = np.stack([one.memory for one in self.envs])
        self._commands = self._memories[:, COMMANDS:]
        self._counters: dict[str, Any] = {name: np.zeros(self.num_envs) for name in self._task.counter_names}
        make_rows = find_domain(first.component.name).load_attribute("rows")
        self._rows: Any = make_rows([one.component for one in self.envs], is_batch=True)
        for k, one in enumerate(self.envs):
            one.memory, one.component = self._memories[k], self._rows.components[k]
            one.bind_memory()
        self._stack_constants()
        self._update_batch()

    def _stack_constants(self) -> None:
        """Stack the constants of the environments' tasks, which depend on their components, into arrays."""
        tasks = [cast(RowTask, one.task) for one in self.envs]
        self._constants = stack_constants([task.constants for task in tasks])
        self._goal_scales = np.array([task.goal_scales for task in tasks], dtype=np.float64)

    def _update_environments(self, numbers: Iterable[int] | None = None) -> list[ComponentEnv]:
        """Update environments (all by default) to the state of the batch, and return them."""
        chosen = range(self.num_envs) if numbers is None else list(numbers)
        for k in chosen:
            self._rows.update_chain(k)
            self.envs[k].task.counters = {name: column[k].item() for name, column in self._counters.items()}
        return [self.envs[k] for k in chosen]

    def _update_batch(self, numbers: Iterable[int] | None = None) -> None:
        """Update the batch from the states of its environments (all by default), whose components may have been replaced."""
        is_redrawn = False
        for k in range(self.num_envs) if numbers is None else numbers:
            one = self.envs[k]
            if one.component is not self._rows.components[k]:
                one.component, is_redrawn = self._rows.replace_chain(k, one.component), True
                one.bind_memory()
            self._rows.update_batch(k)
            for name, value in one.task.counters.items():
                self._counters[name][k] = value
        if is_redrawn:
            self._stack_constants()

    def __getstate__(self) -> dict[str, Any]:
        """Copy only the single environments, from which `_gather_memories` rebuilds the arrays of the batch."""
        self._update_environments()
        made = ("_task", "_memories", "_commands", "_counters", "_rows", "_constants", "_goal_scales")
        return {name: value for name, value in vars(self).items() if name not in made}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._gather_memories()

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[npt.NDArray[np.float32], Infos]:
        """Start episodes in all environments, or in the environments of `options["reset_mask"]`.

        Args:
            seed: environment i gets seed + i, or entry i of a list.
            options: options of the single environment's `reset`.
        """
        self._update_environments()
        _, infos = super().reset(seed=seed, options=options)
        self._update_batch()
        return self._present_observations(), infos

    def step(self, actions: npt.ArrayLike) -> tuple[npt.NDArray[np.float32], np.ndarray, np.ndarray, np.ndarray, Infos]:  # type: ignore[override]
        """Advance all environments by one action; ended environments are treated according to `autoreset_mode`.

        Raises:
            ParameterError: invalid actions, or an environment without a running episode that is not to be reset.
        """
        wished = validate_actions(actions, cast(tuple[int, ...], self.action_space.shape), "actions")
        begin = self._autoreset_envs & (self.autoreset_mode == AutoresetMode.NEXT_STEP)
        moving = self._memories[:, RUNNING] != 0.0
        if over := np.flatnonzero(~moving & ~begin).tolist():
            came = f"the episodes of environments {one_line(over)} are over or have not begun"
            raise ParameterError(came, hint="reset them first", at="step")
        rewards, terminated, truncated, errors = self._advance_environments(wished, moving)
        self._autoreset_envs = terminated | truncated
        observations, infos = self._present_observations(), Infos()
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            begin = self._autoreset_envs
            for k, one in zip(np.flatnonzero(begin).tolist(), self._update_environments(np.flatnonzero(begin)), strict=True):
                info = {**one.observe()[1], **errors.pop(k, {})}
                infos = self._add_info(infos, {"final_obs": observations[k].copy(), "final_info": info}, k)
        for k in np.flatnonzero(begin).tolist():
            observations[k], _ = self.envs[k].reset()
        self._update_batch(np.flatnonzero(begin).tolist())
        infos |= self._infos()
        for k, error in errors.items():
            infos = self._add_info(infos, error, k)
        return observations, rewards, terminated, truncated, infos

    def _advance_environments(
        self, wished: np.ndarray, moving: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, dict[int, Infos]]:
        """Advance the environments `moving`, bitwise as `ComponentEnv.step`; return rewards, terminated, truncated, errors."""
        first, memories = self.envs[0], self._memories
        rewards, over, late = np.zeros(self.num_envs), np.zeros_like(moving), np.zeros_like(moving)
        errors: dict[int, Infos] = {}
        for _ in range(first.hold):
            commands = first.actuator.next_memory(wished, self._commands)
            for k, message in self._rows.advance_chains(first.actuator.inputs(commands), first.internal_steps, moving).items():
                errors[k], over[k], moving[k] = {"step_error": message}, True, False
                rewards[k] += self.envs[k].step_error_reward
            memories[:, ELAPSED] += moving
            counters = dict(self._counters)
            gains, done = self._task.evaluate_rows(self._rows, self._constants, counters, memories[:, ELAPSED])
            np.copyto(self._commands, commands, where=moving[:, None])
            for name, column in self._counters.items():
                np.copyto(column, counters[name], where=moving)
            rewards += np.where(moving, gains, 0.0)
            over |= moving & done
            late |= moving & ~over & (memories[:, ELAPSED] >= first.deadline)
            moving = moving & ~over & ~late
            if not moving.any():
                break
        memories[over | late, RUNNING] = 0.0
        terminated = over | late if first.clock else over
        return rewards, terminated, late & ~terminated, errors

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Return an attribute of every environment, or the result of its call, as a tuple."""
        self._update_environments()
        found = super().call(name, *args, **kwargs)
        self._update_batch()
        return found

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of all environments to one value or to a list of values.

        Raises:
            ParameterError: all environments of the batch have this attribute in common, so it cannot be changed.
        """
        if name not in _OWN:
            expected = " or ".join(map(repr, _OWN))
            received = f"{one_line(name)} is common to all environments of a batch"
            raise ParameterError(received, expected=expected, hint="create another batch", at="name")
        super().set_attr(name, values)

    def render(self) -> tuple[Any, ...]:
        """Return a picture of the present state of each environment."""
        return self.call("render")

    def save(self, environments: Iterable[int] | None = None) -> list[EnvState]:
        """Return the states of the environments with these numbers, or of all; single environments also accept these states."""
        return [one.save() for one in self._update_environments(environments)]

    def restore(self, states: Sequence[EnvState], environments: Iterable[int] | None = None) -> None:
        """Continue the environments with these numbers, or all, from saved states; `observe` returns the observations.

        Raises:
            ParameterError: the numbers of states and environments differ, or a state belongs to another component or task;
                earlier states have been restored.
        """
        numbers = list(range(self.num_envs) if environments is None else environments)
        if len(states) != len(numbers):
            raise ParameterError(f"got {len(states)}", expected=f"{len(numbers)}, one for each environment", at="states")
        for k, state in zip(numbers, states, strict=True):
            self.envs[k].restore(state)
            self._update_batch([k])
            self._autoreset_envs[k] = not self._memories[k, RUNNING]

    def observe(self) -> tuple[npt.NDArray[np.float32], Infos]:
        """Return the present observations and infos, in the form returned by `reset`."""
        return self._present_observations(), self._infos()

    def _present_observations(self) -> npt.NDArray[np.float32]:
        goals = np.array([self._counters[name] for name in self._task.goal_names]).T / self._goal_scales
        return self.envs[0].sensors.make_observations(self._rows.read_output, self._memories, goals)

    def _infos(self) -> Infos:
        """Return the infos of the batch as new arrays, each with a mask of the environments that have this info."""
        first, shown = self.envs[0], {"time": self._rows.time}
        for name in first.task.observations if first.info == "full" else ():
            element = parse_element(name)
            value = self._rows.read_output(element.name)
            shown[name] = value[:, *element.index] if element.index else value
        infos = Infos()
        for name, values in {**shown, **first.actuator.inputs(self._commands), **self._counters}.items():
            infos[name], infos[f"_{name}"] = np.array(values), np.ones(self.num_envs, np.bool_)
        for k, one in enumerate(self.envs) if first.drawn else ():
            infos = self._add_info(infos, sampled_parameter_info(one.drawn), k)
        return infos


def __getattr__(name: str) -> Any:
    """Return the batch factory of a registered environment by its factory's name; Gymnasium looks for a module attribute."""
    for one in load_environments().values():
        if one.entry_point.partition(":")[2] == name:
            return partial(make_batch, import_object(one.entry_point))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
