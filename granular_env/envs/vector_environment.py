"""Many environments of one component and task, advanced together."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, cast

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

from ..components.component import Component
from ..components.errors import ParameterError, nearest, one_line
from ..components.support.validation import whole_number
from ..components.variables import parse_element
from ..domains import domain_of, environments, load
from .environment import COMMANDS, ELAPSED, RUNNING, SEED, ComponentEnv, validate_options, validate_seed
from .randomization import info_of_draws
from .state import EnvState
from .task import RowTask, refuse_infinite, stack_constants

Observations = npt.NDArray[np.float32]
# Attributes that may be set while the batch lives.
_SETTABLE = ("np_random", "render_mode", "step_error_reward")


def make_batch(
    environment: Callable[..., ComponentEnv],
    num_envs: int = 1,
    *,
    autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    max_episode_steps: int | None = None,
    info: str = "brief",
    **arguments: Any,
) -> VectorEnv[Any, Any, Any]:
    """Return a batch of environments: native where the task judges rows, Gymnasium's `SyncVectorEnv` otherwise.

    Args:
        environment: what makes a `ComponentEnv`.
        num_envs: how many.
        autoreset_mode: any `gymnasium.vector.AutoresetMode`.
        max_episode_steps: actions after which an episode is truncated, as by Gymnasium's `TimeLimit`; None or -1 for no other
            end than the environment's own `deadline`.
        info: "brief" or "full", as for the single environment.
        **arguments: of the single environment.
    """
    limit = None if max_episode_steps in (None, -1) else whole_number("max_episode_steps", max_episode_steps)
    make = partial(environment, info=info, **arguments)
    first = make()
    if isinstance(getattr(first, "task", None), RowTask):
        return ComponentVectorEnv(first, num_envs, autoreset_mode=autoreset_mode, max_episode_steps=limit)

    def make_limited() -> gymnasium.Env[Any, Any]:
        return make() if limit is None else gymnasium.wrappers.TimeLimit(make(), limit)

    return SyncVectorEnv([make_limited] * whole_number("num_envs", num_envs), autoreset_mode=_mode(autoreset_mode))


class ComponentVectorEnv(VectorEnv[Observations, npt.NDArray[np.float32], np.ndarray]):
    """Many environments whose task judges rows side by side, advanced by one call of compiled code.

    `gymnasium.make_vec("granular_env/Protection-v1", num_envs=256)` makes one. It gives what `SyncVectorEnv` of the single
    environment gives, bit for bit: observations, rewards, ends and infos. Environment i is the single one reset with seed + i.
    `copy.deepcopy`, pickle and cloudpickle give an independent batch that continues with the same bits.

    Args:
        environment: all are like this one, which becomes the first.
        num_envs: how many.
        autoreset_mode: any `gymnasium.vector.AutoresetMode`. With `DISABLED`, `reset(options={"reset_mask": mask})` resets
            those that have ended.
        max_episode_steps: actions after which an episode is truncated; None for no other end than the environment's own.

    Raises:
        ParameterError: the environment's task does not judge rows, or an argument is not valid.
    """

    def __init__(
        self,
        environment: ComponentEnv,
        num_envs: int = 1,
        *,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
    ) -> None:
        if not isinstance(getattr(environment, "task", None), RowTask):
            raise ParameterError(
                f"got {one_line(environment)}", expected="a ComponentEnv whose task is a RowTask", at="environment"
            )
        self.num_envs, self.autoreset_mode = whole_number("num_envs", num_envs), _mode(autoreset_mode)
        self._limit, self.render_mode = max_episode_steps, environment.render_mode
        self.metadata = {**environment.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = environment.action_space, environment.observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._begun = False
        self._gather([environment, *(environment.twin() for _ in range(self.num_envs - 1))])

    def _gather(self, singles: list[ComponentEnv]) -> None:
        """Let the memories of the environments, and their components, lie in arrays of the batch."""
        first, tasks = singles[0], [cast(RowTask, one.task) for one in singles]
        self._singles, self._task = singles, copy.copy(tasks[0])
        self._memories = np.stack([one.memory for one in singles])
        end = COMMANDS + first.actuator.memory_size
        self._commands, self._counters = self._memories[:, COMMANDS:end], self._memories[:, end:]
        self._columns = {name: self._counters[:, k] for k, name in enumerate(self._task.counter_names)}
        self._constants = stack_constants([task.constants for task in tasks])
        self._goal_scales = np.array([task.goal_scales for task in tasks], dtype=np.float64)
        self._rows: Any = domain_of(first.component.name).load("rows")([one.component for one in singles], together=True)
        # Environments that the caller has; those used by themselves, and those redrawn, since the last step of the batch.
        self._lent: set[int] = set()
        self._used: set[int] = set(range(self.num_envs))
        self._redrawn: set[int] = set()
        for k, one in enumerate(singles):
            one.memory, one.component, one._home = self._memories[k], self._rows.components[k], partial(self._adopt, k)
            one._bind()

    def _adopt(self, k: int, component: Component) -> Component:
        self._redrawn.add(k)
        return self._rows.adopt(k, component)

    def _refresh(self) -> None:
        """Take what environments did by themselves: times, inputs, and the constants of components that were drawn."""
        self._rows.refresh(self._used)
        self._used = set(self._lent)
        if not self._redrawn:
            return
        tasks = [cast(RowTask, one.task) for one in self._singles]
        for k in self._redrawn:
            self._goal_scales[k] = tasks[k].goal_scales
            for field, value in zip(self._constants or (), tasks[k].constants or (), strict=True):
                if np.ndim(value) and len(value) > field.shape[1]:
                    self._constants = stack_constants([task.constants for task in tasks])
                    break
                if np.ndim(value):
                    field[k, len(value) :] = 0.0
                    field[k, : len(value)] = value
                else:
                    field[k] = value
        self._redrawn.clear()

    def __getstate__(self) -> dict[str, Any]:
        """Keep the single environments, from which `_gather` makes the rest."""
        for k in range(self.num_envs):
            self._one(k)
        made = ("_task", "_memories", "_commands", "_counters", "_rows", "_constants", "_columns")
        return {name: value for name, value in vars(self).items() if name not in made}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._gather(self._singles)

    # -- Gymnasium --------------------------------------------------------------------------------------------------

    def reset(  # type: ignore[override]
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Start episodes in all environments, or in those of `options["reset_mask"]`; other options are start values.

        Args:
            seed: environment i gets seed + i, or the i-th of a list.
            options: as for the single environment.

        Raises:
            ParameterError: a seed, an option or the mask is not valid.
        """
        seeds, options = self._seeds(seed), validate_options(options)
        mask = self._mask(options.pop("reset_mask", None))
        for k in np.flatnonzero(mask).tolist():
            self._one(k).reset(seed=seeds[k], options=options or None)
        self._begun = True
        return self._observations(), self._infos(mask)

    def step(self, actions: npt.ArrayLike) -> tuple[Observations, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Advance all environments by one action; those that have ended are treated as `autoreset_mode` says.

        Raises:
            ParameterError: the actions are none, an environment's episode is over with autoreset disabled, or the task's reward
                is not a number (the components have moved).
        """
        given, going = self._validate_actions(actions), self._memories[:, RUNNING] != 0.0
        observations, rewards, terminated, truncated, errors = self._advance(given, going)
        if self._limit is not None:
            late = going & (np.ceil(self._memories[:, ELAPSED] / self._singles[0].hold) >= self._limit)
            truncated |= late
            self._memories[late, RUNNING] = 0.0
        begin, ended, final = ~going, terminated | truncated, dict[str, Any]()
        if self.autoreset_mode == AutoresetMode.SAME_STEP and ended.any():
            begin = begin | ended
            for k in np.flatnonzero(ended).tolist():
                info = {**self._one(k).observe()[1], **errors.pop(k, {})}
                final = self._add_info(final, {"final_obs": observations[k].copy(), "final_info": info}, k)
        for k in np.flatnonzero(begin).tolist():
            observations[k], _ = self._one(k).reset()
        infos = {**final, **self._infos(None)}
        for k, error in errors.items():
            infos = self._add_info(infos, error, k)
        return observations, rewards, terminated, truncated, infos

    def _advance(self, actions: np.ndarray, going: np.ndarray) -> tuple[Any, ...]:
        """Act, advance, judge and observe as `ComponentEnv.step` does, with the same bits; and the errors of refused steps."""
        first, memories, task = self._singles[0], self._memories, self._task
        self._refresh()
        rewards, over, late = np.zeros(self.num_envs), np.zeros_like(going), np.zeros_like(going)
        errors: dict[int, dict[str, str]] = {}
        moving = going
        for _ in range(first.hold):
            before = memories.copy()
            first.actuator.act(actions, self._commands)
            applied = first.actuator.applied(self._commands)
            refused = self._rows.advance(applied, first.internal_steps, moving, self._lent)
            memories[:, ELAPSED] += 1.0
            elapsed = memories[:, ELAPSED].astype(np.int64)
            gains, done = task.judge_rows(self._rows, self._constants, self._columns, elapsed)
            if refused or not moving.all():
                moving = moving.copy()
                moving[[*refused]] = False
                memories[~moving] = before[~moving]
            for k, message in refused.items():
                errors[k], over[k], memories[k, RUNNING] = {"step_error": message}, True, 0.0
                rewards[k] += self._singles[k].step_error_reward
            gained = gains[moving]
            if not np.isfinite(gained).all():
                refuse_infinite(task, gained[~np.isfinite(gained)][0])
            rewards[moving] += gained
            over |= moving & done
            late |= moving & ~over & (elapsed >= first.deadline)
            moving = moving & ~(over | late)
            memories[over | late, RUNNING] = 0.0
            if not moving.any():
                break
        terminated = over | late if first.clock else over
        return self._observations(), rewards, terminated, late & ~terminated, errors

    def render(self) -> tuple[Any, ...] | None:
        """Return the present state of each environment as a picture; None without a render mode."""
        return None if self.render_mode is None else self.call("render")

    # -- single environments ----------------------------------------------------------------------------------------

    def single(self, index: int) -> ComponentEnv:
        """Return environment number `index` as a single one, in the same memory: what it does happens in the batch.

        Its component steps by itself from now on, so that it can be recorded while the batch is stepped.
        """
        (k,) = self._environment_numbers([index])
        self._lent.add(k)
        return self._one(k)

    def _one(self, k: int) -> ComponentEnv:
        """Return environment k, its component as the batch has left it."""
        if k not in self._used:
            self._rows.synchronise(k)
            self._used.add(k)
        return self._singles[k]

    def call(self, name: str, *arguments: Any, **keywords: Any) -> tuple[Any, ...]:
        """Return an attribute of every environment, or the result of its call where it can be called."""
        found = [getattr(self._one(k), name) for k in range(self.num_envs)]
        return tuple(each(*arguments, **keywords) if callable(each) else each for each in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of every environment."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of every environment: one value for all, or a list or a tuple with one for each.

        Raises:
            ParameterError: the attribute belongs to the batch as a whole, or there are more or fewer values.
        """
        each = list(values) if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(each) != self.num_envs:
            expected = f"one, or {self.num_envs}, one for each environment"
            raise ParameterError(f"got {len(each)} values", expected=expected, at=name)
        if name not in _SETTABLE:
            hint = nearest(name, _SETTABLE, "give anything else as an argument, or in `parameters`")
            raise ParameterError("it cannot be set in a batch", hint=hint, at=name)
        for k, value in enumerate(each):
            setattr(self._one(k), name, value)

    @property
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The random numbers of each environment."""
        return self.get_attr("np_random")

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """The seed of each environment's random numbers."""
        return self.get_attr("np_random_seed")

    # -- mid-episode ------------------------------------------------------------------------------------------------

    def save(self, environments: Iterable[int] | None = None) -> list[EnvState]:
        """Return the states of the environments with these numbers, or of all; single environments understand them too."""
        return [self._one(k).save() for k in self._environment_numbers(environments)]

    def restore(self, states: Sequence[EnvState], environments: Iterable[int] | None = None) -> None:
        """Let the environments with these numbers, or all, continue from saved states; `observe` returns what is seen.

        Raises:
            ParameterError: there are more or fewer states than environments, or one belongs to another component or task;
                nothing has changed.
        """
        numbers = self._environment_numbers(environments)
        received = len(states) if isinstance(states, Sequence) else one_line(states)
        if received != len(numbers):
            raise ParameterError(f"got {received}", expected=f"{len(numbers)}, one for each environment", at="states")
        ready = [self._one(k).refuse_foreign(state) for k, state in zip(numbers, states, strict=True)]
        for k, state, one in zip(numbers, states, ready, strict=True):
            self._singles[k].take_state(state, one)
            if self._singles[k].component.follows_profile:
                self._lent.add(k)
        self._begun = True

    def observe(self) -> tuple[Observations, dict[str, Any]]:
        """Return the present observations and infos, as `reset` gives them."""
        return self._observations(), self._infos(None)

    # -- details ----------------------------------------------------------------------------------------------------

    def _observations(self) -> Observations:
        self._refresh()
        numbers = self._memories[:, : SEED + 1].astype(np.int64)
        goals, sensors = self._counters[:, : self._goal_scales.shape[1]], self._singles[0].sensors
        return sensors.observe(self._rows.read, numbers[:, SEED], numbers[:, ELAPSED], goals, self._goal_scales)

    def _infos(self, mask: npt.NDArray[np.bool_] | None) -> dict[str, Any]:
        """Return infos as fresh arrays, and for each which environments they are of."""
        self._refresh()
        first = self._singles[0]
        shown = {"time": self._rows.time}
        for name in first.task.observations if first.info == "full" else ():
            element = parse_element(name)
            value = self._rows.read(element.name)
            shown[name] = value[:, *element.index] if element.index else value
        shown |= {**first.actuator.applied(self._commands), **self._columns}
        infos: dict[str, Any] = {}
        for name, values in shown.items():
            infos[name] = values.copy()
            infos[f"_{name}"] = np.ones(self.num_envs, np.bool_) if mask is None else mask.copy()
            if mask is not None:
                infos[name][~mask] = 0.0
        if first.draws_component:
            for k in np.flatnonzero(np.ones(self.num_envs) if mask is None else mask).tolist():
                infos = self._add_info(infos, info_of_draws(self._singles[k].drawn), k)
        return infos

    def _validate_actions(self, actions: npt.ArrayLike) -> npt.NDArray[np.float64]:
        wanted = self.action_space.shape
        try:
            given = np.asarray(actions)
        except ValueError as error:  # rows of unlike length
            raise ParameterError(f"got {one_line(actions)}", expected=f"shape {wanted}", at="actions") from error
        if given.shape != wanted or given.dtype.kind not in "fiu":
            expected = f"numbers of shape {wanted}"
            raise ParameterError(f"got {given.dtype} of shape {given.shape}", expected=expected, at="actions")
        numbers = given.astype(np.float64)
        if not np.isfinite(numbers).all():
            k, entry = np.argwhere(~np.isfinite(numbers))[0].tolist()
            raise ParameterError(f"got {numbers[k, entry]}", expected="a number from -1 to 1", at=("actions", k, entry))
        if not self._begun:
            raise ParameterError("no episode has begun", hint="call reset() first", at="step")
        over = np.flatnonzero(self._memories[:, RUNNING] == 0.0).tolist()
        if over and self.autoreset_mode == AutoresetMode.DISABLED:
            came = f"the episodes of environments {one_line(over)} are over or have not begun, and autoreset is disabled"
            raise ParameterError(came, hint='call reset(options={"reset_mask": mask}) first', at="step")
        return numbers

    def _seeds(self, seed: Any) -> Sequence[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, (int, np.integer)) and not isinstance(seed, bool):
            return [validate_seed(int(seed) + k) for k in range(self.num_envs)]
        if not isinstance(seed, (list, tuple)) or len(seed) != self.num_envs:
            raise ParameterError(f"got {one_line(seed)}", expected=f"a whole number, or {self.num_envs} in a list", at="seed")
        return [validate_seed(one) for one in seed]

    def _mask(self, mask: Any) -> npt.NDArray[np.bool_]:
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            expected = f"{self.num_envs} truth values in an array, one true"
            raise ParameterError(f"got reset_mask {one_line(mask)}", expected=expected, at="options")
        return mask

    def _environment_numbers(self, environments: Iterable[int] | None) -> list[int]:
        if environments is None:
            return list(range(self.num_envs))
        if not isinstance(environments, Iterable):
            expected = "a list of numbers of environments"
            raise ParameterError(f"got {one_line(environments)}", expected=expected, at="environments")
        numbers = [whole_number("environments", k, 0, self.num_envs - 1) for k in environments]
        if len(set(numbers)) < len(numbers):
            raise ParameterError(f"got {one_line(numbers)}", expected="each environment once", at="environments")
        return numbers


def _mode(given: Any) -> AutoresetMode:
    try:
        return AutoresetMode(given)
    except ValueError:
        modes = ", ".join(repr(mode.value) for mode in AutoresetMode)
        raise ParameterError(f"got {one_line(given)}", expected=f"one of {modes}", at="autoreset_mode") from None


def __getattr__(name: str) -> Any:
    """Return the batch of a registered environment, by the name of its factory: Gymnasium wants an attribute for each."""
    for one in environments().values():
        if one.entry_point.partition(":")[2] == name:
            return partial(make_batch, load(one.entry_point))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
