"""A Gymnasium `VectorEnv` as stable-baselines3 wants one. Needs the extra ``rl``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np

from granular_env.components.errors import MissingExtraError, ParameterError, one_line

try:
    from stable_baselines3.common.vec_env import VecEnv  # pyright: ignore[reportMissingImports]
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices  # pyright: ignore[reportMissingImports]
except ModuleNotFoundError as error:
    raise MissingExtraError("stable_baselines3 is not installed", hint="run: pip install 'granular-env[rl]'") from error


class Sb3VecEnv(VecEnv):
    """All environments of a batch in one call, for the algorithms of stable-baselines3.

        env = Sb3VecEnv(gymnasium.make_vec("granular_env/Protection-v1", num_envs=16, autoreset_mode="SameStep", hold=10))
        PPO("MlpPolicy", env).learn(100_000)

    Each step gives every environment's infos as the single environment gives them; where an episode ends, those of its last
    step, with "terminal_observation" and "TimeLimit.truncated".

    Args:
        env: a `VectorEnv` that resets in the same step (`AutoresetMode.SAME_STEP`).

    Raises:
        ParameterError: it is none, or resets otherwise.
    """

    def __init__(self, env: gymnasium.vector.VectorEnv) -> None:
        if not isinstance(env, gymnasium.vector.VectorEnv):
            raise ParameterError(f"got {one_line(env)}", expected="a VectorEnv", hint="make one by make_vec", at="env")
        if (mode := env.metadata.get("autoreset_mode")) != gymnasium.vector.AutoresetMode.SAME_STEP:
            expected, hint = "AutoresetMode.SAME_STEP", 'give make_vec autoreset_mode="SameStep"'
            raise ParameterError(f"its autoreset_mode is {mode}", expected=expected, hint=hint, at="env")
        self.env: Any = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> np.ndarray:
        """Observations of new episodes, shape (environments, size)."""
        seeds: Any = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, infos = self.env.reset(seed=seeds, options=self._options[0] or None)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [info_of(infos, place) for place in range(self.num_envs)]
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = np.array(actions)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Step all environments; return observations, rewards, whether episodes ended, and infos."""
        observations, rewards, terminated, truncated, info = self.env.step(self._actions)
        over = terminated | truncated
        infos: list[dict[str, Any]] = []
        for place in range(self.num_envs):
            if not over[place]:
                infos.append(info_of(info, place))
                continue
            self.reset_infos[place] = info_of(info, place)
            infos.append(
                {
                    **info_of(info["final_info"], place),
                    "terminal_observation": info["final_obs"][place],
                    "TimeLimit.truncated": bool(truncated[place] and not terminated[place]),
                }
            )
        return observations, rewards.astype(np.float32), over, infos

    def close(self) -> None:
        """Close the batch."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of the environments with these indices."""
        found = self.env.unwrapped.get_attr(attr_name)
        return [found[place] for place in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the environments with these indices."""
        values = list(self.env.unwrapped.get_attr(attr_name))
        for place in self._get_indices(indices):
            values[place] = value
        self.env.unwrapped.set_attr(attr_name, values)

    def env_method(self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any) -> list[Any]:
        """Call a method of the environments with these indices; their answers."""
        batch: Any = self.env.unwrapped
        singles = (batch.single(one) if hasattr(batch, "single") else batch.envs[one] for one in self._get_indices(indices))
        return [getattr(single, method_name)(*method_args, **method_kwargs) for single in singles]

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """Return False for each: no environment is wrapped by itself."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[np.ndarray | None]:
        """Return a picture of each environment; None where it has no render mode."""
        images: Any = self.env.render()
        return [None] * self.num_envs if images is None else list(images)


def info_of(infos: dict[str, Any], place: int) -> dict[str, Any]:
    """Return the info of one environment out of those of a batch."""
    return {
        name: values[place].item() if np.ndim(values[place]) == 0 and hasattr(values[place], "item") else values[place]
        for name, values in infos.items()
        if name[:1] != "_" and name not in ("final_obs", "final_info") and infos[f"_{name}"][place]
    }
