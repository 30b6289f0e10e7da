"""PPO (Schulman et al. 2017) and SAC (Haarnoja et al. 2018) from stable-baselines3, on a batch of environments."""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from granular_env.envs.policies import Policy

from ..problem import Problem
from ..search import BudgetSpentError, Search
from .method import MethodTable


class Reinforcement(MethodTable):
    """Keys of ppo and sac. After each round of training, the policy without exploration noise plays the search episodes.

    The policy with the best return is kept.
    """

    packages: ClassVar[tuple[str, ...]] = ("torch", "stable_baselines3")

    environments: int = Field(default=16, ge=1, le=10_000, description="environments in the batch")
    hold: int = Field(default=1, ge=1, description="number of control steps per action (frame skip)")
    clock: int = Field(default=4, ge=0, le=100, description="number of cosines of the elapsed time in the observation")
    layers: list[int] = Field(default=[64, 64], description="widths of the networks' hidden layers")
    learning_rate: float = Field(default=3e-4, gt=0.0, description="learning rate of the optimiser")
    discount: float = Field(default=0.99, gt=0.0, le=1.0, description="discount factor per decision")
    rollout: int = Field(ge=1, description="decisions per environment and round")
    evaluate_every: int = Field(default=10, ge=1, description="number of training rounds between two evaluations")

    @abstractmethod
    def algorithm(self, env: Any, seed: int) -> Any:
        """Return a new training algorithm of stable-baselines3 for its `VecEnv` `env`."""

    def run(self, search: Search) -> None:
        """Train in rounds until the budget is spent."""
        from ..stable_baselines import Sb3VecEnv

        decisions, rounds, problem = self.rollout * self.environments, 0, self.adapt_problem(search.problem)
        with limit_torch_to_one_thread():
            model = self.algorithm(Sb3VecEnv(problem.make_vector_env(self.environments)), search.seed)
            while True:
                is_last = search.remaining_steps < decisions * self.hold
                if is_last or rounds % self.evaluate_every == 0:
                    self._evaluate_policy(model.policy, problem, search)
                if is_last:
                    raise BudgetSpentError
                model.learn(decisions, reset_num_timesteps=False, log_interval=None)
                search.count_steps(decisions * self.hold)  # an action cut short by the end of an episode counts as `hold` steps
                rounds += 1

    def _evaluate_policy(self, policy: Any, problem: Problem, search: Search) -> None:
        if search.remaining_steps < problem.steps * len(search.seeds):
            return
        value, steps = problem.policy_return(TrainedPolicy(policy), search.seeds)
        search.count_return(copy.deepcopy(policy) if value > search.best_return else None, value, steps)

    def adapt_problem(self, problem: Problem) -> Problem:
        """Return the task with actions held over `hold` control steps, and with the time in the observation."""
        return problem.with_options(hold=self.hold, clock=self.clock)

    def actor(self, search: Search) -> Policy:
        """Return the best policy found, for a single environment."""
        return TrainedPolicy(search.best)


class PPO(Reinforcement):
    """Proximal policy optimisation: collects short rollouts from many environments between its updates."""

    type: Literal["ppo"] = "ppo"
    rollout: int = Field(default=64, ge=2, description="decisions per environment and round")
    batch: int = Field(default=256, ge=2, description="decisions in a minibatch")
    epochs: int = Field(default=10, ge=1, description="number of passes over the decisions of a round")
    trace: float = Field(default=0.95, ge=0.0, le=1.0, description="lambda of the advantage estimation; 1: full returns")
    noise: float = Field(default=0.6, gt=0.0, description="initial standard deviation of the actions")

    def algorithm(self, env: Any, seed: int) -> Any:
        """Return PPO of stable-baselines3."""
        from stable_baselines3 import PPO as Algorithm  # pyright: ignore[reportMissingImports]

        decisions = self.rollout * env.num_envs
        batch = next(part for part in range(min(decisions, self.batch), 0, -1) if decisions % part == 0)
        return Algorithm(
            "MlpPolicy", env, seed=seed, device="cpu", verbose=0, n_steps=self.rollout, batch_size=batch, n_epochs=self.epochs,
            learning_rate=self.learning_rate, gamma=self.discount, gae_lambda=self.trace,
            policy_kwargs={"net_arch": self.layers, "log_std_init": float(np.log(self.noise))},
        )  # fmt: skip


class SAC(Reinforcement):
    """Soft actor-critic: learns from a replay buffer, so it needs fewer simulated steps but more computing time per step."""

    type: Literal["sac"] = "sac"
    rollout: int = Field(default=16, ge=1, description="decisions per environment and round")
    batch: int = Field(default=256, ge=2, description="decisions in a minibatch")
    memory: int = Field(default=100_000, ge=100, description="number of decisions in the replay buffer")
    first: int = Field(default=1000, ge=0, description="number of random decisions before learning starts")
    updates: int = Field(default=8, ge=1, description="number of optimiser steps per decision of the batch")

    def algorithm(self, env: Any, seed: int) -> Any:
        """Return SAC of stable-baselines3."""
        from stable_baselines3 import SAC as Algorithm  # pyright: ignore[reportMissingImports]

        return Algorithm(
            "MlpPolicy", env, seed=seed, device="cpu", verbose=0,
            batch_size=self.batch, buffer_size=self.memory, learning_starts=self.first, train_freq=1,
            gradient_steps=self.updates, learning_rate=self.learning_rate, gamma=self.discount,
            policy_kwargs={"net_arch": self.layers},
        )  # fmt: skip


class TrainedPolicy:
    """A trained policy without noise.

    It accepts the observations of a batch, shape (environments, size), and the observation of a single environment.
    """

    def __init__(self, policy: Any) -> None:
        self._policy = policy

    def reset(self) -> None:
        """Do nothing, because the policy has no memory."""

    def __call__(self, observation: npt.NDArray[Any], info: Any = None) -> npt.NDArray[Any]:
        """Return the next actions."""
        with limit_torch_to_one_thread():
            # Evaluate one observation at a time: in a batch, the network's output would differ in the last bits.
            actions = [self._policy.predict(one, deterministic=True)[0] for one in np.atleast_2d(observation)]
        return np.array(actions) if np.ndim(observation) > 1 else actions[0]


@contextmanager
def limit_torch_to_one_thread() -> Iterator[None]:
    """Restrict torch to one thread: with several threads, small networks are slower and sum in a different order."""
    import torch  # pyright: ignore[reportMissingImports]

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
