"""A Gymnasium `VectorEnv` as stable-baselines3 wants one. Needs the extra ``rl``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from granular_env.components.errors import ParameterError


class Sb3VecEnv(VecEnv):
    """All environments of a batch in one call, for the algorithms of stable-baselines3.

        env = Sb3VecEnv(gymnasium.make_vec("granular_env/Force-v0", num_envs=16, ...), hold=10)
        PPO("MlpPolicy", env).learn(100_000)

    Args:
        env: a `VectorEnv` that resets in the same step (`AutoresetMode.SAME_STEP`).
        hold: control steps for which an action is held; their rewards are added up. An episode that begins while an action is
            held rests until the next one.
    """

    def __init__(self, env: gymnasium.vector.VectorEnv, hold: int = 1) -> None:
        mode = env.metadata.get("autoreset_mode")
        if mode != gymnasium.vector.AutoresetMode.SAME_STEP:
            raise ParameterError(f"env: its autoreset_mode is {mode}, expected AutoresetMode.SAME_STEP")
        self.env, self.hold = env, hold
        self.control_steps = 0
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> np.ndarray:
        """Observations of new episodes, shape (environments, size)."""
        seeds: Any = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, _ = self.env.reset(seed=seeds)
        self._reset_seeds()
        return observations

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
            rewards += np.where(over, 0.0, gained)
            for place in np.flatnonzero((terminated | truncated) & ~over):
                infos[place]["terminal_observation"] = told["final_obs"][place]
                infos[place]["TimeLimit.truncated"] = bool(truncated[place] and not terminated[place])
            over |= terminated | truncated
            self._actions[over] = 0.0
        return observations, rewards.astype(np.float32), over, infos

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
