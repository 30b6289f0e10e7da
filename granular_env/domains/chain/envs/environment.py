"""A Gymnasium environment from a chain and a `ChainTask`: acting, judging and observing are compiled."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, Self, SupportsFloat, TypedDict

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain.layout import U, V
from granular_env.components.chain.parameters import WALLS
from granular_env.components.component import Component
from granular_env.components.errors import GranularError, ParameterError, StepError, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import entry_point
from granular_env.components.support.validation import finite_number
from granular_env.envs.environment import ComponentEnv, Observation, ObservationRow, Ready, element_scales, observation_box
from granular_env.envs.rendering import draw
from granular_env.envs.state import Drawn, EnvState
from granular_env.envs.task import refuse_taken_names
from granular_env.envs.time_observation import show_clock

from .actuator import ACTUATE, Actuator, actuate
from .bounds_check import guard_copy, refuse_slips
from .domain_randomization import Randomization, info_of_draws, redrawn
from .episode_layout import COUNTERS, ELAPSED, LEFT, RIGHT, RUNNING, SEED, START
from .sensors import CONTACT, OBSERVE, Observing, show_goal
from .sensors import observe as observe_kernel
from .task import BEGIN, JUDGE, ChainTask, task_kernel

_LARGEST_COUNT = 2.0**53
# What a number of a goal is given in, by the beginning of its name.
_GOAL_UNITS = {"amplitude": "m/s", "place": "grains", "speed": "grains/s"}


class ChainOptions(TypedDict, total=False):
    """Options of every environment of a chain, beside its own arguments; see `ChainEnv`."""

    internal_steps: int
    deadline: int | None
    hold: int
    clock: int
    step_error_reward: float
    render_mode: str | None
    action_rate: float | None
    control_delay: int
    observe: Any
    noise: float
    info: str
    randomise: Mapping[str, Any] | None


class ChainEnv(ComponentEnv):
    """A chain driven by an agent, as a `ChainTask` sees it.

    ## Action space
    `Box(-1, 1, (number of inputs,), float32)`. Each entry is clipped to [-1, 1], limited in rate, delayed, multiplied by the
    task's declared scale (`env.unwrapped.task.actions`), and held over `hold` control steps. `info` has what was truly
    applied, by the input's name. NaN, infinity and wrong shapes are refused with `ParameterError`, and nothing has moved.

    ## Observation space
    `Box(-limit, limit, (size,), float32)`: the readings chosen by `observe`, each divided by its declared scale
    (`task.observations`; forces by `task.observed_force`), with noise where it is wanted, clipped to +-
    `task.observation_limit`. Where the task draws a goal for each episode, the goal follows, scaled and without noise. Last
    comes the clock, where there is one: cos(pi k t / T) for k = 1 to `clock`, T being the time of the deadline.

    ## Info
    "time" [s], the inputs applied, the task's counters, and what was drawn for the episode ("drawn_radius" and so on); with
    `info="full"` (the default) also "displacement" [m] and "velocity" [m/s] of all grains, float64, without noise, and fresh.

    ## Rewards, start and end
    The task's. A step that would break the physics gives `step_error_reward` and ends the episode, as in `ComponentEnv`.
    `reset(options={"velocity": {0: 5.0}})` starts otherwise than the task says.

    ## Arguments
    * `component`: a `Chain`.
    * `task`: a `ChainTask` whose inputs it has, or a function that makes one for a chain: where the chain is drawn for each
      episode, it is called for each chain, so that the task's constants are those of the chain.
    * `internal_steps` (3), `deadline` (None), `hold` (1), `clock` (0), `step_error_reward` (-10.0), `render_mode` (None): as
      for `ComponentEnv`. Rates, delays and noise count control steps, also where an action is held over several.
    * `action_rate` (None): largest change of an entry of the action in a control step, in scales; None for no limit.
      It begins at the input that holds at the start.
    * `control_delay` (0): control steps between an action and its effect; before, the start's input holds.
    * `observe` ("full"): displacement and velocity of every grain; or sensor -> places, in that order, e.g.
      `{"velocity": [0, 31], "contact_force": [5]}`. Sensors: "displacement", "velocity" and "force" (the mean of the forces in
      a grain's two contacts) at grains, "contact_force" in contacts (i is left of grain i), "wall_force" at "left" or "right".
    * `noise` (0.0): standard deviation of the noise on each reading, in units of its scale. It is a function of the episode's
      seed, the control step and the reading, nearly normal (a sum of twelve uniform numbers, within 6 deviations).
    * `info` ("full"): "full" or "brief".
    * `randomise` (None): see `domain_randomization`: `{"velocity": (low, high)}` draws the first grain's start velocity [m/s],
      other names draw parameters of the chain, `{"radius": (low, high)}` for instance. Everything is drawn anew at each reset
      from `np_random`, so the seed of the reset decides the chain too.
    """

    component: Chain
    task: ChainTask

    _infos: ClassVar[tuple[str, ...]] = ("full", "brief")

    def __init__(
        self,
        component: Chain,
        task: ChainTask | Callable[[Chain], ChainTask],
        *,
        internal_steps: int = 3,
        deadline: int | None = None,
        hold: int = 1,
        clock: int = 0,
        step_error_reward: float = -10.0,
        render_mode: str | None = None,
        action_rate: float | None = None,
        control_delay: int = 0,
        observe: Any = "full",
        noise: float = 0.0,
        info: str = "full",
        randomise: Mapping[str, Any] | None = None,
    ) -> None:
        if not isinstance(component, Chain):
            raise ParameterError(
                f"got {one_line(component)}", expected="a Chain", hint="ComponentEnv takes any component", at="component"
            )
        self._make_task = (lambda chain: task) if isinstance(task, ChainTask) or not callable(task) else task
        first = self._make_task(component)
        super().__init__(
            component, first, internal_steps=internal_steps, deadline=deadline, hold=hold, clock=clock,
            step_error_reward=step_error_reward, render_mode=render_mode,
        )  # fmt: skip
        if info not in self._infos:
            raise ParameterError(f"got {one_line(info)}", expected='"full" or "brief"', at="info")
        self.info, self._acting = info, (action_rate, control_delay)
        self._seeing = observe, noise
        self.control_steps = 0 if deadline is None else int(self.deadline)
        self._home: FloatArray | None = None
        self.on_new_chain: Callable[[], None] | None = None
        self._goal: npt.ArrayLike = ()
        self._fit(component, first)
        refuse_taken_names(first, first.counter_names, ["time", "displacement", "velocity", *self.actuator.names])
        self.observation_space = observation_box(
            first.observation_limit, self.observing.size + len(self.goal_scales), self.clock
        )
        self.observation_size = self.observing.size + len(self.goal_scales) + self.clock
        self._action = np.zeros(len(self.actuator.names))
        self.begin_task = _compile(component, first, "begin_kernel", BEGIN)
        self.judge = _compile(component, first, "judge_kernel", JUDGE)
        self._actuate = entry_point(actuate, ACTUATE)
        self._look = entry_point(component.specialise(observe_kernel), OBSERVE)
        self._lay_out(np.zeros(COUNTERS + len(first.counter_names) + self.actuator.memory_size))
        self.randomization = Randomization.of(randomise, component.parameters.grains)
        if self.randomization.parameters:
            # What cannot be at the ends of the ranges is refused now, not in some later episode.
            for part in (0.0, 1.0):
                self._redraw(self.randomization.at(part))
        refuse_slips(self)

    def _fit(self, chain: Chain, task: ChainTask) -> None:
        """Take from a chain and its task what steps and observations need."""
        task.hold = self.hold
        scales = _scales_by_name("actions", task.actions, chain, "input")
        self.actuator = Actuator.of(scales, *self._acting)
        readings = _scales_by_name("observations", task.observations, chain, "output")
        readings["force"] = finite_number("observed_force", task.observed_force)
        self.observing = Observing.of(chain, self._seeing[0], readings, task.observation_limit, self._seeing[1])
        self.constants = np.ascontiguousarray(task.constants, dtype=np.float64)
        self.goal_scales = np.array(task.goal_scales, dtype=np.float64)

    def _lay_out(self, memory: FloatArray) -> None:
        """Let the episode's memory lie there."""
        end = COUNTERS + len(self.task.counter_names)
        self.memory, self._memory_bytes = memory, memory.data.cast("B")
        self._applied, self._counters, self._commands = memory[LEFT:COUNTERS], memory[COUNTERS:end], memory[end:]

    def copy_into(self, table: FloatArray, memory: FloatArray) -> Self:
        """Return an environment like this one, before its first reset, whose chain and episode live in the memory given."""
        twin = object.__new__(type(self))
        vars(twin).update(vars(self))
        twin.component = self.component.clone(table)
        twin._np_random = twin._np_random_seed = twin._origin = None
        twin._action = np.zeros_like(self._action)
        twin._home, twin.drawn = table, {}
        memory[:] = 0.0
        twin._lay_out(memory)
        return twin

    def guarded_copy(self) -> Any:
        """Return a copy whose kernels run as plain Python on guarded arrays."""
        return guard_copy(self)

    # -- Gymnasium --------------------------------------------------------------------------------------------------

    def step(self, action: npt.ArrayLike) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Advance by one action: `hold` control steps, or fewer where the episode ends; see the class.

        Raises:
            ParameterError: the action is not one, the episode is over, or the reward is not finite (the chain has moved).
        """
        memory, total, over, late = self.memory, 0.0, False, False
        if not memory[RUNNING]:
            raise ParameterError("the episode is over or has not begun", hint="call reset() first", at="step")
        self._action[:] = self._validate_action(action)
        for _ in range(self.hold):
            try:
                reward, over, late = self._control_step()
            except StepError as error:
                return self._fail(error, total)
            total += reward
            if over or late:
                memory[RUNNING] = 0.0
                break
        terminated = over or (late and self.clock > 0)
        return self._observation(), total, terminated, late and not terminated, self._info(self._see())

    def _control_step(self) -> tuple[float, bool, bool]:
        """Act, advance and judge once; return the reward, whether the task has ended, whether the deadline is reached."""
        memory, actuator, before = self.memory, self.actuator, bytes(self._memory_bytes)
        self._actuate(
            self._action, actuator.sides, actuator.scales, actuator.rate, actuator.delay, self._commands, self._applied
        )
        applied = self._applied.tolist()
        try:
            self.component.step(
                self.duration, **{name: applied[side] for name, side in zip(actuator.names, actuator.sides, strict=True)}
            )
        except BaseException:
            self._memory_bytes[:] = before
            raise
        elapsed = int(memory[ELAPSED]) + 1
        memory[ELAPSED] = elapsed
        reward, over = self.judge(
            self.component.table, self._applied, self._counters, self.constants, self.duration, elapsed, self.control_steps
        )
        if not math.isfinite(reward):
            raise ParameterError(
                f"task {self.task.name!r}: its reward is {reward} after control step {elapsed}", hint="mend its judge_kernel"
            )
        return float(reward), bool(over), not over and elapsed >= self.control_steps > 0

    def render(self) -> npt.NDArray[np.uint8] | None:  # type: ignore[override]
        """Return a picture of the present state, shape (360, 960, 3), with walls and what is wanted; None without a mode."""
        if self.render_mode != "rgb_array":
            return None
        ends = self.component.parameters.left in WALLS, self.component.parameters.right in WALLS
        wanted = self.task.wanted_velocity(int(self.memory[ELAPSED]), self._counters)
        return draw(self.component, self.task, ends, wanted)

    # -- other chains -----------------------------------------------------------------------------------------------

    @property
    def draws_component(self) -> bool:
        """Return whether each episode has a chain of its own."""
        return bool(self.randomization.parameters)

    def _draw(self) -> Ready:
        return self._redraw(self.randomization.draw(self.np_random))

    def _redraw(self, drawn: Drawn) -> Ready:
        if drawn == self.drawn:
            return self.component, self.task, self.drawn
        if drawn.keys() != self.randomization.parameters.keys():
            raise ParameterError(
                f"it has {', '.join(sorted(drawn)) or 'nothing'} drawn, this environment draws "
                f"{', '.join(sorted(self.randomization.parameters)) or 'nothing'}",
                hint="make it with that randomise",
                at="state",
            )
        if self.component.is_observed:
            raise ParameterError(
                "a chain is drawn for each episode, but the present one is recorded, and its log holds one chain",
                hint="record with RecordEnv, which gives each episode a log of its own",
                at="randomise",
            )
        chain = redrawn(self.component, drawn)
        return chain, self._make_task(chain), drawn

    def _like(self, recorded: Component) -> Ready:
        if not isinstance(recorded, Chain) or not self.randomization.parameters:
            return self.component, self.task, self.drawn
        values: dict[str, Any] = recorded.parameters.model_dump()
        return self._redraw({name: values[name] for name in self.randomization.parameters if name in values})

    def _take(self, component: Component, task: Any, drawn: Drawn) -> None:
        if component is self.component:
            return
        assert isinstance(component, Chain)
        self._fit(component, task)
        self.component = component if self._home is None else component.clone(self._home)
        self.task, self.drawn = task, drawn
        if self.on_new_chain is not None:
            self.on_new_chain()

    # -- details ----------------------------------------------------------------------------------------------------

    def _start(self, task: Any, options: Mapping[str, Any]) -> dict[str, Any]:
        start, given = self.randomization.add_impacts(task.start(self.np_random), self.np_random), dict(options)
        if "goal" in given:
            self._goal = task.given_goal(given.pop("goal"))
        else:
            self._goal = task.goal(self.np_random)
        return {**start, **given}

    def _begin(self, seed: int) -> None:
        memory, chain = self.memory, self.component
        memory[:] = 0.0
        memory[RUNNING], memory[SEED], memory[START] = 1.0, seed, chain.tick
        for side, name in ((LEFT, chain.left_input), (RIGHT, chain.right_input)):
            # Where a log goes on, it may be a profile's value.
            memory[side] = chain.peek(name) if name in chain.variables else 0.0
        self.actuator.begin(self._commands, self._applied)
        self._counters[: len(self.goal_scales)] = self._goal
        self.begin_task(self.component.table, self._counters, self.constants)

    def _episode(self) -> bytes:
        return bytes(self._memory_bytes)

    def _refuse_episode(self, state: EnvState) -> None:
        if not isinstance(state.episode, bytes) or len(state.episode) != self._memory_bytes.nbytes:
            raise ParameterError("it was saved by an environment of another kind, or with another control_delay", at="state")
        numbers = np.frombuffer(state.episode)
        counts, commands = numbers[:LEFT], numbers[COUNTERS + len(self._counters) :]
        whole = np.all((counts >= 0.0) & (counts < _LARGEST_COUNT) & (counts == np.floor(counts)))
        if not (whole and np.isfinite(numbers[LEFT:COUNTERS]).all() and np.isfinite(commands).all()):
            raise ParameterError("its counts and commands are no finite numbers", hint="the data is damaged", at="state")

    def _go_on(self, episode: Any) -> None:
        self._memory_bytes[:] = episode

    def _see(self) -> dict[str, Any]:
        if self.info == "brief":
            return {}
        return {"displacement": self.component.get("displacement"), "velocity": self.component.get("velocity")}

    def _observation(self) -> Observation:
        out, plan, memory = np.empty(self.observation_size, np.float32), self.observing, self.memory
        self._look(
            self.component.table,
            plan.blocks,
            plan.factors,
            plan.limit,
            plan.noise,
            int(memory[SEED]),
            int(memory[ELAPSED]),
            out,
        )
        end = len(out) - self.clock
        if len(self.goal_scales):
            show_goal(self._counters, self.goal_scales, plan.limit, out[:end])
        if self.clock:
            show_clock(int(memory[ELAPSED]), self.control_steps, out[end:])
        return out

    def observation_rows(self) -> Iterator[ObservationRow]:
        """Yield the parts of an observation, in order."""
        place = 0
        for (kind, first, count), factor in zip(self.observing.blocks.tolist(), self.observing.factors.tolist(), strict=True):
            what, unit = {U: ("displacement", "m"), V: ("velocity", "m/s")}.get(kind, ("force", "N"))
            # The first of the table's rows is the left boundary.
            where = f"of grain {first - 1}" if count == 1 else f"of grains {first - 1} to {first + count - 2}"
            if kind == CONTACT:
                where = f"in the contact of grains {first - 1} and {first}"
            yield ObservationRow(place, place + count - 1, f"{what} {where}", f"{1.0 / factor:g} {unit}")
            place += count
        for name, scale in zip(self.task.counter_names, self.task.goal_scales, strict=False):
            yield ObservationRow(place, place, f"`{name}` of the goal", f"{scale:g} {_GOAL_UNITS[name.partition('_')[0]]}")
            place += 1
        yield from self._clock_rows(place)

    def _info(self, seen: dict[str, Any]) -> dict[str, Any]:
        applied = self._applied.tolist()
        info = {"time": self.component.time, **seen}
        for name, side in zip(self.actuator.names, self.actuator.sides, strict=True):
            info[name] = applied[side]
        info.update(zip(self.task.counter_names, self._counters.tolist(), strict=True))
        if self.drawn:
            info.update(info_of_draws(self.component, self.drawn))
        return info

    def _fail(self, error: StepError, total: float) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.memory[RUNNING] = 0.0
        info = self._info(self._see())
        info["step_error"] = str(error)
        return self._observation(), total + self.step_error_reward, True, False, info


def _compile(chain: Chain, task: ChainTask, kernel: str, signature: str) -> Callable[..., Any]:
    try:
        return entry_point(chain.specialise(task_kernel(task, kernel)), signature)
    except GranularError:
        raise
    except Exception as error:  # numba hands on what it meets in the function
        raise ParameterError(f"does not compile as {signature}:\n{error}", at=kernel, source=f"task {task.name!r}") from None


def _scales_by_name(what: str, scales: Mapping[str, float], chain: Chain, causality: str) -> dict[str, float]:
    """Return scales by the variable's name; single grains are chosen by the sensors of the environment, not by the task."""
    found = element_scales(what, scales, chain, causality)
    for element, _ in found:
        if element.index:
            raise ParameterError(
                f"got {element}", expected=str(element.name), hint="observe=... says which grains are seen", at=what
            )
    return {element.name: scale for element, scale in found}
