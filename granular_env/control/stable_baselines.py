"""A Gymnasium `VectorEnv` in the form required by stable-baselines3. Needs the extra ``rl``."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from granular_env.components.errors import ParameterError, one_line
from granular_env.optional_packages import import_optional

VecEnv: Any = import_optional("stable_baselines3.common.vec_env", "an environment for it").VecEnv


class Sb3VecEnv(VecEnv):
    """An adapter of a batch of environments for the algorithms of stable-baselines3.

        env = Sb3VecEnv(gymnasium.make_vec("granular_env/Protection-v1", num_envs=16, autoreset_mode="SameStep", hold=10))
        PPO("MlpPolicy", env).learn(100_000)

    Infos are empty except at the last step of an episode, with "terminal_observation" and "TimeLimit.truncated".

    Args:
        env: a `SyncVectorEnv` or a `ComponentVectorEnv`, with `AutoresetMode.SAME_STEP`.

    Raises:
        ParameterError: another type of environment or autoreset mode.
    """

    def __init__(self, env: gymnasium.vector.VectorEnv) -> None:
        mode = getattr(env, "metadata", {}).get("autoreset_mode")
        if mode != gymnasium.vector.AutoresetMode.SAME_STEP:
            expected, hint = "AutoresetMode.SAME_STEP", 'pass autoreset_mode="SameStep" to make_vec'
            raise ParameterError(f"the autoreset_mode of {one_line(env)} is {mode}", expected=expected, hint=hint, at="env")
        self.env: Any = env.unwrapped
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> np.ndarray:
        """Return observations of new episodes, shape (environments, size)."""
        seeds: Any = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, _ = self.env.reset(seed=seeds, options=self._options[0] or None)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Store the actions for `step_wait`."""
        self._actions = np.array(actions)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Step all environments; return observations, rewards, a mask of ended episodes, and infos."""
        observations, rewards, terminated, truncated, info = self.env.step(self._actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for place in np.flatnonzero(terminated | truncated):
            last = {name: values[place] for name, values in info["final_info"].items() if name[0] != "_"}
            is_cut = bool(truncated[place] and not terminated[place])
            infos[place] = {**last, "terminal_observation": info["final_obs"][place], "TimeLimit.truncated": is_cut}
        return observations, rewards.astype(np.float32), terminated | truncated, infos

    def close(self) -> None:
        """Close the batch."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the environments with these indices."""
        found = self.env.get_attr(attr_name)
        return [found[place] for place in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the environments with these indices."""
        values = list(self.env.get_attr(attr_name))
        for place in self._get_indices(indices):
            values[place] = value
        self.env.set_attr(attr_name, values)

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Call a method of all environments; return the results of the environments with these indices."""
        found = self.env.call(method_name, *method_args, **method_kwargs)
        return [found[place] for place in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return False for each environment, because single environments have no wrappers."""
        return [False for _ in self._get_indices(indices)]
