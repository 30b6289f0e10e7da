"""PPO (Schulman et al. 2017) and SAC (Haarnoja et al. 2018), by stable-baselines3, on a batch of environments."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from granular_env.envs.sensors import clock_readings

from .method import MethodTable
from .policy_search import Single

if TYPE_CHECKING:
    from ...problem import Problem
    from ..evaluator import BudgetedEvaluator

Arrays = dict[str, npt.NDArray[Any]]


class Reinforcement(MethodTable):
    """The base of both: rounds of training, and now and then the policy, without its noise, in the study's episodes.

    The best of these policies is kept. After a kill the training goes on from the last round's weights and optimisers; its
    noise, and SAC's memory of what it saw, begin anew.
    """

    packages: ClassVar[tuple[str, ...]] = ("torch", "stable_baselines3")
    extra: ClassVar[str] = "rl"

    environments: int = Field(default=16, ge=1, le=10_000, description="environments in the batch")
    hold: int = Field(default=1, ge=1, description="control steps for which an action is held")
    clock: int = Field(default=4, ge=0, le=100, description="cosines of the time that are added to the observation")
    layers: list[int] = Field(default=[64, 64], description="widths of the networks' hidden layers")
    learning_rate: float = Field(default=3e-4, gt=0.0, description="step of the optimiser")
    discount: float = Field(default=0.99, gt=0.0, le=1.0, description="weight of a reward one decision later")
    rollout: int = Field(ge=1, description="decisions of an environment in a round")
    evaluate_every: int = Field(default=10, ge=1, description="rounds of training between two evaluations")

    @abstractmethod
    def algorithm(self, env: Any, seed: int) -> Any:
        """Return the algorithm on an environment of stable-baselines3."""

    def run(self, search: BudgetedEvaluator) -> None:
        """Round after round of training until the budget is spent."""
        from ..evaluator import BudgetSpentError
        from ..trial_record import TRAINING

        rounds = search.record.count(TRAINING)
        with one_thread():
            env = self._batch(search.problem, self.environments)
            # After a kill the noise is not that of the first rounds once more.
            model = self.algorithm(env, search.seed + 1000 * rounds)
            if search.record.agent:
                put_arrays(model, search.record.agent)
                model.num_timesteps = rounds * self.rollout * self.environments
            while True:
                if rounds % self.evaluate_every == 0:
                    self._evaluate(model, search)
                if search.remaining_steps < self.rollout * self.environments * self.hold:
                    self._evaluate(model, search)
                    raise BudgetSpentError
                model.learn(self.rollout * self.environments, reset_num_timesteps=False, log_interval=None)
                # An action that the end of an episode cuts short counts in full.
                search.record.add(TRAINING, None, 0.0, self.rollout * self.environments * self.hold)
                search.record.agent = arrays_of(model)
                rounds += 1
                search.watch(search.record)

    def _evaluate(self, model: Any, search: BudgetedEvaluator) -> None:
        from ..evaluator import refuse_unless_finite
        from ..trial_record import RETURN

        if search.remaining_steps < search.problem.steps * len(search.seeds):
            return
        policies = self._policy(model, search.problem)
        values, steps = search.problem.policy_returns(lambda episodes: policies, 1, search.seeds)
        refuse_unless_finite("return", float(values[0]), search.record)
        search.record.add(RETURN, None, float(values[0]), int(steps[0]))
        if values[0] > search.record.best_return:
            search.record.keep(module_arrays(model.policy), float(values[0]))

    def actor(self, best: Arrays, search: BudgetedEvaluator, problem: Problem) -> Any:
        """Return the best policy as an agent."""
        with one_thread():
            model = self.algorithm(self._batch(problem, 1), 0)
            model.policy.load_state_dict(_tensors(best))
        return Single(self._policy(model, problem))

    def _batch(self, problem: Problem, count: int) -> Any:
        from ...stable_baselines import Sb3VecEnv

        return Sb3VecEnv(problem.vector(count, self.hold, self.clock))

    def _policy(self, model: Any, problem: Problem) -> HeldPolicy:
        return HeldPolicy(model.policy, self.hold, self.clock, problem.steps)


class PPO(Reinforcement):
    """Proximal policy optimisation: many environments, short rounds."""

    type: Literal["ppo"] = "ppo"
    rollout: int = Field(default=64, ge=2, description="decisions of an environment in a round")
    batch: int = Field(default=256, ge=2, description="decisions that the slope of the loss is estimated from")
    epochs: int = Field(default=10, ge=1, description="passes over a round's decisions")
    trace: float = Field(default=0.95, ge=0.0, le=1.0, description="lambda of the advantages; 1: of whole returns")
    noise: float = Field(default=0.6, gt=0.0, description="standard deviation of the actions at the start")

    def algorithm(self, env: Any, seed: int) -> Any:
        """PPO of stable-baselines3."""
        from stable_baselines3 import PPO as Algorithm  # pyright: ignore[reportMissingImports]

        return Algorithm(
            "MlpPolicy", env, seed=seed, device="cpu", verbose=0,
            n_steps=self.rollout, batch_size=_divisor(self.rollout * env.num_envs, self.batch), n_epochs=self.epochs,
            learning_rate=self.learning_rate, gamma=self.discount, gae_lambda=self.trace,
            policy_kwargs={"net_arch": self.layers, "log_std_init": float(np.log(self.noise))},
        )  # fmt: skip


class SAC(Reinforcement):
    """Soft actor-critic: learns from a memory of what was seen, so it needs less physics and more arithmetic."""

    type: Literal["sac"] = "sac"
    rollout: int = Field(default=16, ge=1, description="decisions of an environment in a round")
    batch: int = Field(default=256, ge=2, description="remembered decisions that a step is made from")
    memory: int = Field(default=100_000, ge=100, description="decisions that are remembered")
    first: int = Field(default=1000, ge=0, description="decisions made at random before the learning starts")
    updates: int = Field(default=8, ge=1, description="steps of the optimiser after each decision of the batch")

    def algorithm(self, env: Any, seed: int) -> Any:
        """SAC of stable-baselines3."""
        from stable_baselines3 import SAC as Algorithm  # pyright: ignore[reportMissingImports]

        return Algorithm(
            "MlpPolicy", env, seed=seed, device="cpu", verbose=0,
            batch_size=self.batch, buffer_size=self.memory, learning_starts=self.first, train_freq=1,
            gradient_steps=self.updates, learning_rate=self.learning_rate, gamma=self.discount,
            policy_kwargs={"net_arch": self.layers},
        )  # fmt: skip


def _divisor(number: int, most: int) -> int:
    """Return the largest divisor that is at most `most`: all pieces of a round are of one size."""
    return next(part for part in range(min(number, most), 0, -1) if number % part == 0)


class HeldPolicy:
    """A trained policy without its noise, which decides every so many control steps, in a batch of environments."""

    def __init__(self, policy: Any, hold: int, clock: int, steps: int) -> None:
        self._policy, self._hold, self._clock, self._steps = policy, hold, clock, steps
        self.reset()

    def reset(self) -> None:
        """Decide anew in the next control step."""
        self._step, self._held = 0, np.empty(0)

    def __call__(self, observations: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Actions, shape (environments, entries)."""
        if self._step % self._hold == 0:
            seen = np.asarray(observations)
            if self._clock:
                times = clock_readings(np.array([self._step]), self._steps, self._clock)
                seen = np.hstack([seen, np.broadcast_to(times, (len(seen), self._clock))])
            with one_thread():
                # One at a time: in a batch the sums of a network have other last bits.
                decided = [self._policy.predict(one, deterministic=True)[0] for one in seen]
            self._held = np.array(decided)
        self._step += 1
        return self._held


# -- weights as arrays ----------------------------------------------------------------------------------------------------


def module_arrays(module: Any) -> Arrays:
    """Return the weights of a network, by name."""
    return {name: _array(tensor) for name, tensor in module.state_dict().items()}


def arrays_of(model: Any) -> Arrays:
    """Everything that a training goes on from: weights, optimisers' moments, SAC's temperature."""
    arrays: Arrays = {}
    for part, state in model.get_parameters().items():
        if "param_groups" not in state:
            arrays |= {f"{part}|{name}": _array(tensor) for name, tensor in state.items()}
            continue
        for index, moments in state["state"].items():
            arrays |= {f"{part}|{index}|{name}": _array(value) for name, value in moments.items()}
    for name in model._get_torch_save_params()[1]:
        arrays[f"variable|{name}"] = _array(getattr(model, name))
    return arrays


def put_arrays(model: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Put into a model what `arrays_of` took out of one that was made in the same way."""
    import torch  # pyright: ignore[reportMissingImports]

    parameters = model.get_parameters()
    for part, state in parameters.items():
        mine = {name.removeprefix(f"{part}|"): array for name, array in arrays.items() if name.startswith(f"{part}|")}
        if "param_groups" not in state:
            parameters[part] = _tensors(mine)
            continue
        moments: dict[int, dict[str, Any]] = {}
        for name, array in mine.items():
            index, _, moment = name.partition("|")
            moments.setdefault(int(index), {})[moment] = torch.from_numpy(np.array(array))
        parameters[part] = {"state": moments, "param_groups": state["param_groups"]}
    model.set_parameters(parameters)
    for name in model._get_torch_save_params()[1]:
        getattr(model, name).data.copy_(torch.from_numpy(arrays[f"variable|{name}"]))


def _array(tensor: Any) -> npt.NDArray[Any]:
    return tensor.detach().cpu().numpy().copy()


def _tensors(arrays: Mapping[str, npt.NDArray[Any]]) -> dict[str, Any]:
    import torch  # pyright: ignore[reportMissingImports]

    return {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}


@contextmanager
def one_thread() -> Iterator[None]:
    """Networks this small are slower on several threads, and sum in another order."""
    import torch  # pyright: ignore[reportMissingImports]

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
