"""Many environments of one component and task, advanced together."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

from ..components.errors import ParameterError, one_line
from ..components.support.validation import whole_number
from ..components.variables import parse_element
from ..domains import domain_of, environments, load
from .environment import ComponentEnv, validate_actions
from .randomization import info_of_draws
from .state import COMMANDS, ELAPSED, RUNNING, EnvState
from .task import RowTask, stack_constants

Observations = npt.NDArray[np.float32]
Infos = dict[str, Any]


def make_batch(
    environment: Callable[..., ComponentEnv],
    num_envs: int = 1,
    *,
    autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    info: str = "brief",
    **arguments: Any,
) -> VectorEnv[Any, Any, Any]:
    """Return a batch of environments: native where the task judges rows, Gymnasium's `SyncVectorEnv` otherwise.

    Args:
        environment: what makes a `ComponentEnv`.
        num_envs: how many.
        autoreset_mode: any `gymnasium.vector.AutoresetMode`.
        info: "brief" or "full", as for the single environment.
        **arguments: of the single environment.
    """
    make, mode = partial(environment, info=info, **arguments), AutoresetMode(autoreset_mode)
    first = make()
    if isinstance(first.task, RowTask):
        return ComponentVectorEnv(first, num_envs, autoreset_mode=mode)
    return SyncVectorEnv([make] * whole_number("num_envs", num_envs), autoreset_mode=mode)


class ComponentVectorEnv(VectorEnv[Observations, npt.NDArray[np.float32], np.ndarray]):
    """Many environments whose task judges rows side by side, advanced by one call of compiled code.

    `gymnasium.make_vec("granular_env/Protection-v1", num_envs=256)` makes one. It gives what `SyncVectorEnv` of the single
    environment gives, bit for bit: observations, rewards, ends and infos. Environment i is the single one reset with seed + i.
    `copy.deepcopy`, pickle and cloudpickle give an independent batch that continues with the same bits.

    Args:
        environment: all are like this one, which becomes the first; its task is a `RowTask`.
        num_envs: how many.
        autoreset_mode: any `gymnasium.vector.AutoresetMode`. With `DISABLED`, `reset(options={"reset_mask": mask})` resets
            those that have ended.
    """

    def __init__(
        self,
        environment: ComponentEnv,
        num_envs: int = 1,
        *,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    ) -> None:
        self.num_envs, self.autoreset_mode = whole_number("num_envs", num_envs), AutoresetMode(autoreset_mode)
        self.render_mode = environment.render_mode
        self.metadata = {**environment.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = environment.action_space, environment.observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._begun = False
        self._gather([environment, *(environment.twin() for _ in range(self.num_envs - 1))])

    def _gather(self, singles: list[ComponentEnv]) -> None:
        """Let the memories of the environments, and their components, lie in arrays of the batch."""
        first = singles[0]
        self._singles, self._task = singles, cast(RowTask, copy.copy(first.task))
        self._memories = np.stack([one.memory for one in singles])
        self._commands = self._memories[:, COMMANDS:]
        # Every counter is a column.
        self._counters = np.zeros((len(self._task.counter_names), self.num_envs))
        self._rows: Any = domain_of(first.component.name).load("rows")([one.component for one in singles], together=True)
        for k, one in enumerate(singles):
            one.memory, one.component = self._memories[k], self._rows.components[k]
            one.bind()
        self._take_back(range(self.num_envs))
        self._stack()

    def _stack(self) -> None:
        """Lay the numbers of the tasks side by side, which depend on the component."""
        tasks = [cast(RowTask, one.task) for one in self._singles]
        self._constants = stack_constants([task.constants for task in tasks])
        self._goal_scales = np.array([task.goal_scales for task in tasks], dtype=np.float64)

    def _one(self, k: int) -> ComponentEnv:
        """Return environment k as the batch has left it."""
        self._rows.hand_out(k)
        one = self._singles[k]
        one.task.counters = dict(zip(self._task.counter_names, self._counters[:, k].tolist(), strict=True))
        return one

    def _take_back(self, numbers: Iterable[int]) -> None:
        """Continue from what environments did one by one: they were reset or restored, and may have another component."""
        drawn = False
        for k in numbers:
            one = self._singles[k]
            if one.component is not self._rows.components[k]:
                one.component, drawn = self._rows.adopt(k, one.component), True
                one.bind()
            self._rows.take_back(k)
            self._counters[:, k] = [one.task.counters.get(name, 0.0) for name in self._task.counter_names]
        if drawn:
            self._stack()

    def __getstate__(self) -> dict[str, Any]:
        """Keep the single environments, from which `_gather` makes the rest."""
        singles = [self._one(k) for k in range(self.num_envs)]
        made = ("_task", "_memories", "_counters", "_commands", "_rows", "_constants", "_goal_scales")
        return {name: value for name, value in vars(self).items() if name not in made} | {"_singles": singles}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._gather(self._singles)

    # -- Gymnasium --------------------------------------------------------------------------------------------------

    def reset(  # type: ignore[override]
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, Infos]:
        """Start episodes in all environments, or in those of `options["reset_mask"]`; other options are start values.

        Args:
            seed: environment i gets seed + i, or the i-th of a list.
            options: as for the single environment.

        Raises:
            ParameterError: a seed, an option or the mask is not valid.
        """
        seeds = [None if seed is None else seed + k for k in range(self.num_envs)] if np.ndim(seed) == 0 else list(seed)  # type: ignore
        if len(seeds) != self.num_envs:
            raise ParameterError(f"got {len(seeds)}", expected=f"a whole number, or {self.num_envs} in a list", at="seed")
        given = dict(options or {})
        mask = np.asarray(given.pop("reset_mask", np.ones(self.num_envs, np.bool_)))
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            expected = f"{self.num_envs} truth values in an array"
            raise ParameterError(f"got {one_line(mask)}", expected=expected, at="options.reset_mask")
        chosen = np.flatnonzero(mask).tolist()
        for k in chosen:
            self._singles[k].reset(seed=seeds[k], options=given)
        self._take_back(chosen)
        self._begun = True
        return self._observations(), self._infos(mask)

    def step(self, actions: npt.ArrayLike) -> tuple[Observations, np.ndarray, np.ndarray, np.ndarray, Infos]:
        """Advance all environments by one action; those that have ended are treated as `autoreset_mode` says.

        Raises:
            ParameterError: the actions are none, or an environment's episode is over with autoreset disabled.
        """
        wished = validate_actions(actions, cast(tuple[int, ...], self.action_space.shape), "actions")
        if not self._begun:
            raise ParameterError("no episode has begun", hint="call reset() first", at="step")
        begin = self._memories[:, RUNNING] == 0.0
        if begin.any() and self.autoreset_mode == AutoresetMode.DISABLED:
            over = np.flatnonzero(begin).tolist()
            came = f"the episodes of environments {one_line(over)} are over, and autoreset is disabled"
            raise ParameterError(came, hint='call reset(options={"reset_mask": mask}) first', at="step")
        rewards, terminated, truncated, errors = self._advance(wished, ~begin)
        observations, final = self._observations(), Infos()
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            ended = terminated | truncated
            for k in np.flatnonzero(ended).tolist():
                info = {**self._one(k).observe()[1], **errors.pop(k, {})}
                final = self._add_info(final, {"final_obs": observations[k].copy(), "final_info": info}, k)
            begin = begin | ended
        renewed = np.flatnonzero(begin).tolist()
        for k in renewed:
            observations[k], _ = self._singles[k].reset()
        self._take_back(renewed)
        infos = {**final, **self._infos()}
        for k, error in errors.items():
            infos = self._add_info(infos, error, k)
        return observations, rewards, terminated, truncated, infos

    def _advance(self, wished: np.ndarray, moving: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, dict[int, Infos]]:
        """Act, advance and judge as `ComponentEnv.step` does, with the same bits; return also the errors of refused steps."""
        first, memories = self._singles[0], self._memories
        rewards, over, late = np.zeros(self.num_envs), np.zeros_like(moving), np.zeros_like(moving)
        errors: dict[int, Infos] = {}
        for _ in range(first.hold):
            commands = first.actuator.act(wished, self._commands)
            refused = self._rows.advance(first.actuator.inputs(commands), first.internal_steps, moving)
            for k, message in refused.items():
                errors[k], over[k], moving[k] = {"step_error": message}, True, False
                rewards[k] += first.step_error_reward
            memories[:, ELAPSED] += moving
            counters = self._named_counters()
            gains, done = self._task.judge_rows(self._rows, self._constants, counters, memories[:, ELAPSED])
            self._commands[moving] = commands[moving]
            for column, name in zip(self._counters, counters, strict=True):
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

    def render(self) -> tuple[Any, ...] | None:
        """Return the present state of each environment as a picture; None without a render mode."""
        return None if self.render_mode is None else self.call("render")

    def call(self, name: str, *arguments: Any, **keywords: Any) -> tuple[Any, ...]:
        """Return an attribute of every environment, or the result of its call; for what changes no environment."""
        found = [getattr(self._one(k), name) for k in range(self.num_envs)]
        return tuple(each(*arguments, **keywords) if callable(each) else each for each in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of every environment."""
        return self.call(name)

    # -- mid-episode ------------------------------------------------------------------------------------------------

    def save(self, environments: Iterable[int] | None = None) -> list[EnvState]:
        """Return the states of the environments with these numbers, or of all; single environments understand them too."""
        return [self._one(k).save() for k in self._numbers(environments)]

    def restore(self, states: Sequence[EnvState], environments: Iterable[int] | None = None) -> None:
        """Let the environments with these numbers, or all, continue from saved states; `observe` returns what is seen.

        Raises:
            ParameterError: there are more or fewer states than environments, or one belongs to another component or task;
                nothing has changed.
        """
        numbers = self._numbers(environments)
        if len(states) != len(numbers):
            raise ParameterError(f"got {len(states)}", expected=f"{len(numbers)}, one for each environment", at="states")
        for k, state in zip(numbers, states, strict=True):
            self._singles[k].refuse_foreign(state)
            if any(not isinstance(value, float) for value in state.snapshot.inputs.values()):
                hint = "restore it in a single environment"
                raise ParameterError("an input of it follows a profile", hint=hint, at=("states", k))
        for k, state in zip(numbers, states, strict=True):
            self._singles[k].restore(state)
        self._take_back(numbers)
        self._begun = True

    def observe(self) -> tuple[Observations, Infos]:
        """Return the present observations and infos, as `reset` gives them."""
        return self._observations(), self._infos()

    # -- details ----------------------------------------------------------------------------------------------------

    def _observations(self) -> Observations:
        goals = self._counters[: self._goal_scales.shape[1]].T / self._goal_scales
        return self._singles[0].sensors.observe(self._rows.read, self._memories, goals)

    def _named_counters(self) -> dict[str, Any]:
        return dict(zip(self._task.counter_names, self._counters, strict=True))

    def _infos(self, mask: npt.NDArray[np.bool_] | None = None) -> Infos:
        """Return infos as fresh arrays, and for each which environments they are of."""
        first = self._singles[0]
        mask = np.ones(self.num_envs, np.bool_) if mask is None else mask
        shown = {"time": self._rows.time}
        for name in first.task.observations if first.info == "full" else ():
            element = parse_element(name)
            value = self._rows.read(element.name)
            shown[name] = value[:, *element.index] if element.index else value
        infos = Infos()
        for name, values in {**shown, **first.actuator.inputs(self._commands), **self._named_counters()}.items():
            infos[name], infos[f"_{name}"] = np.array(values), mask.copy()
            infos[name][~mask] = 0.0
        for k in np.flatnonzero(mask).tolist() if first.draws_component else ():
            infos = self._add_info(infos, info_of_draws(self._singles[k].drawn), k)
        return infos

    def _numbers(self, environments: Iterable[int] | None) -> list[int]:
        numbers = [whole_number("environments", k, 0, self.num_envs - 1) for k in environments or range(self.num_envs)]
        if len(set(numbers)) < len(numbers):
            raise ParameterError(f"got {one_line(numbers)}", expected="each environment once", at="environments")
        return numbers


def __getattr__(name: str) -> Any:
    """Return the batch of a registered environment, by the name of its factory: Gymnasium wants an attribute for each."""
    for one in environments().values():
        if one.entry_point.partition(":")[2] == name:
            return partial(make_batch, load(one.entry_point))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
