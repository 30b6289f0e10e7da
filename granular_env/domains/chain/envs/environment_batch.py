"""Single environments in common memory, so that compiled code can advance them all; what is rare they do themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.chain.integrators import SIGNATURE as ADVANCE
from granular_env.components.chain.layout import U, V
from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.addresses import address
from granular_env.components.support.jit import JIT
from granular_env.envs.state import EnvState

from .domain_randomization import info_of_draws
from .environment import ChainEnv
from .episode_layout import COUNTERS, ELAPSED, LEFT, START
from .sensors import OBSERVE, observe
from .task import JUDGE, task_kernel
from .vector_kernel import observe_environments, step_environments

_NO_DRIVE = np.zeros((0, 2))


class EnvironmentBatch:
    """`count` environments whose chains are one array, and whose memories are another.

    Attributes:
        single: the environments.
        tables: their chains' tables, shape (count, rows, width).
        memories: their episodes' memories, shape (count, numbers).
        size: length of an observation.
    """

    def __init__(
        self,
        environment: Callable[..., ChainEnv],
        count: int,
        parameters: Sequence[Mapping[str, Any]] | None,
        arguments: Mapping[str, Any],
    ) -> None:
        made = _make_environments(environment, count, parameters, arguments)
        first = made[0]
        if not isinstance(first, ChainEnv):
            raise ParameterError(f"got {one_line(first)}", expected="what makes a ChainEnv", at="environment")
        for index, one in enumerate(made):
            _refuse_unlike(first, one, index)
        self.tables = np.zeros((count, *first.component.table.shape))
        self.memories = np.zeros((count, len(first.memory)))
        self.single = []
        for k in range(count):
            single = made[k % len(made)].copy_into(self.tables[k], self.memories[k])
            single.on_new_chain = partial(self._redrawn, k)
            self.single.append(single)
        self.size = first.observation_size
        self._lent: set[int] = set()
        # Environments whose chain has been drawn anew since it was last looked at.
        self._new: set[int] = set()
        self._drawn: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._stack(first)

    def _redrawn(self, k: int) -> None:
        self._new.add(k)

    def _stack(self, first: ChainEnv) -> None:
        singles, actuator = self.single, first.actuator
        # One address for each chain: laws and schemes may differ.
        judge = task_kernel(first.task, "judge_kernel")
        advances = _addresses([single.component.scheme_kernel for single in singles], ADVANCE)
        judges = _addresses([single.component.specialise(judge) for single in singles], JUDGE)
        observes = _addresses([single.component.specialise(observe) for single in singles], OBSERVE)
        constants = np.concatenate([single.constants for single in singles])
        places = np.cumsum([0, *(len(single.constants) for single in singles)], dtype=np.int64)
        stacked = lambda values: np.array(list(values), dtype=np.float64)  # noqa: E731
        self._counters = len(first.task.counter_names)
        self._names, self._sides = actuator.names, actuator.sides
        self._steps_each = np.array([single.internal_steps for single in singles], dtype=np.int64)
        self._step_sizes = stacked(single.component.step_size for single in singles)
        self._deadlines = np.array([single.control_steps for single in singles], dtype=np.int64)
        state = [single.component.state_rows for single in singles]
        first_row, last_row = min(rows.start for rows in state), max(rows.stop for rows in state)
        self._judging = (
            advances, judges, constants, places, self._counters,
            self._steps_each, self._deadlines, stacked(single.duration for single in singles),
            actuator.sides, stacked(single.actuator.scales for single in singles),
            stacked(single.actuator.rate for single in singles),
            actuator.delay, first.hold,
        )  # fmt: skip
        self._seeing = (
            observes, first.observing.blocks, stacked(single.observing.factors for single in singles),
            stacked(single.observing.limit for single in singles), stacked(single.observing.noise for single in singles),
            stacked(single.goal_scales for single in singles), first.clock,
        )  # fmt: skip
        kept = np.zeros((last_row - first_row, first.component.table.shape[1]))
        self._room = (_NO_DRIVE, kept, np.zeros(self.memories.shape[1]), first_row)

    def _look_again(self) -> None:
        """Take what changed with the chains that were drawn anew."""
        if not self._new:
            return
        _, _, constants, places, *_ = self._judging
        scales, (_, _, factors, _, _, goals, _) = self._judging[9], self._seeing
        singles = {k: self.single[k] for k in self._new}
        self._new.clear()
        for k, single in singles.items():
            self._note_drawn(k, single)
        if any(len(single.constants) != places[k + 1] - places[k] for k, single in singles.items()):
            self._stack(self.single[0])
            return
        for k, single in singles.items():
            constants[places[k] : places[k + 1]] = single.constants
            scales[k], factors[k], goals[k] = single.actuator.scales, single.observing.factors, single.goal_scales

    def _note_drawn(self, k: int, single: ChainEnv) -> None:
        count = len(self.single)
        for name, value in info_of_draws(single.component, single.drawn).items():
            if name not in self._drawn:
                self._drawn[name] = np.zeros((count, *np.shape(value))), np.zeros(count, np.bool_)
            self._drawn[name][0][k], self._drawn[name][1][k] = value, True

    def step(self, actions: np.ndarray, going: np.ndarray, *results: np.ndarray) -> int:
        """One action of those that are going; see `step_environments` for the results."""
        self._look_again()
        watched = [k for k in self._lent if going[k] and _goes_alone(self.single[k])]
        if watched:
            # Those that somebody records, or whose other end follows a profile, step by themselves.
            going = going.copy()
            going[watched] = False
        special = step_environments(
            self.tables, self.memories, actions, going, *self._judging, *self._seeing, *self._room, *results
        )
        if watched:
            refused = results[-1]
            refused[watched] = True
        for k in self._lent:
            self.synchronise(k)
        return special + len(watched)

    def synchronise(self, k: int) -> ChainEnv:
        """Environment k, its chain's time and inputs as the batch has left them."""
        single, memory = self.single[k], self.memories[k]
        chain = single.component
        if _goes_alone(single):
            return single
        tick = int(memory[START] + memory[ELAPSED] * single.internal_steps)
        applied = memory[LEFT:COUNTERS].tolist()
        chain.adopt(tick, {name: applied[side] for name, side in zip(self._names, self._sides, strict=True)})
        return single

    def lent(self, k: int) -> ChainEnv:
        """Environment k for somebody who may observe its component."""
        self._lent.add(k)
        return self.synchronise(k)

    def restore(self, numbers: Sequence[int], states: Sequence[EnvState]) -> None:
        """Let the environments with these numbers go on from saved states, all of them or none."""
        ready = [self.single[k].refuse_foreign(state) for k, state in zip(numbers, states, strict=True)]
        for k, state, one in zip(numbers, states, ready, strict=True):
            single = self.single[k]
            single.take_state(state, one)
            if _goes_alone(single):
                self._lent.add(k)

    def observe(self) -> npt.NDArray[np.float32]:
        """Return the observations of all environments."""
        self._look_again()
        observations = np.empty((len(self.single), self.size), np.float32)
        observe_environments(self.tables, self.memories, self._deadlines, *self._seeing, observations)
        return observations

    def infos(self, info: str) -> dict[str, np.ndarray]:
        """Return the infos of all environments, by the names of the single environment's info; fresh arrays."""
        memories = self.memories
        ticks = (memories[:, START] + memories[:, ELAPSED] * self._steps_each).astype(np.int64)
        values: dict[str, np.ndarray] = {"time": ticks * self._step_sizes}
        if info == "full":
            grains = slice(1, self.single[0].component.parameters.grains + 1)
            values["displacement"], values["velocity"] = self.tables[:, U, grains].copy(), self.tables[:, V, grains].copy()
        for name, side in zip(self._names, self._sides, strict=True):
            values[name] = memories[:, LEFT + side].copy()
        for place, name in enumerate(self.single[0].task.counter_names):
            values[name] = memories[:, COUNTERS + place].copy()
        return values

    def draws(self) -> Mapping[str, tuple[np.ndarray, np.ndarray]]:
        """Return what was drawn for the present episodes, named as in infos: values, and which environments have one."""
        self._look_again()
        return self._drawn

    def count(self, hold: int) -> npt.NDArray[np.int64]:
        """Return the number of actions of each environment's episode."""
        return -(-self.memories[:, ELAPSED].astype(np.int64) // hold)


def _addresses(kernels: Sequence[Callable[..., Any]], signature: str) -> npt.NDArray[Any]:
    """Return where compiled code finds each of these kernels, of which most are the same."""
    found = {kernel: address(kernel, signature) for kernel in set(kernels)}
    return np.array([found[kernel] for kernel in kernels], dtype=np.int64 if JIT else object)


def _goes_alone(single: ChainEnv) -> bool:
    """Return whether its chain does what the batch knows nothing of."""
    return single.component.is_observed or single.component.follows_profile


def _make_environments(
    environment: Callable[..., ChainEnv],
    count: int,
    parameters: Sequence[Mapping[str, Any]] | None,
    arguments: Mapping[str, Any],
) -> list[ChainEnv]:
    """Make the environments that differ: one where all are alike."""
    if parameters is None:
        return [environment(**arguments)]
    if isinstance(parameters, (str, Mapping)) or not isinstance(parameters, Sequence) or len(parameters) != count:
        raise ParameterError(
            f"got {one_line(parameters)}", expected=f"a list of {count} mappings, one for each", at="parameters"
        )
    made = []
    for k, own in enumerate(parameters):
        if not isinstance(own, Mapping) or "info" in own:
            raise ParameterError(
                f"got {one_line(own)}", expected="arguments of one environment, name -> value", at=f"parameters[{k}]"
            )
        merged = {**arguments, **own}
        if isinstance(own.get("chain"), Mapping):
            merged["chain"] = {**(arguments.get("chain") or {}), **own["chain"]}
        try:
            made.append(environment(**merged))
        except ParameterError as error:
            raise error.within("parameters", k) from None
        except TypeError as error:  # it names an argument that there is not
            raise ParameterError(str(error), at=("parameters", k)) from error
    return made


def _refuse_unlike(first: ChainEnv, other: ChainEnv, index: int) -> None:
    """Environments in one batch must have the same spaces and memories."""
    for what, one, another in (
        ("observation space", first.observation_space, other.observation_space),
        ("action", (type(first.task), first.actuator.names), (type(other.task), other.actuator.names)),
        ("observe", first.observing.blocks.tolist(), other.observing.blocks.tolist()),
        ("counters", first.task.counter_names, other.task.counter_names),
        ("control_delay", first.actuator.delay, other.actuator.delay),
        ("hold", first.hold, other.hold),
        ("clock", first.clock, other.clock),
        ("chain (grains, integrator)", first.component.table.shape, other.component.table.shape),
    ):
        if one != another:
            raise ParameterError(
                f"{what} is not that of environment 0, and has to be the same in a batch", at=f"parameters[{index}]"
            )
