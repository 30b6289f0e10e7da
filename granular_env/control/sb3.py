"""A Gymnasium `VectorEnv` as stable-baselines3 wants one. Needs the extra ``rl``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from granular_env.components.errors import MissingExtraError, ParameterError

try:
    from stable_baselines3.common.vec_env import VecEnv  # pyright: ignore[reportMissingImports]
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices  # pyright: ignore[reportMissingImports]
except ModuleNotFoundError as error:
    raise MissingExtraError("stable_baselines3 is not installed; run: pip install 'granular-env[rl]'") from error


def clocked(observations: np.ndarray, part: npt.ArrayLike, count: int) -> np.ndarray:
    """Observations with the time: cos(pi k part), k = 1 to `count`.

    An agent that does not see how late it is cannot do the right thing before a deadline (Pardo et al. 2018); a chain at rest
    looks the same at any time.

    Args:
        observations: shape (environments, size).
        part: part of the episode that is over, shape (environments,), or one for all.
        count: how many cosines; 0 leaves the observations as they are.
    """
    if not count:
        return observations
    parts = np.broadcast_to(np.asarray(part, dtype=np.float64), len(observations))
    times = np.cos(np.pi * np.arange(1, count + 1) * parts[:, None])
    return np.hstack([observations, times.astype(np.float32)])


class Sb3VecEnv(VecEnv):
    """All environments of a batch in one call, for the algorithms of stable-baselines3.

        env = Sb3VecEnv(gymnasium.make_vec("granular_env/Force-v0", num_envs=16, ...), hold=10)
        PPO("MlpPolicy", env).learn(100_000)

    Args:
        env: a `VectorEnv` that resets in the same step (`AutoresetMode.SAME_STEP`).
        hold: control steps for which an action is held; their rewards are added up. An episode that begins while an action is
            held rests until the next one.
        clock: how many cosines of the time tell an agent how late it is, see `clocked`; 0: it is not told, and the deadline is
            what cuts an episode off, not its end.
        deadline: control steps of an episode; the clock needs it.
    """

    def __init__(self, env: gymnasium.vector.VectorEnv, hold: int = 1, clock: int = 0, deadline: int = 1) -> None:
        mode = env.metadata.get("autoreset_mode")
        if mode != gymnasium.vector.AutoresetMode.SAME_STEP:
            raise ParameterError(f"env: its autoreset_mode is {mode}, expected AutoresetMode.SAME_STEP")
        self.env, self.hold, self.clock, self.deadline = env, hold, clock, deadline
        self.control_steps = 0
        self._elapsed = np.zeros(env.num_envs, dtype=np.int64)
        seen = env.single_observation_space
        assert isinstance(seen, gymnasium.spaces.Box)
        times = np.ones(clock, np.float32)
        space = gymnasium.spaces.Box(np.append(seen.low, -times), np.append(seen.high, times), dtype=np.float32)
        super().__init__(env.num_envs, space, env.single_action_space)

    def reset(self) -> np.ndarray:
        """Observations of new episodes, shape (environments, size)."""
        seeds: Any = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, _ = self.env.reset(seed=seeds)
        self._reset_seeds()
        self._elapsed[:] = 0
        return self._seen(observations, self._elapsed)

    def step_async(self, actions: np.ndarray) -> None:
        """Remember what shall be done."""
        self._actions = np.array(actions)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Do it, for as long as an action is held."""
        over = np.zeros(self.num_envs, dtype=bool)
        rewards = np.zeros(self.num_envs)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        observations = np.empty(0)
        for _ in range(self.hold):
            observations, gained, terminated, truncated, told = self.env.step(self._actions)
            self.control_steps += self.num_envs
            self._elapsed += 1
            rewards += np.where(over, 0.0, gained)
            for place in np.flatnonzero((terminated | truncated) & ~over):
                last = told["final_obs"][place][None]
                infos[place]["terminal_observation"] = self._seen(last, self._elapsed[place : place + 1])[0]
                infos[place]["TimeLimit.truncated"] = bool(truncated[place] and not terminated[place] and not self.clock)
            self._elapsed[terminated | truncated] = 0
            over |= terminated | truncated
            self._actions[over] = 0.0
        return self._seen(observations, self._elapsed), rewards.astype(np.float32), over, infos

    def _seen(self, observations: np.ndarray, elapsed: np.ndarray) -> np.ndarray:
        return clocked(observations, elapsed / self.deadline, self.clock)

    def close(self) -> None:
        """Close the batch."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of the batch, for each environment."""
        return [getattr(self.env, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the batch."""
        setattr(self.env, attr_name, value)

    def env_method(self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any) -> list[Any]:
        """Call a method of the batch, once; its answer for each environment."""
        answer = getattr(self.env, method_name)(*method_args, **method_kwargs)
        return [answer for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """Nothing is wrapped singly."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[np.ndarray | None]:
        """No pictures of batches."""
        return [None] * self.num_envs
