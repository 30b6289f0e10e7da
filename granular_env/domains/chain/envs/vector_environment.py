"""A native batch of chain environments: one call advances all chains through all internal steps, judges and observes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from granular_env.components.errors import IssuedCautions, ParameterError, nearest, one_line
from granular_env.components.support.validation import whole_number
from granular_env.envs.environment import validate_seed
from granular_env.envs.pickling import Recreatable, make_again
from granular_env.envs.state import EnvState

from .environment import ChainEnv
from .environment_batch import EnvironmentBatch
from .episode_layout import RUNNING

Observations = npt.NDArray[np.float32]
# What the compiled code does not read, so that it may be set while the batch lives.
_SETTABLE = ("np_random", "render_mode", "step_error_reward")


class ChainVectorEnv(Recreatable, VectorEnv[Observations, npt.NDArray[np.float32], np.ndarray]):
    """Many environments of a chain side by side, advanced by one call of compiled code.

    `gymnasium.make_vec("granular_env/Protection-v1", num_envs=256)` makes one. It gives what `SyncVectorEnv` of the single
    environment gives, bit for bit: observations, rewards, ends and infos.

    ## Spaces
    Those of the single environment, batched. Actions are clipped, limited and delayed as there; NaN or infinity in any of them,
    or a wrong shape, raises `ParameterError`, and nothing has moved.

    ## Infos
    By default `info="brief"`: "time", the inputs applied and the task's counters, each a fresh array of shape (num_envs,) with
    its mask "_name". With `info="full"` "displacement" and "velocity" of all grains, (num_envs, grains), too: as many bytes as
    the physics itself touches.

    ## Arguments
    * `environment`: a class of `ChainEnv`, or a function that makes one.
    * `num_envs`: how many.
    * `max_episode_steps` (None): actions after which an episode is truncated, as by Gymnasium's `TimeLimit`; None or -1 for no
      other end than the environment's own `deadline`.
    * `autoreset_mode` (next step): any `gymnasium.vector.AutoresetMode`. With `DISABLED`,
      `reset(options={"reset_mask": mask})` resets those that have ended.
    * `parameters` (None): a list of `num_envs` mappings, arguments of each environment that differ from the common ones; those
      in "chain" are added to the common "chain".
    * `info` ("brief"): as above.
    * **arguments: of the single environment.

    Environment i is bit for bit the single one reset with seed + i: chains that are drawn (`randomise`) are the same, too.

    `copy.deepcopy`, pickle and cloudpickle give an independent batch that goes on with the same bits.
    """

    def __init__(
        self,
        environment: Callable[..., ChainEnv],
        num_envs: int = 1,
        *,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        parameters: Sequence[Mapping[str, Any]] | None = None,
        max_episode_steps: int | None = None,
        info: str = "brief",
        **arguments: Any,
    ) -> None:
        self.num_envs = whole_number("num_envs", num_envs)
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = ", ".join(repr(mode.value) for mode in AutoresetMode)
            raise ParameterError(f"got {one_line(autoreset_mode)}", expected=f"one of {modes}", at="autoreset_mode") from None
        self._limit = None if max_episode_steps in (None, -1) else whole_number("max_episode_steps", max_episode_steps)
        self._batch = EnvironmentBatch(environment, self.num_envs, parameters, {**arguments, "info": info})
        first = self._batch.single[0]
        self.info, self.render_mode, self.single_hold = info, first.render_mode, first.hold
        self.metadata = {**first.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = first.action_space, first.observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._begun = False

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
        if not isinstance(options, Mapping | None):
            raise ParameterError(
                f"got {one_line(options)}", expected="start values of state variables, name -> value", at="options"
            )
        seeds, options = self._seeds(seed), dict(options or {})
        mask = self._mask(options.pop("reset_mask", None))
        for k in np.flatnonzero(mask).tolist():
            self._batch.single[k].reset(seed=seeds[k], options=options or None)
        self._begun = True
        return self._batch.observe(), self._infos(mask)

    def step(self, actions: npt.ArrayLike) -> tuple[Observations, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One action of all environments; those that have ended are treated as `autoreset_mode` says.

        Raises:
            ParameterError: the actions are none, an environment's episode is over with autoreset disabled, or the task's reward
                is not a number (the chains have moved).
        """
        given = self._validate_actions(actions)
        going = ~self._are_over
        observations = np.empty((self.num_envs, self._batch.size), np.float32)
        rewards, ends = np.zeros(self.num_envs), np.zeros((3, self.num_envs), np.bool_)
        terminated, truncated, refused = ends
        special = self._batch.step(given, going, observations, rewards, terminated, truncated, refused)
        errors: dict[int, str] = {}
        if not np.isfinite(rewards).all():
            k, task = int(np.argmin(np.isfinite(rewards))), self._batch.single[0].task
            raise ParameterError(
                f"task {task.name!r}: its reward is {rewards[k]} in environment {k}", hint="mend its judge_kernel"
            )
        if special:
            for k in np.flatnonzero(refused).tolist():
                single = self._batch.synchronise(k)
                observations[k], rewards[k], terminated[k], truncated[k], info = single.step(given[k])
                if "step_error" in info:
                    errors[k] = info["step_error"]
        if self._limit is not None:
            late = going & (self._batch.count(self.single_hold) >= self._limit)
            truncated |= late
            self._batch.memories[late, RUNNING] = 0.0
            special += int(late.sum())
        ended = terminated | truncated
        extra: dict[str, Any] = {}
        if special and self.autoreset_mode == AutoresetMode.SAME_STEP:
            for k in np.flatnonzero(ended).tolist():
                extra = self._add_info(extra, self._final(k, observations[k], errors.pop(k, None)), k)
                observations[k], _ = self._batch.single[k].reset()
        if not going.all():
            for k in np.flatnonzero(~going).tolist():
                observations[k], _ = self._batch.single[k].reset()
        infos = {**extra, **self._infos(None)}
        for k, message in errors.items():
            infos = self._add_info(infos, {"step_error": message}, k)
        return observations, rewards, terminated.copy(), truncated.copy(), infos

    def render(self) -> tuple[Any, ...] | None:
        """Return the present state of each environment as a picture; None without a render mode."""
        return None if self.render_mode is None else self.call("render")

    # -- single environments ----------------------------------------------------------------------------------------

    def single(self, index: int) -> ChainEnv:
        """Environment number `index` as a single one, in the same memory: what it does happens in the batch.

        A recording of its component goes on while the batch is stepped.
        """
        self._environment_numbers([index])
        return self._batch.lent(index)

    def call(self, name: str, *arguments: Any, **keywords: Any) -> tuple[Any, ...]:
        """Return an attribute of every environment, or the result of its call where it can be called."""
        found = [getattr(self._batch.synchronise(k), name) for k in range(self.num_envs)]
        return tuple(each(*arguments, **keywords) if callable(each) else each for each in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of every environment."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of every environment: one value for all, or a list or a tuple with one for each.

        Raises:
            ParameterError: there is no such attribute, it belongs to the batch as a whole, or there are more or fewer values.
        """
        each = list(values) if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ParameterError(
                f"got {len(each)} values", expected=f"one, or {self.num_envs}, one for each environment", at=name
            )
        if name not in _SETTABLE:
            raise ParameterError(
                "it cannot be set in a batch, compiled code has read it",
                hint=nearest(name, _SETTABLE, "give anything else as an argument, or in `parameters`"),
                at=name,
            )
        for k, value in enumerate(each):
            setattr(self._batch.synchronise(k), name, value)

    @property
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The random numbers of each environment."""
        return self.get_attr("np_random")

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """Return what each environment's random numbers were seeded with."""
        return self.get_attr("np_random_seed")

    # -- mid-episode ------------------------------------------------------------------------------------------------

    def save(self, environments: Iterable[int] | None = None) -> list[EnvState]:
        """Return the states of the environments with these numbers, or of all; single environments understand them too."""
        return [self._batch.synchronise(k).save() for k in self._environment_numbers(environments)]

    def restore(self, states: Sequence[EnvState], environments: Iterable[int] | None = None) -> None:
        """Let the environments with these numbers, or all, go on from saved states. `observe` tells what is seen there.

        Raises:
            ParameterError: there are more or fewer states than environments, or one belongs to another chain or task;
                nothing has changed.
        """
        numbers = self._environment_numbers(environments)
        received = len(states) if isinstance(states, Sequence) else one_line(states)
        if received != len(numbers):
            raise ParameterError(f"got {received}", expected=f"{len(numbers)}, one for each environment", at="states")
        self._batch.restore(numbers, states)
        self._begun = True

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle and `copy.deepcopy`: the constructor's arguments, and where each episode is."""
        singles = self._batch.single
        seeds = [single._np_random_seed for single in singles]
        issued = [single.component.issued_cautions for single in singles]
        spaces = [f"{single}{kind}_space" for single in ("", "single_") for kind in ("action", "observation")]
        kept = {name: getattr(self, name) for name in ("_begun", "spec", *spaces)}
        return _recreate, (self._made_by, *self._made_with, self.save(), seeds, issued, kept)

    def observe(self) -> tuple[Observations, dict[str, Any]]:
        """Return the present observations and infos, as `reset` gives them."""
        return self._batch.observe(), self._infos(None)

    # -- details ----------------------------------------------------------------------------------------------------

    @property
    def _are_over(self) -> npt.NDArray[np.bool_]:
        """Whose episodes are over, or have never begun; also where an environment was stepped, reset or restored by itself."""
        return self._batch.memories[:, RUNNING] == 0.0

    def _validate_actions(self, actions: npt.ArrayLike) -> npt.NDArray[np.float64]:
        wanted = self.action_space.shape
        try:
            given = np.asarray(actions)
        except ValueError as error:  # rows of unlike length
            raise ParameterError(f"got {one_line(actions)}", expected=f"shape {wanted}", at="actions") from error
        if given.shape != wanted or given.dtype.kind not in "fiu":
            raise ParameterError(
                f"got {given.dtype} of shape {given.shape}", expected=f"numbers of shape {wanted}", at="actions"
            )
        numbers = given.astype(np.float64, order="C")
        if not np.isfinite(numbers).all():
            k, entry = np.argwhere(~np.isfinite(numbers))[0].tolist()
            raise ParameterError(f"got {numbers[k, entry]}", expected="a number from -1 to 1", at=("actions", k, entry))
        if not self._begun:
            raise ParameterError("no episode has begun", hint="call reset() first", at="step")
        over = np.flatnonzero(self._are_over).tolist() if self.autoreset_mode == AutoresetMode.DISABLED else []
        if over:
            raise ParameterError(
                f"the episodes of environments {one_line(over)} are over or have not begun, and autoreset is disabled",
                hint='call reset(options={"reset_mask": mask}) first',
                at="step",
            )
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
            raise ParameterError(
                f"got reset_mask {one_line(mask)}",
                expected=f"{self.num_envs} truth values in an array, one true",
                at="options",
            )
        return mask

    def _environment_numbers(self, environments: Iterable[int] | None) -> list[int]:
        if environments is None:
            return list(range(self.num_envs))
        if not isinstance(environments, Iterable):
            raise ParameterError(
                f"got {one_line(environments)}", expected="a list of numbers of environments", at="environments"
            )
        numbers = list(environments)
        for k in numbers:
            if isinstance(k, bool) or not isinstance(k, (int, np.integer)) or not 0 <= k < self.num_envs:
                raise ParameterError(
                    f"got {one_line(k)}", expected=f"whole numbers from 0 to {self.num_envs - 1}", at="environments"
                )
        if len(set(numbers)) < len(numbers):
            raise ParameterError(f"got {one_line(numbers)}", expected="each environment once", at="environments")
        return numbers

    def _final(self, k: int, observation: Observations, message: str | None) -> dict[str, Any]:
        """Return what an episode ended with, where the next one begins in the same step."""
        info = self._batch.synchronise(k).observe()[1]
        if message is not None:
            info["step_error"] = message
        return {"final_obs": observation.copy(), "final_info": info}

    def _infos(self, mask: npt.NDArray[np.bool_] | None) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        chosen = np.ones(self.num_envs, np.bool_) if mask is None else mask
        for name, values in self._batch.infos(self.info).items():
            if mask is not None:
                values[~mask] = 0.0
            infos[name], infos[f"_{name}"] = values, chosen.copy()
        for name, (values, having) in self._batch.draws().items():
            shown = having & chosen
            if shown.any():
                infos[name], infos[f"_{name}"] = values.copy(), shown
                infos[name][~shown] = 0.0
        return infos


def _recreate(
    kind: type[ChainVectorEnv],
    arguments: Any,
    keywords: Mapping[str, Any],
    states: Any,
    seeds: Any,
    issued_cautions: list[IssuedCautions],
    kept: Mapping[str, Any],
) -> ChainVectorEnv:
    """Return a batch that was made so, in these states; it says nothing that the first one has said."""
    env = make_again(kind, arguments, keywords)
    for single, issued in zip(env._batch.single, issued_cautions, strict=True):
        single.component.share_cautions(issued)
    env.restore(states)
    for single, seed in zip(env._batch.single, seeds, strict=True):
        single._np_random_seed = seed
    for name, value in kept.items():
        setattr(env, name, value)
    return env
