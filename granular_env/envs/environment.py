"""A Gymnasium environment from any component and any task."""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Self, SupportsFloat

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.envs.registration import EnvSpec

from ..components.component import Component
from ..components.errors import ParameterError, StepError, one_line
from ..components.snapshot import Snapshot
from ..components.support.float_arrays import FloatArray
from ..components.support.validation import finite_number, whole_number
from ..components.variables import parse_element
from ..domains import domain_of
from .actuator import Actuator
from .randomization import Randomization, info_of_draws, redrawn
from .rendering import draw
from .sensors import ObservationRow, Sensors
from .state import Drawn, EnvState, EpisodeOrigin, bit_generator
from .task import RowTask, Task, judgement, refuse_incomplete, refuse_infinite, stack_constants

Observation = npt.NDArray[np.float32]
Ready = tuple[Component, Task, Drawn]

# The memory of an episode: control steps done, whether it is running, the seed of its noise; then the actuator's commands, then
# the counters of a `RowTask`.
ELAPSED, RUNNING, SEED, COMMANDS = range(4)
_LARGEST_COUNT = 2.0**53


class ComponentEnv(gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """A component driven by an agent, as a task sees it.

    ## Action space
    `Box(-1, 1, (entries,), float32)`: an entry for each input that is a number, one for each element of an array, row by row,
    and one for an element such as `force[3,0]`; elements that are not driven are 0. Each entry is clipped, limited in rate,
    delayed, multiplied by the task's scale (`env.unwrapped.task.actions`, in the input's unit), and held over `hold` control
    steps. NaN, infinity and wrong shapes are refused with `ParameterError`, and nothing has moved.

    ## Observation space
    `Box(-limit, limit, (size,), float32)`: the outputs of the task, or those that `observe` chooses, one after the other,
    arrays row by row, each divided by its scale (`env.unwrapped.task.observations`), with noise, clipped to +-
    `task.observation_limit`; then the goal, where the task draws one; then the clock, whose readings lie in [-1, 1].

    ## Info
    "time" [s], the task's outputs, unscaled in float64 and without noise (not with `info="brief"`), the inputs that the action
    drives as they were applied, the task's counters, and the parameters that were drawn ("drawn_radius" and so on). Arrays are
    fresh.

    ## Rewards, start and end
    The task's. A step that the component refuses (`StepError`: the physics would break down) ends the episode: the reward is
    `step_error_reward`, `terminated` is true, `info["step_error"]` holds the message, the state is that from before the step.
    After `deadline` control steps the episode ends: with a clock it is `terminated`, because the agent has seen the end come,
    without one it is `truncated`.

    ## Arguments
    * `component`: any `Component`.
    * `task`: any `Task` whose inputs and outputs the component has, or a function that makes one for a component: it is called
      for each component that is drawn. A task holds the counters of an episode: give each environment one of its own.
    * `internal_steps` (3): internal steps of the component in a control step.
    * `deadline` (None): control steps of an episode; None for no end.
    * `hold` (1): control steps for which an action is held (frame skip); the reward of a step is the sum of theirs. Rates,
      delays and noise count control steps.
    * `clock` (0): numbers at the end of the observation that show the time, cos(pi k t / deadline), k = 1 to `clock`.
    * `observe` ("full"): the task's outputs; or output -> places along its first axis, or "all":
      `{"velocity": [0, 31], "right_wall_force": "all"}`. Outputs that the task does not name take the scale of their unit.
    * `noise` (0.0): standard deviation of the noise on each reading, in units of its scale. It is a function of the episode's
      seed, the control step and the reading, nearly normal (a sum of twelve uniform numbers, within 6 deviations).
    * `action_rate` (None): largest change of an entry of the action in a control step, in scales; None for no limit.
      It begins at the input that holds at the start.
    * `control_delay` (0): control steps between an action and its effect; before, the start's input holds.
    * `randomise` (None): `{"radius": (low, high)}` draws a parameter of the component for each episode, and
      `{"velocity": (low, high)}` the start value of a state variable; see `granular_env.envs.randomization`.
    * `info` ("full"): "full" or "brief".
    * `step_error_reward` (-10.0): reward of a step that the component refuses. An episode that it does not refuse can return
      less.
    * `render_mode` (None): None or "rgb_array".

    `reset(options={"velocity": {0: 5.0}})` gives start values, as `Component.reset` takes them. `copy.deepcopy`, pickle and
    cloudpickle give an independent environment that continues with the same bits; a recording stays with the original.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012
    _spec: EnvSpec | None = None

    def __init__(
        self,
        component: Component,
        task: Task | Callable[[Any], Task],
        *,
        internal_steps: int = 3,
        deadline: int | None = None,
        hold: int = 1,
        clock: int = 0,
        observe: Any = "full",
        noise: float = 0.0,
        action_rate: float | None = None,
        control_delay: int = 0,
        randomise: Mapping[str, Any] | None = None,
        info: str = "full",
        step_error_reward: float = -10.0,
        render_mode: str | None = None,
    ) -> None:
        for name, value, known in (("render_mode", render_mode, (None, "rgb_array")), ("info", info, ("full", "brief"))):
            if value not in known:
                raise ParameterError(f"got {one_line(value)}", expected=" or ".join(map(repr, known)), at=name)
        self._make_task = task if callable(task) else None
        self.component, self.task = component, task(component) if callable(task) else task
        refuse_incomplete(self.task)
        self.render_mode, self.info = render_mode, info
        self.internal_steps = whole_number("internal_steps", internal_steps)
        self.deadline = math.inf if deadline is None else whole_number("deadline", deadline)
        self.hold = whole_number("hold", hold)
        if self.hold > self.deadline:
            expected = f"at most the deadline of {self.deadline} control steps"
            raise ParameterError(f"got {self.hold}", expected=expected, at="hold")
        self.step_error_reward = finite_number("step_error_reward", step_error_reward)
        self.duration = self.internal_steps * component.step_size
        self._acting = {"action_rate": action_rate, "control_delay": control_delay}
        self._sensing = {"observe": observe, "noise": noise, "clock": clock, "deadline": self.deadline}
        self.home: Callable[[Component], Component] | None = None
        self.drawn: Drawn = {}
        # As it is at the first save of an episode: only a start draws random numbers.
        self._origin: EpisodeOrigin | None = None
        self._fit()
        self.clock = self.sensors.clock
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self.actuator.entries),), np.float32)
        self.observation_space = self.sensors.space
        self.memory: FloatArray = np.zeros(COMMANDS + self.actuator.memory_size + len(self._counter_names))
        self.task.counters = {}
        self.bind()
        self.randomization = Randomization(randomise, component)
        for drawn in self.randomization.ends():  # values that cannot be are refused now, not in some later episode
            self._redraw(drawn)

    def _fit(self) -> None:
        """Take the parts that depend on the component and its task."""
        self.task.hold = self.hold
        self.actuator = Actuator(self.task, self.component, **self._acting)
        self.sensors = Sensors(self.task, self.component, **self._sensing)
        self._elements = [(name, parse_element(name)) for name in self.task.observations]
        self._counter_names = self.task.counter_names if isinstance(self.task, RowTask) else ()

    def bind(self) -> None:
        """Show the memory's parts to the task, and the component to a task that judges rows."""
        end = COMMANDS + self.actuator.memory_size
        self._commands, self._counters, self._bytes = self.memory[COMMANDS:end], self.memory[end:], self.memory.data.cast("B")
        self._rows: Any = None
        if isinstance(self.task, RowTask):
            native = domain_of(self.component.name).load("rows")
            if native is None:
                expected = "a Task: the component's domain has no native batch"
                raise ParameterError(f"got {one_line(self.task)}", expected=expected, at="task")
            self._rows, self._constants = native([self.component]), stack_constants([self.task.constants])
            self.task.counters = {name: self._counters[k : k + 1] for k, name in enumerate(self._counter_names)}

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what `bind` makes; a copy lives in memory of its own."""
        made = ("_commands", "_counters", "_bytes", "_rows", "_constants", "home")
        return {name: value for name, value in vars(self).items() if name not in made}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, home=None)
        self.bind()

    def twin(self) -> Self:
        """Return an environment like this one, before its first reset, for a batch."""
        made = object.__new__(type(self))
        vars(made).update(self.__getstate__(), component=self.component.clone(), task=copy.copy(self.task), drawn={})
        made.memory, made._origin, made._np_random, made._np_random_seed = np.zeros_like(self.memory), None, None, None
        made.task.counters = {}
        made.__setstate__({})
        return made

    # -- Gymnasium --------------------------------------------------------------------------------------------------

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override]
        """Return the spec that Gymnasium made this environment from; `max_episode_steps` is one action more than the deadline.

        So wrappers know how long an episode is at most, and no time limit comes before the environment's own end.
        """
        return self._spec

    @spec.setter
    def spec(self, given: EnvSpec | None) -> None:  # pyright: ignore[reportIncompatibleVariableOverride]
        if given is not None and given.max_episode_steps is None and self.deadline < math.inf:
            given = replace(given, max_episode_steps=-(-int(self.deadline) // self.hold) + 1)
        self._spec = given

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class.

        Raises:
            ParameterError: a start value in `options` is not valid, or the seed is none.
        """
        super().reset(seed=validate_seed(seed))
        ready = self._redraw(self.randomization.draw(self.np_random))
        start, goal = self._start(ready[1], validate_options(options))
        number = int(self.np_random.integers(2**31))
        if ready[0] is not self.component:
            # Start values that are not valid are refused before anything is replaced.
            ready[0].reset(seed=number, **start)
            self._take(*ready)
        self.component.reset(seed=number, **start)
        self._begin(number, goal)
        return self.observe()

    def step(self, action: npt.ArrayLike) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Advance by one action: `hold` control steps, or fewer where the episode ends; see the class.

        Raises:
            ParameterError: the action is not one, the episode is over, or the task's judgement is no (finite reward, done), and
                the component has moved then.
        """
        memory, total, over, late = self.memory, 0.0, False, False
        if not memory[RUNNING]:
            raise ParameterError("the episode is over or has not begun", hint="call reset() first", at="step")
        command, seen = self._validate_action(action), None
        for _ in range(self.hold):
            try:
                self._advance(command)
            except StepError as error:
                memory[RUNNING] = 0.0
                observation, info = self.observe()
                return observation, total + self.step_error_reward, True, False, {**info, "step_error": str(error)}
            memory[ELAPSED] += 1.0
            seen = self._see()
            reward, over = self._judge(seen)
            total, late = total + reward, not over and bool(memory[ELAPSED] >= self.deadline)
            if over or late:
                memory[RUNNING] = 0.0
                break
        terminated = over or (late and self.clock > 0)
        return self._observation(), total, terminated, late and not terminated, self._info(seen)

    def _advance(self, command: FloatArray) -> None:
        """Act on the component for one control step; a refused one leaves the actuator as it was."""
        before = self._commands.copy()
        self.actuator.act(command, self._commands)
        driven = self.actuator.inputs(self.actuator.applied(self._commands))
        try:
            self.component.step(self.duration, **self.task.inputs(self.component, driven))
        except BaseException:
            self._commands[:] = before
            raise

    def _judge(self, seen: Mapping[str, Any] | None) -> tuple[float, bool]:
        if not isinstance(self.task, RowTask):
            return judgement(self.task, self.component, seen or {}, self.duration)
        elapsed = self.memory[ELAPSED : ELAPSED + 1].astype(np.int64)
        rewards, done = self.task.judge_rows(self._rows, self._constants, self.task.counters, elapsed)
        reward = float(rewards[0])
        refuse_infinite(self.task, reward)
        return reward, bool(done if done is False else done[0])

    def render(self) -> npt.NDArray[np.uint8] | None:  # type: ignore[override]
        """Return the present state as a picture, shape (360, 960, 3); None without a render mode."""
        if self.render_mode != "rgb_array":
            return None
        return draw(self.component, self.task, self.task.wanted(int(self.memory[ELAPSED])))

    # -- mid-episode ------------------------------------------------------------------------------------------------

    def observe(self) -> tuple[Observation, dict[str, Any]]:
        """Return the present observation and info, as `reset` gives them; after `restore`, for instance."""
        return self._observation(), self._info(self._see())

    def save(self) -> EnvState:
        """Return everything that changes in an episode; restoring it gives the same bits from there on."""
        if self._origin is None:
            self._origin = EpisodeOrigin(self.task.name, self.np_random.bit_generator.state, self.drawn)
        counters = {} if self._rows is not None else _numbers(self.task)
        return EnvState(self.component.save(), bytes(self._bytes), counters, self._origin)

    def restore(self, state: EnvState) -> None:
        """Continue from a saved state, of this environment or of one made in the same way; `observe` returns what is seen.

        Raises:
            ParameterError: the state belongs to another component or task; nothing has changed.
        """
        if state.__class__ is not EnvState or state.origin is not self._origin:
            self.take_state(state, self.refuse_foreign(state))
            return
        # One of the present episode, as a tree search restores them: nothing else is to be compared.
        self.component.restore(state.snapshot)
        self._recall(state)

    def refuse_foreign(self, state: EnvState) -> Ready:
        """Raise what `restore` would raise for this state, and change nothing; return what `take_state` needs."""
        if state.__class__ is not EnvState or state.origin.task != self.task.name:
            expected = f"what save() of an environment of {self.task.name!r} gave"
            raise ParameterError(f"got {one_line(state)}", expected=expected, at="state")
        if len(state.memory) != self.memory.nbytes:
            raise ParameterError("it was saved by an environment with another control_delay", at="state")
        memory = np.frombuffer(state.memory)
        counts, commands = memory[:COMMANDS], memory[COMMANDS : COMMANDS + self.actuator.memory_size]
        if not (
            np.isfinite(commands).all() and np.all((counts >= 0.0) & (counts < _LARGEST_COUNT) & (counts == np.floor(counts)))
        ):
            raise ParameterError("its counts and commands are no finite numbers", hint="the data is damaged", at="state")
        try:
            bit_generator(state.origin.random)
        except ValueError as error:
            raise ParameterError(f"its random numbers are none: {error}", at="state") from error
        ready = self._redraw(state.origin.drawn)
        ready[0].refuse_foreign(state.snapshot)
        return ready

    def take_state(self, state: EnvState, ready: Ready) -> None:
        """Continue from a state that `refuse_foreign` has looked at."""
        self._take(*ready)
        self.component.restore(state.snapshot)
        self._recall(state)
        if state.origin is not self._origin:
            self._np_random, self._origin = np.random.Generator(bit_generator(state.origin.random)), state.origin

    def _recall(self, state: EnvState) -> None:
        self._bytes[:] = state.memory
        if self._rows is None:
            self.task.counters = dict(state.counters)

    def branch(
        self, log: str | os.PathLike[str], at: float, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode at an instant of a recorded log: the component continues from there, the task begins its episode.

        Args:
            log: path of a log whose component has this one's parameters.
            at: time of the log [s]; a time between two internal steps is moved to the nearest.
            seed: as for `reset`.
            options: as for `reset`, but for start values.

        Raises:
            ParameterError: the log's component has other parameters, or the time is outside of the log; nothing has changed.
            LogError: it is no log, or cannot be re-run.
        """
        ready, snapshot = self._snapshot_at(log, at)
        given = validate_options(options)
        start = set(given) & {variable.name for variable in self.component.variables.values() if variable.state}
        if start:
            raise ParameterError(f"got start values of {', '.join(sorted(start))}, but the log gives the start", at="options")
        super().reset(seed=validate_seed(seed))
        _, goal = self._start(ready[1], given)
        number = int(self.np_random.integers(2**31))
        self._take(*ready)
        self.component.restore(snapshot)
        self._begin(number, goal)
        return self.observe()

    def _snapshot_at(self, log: str | os.PathLike[str], at: float) -> tuple[Ready, Snapshot]:
        """Return the state at a time of a log, and the component that can continue from it."""
        from contextlib import closing

        from ..recording import open_log

        with closing(open_log(log, components={self.component.name: type(self.component)})) as opened:
            recorded = opened.rebuilt()
            ready = self.component, self.task, self.drawn
            if recorded.name == self.component.name and self.randomization.parameters:
                values: dict[str, Any] = recorded.parameters.model_dump()
                ready = self._redraw({name: values[name] for name in self.randomization.parameters if name in values})
            if recorded.identity != ready[0].identity:
                difference = _difference(ready[0], recorded)
                raise ParameterError(difference, hint="make the environment so", source=f"log {str(opened.path)!r}")
            return ready, opened.branch(at).component.save()

    # -- episodes ---------------------------------------------------------------------------------------------------

    @property
    def draws_component(self) -> bool:
        """Return whether parameters of the component are drawn for each episode."""
        return bool(self.randomization.parameters)

    def _redraw(self, drawn: Drawn) -> Ready:
        """Return the component and the task for parameters that were drawn."""
        if drawn == self.drawn:
            return self.component, self.task, self.drawn
        if drawn.keys() != self.randomization.parameters.keys():
            theirs, ours = (", ".join(sorted(names)) or "nothing" for names in (drawn, self.randomization.parameters))
            came = f"it has {theirs} drawn, this environment draws {ours}"
            raise ParameterError(came, hint="make it with that randomise", at="state")
        if self.component.is_observed:
            raise ParameterError(
                "a component is drawn for each episode, but the present one is recorded, and its log holds one component",
                hint="record with RecordEnv, which gives each episode a log of its own",
                at="randomise",
            )
        component = redrawn(self.component, drawn)
        return component, self._make_task(component) if self._make_task else self.task, drawn

    def _take(self, component: Component, task: Task, drawn: Drawn) -> None:
        """Continue with another component of the same shape, and its task."""
        if component is self.component:
            return
        self.component = component if self.home is None else self.home(component)
        self.task, self.drawn = task, drawn
        self._fit()
        self.bind()

    def _start(self, task: Task, options: dict[str, Any]) -> tuple[dict[str, Any], FloatArray | None]:
        """Return the start values of an episode, and its goal; both may draw random numbers."""
        start, goal = self.randomization.add_starts(task.start(self.np_random), self.np_random), None
        if isinstance(task, RowTask):
            goal = task.given_goal(options.pop("goal")) if "goal" in options else task.goal(self.np_random)
        return {**start, **options}, goal

    def _begin(self, seed: int, goal: FloatArray | None) -> None:
        """Begin an episode; the component has its start state."""
        self.memory[:] = 0.0
        self.memory[RUNNING], self.memory[SEED], self._origin = 1.0, seed, None
        self.actuator.begin(self.component, self._commands)
        if isinstance(self.task, RowTask) and goal is not None:
            self._counters[: len(goal)] = goal
            self.task.begin_rows(self._rows, self._constants, self.task.counters)
        else:
            self.task.counters = {}
            self.task.begin(self.component, self._see() or {})

    # -- details ----------------------------------------------------------------------------------------------------

    def _validate_action(self, action: npt.ArrayLike) -> FloatArray:
        """Return the action's numbers, finite."""
        count = len(self.actuator.entries)
        try:
            given = np.asarray(action)
        except ValueError as error:  # rows of unlike length
            raise ParameterError(f"got {one_line(action)}", expected=f"{count} numbers", at="action") from error
        if given.shape != (count,):
            raise ParameterError(f"got shape {given.shape}", expected=f"shape {(count,)}: {one_line(action)}", at="action")
        if given.dtype.kind not in "fiu":
            raise ParameterError(f"got {one_line(action)}", expected=f"{count} numbers from -1 to 1", at="action")
        numbers = given.astype(np.float64)
        for entry, number in zip(self.actuator.entries, numbers.tolist(), strict=True):
            if not math.isfinite(number):
                raise ParameterError(f"got {number} for {entry}", expected="a number from -1 to 1", at="action")
        return numbers

    def _see(self) -> dict[str, Any] | None:
        """Return the task's outputs, fresh; None where nothing needs them."""
        if self._rows is not None and self.info == "brief":
            return None
        return {name: one.of(self.component.get(one.name)) for name, one in self._elements}

    def _observation(self) -> Observation:
        numbers, scales = self.memory[: SEED + 1].astype(np.int64), self.sensors.goal_scales
        goals = self._counters[None, : len(scales)]
        return self.sensors.observe(self._read, numbers[SEED:], numbers[:1], goals, scales[None])[0]

    def _read(self, name: str) -> FloatArray:
        """Return an output with a leading axis."""
        if self._rows is not None:
            return self._rows.read(name)
        return np.asarray(self.component.get(name), dtype=np.float64)[None]

    def observation_rows(self) -> Iterator[ObservationRow]:
        """Yield the parts of an observation in words, in order."""
        yield from self.sensors.rows(self.component)

    def _info(self, seen: Mapping[str, Any] | None) -> dict[str, Any]:
        shown = {} if seen is None or self.info == "brief" else seen
        parts = ({"time": self.component.time}, shown, self.actuator.applied(self._commands), _numbers(self.task))
        info = {name: value for part in parts for name, value in part.items()} | info_of_draws(self.drawn)
        if len(info) < sum(map(len, parts)) + len(self.drawn) or "step_error" in info:
            hint = "give the counter a name that info does not have"
            raise ParameterError(
                f"got {', '.join(self.task.counters)}", hint=hint, at="counters", source=f"task {self.task.name!r}"
            )
        return info


def _numbers(task: Task) -> dict[str, float]:
    """Return a task's counters as numbers; `ParameterError` where one of them is none."""
    try:
        return {name: value.item() if isinstance(value, np.ndarray) else float(value) for name, value in task.counters.items()}
    except (TypeError, ValueError, AttributeError):
        hint = "give each number of an array a name of its own"
        came, source = f"got {one_line(task.counters)}", f"task {task.name!r}"
        raise ParameterError(came, expected="name -> number", hint=hint, at="counters", source=source) from None


def _difference(component: Component, recorded: Component) -> str:
    if recorded.name != component.name:
        return f"it was recorded from {recorded.name!r}, this environment has {component.name!r}"
    theirs, ours = (one.parameters.model_dump(mode="json") for one in (recorded, component))  # type: ignore[attr-defined]
    differ = [name for name in theirs if theirs[name] != ours.get(name)]
    words = (f"{name} is {one_line(theirs[name], 40)} there and {one_line(ours.get(name), 40)} here" for name in differ[:5])
    return "; ".join(words) or f"it was recorded from another version of {component.name!r}"


def validate_options(options: Any) -> dict[str, Any]:
    """Return options of a reset as a mapping; `ParameterError` where they are none."""
    if not isinstance(options, Mapping | None) or "seed" in (options or {}):
        expected = "start values of state variables, name -> value"
        raise ParameterError(f"got {one_line(options)}", expected=expected, at="options")
    return dict(options or {})


def validate_seed(seed: Any) -> int | None:
    """Return a seed as Gymnasium takes it; `ParameterError` where it is neither None nor a whole number from 0."""
    if seed is not None and (isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0):
        raise ParameterError(f"got {one_line(seed)}", expected="a whole number from 0, or None", at="seed")
    return None if seed is None else int(seed)
