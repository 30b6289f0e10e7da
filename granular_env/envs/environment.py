"""A Gymnasium environment from any component and any task."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
import numpy.typing as npt

from ..components.component import Component
from ..components.errors import ParameterError, StepError, one_line
from ..components.support.float_arrays import FloatArray
from ..components.support.validation import finite_number, whole_number
from ..components.variables import parse_element
from ..domains import find_domain
from .actuator import Actuator
from .randomization import Randomization, rebuild_component, sampled_parameter_info
from .sensors import Sensors
from .state import COMMANDS, ELAPSED, RUNNING, SEED, Drawn, EnvState, Origin
from .task import RowTask, Task

Observation = npt.NDArray[np.float32]
Ready = tuple[Component, Task, Drawn]


class ComponentEnv(gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """Gymnasium environment of a component and a task.

    ## Action space
    `Box(-1, 1, (entries,), float32)`: one entry for each scalar input, for each element of an array input (row by row), or
    for a single element such as `force[3,0]`; elements that are not driven are 0. Each entry is clipped, limited in rate,
    delayed, multiplied by the scale of the task (`env.unwrapped.task.actions`, in the unit of the input), and held over
    `hold` control steps. NaN, infinity and wrong shapes raise `ParameterError` without a change of state.

    ## Observation space
    `Box(-limit, limit, (size,), float32)`: the outputs of the task, or those selected by `observe` (arrays row by row),
    each divided by its scale (`env.unwrapped.task.observations`), with noise, clipped to `task.observation_limit`. The goal
    follows, if the task samples one, then the clock, with readings in [-1, 1].

    ## Info
    "time" [s], the outputs of the task in SI units, float64 and without noise (not with `info="brief"`), the applied
    inputs, the counters of the task, and the sampled parameters ("drawn_radius" and so on). Arrays are new copies.

    ## Rewards, start and end
    The task defines rewards, start and end. A step that the component rejects (`StepError`: the state would leave the range
    of the physics) ends the episode: the reward is `step_error_reward`, `terminated` is true, `info["step_error"]` holds
    the message, and the state is that before the step. After `deadline` control steps the episode ends: `terminated` with a
    clock, because the agent observes the deadline, and `truncated` without a clock.

    ## Arguments
    * `component`: any `Component`.
    * `task`: any `Task` with inputs and outputs of the component, or a function that makes a task for a component, which is
      called for each sampled component. A task holds the counters of an episode, so each environment needs its own task.
    * `internal_steps` (3): internal steps of the component in a control step.
    * `deadline` (None): control steps of an episode; None for no end.
    * `hold` (1): control steps for which an action is held (frame skip); the reward of a step is the sum of theirs. Rates,
      delays and noise count control steps.
    * `clock` (0): number of time readings at the end of the observation, cos(pi k t / deadline), k = 1 to `clock`.
    * `observe` ("full"): the task's outputs; or output -> indices along its first axis, or "all":
      `{"velocity": [0, 31], "right_wall_force": "all"}`. Outputs that the task does not name use the scale of their unit.
    * `noise` (0.0): standard deviation of the noise of each reading, in units of its scale. The noise is a function of the
      episode's seed, the control step and the reading, and nearly normal (a sum of twelve uniform numbers, within 6
      deviations).
    * `action_rate` (None): largest change of an entry of the action per control step, in scales, from the input held at the
      start; None for no limit.
    * `control_delay` (0): control steps between an action and its effect; until then, the input of the start is held.
    * `randomise` (None): `{"radius": (low, high)}` samples a parameter of the component for each episode,
      `{"velocity": (low, high)}` the start value of a state variable; see `granular_env.envs.randomization`.
    * `info` ("full"): "full" or "brief".
    * `step_error_reward` (-10.0): reward of a rejected step. Episodes without a rejected step can return less.
    * `render_mode` (None): None or "rgb_array".

    `reset(options={"velocity": {0: 5.0}})` sets start values, as for `Component.reset`; `{"snapshot": state}` continues
    from a state of the component, such as `granular_env.open_log(path).branch(at).component.save()`. `copy.deepcopy`,
    pickle and cloudpickle give an independent environment that continues bitwise identically; a recording stays with the
    original.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

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
        self.render_mode, self.info = render_mode, info
        self.internal_steps = whole_number("internal_steps", internal_steps)
        self.deadline = math.inf if deadline is None else whole_number("deadline", deadline)
        self.hold = whole_number("hold", hold)
        self.step_error_reward = finite_number("step_error_reward", step_error_reward)
        self.duration = self.internal_steps * component.step_size
        self._acting = action_rate, control_delay
        self._sensing = observe, noise, clock, self.deadline
        self.drawn: Drawn = {}
        # Stored at the first save of an episode. The random generator in it needs no later update: only a start draws numbers.
        self._origin: Origin | None = None
        self._build_parts()
        self.clock = self.sensors.clock
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self.actuator.size,), np.float32)
        self.observation_space = self.sensors.space
        self.memory: FloatArray = np.zeros(COMMANDS + self.actuator.memory_size)
        self.bind_memory()
        self.randomization = Randomization(randomise, component)
        for drawn in self.randomization.extreme_parameters():
            rebuild_component(component, drawn)

    def _build_parts(self) -> None:
        """Make the actuator and the sensors, which depend on the component and its task."""
        self.task.hold, self.task.counters = self.hold, {}
        self.actuator = Actuator(self.task, self.component, *self._acting)
        self.sensors = Sensors(self.task, self.component, *self._sensing)
        self._elements = [(name, parse_element(name)) for name in self.task.observations]

    def bind_memory(self) -> None:
        """Set the views into `memory`, and wrap the component for a `RowTask`."""
        self._row, self._commands, self._bytes = self.memory[None], self.memory[COMMANDS:], self.memory.data.cast("B")
        self._rows: Any = None
        if isinstance(self.task, RowTask):
            native = find_domain(self.component.name).load_attribute("rows")
            if native is None:
                expected = "a Task, because the component's domain has no native batch for a RowTask"
                raise ParameterError(f"got {one_line(self.task)}", expected=expected, at="task")
            self._rows = native([self.component])

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the attributes made by `bind_memory`, because a copy has its own memory."""
        return {name: value for name, value in vars(self).items() if name not in ("_row", "_commands", "_bytes", "_rows")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.bind_memory()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the docstring of the class.

        Args:
            seed: seed of all random samples.
            options: start values; or "snapshot": a state from which the component continues, such as a state in a log.

        Raises:
            ParameterError: an option is invalid.
        """
        if not isinstance(options or {}, Mapping):
            raise ParameterError(f"got {one_line(options)}", expected="a mapping of start values", at="options")
        super().reset(seed=seed)
        component, task, drawn = self._rebuild_component(self.randomization.sample_parameters(self.np_random))
        start, given = self.randomization.add_start_values(task.start(self.np_random), self.np_random), dict(options or {})
        goal: dict[str, float] = {}
        if isinstance(task, RowTask):
            numbers = task.parse_goal(given.pop("goal")) if "goal" in given else task.sample_goal(self.np_random)
            goal = dict(zip(task.goal_names, numbers, strict=True))
        number = int(self.np_random.integers(2**31))
        # Check all options before changing anything, so that a refused reset has no effect.
        if "snapshot" in given:
            snapshot = given.pop("snapshot")
            if given or self.randomization.parameters:
                hint = "omit start values, and use an environment without `randomise`"
                raise ParameterError("a snapshot determines the complete start state", hint=hint, at="options.snapshot")
            component.restore(snapshot)
        else:
            component.reset(seed=number, **{**start, **given})
        self._replace_component((component, task, drawn))
        self._begin_episode(number, goal)
        return self.observe()

    def step(self, action: npt.ArrayLike) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Advance by one action: `hold` control steps, or fewer if the episode ends; see the docstring of the class.

        Raises:
            ParameterError: the action is invalid, or the episode is over.
        """
        memory, task, actuator = self.memory, self.task, self.actuator
        if not memory[RUNNING]:
            raise ParameterError("the episode is over or has not begun", hint="call reset() first", at="step")
        wished, total, over, late = validate_actions(action, (actuator.size,), "action"), 0.0, False, False
        inputs: dict[str, Any] = {}
        seen: dict[str, Any] = {}
        for _ in range(self.hold):
            commands = actuator.next_memory(wished, self._commands)
            inputs = actuator.inputs(commands)
            try:
                self.component.step(self.duration, **task.inputs(self.component, inputs))
            except StepError as error:
                memory[RUNNING] = 0.0
                observation, info = self.observe()
                return observation, total + self.step_error_reward, True, False, {**info, "step_error": str(error)}
            self._commands[:] = commands
            memory[ELAPSED] += 1.0
            seen = self._read_outputs()
            if self._rows is not None:
                reward, over = task.evaluate_rows(self._rows, task.constants, task.counters, memory[ELAPSED])  # type: ignore
            else:
                reward, over = task.evaluate_step(self.component, seen, self.duration)
            self._copy_counters()
            total, late = total + float(reward), bool(memory[ELAPSED] >= self.deadline)
            if over or late:
                memory[RUNNING] = 0.0
                break
        # With a clock the agent observes the deadline, which therefore terminates the episode.
        terminated = bool(over or (late and self.clock > 0))
        return self._observation(seen), total, terminated, late and not terminated, self._info(seen, inputs)

    def render(self) -> npt.NDArray[np.uint8] | None:  # type: ignore[override]
        """Return a picture of the state and the task's target values, shape (360, 960, 3); None if `render_mode` is None."""
        from .rendering import draw_state

        if self.render_mode is None:
            return None
        return draw_state(self.component, self.task, self.task.target_profile(int(self.memory[ELAPSED])))

    def observe(self) -> tuple[Observation, dict[str, Any]]:
        """Return the present observation and info in the form returned by `reset`, for instance after `restore`."""
        seen = self._read_outputs()
        return self._observation(seen), self._info(seen, self.actuator.inputs(self._commands))

    def save(self) -> EnvState:
        """Return everything that changes during an episode; from it, `restore` continues the episode bitwise identically."""
        if self._origin is None:
            self._origin = self.task.name, self.np_random.bit_generator.state, self.drawn
        return EnvState(self.component.save(), bytes(self._bytes), dict(self.task.counters), self._origin)

    def restore(self, state: EnvState) -> None:
        """Continue from a saved state of this or an equally built environment; `observe` returns the observation.

        Raises:
            ParameterError: the state belongs to another component or task; nothing has changed.
        """
        if state.__class__ is not EnvState or state.origin[0] != self.task.name:
            expected = f"a state saved by an environment of task {self.task.name!r}"
            raise ParameterError(f"got {one_line(state)}", expected=expected, at="state")
        if len(state.memory) != self.memory.nbytes:
            raise ParameterError("the state was saved by an environment with a different control_delay", at="state")
        _, random, drawn = state.origin
        ready = self._rebuild_component(drawn)
        ready[0].restore(state.snapshot)
        if state.origin is not self._origin:
            self._replace_component(ready)
            self.np_random.bit_generator.state, self._origin = random, state.origin
        self._bytes[:], self.task.counters = state.memory, dict(state.counters)

    def _rebuild_component(self, sampled: Drawn) -> Ready:
        """Return a component with the sampled parameters, and the task for it."""
        if sampled == self.drawn:
            return self.component, self.task, self.drawn
        if sampled.keys() != self.randomization.parameters.keys():
            theirs, ours = (", ".join(sorted(names)) or "nothing" for names in (sampled, self.randomization.parameters))
            came = f"the saved episode samples {theirs}; this environment samples {ours}"
            raise ParameterError(came, hint="create the environment with the same randomise", at="state")
        if self.component.is_observed:
            raise ParameterError(
                "each episode samples a new component, but the present one is recorded, and a log contains only one",
                hint="reset with a seed, start the recording, and reset with the same seed",
                at="randomise",
            )
        component = rebuild_component(self.component, sampled)
        return component, self._make_task(component) if self._make_task else self.task, sampled

    def _replace_component(self, ready: Ready) -> None:
        """Replace component and task by those from `_rebuild_component`; the sizes of actions and observations are the same."""
        if ready[0] is not self.component:
            self.component, self.task, self.drawn = ready
            self._build_parts()
            self.bind_memory()

    def _begin_episode(self, seed: int, goal: Mapping[str, float]) -> None:
        """Begin an episode of the task; the component is already in its start state."""
        memory = self.memory
        memory[:], self._commands[:] = 0.0, self.actuator.initial_memory(self.component)
        memory[RUNNING], memory[SEED], self._origin, self.task.counters = 1.0, seed, None, {}
        if isinstance(self.task, RowTask):
            self.task.counters = {**dict.fromkeys(self.task.counter_names, 0.0), **goal}
            self.task.begin_rows(self._rows, self.task.constants, self.task.counters)
        else:
            self.task.begin_episode(self.component, self._read_outputs())
        self._copy_counters()

    def _copy_counters(self) -> None:
        """Convert the task's counters to numbers, because a `RowTask` may have stored views of the component's memory."""
        self.task.counters = {name: float(value) for name, value in self.task.counters.items()}

    def _read_outputs(self) -> dict[str, Any]:
        """Return the present values of the task's outputs, or an empty mapping if nothing uses them."""
        if self._rows is not None and self.info == "brief":
            return {}
        return {name: element.select_from(self.component.get(element.name)) for name, element in self._elements}

    def _observation(self, outputs: Mapping[str, Any]) -> Observation:
        def read_output(name: str) -> FloatArray:
            value = outputs[name] if name in outputs else self.component.get(name)
            return np.asarray(value, dtype=np.float64)[None]

        goal = [self.task.counters[name] / scale for name, scale in self.sensors.goal.items()]
        return self.sensors.make_observations(read_output, self._row, goal)[0]

    def _info(self, outputs: Mapping[str, Any], inputs: Mapping[str, Any]) -> dict[str, Any]:
        shown = {} if self.info == "brief" else outputs
        info = {"time": self.component.time, **shown, **inputs, **self.task.counters}
        return info | sampled_parameter_info(self.drawn) if self.drawn else info


def validate_actions(actions: npt.ArrayLike, shape: tuple[int, ...], at: str) -> FloatArray:
    """Return actions as a float array; `ParameterError` unless they are finite numbers of the given shape."""
    try:
        numbers = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):  # text, or rows of unequal length
        numbers = np.zeros(0)
    if numbers.shape != shape:
        raise ParameterError(f"got {one_line(actions)}", expected=f"numbers from -1 to 1 of shape {shape}", at=at)
    if not math.isfinite(sum(numbers.ravel().tolist())):
        for place in np.argwhere(~np.isfinite(numbers)).tolist():
            raise ParameterError(f"got {numbers[tuple(place)]}", expected="a number from -1 to 1", at=(at, *place))
    return numbers
